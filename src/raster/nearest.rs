//! Operation 1: the nearest surface of every pixel.

use super::{Backend, Geometry, Options, Prepared, Tile, backend::in_tiles, patch::Holes};
use crate::{
    math::{Stop, Stopped},
    view::View,
};

/// Marks a pixel that sees nothing.
pub const NOTHING: u32 = u32::MAX;

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

/// What the pixels of one tile see.
#[derive(Default)]
pub(crate) struct Samples {
    pub depth: Vec<f32>,
    pub triangle: Vec<u32>,
}

impl Samples {
    pub fn clear(&mut self, pixels: usize) {
        self.depth.clear();
        self.depth.resize(pixels, f32::INFINITY);
        self.triangle.clear();
        self.triangle.resize(pixels, NOTHING);
    }

    pub fn fill(&mut self, prepared: &Prepared, index: u32) {
        let tile = prepared.tile(index);
        self.clear(tile.pixels());
        prepared.nearest_in_tile(index, &mut rows(&mut self.depth, &tile), &mut rows(&mut self.triangle, &tile));
    }
}

fn rows<'a, T>(values: &'a mut [T], tile: &Tile) -> Vec<&'a mut [T]> {
    values.chunks_mut(tile.width as usize).collect()
}

impl Prepared<'_> {
    /// `depth` and `triangle` are the rows of the tile, filled with infinity and [`NOTHING`].
    pub(crate) fn nearest_in_tile(&self, index: u32, depth: &mut [&mut [f32]], triangle: &mut [&mut [u32]]) {
        let tile = self.tile(index);
        let mut holes = Holes::new(self);
        for t in self.triangles_in(index) {
            let masked = t.masked();
            t.cover(&tile, |y, x0, x1| {
                let row = (y - tile.y as i32) as usize;
                let (from, to) = ((x0 - tile.x as i32) as usize, (x1 - tile.x as i32) as usize);
                let (depth, triangle) = (&mut depth[row][from..to], &mut triangle[row][from..to]);
                let py = y as f64 + 0.5;
                for (i, (depth, triangle)) in depth.iter_mut().zip(triangle).enumerate() {
                    let px = (x0 + i as i32) as f64 + 0.5;
                    let z = t.depth_at(px, py);
                    if z < *depth && (!masked || holes.solid(t.triangle, px, py)) {
                        *depth = z;
                        *triangle = t.triangle;
                    }
                }
            });
        }
    }
}
