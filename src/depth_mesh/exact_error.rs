//! The error of each grid point as the largest distance of what is covered by the two triangles that it splits.
//!
//! A triangulation consists of triangles whose hypotenuse has an unselected midpoint. If that point's error, the larger
//! of its two triangles', is at most ε, no grid point is farther than ε from the triangle that stands in for it,
//! whatever its neighbours are: the bound holds triangle by triangle and needs no maximum up the hierarchy.

use super::{edge_error::across, grid::Grid, map::DepthMap, options::Distance, rays::Rays};
use glam::Vec3;
use rayon::prelude::*;

/// Rows of a large triangle that one task takes: a constant, so that the order of comparisons does not depend on threads.
const ROWS: isize = 16;

/// Squared distances, metres². Corners have none. A triangle that holds surface and background has the length of its hypotenuse across the view at least:
/// by so much the outline recedes where it is cut.
pub(super) fn exact_errors(map: &DepthMap, rays: &Rays, distance: Distance) -> Vec<f32> {
    let side = map.side();
    let n = side - 1;
    let scan = Scan { map, rays, depth: distance == Distance::Depth };
    let mut errors = vec![0.0; side * side];
    for level in (0..Grid::of(side).k).rev() {
        let h = Grid::of(side).half(level);
        let error = |x: usize, y: usize, shape: Shape| scan.error(x, y, h, shape);
        errors.par_chunks_mut(2 * h * side).with_min_len((16 / h).max(1)).enumerate().for_each(|(band, rows)| {
            let y = 2 * h * band;
            for x in (h..n).step_by(2 * h) {
                let above = if y > 0 { error(x, y - h, Shape::South) } else { 0.0 };
                let below = if y < n { error(x, y + h, Shape::North) } else { 0.0 };
                rows[x] = above.max(below);
            }
            // The last band is the bottom row alone.
            let Some(row) = rows.get_mut(h * side..).filter(|row| !row.is_empty()) else { return };
            let y = y + h;
            for x in (0..=n).step_by(2 * h) {
                let left = if x > 0 { error(x - h, y, Shape::East) } else { 0.0 };
                let right = if x < n { error(x + h, y, Shape::West) } else { 0.0 };
                row[x] = left.max(right);
            }
            for x in (h..n).step_by(2 * h) {
                let [one, other] = if (x ^ y) & (2 * h) == 0 {
                    [Shape::SouthWest, Shape::NorthEast]
                } else {
                    [Shape::NorthWest, Shape::SouthEast]
                };
                row[x] = error(x, y, one).max(error(x, y, other));
            }
        });
    }
    errors
}

/// A quarter or a half of a quad of side 2h.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    North,
    East,
    South,
    West,
    NorthEast,
    SouthEast,
    SouthWest,
    NorthWest,
}

impl Shape {
    /// Corners from the centre in half sides.
    fn corners(self) -> [(isize, isize); 3] {
        let [nw, ne, se, sw, c] = [(-1, -1), (1, -1), (1, 1), (-1, 1), (0, 0)];
        match self {
            Self::North => [nw, ne, c],
            Self::East => [ne, se, c],
            Self::South => [se, sw, c],
            Self::West => [sw, nw, c],
            Self::NorthEast => [nw, ne, se],
            Self::SouthEast => [ne, se, sw],
            Self::SouthWest => [se, sw, nw],
            Self::NorthWest => [sw, nw, ne],
        }
    }

    /// Rows that it covers.
    fn rows(self, h: isize) -> [isize; 2] {
        match self {
            Self::North => [-h, 0],
            Self::South => [0, h],
            _ => [-h, h],
        }
    }

    /// Columns that it covers in row s.
    fn columns(self, h: isize, s: isize) -> [isize; 2] {
        match self {
            Self::North | Self::South => [-s.abs(), s.abs()],
            Self::East => [s.abs(), h],
            Self::West => [-h, -s.abs()],
            Self::NorthEast => [s, h],
            Self::SouthWest => [-h, s],
            Self::NorthWest => [-h, -s],
            Self::SouthEast => [-s, h],
        }
    }
}

/// A triangle's plane.
struct Plane {
    corners: [Vec3; 3],
    normal: Vec3,
}

/// What a triangle covers.
#[derive(Clone, Copy)]
struct Found {
    /// Largest squared distance.
    error: f32,
    /// Depth of the deepest surface; −1 without any.
    deepest: f32,
    background: bool,
}

impl Found {
    const NOTHING: Self = Self { error: 0.0, deepest: -1.0, background: false };

    fn join(self, other: Self) -> Self {
        Self {
            error: self.error.max(other.error),
            deepest: self.deepest.max(other.deepest),
            background: self.background | other.background,
        }
    }
}

struct Scan<'a> {
    map: &'a DepthMap,
    rays: &'a Rays,
    depth: bool,
}

impl Scan<'_> {
    fn error(&self, x: usize, y: usize, h: usize, shape: Shape) -> f32 {
        let side = self.map.side();
        let reach = h as isize;
        let at = |(dx, dy): (isize, isize)| {
            let (x, y) = (x.wrapping_add_signed(dx * reach), y.wrapping_add_signed(dy * reach));
            self.rays.position(x, y, self.map.depth()[y * side + x])
        };
        let corners = shape.corners().map(at);
        let cut = corners.iter().any(|c| c.z == f32::INFINITY);
        let [a, b, c] = corners;
        let plane = (!cut).then(|| Plane { corners, normal: (b - a).cross(c - a) });
        let [from, to] = shape.rows(reach);
        let rows = |[from, to]: [isize; 2]| {
            let mut found = Found { background: cut, ..Found::NOTHING };
            for s in from..=to {
                let [left, right] = shape.columns(reach, s).map(|c| x.wrapping_add_signed(c));
                self.row(y.wrapping_add_signed(s), left, right, plane.as_ref(), &mut found);
            }
            found
        };
        let found = if to - from < 2 * ROWS {
            rows([from, to])
        } else {
            let chunks = (to - from) / ROWS + 1;
            let chunk = |i: isize| rows([from + i * ROWS, (from + i * ROWS + ROWS - 1).min(to)]);
            (0..chunks).into_par_iter().map(chunk).reduce(|| Found::NOTHING, Found::join)
        };
        let diagonal = shape as u8 > Shape::West as u8;
        match found.background && found.deepest >= 0.0 {
            true => found.error.max(across(self.rays, h, diagonal, found.deepest)),
            false => found.error,
        }
    }

    fn row(&self, y: usize, left: usize, right: usize, plane: Option<&Plane>, found: &mut Found) {
        let side = self.map.side();
        let depths = &self.map.depth()[y * side + left..=y * side + right];
        let Some(Plane { corners: [a, ..], normal }) = plane else {
            for &z in depths {
                found.deepest = found.deepest.max(if z < f32::INFINITY { z } else { -1.0 });
            }
            return;
        };
        for (x, &z) in (left..).zip(depths) {
            if z == f32::INFINITY {
                found.background = true;
                continue;
            }
            found.deepest = found.deepest.max(z);
            // q/s is the distance along the ray in planar depth; with the ray's length it bounds the distance from above.
            let ray = self.rays.direction(x, y);
            let p = self.rays.position(x, y, z);
            let (q, s) = (normal.dot(p - a), normal.dot(ray));
            let (q, s) = (q * q, s * s);
            if self.depth {
                if q > found.error * s {
                    found.error = found.error.max(q / s);
                }
            } else if !(q * ray.length_squared() <= found.error * s) {
                found.error = found.error.max(squared_distance(plane, p));
            }
        }
    }
}

/// Squared distance of a point from a triangle.
fn squared_distance(plane: Option<&Plane>, p: Vec3) -> f32 {
    let Some(Plane { corners: [a, b, c], normal }) = plane else { return 0.0 };
    let (a, b, c) = (*a, *b, *c);
    let area = normal.length_squared();
    let inside =
        area > 0.0 && [(a, b), (b, c), (c, a)].into_iter().all(|(s, e)| (e - s).cross(p - s).dot(*normal) >= 0.0);
    if inside {
        let d = (p - a).dot(*normal);
        return d * (d / area);
    }
    let to_edge = |s: Vec3, e: Vec3| {
        let (d, q) = (e - s, p - s);
        let length = d.length_squared();
        let t = if length > 0.0 { (d.dot(q) / length).clamp(0.0, 1.0) } else { 0.0 };
        (q - d * t).length_squared()
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}
