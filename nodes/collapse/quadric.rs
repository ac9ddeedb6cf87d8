//! Policy `quadric`: meshoptimizer's simplifier, the baseline. It knows nothing of voxels; what it covers is found afterwards.

use crate::{
    array::Array,
    math::{Stop, Stopped},
    voxel::{
        VoxelMesh,
        touch::{self, Point, Toucher},
    },
};
use meshopt::{DecodePosition, SimplifyOptions};

/// A position as meshoptimizer reads it.
struct Position([f32; 3]);

impl DecodePosition for Position {
    fn decode_position(&self) -> [f32; 3] {
        self.0
    }
}

/// What meshoptimizer is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Stop at this many triangles; topology may stop it before.
    pub triangles: usize,
    /// Whether boundary vertices stay.
    pub lock_border: bool,
}

/// The faces that meshoptimizer leaves of `mesh`, in the mesh's vertex numbers. Locked vertices stay.
pub fn faces(mesh: &VoxelMesh, target: Target) -> Vec<[u32; 3]> {
    let positions: Vec<Position> = mesh.vertices.iter().map(|v| Position(touch::point(*v).map(|c| c as f32))).collect();
    let locks: Vec<bool> = mesh.flags.iter().map(|f| f & 1 == 1).collect();
    let options = if target.lock_border { SimplifyOptions::LockBorder } else { SimplifyOptions::None };
    let indices = meshopt::simplify_with_locks_decoder(
        mesh.faces.as_flattened(),
        &positions,
        &locks,
        target.triangles.saturating_mul(3),
        f32::MAX,
        options,
        None,
    );
    indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect()
}

/// Simplifies `mesh`. A voxel is given to the faces that touch its box enlarged by `factor`, or else to the nearest face.
pub fn simplify(mesh: &VoxelMesh, target: Target, factor: f64, stop: &Stop) -> Result<VoxelMesh, Stopped> {
    let kept = faces(mesh, target);
    stop.check()?;
    let mut number = vec![u32::MAX; mesh.vertices.len()];
    let (mut vertices, mut flags) = (Vec::new(), Vec::new());
    let mut faces: Vec<[u32; 3]> = Vec::with_capacity(kept.len());
    for f in kept {
        faces.push(f.map(|v| {
            let slot = &mut number[v as usize];
            if *slot == u32::MAX {
                *slot = vertices.len() as u32;
                vertices.push(mesh.vertices[v as usize]);
                flags.push(mesh.flags[v as usize]);
            }
            *slot
        }));
    }
    let corners: Vec<[Point; 3]> = faces.iter().map(|f| f.map(|v| touch::point(vertices[v as usize]))).collect();
    let lists = cover_lists(mesh, &corners, 2.0 * factor, stop)?;
    let mut cover_start = vec![0];
    let mut cover = Vec::new();
    for list in &lists {
        cover.extend_from_slice(list);
        cover_start.push(cover.len() as u32);
    }
    Ok(VoxelMesh {
        frustum: mesh.frustum,
        vertices: vertices.into(),
        flags: flags.into(),
        faces: faces.into(),
        cover_start: cover_start.into(),
        cover: cover.into(),
        voxels: Array::clone(&mesh.voxels),
        factor,
    })
}

/// Side of a tile in quarter pixels: faces are looked up by the tile in which a voxel lies.
const TILE: f64 = 64.0;

/// For every face the voxels that it covers, ascending.
fn cover_lists(mesh: &VoxelMesh, corners: &[[Point; 3]], half: f64, stop: &Stop) -> Result<Vec<Vec<u32>>, Stopped> {
    let mut lists = vec![Vec::new(); corners.len()];
    if corners.is_empty() {
        return Ok(lists);
    }
    let tile = |p: f64| (p / TILE).floor().max(0.0) as usize;
    let most = |axis: usize| mesh.vertices.iter().map(|v| v[axis]).max().unwrap_or(0);
    let (width, height) = (tile(f64::from(most(0)) + half) + 1, tile(f64::from(most(1)) + half) + 1);
    let mut tiles = vec![Vec::new(); width * height];
    for (f, c) in corners.iter().enumerate() {
        let low = |axis: usize| c.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min) - half;
        let high = |axis: usize| c.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max) + half;
        for y in tile(low(1))..=tile(high(1)).min(height - 1) {
            for x in tile(low(0))..=tile(high(0)).min(width - 1) {
                tiles[y * width + x].push(f as u32);
            }
        }
    }
    let touchers: Vec<Toucher> = corners.iter().map(|c| Toucher::new(*c, half)).collect();
    for (v, voxel) in mesh.voxels.iter().enumerate() {
        if v % 4096 == 0 {
            stop.check()?;
        }
        let c = touch::centre(voxel);
        let near = tiles.get(tile(c[1]).min(height - 1) * width + tile(c[0]).min(width - 1)).map_or(&[][..], |t| t);
        let mut covered = false;
        for &f in near.iter().filter(|f| touchers[**f as usize].touches(&c)) {
            lists[f as usize].push(v as u32);
            covered = true;
        }
        if !covered {
            let distance = |f: &usize| squared_distance(&corners[*f], &c);
            let nearest = (0..corners.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
            lists[nearest.unwrap_or(0)].push(v as u32);
        }
    }
    Ok(lists)
}

/// Squared distance of `p` from a triangle (Ericson, Real-Time Collision Detection, section 5.1.5).
fn squared_distance([a, b, c]: &[Point; 3], p: &Point) -> f64 {
    let sub = |u: &Point, v: &Point| -> Point { std::array::from_fn(|i| u[i] - v[i]) };
    let dot = |u: &Point, v: &Point| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    let n = touch::normal(*a, *b, *c);
    let area = dot(&n, &n);
    // Inside the prism over the face its plane is nearest, elsewhere one of its edges.
    let inside =
        area > 0.0 && [(a, b), (b, c), (c, a)].into_iter().all(|(s, e)| dot(&touch::normal(*s, *e, *p), &n) >= 0.0);
    if inside {
        let d = dot(&sub(p, a), &n);
        return d * d / area;
    }
    let to_edge = |s: &Point, e: &Point| {
        let (d, q) = (sub(e, s), sub(p, s));
        let length = dot(&d, &d);
        let t = if length > 0.0 { (dot(&d, &q) / length).clamp(0.0, 1.0) } else { 0.0 };
        let r: Point = std::array::from_fn(|i| q[i] - t * d[i]);
        dot(&r, &r)
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_to_face_edge_and_corner() {
        let t = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        for (p, expected) in [
            ([1.0, 1.0, 3.0], 9.0),
            ([1.0, 1.0, 0.0], 0.0),
            ([2.0, -2.0, 0.0], 4.0),
            ([-3.0, -4.0, 0.0], 25.0),
            ([4.0, 4.0, 0.0], 8.0),
        ] {
            assert!((squared_distance(&t, &p) - expected).abs() < 1e-12, "{p:?}");
        }
    }
}
