//! Which references are drawn, and how much each counts: section 6.2.

use super::{Dmesh, Reference};
use crate::view::View;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_1_SQRT_2;

/// How the selected references are weighted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Weights {
    /// By direction and distance.
    #[default]
    Positional,
    /// By direction alone.
    Angular,
    /// All alike.
    Uniform,
}

impl Weights {
    /// Name in manifests.
    pub fn name(self) -> &'static str {
        match self {
            Self::Positional => "positional",
            Self::Angular => "angular",
            Self::Uniform => "uniform",
        }
    }

    pub fn named(name: &str) -> Option<Self> {
        [Self::Positional, Self::Angular, Self::Uniform].into_iter().find(|w| w.name() == name)
    }
}

/// A reference that is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Selected {
    /// Index into [`Dmesh::references`].
    pub reference: usize,
    /// w_i, > 0; those of all selected references add up to 1.
    pub weight: f64,
}

/// The angular weight of a reference that looks along the unit vector `v` for a view that looks along `n`: 1 while their angle β is
/// below 45°, then cos(β − 45°); 0, and not selected, from 135° on.
pub fn angular_weight(v: DVec3, n: DVec3) -> f64 {
    let (cos, sin) = (v.dot(n), v.cross(n).length());
    if cos >= sin {
        return 1.0;
    }
    // cos(β − 45°) = (cos β + sin β)/√2.
    let weight = (cos + sin) * FRAC_1_SQRT_2;
    if weight > 1e-9 { weight.min(1.0) } else { 0.0 }
}

/// The weight for the distance d = |e − r_i| between the eyes. The paper leaves the function open: 1/(d + 0.01·diagonal).
pub fn distance_weight(d: f64, diagonal: f64) -> f64 {
    1.0 / (d + 0.01 * diagonal)
}

/// The references that are drawn for `view`, in their order, with weights that add up to 1. None where no reference looks less
/// than 135° away from the view's direction.
pub fn select(dmesh: &Dmesh, view: &View, weights: Weights) -> Vec<Selected> {
    let raw = |r: &Reference| {
        let angular = angular_weight(r.view.forward, view.forward);
        match weights {
            Weights::Positional => angular * distance_weight(view.eye.distance(r.view.eye), dmesh.diagonal),
            Weights::Angular => angular,
            Weights::Uniform => f64::from(u8::from(angular > 0.0)),
        }
    };
    let all: Vec<f64> = dmesh.references.iter().map(raw).collect();
    let sum: f64 = all.iter().sum();
    let some = all.into_iter().enumerate().filter(|(_, w)| *w > 0.0);
    some.map(|(reference, w)| Selected { reference, weight: w / sum }).collect()
}
