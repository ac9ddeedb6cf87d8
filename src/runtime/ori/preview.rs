//! What people look at without a renderer for impostors: a sheet of all maps, and cards in a GLB.

use super::{Ori, OriError};
use crate::{
    image::{Picture, encode_png},
    relief::ReliefMap,
    runtime::cards::{CORNERS, Card, glb},
    view::directions::window,
};
use glam::DVec3;

/// Texels along the side of a map on the sheet, at most.
const THUMB: usize = 128;
const GREY: u8 = 128;

/// The colours of all maps side by side, PNG.
pub(super) fn sheet(ori: &Ori) -> Result<Vec<u8>, OriError> {
    let side = ori.maps[0].1.side() as usize;
    let step = side.div_ceil(THUMB).max(1);
    let (tile, columns) = (side / step, (ori.maps.len() as f64).sqrt().ceil() as usize);
    let rows = ori.maps.len().div_ceil(columns);
    let mut texels = vec![[GREY, GREY, GREY, 255]; columns * tile * rows * tile];
    for (i, (_, map)) in ori.maps.iter().enumerate() {
        let (x0, y0) = (i % columns * tile, i / columns * tile);
        for y in 0..tile {
            for x in 0..tile {
                let c = map.color[y * step * side + x * step];
                if c[3] == 255 {
                    texels[(y0 + y) * columns * tile + x0 + x] = c;
                }
            }
        }
    }
    let picture = Picture { width: (columns * tile) as u32, height: (rows * tile) as u32, texels };
    encode_png(&picture).map_err(|e| OriError::invalid("preview.png", e.to_string()))
}

/// The maps nearest to the six axes on cards through the middle of the object.
pub(super) fn cards(ori: &Ori) -> Result<Vec<u8>, OriError> {
    let mut chosen: Vec<usize> = Vec::new();
    for axis in DVec3::AXES.into_iter().flat_map(|a| [a, -a]) {
        let near = |i: &usize| -ori.maps[*i].1.view.forward.dot(axis);
        // Of equals the first, whatever the order of comparison.
        let best = (0..ori.maps.len()).reduce(|a, b| if near(&b) > near(&a) { b } else { a });
        chosen.extend(best.filter(|b| !chosen.contains(b)));
    }
    let centre = ori.bounds.centre();
    let cards: Vec<Card> = chosen.iter().filter_map(|i| card(&ori.maps[*i].1, centre)).collect();
    Ok(glb("impostor", ori.maps[0].1.side(), centre, true, &cards)?)
}

fn card(map: &ReliefMap, centre: DVec3) -> Option<Card> {
    let view = &map.view;
    let window = window(view)?;
    let middle = window.centre();
    // As deep as the middle of the object.
    let depth = (centre - view.eye).dot(view.forward);
    let at = view.eye + view.right * middle.x + view.up * middle.y + view.forward * depth;
    let (right, up) = (view.right * (window.max.x - middle.x), view.up * (window.max.y - middle.y));
    Some(Card {
        normal: right.cross(up).normalize_or_zero(),
        texels: map.color.to_vec(),
        corners: CORNERS.map(|(x, y)| at - centre + right * x + up * y),
    })
}
