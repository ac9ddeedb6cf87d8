//! What certificates say about stand-ins whose errors are known.

use super::*;
use crate::{
    array::Array,
    math::Stop,
    raster::Cpu,
    scene::{Material, Mesh, Object, Part, Scene},
    voxel::Cell,
};
use glam::{DVec3, Mat4, Vec3};
use std::sync::Arc;

/// Side of a wall in metres and in cells of its grid.
const SIDE: f32 = 10.0;
const CELLS: u32 = 80;

/// An upright wall of `CELLS`² squares, `side` metres wide, facing +Z; `keep(x, y)` says which squares are there.
fn wall(name: &str, centre: Vec3, side: f32, keep: impl Fn(u32, u32) -> bool) -> Object {
    let n = CELLS + 1;
    let at = |i: u32| (i as f32 / CELLS as f32 - 0.5) * side;
    let positions: Array<[f32; 3]> = (0..n * n).map(|i| [at(i % n), at(i / n), 0.0]).collect();
    let colors = (0..n * n)
        .map(|i| {
            let g = if (i % n / 5 + i / n / 5).is_multiple_of(2) { 0.2 } else { 0.7 };
            [g, g * 0.8, 0.3, 1.0]
        })
        .collect();
    let squares = (0..CELLS * CELLS).map(|i| (i % CELLS, i / CELLS)).filter(|(x, y)| keep(*x, *y));
    let triangles = squares
        .flat_map(|(x, y)| {
            let i = y * n + x;
            [[i, i + 1, i + n], [i + 1, i + n + 1, i + n]]
        })
        .collect();
    let mesh = Arc::new(Mesh { positions, colors, triangles, ..Mesh::default() });
    Object {
        name: name.into(),
        transform: Mat4::from_translation(centre),
        parts: vec![Part { mesh, material: Arc::new(Material::default()) }],
    }
}

fn scene(objects: Vec<Object>) -> Scene {
    Scene { objects }
}

fn one(centre: Vec3, keep: impl Fn(u32, u32) -> bool) -> Scene {
    scene(vec![wall("wall", centre, SIDE, keep)])
}

const PLACE: Vec3 = Vec3::new(0.0, 0.0, -20.0);
const CELL: Cell = Cell { centre: DVec3::ZERO, half: DVec3::splat(0.5) };

fn options(bound: f64) -> Options {
    Options {
        sampling: Sampling { views: 9, seed: 1, resolution: 160, fov: 45_f64.to_radians() },
        samples_per_axis: 2,
        shading: Choice::Auto,
        bound: Bound { kind: "test".into(), value: bound, unit: "px".into() },
        stand_in: StandIn { name: String::new(), blake3: String::new() },
        bytes: 0,
        ceiling_views: 64,
    }
}

fn judge(original: &Scene, stand_in: &Scene, bound: f64) -> Certificate {
    compare(original, stand_in, None, &CELL, &options(bound), &Cpu, &Stop::default()).unwrap().certificate
}

/// Pixels that a metre at the wall spans, about.
fn px_per_metre() -> f64 {
    160.0 / (2.0 * libm::tan(22.5_f64.to_radians()) * 20.0)
}

#[test]
fn a_scene_is_its_own_perfect_stand_in() {
    let s = scene(vec![
        wall("a", PLACE, SIDE, |x, _| x % 7 != 0),
        wall("b", Vec3::new(1.0, 2.0, -26.0), 20.0, |_, _| true),
    ]);
    let result = compare(&s, &s, Some(&s), &CELL, &options(2.0), &Cpu, &Stop::default()).unwrap();
    let c = &result.certificate;
    for f in [&c.figures, &c.ceiling.as_ref().unwrap().figures] {
        assert_eq!((f.psnr_y_db.min, f.psnr_y_object_db.min), (100.0, 100.0));
        assert_eq!((f.ssim.min, f.ssim_object.min), (1.0, 1.0));
        assert_eq!((f.missing_px.max, f.extra_px.max, f.wrong_surface_px.max, f.in_front_px.max), (0.0, 0.0, 0.0, 0.0));
        assert_eq!((f.crack_px.total, f.band.differing_ratio, f.max_deviation_px), (0, 0.0, 0.0));
        assert!(f.band.share > 0.1 && f.covered_px.mean > 1000.0);
    }
    assert_eq!((c.flip.views, c.flip.max), (8, 0.0));
    assert_eq!(c.views, 9);
    assert!(c.worst_view["missing_px"].picture.is_none());
}

#[test]
fn a_shifted_wall_misses_and_adds_a_strip() {
    let shift = 0.5;
    let c = judge(&one(PLACE, |_, _| true), &one(PLACE + Vec3::X * shift, |_, _| true), 1.0);
    let f = &c.figures;
    let strip = f64::from(shift) * px_per_metre() * f64::from(SIDE) * px_per_metre();
    for total in [f.missing_px.mean + f.band.missing_px.mean, f.extra_px.mean + f.band.extra_px.mean] {
        assert!((total / strip - 1.0).abs() < 0.1, "{total} px of {strip}");
    }
    // A bound of one pixel leaves out at most the two outermost columns.
    assert!(f.missing_px.mean > 0.4 * strip);
    assert!((f.max_deviation_px - f64::from(shift) * px_per_metre()).abs() < 1.0, "{}", f.max_deviation_px);
    assert_eq!(f.crack_px.total, 0);
    let wide = judge(&one(PLACE, |_, _| true), &one(PLACE + Vec3::X * shift, |_, _| true), 5.5).figures;
    assert_eq!((wide.missing_px.max, wide.extra_px.max), (0.0, 0.0));
    assert!(wide.band.differing_ratio > 0.05);
}

#[test]
fn a_missing_column_is_a_crack() {
    // A square is 1.2 px wide.
    let c = judge(&one(PLACE, |_, _| true), &one(PLACE, |x, _| x != 40), 2.0);
    let column = f64::from(SIDE) * px_per_metre();
    assert!(c.figures.crack_px.total as f64 >= 9.0 * 0.85 * column, "{} of {column}", c.figures.crack_px.total);
    assert!(c.figures.missing_px.mean >= 0.85 * column && c.figures.wrong_surface_px.max == 0.0);
    assert!(c.worst_view["crack_px"].picture.is_some());
}

#[test]
fn a_hole_at_the_silhouette_lies_in_the_band_and_is_no_crack() {
    let c = judge(&one(PLACE, |_, _| true), &one(PLACE, |x, _| x != 0), 2.0);
    assert_eq!((c.figures.crack_px.total, c.figures.missing_px.max), (0, 0.0));
    assert!(c.figures.band.missing_px.mean > 50.0);
}

#[test]
fn a_wall_pushed_back_is_a_wrong_surface() {
    let back = scene(vec![wall("wall", PLACE * 2.0, SIDE * 2.0, |_, _| true)]);
    let f = judge(&one(PLACE, |_, _| true), &back, 2.0).figures;
    assert!(f.wrong_surface_px.mean > 0.8 * f.covered_px.mean, "{f:?}");
    assert_eq!(f.crack_px.total, 0);
    let reverse = judge(&back, &one(PLACE, |_, _| true), 2.0).figures;
    assert!(reverse.in_front_px.mean > 0.6 * reverse.covered_px.mean, "{reverse:?}");
    // 1 % farther shows as at most 1.3 px from the farthest corner.
    let little = scene(vec![wall("wall", PLACE * 1.01, SIDE * 1.01, |_, _| true)]);
    let f = judge(&one(PLACE, |_, _| true), &little, 2.0).figures;
    assert_eq!((f.wrong_surface_px.max, f.missing_px.max), (0.0, 0.0));
}

#[test]
fn a_crack_in_front_of_the_ground_is_caught_by_depth() {
    let with = |keep: fn(u32, u32) -> bool| {
        scene(vec![wall("ground", Vec3::new(0.0, 0.0, -60.0), 36.0, |_, _| true), wall("wall", PLACE, SIDE, keep)])
    };
    let f = judge(&with(|_, _| true), &with(|x, _| x != 40), 2.0).figures;
    let column = f64::from(SIDE) * px_per_metre();
    assert_eq!(f.missing_px.max, 0.0);
    assert!(f.wrong_surface_px.mean >= 0.85 * column, "{f:?}");
    assert!(f.crack_px.total as f64 >= 9.0 * 0.85 * column, "{f:?}");
}

#[test]
fn steep_ground_displaced_within_the_bound_is_right() {
    // Ground seen at a grazing angle, 1.5 m below the cell; lowered by a centimetre its depth changes by a metre far away.
    let ground = |y: f32| {
        let mut o = wall("ground", Vec3::ZERO, 200.0, |_, _| true);
        o.transform =
            Mat4::from_translation(Vec3::new(0.0, y, -110.0)) * Mat4::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        scene(vec![o])
    };
    let f = judge(&ground(-1.5), &ground(-1.51), 2.0).figures;
    assert_eq!((f.wrong_surface_px.max, f.in_front_px.max, f.crack_px.total), (0.0, 0.0, 0), "{f:?}");
    let low = judge(&ground(-1.5), &ground(-3.0), 2.0).figures;
    assert!(low.wrong_surface_px.mean > 1000.0, "{low:?}");
}

#[test]
fn steep_ground_cut_off_deviates_by_what_is_cut() {
    // 6 m wide; rows of half a metre are missing at the near end, which is seen from 0.5 to 1.5 m above and 9.5 to 10.5 m away.
    let ground = |cut: u32| {
        let mut o = wall("ground", Vec3::ZERO, 40.0, |_, y| y >= cut);
        o.transform = Mat4::from_translation(Vec3::new(0.0, -1.0, -30.0))
            * Mat4::from_rotation_x(-std::f32::consts::FRAC_PI_2)
            * Mat4::from_scale(Vec3::new(0.15, 1.0, 1.0));
        scene(vec![o])
    };
    // Seen from height h the ground at distance z lies h/z below the horizon; the nearest and highest corner sees most of it.
    let pixel = 2.0 * libm::tan(22.5_f64.to_radians()) / 160.0;
    for cut in [1, 2, 8] {
        let moved = 1.0 / 9.5 - 1.0 / (9.5 + 0.5 * f64::from(cut));
        // The rows cut off, and how far the corners 3.5 m aside move; those are thin wedges between pixel centres.
        let (rows, corner) = (1.5 * moved / pixel, libm::hypot(1.5, 3.5) * moved / pixel);
        let f = judge(&ground(0), &ground(cut), 1.0).figures;
        let found = f.max_deviation_px;
        assert!(rows - 1.0 <= found && found <= corner + 4.0, "{cut}: {found}, {rows} to {corner}");
    }
}

#[test]
fn a_back_side_is_reported() {
    let mut turned = one(PLACE, |_, _| true);
    turned.objects[0].transform *= Mat4::from_rotation_y(std::f32::consts::PI);
    let f = judge(&one(PLACE, |_, _| true), &turned, 2.0).figures;
    assert!(f.back_facing_px.mean > 0.95 * f.covered_px.mean);
    assert_eq!(f.missing_px.max, 0.0);
}

#[test]
fn empty_and_unseen_stand_ins_fail() {
    let s = one(PLACE, |_, _| true);
    let run = |a: &Scene, b: &Scene| compare(a, b, None, &CELL, &options(2.0), &Cpu, &Stop::default());
    assert!(matches!(run(&s, &Scene::default()), Err(CompareError::EmptyStandIn)));
    assert!(matches!(run(&Scene::default(), &s), Err(CompareError::EmptyOriginal)));
    assert!(matches!(run(&s, &one(-PLACE, |_, _| true)), Err(CompareError::Unseen("stand-in", 9))));
}

#[test]
fn colourless_scenes_are_compared_under_noise() {
    let plain = |centre| {
        let mut s = one(centre, |_, _| true);
        let mesh = Arc::make_mut(&mut s.objects[0].parts[0].mesh);
        mesh.colors = Array::default();
        s
    };
    let same = judge(&plain(PLACE), &plain(PLACE), 2.0);
    assert!(same.shading.starts_with("noise"), "{}", same.shading);
    assert_eq!(same.figures.psnr_y_object_db.min, 100.0);
    let moved = judge(&plain(PLACE), &plain(PLACE * 1.1), 2.0);
    assert!(moved.figures.psnr_y_object_db.mean < 40.0);
}

#[test]
fn certificates_have_equal_bytes_on_any_number_of_threads() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let shifted = one(PLACE + Vec3::new(0.3, 0.1, -0.5), |x, _| x != 9);
            compare(&one(PLACE, |_, _| true), &shifted, None, &CELL, &options(2.0), &Cpu, &Stop::default()).unwrap()
        })
    };
    let (a, b) = (run(1), run(3));
    assert_eq!(a.certificate.to_json(), b.certificate.to_json());
    assert_eq!(a.pictures, b.pictures);
    let keys =
        ["\"psnr_y_db\"", "\"missing_px\"", "\"crack_px\"", "\"worst_view\"", "\"ceiling\": null", "\"shading\""];
    assert!(keys.iter().all(|k| a.certificate.to_json().contains(k)));
}
