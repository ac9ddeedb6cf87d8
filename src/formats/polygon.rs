//! Faces of any number of corners as triangles.
//!
//! A face is projected on the plane of its Newell normal (Sutherland et al. 1974) and cut into ears there (Held 2001,
//! as in mapbox's earcut). What always holds: triangles use the face's own corners and have its winding; a face
//! whose corners are distinct and whose outline does not cross itself gives two triangles fewer than it has corners, so
//! that its neighbours still meet it edge to edge.

use earcut::Earcut;
use glam::{DVec2, DVec3};

/// Most corners of one face. Cutting a tangled outline costs the square of its corners.
pub(super) const MOST_CORNERS: usize = 1 << 16;

/// Areas below this share of the face's squared extent are rounding.
const FLAT: f64 = 1e-14;

/// Cuts faces; keeps its buffers from face to face.
pub(super) struct Polygons {
    ears: Earcut<f64>,
    /// Numbers of the corners that differ from the one before.
    kept: Vec<u32>,
    points: Vec<DVec3>,
    flat: Vec<[f64; 2]>,
    numbers: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl Polygons {
    pub fn new() -> Self {
        let (kept, points, flat, numbers, triangles) = Default::default();
        Self { ears: Earcut::new(), kept, points, flat, numbers, triangles }
    }

    /// Triangles over the numbers of `corners`; none where the face has no area.
    pub fn triangles(&mut self, corners: impl IntoIterator<Item = DVec3>) -> &[[u32; 3]] {
        self.triangles.clear();
        self.keep_distinct(corners);
        match self.points.len() {
            0..3 => return &[],
            3 => self.triangles.push([0, 1, 2]),
            4 => self.quad(),
            _ => self.polygon(),
        }
        for t in &mut self.triangles {
            *t = t.map(|v| self.kept[v as usize]);
        }
        &self.triangles
    }

    fn keep_distinct(&mut self, corners: impl IntoIterator<Item = DVec3>) {
        self.kept.clear();
        self.points.clear();
        for (i, p) in (0..).zip(corners) {
            if self.points.last() != Some(&p) {
                self.points.push(p);
                self.kept.push(i);
            }
        }
        while self.points.len() > 1 && self.points.first() == self.points.last() {
            self.points.pop();
            self.kept.pop();
        }
    }

    /// The Newell normal, twice the face's area long, and the face's squared extent.
    fn normal(&self) -> (DVec3, f64) {
        let origin = self.points[0];
        let at = |i: usize| self.points[i % self.points.len()] - origin;
        let sum = (0..self.points.len()).fold(DVec3::ZERO, |n, i| n + at(i).cross(at(i + 1)));
        let extent = self.points.iter().map(|p| (*p - origin).length_squared()).fold(0.0, f64::max);
        (sum, extent)
    }

    /// Twice the area of a triangle of points, as seen against `normal`.
    fn facing(&self, [a, b, c]: [u32; 3], normal: DVec3) -> f64 {
        let [a, b, c] = [a, b, c].map(|i| self.points[i as usize]);
        (b - a).cross(c - a).dot(normal)
    }

    fn quad(&mut self) {
        let (normal, extent) = self.normal();
        let least = FLAT * extent * normal.length();
        for halves in [[[0, 1, 2], [0, 2, 3]], [[1, 2, 3], [1, 3, 0]]] {
            if halves.iter().all(|t| self.facing(*t, normal) > least) {
                self.triangles.extend(halves);
                return;
            }
        }
        self.fan_of_what_has_area(extent);
    }

    fn polygon(&mut self) {
        let (normal, extent) = self.normal();
        if !(normal.length() > FLAT * extent) {
            return self.fan_of_what_has_area(extent);
        }
        let n = self.points.len() as u32;
        let least = FLAT * extent * normal.length();
        let convex = (0..n).all(|i| self.facing([i, (i + 1) % n, (i + 2) % n], normal) >= -least)
            && (1..n - 1).all(|i| self.facing([0, i, i + 1], normal) > least);
        if convex {
            return self.triangles.extend((1..n - 1).map(|i| [0, i, i + 1]));
        }
        let (u, v) = normal.normalize().any_orthonormal_pair();
        let origin = self.points[0];
        self.flat.clear();
        self.flat.extend(self.points.iter().map(|p| [(*p - origin).dot(u), (*p - origin).dot(v)]));
        self.ears.earcut_slice(&self.flat, &[], &mut self.numbers);
        let at = |i: u32| DVec2::from(self.flat[i as usize]);
        let cut = self.numbers.chunks_exact(3).map(|t| {
            let [a, b, c] = [t[0], t[1], t[2]];
            // Earcut gives one winding whatever the outline's; the face's own is counter-clockwise here.
            if (at(b) - at(a)).perp_dot(at(c) - at(a)) < 0.0 { [a, c, b] } else { [a, b, c] }
        });
        self.triangles.extend(cut);
        if self.triangles.is_empty() {
            self.fan_of_what_has_area(extent);
        }
    }

    /// For outlines that cross themselves so that no plane shows them: what common viewers draw.
    fn fan_of_what_has_area(&mut self, extent: f64) {
        let area = |[a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|i| self.points[i as usize]);
            (b - a).cross(c - a).length()
        };
        let fan = (1..self.points.len() as u32 - 1).map(|i| [0, i, i + 1]);
        self.triangles = fan.filter(|t| area(*t) > FLAT * extent).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn cut(corners: &[DVec3]) -> Vec<[u32; 3]> {
        Polygons::new().triangles(corners.iter().copied()).to_vec()
    }

    fn flat(points: &[[f64; 2]]) -> Vec<DVec3> {
        points.iter().map(|[x, y]| DVec3::new(*x, *y, 0.0)).collect()
    }

    /// Twice the area of each triangle, seen from +Z.
    fn areas(corners: &[DVec3], triangles: &[[u32; 3]]) -> Vec<f64> {
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| corners[v as usize]);
            (b - a).cross(c - a).z
        };
        triangles.iter().map(area).collect()
    }

    /// The triangles fill the outline, each of its edges once, and meet each other edge to edge.
    fn fills(corners: usize, triangles: &[[u32; 3]]) {
        assert_eq!(triangles.len(), corners - 2);
        let edges = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        let all: BTreeSet<_> = edges.collect();
        assert_eq!(all.len(), 3 * triangles.len(), "no directed edge twice");
        for i in 0..corners as u32 {
            assert!(all.contains(&(i, (i + 1) % corners as u32)), "edge {i} of the outline");
        }
        let inner = all.iter().filter(|(a, b)| (a + 1) % corners as u32 != *b);
        assert!(inner.clone().all(|(a, b)| all.contains(&(*b, *a))));
    }

    #[test]
    fn known_shapes() {
        // A convex quad keeps the fan that it always had; a concave one is cut at its notch.
        assert_eq!(cut(&flat(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.]])), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(cut(&flat(&[[0., 0.], [2., 0.], [0.5, 0.5], [0., 2.]])), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(cut(&flat(&[[2., 0.], [0.5, 0.5], [0., 2.], [0., 0.]])), [[1, 2, 3], [1, 3, 0]]);
        // A corner on an edge.
        assert_eq!(cut(&flat(&[[0., 0.], [1., 0.], [2., 0.], [1., 2.]])), [[1, 2, 3], [1, 3, 0]]);
        // Repeated corners, next to each other and at the ends.
        assert_eq!(cut(&flat(&[[0., 0.], [1., 0.], [1., 0.], [1., 1.], [0., 0.]])), [[0, 1, 3]]);
        for degenerate in
            [&[[0., 0.]; 5][..], &[[0., 0.], [1., 1.]], &[[0., 0.], [1., 1.], [2., 2.], [3., 3.], [1.5, 1.5]], &[]]
        {
            assert_eq!(cut(&flat(degenerate)), [[0u32; 3]; 0], "{degenerate:?}");
        }
        // A bow tie has no normal; its halves are shown.
        assert_eq!(cut(&flat(&[[0., 0.], [1., 1.], [1., 0.], [0., 1.]])).len(), 2);
    }

    #[test]
    fn a_ring_with_a_slit_keeps_its_hole() {
        let outer = [[-2., -2.], [2., -2.], [2., 2.], [-2., 2.], [-2., -2.]];
        let inner = [[-1., -1.], [-1., 1.], [1., 1.], [1., -1.], [-1., -1.]];
        let corners = flat(&[outer, inner].concat());
        let triangles = cut(&corners);
        let areas = areas(&corners, &triangles);
        assert!(areas.iter().all(|a| *a >= 0.0));
        assert!((areas.iter().sum::<f64>() - 2.0 * 12.0).abs() < 1e-12);
    }

    #[test]
    fn thousands_of_corners() {
        // A comb: half of its corners are notches.
        let teeth = 5000;
        let comb = (0..2 * teeth).rev().map(|i| [i as f64, if i % 2 == 0 { 1.0 } else { 900.0 }]);
        let corners = flat(&[vec![[-1.0, 0.0], [2.0 * teeth as f64, 0.0]], comb.collect()].concat());
        let triangles = cut(&corners);
        fills(corners.len(), &triangles);
        assert!(areas(&corners, &triangles).iter().all(|a| *a > 0.0));
    }

    #[test]
    fn tangled_outlines_end() {
        for step in [2, 499, 1001] {
            let corners: Vec<_> = (0..2003)
                .map(|i| {
                    let angle = (i * step % 2003) as f64 * std::f64::consts::TAU / 2003.0;
                    DVec3::new(libm::cos(angle), libm::sin(angle), libm::sin(7.0 * angle))
                })
                .collect();
            assert!(cut(&corners).iter().flatten().all(|v| (*v as usize) < corners.len()));
        }
    }

    proptest! {
        #[test]
        fn star_shaped_faces_are_filled(
            radii in prop::collection::vec(0.1f64..1.0, 5..60), bend in 0.0f64..0.002,
            turn in prop::array::uniform3(-3.0f64..3.0), far in prop::array::uniform3(-1e6f64..1e6), mirror in any::<bool>(),
        ) {
            let n = radii.len();
            let planar: Vec<_> = radii.iter().enumerate().map(|(i, r)| {
                let angle = i as f64 * std::f64::consts::TAU / n as f64;
                DVec3::new(r * libm::cos(angle), r * libm::sin(angle), bend * libm::sin(3.0 * angle))
            }).collect();
            let place = glam::DAffine3::from_scale_rotation_translation(
                DVec3::splat(3.0), glam::DQuat::from_euler(glam::EulerRot::XYZ, turn[0], turn[1], turn[2]), far.into());
            let mut corners: Vec<_> = planar.iter().map(|p| place.transform_point3(*p)).collect();
            let mut local = planar;
            if mirror {
                corners.reverse();
                local.reverse();
            }
            let triangles = cut(&corners);
            fills(n, &triangles);
            let side = if mirror { -1.0 } else { 1.0 };
            // Slivers of the bent surface may turn by rounding; the whole is filled.
            let areas = areas(&local, &triangles);
            prop_assert!(areas.iter().all(|a| a * side > -1e-6));
            let outline: f64 = (0..n).map(|i| local[i].truncate().perp_dot(local[(i + 1) % n].truncate())).sum();
            prop_assert!((areas.iter().sum::<f64>() - outline).abs() < 1e-6);
        }

        #[test]
        fn anything_gives_triangles_of_its_own_corners(
            corners in prop::collection::vec(prop::array::uniform3(-3i8..3), 0..40), scale in prop_oneof![Just(1.0), Just(1e-30), Just(3e38)],
        ) {
            let corners: Vec<_> = corners.iter().map(|c| DVec3::from(c.map(f64::from)) * scale).collect();
            let triangles = cut(&corners);
            prop_assert!(triangles.iter().flatten().all(|v| (*v as usize) < corners.len()));
            prop_assert!(triangles.len() <= corners.len());
        }
    }
}
