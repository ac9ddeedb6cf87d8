//! Patches over the gaps that simplification opened.
//!
//! Where the simplified mesh leaves voxels bare, the faces of the initial mesh around them are simplified once more, by
//! themselves, and added. A patch lies within the same tolerance as everything else.

use super::{Goal, Silhouette, demands, drop::neighbours, reduce};
use crate::{
    math::{Stop, Stopped},
    voxel::{Voxel, VoxelMesh, assemble::split_bow_ties, gaps::bare},
};
use std::collections::BTreeSet;

/// Adds to `simple`, which stands for `mesh`, patches over what it leaves bare.
pub fn patch(mesh: &VoxelMesh, simple: &mut VoxelMesh, goal: Goal, stop: &Stop) -> Result<(), Stopped> {
    let faces: Vec<_> = (0..simple.faces.len()).map(|f| simple.triangle(f)).collect();
    let bare = bare(&mesh.voxels, &faces, goal.silhouette == Silhouette::Alpha, stop)?;
    if bare.is_empty() {
        return Ok(());
    }
    let near: BTreeSet<u32> = bare.iter().flat_map(|v| neighbours(&mesh.voxels, *v)).collect();
    let around = |f: usize| mesh.covered_by(f).iter().any(|v| near.contains(v));
    let part = select(mesh, &near.iter().copied().collect::<Vec<_>>(), around, stop)?;
    // The patch ends where its voxels do: it had better cover those.
    append(simple, &reduce(&part, &demands(&part, goal), goal, stop)?);
    Ok(())
}

/// The faces that `keep` admits, with what they cover of `voxels` (ascending numbers), as a mesh of their own.
pub fn select(
    mesh: &VoxelMesh,
    voxels: &[u32],
    keep: impl Fn(usize) -> bool,
    stop: &Stop,
) -> Result<VoxelMesh, Stopped> {
    let mut local = vec![u32::MAX; mesh.voxels.len()];
    voxels.iter().enumerate().for_each(|(i, v)| local[*v as usize] = i as u32);
    let (mut number, mut vertices, mut flags) = (vec![u32::MAX; mesh.vertices.len()], Vec::new(), Vec::new());
    let (mut faces, mut start, mut cover) = (Vec::new(), vec![0], Vec::new());
    for f in (0..mesh.faces.len()).filter(|f| keep(*f)) {
        faces.push(mesh.faces[f].map(|v| {
            let slot = &mut number[v as usize];
            if *slot == u32::MAX {
                *slot = vertices.len() as u32;
                vertices.push(mesh.vertices[v as usize]);
                flags.push(mesh.flags[v as usize]);
            }
            *slot
        }));
        cover.extend(mesh.covered_by(f).iter().map(|v| local[*v as usize]).filter(|v| *v != u32::MAX));
        start.push(cover.len() as u32);
    }
    // Where faces are missing, two fans may be left around a vertex.
    for v in split_bow_ties(&mut faces, vertices.len(), stop)? {
        vertices.push(vertices[v as usize]);
        flags.push(flags[v as usize]);
    }
    Ok(VoxelMesh {
        frustum: mesh.frustum,
        vertices: vertices.into(),
        flags: flags.into(),
        faces: faces.into(),
        cover_start: start.into(),
        cover: cover.into(),
        voxels: voxels.iter().map(|v| mesh.voxels[*v as usize]).collect(),
        quarters: voxels.iter().filter_map(|v| mesh.quarters.get(*v as usize)).copied().collect(),
        factor: mesh.factor,
        alpha: mesh.alpha,
    })
}

/// Adds a part's faces; its voxels are among those of `simple`.
fn append(simple: &mut VoxelMesh, part: &VoxelMesh) {
    let key = |v: &Voxel| (v.layer, v.y, v.x);
    let number = |v: &Voxel| simple.voxels.partition_point(|u| key(u) < key(v)) as u32;
    let number: Vec<u32> = part.voxels.iter().map(number).collect();
    let (first, end) = (simple.vertices.len() as u32, simple.cover.len() as u32);
    let faces = part.faces.iter().map(|f| f.map(|v| v + first));
    simple.faces = simple.faces.iter().copied().chain(faces).collect();
    simple.vertices = simple.vertices.iter().chain(part.vertices.iter()).copied().collect();
    simple.flags = simple.flags.iter().chain(part.flags.iter()).copied().collect();
    let cover = part.cover.iter().map(|v| number[*v as usize]);
    simple.cover = simple.cover.iter().copied().chain(cover).collect();
    let starts = part.cover_start.iter().skip(1).map(|s| s + end);
    simple.cover_start = simple.cover_start.iter().copied().chain(starts).collect();
}
