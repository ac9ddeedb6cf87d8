//! Which voxels can never be seen (Jeschke and Wimmer 2002, section 4.2).
//!
//! H_0 is empty, H_{k+1} = erode3×3(S_k ∪ H_k), and the voxels S_k \ H_k are visible. H is dense, over empty pixels too.
//! Hidden voxels near visible pixels, S_k ∩ H_k \ erode3×3^skirt(H_k), are kept too: see [`super::skirt`].
//! Outside an image everything is empty, except across a shared edge of two cube faces: there the other face's pixels
//! count. At a corner of the cube the missing diagonal neighbour counts as set where both its neighbours are.

use super::{
    mask::{self, Shape},
    samples::Part,
    skirt,
};
use crate::voxel::{Across, Frustum, Side, Voxel, valid::SIDES};
use bytemuck::Zeroable;
use rayon::prelude::*;

/// H and S, for every frustum.
pub struct Hidden {
    images: Vec<Image>,
}

struct Image {
    shape: Shape,
    across: [Option<Across>; 4],
    hidden: Vec<u64>,
    /// S while it is filled, then S ∪ H.
    union: Vec<u64>,
    /// H eroded 1, 2, … `skirt` times: what is hidden deeper.
    deeper: Vec<Vec<u64>>,
}

/// Rows that one task works on.
const BAND: usize = 32;

impl Hidden {
    pub fn new(frusta: &[Frustum], skirt: u32) -> Self {
        let image = |f: &Frustum| {
            let shape = Shape::new(f.size[0], f.size[1]);
            let zeros = || shape.zeros();
            let deeper = (0..skirt).map(|_| zeros()).collect();
            Image { shape, across: f.across, hidden: zeros(), union: zeros(), deeper }
        };
        Self { images: frusta.iter().map(image).collect() }
    }

    /// Adds pixels to S_k of a frustum.
    pub fn fill<'a>(&mut self, frustum: usize, parts: impl IntoIterator<Item = &'a Part>) {
        let image = &mut self.images[frustum];
        for part in parts {
            image.union[image.shape.row(part.y.into()) + part.word as usize] |= part.bits;
        }
    }

    /// The voxels of S_k to keep, in each frustum by (y, x), without colour; those that are hidden have the ring
    /// [`skirt::UNREACHED`]. H_k becomes H_{k+1}, and S is empty again.
    pub fn step(&mut self, layer: u16) -> Vec<Vec<Voxel>> {
        let kept = self.images.iter_mut().map(|image| {
            image.deepen();
            image.unite(layer)
        });
        let kept = kept.collect();
        let aprons: Vec<_> = (0..self.images.len()).map(|i| self.apron(i)).collect();
        for (image, lines) in self.images.iter_mut().zip(aprons) {
            image.set_apron(&lines);
            erode(image.shape, &image.union, &mut image.hidden);
            image.union.fill(0);
        }
        kept
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
    fn deepen(&mut self) {
        let mut from = &self.hidden;
        for deeper in &mut self.deeper {
            erode(self.shape, from, deeper);
            from = deeper;
        }
    }

    /// Makes S ∪ H of S; the voxels to keep.
    fn unite(&mut self, layer: u16) -> Vec<Voxel> {
        let n = self.shape.words;
        let rows = n..n * (self.shape.height as usize + 1);
        let (hidden, deeper) = (&self.hidden, &self.deeper);
        let deepest = deeper.last().unwrap_or(hidden);
        let bands = self.union[rows].par_chunks_mut(n * BAND).enumerate().map(|(band, union)| {
            let mut voxels = Vec::new();
            for (i, word) in union.iter_mut().enumerate() {
                let at = n + band * n * BAND + i;
                let kept = *word & !deepest[at];
                *word |= hidden[at];
                if kept == 0 {
                    continue;
                }
                // As deep as the voxel itself, and deeper: visible and hidden, hidden and hidden deeper, …
                let mut inside = [0; 4];
                let mut here = kept;
                for deep in std::iter::once(hidden).chain(deeper) {
                    let rest = here & deep[at];
                    here &= !deep[at];
                    let left = deep[at] << 1 | if i % n > 0 { deep[at - 1] >> 63 } else { 0 };
                    let right = deep[at] >> 1 | if i % n + 1 < n { deep[at + 1] << 63 } else { 0 };
                    for (side, beside) in [left, right, deep[at - n], deep[at + n]].into_iter().enumerate() {
                        inside[side] |= here & beside;
                    }
                    here = rest;
                }
                let mut rest = kept;
                while rest != 0 {
                    let bit = rest.trailing_zeros();
                    rest &= rest - 1;
                    let sides = inside.iter().enumerate().map(|(side, bits)| ((bits >> bit & 1) as u8) << side);
                    voxels.push(Voxel {
                        x: (i % n * 64 + bit as usize - 1) as u16,
                        y: (band * BAND + i / n) as u16,
                        layer,
                        ring: if hidden[at] >> bit & 1 == 1 { skirt::UNREACHED } else { 0 },
                        inside: sides.sum(),
                        ..Voxel::zeroed()
                    });
                }
            }
            voxels
        });
        bands.collect::<Vec<_>>().concat()
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
