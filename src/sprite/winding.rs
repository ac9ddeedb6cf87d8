//! Inside and outside of surfaces that are open, overlap, or meet themselves, by the generalised winding number (A. Jacobson,
//! L. Kavan and O. Sorkine-Hornung, *Robust Inside-Outside Segmentation using Generalized Winding Numbers*, 2013).
//!
//! w(p) is the sum of the solid angles of all triangles seen from p, over 4π: a whole number where the surface is closed, and
//! smooth across its holes where it is not. A point is inside where |w(p)| > ½.
//!
//! Far groups of triangles are summed by their dipoles (G. Barill, N. Dickson, R. Schmidt, D. Levin and A. Jacobson, *Fast
//! Winding Numbers for Soups and Clouds*, 2018, section 3: the first two terms of the Taylor series), near ones exactly. A result
//! close to ½ is summed once more with groups that are farther away, so that the approximation decides nothing.

use glam::{DMat3, DVec3};

/// Triangles of a leaf, which are summed one by one.
const LEAF: usize = 6;
/// A group is taken as a whole from so many of its radii on (β of the paper).
const FAR: f64 = 2.0;
/// The same for results near ½.
const FARTHER: f64 = 8.0;
/// How near ½ those are: more than the first sum can be off by.
const CLOSE: f64 = 0.15;

/// Triangles in a hierarchy of groups.
pub struct Winding {
    /// Grouped: those of a leaf are neighbours.
    triangles: Vec<[DVec3; 3]>,
    nodes: Vec<Node>,
}

/// A group of triangles.
struct Node {
    /// p̃: mean of the triangles' centroids by area.
    centre: DVec3,
    /// No point of the group is farther from the centre.
    radius: f64,
    /// Σ a·n over its triangles.
    dipole: DVec3,
    /// Σ a·(centroid − p̃) ⊗ n: column j belongs to component j of n.
    spread: DMat3,
    /// Its triangles where it is a leaf; the numbers of its two parts otherwise.
    parts: Parts,
}

enum Parts {
    Leaf(std::ops::Range<u32>),
    Two(u32, u32),
}

impl Winding {
    /// Of triangles that are counter-clockwise seen from outside. The order of the triangles does not matter beyond rounding.
    pub fn new(mut triangles: Vec<[DVec3; 3]>) -> Self {
        triangles.retain(|[a, b, c]| (b - a).cross(c - a).length() > 0.0);
        let mut nodes = Vec::with_capacity(triangles.len() / 2 + 1);
        if !triangles.is_empty() {
            build(&mut triangles, 0, &mut nodes);
        }
        Self { triangles, nodes }
    }

    /// Whether |w(p)| > ½.
    pub fn contains(&self, p: DVec3) -> bool {
        let w = self.sum(p, FAR).abs();
        if (w - 0.5).abs() > CLOSE { w > 0.5 } else { self.sum(p, FARTHER).abs() > 0.5 }
    }

    /// w(p), groups taken as a whole from `far` of their radii on.
    fn sum(&self, p: DVec3, far: f64) -> f64 {
        let mut sum = 0.0;
        // A hierarchy split at medians is no deeper than 32.
        let mut open = [0u32; 64];
        let mut count = usize::from(!self.nodes.is_empty());
        while count > 0 {
            count -= 1;
            let node = &self.nodes[open[count] as usize];
            let d = node.centre - p;
            let d2 = d.length_squared();
            if d2 > (far * node.radius) * (far * node.radius) {
                sum += node.seen(d, d2);
                continue;
            }
            match &node.parts {
                Parts::Leaf(range) => {
                    let near = &self.triangles[range.start as usize..range.end as usize];
                    sum += solid_angles(near, p);
                }
                Parts::Two(a, b) => {
                    open[count] = *b;
                    open[count + 1] = *a;
                    count += 2;
                }
            }
        }
        sum / (4.0 * std::f64::consts::PI)
    }
}

impl Node {
    /// Its solid angle from a point that its centre lies at `d` from: Σ a·n·∇G + spread : ∇²G with G = −1/r, without 1/4π.
    fn seen(&self, d: DVec3, d2: f64) -> f64 {
        let r3 = d2 * d2.sqrt();
        let trace = self.spread.x_axis.x + self.spread.y_axis.y + self.spread.z_axis.z;
        (self.dipole.dot(d) + trace - 3.0 * d.dot(self.spread * d) / d2) / r3
    }
}

/// Adds the group of `triangles`, the first of which has the number `first`; returns its own number.
fn build(triangles: &mut [[DVec3; 3]], first: u32, nodes: &mut Vec<Node>) -> u32 {
    let number = nodes.len() as u32;
    nodes.push(group(triangles, Parts::Leaf(first..first + triangles.len() as u32)));
    if triangles.len() > LEAF {
        let middle = |t: &[DVec3; 3]| t[0] + t[1] + t[2];
        let bounds = triangles
            .iter()
            .map(middle)
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), m| (low.min(m), high.max(m)));
        let size = bounds.1 - bounds.0;
        let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
        let key = |t: &[DVec3; 3]| middle(t)[axis];
        let half = triangles.len() / 2;
        // Equal places in the given order, so that the groups depend on nothing else.
        triangles.sort_by(|a, b| key(a).total_cmp(&key(b)));
        let (low, high) = triangles.split_at_mut(half);
        let a = build(low, first, nodes);
        let b = build(high, first + half as u32, nodes);
        nodes[number as usize].parts = Parts::Two(a, b);
    }
    number
}

fn group(triangles: &[[DVec3; 3]], parts: Parts) -> Node {
    let (mut area, mut sum, mut dipole) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for [a, b, c] in triangles {
        let n = (b - a).cross(c - a) * 0.5;
        area += n.length();
        sum += (a + b + c) / 3.0 * n.length();
        dipole += n;
    }
    let centre = sum / area;
    let (mut spread, mut radius2) = (DMat3::ZERO, 0.0f64);
    for [a, b, c] in triangles {
        let n = (b - a).cross(c - a) * 0.5;
        let from = (a + b + c) / 3.0 - centre;
        spread += DMat3::from_cols(from * n.x, from * n.y, from * n.z);
        radius2 = [a, b, c].iter().fold(radius2, |r, p| r.max(p.distance_squared(centre)));
    }
    Node { centre, radius: radius2.sqrt(), dipole, spread, parts }
}

/// The solid angles of a few triangles seen from `p`. Angles add up where complex numbers are multiplied, so that most of them share
/// one arc tangent: [`LEAF`] times atan ½ is less than π.
fn solid_angles(triangles: &[[DVec3; 3]], p: DVec3) -> f64 {
    let (mut sum, mut x, mut y) = (0.0, 1.0, 0.0);
    for t in triangles {
        let [b, a] = half_angle(t.map(|q| q - p));
        if a.abs() <= 0.5 * b {
            (x, y) = (x * b - y * a, x * a + y * b);
        } else {
            sum += libm::atan2(a, b);
        }
    }
    2.0 * (sum + libm::atan2(y, x))
}

/// A complex number (real part first) whose argument is half the solid angle of a triangle seen from the origin, positive where it turns its back to it (A. van Oosterom and J. Strackee,
/// *The Solid Angle of a Plane Triangle*, 1983).
fn half_angle([a, b, c]: [DVec3; 3]) -> [f64; 2] {
    let [la, lb, lc] = [a.length(), b.length(), c.length()];
    let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    [below, a.dot(b.cross(c))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{math::Sequence, raster::tests::octahedron, scene::Mesh};

    fn triangles(mesh: &Mesh) -> Vec<[DVec3; 3]> {
        let at = |i: u32| DVec3::from(mesh.positions[i as usize].map(f64::from));
        mesh.triangles.iter().map(|t| t.map(at)).collect()
    }

    /// The definition: all solid angles, one after the other.
    fn literal(triangles: &[[DVec3; 3]], p: DVec3) -> f64 {
        let angle = |t: &[DVec3; 3]| {
            let [b, a] = half_angle(t.map(|q| q - p));
            2.0 * libm::atan2(a, b)
        };
        triangles.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
    }

    #[test]
    fn agrees_with_summing_all() {
        let mut open = triangles(&octahedron(4));
        // A hole, and a second shape that overlaps the first.
        open.retain(|t| (t[0] + t[1] + t[2]).z < 2.0);
        open.extend(triangles(&octahedron(3)).into_iter().map(|t| t.map(|p| p * 0.7 + DVec3::X)));
        let winding = Winding::new(open.clone());
        let sequence = Sequence::<3>::new(3);
        let (mut worst, mut inside) = (0.0f64, 0);
        for i in 0..3000 {
            let p = (DVec3::from(sequence.point(i)) * 2.0 - 1.0) * DVec3::new(2.0, 1.3, 1.3);
            let w = literal(&open, p);
            worst = worst.max((winding.sum(p, FAR) - w).abs());
            if (w.abs() - 0.5).abs() > 2e-3 {
                assert_eq!(winding.contains(p), w.abs() > 0.5, "{p}: {w}");
            }
            inside += usize::from(w.abs() > 0.5);
        }
        assert!(worst < 0.8 * CLOSE, "off by {worst}: results near one half would not be summed again");
        assert!((500..2500).contains(&inside), "{inside}");
    }

    #[test]
    fn closed_surfaces_are_wound_once() {
        let ball = triangles(&octahedron(3));
        for (p, w) in [(DVec3::ZERO, 1.0), (DVec3::splat(0.4), 1.0), (DVec3::splat(0.8), 0.0), (DVec3::Y * 3.0, 0.0)] {
            assert!(
                (literal(&ball, p) - w).abs() < 1e-12 && (Winding::new(ball.clone()).sum(p, FAR) - w).abs() < CLOSE
            );
        }
        let turned: Vec<_> = ball.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        assert!(Winding::new(turned).contains(DVec3::ZERO), "clockwise all round is a solid too");
        assert!(!Winding::new(Vec::new()).contains(DVec3::ZERO));
        assert!(!Winding::new(vec![[DVec3::ZERO; 3]]).contains(DVec3::ZERO));
    }
}
