//! Spheres around the surface of quadtree nodes.

use super::rays::Rays;
use glam::Vec3;

/// A sphere that holds all surface points of a node, with room for rounding; radius −1 where there are none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sphere {
    pub centre: Vec3,
    pub radius: f32,
}

impl Sphere {
    /// Around columns x0 to x1 and rows y0 to y1 between depths `nearest` and `farthest`; none where `nearest > farthest`.
    pub fn around(rays: &Rays, [x0, x1]: [usize; 2], [y0, y1]: [usize; 2], [nearest, farthest]: [f32; 2]) -> Self {
        if nearest > farthest {
            return Self { centre: Vec3::ZERO, radius: -1.0 };
        }
        let middle = 0.5 * (nearest + farthest);
        let w = rays.stretch(middle);
        let (x, y) = ([rays.x[x0], rays.x[x1]], [rays.y[y0], rays.y[y1]]);
        let centre = Vec3::new(0.5 * (x[0] + x[1]) * w, 0.5 * (y[0] + y[1]) * w, middle);
        let reach = |c: [f32; 2], w: f32, centre: f32| {
            let (a, b) = (c[0] * w - centre, c[1] * w - centre);
            (a * a).max(b * b)
        };
        let to = |z: f32| {
            let w = rays.stretch(z);
            reach(x, w, centre.x) + reach(y, w, centre.y) + (z - middle) * (z - middle)
        };
        let radius = to(nearest).max(to(farthest)).sqrt();
        Self { centre, radius: radius * (1.0 + 1e-5) + 1e-6 * centre.length() }
    }

    pub fn is_empty(&self) -> bool {
        self.radius < 0.0
    }

    /// Least squared distance of `p` from what the sphere holds.
    pub fn squared_distance(&self, p: Vec3) -> f32 {
        let d = ((self.centre - p).length() - self.radius).max(0.0);
        d * d
    }
}
