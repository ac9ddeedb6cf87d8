//! Depth maps of a synthetic object and of model files, for benchmarks.

use farfield::{
    depth_mesh::DepthMap,
    formats::{self, DiskFiles, Limits},
    math::{Aabb, Stop},
    raster::{Cpu, Geometry, Options, nearest},
    view::{Projection, View},
};
use glam::DVec3;
use std::path::Path;

/// Depth maps of one object from the six sides of its bounding box.
pub struct Object {
    pub name: String,
    pub bounds: Aabb,
    pub maps: Vec<DepthMap>,
}

const SIDES: [DVec3; 6] = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];

/// A view of 40° from one side, far enough to see the whole sphere around the bounds; or an orthographic one of the whole box.
pub fn view(bounds: &Aabb, from: DVec3, side: u32, perspective: bool) -> View {
    let half = 0.5 * bounds.diagonal();
    let distance = half / libm::sin(20f64.to_radians()) * 1.01;
    let eye = bounds.centre() + from * distance;
    let mut view =
        View::look_at(eye, bounds.centre(), DVec3::Y, 40f64.to_radians(), side, side, 0.01 * half, 4.0 * distance);
    if !perspective {
        let size = bounds.max - bounds.min;
        let across = 0.5 * (size.dot(view.right.abs())).max(size.dot(view.up.abs())) * 1.02;
        view.projection = Projection::Orthographic { left: -across, right: across, bottom: -across, top: across };
    }
    view
}

/// A wavy sphere of radius 1.
pub fn synthetic(side: u32) -> Object {
    let bounds = Aabb { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
    let map = |(i, from): (usize, &DVec3)| {
        let view = view(&bounds, *from, side, true);
        let distance = (view.eye - bounds.centre()).length();
        let phase = i as f64;
        let depth = (0..side * side).map(|at| {
            let [x, y] = [at % side, at / side].map(|c| 2.0 * f64::from(c) / f64::from(side - 1) - 1.0);
            // The outline at 0.9 of the image's half side.
            let r = (x * x + y * y) / 0.81;
            let waves = 0.02 * libm::sin(30.0 * x + phase) * libm::cos(25.0 * y)
                + 0.002 * libm::sin(170.0 * x + 90.0 * y + phase);
            let z = distance - (1.0 - r).max(0.0).sqrt() + waves;
            if r < 1.0 { z as f32 } else { f32::INFINITY }
        });
        DepthMap::new(view, depth.collect()).expect("the view fits the grid")
    };
    Object { name: "wavy sphere".to_owned(), bounds, maps: SIDES.iter().enumerate().map(map).collect() }
}

/// The nearest surfaces of a model file.
pub fn model(path: &Path, side: u32, perspective: bool) -> Result<Object, String> {
    let scene = formats::load(path, &DiskFiles, &Limits::default()).map_err(|e| e.to_string())?;
    let bounds = scene.bounds();
    let geometry = Geometry::new(&scene);
    let map = |from: &DVec3| {
        let view = view(&bounds, *from, side, perspective);
        let seen = nearest(&Cpu, &geometry, &view, &Options::BOTH, &Stop::default()).map_err(|e| e.to_string())?;
        DepthMap::new(view, seen.depth).map_err(|e| e.to_string())
    };
    let maps = SIDES.iter().map(map).collect::<Result<Vec<_>, String>>()?;
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Object { name, bounds, maps })
}
