//! Operation 2: all surfaces of every pixel, sorted by depth.

use super::{Backend, Geometry, Options, Prepared, ScreenTriangle, Tile, backend::in_tiles, patch::Holes};
use crate::{
    math::{Stop, Stopped},
    view::View,
};

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

/// Calls `work` with the fragments of each tile, several tiles at a time; the results in the order of the tiles. `work` may be called
/// twice for a tile, with the same values. On the CPU no more than one tile's fragments for each thread are in memory.
pub fn fragments_in_tiles<R: Send>(
    backend: &dyn Backend,
    prepared: &Prepared,
    stop: &Stop,
    work: impl Fn(Tile, &TileFragments) -> R + Sync,
) -> Result<Vec<R>, Stopped> {
    in_tiles(prepared, |keep| {
        backend.fragments(prepared, stop, &|i, fragments| keep(i, work(prepared.tile(i), fragments)))
    })
}

/// The fragments of a whole view at once. Memory grows with their number; for tests and small views.
pub fn fragments(
    backend: &dyn Backend,
    geometry: &Geometry,
    view: &View,
    options: &Options,
    stop: &Stop,
) -> Result<Fragments, Stopped> {
    let prepared = Prepared::new(geometry, view, options, stop)?;
    let tiles = fragments_in_tiles(backend, &prepared, stop, |tile, f| (tile, f.offsets.clone(), f.fragments.clone()))?;
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
    /// Calls `visit(x, y, fragment)` for the fragments of a tile that belong to triangles which `wanted` names, triangle by triangle.
    pub(crate) fn fragments_of(
        &self,
        index: u32,
        wanted: impl Fn(&ScreenTriangle) -> bool,
        mut visit: impl FnMut(u32, u32, Fragment),
    ) {
        let tile = self.tile(index);
        let mut holes = Holes::new(self);
        for t in self.triangles_in(index).filter(|t| wanted(t)) {
            let masked = t.masked();
            t.cover(&tile, |y, x0, x1| {
                let py = y as f64 + 0.5;
                for x in x0..x1 {
                    let px = x as f64 + 0.5;
                    if !masked || holes.solid(t.triangle, px, py) {
                        visit(x as u32, y as u32, Fragment { triangle: t.triangle, depth: t.depth_at(px, py) });
                    }
                }
            });
        }
    }

    /// Fills `out` with the fragments of a tile.
    pub fn collect(&self, index: u32, out: &mut TileFragments) {
        let tile = self.tile(index);
        let mut unsorted = std::mem::take(&mut out.unsorted);
        unsorted.clear();
        let all = |_: &ScreenTriangle| true;
        self.fragments_of(index, all, |x, y, fragment| unsorted.push((tile.at(x, y) as u32, fragment)));
        out.collect(tile.pixels(), unsorted);
    }
}

impl TileFragments {
    /// From (pixel, fragment), those of a pixel by ascending number of the triangle.
    pub(crate) fn collect(&mut self, pixels: usize, unsorted: Vec<(u32, Fragment)>) {
        self.offsets.clear();
        self.offsets.resize(pixels + 1, 0);
        for (i, _) in &unsorted {
            self.offsets[*i as usize + 1] += 1;
        }
        for i in 0..pixels {
            self.offsets[i + 1] += self.offsets[i];
        }
        // By pixel; within a pixel triangles keep their ascending order, so a stable sort by depth is enough.
        self.next.clear();
        self.next.extend_from_slice(&self.offsets[..pixels]);
        self.fragments.clear();
        self.fragments.resize(unsorted.len(), Fragment { triangle: 0, depth: 0.0 });
        for (i, f) in &unsorted {
            let at = &mut self.next[*i as usize];
            self.fragments[*at as usize] = *f;
            *at += 1;
        }
        for i in 0..pixels {
            sort_by_depth(&mut self.fragments[self.offsets[i] as usize..self.offsets[i + 1] as usize]);
        }
        self.unsorted = unsorted;
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
