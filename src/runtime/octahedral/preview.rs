//! A GLB that any viewer opens: the frames nearest to the six axes on crossed cards. An approximation: it does not blend, and each
//! card is right only from its own side.

use super::OctahedralError;
use crate::{
    octahedral::{Impostor, axes},
    runtime::cards::{CORNERS, Card, glb},
};
use glam::DVec3;

/// Texels along the side of a frame in the preview, at most.
const SIDE: u32 = 256;

/// The bytes of the GLB.
pub fn preview(impostor: &Impostor) -> Result<Vec<u8>, OctahedralError> {
    let grid = impostor.grid;
    let mut frames: Vec<(u32, u32)> = Vec::new();
    for axis in DVec3::AXES.into_iter().flat_map(|a| [a, -a]) {
        if grid.hemi && axis.y < 0.0 {
            continue;
        }
        let points = (0..grid.side * grid.side).map(|i| (i % grid.side, i / grid.side));
        let cosine = |p: &(u32, u32)| grid.direction(p.0, p.1).dot(axis);
        // Of equals the first, whatever the order of comparison.
        let best = points.reduce(|a, b| if cosine(&b) > cosine(&a) { b } else { a });
        frames.extend(best.filter(|b| !frames.contains(b)));
    }
    let level = crate::octahedral::levels(impostor).into_iter().find(|l| l.side / grid.side <= SIDE);
    let atlas = level.unwrap_or_else(|| impostor.atlas.clone());
    let tile = (atlas.side / grid.side) as usize;
    let card = |(column, row): &(u32, u32)| {
        let texels = (0..tile).flat_map(|y| {
            let first = (*row as usize * tile + y) * atlas.side as usize + *column as usize * tile;
            atlas.color[first..first + tile].iter().copied()
        });
        let normal = grid.direction(*column, *row);
        let [right, up] = axes(normal).map(|a| a * impostor.radius);
        Card { normal, texels: texels.collect(), corners: CORNERS.map(|(x, y)| right * x + up * y) }
    };
    let cards: Vec<Card> = frames.iter().map(card).collect();
    Ok(glb("impostor", tile as u32, impostor.centre, false, &cards)?)
}
