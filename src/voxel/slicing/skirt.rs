//! The skirt: hidden voxels where a visible surface goes on under what hides it.
//!
//! Not in the paper, which ends every surface where the view cell ends seeing it. Simplification may then draw the silhouette
//! in front back by its tolerance and the surface behind likewise, and a gap opens between them that the paper's test of
//! boundaries cannot see. With the skirt, surfaces overlap by more than that.

use crate::voxel::Voxel;

/// A hidden voxel whose distance from the visible ones is not known yet.
pub const UNREACHED: u8 = u8::MAX;

/// Numbers the hidden voxels' rings and leaves out those that are not within `skirt` steps of a visible voxel, a step
/// leading to a voxel that touches. `voxels` are sorted, `size` is that of the image.
pub fn keep_reached(voxels: &mut Vec<Voxel>, size: [u32; 2], skirt: u32) {
    let ends: Vec<usize> = voxels
        .chunk_by(|a, b| a.layer == b.layer)
        .scan(0, |at, c| {
            *at += c.len();
            Some(*at)
        })
        .collect();
    let width = size[0] as usize + 2;
    // Voxels of the last ring in three layers, with an apron.
    let mut grids = vec![vec![false; width * (size[1] as usize + 2)]; 3];
    let at = |v: &Voxel| (usize::from(v.y) + 1) * width + usize::from(v.x) + 1;
    for ring in 1..=skirt as u8 {
        let part = |i: usize| if i < ends.len() { (if i == 0 { 0 } else { ends[i - 1] })..ends[i] } else { 0..0 };
        let set = |grid: &mut Vec<bool>, voxels: &[Voxel], value: bool| {
            voxels.iter().filter(|v| v.ring == ring - 1).for_each(|v| grid[at(v)] = value);
        };
        set(&mut grids[0], &voxels[part(0)], true);
        for i in 0..ends.len() {
            set(&mut grids[(i + 1) % 3], &voxels[part(i + 1)], true);
            let layer = voxels[part(i).start].layer;
            let near: Vec<usize> = (i.saturating_sub(1)..=i + 1)
                .filter(|j| part(*j).start < part(*j).end && voxels[part(*j).start].layer.abs_diff(layer) <= 1)
                .map(|j| j % 3)
                .collect();
            for n in part(i) {
                if voxels[n].ring == UNREACHED {
                    let c = at(&voxels[n]);
                    let touches =
                        |g: &usize| [c - width, c, c + width].iter().any(|r| grids[*g][r - 1..=r + 1].contains(&true));
                    if near.iter().any(touches) {
                        voxels[n].ring = ring;
                    }
                }
            }
            if i > 0 {
                set(&mut grids[(i - 1) % 3], &voxels[part(i - 1)], false);
            }
        }
        if let Some(last) = ends.len().checked_sub(1) {
            set(&mut grids[last % 3], &voxels[part(last)], false);
        }
    }
    voxels.retain(|v| v.ring != UNREACHED);
}
