//! The selection and weights of section 6.2.

use super::*;
use glam::DVec3;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_4, PI};

/// The direction at the angle β from +X.
fn at(beta: f64) -> DVec3 {
    DVec3::new(libm::cos(beta), libm::sin(beta), 0.0)
}

#[test]
fn the_angular_weight_is_the_papers() {
    for degrees in 0..=180 {
        let beta = f64::from(degrees) * PI / 180.0;
        let expect = match degrees {
            0..45 => 1.0,
            45..135 => libm::cos(beta - FRAC_PI_4),
            _ => 0.0,
        };
        let found = angular_weight(DVec3::X, at(beta));
        assert!((found - expect).abs() < 1e-9, "{degrees}°: {found} {expect}");
        assert_eq!(found > 0.0, degrees < 135, "{degrees}°");
    }
}

#[test]
fn five_of_six_faces_are_selected_at_most() {
    let dmesh = captured(&solids(), 9);
    let count = |d: DVec3| select(&dmesh, &towards(&solids(), d, 9), Weights::Positional).len();
    assert_eq!(count(DVec3::X), 5);
    assert_eq!(count(DVec3::ONE), 6 - 3 + 3 * usize::from(angular_weight(DVec3::NEG_ONE.normalize(), DVec3::X) > 0.0));
    let alone = Dmesh { references: dmesh.references[..1].to_vec(), ..dmesh.clone() };
    assert_eq!(select(&alone, &towards(&solids(), DVec3::NEG_X, 9), Weights::Uniform), []);
    let seen = select(&alone, &towards(&solids(), DVec3::X, 9), Weights::Angular);
    assert_eq!(seen, [Selected { reference: 0, weight: 1.0 }]);
}

fn direction() -> impl Strategy<Value = DVec3> {
    let unit = |(x, y, z)| DVec3::new(x, y, z).normalize_or(DVec3::X);
    (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(unit)
}

proptest! {
    /// A step of δ in the angle changes the angular weight by at most δ: its slope is between −1 and 0.
    #[test]
    fn angular_weights_are_continuous(beta in 0.0..PI, step in 0.0..0.1f64) {
        let change = angular_weight(DVec3::X, at(beta)) - angular_weight(DVec3::X, at((beta + step).min(PI)));
        prop_assert!((-1e-9..=step + 1e-9).contains(&change), "{beta} {step}: {change}");
    }

    #[test]
    fn weights_add_up_to_one(d in direction(), distance in 0.0..9.0f64, which in 0..3usize) {
        let weights = [Weights::Positional, Weights::Angular, Weights::Uniform][which];
        let dmesh = six();
        let view = View::look_at(d * distance, DVec3::ZERO, DVec3::Y, 1.0, 9, 9, 0.1, 9.0);
        let view = View { forward: -d, ..view };
        let selected = select(&dmesh, &view, weights);
        prop_assert!(!selected.is_empty());
        prop_assert!((selected.iter().map(|s| s.weight).sum::<f64>() - 1.0).abs() < 1e-12);
        prop_assert!(selected.iter().all(|s| s.weight > 0.0));
    }

    /// A small motion of the view changes every weight a little, whether a reference comes or goes.
    #[test]
    fn weights_follow_the_view(d in direction(), side in direction(), distance in 1.0..9.0f64) {
        let dmesh = six();
        let of = |d: DVec3| {
            let view = View { forward: -d, ..View::look_at(d * distance, DVec3::ZERO, DVec3::Y, 1.0, 9, 9, 0.1, 9.0) };
            let mut all = [0.0; 6];
            select(&dmesh, &view, Weights::Positional).iter().for_each(|s| all[s.reference] = s.weight);
            all
        };
        let step = 1e-4;
        let (a, b) = (of(d), of((d + side * step).normalize()));
        // The distance weight is steepest beside a reference's eye: 1/(0.01 diagonal) per metre.
        let bound = step * 20.0 * distance.max(1.0) / (0.01 * dmesh.diagonal);
        prop_assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < bound), "{a:?} {b:?}");
    }
}

/// References without meshes on six sides.
pub fn six() -> Dmesh {
    let references = scenes::SIDES.map(|(name, d)| {
        let r = square(name, d * 3.0, DVec3::ZERO, [0; 3], 1.0);
        Reference { mesh: Default::default(), ..r }
    });
    Dmesh { references: references.to_vec(), epsilon: 0.01, diagonal: 2.0, double_sided: false }
}
