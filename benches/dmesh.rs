//! Depth meshes of a synthetic object, and of a model of your own: `FARFIELD_BENCH_MODEL=model.ply cargo bench --bench dmesh`.

#[path = "support/maps.rs"]
mod maps;

use criterion::{Criterion, criterion_group, criterion_main};
use farfield::{
    depth_mesh::{ErrorMeasure, Hierarchy, Options, Propagation, Workspace},
    view::View,
};
use glam::DVec3;
use maps::Object;
use rayon::prelude::*;
use std::{hint::black_box, path::Path};

const SIDE: u32 = 513;

fn measure(c: &mut Criterion, object: &Object) {
    let extent = (object.bounds.max - object.bounds.min).max_element() as f32;
    let diagonal = object.bounds.diagonal();
    let epsilon = (diagonal / 1000.0) as f32;
    let paper = Options::for_extent(extent);
    let mut group = c.benchmark_group(format!("{}, {} maps of {SIDE}²", object.name, object.maps.len()));
    group.sample_size(20);
    for (name, options) in [
        ("edge", paper.clone()),
        ("edge, refine", Options { propagation: Propagation::Refine, ..paper.clone() }),
        ("exact", Options { error: ErrorMeasure::Exact, ..paper.clone() }),
    ] {
        let all = || -> Vec<Hierarchy> {
            let new = |map: &farfield::depth_mesh::DepthMap| Hierarchy::new(map.clone(), &options);
            object.maps.par_iter().filter_map(|map| new(map).ok()).collect()
        };
        group.bench_function(format!("initialise one, {name}"), |b| {
            b.iter(|| black_box(Hierarchy::new(object.maps[0].clone(), &options).is_ok()))
        });
        group.bench_function(format!("initialise all, {name}"), |b| b.iter(|| black_box(all().len())));
        let hierarchies = all();
        let mut workspaces = vec![Workspace::default(); hierarchies.len()];
        group.bench_function(format!("triangulate one at 1/1000, {name}"), |b| {
            b.iter(|| black_box(hierarchies[0].triangulate(epsilon, &mut workspaces[0]).triangles.len()))
        });
        group.bench_function(format!("mesh of one at 1/1000, {name}"), |b| {
            b.iter(|| black_box(hierarchies[0].static_mesh(epsilon).positions.len()))
        });
        let meshes: Vec<_> = hierarchies.iter().map(|h| h.static_mesh(epsilon)).collect();
        let triangles: Vec<usize> = meshes.iter().map(|m| m.triangles.len()).collect();
        let strips: usize = meshes.iter().map(|m| m.strips.len()).sum();
        let cut: usize = meshes.iter().map(|m| m.cut).sum();
        let total: usize = triangles.iter().sum();
        eprintln!(
            "{name}: {total} triangles {triangles:?}, {cut} cut, {:.1} per strip",
            total as f64 / strips.max(1) as f64
        );
        for (distance, times) in [("near", 1.2), ("far", 8.0)] {
            let target = object.bounds.centre();
            let eye = target + DVec3::new(0.4, 0.35, 0.85).normalize() * diagonal * times;
            let view = View::look_at(eye, target, DVec3::Y, 0.785, 1024, 1024, diagonal * 1e-3, diagonal * 2.0 * times);
            group.bench_function(format!("all for a {distance} view at 1 px, {name}"), |b| {
                b.iter(|| {
                    let work = hierarchies.par_iter().zip(&mut workspaces);
                    let count = |(h, w): (&Hierarchy, &mut Workspace)| h.view_dependent(&view, 1.0, w).triangles.len();
                    black_box(work.map(count).sum::<usize>())
                })
            });
            let seen: usize = workspaces.iter().map(|w| w.triangulation().triangles.len()).sum();
            eprintln!("{name}, {distance} view: {seen} triangles");
        }
    }
    group.finish();
}

fn benches(c: &mut Criterion) {
    measure(c, &maps::synthetic(SIDE));
    if let Some(path) = std::env::var_os("FARFIELD_BENCH_MODEL") {
        match maps::model(Path::new(&path), SIDE, true) {
            Ok(object) => measure(c, &object),
            Err(e) => eprintln!("FARFIELD_BENCH_MODEL: {e}"),
        }
    }
}

criterion_group!(dmesh, benches);
criterion_main!(dmesh);
