//! Policy `voxel-cover`: contract edges as long as every voxel stays covered (Jeschke and Wimmer 2002, section 6).
//!
//! Shortest edge first in the uniform grid. What holds for the result: every voxel of the mesh is touched by a face that
//! names it, within its box enlarged by `factor`; every boundary edge lies inside such boxes; no face turns its back to
//! the cell's centre; an edge has at most two faces; locked vertices stay where they are.

mod close;
mod contract;
mod cover;
mod drop;
mod queue;
mod remove;
mod topology;

use crate::{
    array::Array,
    math::{Stop, Stopped},
    voxel::{VoxelMesh, touch},
};
use contract::Surface;
use cover::Cover;
use queue::{Entry, Queue};
use remove::Triangulations;
use topology::{Topology, next, prev};

/// Simplifies `mesh`; boxes of voxels are enlarged by `factor` (at least 1).
pub fn simplify(mesh: &VoxelMesh, factor: f64, stop: &Stop) -> Result<VoxelMesh, Stopped> {
    let mut surface = Surface {
        topology: Topology::new(mesh.vertices.len(), &mesh.faces),
        cover: Cover::new(
            mesh.voxels.iter().map(touch::centre).collect(),
            2.0 * factor,
            &mesh.cover_start,
            mesh.cover.to_vec(),
        ),
        points: mesh.vertices.iter().map(|v| touch::point(*v)).collect(),
        locked: mesh.flags.iter().map(|f| f & 1 == 1).collect(),
        origin: (0..mesh.vertices.len() as u32).collect(),
        scratch: Default::default(),
    };
    surface.drop_parts(&mesh.voxels, stop)?;
    while pass(&mut surface, stop)? > 0 {}
    let all = Triangulations::new();
    loop {
        let closed = surface.close_holes(&all, stop)?;
        let gone = sweep(&mut surface, &all, stop)?;
        if closed + gone == 0 {
            break;
        }
        while pass(&mut surface, stop)? > 0 {}
    }
    Ok(gather(&surface, mesh, factor))
}

/// Tries every edge, and those around a contraction again, until the queue is empty. Returns how many were contracted.
fn pass(surface: &mut Surface, stop: &Stop) -> Result<usize, Stopped> {
    let mut queue = Queue::new();
    let topology = &surface.topology;
    for c in 0..topology.vertex.len() as u32 {
        if !topology.is_live(c / 3) {
            continue;
        }
        let (a, b) = (topology.at(next(c)), topology.at(prev(c)));
        if topology.opposite[c as usize] == topology::NONE || a < b {
            queue.push(surface.squared(a, b), Entry { time: 0, a: a.min(b), b: a.max(b) });
        }
    }
    // When all edges of a vertex were last queued: older entries are void.
    let mut queued = vec![0u32; surface.points.len()];
    let (mut time, mut polls, mut star, mut ring) = (0, 0u32, Vec::new(), Vec::new());
    while let Some(Entry { time: then, a, b }) = queue.pop() {
        polls += 1;
        if polls % 256 == 0 {
            stop.check()?;
        }
        if !surface.is_live(a) || !surface.is_live(b) || then < queued[a as usize].max(queued[b as usize]) {
            continue;
        }
        let kept = if surface.contract(a, b) {
            b
        } else if surface.contract(b, a) {
            a
        } else {
            continue;
        };
        time += 1;
        queued.resize(surface.points.len(), 0);
        queued[kept as usize] = time;
        surface.topology.star(kept, &mut star);
        ring.clear();
        ring.extend(star.iter().map(|c| surface.topology.at(next(*c))));
        if let Some(last) = star.last().filter(|_| surface.topology.is_boundary(kept)) {
            ring.push(surface.topology.at(prev(*last)));
        }
        for &x in &ring {
            queue.push(surface.squared(kept, x), Entry { time, a: kept.min(x), b: kept.max(x) });
        }
    }
    Ok(time as usize)
}

/// Tries to remove every vertex; returns how many went.
fn sweep(surface: &mut Surface, all: &Triangulations, stop: &Stop) -> Result<usize, Stopped> {
    let mut gone = 0;
    for v in 0..surface.points.len() as u32 {
        if surface.is_live(v) {
            stop.check()?;
            gone += usize::from(surface.remove(v, all));
        }
    }
    Ok(gone)
}

/// The living faces as a mesh of their own.
fn gather(surface: &Surface, mesh: &VoxelMesh, factor: f64) -> VoxelMesh {
    let topology = &surface.topology;
    let mut number = vec![u32::MAX; surface.points.len()];
    let (mut vertices, mut flags, mut faces) = (Vec::new(), Vec::new(), Vec::new());
    let (mut cover_start, mut cover) = (vec![0], Vec::new());
    for face in (0..mesh.faces.len() as u32).filter(|f| topology.is_live(*f)) {
        faces.push(topology.corners(face).map(|v| {
            let slot = &mut number[v as usize];
            if *slot == u32::MAX {
                *slot = vertices.len() as u32;
                let original = surface.origin[v as usize] as usize;
                vertices.push(mesh.vertices[original]);
                flags.push(mesh.flags[original]);
            }
            *slot
        }));
        let from = cover.len();
        cover.extend_from_slice(surface.cover.list(face));
        cover[from..].sort_unstable();
        cover_start.push(cover.len() as u32);
    }
    VoxelMesh {
        frustum: mesh.frustum,
        vertices: vertices.into(),
        flags: flags.into(),
        faces: faces.into(),
        cover_start: cover_start.into(),
        cover: cover.into(),
        voxels: Array::clone(&mesh.voxels),
        factor,
    }
}
