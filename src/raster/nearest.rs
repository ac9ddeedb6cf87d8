//! Operation 1: the nearest surface of every pixel.

use super::{Geometry, Options, Prepared, patch::Holes};
use crate::math::{Stop, Stopped, View};
use rayon::prelude::*;

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
pub fn nearest(geometry: &Geometry, view: &View, options: &Options, stop: &Stop) -> Result<Nearest, Stopped> {
    Prepared::new(geometry, view, options, stop)?.nearest(stop)
}

impl Prepared<'_> {
    /// See [`nearest`].
    pub fn nearest(&self, stop: &Stop) -> Result<Nearest, Stopped> {
        let pixels = self.view.width as usize * self.view.height as usize;
        let mut depth = vec![f32::INFINITY; pixels];
        let mut triangle = vec![NOTHING; pixels];
        let tiles = self.grid.split(&mut depth).into_par_iter().zip(self.grid.split(&mut triangle)).enumerate();
        tiles.try_for_each(|(i, (mut depth, mut triangle))| {
            stop.check()?;
            self.nearest_in_tile(i as u32, &mut depth, &mut triangle);
            Ok(())
        })?;
        Ok(Nearest { width: self.view.width, height: self.view.height, depth, triangle })
    }

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
