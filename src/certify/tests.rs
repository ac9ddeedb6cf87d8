//! What certificates say about stand-ins whose errors are known.

use super::{about::MODES, modes::ModeView, *};
use crate::{
    array::Array,
    math::Stop,
    raster::{Cpu, Geometry},
    runtime::SceneStandIn,
    scene::{Alpha, Material, Mesh, Object, Part, Scene},
    view::{Cell, Region},
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
        viewing: Viewing {
            sampling: Sampling { views: 9, seed: 1, resolution: 160, fov: 45_f64.to_radians() },
            samples_per_axis: 2,
            shading: Choice::Auto,
        },
        bound: Bound { kind: "test".into(), value: bound, unit: "px".into(), held: false },
        stand_in: Subject { name: String::new(), blake3: String::new() },
        bytes: 0,
        ceiling: None,
        may_be_unseen: false,
    }
}

fn run(a: &Scene, b: &Scene, ceiling: Option<&Scene>, bound: f64) -> Result<Comparison, CompareError> {
    let context = Context { backend: &Cpu, stop: &Stop::default(), progress: &|_, _| {} };
    compared(a, b, ceiling, &options(bound), context)
}

/// Two scenes compared as the command line does, from [`CELL`].
fn compared(
    original: &Scene,
    stand_in: &Scene,
    ceiling: Option<&Scene>,
    options: &Options,
    context: Context,
) -> Result<Comparison, CompareError> {
    let geometry = Geometry::new(stand_in);
    let drawn = SceneStandIn::new(stand_in, &geometry);
    let modes = [Mode { name: String::new(), stand_in: &drawn }];
    let region = Region::Box(CELL);
    let of = |mesh| super::ceiling(original, mesh, &region, &options.viewing, options.bound.value, context);
    let options = Options { ceiling: ceiling.map(of).transpose()?, ..options.clone() };
    compare(original, &modes, &region, &options, context)
}

fn judge(original: &Scene, stand_in: &Scene, bound: f64) -> Certificate {
    run(original, stand_in, None, bound).unwrap().certificate
}

/// Pixels that a metre at the wall spans, about.
fn px_per_metre() -> f64 {
    160.0 / (2.0 * libm::tan(22.5_f64.to_radians()) * 20.0)
}

#[test]
fn of_what_no_view_shows_nothing_differs() {
    let context = Context { backend: &Cpu, stop: &Stop::default(), progress: &|_, _| {} };
    // Less than a hundredth of a pixel, between pixel centres.
    let speck = |size| scene(vec![wall("speck", Vec3::new(0.013, 0.017, -400.0), size, |_, _| true)]);
    let (original, stand_in) = (speck(1e-5), speck(2e-5));
    let strict = compared(&original, &stand_in, None, &options(2.0), context).unwrap_err();
    assert!(strict.to_string().contains("the original is seen from none of the 9 views"), "{strict}");
    let lenient = Options { may_be_unseen: true, ..options(2.0) };
    let c = compared(&original, &stand_in, None, &lenient, context).unwrap().certificate;
    assert_eq!(c.verdict, Verdict::Indistinguishable);
    assert_eq!(
        (c.figures.covered_px.max, c.figures.psnr_y_object_db.min, c.figures.ssim_object.min),
        (0.0, 100.0, 1.0)
    );
    // What is shown where nothing was is an error of its own.
    let large = scene(vec![wall("wall", PLACE, SIDE, |_, _| true)]);
    let c = compared(&original, &large, None, &lenient, context).unwrap().certificate;
    assert_eq!(c.verdict, Verdict::Failed);
}

#[test]
fn a_scene_is_its_own_perfect_stand_in() {
    let s = scene(vec![
        wall("a", PLACE, SIDE, |x, _| x % 7 != 0),
        wall("b", Vec3::new(1.0, 2.0, -26.0), 20.0, |_, _| true),
    ]);
    let result = run(&s, &s, Some(&s), 2.0).unwrap();
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
fn overdraw_tells_what_the_alpha_test_discards() {
    let whole = |z: f32| wall("wall", PLACE + Vec3::Z * z, SIDE, |_, _| true);
    let mut cut = whole(0.0);
    let part = &mut cut.parts[0];
    let mesh = Arc::make_mut(&mut part.mesh);
    let quarter = |i: usize| i as u32 % (CELLS + 1) < CELLS / 4;
    mesh.colors = mesh.colors.iter().enumerate().map(|(i, c)| [c[0], c[1], c[2], f32::from(!quarter(i))]).collect();
    part.material = Arc::new(Material { alpha: Alpha::Mask { cutoff: 0.5 }, ..Material::default() });
    let overdraw = |objects: Vec<Object>| {
        let o = judge(&one(PLACE, |_, _| true), &scene(objects), 2.0).overdraw.unwrap();
        assert_eq!(o.views, 8);
        (o.opaque, o.transparent)
    };
    assert_eq!(overdraw(vec![whole(0.0)]), (1.0, 0.0));
    let near = |(opaque, transparent): (f64, f64), expected: [f64; 2]| {
        assert!(
            (opaque - expected[0]).abs() < 0.02 && (transparent - expected[1]).abs() < 0.02,
            "{opaque} {transparent}"
        );
    };
    near(overdraw(vec![cut.clone()]), [1.0, 1.0 / 3.0]);
    // Whichever is in front: hidden surfaces count, and so do transparent ones behind.
    for z in [-0.1, 0.1] {
        near(overdraw(vec![cut.clone(), whole(z)]), [1.75, 0.25]);
    }
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
    assert_eq!(c.worst_view["crack_px"].picture.as_deref(), Some("worst-crack"));
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

/// A wall with thin upright wires before it, each at `shift` metres from its place, or none of them.
fn with_wires(shift: Option<f32>) -> Scene {
    let mut objects = vec![wall("wall", Vec3::new(0.0, -4.0, -20.0), SIDE, |_, _| true)];
    for (i, shift) in (0..6).zip(std::iter::repeat(shift)).filter_map(|(i, s)| Some((i, s?))) {
        // About 1.5 px wide, and above the wall for half their height.
        let mut wire = wall(&format!("wire {i}"), Vec3::ZERO, SIDE, |_, _| true);
        let place = Vec3::new(i as f32 * 1.4 - 3.5 + shift, 0.0, -19.0);
        wire.transform = Mat4::from_translation(place) * Mat4::from_scale(Vec3::new(0.016, 1.0, 1.0));
        objects.push(wire);
    }
    scene(objects)
}

#[test]
fn wires_that_vanish_are_lost_and_wires_that_move_are_not() {
    let original = with_wires(Some(0.0));
    let gone = judge(&original, &with_wires(None), 3.0);
    assert!(gone.verdict >= Verdict::Visible, "{}", gone.sentence);
    assert!(gone.sentence.contains("vanish"), "{}", gone.sentence);
    let lost = gone.figures.lost_detail_px;
    // All of it lies inside the band, where no other count would tell it from an outline that moved.
    assert!(lost.ratio > 0.02 && lost.band_ratio == lost.ratio && gone.figures.missing_px.max == 0.0, "{lost:?}");
    assert_eq!(gone.worst_view["lost_detail_px"].picture.as_deref(), Some("worst-lost-detail"));

    let two_px = (2.0 / px_per_metre()) as f32;
    let moved = judge(&original, &with_wires(Some(two_px)), 3.0);
    assert!(moved.verdict <= Verdict::Good, "{}", moved.sentence);
    assert_eq!(moved.figures.lost_detail_px.max, 0.0);
    assert!(moved.figures.band.missing_px.mean > 100.0 && moved.bound.held);
}

#[test]
fn verdicts_follow_the_figures_and_say_which() {
    let whole = one(PLACE, |_, _| true);
    let same = judge(&whole, &whole, 2.0);
    assert_eq!((same.verdict, same.bound.held), (Verdict::Indistinguishable, true));
    let holes = judge(&whole, &one(PLACE, |x, y| !(30..50).contains(&x) || !(30..50).contains(&y)), 2.0);
    assert_eq!(holes.verdict, Verdict::Failed);
    assert!(holes.sentence.contains("holes cover"), "{}", holes.sentence);
    let cracked = judge(&whole, &one(PLACE, |x, y| x != 40 || y > 40), 2.0);
    assert!(cracked.verdict >= Verdict::Visible && cracked.figures.crack_px.ratio > 2e-5, "{}", cracked.sentence);
    // Every figure that decides is in the certificate with its limits, and is explained.
    let json: serde_json::Value = serde_json::from_str(&cracked.to_json()).unwrap();
    let first: Vec<&String> = json.as_object().unwrap().keys().collect();
    assert!(cracked.to_json().starts_with("{\n  \"verdict\": \""), "{first:?}");
    for r in json["requirements"].as_array().unwrap() {
        let path = r["measure"].as_str().unwrap();
        let value = path.split('.').try_fold(&json, |v, name| v.get(name)).and_then(serde_json::Value::as_f64);
        assert_eq!(value, r["value"].as_f64(), "{path}");
        assert!(json["about"][path]["about"].is_string(), "{path}");
    }
}

#[test]
fn a_deviation_beyond_the_bound_is_said() {
    let shift = judge(&one(PLACE, |_, _| true), &one(PLACE + Vec3::X * 0.5, |_, _| true), 1.0);
    assert!(!shift.bound.held && shift.sentence.contains("more than the 1 px meant"), "{}", shift.sentence);
}

#[test]
fn a_certificate_has_no_number_that_is_not_explained() {
    fn numbers(value: &serde_json::Value, path: &str, found: &mut Vec<String>) {
        match value {
            serde_json::Value::Object(members) => {
                for (name, v) in members {
                    let inner = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                    numbers(v, &inner, found);
                }
            }
            serde_json::Value::Number(_) => found.push(path.to_owned()),
            _ => {}
        }
    }
    let s = one(PLACE, |_, _| true);
    let mut certificate = run(&s, &s, Some(&s), 2.0).unwrap().certificate;
    let (modes, explained_before) = (MODES.map(|m| m.0.to_owned()), certificate.about.len());
    certificate.modes = modes.into_iter().map(|m| (m, ModeFigures::of(&[ModeView::default()]))).collect();
    certificate.judge();
    assert!(certificate.about.len() > explained_before);
    let json: serde_json::Value = serde_json::from_str(&certificate.to_json()).unwrap();
    let mut found = Vec::new();
    numbers(&json, "", &mut found);
    // How the views were drawn, where the worst are, and where they lie in their pictures, judge nothing.
    found.retain(|p| !["sampling.", "worst_view.", "panels."].iter().any(|beginning| p.starts_with(beginning)));
    let mut explained: Vec<&str> = measures().iter().map(|m| m.path.as_str()).collect();
    explained.sort_unstable();
    found.sort_unstable();
    assert_eq!(found, explained);
}

#[test]
fn a_stand_in_that_is_heavier_says_so() {
    let light = one(PLACE, |x, y| x < 40 || y < 40);
    let said = |a: &Scene, b: &Scene| {
        judge(a, b, 2.0).summary.iter().any(|line| line.starts_with("heavier than the original: 12,800 triangles"))
    };
    assert!(said(&light, &one(PLACE, |_, _| true)));
    assert!(!said(&one(PLACE, |_, _| true), &light));
}

#[test]
fn any_number_of_samples_is_compared() {
    let s = one(PLACE, |_, _| true);
    for samples_per_axis in [1, 2, 3, 5, 6] {
        let mut options = options(2.0);
        options.viewing.samples_per_axis = samples_per_axis;
        let context = Context { backend: &Cpu, stop: &Stop::default(), progress: &|_, _| {} };
        assert_eq!(compared(&s, &s, None, &options, context).unwrap().certificate.verdict, Verdict::Indistinguishable);
    }
}

#[test]
fn the_views_that_are_done_are_told() {
    let s = one(PLACE, |_, _| true);
    let most = std::sync::Mutex::new((0, 0));
    let progress = |done: u64, total: u64| {
        let mut most = most.lock().unwrap();
        *most = (most.0.max(done), total);
    };
    let context = Context { backend: &Cpu, stop: &Stop::default(), progress: &progress };
    compared(&s, &s, None, &options(2.0), context).unwrap();
    assert_eq!(*most.lock().unwrap(), (9, 9));
}

#[test]
fn a_back_side_is_reported() {
    let two = |turn: f32, double_sided: bool| {
        let mut near = wall("near", PLACE, SIDE, |_, _| true);
        near.transform *= Mat4::from_rotation_y(turn);
        near.parts[0].material = Arc::new(Material { double_sided, ..Material::default() });
        // Something to see wherever the wall faces.
        scene(vec![wall("far", PLACE + Vec3::new(6.0, 0.0, 0.0), SIDE, |_, _| true), near])
    };
    let half = std::f32::consts::PI;
    let (facing, turned) = (two(0.0, false), two(half, false));
    let f = judge(&facing, &turned, 2.0).figures;
    assert!(f.back_facing_px.mean > 0.3 * f.covered_px.mean, "{f:?}");
    assert!(f.missing_px.mean > 0.0, "what engines do not draw is missing: {f:?}");
    // Both sides of the same wall, and a wall that shows its back in both scenes.
    for (a, b, backs) in [(&facing, &two(half, true), false), (&turned, &turned, true)] {
        let f = judge(a, b, 2.0).figures;
        assert_eq!((f.missing_px.max, f.back_facing_px.max > 0.0), (0.0, backs), "{f:?}");
    }
}

#[test]
fn empty_and_unseen_stand_ins_fail() {
    let s = one(PLACE, |_, _| true);
    let run = |a: &Scene, b: &Scene| run(a, b, None, 2.0);
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
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let shifted = one(PLACE + Vec3::new(0.3, 0.1, -0.5), |x, _| x != 9);
            run(&one(PLACE, |_, _| true), &shifted, None, 2.0).unwrap()
        })
    };
    let (a, b) = (on(1), on(3));
    assert_eq!(a.certificate.to_json(), b.certificate.to_json());
    assert_eq!(a.pictures, b.pictures);
    let keys =
        ["\"psnr_y_db\"", "\"missing_px\"", "\"crack_px\"", "\"worst_view\"", "\"ceiling\": null", "\"shading\""];
    assert!(keys.iter().all(|k| a.certificate.to_json().contains(k)));
}
