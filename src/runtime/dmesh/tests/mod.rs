//! Tests of how a DMesh is drawn, and the DMeshes that they share.

mod blending;
mod bundle;
mod looks;
pub mod scenes;
mod weights;

use super::*;
use crate::{
    math::Stop,
    raster::Rendering,
    scene::{Scene, builtin},
    view::View,
};
use scenes::{captured, reference, square, towards};

fn one_sample() -> Rendering {
    Rendering::default().with_samples(1)
}

fn draw(dmesh: &Dmesh, view: &View, how: &Rendering) -> Drawn {
    Model::new(dmesh.clone()).unwrap().draw(view, how, &Blending::default(), &Stop::default()).unwrap()
}

fn solids() -> Scene {
    builtin::make("solids", 1).unwrap()
}

/// Greatest difference of two texels.
fn far(a: &[u8; 4], b: &[u8; 4]) -> u32 {
    a.iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(*b))).max().unwrap_or(0)
}
