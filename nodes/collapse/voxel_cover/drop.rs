//! Dropping parts of a mesh that lie within the tolerance of its other parts.
//!
//! Where occlusion or a ragged edge cuts voxels off, single triangles remain beside the surface that they belong to, and where a
//! skirt is simplified, pieces of it come off. A part (faces that hang together) goes if faces of other parts touch the
//! enlarged boxes of all its visible voxels: these are then covered by those.

use super::surface::Surface;
use crate::{
    math::{Stop, Stopped},
    voxel::Voxel,
};

/// Parts of more faces are never dropped.
const MOST: usize = 256;

impl Surface {
    /// Drops parts of a mesh over `voxels`; returns how many went.
    pub fn drop_parts(&mut self, voxels: &[Voxel], stop: &Stop) -> Result<usize, Stopped> {
        let parts = self.parts();
        if parts.count < 2 {
            return Ok(0);
        }
        // Smallest first, so that of two that cover each other the larger stays.
        let mut faces_of = vec![Vec::new(); parts.count];
        for (f, part) in parts.of_face.iter().enumerate() {
            if *part != u32::MAX {
                let list: &mut Vec<u32> = &mut faces_of[*part as usize];
                if list.len() <= MOST {
                    list.push(f as u32);
                }
            }
        }
        let mut order: Vec<usize> = (0..parts.count).filter(|p| faces_of[*p].len() <= MOST).collect();
        order.sort_by_key(|p| faces_of[*p].len());
        if order.len() == parts.count {
            order.pop();
        }
        let naming = self.cover.faces_by_voxel();
        let mut dropped = 0;
        // Faces that were tried against the voxel at hand bear its turn.
        let (mut tried, mut turn) = (vec![0u32; parts.of_face.len()], 0);
        for part in order {
            stop.check()?;
            // What lies on a seam is the neighbour's edge too.
            let on_seam = |f: &u32| self.topology.corners(*f).iter().any(|v| self.locked[*v as usize]);
            if faces_of[part].iter().any(on_seam) {
                continue;
            }
            let mut own: Vec<u32> = faces_of[part].iter().flat_map(|f| self.cover.list(*f).iter().copied()).collect();
            own.sort_unstable();
            own.dedup();
            let mut gains = Vec::new();
            let covered = own.iter().all(|v| {
                let near = neighbours(voxels, *v).flat_map(|u| naming.of(u));
                turn += 1;
                let other = near.filter(|f| {
                    let first = std::mem::replace(&mut tried[**f as usize], turn) != turn;
                    first && parts.of_face[**f as usize] != part as u32 && self.topology.is_live(**f)
                });
                let before = gains.len();
                gains.extend(other.filter(|f| self.cover.touches(self.triangle(**f), *v)).map(|f| (*f, *v)));
                gains.len() > before || voxels[*v as usize].ring > 0
            });
            if covered {
                gains.sort_unstable();
                for f in &faces_of[part] {
                    self.cover.clear(*f);
                    self.topology.remove_face(*f);
                }
                self.cover.extend(&gains);
                dropped += 1;
            }
        }
        Ok(dropped)
    }

    fn parts(&self) -> Parts {
        let faces = self.topology.vertex.len() / 3;
        let mut of_face = vec![u32::MAX; faces];
        let (mut count, mut open) = (0, Vec::new());
        for first in 0..faces as u32 {
            if of_face[first as usize] != u32::MAX || !self.topology.is_live(first) {
                continue;
            }
            open.push(first);
            of_face[first as usize] = count as u32;
            while let Some(f) = open.pop() {
                for c in 3 * f..3 * f + 3 {
                    let across = self.topology.opposite[c as usize];
                    if across != super::topology::NONE && of_face[across as usize / 3] == u32::MAX {
                        of_face[across as usize / 3] = count as u32;
                        open.push(across / 3);
                    }
                }
            }
            count += 1;
        }
        Parts { of_face, count }
    }
}

/// Which part every face belongs to.
struct Parts {
    of_face: Vec<u32>,
    count: usize,
}

/// The voxel itself and those that touch it, if only at a corner; `voxels` are sorted by layer, y and x.
pub fn neighbours(voxels: &[Voxel], v: u32) -> impl Iterator<Item = u32> {
    let at = |v: &Voxel| (i32::from(v.layer), i32::from(v.y), i32::from(v.x));
    let (layer, y, x) = at(&voxels[v as usize]);
    (0..9).flat_map(move |k| {
        let (l, j) = (layer + k / 3 - 1, y + k % 3 - 1);
        let from = voxels.partition_point(|u| at(u) < (l, j, x - 1));
        voxels[from..]
            .iter()
            .take_while(move |u| at(u) <= (l, j, x + 1))
            .enumerate()
            .map(move |(i, _)| (from + i) as u32)
    })
}
