//! What a triangulation of a depth map deviates by, at every grid point.

use super::{map::DepthMap, rays::Rays, selection::Selection};
use crate::math::squared_distance;

/// Largest deviations over the grid points that triangles cover.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// Distance of a grid point from the triangle that stands in for it, metres.
    pub distance: f64,
    /// Difference of planar depth, metres.
    pub depth: f64,
    /// Grid points that are covered and no background.
    pub covered: usize,
}

/// Compares triangles, whose corners are grid points (y · side + x) that are no background, with all grid points that they cover.
pub fn measure(map: &DepthMap, triangles: impl IntoIterator<Item = [u32; 3]>) -> Measured {
    let side = map.side();
    let rays = Rays::new(map.view());
    let position = |x: usize, y: usize| rays.position(x, y, map.depth()[y * side + x]).as_dvec3();
    let mut found = Measured::default();
    let mut covered = Selection::new(side);
    for triangle in triangles {
        let corners = triangle.map(|i| (i as usize % side, i as usize / side));
        let [a, b, c] = corners.map(|(x, y)| position(x, y));
        let normal = (b - a).cross(c - a);
        let (first, last) = corners.iter().fold((side, 0), |(f, l), &(_, y)| (f.min(y), l.max(y)));
        for y in first..=last {
            let Some((left, right)) = columns(&corners, y) else { continue };
            for x in left..=right {
                if map.depth()[y * side + x] == f32::INFINITY {
                    continue;
                }
                let (p, ray) = (position(x, y), rays.direction(x, y).as_dvec3());
                let depth = (normal.dot(p - a) / normal.dot(ray)).abs();
                // A point at the eye lies on every ray.
                found.depth = found.depth.max(if depth.is_finite() { depth } else { 0.0 });
                found.distance = found.distance.max(squared_distance([a, b, c], p));
                found.covered += usize::from(covered.insert(x, y));
            }
        }
    }
    Measured { distance: found.distance.sqrt(), ..found }
}

/// The first and last grid point of row y that a triangle covers, its border included.
fn columns(corners: &[(usize, usize); 3], y: usize) -> Option<(usize, usize)> {
    let (mut left, mut right) = (i64::MAX, i64::MIN);
    let y = y as i64;
    for i in 0..3 {
        let [(x0, y0), (x1, y1)] = [corners[i], corners[(i + 1) % 3]].map(|(x, y)| (x as i64, y as i64));
        if y < y0.min(y1) || y > y0.max(y1) {
            continue;
        }
        if y0 == y1 {
            left = left.min(x0.min(x1));
            right = right.max(x0.max(x1));
        } else {
            let (run, rise) = ((x1 - x0) * (y - y0), y1 - y0);
            let floor = run.div_euclid(rise) + if rise < 0 && run.rem_euclid(rise) != 0 { -1 } else { 0 };
            left = left.min(x0 + floor + i64::from(floor * rise != run));
            right = right.max(x0 + floor);
        }
    }
    (left <= right).then_some((left as usize, right as usize))
}
