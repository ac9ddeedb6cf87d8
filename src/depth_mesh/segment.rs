//! Which triangles of the full resolution are cut: rubber sheets (section 5.2) and triangles that touch background.
//!
//! Triangles of a quadtree node are numbered clockwise from the one between its north-west corner and its northern
//! midpoint: a1, a2, b1, b2, c1, c2, d1, d2 of figure 11.

use super::{
    grid::{RING, step},
    map::DepthMap,
    normals,
    options::{DepthRange, Options, Segmentation},
    rays::Rays,
};
use glam::Vec3;

pub(super) struct Segmenter<'a> {
    map: &'a DepthMap,
    rays: &'a Rays,
    options: &'a Options,
    /// sin²ω, which is cos²(90° − ω).
    sine: f32,
}

impl<'a> Segmenter<'a> {
    pub fn new(map: &'a DepthMap, rays: &'a Rays, options: &'a Options) -> Self {
        let sine = libm::sinf(options.omega.to_radians());
        Self { map, rays, options, sine: sine * sine }
    }

    /// Bit t is set where triangle t of the node around the odd point (x, y) is cut. `nearest` and `farthest` are the least and largest of
    /// its finite depths; nothing but background is (∞, −∞).
    pub fn flags(&self, x: usize, y: usize, nearest: f32, farthest: f32, background: bool) -> u8 {
        if nearest > farthest {
            return u8::MAX;
        }
        if !background && (self.options.segmentation == Segmentation::None || !self.wide(nearest, farthest, nearest)) {
            return 0;
        }
        let at = |d: (isize, isize)| step((x, y), d, 1);
        (0..8).fold(0, |flags, t| {
            let corners = [(x, y), at(RING[t]), at(RING[(t + 1) % 8])];
            flags | u8::from(self.cut(corners)) << t
        })
    }

    /// Equation (11).
    fn wide(&self, nearest: f32, farthest: f32, z: f32) -> bool {
        let lambda = self.options.lambda;
        match self.options.depth_range {
            DepthRange::Absolute => farthest - nearest > lambda,
            DepthRange::Relative => farthest - nearest > lambda * z,
        }
    }

    fn depth(&self, (x, y): (usize, usize)) -> f32 {
        self.map.depth()[y * self.map.side() + x]
    }

    fn position(&self, at: (usize, usize)) -> Vec3 {
        self.rays.position(at.0, at.1, self.depth(at))
    }

    fn cut(&self, corners: [(usize, usize); 3]) -> bool {
        let z = corners.map(|c| self.depth(c));
        if z[0] + z[1] + z[2] == f32::INFINITY {
            return true;
        }
        let (nearest, farthest) = (z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2]));
        self.wide(nearest, farthest, (z[0] + z[1] + z[2]) / 3.0)
            && match self.options.segmentation {
                Segmentation::None => false,
                Segmentation::Orthogonality => self.grazing(corners),
                Segmentation::Disparity => corners.into_iter().filter(|&c| self.disparate(c)).count() >= 2,
                Segmentation::Connectedness => {
                    let pairs = [[0, 1], [1, 2], [2, 0]].map(|p| p.map(|i| corners[i]));
                    let along = |[a, b]: &[(usize, usize); 2]| a.0 == b.0 || a.1 == b.1;
                    pairs.into_iter().filter(along).any(|[a, b]| self.disconnected(a, b))
                }
            }
    }

    /// Equation (10).
    fn grazing(&self, corners: [(usize, usize); 3]) -> bool {
        let [a, b, c] = corners.map(|c| self.position(c));
        let n = (b - a).cross(c - a);
        let v = if self.rays.perspective { a + b + c } else { Vec3::Z };
        let along = n.dot(v);
        let lengths = n.length_squared() * v.length_squared();
        // A triangle without area is seen at no angle at all.
        !(along * along >= self.sine * lengths) || lengths == 0.0
    }

    /// Equation (9) along the row or the column.
    fn disparate(&self, (x, y): (usize, usize)) -> bool {
        let last = self.map.side() - 1;
        let at = |x: usize, y: usize| self.depth((x, y));
        let row = x > 0 && x < last && self.jumps(at(x - 1, y), at(x, y), at(x + 1, y));
        row || y > 0 && y < last && self.jumps(at(x, y - 1), at(x, y), at(x, y + 1))
    }

    /// Next to background nothing is known but that it is cut anyway.
    fn jumps(&self, z1: f32, z2: f32, z3: f32) -> bool {
        let change = if self.rays.perspective {
            (z1 - z2) / z1 - (z2 - z3) / z3
        } else {
            ((z1 - z2) - (z2 - z3)) / self.rays.window
        };
        z1 + z2 + z3 < f32::INFINITY && change.abs() > self.options.sigma
    }

    /// Equations (5) and (6) between neighbours of a row or column, in the frame of which the z axis points from the eye to the first.
    /// Only the parameter range is sheared (x̂2 of figure 9b): slopes are the normals', so that a rubber sheet that its own
    /// normals predict is still off the curve.
    fn disconnected(&self, from: (usize, usize), to: (usize, usize)) -> bool {
        let (p1, p2) = (self.position(from), self.position(to));
        let axis = if self.rays.perspective { p1.normalize_or(Vec3::Z) } else { Vec3::Z };
        let edge = p2 - p1;
        let range = edge.length();
        let rise = edge.dot(axis);
        let across = (edge - axis * rise).normalize_or_zero();
        let slope = |at: (usize, usize)| {
            let n = normals::normal(self.map, self.rays, self.options, at.0, at.1);
            -n.dot(across) / n.dot(axis)
        };
        let (b1, b2) = (slope(from), slope(to));
        // f(x̂2) − z2 with C = (f'(x̂2) − B)/(2·x̂2), over x̂2. Slopes are infinite where a normal lies across the view: not connected.
        !((0.5 * (b1 + b2) * range - rise).abs() <= self.options.kappa * range)
    }
}
