//! meshoptimizer's simplifier on a mesh over voxels, the baseline for `voxel-cover`. It knows nothing of voxels; what it covers is found
//! afterwards.

use crate::{
    array::Array,
    engine::node::{Ctx, Node, NodeError},
    math::{Stop, Stopped, squared_distance},
    nodes::values::Factor,
    ports,
    voxel::{
        VoxelMesh,
        touch::{self, Point, Toucher},
    },
};
use glam::DVec3;
use meshopt::{DecodePosition, SimplifyOptions};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Simplifies a connected mesh over voxels by meshoptimizer's quadrics down to a number of triangles, for comparison with `voxel-cover`: it
/// covers nothing for certain. A method of its own beside `quadric`, because its faces name the voxels that they cover.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Triangles at which it stops; 1 or more. Topology may stop it before.
    #[schemars(range(min = 1))]
    pub triangles: u32,
    /// Side of the box in which a face covers a voxel, in voxels; 1 to 8.
    #[schemars(range(min = 1.0, max = 8.0), extend("x-unit" = "voxels"))]
    pub factor: f64,
    /// Whether boundary vertices stay where they are.
    pub lock_border: bool,
}

impl Default for Params {
    fn default() -> Self {
        Self { triangles: 1000, factor: 2.0, lock_border: false }
    }
}

ports! {
    pub struct In {
        /// A connected mesh over voxels.
        mesh: Arc<VoxelMesh>,
        /// Takes the place of `factor` where it holds one.
        fitted: Option<Arc<Factor>>,
    }
}

ports! {
    pub struct Out {
        /// The same surface in fewer triangles; every face names the voxels that it covers, or that lie nearest to it.
        mesh: Arc<VoxelMesh>,
    }
}

pub struct VoxelQuadric;

impl Node for VoxelQuadric {
    const KIND: &'static str = "collapse";
    const METHOD: &'static str = "voxel-quadric";
    const VERSION: u32 = 1;
    /// meshoptimizer is C++.
    const NATIVE: bool = true;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // Quadrics, positions and the lists of voxels beside the mesh itself.
        sizes.first().copied().unwrap_or(0).saturating_mul(6)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let factor = inputs.fitted.and_then(|f| f.0).unwrap_or(params.factor);
        let target = Target { triangles: params.triangles as usize, lock_border: params.lock_border };
        Ok(Out { mesh: Arc::new(simplify(&inputs.mesh, target, factor, ctx.stop)?) })
    }
}

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
        quarters: Array::clone(&mesh.quarters),
        factor,
        alpha: false,
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
            let distance = |f: &usize| squared_distance(corners[*f].map(DVec3::from), DVec3::from(c));
            let nearest = (0..corners.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
            lists[nearest.unwrap_or(0)].push(v as u32);
        }
    }
    Ok(lists)
}
