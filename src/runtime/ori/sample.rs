//! Impostors for tests.

use super::{Drawing, Model, Ori};
use crate::{
    capture::{Capturing, capture},
    math::Stop,
    raster::{Cpu, Geometry, Shader},
    relief::{DepthBits, ReliefMap, Resampling, Strategy, Trace, measure, resample, select::Choice},
    scene::Scene,
    view::directions,
};
use glam::DVec3;

/// An impostor of 20 maps with `side` texels along a side; `glows`: it emits its base colour.
pub(crate) fn impostor(scene: &Scene, side: u32, bits: DepthBits, drawing: Drawing, glows: bool) -> Model {
    let (geometry, stop) = (Geometry::new(scene), Stop::default());
    let shader = Shader::new(&geometry);
    let corners = scene.points();
    let map = |(i, d): (usize, DVec3)| {
        let view = directions::look_along(corners.iter().copied(), d, side * 2, 4.0).unwrap();
        let seen = capture(&Cpu, &shader, scene.bounds(), &view, Capturing { layers: 1, backs: false }, &stop).unwrap();
        let mut map = resample(&seen, Resampling { samples: 2, bits }).unwrap();
        if glows {
            map.emissive = map.color.iter().map(|[r, g, b, _]| [*r, *g, *b, 255]).collect();
        }
        (format!("v{i:02}"), map)
    };
    let maps: Vec<(String, ReliefMap)> = directions::icosahedron().into_iter().enumerate().map(map).collect();
    let named: Vec<(&str, &ReliefMap)> = maps.iter().map(|(n, m)| (&**n, m)).collect();
    let directions = directions::geodesic(1);
    let trace = Trace { wall: drawing.trace.wall, ..Trace::default() };
    let original = measure::Original { geometry: &geometry, corners: &corners, whole: None };
    let coverage = measure::measure(&Cpu, original, &named, directions, 64, trace, &stop).unwrap();
    let selection = coverage.select(Choice::Best { goal: 0.002, neighbours: 0 });
    let ori = Ori {
        directions: selection.directions.clone(),
        subsets: selection.subsets.iter().map(|s| s.maps.clone()).collect(),
        bounds: scene.bounds(),
        plt: selection.plt(),
        drawing,
        maps,
    };
    Model::new(ori).unwrap()
}

/// Pyramids and the default strategy.
pub(crate) fn usual() -> Drawing {
    Drawing { trace: Trace::default(), strategy: Strategy::Direction }
}
