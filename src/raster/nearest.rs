//! Operation 1: the nearest surface of every pixel.

pub use super::samples::NOTHING;

use super::{Backend, Geometry, Options, Prepared, Tile, backend::in_tiles};
use crate::{
    math::{Stop, Stopped},
    view::View,
};

/// The nearest surface at every pixel centre, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Nearest {
    pub width: u32,
    pub height: u32,
    /// Planar depth in metres; infinite where there is nothing.
    pub depth: Vec<f32>,
    /// Triangle number in the [`Geometry`]; [`NOTHING`] where there is nothing.
    pub triangle: Vec<u32>,
}

/// The nearest surface of every pixel of `view`. Of equal depths the lower triangle number wins.
pub fn nearest(
    backend: &dyn Backend,
    geometry: &Geometry,
    view: &View,
    options: &Options,
    stop: &Stop,
) -> Result<Nearest, Stopped> {
    let prepared = Prepared::new(geometry, view, options, stop)?;
    let tiles =
        nearest_in_tiles(backend, &prepared, stop, |tile, depth, triangle| (tile, depth.to_vec(), triangle.to_vec()))?;
    let pixels = view.width as usize * view.height as usize;
    let (mut depth, mut triangle) = (vec![f32::INFINITY; pixels], vec![NOTHING; pixels]);
    for (tile, z, t) in &tiles {
        let lines = z.chunks(tile.width as usize).zip(t.chunks(tile.width as usize));
        for (y, (z, t)) in (tile.y as usize..).zip(lines) {
            let at = y * view.width as usize + tile.x as usize;
            depth[at..at + z.len()].copy_from_slice(z);
            triangle[at..at + t.len()].copy_from_slice(t);
        }
    }
    Ok(Nearest { width: view.width, height: view.height, depth, triangle })
}

/// Calls `work` with what the pixels of each tile see, several tiles at a time; the results in the order of the tiles. `work` may be
/// called twice for a tile, with the same values.
pub fn nearest_in_tiles<R: Send>(
    backend: &dyn Backend,
    prepared: &Prepared,
    stop: &Stop,
    work: impl Fn(Tile, &[f32], &[u32]) -> R + Sync,
) -> Result<Vec<R>, Stopped> {
    in_tiles(prepared, |keep| {
        backend.nearest(prepared, stop, &|i, depth, triangle| keep(i, work(prepared.tile(i), depth, triangle)))
    })
}
