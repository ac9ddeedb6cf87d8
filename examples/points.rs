//! Asks a solid's depth sprite about many points, in every layout, on the CPU and in a shader on the first adapter (or the one that
//! FARFIELD_ADAPTER names), and compares with the mesh: `cargo run --release --example points -- model.ply [count] [resolution]`.

use farfield::{
    formats::{self, DiskFiles, Limits},
    gpu::{Gpu, Wanted},
    math::{Sequence, Stop},
    raster::{Cpu, Geometry},
    sprite::{DepthQuantizer, Exact, Layout, Packed, Peeling, Repair, judge, peel, spread},
};
use glam::DVec3;
use rayon::prelude::*;
use std::{path::Path, time::Instant};

/// Texels within which image and mesh may differ.
const NEAR: f64 = 0.75;
const CHUNK: u32 = 1 << 20;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().ok_or("expected a model file")?;
    let count: u32 = arguments.next().map_or(Ok(10_000_000), |n| n.parse())?;
    let resolution: u32 = arguments.next().map_or(Ok(1024), |n| n.parse())?;
    let adapter = std::env::var("FARFIELD_ADAPTER").ok();
    let gpu = Gpu::open(adapter.as_deref().map_or(Wanted::Any, Wanted::Named), 1 << 30)?;
    let stop = Stop::default();
    let scene = formats::load(Path::new(&file), &DiskFiles, &Limits::default())?;
    let geometry = Geometry::new(&scene);
    let best = judge(&Cpu, &geometry, &spread(64), 256, &stop)?.swap_remove(0);
    let peeled =
        peel(&Cpu, &geometry, &best.direction, &Peeling { resolution, samples: 1, repair: Repair::None }, &stop)?;
    let image = peeled.image.crop().ok_or("nothing was peeled")?;
    let exact = Exact::new(&geometry, &peeled.frame);
    let grid = DepthQuantizer::around(&image);
    let layouts: Vec<(String, Packed)> = Layout::ALL
        .into_iter()
        .flat_map(|l| {
            let name = |form: &str| format!("{}{form}", l.name());
            let floats = Packed::new(&image, l).map(|p| (name(""), p));
            [floats, Packed::short(&image, l, grid).map(|p| (name(" u16"), p))]
        })
        .flatten()
        .collect();
    let sequence = Sequence::<3>::new(1);
    let texel = NEAR / f64::from(resolution);
    let (mut wrong, mut inside) = (0, 0);
    let mut of_layouts = vec![[0u64; 3]; layouts.len()];
    let mut seconds = vec![[0.0; 2]; layouts.len()];
    for first in (0..count).step_by(CHUNK as usize) {
        // A little beyond the cube, where all is outside.
        let at = |i: u32| (DVec3::from(sequence.point(i)) * 1.02 - 0.01).as_vec3().to_array();
        let points: Vec<[f32; 3]> = (first..count.min(first + CHUNK)).into_par_iter().map(at).collect();
        let truth: Vec<bool> = points.par_iter().map(|p| exact.contains(glam::Vec3::from(*p).as_dvec3())).collect();
        let plain: Vec<bool> = points.par_iter().map(|p| image.contains(*p)).collect();
        let is_wrong = |i: usize| plain[i] != truth[i] && !exact.is_near(glam::Vec3::from(points[i]).as_dvec3(), texel);
        wrong += (0..points.len()).into_par_iter().filter(|i| is_wrong(*i)).count();
        inside += plain.iter().filter(|p| **p).count();
        for (k, (_, packed)) in layouts.iter().enumerate() {
            let start = Instant::now();
            let mut cpu = vec![false; points.len()];
            packed.contain(&points, &mut cpu);
            seconds[k][0] += start.elapsed().as_secs_f64();
            let start = Instant::now();
            let shader = gpu.classify(packed, &points, &stop)?;
            seconds[k][1] += start.elapsed().as_secs_f64();
            for i in 0..points.len() {
                of_layouts[k][0] += u64::from(cpu[i] != plain[i]);
                of_layouts[k][1] += u64::from(shader[i] != cpu[i]);
                let near = || exact.is_near(glam::Vec3::from(points[i]).as_dvec3(), texel);
                of_layouts[k][2] += u64::from(cpu[i] != truth[i] && plain[i] == truth[i] && !near());
            }
        }
    }
    println!("{file}: {count} points, {inside} inside, {wrong} wrong beyond {NEAR} texel; {}", gpu.info.name);
    for ((name, packed), (d, s)) in layouts.iter().zip(of_layouts.iter().zip(&seconds)) {
        let rate = |s: f64| f64::from(count) / s / 1e6;
        println!(
            "  {name}: {} values; {} answers differ from the image's, {} of them wrong beyond {NEAR} texel; shader and CPU differ in {}; \
             {:.0} M points a second on one core, {:.0} M in the shader with transfers",
            packed.values(),
            d[0],
            d[2],
            d[1],
            rate(s[0]),
            rate(s[1])
        );
    }
    Ok(())
}
