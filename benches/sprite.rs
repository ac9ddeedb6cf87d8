//! Depth sprites of a synthetic solid, and of a model of your own: `FARFIELD_BENCH_MODEL=model.ply cargo bench --bench sprite`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use farfield::{
    formats::{self, DiskFiles, Limits},
    math::{Sequence, Stop},
    raster::{Cpu, Geometry},
    scene::{Scene, builtin},
    sprite::{Direction, Layout, Packed, Peeling, Repair, judge, peel, spread},
};
use glam::DVec3;
use std::{hint::black_box, path::Path};

fn measure(c: &mut Criterion, name: &str, scene: &Scene) {
    let geometry = Geometry::new(scene);
    let stop = Stop::default();
    let mut group = c.benchmark_group(format!("{name} ({} triangles)", geometry.triangle_count()));
    group.sample_size(10);
    group.bench_function("64 directions at 256²", |b| {
        b.iter(|| black_box(judge(&Cpu, &geometry, &spread(64), 256, &stop).map(|j| j[0].depth_complexity)))
    });
    let Some(direction) = Direction::new(DVec3::NEG_Z) else { return };
    let how = Peeling { resolution: 1024, samples: 1, repair: Repair::Drop };
    let run = || peel(&Cpu, &geometry, &direction, &how, &stop);
    group.bench_function("peel 1024²", |b| b.iter(|| black_box(run().is_ok())));
    let image = match run() {
        Ok(peeled) => peeled.image,
        Err(e) => return eprintln!("{name}: {e}"),
    };
    group.bench_function("crop", |b| b.iter(|| black_box(image.crop().is_some())));
    let Some(cropped) = image.crop() else { return };
    // Points in the crop, in an order that no cache likes.
    let region = cropped.region();
    let sequence = Sequence::<3>::new(1);
    let points: Vec<[f32; 3]> = (0..1 << 20)
        .map(|i| {
            let [s, t, r] = sequence.point(i);
            let along = |at: u32, length: u32, x: f64| ((f64::from(at) + f64::from(length) * x) / 1024.0) as f32;
            [along(region.x, region.width, s), along(region.y, region.height, t), r as f32]
        })
        .collect();
    group.throughput(Throughput::Elements(points.len() as u64));
    for layout in Layout::ALL {
        group.bench_function(format!("pack {layout:?}"), |b| {
            b.iter(|| black_box(Packed::new(&cropped, layout).is_some()))
        });
        let Some(packed) = Packed::new(&cropped, layout) else { continue };
        group.bench_function(format!("{} points in {layout:?}", points.len()), |b| {
            b.iter(|| black_box(points.iter().filter(|p| packed.contains(**p)).count()))
        });
        let mut inside = vec![false; points.len()];
        group.bench_function(format!("{} points at once in {layout:?}", points.len()), |b| {
            b.iter(|| {
                packed.contain(&points, &mut inside);
                black_box(inside.iter().filter(|inside| **inside).count())
            })
        });
    }
    group.finish();
}

fn benches(c: &mut Criterion) {
    if let Some(solids) = builtin::make("solids", 1) {
        measure(c, "solids", &solids);
    }
    if let Some(path) = std::env::var_os("FARFIELD_BENCH_MODEL") {
        let path = Path::new(&path);
        match formats::load(path, &DiskFiles, &Limits::default()) {
            Ok(scene) => measure(c, &path.file_name().unwrap_or_default().to_string_lossy(), &scene),
            Err(e) => eprintln!("FARFIELD_BENCH_MODEL: {e}"),
        }
    }
}

criterion_group!(sprite, benches);
criterion_main!(sprite);
