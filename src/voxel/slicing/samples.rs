//! Which pixels of which layers hold a covered sample: the rasteriser's second operation, sorted into layers.

use super::{Face, mask};
use crate::{
    math::{Stop, Stopped},
    raster::{Backend, fragments_in_tiles},
};
use rayon::prelude::*;

/// Filled pixels of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// The layer; for cuts the border.
    pub layer: u16,
    pub y: u16,
    /// Which word of the mask's row, and its bits.
    pub word: u32,
    pub bits: u64,
}

/// The layer of a planar depth; `guess` is tried first, because neighbours mostly share a layer. What rounding moved in front
/// of the nearest border belongs to layer 0.
#[inline]
pub fn layer_of(borders: &[f64], depth: f32, guess: u16) -> u16 {
    let (z, g) = (f64::from(depth), usize::from(guess));
    if borders[g] <= z && z < borders[g + 1] {
        return guess;
    }
    let last = borders.len() - 2;
    (borders.partition_point(|b| *b <= z).max(1) - 1).min(last) as u16
}

/// The pixels in which a sample is covered, by layer.
pub fn parts(backend: &dyn Backend, face: &Face, stop: &Stop) -> Result<Vec<Part>, Stopped> {
    let (n, borders) = (face.samples, face.borders);
    let tiles = fragments_in_tiles(backend, &face.prepared, stop, |tile, fragments| {
        let mut out = Vec::new();
        // Of every layer the tile's pixels in the current row, and which layers have any.
        let mut row = vec![0u64; borders.len() - 1];
        let mut touched: Vec<u16> = Vec::new();
        let mut layer = 0;
        for y in (tile.y..tile.y + tile.height).step_by(n as usize) {
            for sy in y..y + n {
                for sx in tile.x..tile.x + tile.width {
                    for fragment in fragments.of(tile.at(sx, sy)) {
                        layer = layer_of(borders, fragment.depth, layer);
                        let bits = &mut row[usize::from(layer)];
                        if *bits == 0 {
                            touched.push(layer);
                        }
                        *bits |= 1 << ((sx - tile.x) / n);
                    }
                }
            }
            for layer in touched.drain(..) {
                let bits = std::mem::take(&mut row[usize::from(layer)]);
                mask::for_words(tile.x / n, bits, |word, bits| {
                    out.push(Part { layer, y: (y / n) as u16, word: word as u32, bits });
                });
            }
        }
        out
    })?;
    let mut parts = tiles.concat();
    parts.par_sort_unstable_by_key(|p| p.layer);
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_guess_changes_no_layer(mut borders in prop::collection::vec(0.1..9.0f64, 2..9), depth in 0.05..12.0f32, guess in 0..8u16) {
            borders.sort_by(f64::total_cmp);
            borders.push(f64::INFINITY);
            let last = borders.len() as u16 - 2;
            let layer = layer_of(&borders, depth, guess.min(last));
            let z = f64::from(depth);
            prop_assert!(z < borders[usize::from(layer) + 1]);
            prop_assert!(layer == 0 || borders[usize::from(layer)] <= z);
        }
    }
}
