//! From where a stand-in is judged: views drawn from the whole region, such as a view cell.
//!
//! The region's extremes come first (the eight corners of a cell), because errors peak there; the rest follow a low-discrepancy
//! sequence over the region. Every picture has the same field of view and resolution, so that a pixel subtends the angle
//! δ = 2·tan(fov/2)/resolution that the stand-in was made for, wherever it looks:
//! - at the centre of the selection's box, where the selection fits into the picture from there;
//! - in an axis of the picture in which it does not fit, the sequence turns the view over the angles that the
//!   selection spans, so that all of it is judged by some view;
//! - where the selection lies around the region, the sequence chooses among the directions in which it is seen.

use crate::{
    math::{Aabb, Sequence},
    view::{Region, View},
};
use glam::DVec3;

/// How views are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// Number of views; the region's extremes (a cell's eight corners) are always among them, so at least as many are drawn.
    pub views: u32,
    pub seed: u64,
    /// Width and height of a picture in pixels.
    pub resolution: u32,
    /// Field of view of a picture, radians.
    pub fov: f64,
}

impl Sampling {
    /// The angle δ of a pixel in the middle of a picture, radians.
    pub fn pixel_angle(&self) -> f64 {
        2.0 * libm::tan(self.fov * 0.5) / f64::from(self.resolution)
    }
}

/// A selection whose box spans more than this from the direction to its centre, seen from an extreme of the region,
/// counts as lying around the region.
const AROUND: f64 = 80.0 * std::f64::consts::PI / 180.0;

/// True where some of the selection lies so far aside of its centre that one direction cannot aim at all of it.
pub fn surrounds(region: &Region, selection: &Aabb) -> bool {
    let limit = libm::cos(AROUND);
    region.extremes().iter().any(|eye| {
        let forward = (selection.centre() - *eye).normalize_or_zero();
        selection.corners().iter().any(|p| (*p - *eye).normalize_or_zero().dot(forward) < limit)
    })
}

/// The views. `selection` bounds the original, `all` original and stand-in; neither is empty.
/// `seen`: directions from the region's middle in which the original is seen, with their solid angles; used where
/// the selection [`surrounds`] the region and then not empty.
pub fn draw(region: &Region, selection: &Aabb, all: &Aabb, seen: &[(DVec3, f64)], sampling: &Sampling) -> Vec<View> {
    let around = surrounds(region, selection) && !seen.is_empty();
    let sequence = Sequence::<5>::new(sampling.seed);
    let first = region.extremes();
    (0..sampling.views.max(first.len() as u32))
        .map(|i| {
            let u = sequence.point(i);
            let eye = first.get(i as usize).copied().unwrap_or_else(|| region.eye([u[0], u[1], u[2]]));
            let forward = if around { pick(seen, u[3]) } else { aim(eye, selection, sampling.fov, [u[3], u[4]]) };
            let (near, far) = depths(eye, all, sampling.fov);
            let n = sampling.resolution;
            View::look_at(eye, eye + forward, DVec3::Y, sampling.fov, n, n, near, far)
        })
        .collect()
}

/// A direction from `eye` at the selection; `u` turns it where the selection is larger than the picture.
fn aim(eye: DVec3, selection: &Aabb, fov: f64, u: [f64; 2]) -> DVec3 {
    let centre = View::look_at(eye, selection.centre(), DVec3::Y, fov, 1, 1, 1.0, 2.0);
    let turn = |axis: DVec3, u: f64| {
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for p in selection.corners() {
            let d = p - eye;
            let angle = libm::atan2(d.dot(axis), d.dot(centre.forward));
            (lo, hi) = (lo.min(angle), hi.max(angle));
        }
        let half = fov * 0.5;
        if lo >= -half && hi <= half {
            0.0
        } else if hi - lo <= fov {
            (lo + hi) * 0.5
        } else {
            let (first, last) = (lo + half, hi - half);
            // Stretched, so that the ends of the selection are seen as often as what lies between them.
            let u = (1.5 * u - 0.25).clamp(0.0, 1.0);
            (first + u * (last - first)).clamp(-AROUND, AROUND)
        }
    };
    let (x, y) = (turn(centre.right, u[0]), turn(centre.up, u[1]));
    (centre.forward + centre.right * libm::tan(x) + centre.up * libm::tan(y)).normalize()
}

/// The direction at place `u` in [0, 1) of the directions laid side by side by solid angle.
fn pick(seen: &[(DVec3, f64)], u: f64) -> DVec3 {
    let mut left = u * seen.iter().map(|s| s.1).sum::<f64>();
    for (direction, weight) in seen {
        left -= weight;
        if left < 0.0 {
            return *direction;
        }
    }
    seen[seen.len() - 1].0
}

/// Planar depths that hold all of `all` that a picture from `eye` can show.
fn depths(eye: DVec3, all: &Aabb, fov: f64) -> (f64, f64) {
    let t = libm::tan(fov * 0.5);
    let farthest = all.corners().iter().map(|p| p.distance(eye)).fold(0.0, f64::max);
    let nearest = eye.clamp(all.min, all.max).distance(eye);
    let far = (farthest * 1.01).max(f64::MIN_POSITIVE);
    ((0.99 * nearest / (1.0 + 2.0 * t * t).sqrt()).max(far * 1e-5), far)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::Cell;

    const SAMPLING: Sampling = Sampling { views: 40, seed: 7, resolution: 64, fov: 0.785 };

    const CELL: Cell = Cell { centre: DVec3::ZERO, half: DVec3::new(1.0, 2.0, 3.0) };

    fn region() -> Region {
        Region::Box(CELL)
    }

    fn cube(centre: DVec3, half: f64) -> Aabb {
        Aabb { min: centre - half, max: centre + half }
    }

    #[test]
    fn corners_come_first_and_all_eyes_lie_in_the_cell() {
        let target = cube(DVec3::new(0.0, 0.0, -40.0), 5.0);
        let views = draw(&region(), &target, &target, &[], &SAMPLING);
        assert_eq!(views.len(), 40);
        for (view, corner) in views.iter().zip(CELL.corners()) {
            assert_eq!(view.eye, corner);
        }
        assert!(views.iter().all(|v| (v.eye.abs().cmple(CELL.half)).all()));
    }

    #[test]
    fn a_selection_that_fits_is_whole_in_every_picture() {
        let target = cube(DVec3::new(3.0, -2.0, -40.0), 5.0);
        for v in draw(&region(), &target, &target, &[], &SAMPLING) {
            for p in target.corners() {
                let (x, y, z) = v.project(p);
                assert!((0.0..=64.0).contains(&x) && (0.0..=64.0).contains(&y), "{x} {y}");
                assert!(v.near <= z && z <= v.far);
            }
        }
    }

    #[test]
    fn a_wide_selection_is_covered_by_the_views_together() {
        let target = Aabb { min: DVec3::new(-60.0, -2.0, -45.0), max: DVec3::new(60.0, 2.0, -40.0) };
        let views = draw(&region(), &target, &target, &[], &SAMPLING);
        for i in 0..=20 {
            let p = DVec3::new(-60.0 + 6.0 * f64::from(i), 0.0, -40.0);
            let seen = views.iter().any(|v| {
                let (x, y, z) = v.project(p);
                z > 0.0 && (0.0..=64.0).contains(&x) && (0.0..=64.0).contains(&y)
            });
            assert!(seen, "nothing looks at {p}");
        }
    }

    #[test]
    fn a_cell_inside_its_selection_looks_where_it_is_seen() {
        let target = cube(DVec3::ZERO, 10.0);
        assert!(surrounds(&region(), &target));
        let seen = [(DVec3::X, 1.0), (-DVec3::X, 3.0)];
        let views = draw(&region(), &target, &target, &seen, &SAMPLING);
        let left = views.iter().filter(|v| v.forward.distance(-DVec3::X) < 1e-9).count();
        assert!((27..=33).contains(&left), "{left} of 40");
    }
}
