//! A field of relief impostors of a model, drawn by the CPU, by a graphics adapter, and as meshes for comparison:
//! `cargo run --release --example impostor_field -- MODEL OUT [COUNT] [SEED] [TEXELS] [WIDTH,HEIGHT]`.
//!
//! MODEL is a scene file or `builtin:NAME`. The impostor is made in memory: 20 maps of TEXELS² (128) from the faces of an icosahedron, and for each of 320
//! directions the smallest subset that misses at most 0.2 % of its viewport. COUNT (1000) instances are turned about Y and spread over a plane by SEED
//! (1). Writes OUT-cpu.png, OUT-gpu.png, OUT-mesh.png and OUT-difference.png, the difference between CPU and adapter times 16, and prints what drawing
//! took. FARFIELD_ADAPTER names the adapter.

use farfield::{
    capture::{Capturing, capture},
    formats::{self, DiskFiles, Limits},
    gpu::{Gpu, Wanted},
    image::{Picture, save_png},
    math::{Sequence, Stop},
    raster::{Cpu, Geometry, Light, Rendering, Shader, Shading, render},
    relief::{
        DepthBits, ReliefMap, Resampling, Strategy, Trace,
        measure::{Original, Selection, measure},
        resample,
        select::Choice,
    },
    runtime::ori::{Drawing, Instance, Model, Ori, draw_instances},
    scene::{Object, Scene},
    view::{View, directions},
};
use glam::{DQuat, DVec3, Mat4};
use std::{error::Error, f64::consts::TAU, path::Path, sync::Arc, time::Instant};

/// Pixels of a capture along a side of a texel.
const SAMPLES: u32 = 4;
/// Pixels of a viewport in which coverage is measured.
const VIEWPORT: u32 = 128;

/// The impostor and how its maps were selected.
fn make(scene: &Scene, texels: u32) -> Result<(Model, Selection), Box<dyn Error>> {
    let (geometry, stop) = (Geometry::new(scene), Stop::default());
    let shader = Shader::new(&geometry);
    let corners: Vec<DVec3> = scene.points();
    let mut maps: Vec<(String, ReliefMap)> = Vec::new();
    for (i, direction) in directions::icosahedron().into_iter().enumerate() {
        let margin = f64::from(2 * SAMPLES);
        let view = directions::look_along(corners.iter().copied(), direction, texels * SAMPLES, margin)
            .ok_or("the scene is empty")?;
        let one = Capturing { layers: 1, backs: false };
        let seen = capture(&Cpu, &shader, scene.bounds(), &view, one, &stop)?;
        maps.push((format!("v{i:02}"), resample(&seen, Resampling { samples: SAMPLES, bits: DepthBits::Eight })?));
    }
    let named: Vec<(&str, &ReliefMap)> = maps.iter().map(|(name, map)| (&**name, map)).collect();
    let trace = Trace::default();
    let directions = directions::geodesic(2);
    let original = Original { geometry: &geometry, corners: &corners, whole: None };
    let coverage = measure(&Cpu, original, &named, directions, VIEWPORT, trace, &stop)?;
    let selection = coverage.select(Choice::Best { goal: 0.002, neighbours: 3 });
    let ori = Ori {
        directions: selection.directions.clone(),
        subsets: selection.subsets.iter().map(|s| s.maps.clone()).collect(),
        bounds: scene.bounds(),
        plt: selection.plt(),
        drawing: Drawing { trace, strategy: Strategy::Direction },
        maps,
    };
    Ok((Model::new(ori)?, selection))
}

/// Instances that stand on the plane y = 0, one in each square of a grid, behind z = 0.
fn spread(scene: &Scene, count: u32, seed: u32) -> Vec<Instance> {
    let bounds = scene.bounds();
    let size = bounds.max - bounds.min;
    let step = size.x.max(size.z) * 1.3;
    let columns = (f64::from(count).sqrt().ceil() as u32).max(1);
    let random = Sequence::<3>::new(u64::from(seed));
    let instance = |i: u32| {
        let [turn, x, z] = random.point(i);
        let rotation = DQuat::from_rotation_y(turn * TAU);
        let column = f64::from(i % columns) - f64::from(columns - 1) * 0.5;
        let at = DVec3::new(column + (x - 0.5) * 0.6, 0.0, -f64::from(i / columns) - z * 0.6) * step;
        let foot = DVec3::new(bounds.centre().x, bounds.min.y, bounds.centre().z);
        Instance { model: 0, rotation, scale: 1.0, translation: at - rotation * foot }
    };
    (0..count).map(instance).collect()
}

/// The same field as meshes.
fn meshes(scene: &Scene, instances: &[Instance]) -> Scene {
    let at = |(i, place): (usize, &Instance)| {
        let turn = Mat4::from_rotation_translation(place.rotation.as_quat(), place.translation.as_vec3());
        let object = move |o: &Object| Object {
            name: format!("{i:05}/{}", o.name),
            transform: turn * o.transform,
            parts: o.parts.clone(),
        };
        scene.objects.iter().map(object).collect::<Vec<_>>()
    };
    Scene { objects: instances.iter().enumerate().flat_map(at).collect() }
}

fn difference(a: &Picture, b: &Picture) -> Picture {
    let texel = |(a, b): (&[u8; 4], &[u8; 4])| {
        let [r, g, b] = [0, 1, 2].map(|k| a[k].abs_diff(b[k]).saturating_mul(16));
        [r, g, b, 255]
    };
    Picture { width: a.width, height: a.height, texels: a.texels.iter().zip(&b.texels).map(texel).collect() }
}

/// Runs `f` twice, since the first run may have to set things up; what it gave and how long the second took.
fn timed<T>(mut f: impl FnMut() -> Result<T, Box<dyn Error>>) -> Result<(T, f64), Box<dyn Error>> {
    f()?;
    let clock = Instant::now();
    let done = f()?;
    Ok((done, clock.elapsed().as_secs_f64() * 1e3))
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [model, out, rest @ ..] = &args[..] else {
        return Err("expected MODEL OUT [COUNT] [SEED] [TEXELS] [WIDTH,HEIGHT]".into());
    };
    let number = |i: usize, usual: u32| rest.get(i).map_or(Ok(usual), |text| text.parse());
    let (count, seed, texels): (u32, u32, u32) = (number(0, 1000)?, number(1, 1)?, number(2, 128)?);
    let (width, height) =
        rest.get(3).map_or("1280,720", |s| s).split_once(',').ok_or("expected a size of WIDTH,HEIGHT")?;
    let (width, height): (u32, u32) = (width.parse()?, height.parse()?);
    let scene = match model.strip_prefix("builtin:") {
        Some(name) => farfield::scene::builtin::make(name, 1).ok_or("no such scene")?,
        None => formats::load(Path::new(model), &DiskFiles, &Limits::default())?,
    };
    let clock = Instant::now();
    let (impostor, selection) = make(&scene, texels)?;
    let (mean, most) = selection.maps_per_frame();
    println!(
        "impostor of {} triangles in {:.1?}: {:.2} % missing at most, threshold {:.0} px, {mean:.1} maps a view, {most} at most",
        scene.triangle_count(),
        clock.elapsed(),
        selection.missing().max * 100.0,
        selection.plt(),
    );
    let instances = spread(&scene, count, seed);
    let size = scene.bounds().max - scene.bounds().min;
    let height_of_eye = size.y * 1.6;
    let step = size.x.max(size.z) * 1.3;
    let deep = step * (f64::from(count).sqrt() + 2.0);
    let eye = DVec3::new(0.0, height_of_eye, step * 2.0);
    let target = DVec3::new(0.0, size.y * 0.4, -deep * 0.25);
    let view = View::look_at(eye, target, DVec3::Y, 0.8, width, height, step * 0.02, deep * 1.6);
    let how = Rendering { shading: Shading::Lit(Light::default()), ..Rendering::default() }.with_samples(1);
    let stop = Stop::default();

    let (cpu, ms) = timed(|| Ok(draw_instances(&[&impostor], &instances, &view, &how, &stop)?))?;
    println!("{count} impostors by the CPU: {ms:.0} ms");
    let name = std::env::var("FARFIELD_ADAPTER").ok();
    let gpu = Gpu::open(name.as_deref().map_or(Wanted::Any, Wanted::Named), 1 << 30)?;
    let loaded = gpu.load_ori(Arc::new(impostor))?;
    let (drawn, ms) = timed(|| Ok(gpu.draw_ori(&[&loaded], &instances, &view, &how, &stop)?))?;
    println!("{count} impostors by {}, read back: {ms:.0} ms", gpu.info.name);
    let field = meshes(&scene, &instances);
    let geometry = Geometry::new(&field);
    let shader = Shader::new(&geometry);
    let (mesh, ms) = timed(|| Ok(render(&Cpu, &shader, &view, &how, &stop)?))?;
    println!("{} triangles by the CPU: {ms:.0} ms", geometry.triangle_count());

    let covered = cpu.depth.iter().filter(|z| z.is_finite()).count();
    let coverage = cpu.depth.iter().zip(&drawn.depth).filter(|(a, b)| a.is_finite() != b.is_finite()).count();
    let apart = |(a, b): (&[u8; 4], &[u8; 4])| (0..3).any(|k| a[k].abs_diff(b[k]) > 3);
    let colors = cpu.picture.texels.iter().zip(&drawn.picture.texels).filter(|pair| apart(*pair)).count();
    println!(
        "{covered} pixels covered; CPU and adapter: {coverage} covered by one alone, {colors} colours more than 3 apart"
    );
    let file = |what: &str| format!("{out}-{what}.png");
    save_png(Path::new(&file("cpu")), &cpu.picture)?;
    save_png(Path::new(&file("gpu")), &drawn.picture)?;
    save_png(Path::new(&file("mesh")), &mesh.picture)?;
    save_png(Path::new(&file("difference")), &difference(&cpu.picture, &drawn.picture))?;
    Ok(())
}
