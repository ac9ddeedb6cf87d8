use farfield::{
    math::Stop,
    nodes::collapse::{quadric, voxel_cover},
    voxel::{self, cover_mesh},
};
#[path = "../benches/support/fields.rs"]
mod fields;
use std::time::Instant;

fn main() {
    let arg = |i: usize, d: u32| std::env::args().nth(i).map_or(d, |a| a.parse().expect("a number"));
    let (width, layers, houses) = (arg(1, 1024), arg(2, 33), arg(3, 150));
    let solid = fields::skyline(width, layers, houses, 7);
    let field = solid.field();
    let slices = fields::slices(solid.size, layers);
    let stop = Stop::default();
    let t = Instant::now();
    let meshes = cover_mesh::cover_meshes(&slices, &[&field], &stop).expect("a valid field");
    let total: usize = meshes.iter().map(|m| m.1.faces.len()).sum();
    println!("{} voxels, {} meshes, {} faces, {:?}", field.voxels.len(), meshes.len(), total, t.elapsed());
    let mut final_faces = 0;
    let mut histogram = std::collections::BTreeMap::new();
    let (mut ours, mut theirs) = (0.0, 0.0);
    for (_, m) in &meshes {
        let t = Instant::now();
        let done = voxel_cover::simplify(m, 2.0, &stop).expect("not stopped");
        ours += t.elapsed().as_secs_f64();
        let t = Instant::now();
        let q = quadric::faces(m, quadric::Target { triangles: done.faces.len(), lock_border: false });
        theirs += t.elapsed().as_secs_f64();
        final_faces += done.faces.len();
        let e: &mut (usize, usize, usize) = histogram.entry(done.faces.len().next_power_of_two()).or_default();
        e.0 += 1;
        e.1 += done.faces.len();
        e.2 += q.len();
    }
    println!("{final_faces} faces, {ours:.3} s, meshopt {theirs:.3} s, ratio {:.2}", ours / theirs);
    for (k, v) in histogram {
        println!("  <= {k}: {} meshes, {} faces (meshopt {})", v.0, v.1, v.2);
    }
}
