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
