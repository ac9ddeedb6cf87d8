//! Grids, packing, mip levels and cards.

use super::*;
use crate::{
    capture::{Capture, Capturing, capture},
    math::{Sequence, Stop},
    raster::{Cpu, Geometry, Shader},
    scene::{Material, Mesh, Object, Part, Scene, builtin},
    view::{Projection, Region, View, enclosing_sphere},
};
use glam::{DVec2, Mat4};
use proptest::prelude::*;
use std::{collections::BTreeMap, sync::Arc};

/// Captures of a scene from all points of a grid, row by row.
pub(crate) fn captured(scene: &Scene, grid: Grid, pixels: u32, margin: f64) -> Vec<(String, Capture)> {
    let geometry = Geometry::new(scene);
    captured_by(&Shader::new(&geometry), scene, grid, pixels, margin)
}

fn captured_by(shader: &Shader, scene: &Scene, grid: Grid, pixels: u32, margin: f64) -> Vec<(String, Capture)> {
    let (centre, radius) = enclosing_sphere(&scene.points()).unwrap();
    let half = radius * f64::from(pixels) / (f64::from(pixels) - 2.0 * margin);
    let take = |i: u32| {
        let (column, row) = (i % grid.side, i / grid.side);
        let direction = grid.direction(column, row);
        let [right, up] = axes(direction);
        let projection = square(half);
        let (eye, forward) = (centre + direction * half, -direction);
        let view =
            View { eye, right, up, forward, projection, width: pixels, height: pixels, near: 0.0, far: 2.0 * half };
        let how = Capturing { layers: 1, backs: false };
        let capture = capture(&Cpu, shader, scene.bounds(), &view, how, &Stop::default()).unwrap();
        (format!("r{row:02}c{column:02}"), capture)
    };
    (0..grid.side * grid.side).map(take).collect()
}

pub(crate) fn packed(captures: &[(String, Capture)], tile: Option<u32>) -> Result<Impostor, PackError> {
    let all: Vec<(&str, &Capture)> = captures.iter().map(|(name, c)| (name.as_str(), c)).collect();
    pack(&all, tile, &Stop::default())
}

pub(crate) fn impostor(scene: &Scene, grid: Grid, pixels: u32, tile: u32) -> Impostor {
    packed(&captured(scene, grid, pixels, 2.0), Some(tile)).unwrap()
}

fn scene_of(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>, base_color: [f32; 4]) -> Scene {
    let mesh = Mesh { positions: positions.into(), triangles: triangles.into(), ..Mesh::default() };
    let material = Material { base_color, double_sided: false, ..Material::default() };
    let part = Part { mesh: Arc::new(mesh), material: Arc::new(material) };
    Scene { objects: vec![Object { name: "o".into(), transform: Mat4::IDENTITY, parts: vec![part] }] }
}

pub(crate) fn cube() -> Scene {
    let corners = Aabb { min: DVec3::new(1.0, 2.0, 3.0), max: DVec3::new(2.0, 3.0, 4.0) }.corners();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|f: &[u32; 4]| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]]).collect();
    scene_of(corners.iter().map(|c| c.as_vec3().to_array()).collect(), triangles, [0.8, 0.2, 0.1, 1.0])
}

pub(crate) fn ball() -> Scene {
    let (columns, rows) = (40_u32, 20_u32);
    let point = |i: u32, j: u32| {
        let (sa, ca) = libm::sincos(std::f64::consts::TAU * f64::from(i) / f64::from(columns));
        let (sb, cb) = libm::sincos(std::f64::consts::PI * f64::from(j) / f64::from(rows));
        (DVec3::new(sb * ca, cb, sb * sa) * 0.7 + DVec3::new(-2.0, 0.5, 1.0)).as_vec3().to_array()
    };
    let positions = (0..=rows).flat_map(|j| (0..columns).map(move |i| point(i, j))).collect();
    let at = |i: u32, j: u32| j * columns + i % columns;
    let quads = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
    let triangles = quads
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    scene_of(positions, triangles, [0.3, 0.9, 0.2, 1.0])
}

/// Weights by direction: points of the border stand for one direction twice.
fn by_direction(grid: Grid, d: DVec3) -> BTreeMap<[i64; 3], f64> {
    let mut out = BTreeMap::new();
    for Pick { column, row, weight } in grid.select(d) {
        let key = (grid.direction(column, row) * 1e6).round().to_array().map(|v| v as i64);
        *out.entry(key).or_insert(0.0) += weight;
    }
    out
}

const GRIDS: [Grid; 5] = [
    Grid { side: 3, hemi: false },
    Grid { side: 8, hemi: false },
    Grid { side: 13, hemi: false },
    Grid { side: 2, hemi: true },
    Grid { side: 12, hemi: true },
];

#[test]
fn a_grid_point_shows_its_own_frame() {
    for grid in GRIDS {
        for i in 0..grid.side * grid.side {
            let d = grid.direction(i % grid.side, i / grid.side);
            assert!((d.length() - 1.0).abs() < 1e-12 && !(grid.hemi && d.y < -1e-12));
            let weights = by_direction(grid, d);
            let own = (d * 1e6).round().to_array().map(|v| v as i64);
            // Below HORIZON the upper half is drawn as from a little above.
            let slack = if d.y < 0.01 && grid.hemi { 0.02 } else { 1e-9 };
            assert!((weights.get(&own).copied().unwrap_or(0.0) - 1.0).abs() < slack, "{grid:?} {d}: {weights:?}");
        }
    }
}

proptest! {
    #[test]
    fn weights_are_barycentric_and_continuous(
        which in 0..GRIDS.len(),
        u in prop::array::uniform3(0.0..1.0_f64),
        step in prop::array::uniform3(-1e-4..1e-4_f64),
    ) {
        let grid = GRIDS[which];
        let sphere = Region::Sphere { centre: DVec3::ZERO, radius: 1.0 };
        let d = sphere.eye(u);
        let near = (d + DVec3::from(step)).normalize();
        let picks = grid.select(d);
        prop_assert!(picks.iter().all(|p| (0.0..=1.0).contains(&p.weight) && p.column < grid.side && p.row < grid.side));
        prop_assert!((picks.iter().map(|p| p.weight).sum::<f64>() - 1.0).abs() < 1e-12);
        let (a, b) = (by_direction(grid, d), by_direction(grid, near));
        let change: f64 = a
            .keys()
            .chain(b.keys().filter(|k| !a.contains_key(*k)))
            .map(|k| (a.get(k).copied().unwrap_or(0.0) - b.get(k).copied().unwrap_or(0.0)).abs())
            .sum();
        // Below the horizon of the upper half all that counts is the heading, which turns ever faster towards straight down.
        let horizontal = libm::hypot(d.x, d.z).min(libm::hypot(near.x, near.z));
        let reach = if grid.hemi { horizontal.max(d.y.min(near.y)).clamp(1e-3, 1.0) } else { 1.0 };
        // Three coordinates change by at most 3·√3 per unit of direction, times half the grid's side.
        let most = d.distance(near) * 12.0 * f64::from(grid.side) / reach;
        prop_assert!(change <= most, "{} for {}", change, d.distance(near));
    }
}

/// The point of the square that the weights stand for is the direction's own.
#[test]
fn weights_give_the_direction_back() {
    let grid = Grid { side: 9, hemi: false };
    let sphere = Region::Sphere { centre: DVec3::ZERO, radius: 1.0 };
    let sequence = Sequence::<3>::new(2);
    for i in 0..500 {
        let d = sphere.eye(sequence.point(i));
        let at: DVec2 = grid
            .select(d)
            .iter()
            .map(|p| DVec2::new(f64::from(p.column), f64::from(p.row)) / 8.0 * 2.0 - 1.0)
            .zip(grid.select(d))
            .map(|(e, p)| e * p.weight)
            .sum();
        assert!(crate::view::directions::from_octahedral(at).distance(d) < 1e-9);
    }
}

#[test]
fn captures_of_another_grid_are_refused() {
    let good = captured(&cube(), GRIDS[0], 32, 2.0);
    let message = |change: &dyn Fn(&mut Vec<(String, Capture)>), tile: Option<u32>| {
        let mut captures = good.clone();
        change(&mut captures);
        packed(&captures, tile).err().map(|e| e.to_string()).unwrap_or_default()
    };
    assert_eq!(message(&|_| {}, Some(32)), "");
    for (change, tile, expect) in [
        (&(|c: &mut Vec<_>| c.truncate(8)) as &dyn Fn(&mut Vec<(String, Capture)>), None, "8 captures; expected"),
        (&|c| c.truncate(4), None, "4 captures; expected"),
        (&|c| c.swap(1, 3), None, "r01c00: looks along"),
        (&|c| c[4].1.view.projection = square(0.5), None, "r01c01: its window is not that"),
        (&|c| c[2].1.view.eye += DVec3::ONE, None, "its window is not that of the other cameras"),
        (&|_| {}, Some(24), "frames of 24 texels"),
        (&|_| {}, Some(8), "frames of 8 texels"),
        (&|_| {}, Some(64), "frames of 64 texels from captures of 32 pixels"),
    ] {
        let found = message(change, tile);
        assert!(found.contains(expect), "{found}; expected {expect}");
    }
}

/// A square window.
fn square(half: f64) -> Projection {
    Projection::Orthographic { left: -half, right: half, bottom: -half, top: half }
}

#[test]
fn frames_are_the_means_of_their_captures() {
    let captures = captured(&cube(), GRIDS[0], 32, 2.0);
    let (full, half) = (packed(&captures, None).unwrap(), packed(&captures, Some(16)).unwrap());
    assert_eq!((full.atlas.side, half.atlas.side, half.grid), (96, 48, GRIDS[0]));
    assert!(full.centre.distance(DVec3::new(1.5, 2.5, 3.5)) < 0.01);
    for (i, (_, capture)) in captures.iter().enumerate() {
        for (at, z) in capture.layers[0].depth.iter().enumerate() {
            let (x, y) = (i % 3 * 32 + at % 32, i / 3 * 32 + at / 32);
            let (color, normal) = (full.atlas.color[y * 96 + x], full.atlas.normal[y * 96 + x]);
            assert_eq!(color[3], if z.is_finite() { 255 } else { 0 });
            if z.is_finite() {
                assert_eq!(color, capture.layers[0].color[at]);
                let p = capture.view.unproject(at as f64 % 32.0 + 0.5, (at / 32) as f64 + 0.5, f64::from(*z));
                let height = (p - full.centre).dot(-capture.view.forward);
                assert!((full.height(normal[3]) - height).abs() <= full.radius / 255.0 * 1.01, "{height}");
            }
        }
    }
    let covered = |a: &Atlas| a.color.iter().map(|t| f64::from(t[3])).sum::<f64>() / f64::from(a.side * a.side);
    assert!((covered(&full.atlas) - covered(&half.atlas)).abs() < 0.3);
    // A round outline covers parts of texels.
    let ball = packed(&captured(&ball(), GRIDS[0], 32, 2.0), Some(16)).unwrap();
    assert!(ball.atlas.color.iter().any(|t| t[3] > 0 && t[3] < 255));
}

/// Of a red cube every texel is red, covered or not, on every level; normals are units and heights those of the cube.
#[test]
fn empty_texels_are_dilated() {
    let impostor = impostor(&cube(), GRIDS[1], 64, 32);
    let red = captured(&cube(), GRIDS[0], 16, 2.0)[4].1.layers[0].color.iter().copied().find(|t| t[3] > 0).unwrap();
    let all = levels(&impostor);
    assert_eq!(all.len(), 4);
    for level in &all {
        assert!(level.color.iter().all(|t| t[..3] == red[..3]), "a texel of another colour");
        for n in level.normal.iter() {
            let length = DVec3::from([n[0], n[1], n[2]].map(|c| f64::from(c) / 127.5 - 1.0)).length();
            assert!((length - 1.0).abs() < 0.02 && n[3].abs_diff(128) < 121, "{n:?}");
        }
    }
}

/// Heights reach a few texels beyond an outline and are those of the plane through the centre beyond.
#[test]
fn heights_are_dilated_a_little() {
    let side = 64;
    let frame = packed(&captured(&cube(), GRIDS[0], side, 20.0), None).unwrap();
    let (atlas, width) = (&frame.atlas, 3 * side as usize);
    let (mut near, mut far) = (0, 0);
    for i in 0..(side * side) as usize {
        let (x, y) = ((i % side as usize) as i64, (i / side as usize) as i64);
        let covers = |x: i64, y: i64| {
            (0..64).contains(&x) && (0..64).contains(&y) && atlas.color[y as usize * width + x as usize][3] > 0
        };
        let reached = (-4..=4).any(|v| (-4..=4).any(|u| covers(x + u, y + v)));
        let height = atlas.normal[y as usize * width + x as usize][3];
        if reached {
            near += usize::from(height != 128);
        } else {
            assert_eq!(height, 128);
            far += 1;
        }
    }
    assert!(near > 100 && far > 100, "{near} and {far}");
}

#[test]
fn materials_are_packed_where_they_were_captured() {
    let mut scene = cube();
    let material = Material { roughness: 0.25, metallic: 1.0, emissive: [0.0, 1.0, 0.0], ..Material::default() };
    scene.objects[0].parts[0].material = Arc::new(material);
    let take = |scene: &Scene| captured_by(&Shader::with_finishes(&Geometry::new(scene)), scene, GRIDS[0], 32, 2.0);
    let shining = take(&scene);
    let atlas = packed(&shining, Some(16)).unwrap().atlas;
    // Dilated, so everywhere.
    assert!(atlas.orm.unwrap().iter().all(|t| *t == [255, 64, 255, 255]));
    assert!(atlas.emissive.unwrap().iter().all(|t| *t == [0, 255, 0, 255]));
    // Without light of its own no atlas, without materials neither.
    let dark = packed(&take(&cube()), None).unwrap().atlas;
    assert!(dark.orm.is_some() && dark.emissive.is_none());
    let plain = captured(&scene, GRIDS[0], 32, 2.0);
    assert!(packed(&plain, None).unwrap().atlas.orm.is_none());
    let mut mixed = plain;
    mixed[3] = shining[3].clone();
    let message = packed(&mixed, None).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains("r01c00: images of materials, other than the first"), "{message}");
}

/// Each frame's levels are those of a frame alone: changing one frame changes no texel of another.
#[test]
fn levels_mix_no_frames() {
    let before = impostor(&builtin::make("solids", 1).unwrap(), GRIDS[0], 32, 32);
    let mut after = before.clone();
    let side = after.atlas.side as usize;
    let invert = |image: &Array<[u8; 4]>| -> Array<[u8; 4]> {
        let inside = |i: usize| (i % side) / 32 == 1 && (i / side) / 32 == 1;
        image.iter().enumerate().map(|(i, t)| if inside(i) { t.map(|c| 255 - c) } else { *t }).collect()
    };
    after.atlas.color = invert(&after.atlas.color);
    after.atlas.normal = invert(&after.atlas.normal);
    for (a, b) in levels(&before).iter().zip(levels(&after)) {
        let (side, tile) = (a.side as usize, a.side as usize / 3);
        let mut changed = 0;
        for i in 0..side * side {
            let differs = a.color[i] != b.color[i] || a.normal[i] != b.normal[i];
            let own = (i % side) / tile == 1 && (i / side) / tile == 1;
            assert!(own || !differs, "texel {i} of the level with frames of {tile}");
            changed += usize::from(differs);
        }
        assert!(changed > 0);
    }
}

#[test]
fn levels_keep_coverage_and_colour() {
    let impostor = impostor(&builtin::make("solids", 1).unwrap(), GRIDS[1], 64, 64);
    let all = levels(&impostor);
    assert_eq!(all.iter().map(|l| l.side / 8).collect::<Vec<_>>(), [64, 32, 16, 8, 4]);
    let mean = |l: &Atlas, k: usize| {
        let value = |t: &[u8; 4]| f64::from(crate::image::srgb::to_linear(t[k]));
        let weight = |t: &[u8; 4]| f64::from(t[3]);
        l.color.iter().map(|t| value(t) * weight(t)).sum::<f64>() / l.color.iter().map(weight).sum::<f64>()
    };
    // Of each frame: what passes the test of alpha.
    let passes = |l: &Atlas, column: usize, row: usize| {
        let tile = l.side as usize / 8;
        let at = |i: usize| (row * tile + i / tile) * l.side as usize + column * tile + i % tile;
        (0..tile * tile).filter(|i| l.color[at(*i)][3] >= 128).count() as f64 / (tile * tile) as f64
    };
    for level in &all {
        // Half a texel of a frame; more may pass, because equal alphas pass together.
        let side = f64::from(level.side);
        let half = 32.0 / (side * side) + 1e-9;
        for i in 0..64 {
            let (found, expect) = (passes(level, i % 8, i / 8), passes(&all[0], i % 8, i / 8));
            assert!(
                found >= expect - half && found <= expect + 0.08 + half,
                "{found} of {expect} in frames of {}",
                level.side / 8
            );
        }
        assert!((0..3).all(|k| (mean(level, k) - mean(&all[0], k)).abs() < 0.01));
    }
}

#[test]
fn the_card_holds_the_object_from_everywhere() {
    for (scene, hemi) in [(cube(), false), (builtin::make("car", 1).unwrap(), false), (ball(), true)] {
        let impostor = impostor(&scene, Grid { side: 6, hemi }, 64, 64);
        assert!(impostor.card.len() <= 8 && crate::mesh::card::area(&corners(&impostor)) > 0.0);
        let region = Region::Sphere { centre: DVec3::ZERO, radius: 1.0 };
        let sequence = Sequence::<3>::new(5);
        for i in 0..300 {
            let d = region.eye(sequence.point(i));
            let d = if hemi { DVec3 { y: d.y.abs(), ..d } } else { d };
            let [right, up] = axes(d);
            for p in scene.points() {
                let p = (p - impostor.centre) / impostor.radius;
                let p = DVec2::new(p.dot(right), p.dot(up));
                let c = corners(&impostor);
                let inside = (0..c.len()).all(|k| {
                    let (a, b) = (c[k], c[(k + 1) % c.len()]);
                    (b - a).perp_dot(p - a) >= 0.0
                });
                assert!(inside, "{p} lies beside {c:?}, seen from {d}");
            }
        }
    }
    // A ball's card is an octagon around its disc, whose radius is 60/64 and two texels: 8·tan(π/8)·r².
    let area = crate::mesh::card::area(&corners(&impostor(&ball(), GRIDS[1], 64, 64)));
    assert!((3.1..3.6).contains(&area), "{area}");
}

fn corners(impostor: &Impostor) -> Vec<DVec2> {
    impostor.card.iter().map(|c| DVec2::from(*c)).collect()
}

#[test]
fn an_object_that_is_not_seen_gives_an_empty_impostor() {
    let mut captures = captured(&cube(), GRIDS[0], 16, 2.0);
    let nothing = crate::capture::Layer {
        depth: vec![f32::INFINITY; 256].into(),
        color: vec![[0; 4]; 256].into(),
        normal: vec![[0; 4]; 256].into(),
        object: vec![u32::MAX; 256].into(),
        triangle: vec![u32::MAX; 256].into(),
        orm: Default::default(),
        emissive: Default::default(),
    };
    captures.iter_mut().for_each(|c| c.1.layers = vec![nothing.clone()]);
    let empty = packed(&captures, None).unwrap();
    assert_eq!(empty.card.len(), 4);
    assert!(empty.atlas.color.iter().all(|t| t[3] == 0));
}
