//! Meshes and collapses a synthetic field, prints counts, writes pictures seen from the centre.
use farfield::{
    math::Stop,
    nodes::collapse::{quadric, voxel_cover},
    voxel::{self, VoxelMesh, cover_mesh},
};
use image::{Rgb, RgbImage};
use std::time::Instant;

#[path = "../benches/support/fields.rs"]
mod fields;

/// Faces by number, edges dark, boundary edges red; `shear` shifts layers as a view from beside the centre does.
fn draw(meshes: &[&VoxelMesh], size: [u32; 2], scale: f64, shear: [f64; 2], path: &str) {
    let (w, h) = ((f64::from(size[0]) * scale) as u32, (f64::from(size[1]) * scale) as u32);
    let mut img = RgbImage::from_pixel(w, h, Rgb([30, 30, 40]));
    let mut depth = vec![f64::INFINITY; (w * h) as usize];
    let at = |v: [i32; 3]| {
        let z = f64::from(v[2]);
        [(f64::from(v[0]) / 4.0 + shear[0] * z) * scale, (f64::from(v[1]) / 4.0 + shear[1] * z) * scale, z]
    };
    for m in meshes {
        for (f, face) in m.faces.iter().enumerate() {
            let p = face.map(|v| at(m.vertices[v as usize]));
            let low = [0, 1].map(|k| p.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min).floor().max(0.0) as u32);
            let high = [0, 1].map(|k| p.iter().map(|p| p[k]).fold(0.0, f64::max).ceil());
            let area = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]);
            if area == 0.0 {
                continue;
            }
            let hash = (f as u32).wrapping_mul(2654435761).rotate_left(9);
            let base = [hash, hash >> 8, hash >> 16].map(|c| 110 + (c & 127) as u8);
            // A face whose back is seen is magenta.
            let color = if area > 0.0 { [255, 0, 255] } else { base };
            for y in low[1]..(high[1] as u32).min(h) {
                for x in low[0]..(high[0] as u32).min(w) {
                    let q = [f64::from(x) + 0.5, f64::from(y) + 0.5];
                    let e = |a: usize, b: usize| {
                        ((p[b][0] - p[a][0]) * (q[1] - p[a][1]) - (p[b][1] - p[a][1]) * (q[0] - p[a][0])) / area
                    };
                    let (b2, b0, b1) = (e(0, 1), e(1, 2), e(2, 0));
                    if b0 < 0.0 || b1 < 0.0 || b2 < 0.0 {
                        continue;
                    }
                    let z = b0 * p[0][2] + b1 * p[1][2] + b2 * p[2][2];
                    let i = (y * w + x) as usize;
                    if z < depth[i] {
                        depth[i] = z;
                        let shade = 1.0 - z / 80.0;
                        img.put_pixel(x, y, Rgb(color.map(|c| (f64::from(c) * shade) as u8)));
                    }
                }
            }
        }
    }
    for m in meshes {
        let mut edges: Vec<_> = m.faces.iter().flat_map(|f| [[f[0], f[1]], [f[1], f[2]], [f[2], f[0]]]).collect();
        edges.sort_unstable();
        for e in &edges {
            let boundary = edges.binary_search(&[e[1], e[0]]).is_err();
            let (a, b) = (at(m.vertices[e[0] as usize]), at(m.vertices[e[1] as usize]));
            let n = ((a[0] - b[0]).abs().max((a[1] - b[1]).abs()) * 2.0).ceil().max(1.0) as u32;
            for i in 0..=n {
                let t = f64::from(i) / f64::from(n);
                let p: [f64; 3] = std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t);
                if p[0] < 0.0 || p[1] < 0.0 || p[0] as u32 >= w || p[1] as u32 >= h {
                    continue;
                }
                let (x, y) = (p[0] as u32, p[1] as u32);
                if p[2] <= depth[(y * w + x) as usize] + 0.3 {
                    img.put_pixel(x, y, if boundary { Rgb([220, 0, 0]) } else { Rgb([0, 0, 0]) });
                }
            }
        }
    }
    img.save(path).expect("a writable path");
}

fn main() {
    let arg = |i: usize, d: u32| std::env::args().nth(i).map_or(d, |a| a.parse().expect("a number"));
    let (width, layers, houses) = (arg(1, 1024), arg(2, 33), arg(3, 150));
    let out = std::env::args().nth(4);
    let solid = fields::skyline(width, layers, houses, 7);
    let field = solid.field();
    let slices = fields::slices(solid.size, layers);
    let stop = Stop::default();
    let t = Instant::now();
    let meshes = cover_mesh::cover_meshes(&slices, &[&field], &stop).expect("a valid field");
    let total: usize = meshes.iter().map(|m| m.1.faces.len()).sum();
    println!("{} voxels, {} meshes, {} faces, {:?}", field.voxels.len(), meshes.len(), total, t.elapsed());
    report(&meshes, solid.size, out.as_deref());
}

fn report(meshes: &[(String, VoxelMesh)], size: [u32; 2], out: Option<&str>) {
    let stop = Stop::default();
    let mut histogram = std::collections::BTreeMap::new();
    let (mut ours, mut theirs, mut count, mut results) = (0.0, 0.0, 0, Vec::new());
    for (_, m) in meshes {
        let t = Instant::now();
        let done = voxel_cover::simplify(m, 2.0, &stop).expect("not stopped");
        ours += t.elapsed().as_secs_f64();
        let t = Instant::now();
        let q = quadric::faces(m, quadric::Target { triangles: done.faces.len(), lock_border: false });
        theirs += t.elapsed().as_secs_f64();
        count += done.faces.len();
        let e: &mut (usize, usize, usize) = histogram.entry(done.faces.len().next_power_of_two()).or_default();
        e.0 += 1;
        e.1 += done.faces.len();
        e.2 += q.len();
        results.push(done);
    }
    let boundary: usize = results.iter().map(boundary_edges).sum();
    let vertices: usize = results.iter().map(|m| m.vertices.len()).sum();
    println!(
        "{count} faces, {vertices} vertices, {boundary} boundary edges, {ours:.3} s, meshopt {theirs:.3} s, ratio {:.2}",
        ours / theirs
    );
    for (k, v) in histogram {
        println!("  <= {k}: {} meshes, {} faces (meshopt {})", v.0, v.1, v.2);
    }
    if let Some(out) = out {
        let (before, after): (Vec<_>, Vec<_>) = (meshes.iter().map(|m| &m.1).collect(), results.iter().collect());
        let scale = (1600.0 / f64::from(size[0])).max(1.0);
        draw(&before, size, scale, [0.0; 2], &format!("{out}-before.png"));
        draw(&after, size, scale, [0.0; 2], &format!("{out}-after.png"));
        draw(&after, size, scale, [-1.0, -1.0], &format!("{out}-side.png"));
    }
}

fn boundary_edges(m: &VoxelMesh) -> usize {
    let mut edges: Vec<_> = m.faces.iter().flat_map(|f| [[f[0], f[1]], [f[1], f[2]], [f[2], f[0]]]).collect();
    edges.sort_unstable();
    edges.iter().filter(|e| edges.binary_search(&[e[1], e[0]]).is_err()).count()
}
