//! `collapse` on a skyline of about 600,000 faces, and meshoptimizer's simplifier on the same mesh and count.
//!
//! The ratio of the two is printed first; criterion then times both on a smaller skyline.

use criterion::{Criterion, criterion_group, criterion_main};
use farfield::{
    math::Stop,
    nodes::collapse::{
        voxel_cover::{self, Goal, Silhouette},
        voxel_quadric,
    },
    view,
    voxel::{self, VoxelMesh, cover_mesh::cover_meshes},
};
use std::{hint::black_box, time::Instant};

#[path = "support/fields.rs"]
mod fields;

fn meshes(width: u32, layers: u32, houses: u32) -> Vec<VoxelMesh> {
    let solid = fields::skyline(width, layers, houses, 7);
    let slices = fields::slices(solid.size, layers);
    let made = cover_meshes(&slices, &[&solid.field()], &Stop::default()).expect("a valid field");
    made.into_iter().map(|m| m.1).collect()
}

fn collapse(meshes: &[VoxelMesh]) -> Vec<VoxelMesh> {
    let stop = Stop::default();
    let goal = Goal { factor: 2.0, silhouette: Silhouette::Geometry };
    meshes.iter().map(|m| voxel_cover::simplify(m, goal, &stop).expect("nobody stops it")).collect()
}

fn simplify(meshes: &[VoxelMesh], counts: &[usize]) -> usize {
    let one = |(m, n): (&VoxelMesh, &usize)| {
        voxel_quadric::faces(m, voxel_quadric::Target { triangles: *n, lock_border: false }).len()
    };
    meshes.iter().zip(counts).map(one).sum()
}

fn bench(c: &mut Criterion) {
    let large = meshes(720, 33, 100);
    let before: usize = large.iter().map(|m| m.faces.len()).sum();
    let start = Instant::now();
    let after = collapse(&large);
    let ours = start.elapsed().as_secs_f64();
    let counts: Vec<usize> = after.iter().map(|m| m.faces.len()).collect();
    let start = Instant::now();
    let left = simplify(&large, &counts);
    let theirs = start.elapsed().as_secs_f64();
    println!(
        "{before} faces in {} meshes: voxel-cover {} faces in {ours:.2} s, meshoptimizer {left} in {theirs:.2} s, ratio {:.1}",
        large.len(),
        counts.iter().sum::<usize>(),
        ours / theirs,
    );
    let small = meshes(240, 16, 20);
    let counts: Vec<usize> = collapse(&small).iter().map(|m| m.faces.len()).collect();
    let mut group = c.benchmark_group("collapse");
    group.sample_size(10);
    group.bench_function("voxel-cover", |b| b.iter(|| collapse(black_box(&small))));
    group.bench_function("meshoptimizer", |b| b.iter(|| simplify(black_box(&small), &counts)));
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
