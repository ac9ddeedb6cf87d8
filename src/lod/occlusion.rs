//! The self-occluding error: how large a hole may open when an object that shows only what the centre of a cell sees is seen from
//! elsewhere in the cell (Chen et al. 2003, section 3.1.2).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the error is estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Estimate {
    /// The paper's formula, which is no bound: it looks from one place of the cell, and leaves out the angle of the pixels.
    Paper,
    /// The largest error from anywhere in the cell, at the edge of the picture.
    #[default]
    Bound,
}

/// An object before a cell, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// c: radius of the cell about its centre, > 0.
    pub c: f64,
    /// d: from the centre to the nearest point of the object.
    pub d: f64,
    /// l: the object's depth, ≥ 0.
    pub l: f64,
}

/// s in pixels, for pictures of `image_res` pixels that show 60°. Infinite where the object reaches the cell.
///
/// Paper: s = √3·c·l / (2d·(d + l)) · ImageRes. Bound: with f = ImageRes·√3/2 pixels per unit of the tangent and the eye at angle φ from the line
/// across, s = max over φ of f·c·cosφ·l / ((d − c·sinφ)(d + l − c·sinφ)), times 4/3, since a pixel at the edge of a picture of 60° is that much
/// larger on the picture plane.
pub fn self_occluding_error(at: Distance, image_res: f64, estimate: Estimate) -> f64 {
    let Distance { c, d, l } = at;
    let half_root = 3.0_f64.sqrt() * 0.5;
    match estimate {
        Estimate::Paper if d > 0.0 => half_root * c * l / (d * (d + l)) * image_res,
        Estimate::Bound if d > c => {
            let t = worst_sine(at);
            let (near, far) = (d - c * t, d + l - c * t);
            image_res * half_root * c * (1.0 - t * t).sqrt() * l / (near * far) * 4.0 / 3.0
        }
        _ => f64::INFINITY,
    }
}

/// t = sinφ where √(1 − t²) / ((d − ct)(d + l − ct)) is largest: the root of its logarithm's derivative
/// −t/(1 − t²) + c/(d − ct) + c/(d + l − ct), by halving. Multiplied by (1 − t²)(d − ct)(d + l − ct) > 0 this is a cubic that falls from a positive value at 0
/// to a negative one at 1. It has one root between: the other two lie below 0 and above 1, where it ends at −∞ and +∞.
fn worst_sine(Distance { c, d, l }: Distance) -> f64 {
    let rises = |t: f64| c * (1.0 - t * t) * (2.0 * (d - c * t) + l) > t * (d - c * t) * (d + l - c * t);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if rises(middle) { low = middle } else { high = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use proptest::prelude::*;

    #[test]
    fn the_papers_formula() {
        let at = Distance { c: 50.0, d: 400.0, l: 40.0 };
        let s = self_occluding_error(at, 1024.0, Estimate::Paper);
        assert!((s - 3.0_f64.sqrt() * 50.0 * 40.0 / (2.0 * 400.0 * 440.0) * 1024.0).abs() < 1e-9);
        assert_eq!(self_occluding_error(Distance { d: 50.0, ..at }, 1024.0, Estimate::Bound), f64::INFINITY);
        assert_eq!(self_occluding_error(Distance { l: 0.0, ..at }, 1024.0, Estimate::Bound), 0.0);
    }

    proptest! {
        /// Two points on one ray of the centre, at d and d + l, are seen apart by no more than the bound from any eye of the circle.
        #[test]
        fn no_eye_sees_a_larger_hole(
            c in 0.1..50.0_f64, further in 1.02..20.0_f64, l in 0.0..100.0_f64,
            angle in 0.0..std::f64::consts::TAU, r in 0.0..1.0_f64, turn in -0.5..0.5_f64,
        ) {
            let at = Distance { c, d: c * further, l };
            let bound = self_occluding_error(at, 1024.0, Estimate::Bound);
            let eye = DVec2::new(libm::cos(angle), libm::sin(angle)) * c * r;
            let (p, q) = (DVec2::X * at.d - eye, DVec2::X * (at.d + l) - eye);
            // A picture of 60° that has both points: pixels of the tangent along its axis.
            let middle = (p.normalize() + q.normalize()).normalize();
            let axis = DVec2::from_angle(turn).rotate(middle);
            let (tp, tq) = (axis.perp_dot(p) / axis.dot(p), axis.perp_dot(q) / axis.dot(q));
            let edge = 1.0 / 3.0_f64.sqrt();
            prop_assume!(axis.dot(p) > 0.0 && axis.dot(q) > 0.0 && tp.abs() <= edge && tq.abs() <= edge);
            let pixels = (tp - tq).abs() * 1024.0 * 3.0_f64.sqrt() * 0.5;
            prop_assert!(pixels <= bound * (1.0 + 1e-9) + 1e-9, "{pixels} > {bound}");
        }

        #[test]
        fn the_maximum_is_the_largest_of_many(c in 0.1..50.0_f64, further in 1.01..30.0_f64, l in 0.01..100.0_f64) {
            let at = Distance { c, d: c * further, l };
            let g = |t: f64| (1.0 - t * t).sqrt() / ((at.d - c * t) * (at.d + l - c * t));
            let best = (0..2000).map(|i| g(f64::from(i) / 2000.0)).fold(0.0, f64::max);
            prop_assert!(g(worst_sine(at)) >= best * (1.0 - 1e-9));
        }
    }
}
