//! Operation 1 on one tile.

use super::{Prepared, Tile, patch::Holes};

/// Marks a pixel that sees nothing.
pub const NOTHING: u32 = u32::MAX;

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
