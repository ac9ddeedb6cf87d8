//! Compares the two back ends on scenes of your own: `cargo run --release --example parity -- model.glb …` renders each
//! from 20 views at 512² on the CPU and on the first adapter (or the one that FARFIELD_ADAPTER names) and counts what differs.

use farfield::{
    formats::{self, DiskFiles, Limits},
    gpu::{Gpu, Wanted},
    math::Stop,
    raster::{Backend, Cpu, Geometry, Options, Rendering, Shader, fragments, nearest, picture},
    scene::Scene,
    view::View,
};
use glam::DVec3;
use std::{path::Path, time::Instant};

const VIEWS: u32 = 20;
const SIDE: u32 = 512;

/// Directions spread over the sphere by the golden angle; every other view stands among the objects.
fn views(scene: &Scene) -> Vec<View> {
    let bounds = scene.bounds();
    let (centre, radius) = (bounds.centre(), bounds.diagonal() * 0.5);
    (0..VIEWS)
        .map(|i| {
            let y = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(VIEWS);
            let (r, turn) = ((1.0 - y * y).sqrt(), 2.399963229728653 * f64::from(i));
            let direction = DVec3::new(r * libm::cos(turn), y, r * libm::sin(turn));
            let distance = radius * if i % 2 == 0 { 2.2 } else { 0.4 };
            let eye = centre + direction * distance;
            View::look_at(eye, centre, DVec3::Y, 0.9, SIDE, SIDE, radius * 1e-3, distance + radius * 1.1)
        })
        .collect()
}

#[derive(Default)]
struct Sum {
    pixels: u64,
    ids: u64,
    depth: f64,
    lists: u64,
    colour: u8,
    seconds: [f64; 2],
}

fn compare(scene: &Scene, gpu: &Gpu) -> Result<Sum, Box<dyn std::error::Error>> {
    let geometry = Geometry::new(scene);
    let shader = Shader::new(&geometry);
    let (options, stop) = (Options::default(), Stop::default());
    let mut sum = Sum::default();
    for view in views(scene) {
        let mut timed = |k: usize, backend: &dyn Backend| {
            let start = Instant::now();
            let found = nearest(backend, &geometry, &view, &options, &stop);
            sum.seconds[k] += start.elapsed().as_secs_f64();
            found
        };
        let (a, b) = (timed(0, &Cpu)?, timed(1, gpu)?);
        sum.pixels += a.triangle.iter().filter(|t| **t != farfield::raster::NOTHING).count() as u64;
        for i in 0..a.depth.len() {
            sum.ids += u64::from(a.triangle[i] != b.triangle[i]);
            if a.depth[i].to_bits() != b.depth[i].to_bits() {
                sum.depth = sum.depth.max(f64::from((a.depth[i] - b.depth[i]).abs()) / (view.far - view.near));
            }
        }
        let all = |backend: &dyn Backend| fragments(backend, &geometry, &view, &options, &stop);
        sum.lists += u64::from(all(&Cpu)? != all(gpu)?);
        let how = Rendering::default();
        let (a, b) = (picture(&Cpu, &shader, &view, &how, &stop)?, picture(gpu, &shader, &view, &how, &stop)?);
        let apart = a.texels.iter().flatten().zip(b.texels.iter().flatten()).map(|(a, b)| a.abs_diff(*b));
        sum.colour = sum.colour.max(apart.max().unwrap_or(0));
    }
    Ok(sum)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::var("FARFIELD_ADAPTER").ok();
    let gpu = Gpu::open(name.as_deref().map_or(Wanted::Any, Wanted::Named), 1 << 30)?;
    println!("{}: {VIEWS} views of {SIDE}² each", gpu.info.name);
    for path in std::env::args().skip(1) {
        let scene = formats::load(Path::new(&path), &DiskFiles, &Limits::default())?;
        let s = compare(&scene, &gpu)?;
        println!(
            "{path}: {} triangles, {} pixels seen; different: {} ids, depth {:e} of the range, {} views' fragments, colour {}/255; \
             nearest {:.1} ms on the CPU, {:.1} ms here, {} tiles decided by the CPU, {} bytes of GPU memory at most",
            scene.triangle_count(),
            s.pixels,
            s.ids,
            s.depth,
            s.lists,
            s.colour,
            s.seconds[0] * 1e3 / f64::from(VIEWS),
            s.seconds[1] * 1e3 / f64::from(VIEWS),
            gpu.undecided(),
            gpu.most_memory(),
        );
        for warning in gpu.warnings() {
            println!("  warning: {warning}");
        }
    }
    Ok(())
}
