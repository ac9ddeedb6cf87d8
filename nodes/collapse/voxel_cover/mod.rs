//! Contract edges as long as every voxel stays covered (Jeschke and Wimmer 2002, section 6).
//!
//! Edges go in order of length times error, in the uniform grid. What holds for the result: every visible voxel of the mesh is
//! touched by a face that names it, within its box enlarged by `factor`; edges that were made, inside the surface and on its
//! boundary, lie inside such boxes (from factor 1.5 on: the edges of a receding wall run outside smaller ones from the start); no
//! face turns its back to the whole cell; an edge has at most two faces; locked vertices stay where they are; vertices lie on the
//! mesh's own lattice (quarter pixels and layers) within the box around it.
//!
//! The paper moves one end of an edge onto the other, the shortest edge first, on whatever mesh that makes. Here meshes stay
//! manifolds, and where that alone would forbid too much: slits and holes smaller than the tolerance are closed (`notch`,
//! `close`), parts that others cover go (`drop`), a vertex goes together with all its faces (`remove`), and both ends of an edge
//! move to a third place (`merge`). In the end each vertex moves to where the surface fits best (`settle`), which leaves room for more: faces
//! that nobody in the cell sees go (`unseen`), and what is left is simplified again, as long as that is worth it. Then the result is
//! looked at from all over the cell, and gaps are closed by single triangles (`lines`, `stitch`). All lie within the same tolerance.
//!
//! Where alpha cuts outlines ([`Silhouette::Alpha`]), a boundary is free to run up to two voxels out of the boxes to the sides, its
//! shape costs nothing, voxels of which no more than a trace is seen may be uncovered, and settling draws faces out over the surface's ends.

mod close;
mod contract;
mod cover;
mod drop;
pub mod fit;
mod lines;
mod merge;
pub mod node;
mod notch;
mod queue;
mod remove;
mod settle;
mod stitch;
mod surface;
#[cfg(test)]
mod tests;
mod topology;
mod unseen;

pub use node::VoxelCover;

use crate::{
    math::{Stop, Stopped},
    voxel::{
        Voxel, VoxelMesh,
        columns::Columns,
        outline::{self, Outline, Run},
    },
};
use contract::Quadric;
use cover::Demand;
use queue::{Entry, Queue, Rank};
use rayon::prelude::*;
use remove::Triangulations;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use surface::Surface;
use topology::{next, prev};

/// How outlines are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Silhouette {
    /// Faces run out over the surface's ends, and the texture's alpha cuts them there: finer outlines and mostly fewer triangles. For consumers
    /// with an alpha test.
    #[default]
    Alpha,
    /// Faces end where the surface ends, textures are opaque.
    Geometry,
}

/// How often the result is simplified once more at most: vertices that have settled have room again.
const MOST_ROUNDS: u64 = 8;
/// A round that leaves a larger share of the faces is the last one.
const WORTH_ANOTHER: f64 = 0.97;

/// What a mesh is simplified to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// How boxes of voxels are enlarged, at least 1.
    pub factor: f64,
    pub silhouette: Silhouette,
}

impl Goal {
    /// How far out of their boxes boundaries may run, quarter units: two voxels.
    fn skirt(&self) -> f64 {
        match self.silhouette {
            Silhouette::Alpha => 8.0,
            Silhouette::Geometry => 0.0,
        }
    }
}

/// Simplifies `mesh`.
pub fn simplify(mesh: &VoxelMesh, goal: Goal, stop: &Stop) -> Result<VoxelMesh, Stopped> {
    simplify_in_steps(mesh, goal, stop, &|_, _| {})
}

/// [`simplify`] that tells after each step how many of how many are done.
pub fn simplify_in_steps(
    mesh: &VoxelMesh,
    goal: Goal,
    stop: &Stop,
    progress: &dyn Fn(u64, u64),
) -> Result<VoxelMesh, Stopped> {
    let mut surface = Surface::new(mesh, demands(mesh, goal), goal);
    let steps = MOST_ROUNDS + 2;
    reduce(&mut surface, &mesh.voxels, stop)?;
    progress(1, steps);
    for round in 0..MOST_ROUNDS {
        let before = surface.faces().count();
        surface.drop_unseen(&mesh.voxels, stop)?;
        reduce(&mut surface, &mesh.voxels, stop)?;
        progress(2 + round, steps);
        if surface.faces().count() as f64 > WORTH_ANOTHER * before as f64 {
            break;
        }
    }
    let mut simple = surface.to_mesh(mesh, goal);
    stitch::stitch(&mut simple, goal, surface.bounds, stop)?;
    progress(steps, steps);
    Ok(simple)
}

/// Simplifies without looking for gaps. `voxels` are the mesh's.
fn reduce(surface: &mut Surface, voxels: &[Voxel], stop: &Stop) -> Result<(), Stopped> {
    surface.fill_notches(stop)?;
    let all = Triangulations::new();
    let (mut passed, mut merged) = (0, 0);
    loop {
        let start = surface.clock;
        loop {
            let since = std::mem::replace(&mut passed, surface.clock);
            if pass(surface, since, stop)? == 0 {
                break;
            }
        }
        let since = std::mem::replace(&mut merged, surface.clock);
        surface.drop_parts(voxels, stop)?;
        surface.close_holes(&all, stop)?;
        sweep(surface, &all, since, stop)?;
        merges(surface, since, stop)?;
        if surface.clock == start {
            break;
        }
    }
    surface.settle(stop)
}

/// What every voxel demands. Hidden ones nothing; where alpha cuts outlines, those neither of which no more than a trace is seen.
fn demands(mesh: &VoxelMesh, goal: Goal) -> Vec<Demand> {
    if goal.silhouette == Silhouette::Geometry {
        return mesh.voxels.iter().map(|v| if v.ring == 0 { Demand::Touch } else { Demand::Nothing }).collect();
    }
    let outline = Outline::new(&Columns::new(&mesh.voxels, 0..mesh.voxels.len() as u32), None);
    let demand = |(run, v): (&Run, &Voxel)| match (outline::counts(run, v), run.open) {
        (false, _) => Demand::Nothing,
        (true, false) => Demand::Touch,
        (true, true) => Demand::End,
    };
    outline.runs.iter().zip(mesh.voxels.iter()).map(demand).collect()
}

/// The edges at a vertex that changed after `since`, with their ranks, and first the end that had better move.
fn edges(surface: &Surface, since: u32) -> Vec<(Rank, [u32; 2])> {
    let topology = &surface.topology;
    let (mut edges, mut at_edge) = (Vec::new(), vec![false; surface.points.len()]);
    for c in 0..topology.vertex.len() as u32 {
        if !topology.is_live(c / 3) {
            continue;
        }
        let (a, b) = (topology.at(next(c)), topology.at(prev(c)));
        let once = topology.opposite[c as usize] == topology::NONE || a < b;
        if once && surface.changed[a as usize].max(surface.changed[b as usize]) > since {
            edges.push([a, b]);
            [a, b].iter().for_each(|v| at_edge[*v as usize] = true);
        }
    }
    let quadric = |(v, used): (usize, &bool)| if *used { surface.quadric(v as u32) } else { Quadric::default() };
    let quadrics: Vec<Quadric> = at_edge.par_iter().enumerate().with_min_len(4096).map(quadric).collect();
    let rank = |ends: &[u32; 2]| surface.rank(*ends, ends.map(|v| &quadrics[v as usize]));
    edges.par_iter().with_min_len(4096).map(rank).collect()
}

/// Tries the edges that changed after `since`, and those around a contraction again, until the queue is empty.
/// Returns how many were contracted.
fn pass(surface: &mut Surface, since: u32, stop: &Stop) -> Result<usize, Stopped> {
    let mut queue = Queue::new();
    for (rank, [a, b]) in edges(surface, since) {
        queue.push(rank, Entry { time: 0, a, b });
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
        surface.topology.ring(kept, &star, &mut ring);
        let of_kept = surface.quadric(kept);
        for &x in &ring {
            let (rank, [a, b]) = surface.rank([kept, x], [&of_kept, &surface.quadric(x)]);
            queue.push(rank, Entry { time, a, b });
        }
    }
    Ok(time as usize)
}

/// Tries to remove every vertex that changed after `since`.
fn sweep(surface: &mut Surface, all: &Triangulations, since: u32, stop: &Stop) -> Result<(), Stopped> {
    for v in 0..surface.points.len() as u32 {
        if surface.is_live(v) && surface.changed[v as usize] > since {
            stop.check()?;
            surface.remove(v, all);
        }
    }
    Ok(())
}

/// Tries to merge the ends of every edge that changed after `since`, in order of rank.
fn merges(surface: &mut Surface, since: u32, stop: &Stop) -> Result<(), Stopped> {
    let mut edges = edges(surface, since);
    edges.sort_unstable();
    for (_, [a, b]) in edges {
        if surface.is_live(a) && surface.is_live(b) && surface.are_neighbours(a, b) {
            stop.check()?;
            surface.merge(a, b);
        }
    }
    Ok(())
}
