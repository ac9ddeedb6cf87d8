//! Does a face touch a voxel's box? The test on which the whole simplification stands (Jeschke and Wimmer 2002, section 6).
//!
//! Coordinates are *quarter units*: x and y in quarter pixels, z four times the layer, so that a voxel is a cube of side 4
//! around (4x + 2, 4y + 2, 4 layer). Enlarged by `factor` its half side is 2 · factor. Boxes and faces are closed. All
//! products of coordinates are integers below 2^53: without enlargement by a fraction the test is exact.

use super::Voxel;

/// A point in quarter units.
pub type Point = [f64; 3];

/// Centre of a voxel's box.
pub fn centre(v: &Voxel) -> Point {
    [4.0 * f64::from(v.x) + 2.0, 4.0 * f64::from(v.y) + 2.0, 4.0 * f64::from(v.layer)]
}

/// A vertex of a [`super::VoxelMesh`] in quarter units.
pub fn point(v: [i32; 3]) -> Point {
    [f64::from(v[0]), f64::from(v[1]), 4.0 * f64::from(v[2])]
}

/// a − b.
pub fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Scalar product.
pub fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Squared distance.
pub fn squared(a: Point, b: Point) -> f64 {
    let along = sub(a, b);
    dot(along, along)
}

/// Cross product of b − a and c − a.
pub fn normal(a: Point, b: Point, c: Point) -> Point {
    let (u, v) = (sub(b, a), sub(c, a));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// Twice the area of the face as the cell's centre sees it, in quarter pixels squared; y points down, so that
/// a face that is counter-clockwise to the eye is positive.
pub fn front_area(a: Point, b: Point, c: Point) -> f64 {
    (c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1])
}

/// A face prepared for tests against many boxes of one half side: the separating axes of box and triangle,
/// as half spaces that the box's centre must lie in.
pub struct Toucher {
    low: Point,
    high: Point,
    normal: Point,
    /// The plane's slab: |normal · (c − a)| ≤ reach.
    offset: f64,
    reach: f64,
    /// In the planes yz, zx and xy, those first in which the face is large: the axes u and v, and per edge
    /// p · c_u + q · c_v + r ≥ 0.
    edges: [(usize, usize, [[f64; 3]; 3]); 3],
}

impl Toucher {
    /// `half`: half side of the boxes, quarter units.
    pub fn new(corners: [Point; 3], half: f64) -> Self {
        Self::oblong(corners, [half; 3])
    }

    /// `half`: half sides of the boxes, quarter units.
    pub fn oblong(corners: [Point; 3], half: Point) -> Self {
        let [a, b, c] = corners;
        let n = normal(a, b, c);
        let area = n.map(f64::abs);
        let mut axes = if area[0] > area[2] { [0, 1, 2] } else { [2, 1, 0] };
        if area[1] > area[axes[0]] {
            axes.swap(0, 1);
        }
        let edges = axes.map(|axis| {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            // Inward normals of the projected edges. Where the projection is a segment, edges run both ways and so
            // bound it from both sides, whatever the sign.
            let sign = if n[axis] < 0.0 { -1.0 } else { 1.0 };
            let edge = |i: usize| {
                let (s, e) = (corners[i], corners[(i + 1) % 3]);
                let (p, q) = (-(e[v] - s[v]) * sign, (e[u] - s[u]) * sign);
                [p, q, half[u] * p.abs() + half[v] * q.abs() - p * s[u] - q * s[v]]
            };
            (u, v, [edge(0), edge(1), edge(2)])
        });
        Self {
            low: std::array::from_fn(|i| a[i].min(b[i]).min(c[i]) - half[i]),
            high: std::array::from_fn(|i| a[i].max(b[i]).max(c[i]) + half[i]),
            normal: n,
            offset: dot(n, a),
            reach: half[0] * area[0] + half[1] * area[1] + half[2] * area[2],
            edges,
        }
    }

    /// Whether the face touches the box around `c`.
    pub fn touches(&self, c: &Point) -> bool {
        if c[0] < self.low[0] || c[0] > self.high[0] || c[1] < self.low[1] || c[1] > self.high[1] {
            return false;
        }
        if c[2] < self.low[2] || c[2] > self.high[2] {
            return false;
        }
        if (dot(self.normal, *c) - self.offset).abs() > self.reach {
            return false;
        }
        self.edges.iter().all(|(u, v, plane)| plane.iter().all(|e| e[0] * c[*u] + e[1] * c[*v] + e[2] >= 0.0))
    }
}

/// The part of the segment a–b, as parameters from 0 to 1, that lies in the box around `c`; `None` where they are apart.
pub fn interval(a: Point, b: Point, c: &Point, half: f64) -> Option<(f64, f64)> {
    interval_oblong(a, b, c, [half; 3])
}

/// [`interval`] of a box with half sides of its own along each axis.
pub fn interval_oblong(a: Point, b: Point, c: &Point, half: Point) -> Option<(f64, f64)> {
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for i in 0..3 {
        let (d, low, high) = (b[i] - a[i], c[i] - half[i] - a[i], c[i] + half[i] - a[i]);
        if d == 0.0 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
        } else {
            let (t, u) = (low / d, high / d);
            from = from.max(t.min(u));
            to = to.min(t.max(u));
        }
    }
    (from <= to).then_some((from, to))
}

/// Whether intervals cover the whole of [0, 1]. Sorts them.
pub fn cover_unit(intervals: &mut [(f64, f64)]) -> bool {
    intervals.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut reached = 0.0;
    for (from, to) in intervals.iter() {
        // Rounding of the divisions must not tear two boxes that share a side apart.
        if *from > reached + 1e-12 {
            break;
        }
        reached = f64::max(reached, *to);
    }
    reached >= 1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Clips the triangle by the box's six planes: what remains is not empty exactly if they touch.
    fn touches_by_clipping(corners: [Point; 3], c: Point, half: f64) -> bool {
        let mut polygon = corners.to_vec();
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let inside = |p: &Point| half - sign * (p[axis] - c[axis]);
                let mut out = Vec::new();
                for i in 0..polygon.len() {
                    let (s, e) = (polygon[i], polygon[(i + 1) % polygon.len()]);
                    let (ds, de) = (inside(&s), inside(&e));
                    if ds >= 0.0 {
                        out.push(s);
                    }
                    if (ds > 0.0 && de < 0.0) || (ds < 0.0 && de > 0.0) {
                        let t = ds / (ds - de);
                        out.push(std::array::from_fn(|k| s[k] + (e[k] - s[k]) * t));
                    }
                }
                polygon = out;
            }
        }
        !polygon.is_empty()
    }

    fn lattice() -> impl Strategy<Value = Point> {
        prop::array::uniform3(-12i32..13).prop_map(|p| p.map(f64::from))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]
        #[test]
        fn agrees_with_clipping(t in prop::array::uniform3(lattice()), c in lattice()) {
            // A box a hair smaller or larger decides where rounding of the clipped points could.
            let touched = Toucher::new(t, 3.0).touches(&c);
            if touched {
                prop_assert!(touches_by_clipping(t, c, 3.0 + 1e-9));
            } else {
                prop_assert!(!touches_by_clipping(t, c, 3.0 - 1e-9));
            }
        }

        #[test]
        fn interval_ends_lie_in_the_box(a in lattice(), b in lattice(), c in lattice()) {
            let at = |t: f64| -> Point { std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t) };
            let inside = |p: Point| (0..3).all(|i| (p[i] - c[i]).abs() <= 3.0 + 1e-9);
            match interval(a, b, &c, 3.0) {
                Some((from, to)) => prop_assert!(inside(at(from)) && inside(at(to))),
                None => prop_assert!((0..=100).all(|k| !inside(at(f64::from(k) / 100.0)) || a == b)),
            }
        }
    }

    #[test]
    fn unit_cover_finds_gaps() {
        assert!(cover_unit(&mut [(0.4, 1.0), (-0.2, 0.5)]));
        assert!(!cover_unit(&mut [(0.6, 1.0), (0.0, 0.5)]));
        assert!(!cover_unit(&mut [(0.0, 0.9)]));
        assert!(!cover_unit(&mut []));
    }
}
