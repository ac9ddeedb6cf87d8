//! Tests of how impostors are drawn, written and read.

mod bundle;
mod looks;

use super::*;
use crate::{
    octahedral::{
        Grid, Impostor,
        tests::{ball, captured, cube, impostor, packed},
    },
    raster::{Cpu, Rendering},
    runtime::{Context, Shot, StandIn},
    scene::{Scene, builtin},
    view::View,
};
use glam::DVec3;

fn stand_in(impostor: Impostor, steps: u32) -> OctahedralStandIn {
    OctahedralStandIn::new(Model::new(impostor, Drawing { steps }).unwrap())
}

fn draw<'a>(stand_in: &'a OctahedralStandIn, view: &View, how: &Rendering) -> Shot<'a> {
    let stop = crate::math::Stop::default();
    stand_in.draw(view, how, Context { backend: &Cpu, stop: &stop }).unwrap()
}

/// A perspective view towards the scene from the direction `d`, from so many radii away.
pub fn towards(scene: &Scene, d: DVec3, side: u32, distance: f64) -> View {
    let bounds = scene.bounds();
    let (centre, radius) = (bounds.centre(), bounds.diagonal() * 0.5);
    let eye = centre + d.normalize() * radius * distance;
    let fov = 2.2 * libm::asin(1.0 / distance);
    View::look_at(eye, centre, DVec3::Y, fov, side, side, radius * (distance - 1.1), radius * (distance + 1.1))
}
