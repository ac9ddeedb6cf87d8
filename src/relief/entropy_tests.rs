//! Viewpoint entropy against analytic values and counts of fine pictures.

use super::entropy::{Probe, Seen, Sight};
use crate::{
    math::Stop,
    raster::{
        Cpu, Geometry, NOTHING, Options, nearest,
        tests::{mesh, octahedron, scene},
    },
    scene::{Mesh, Scene},
    view::directions,
};
use glam::DVec3;
use std::collections::BTreeMap;

/// A cube from −1 to 1, two triangles a side, facing outwards.
pub fn cube() -> Mesh {
    let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 1 { 1.0 } else { -1.0 });
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<_> = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    mesh(&(0..8).map(corner).collect::<Vec<_>>(), &triangles)
}

pub fn look(scene: &Scene, direction: DVec3, ids: u32) -> Sight {
    let geometry = Geometry::new(scene);
    let points = scene.points();
    Probe::new(&Cpu, &geometry, &points, ids).unwrap().sight(direction.normalize(), &Stop::default()).unwrap()
}

fn bits(areas: &[f64]) -> f64 {
    let background = 1.0 - areas.iter().sum::<f64>();
    -areas.iter().chain([&background]).filter(|p| **p > 0.0).map(|p| p * libm::log2(*p)).sum::<f64>()
}

/// By the letter: counts of pixels in a picture fine enough for its faces.
fn literal(scene: &Scene, direction: DVec3, ids: u32) -> f64 {
    let points = scene.points();
    let bounds: crate::math::Aabb = points.iter().copied().collect();
    let radius = points.iter().map(|p| p.distance(bounds.centre())).fold(0.0, f64::max);
    let view = directions::look_along_sphere(bounds.centre(), radius, direction.normalize(), ids, 0.0);
    let shown = nearest(&Cpu, &Geometry::new(scene), &view, &Options::default(), &Stop::default()).unwrap();
    let mut counts = BTreeMap::new();
    shown.triangle.iter().filter(|t| **t != NOTHING).for_each(|t| *counts.entry(*t).or_insert(0.0) += 1.0);
    bits(&counts.values().map(|n| n / f64::from(ids * ids)).collect::<Vec<_>>())
}

#[test]
fn a_cube_along_an_axis_and_its_diagonal() {
    let cube = scene(cube());
    // The square around the bounding sphere of radius √3 has the area 12.
    let diagonal = 2.0 / 3.0_f64.sqrt() / 12.0;
    for (direction, areas) in [
        (DVec3::X, vec![2.0 / 12.0; 2]),
        (-DVec3::Y, vec![2.0 / 12.0; 2]),
        (DVec3::ONE, vec![diagonal; 6]),
        (DVec3::new(1.0, 1.0, 0.0), vec![2.0_f64.sqrt() / 12.0; 4]),
    ] {
        let sight = look(&cube, direction, 512);
        assert_eq!(sight.faces.len(), areas.len(), "{direction}");
        let (found, expected) = (sight.entropy(), bits(&areas));
        assert!((found - expected).abs() < 5e-3, "{direction}: {found} {expected}");
    }
}

#[test]
fn small_faces_do_not_saturate() {
    // 8192 faces, of which half are seen: their areas are known, the sphere is convex.
    let ball = scene(octahedron(5));
    let direction = DVec3::new(0.3, 0.5, -0.8).normalize();
    let geometry = Geometry::new(&ball);
    let area = |t: u32| {
        let [a, b, c] = geometry.positions(t);
        (b - a).cross(c - a).dot(direction) * 0.125
    };
    let areas: Vec<f64> = (0..geometry.triangle_count()).map(area).filter(|a| *a > 0.0).collect();
    let exact = bits(&areas);
    let [coarse, fine] = [64, 256].map(|ids| look(&ball, direction, ids).entropy());
    assert!((coarse - exact).abs() < 0.1 && (fine - exact).abs() < 0.05, "{coarse} {fine} {exact}");
    // Counts of as few pixels are far off.
    assert!(literal(&ball, direction, 64) < exact - 0.2);
    assert!((literal(&ball, direction, 2048) - exact).abs() < 0.02);
}

#[test]
fn what_hides_and_what_is_hidden() {
    for name in ["solids", "car"] {
        let scene = crate::scene::builtin::make(name, 1).unwrap();
        for direction in [DVec3::new(0.2, 0.3, 1.0), DVec3::new(-1.0, 0.1, 0.2), DVec3::new(0.4, -0.9, 0.1)] {
            let (found, expected) = (look(&scene, direction, 512).entropy(), literal(&scene, direction, 4096));
            assert!((found - expected).abs() < 0.02 * expected, "{name} {direction}: {found} {expected}");
        }
    }
}

#[test]
fn what_a_turn_reveals() {
    let cube = scene(cube());
    let (front, corner) = (look(&cube, DVec3::X, 256), look(&cube, DVec3::ONE, 256));
    let mut seen = Seen::none(12);
    seen.add(&front);
    assert_eq!(seen.count(), 2);
    let expected = 4.0 * 2.0 / 3.0_f64.sqrt() / 12.0;
    assert!((corner.beyond(&seen) - expected).abs() < 5e-3);
    assert_eq!(front.beyond(&seen), 0.0);
}

#[test]
fn a_single_triangle_from_all_sides() {
    let card = scene(mesh(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]));
    assert!(look(&card, DVec3::Z, 64).entropy() > 0.5 && look(&card, -DVec3::Z, 64).faces.len() == 1);
    for edge in [DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0)] {
        let sight = look(&card, edge, 64);
        assert!(sight.faces.is_empty() && sight.entropy() == 0.0);
    }
    let point = scene(mesh(&[[1.0; 3]], &[[0, 0, 0]]));
    assert_eq!(look(&point, DVec3::X, 64).entropy(), 0.0);
    let geometry = Geometry::new(&Scene::default());
    assert!(Probe::new(&Cpu, &geometry, &[], 64).is_none());
}
