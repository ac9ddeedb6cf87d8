//! Which voxels can never be seen (Jeschke and Wimmer 2002, section 4.2).
//!
//! H_0 is empty, H_{k+1} = erode3×3(S_k ∪ H_k), and the voxels S_k \ H_k are visible. H is dense, over empty pixels too.
//! Hidden voxels near visible pixels, S_k ∩ H_k \ erode3×3^skirt(H_k), are kept too: see [`super::skirt`].
//! Outside an image everything is empty, except across a shared edge of two cube faces: there the other face's pixels
//! count. At a corner of the cube the missing diagonal neighbour counts as set where both its neighbours are.

use super::mask::{self, Shape};
use crate::voxel::{Across, Frustum, Side, valid::SIDES};
use rayon::prelude::*;

/// H and a place for S ∪ H, for every frustum.
pub struct Hidden {
    images: Vec<Image>,
    skirt: u32,
}

struct Image {
    shape: Shape,
    across: [Option<Across>; 4],
    hidden: Vec<u64>,
    union: Vec<u64>,
    /// H eroded `skirt` times.
    deep: Vec<u64>,
}

/// Rows of a band in one layer, without apron: S_k, of which the voxels to keep are left, and room for the hidden ones among them.
pub struct Rows<'a> {
    pub filled: &'a mut [u64],
    pub hidden: &'a mut [u64],
}

/// Rows that one task works on.
pub const BAND: usize = 32;

impl Hidden {
    pub fn new(frusta: &[Frustum], skirt: u32) -> Self {
        let image = |f: &Frustum| {
            let shape = Shape::new(f.size[0], f.size[1]);
            let zeros = || shape.zeros();
            Image { shape, across: f.across, hidden: zeros(), union: zeros(), deep: zeros() }
        };
        Self { images: frusta.iter().map(image).collect(), skirt }
    }

    /// Takes S_k out of `bands[frustum][band]` ([`BAND`] rows each) and leaves the pixels to keep there; H_k becomes H_{k+1}.
    pub fn step(&mut self, bands: &mut [Vec<Rows>]) {
        for (image, bands) in self.images.iter_mut().zip(bands) {
            image.deepen(self.skirt);
            image.unite(bands);
        }
        let aprons: Vec<_> = (0..self.images.len()).map(|i| self.apron(i)).collect();
        for (image, lines) in self.images.iter_mut().zip(aprons) {
            image.set_apron(&lines);
            erode(image.shape, &image.union, &mut image.hidden);
        }
    }

    /// The pixels across each side of image `i`, in that side's own order.
    fn apron(&self, i: usize) -> [Option<Vec<bool>>; 4] {
        self.images[i].across.map(|across| {
            let a = across?;
            let mut line = self.images[a.frustum as usize].edge(a.side);
            if a.reversed {
                line.reverse();
            }
            Some(line)
        })
    }
}

impl Image {
    /// Sets `deep`; `union` is scratch.
    fn deepen(&mut self, skirt: u32) {
        self.deep.copy_from_slice(&self.hidden);
        for _ in 0..skirt {
            self.union.copy_from_slice(&self.deep);
            erode(self.shape, &self.union, &mut self.deep);
        }
    }

    fn unite(&mut self, bands: &mut [Rows]) {
        let n = self.shape.words;
        let rows = n..n * (self.shape.height as usize + 1);
        let union = self.union[rows.clone()].par_chunks_mut(n * BAND);
        let known = self.hidden[rows.clone()].par_chunks(n * BAND).zip(self.deep[rows].par_chunks(n * BAND));
        union.zip(known).zip(bands.par_iter_mut()).for_each(|((union, (hidden, deep)), rows)| {
            for (i, u) in union.iter_mut().enumerate() {
                let s = &mut rows.filled[i];
                *u = *s | hidden[i];
                *s &= !deep[i];
                rows.hidden[i] = *s & hidden[i];
            }
        });
    }

    /// The pixels along a side of S ∪ H.
    fn edge(&self, side: Side) -> Vec<bool> {
        let Shape { width, height, words } = self.shape;
        let at = |x: u32, y: u32| {
            let row = self.shape.row(y as i32);
            mask::get(&self.union[row..row + words], x as i32)
        };
        match side {
            Side::Left => (0..height).map(|y| at(0, y)).collect(),
            Side::Right => (0..height).map(|y| at(width - 1, y)).collect(),
            Side::Top => (0..width).map(|x| at(x, 0)).collect(),
            Side::Bottom => (0..width).map(|x| at(x, height - 1)).collect(),
        }
    }

    fn put(&mut self, x: i32, y: i32, value: bool) {
        let row = self.shape.row(y);
        mask::put(&mut self.union[row..row + self.shape.words], x, value);
    }

    fn get(&self, x: i32, y: i32) -> bool {
        let row = self.shape.row(y);
        mask::get(&self.union[row..row + self.shape.words], x)
    }

    fn set_apron(&mut self, lines: &[Option<Vec<bool>>; 4]) {
        let (w, h) = (self.shape.width as i32, self.shape.height as i32);
        for (side, line) in SIDES.into_iter().zip(lines) {
            for (i, value) in line.iter().flatten().enumerate() {
                let i = i as i32;
                let (x, y) = match side {
                    Side::Left => (-1, i),
                    Side::Right => (w, i),
                    Side::Top => (i, -1),
                    Side::Bottom => (i, h),
                };
                self.put(x, y, *value);
            }
        }
        for (x, inner_x) in [(-1, 0), (w, w - 1)] {
            for (y, inner_y) in [(-1, 0), (h, h - 1)] {
                let value = self.get(x, inner_y) && self.get(inner_x, y);
                self.put(x, y, value);
            }
        }
    }
}

/// The rows of `from` (apron included) eroded by 3×3.
fn erode(shape: Shape, from: &[u64], into: &mut [u64]) {
    let (n, width) = (shape.words, shape.width);
    let rows = n..n * (shape.height as usize + 1);
    into[rows].par_chunks_mut(n * BAND).enumerate().for_each(|(band, out)| {
        for (i, out) in out.chunks_mut(n).enumerate() {
            let at = (band * BAND + i) * n;
            let (above, rest) = from[at..at + 3 * n].split_at(n);
            let (row, below) = rest.split_at(n);
            mask::erode_row(above, row, below, width, out);
        }
    });
}
