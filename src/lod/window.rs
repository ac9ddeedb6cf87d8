//! Cameras that look at one object, from a cell's centre or from a neighbour's: crops of the pictures that the cell's windows would show.

use super::outline::Outline;
use crate::view::{Projection, View};
use glam::{DAffine3, DVec3};

/// A camera and what it looks at, all about its eye: cells that look at an object from the same point have equal ones.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowCamera {
    /// Objects by name, each with its place.
    pub members: Vec<(String, DAffine3)>,
    /// The eye is the origin.
    pub view: View,
}

/// Pixels around the object.
const MARGIN: f64 = 2.0;
/// The largest tangent of the angle between the axis and a corner: beyond it pixels at the edge are five times as large as in the middle.
const WIDEST: f64 = 2.0;
/// Pixels along a side, at most.
const MOST: f64 = 4096.0;

/// The camera at `eye` whose picture is just as large as the outline, with `focal` pixels per unit of the tangent. `None` where the eye is too near:
/// the outline would fill more than 126° of what it sees, or 4096 pixels.
pub fn window(outline: &Outline, eye: DVec3, focal: f64) -> Option<View> {
    let forward = (outline.centre() - eye).try_normalize()?;
    let side = forward.cross(DVec3::Y);
    // Straight up or down: any direction is as good as another.
    let right = if side.length_squared() > 1e-12 { side.normalize() } else { DVec3::X };
    let up = right.cross(forward);
    let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let (mut near, mut far) = (f64::INFINITY, 0.0_f64);
    for corner in outline.corners() {
        let d = corner - eye;
        let z = d.dot(forward);
        if z <= 0.0 {
            return None;
        }
        for (k, t) in [d.dot(right) / z, d.dot(up) / z].into_iter().enumerate() {
            (min[k], max[k]) = (min[k].min(t), max[k].max(t));
        }
        (near, far) = (near.min(z), far.max(z));
    }
    if min.iter().chain(&max).any(|t| t.abs() > WIDEST) {
        return None;
    }
    // Whole pixels, with the outline in their middle.
    let size: [f64; 2] = std::array::from_fn(|k| ((max[k] - min[k]) * focal + 2.0 * MARGIN).ceil());
    if size.iter().any(|n| *n > MOST) {
        return None;
    }
    let ends = |k: usize| {
        let (middle, half) = ((min[k] + max[k]) * 0.5, size[k] * 0.5 / focal);
        (middle - half, middle + half)
    };
    let ((left, right_end), (bottom, top)) = (ends(0), ends(1));
    Some(View {
        eye,
        right,
        up,
        forward,
        projection: Projection::Perspective { left, right: right_end, bottom, top },
        width: size[0] as u32,
        height: size[1] as u32,
        near: near * 0.5,
        far: far * 2.0,
    })
}

/// Pixels per unit of the tangent of a picture of 60° with `image_res` pixels a side.
pub fn focal(image_res: f64) -> f64 {
    image_res * 3.0_f64.sqrt() * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn the_picture_holds_the_outline_with_its_margin() {
        let plan = [(-3.0, -2.0), (3.0, -2.0), (3.0, 2.0), (-3.0, 2.0)];
        let outline =
            Outline { plan: plan.iter().map(|(x, z)| DVec2::new(20.0 + x, 5.0 + z)).collect(), low: -1.0, high: 4.0 };
        let view = window(&outline, DVec3::new(0.0, 1.0, 0.0), 300.0).unwrap();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for c in outline.corners() {
            let (x, y, z) = view.project(c);
            assert!(view.near < z && z < view.far);
            for (k, v) in [x, y].into_iter().enumerate() {
                (low[k], high[k]) = (low[k].min(v), high[k].max(v));
            }
        }
        for (k, n) in [view.width, view.height].into_iter().enumerate() {
            assert!((MARGIN..MARGIN + 0.51).contains(&low[k]), "{low:?}");
            assert!((MARGIN..MARGIN + 0.51).contains(&(f64::from(n) - high[k])), "{high:?}");
        }
        assert_eq!(window(&outline, DVec3::new(17.5, 1.0, 5.0), 300.0), None, "inside");
        assert_eq!(window(&outline, DVec3::new(16.9, 1.0, 5.0), 300.0), None, "too near");
    }
}
