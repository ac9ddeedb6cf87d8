//! The error of each grid point as its distance from the edge that it bisects (section 4.2).

use super::{grid::Grid, map::DepthMap, options::Distance, rays::Rays};
use glam::Vec3;
use rayon::prelude::*;

/// Squared distances, metres². Corners have none. Where only some of a point and the ends of its edge are background, the error is the
/// length of the edge across the view: unselected, the triangles that touch background are cut, and the outline recedes by
/// that much at most.
pub(super) fn edge_errors(map: &DepthMap, rays: &Rays, distance: Distance) -> Vec<f32> {
    match distance {
        Distance::Planar => levels(map, rays, planar),
        Distance::Full => levels(map, rays, full),
        Distance::Depth => levels(map, rays, depth),
    }
}

/// Which edges a point may bisect.
#[derive(Clone, Copy, PartialEq)]
enum Edge {
    Horizontal,
    Vertical,
    Diagonal,
}

/// A grid point with its depth.
#[derive(Clone, Copy)]
struct Sample {
    x: usize,
    y: usize,
    z: f32,
}

fn levels(
    map: &DepthMap,
    rays: &Rays,
    distance: impl Fn(&Rays, Edge, Sample, Sample, Sample) -> f32 + Sync,
) -> Vec<f32> {
    let side = map.side();
    let (z, n) = (map.depth(), side - 1);
    let mut errors = vec![0.0; side * side];
    let error = |edge: Edge, h: usize, a: usize, b: usize, p: usize, x: usize, y: usize| {
        let (za, zb, zp) = (z[a], z[b], z[p]);
        if za + zb + zp < f32::INFINITY {
            let at = |i: usize, z: f32| match edge {
                Edge::Horizontal if i == a => Sample { x: x - h, y, z },
                Edge::Horizontal if i == b => Sample { x: x + h, y, z },
                Edge::Vertical if i == a => Sample { x, y: y - h, z },
                Edge::Vertical if i == b => Sample { x, y: y + h, z },
                Edge::Diagonal if i != p => Sample { x: i % side, y: i / side, z },
                _ => Sample { x, y, z },
            };
            distance(rays, edge, at(a, za), at(b, zb), at(p, zp))
        } else {
            lateral(rays, h, edge == Edge::Diagonal, [za, zb, zp])
        }
    };
    for level in (0..Grid::of(side).k).rev() {
        let h = Grid::of(side).half(level);
        errors.par_chunks_mut(2 * h * side).with_min_len((64 / h).max(1)).enumerate().for_each(|(band, rows)| {
            let y = 2 * h * band;
            for x in (h..n).step_by(2 * h) {
                let p = y * side + x;
                rows[x] = error(Edge::Horizontal, h, p - h, p + h, p, x, y);
            }
            // The last band is the bottom row alone.
            let Some(row) = rows.get_mut(h * side..).filter(|row| !row.is_empty()) else { return };
            let y = y + h;
            for x in (0..=n).step_by(2 * h) {
                let p = y * side + x;
                row[x] = error(Edge::Vertical, h, p - h * side, p + h * side, p, x, y);
            }
            for x in (h..n).step_by(2 * h) {
                let p = y * side + x;
                let across = if (x ^ y) & (2 * h) == 0 { h * side + h } else { h * side - h };
                row[x] = error(Edge::Diagonal, h, p - across, p + across, p, x, y);
            }
        });
    }
    errors
}

/// The squared length across the view of an edge of 2h pixels, 2h√2 if it is diagonal, at the deepest surface among `depths`;
/// 0 where all or none of them are background.
pub(super) fn lateral(rays: &Rays, h: usize, diagonal: bool, depths: [f32; 3]) -> f32 {
    let deepest = depths.into_iter().filter(|z| z.is_finite()).fold(-1.0, f32::max);
    if deepest < 0.0 || depths.iter().all(|z| z.is_finite()) { 0.0 } else { across(rays, h, diagonal, deepest) }
}

/// The squared length across the view of an edge of 2h pixels, 2h√2 if it is diagonal, at depth z.
pub(super) fn across(rays: &Rays, h: usize, diagonal: bool, z: f32) -> f32 {
    let length = 2.0 * h as f32 * rays.pixel(z);
    length * length * if diagonal { 2.0 } else { 1.0 }
}

/// `numerator²/denominator`, 0 for edges without length, without overflow where the result has none.
#[inline]
fn squared(numerator: f32, denominator: f32) -> f32 {
    if denominator > 0.0 { numerator * (numerator / denominator) } else { 0.0 }
}

/// Equation (1).
#[inline]
fn full(rays: &Rays, _: Edge, a: Sample, b: Sample, p: Sample) -> f32 {
    let at = |s: Sample| rays.position(s.x, s.y, s.z);
    point_line(at(a), at(b), at(p))
}

/// Squared distance of p from the line through a and b, equation (1).
#[inline]
pub(super) fn point_line(a: Vec3, b: Vec3, p: Vec3) -> f32 {
    let d = b - a;
    let c = d.cross(b - p);
    let length = d.length_squared();
    // A surface that returns to the same point has no line: the distance is that of points.
    if length > 0.0 { c.dot(c / length) } else { (p - a).length_squared() }
}

/// Equation (2) for edges of rows and columns, (1) for diagonals.
#[inline]
fn planar(rays: &Rays, edge: Edge, a: Sample, b: Sample, p: Sample) -> f32 {
    let across = |s: Sample| match edge {
        Edge::Vertical => rays.y[s.y] * rays.stretch(s.z),
        _ => rays.x[s.x] * rays.stretch(s.z),
    };
    if edge == Edge::Diagonal {
        return full(rays, edge, a, b, p);
    }
    let (ua, ub, up) = (across(a), across(b), across(p));
    let (du, dz) = (ub - ua, b.z - a.z);
    squared(dz * (up - ua) - (p.z - a.z) * du, du * du + dz * dz)
}

/// Along the ray, as a difference of planar depths.
#[inline]
fn depth(rays: &Rays, _: Edge, a: Sample, b: Sample, p: Sample) -> f32 {
    let d = p.z - rays.depth_between(a.z, b.z);
    d * d
}
