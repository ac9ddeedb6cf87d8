//! Operation 2: all surfaces of every pixel, sorted by depth.

use super::{Geometry, Options, Prepared, Tile, patch::Holes};
use crate::math::{Stop, Stopped, View};
use rayon::prelude::*;

/// One surface at one pixel centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment {
    pub triangle: u32,
    /// Planar depth, metres.
    pub depth: f32,
}

/// The fragments of one tile. Those of the pixel at position `i` (see [`Tile::at`]) are
/// `fragments[offsets[i]..offsets[i + 1]]`, sorted by (depth, triangle).
#[derive(Clone, Debug, Default)]
pub struct TileFragments {
    pub offsets: Vec<u32>,
    pub fragments: Vec<Fragment>,
    unsorted: Vec<(u32, Fragment)>,
    next: Vec<u32>,
}

impl TileFragments {
    pub fn of(&self, i: usize) -> &[Fragment] {
        &self.fragments[self.offsets[i] as usize..self.offsets[i + 1] as usize]
    }
}

/// All fragments of a view; the layout of [`TileFragments`] over the pixels of the view, row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fragments {
    pub width: u32,
    pub height: u32,
    pub offsets: Vec<u64>,
    pub fragments: Vec<Fragment>,
}

impl Fragments {
    pub fn of(&self, x: u32, y: u32) -> &[Fragment] {
        let i = y as usize * self.width as usize + x as usize;
        &self.fragments[self.offsets[i] as usize..self.offsets[i + 1] as usize]
    }
}

/// Calls `work` with the fragments of each tile, several tiles at a time; the results in the order of the tiles.
/// No more than one tile's fragments for each thread are in memory.
pub fn fragments_in_tiles<R: Send>(
    geometry: &Geometry,
    view: &View,
    options: &Options,
    stop: &Stop,
    work: impl Fn(Tile, &TileFragments) -> R + Sync,
) -> Result<Vec<R>, Stopped> {
    Prepared::new(geometry, view, options, stop)?.fragments_in_tiles(stop, work)
}

/// The fragments of a whole view at once. Memory grows with their number; for tests and small views.
pub fn fragments(geometry: &Geometry, view: &View, options: &Options, stop: &Stop) -> Result<Fragments, Stopped> {
    let prepared = Prepared::new(geometry, view, options, stop)?;
    let tiles = prepared.fragments_in_tiles(stop, |tile, f| (tile, f.offsets.clone(), f.fragments.clone()))?;
    let (w, h) = (view.width as usize, view.height as usize);
    let mut offsets = vec![0u64; w * h + 1];
    for (tile, starts, _) in &tiles {
        for (i, s) in starts.windows(2).enumerate() {
            let (x, y) = tile.pixel(i);
            offsets[y as usize * w + x as usize + 1] = (s[1] - s[0]) as u64;
        }
    }
    for i in 1..offsets.len() {
        offsets[i] += offsets[i - 1];
    }
    let none = Fragment { triangle: super::NOTHING, depth: f32::INFINITY };
    let mut all = vec![none; offsets[w * h] as usize];
    for (tile, starts, list) in &tiles {
        for (i, s) in starts.windows(2).enumerate() {
            let (x, y) = tile.pixel(i);
            let to = offsets[y as usize * w + x as usize] as usize;
            let from = &list[s[0] as usize..s[1] as usize];
            all[to..to + from.len()].copy_from_slice(from);
        }
    }
    Ok(Fragments { width: view.width, height: view.height, offsets, fragments: all })
}

impl Prepared<'_> {
    /// See [`fragments_in_tiles`].
    pub fn fragments_in_tiles<R: Send>(
        &self,
        stop: &Stop,
        work: impl Fn(Tile, &TileFragments) -> R + Sync,
    ) -> Result<Vec<R>, Stopped> {
        (0..self.tile_count() as u32)
            .into_par_iter()
            .map_init(TileFragments::default, |buffer, index| {
                stop.check()?;
                self.collect(index, buffer);
                Ok(work(self.tile(index), buffer))
            })
            .collect()
    }

    /// Fills `out` with the fragments of a tile.
    pub fn collect(&self, index: u32, out: &mut TileFragments) {
        let tile = self.tile(index);
        let pixels = tile.pixels();
        out.offsets.clear();
        out.offsets.resize(pixels + 1, 0);
        out.unsorted.clear();
        let mut holes = Holes::new(self);
        for t in self.triangles_in(index) {
            let masked = t.masked();
            t.cover(&tile, |y, x0, x1| {
                let py = y as f64 + 0.5;
                let at = tile.at(x0 as u32, y as u32);
                for x in x0..x1 {
                    let px = x as f64 + 0.5;
                    if masked && !holes.solid(t.triangle, px, py) {
                        continue;
                    }
                    let i = at + (x - x0) as usize;
                    out.offsets[i + 1] += 1;
                    out.unsorted.push((i as u32, Fragment { triangle: t.triangle, depth: t.depth_at(px, py) }));
                }
            });
        }
        for i in 0..pixels {
            out.offsets[i + 1] += out.offsets[i];
        }
        // By pixel; within a pixel triangles keep their ascending order, so a stable sort by depth is enough.
        out.next.clear();
        out.next.extend_from_slice(&out.offsets[..pixels]);
        out.fragments.clear();
        out.fragments.resize(out.unsorted.len(), Fragment { triangle: 0, depth: 0.0 });
        for (i, f) in &out.unsorted {
            let at = &mut out.next[*i as usize];
            out.fragments[*at as usize] = *f;
            *at += 1;
        }
        for i in 0..pixels {
            sort_by_depth(&mut out.fragments[out.offsets[i] as usize..out.offsets[i + 1] as usize]);
        }
    }
}

/// Stable; depths are numbers.
fn sort_by_depth(list: &mut [Fragment]) {
    if list.len() > 32 {
        return list.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    }
    for i in 1..list.len() {
        let f = list[i];
        let mut k = i;
        while k > 0 && list[k - 1].depth > f.depth {
            list[k] = list[k - 1];
            k -= 1;
        }
        list[k] = f;
    }
}
