//! What is handed to the shaders: snapped triangles as whole numbers, and the tiles that they touch.

use super::device::GpuError;
use crate::raster::{Prepared, ScreenTriangle};
use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;
use std::ops::Range;

/// `Triangle` of shaders/cover.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Triangle {
    pub corners: [[i32; 2]; 3],
    pub first: [i32; 2],
    pub a: [u32; 2],
    pub b: [u32; 2],
    pub c: [u32; 2],
    pub low: u32,
    pub high: u32,
    pub exponent: i32,
    pub padding: u32,
}

/// `Item` of shaders/cover.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Item {
    pub triangle: u32,
    pub tile: u32,
}

/// `Frame` of shaders/cover.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Frame {
    pub width: u32,
    pub height: u32,
    pub first_row: u32,
    pub columns: u32,
    pub side: u32,
    pub items: u32,
    pub base: u32,
    pub perspective: u32,
    pub round: u32,
}

/// Consecutive triangles of a view.
pub struct Batch {
    /// Number of the first among the view's snapped triangles.
    pub base: u32,
    pub triangles: Vec<Triangle>,
    /// Those of at most 4×4 samples.
    pub small: Vec<Item>,
    pub large: Vec<Item>,
    /// Shaders cannot decide on some of the triangles.
    some_left: bool,
}

impl Triangle {
    /// `None` where the shaders cannot decide: a material with holes, or a plane seen nearly edge-on. The CPU covers those.
    pub fn new(t: &ScreenTriangle, prepared: &Prepared) -> Option<Self> {
        let (grid, perspective) = (&prepared.grid, prepared.camera.perspective);
        let [x0, y0, x1, y1] = t.samples();
        let (x0, y0) = (x0.max(0), y0.max(0));
        let (x1, y1) = (x1.min(grid.width as i32 - 1), y1.min(grid.height as i32 - 1));
        let [a, b, at_corner] = t.plane();
        let c = a * (f64::from(x0) + 0.5) + (b * (f64::from(y0) + 0.5) + at_corner);
        // More than the function changes over all samples from its first value, and from its value at the view's corner.
        let over = |w: u32, h: u32, c: f64| a.abs() * f64::from(w) + b.abs() * f64::from(h) + c.abs();
        let most = over((x1 - x0) as u32 + 1, (y1 - y0) as u32 + 1, c);
        let most_from_corner = over(grid.width, grid.height, at_corner);
        let least = if perspective { 1.0 / f64::from(t.depth[1]) } else { smallest(t.depth) };
        // Whole numbers differ from the function by less than 2^-44 of `most`, what is computed in floats of 64 bits, `c` too, by less
        // than 2^-50 of `most_from_corner`. Where either is more than a quarter of a float's last place anywhere on the triangle, the CPU decides.
        let exact = most < least * (1u64 << 18) as f64 && most_from_corner < least * (1u64 << 24) as f64;
        let ends = if perspective { [t.depth[1], t.depth[0]].map(|z| 1.0 / z) } else { t.depth };
        // Shaders know no floats below the normal ones.
        let normal = ends.iter().chain(&t.depth).all(|z| z.is_normal());
        if t.masked() || !(most > 1e-100 && most < 1e100 && exact && normal) {
            return None;
        }
        let exponent = 60 - libm::ilogb(most);
        let whole = |v: f64| {
            let v = libm::rint(libm::ldexp(v, exponent)) as i64;
            [v as u32, (v >> 32) as u32]
        };
        let [low, high] = ends.map(ordered);
        let [a, b, c] = [a, b, c].map(whole);
        Some(Self { corners: t.corners, first: [x0, y0], a, b, c, low, high, exponent, padding: 0 })
    }
}

/// The smallest absolute value between two depths.
fn smallest([a, b]: [f32; 2]) -> f64 {
    if a <= 0.0 && b >= 0.0 { 0.0 } else { f64::from(a.abs().min(b.abs())) }
}

/// Whole numbers in the order of the floats.
pub fn ordered(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

impl Batch {
    /// The triangles of some of the view's chunks, with the tiles of `tiles` that they may cover.
    pub fn new(prepared: &Prepared, chunks: Range<usize>, base: u32, tiles: Range<u32>) -> Self {
        let mut batch = Self { base, triangles: Vec::new(), small: Vec::new(), large: Vec::new(), some_left: false };
        for chunk in &prepared.chunks()[chunks] {
            let first = batch.triangles.len() as u32;
            let mut known = Vec::with_capacity(chunk.triangles.len());
            for t in &chunk.triangles {
                let triangle = Triangle::new(t, prepared);
                known.push(triangle.is_some());
                batch.some_left |= triangle.is_none();
                batch.triangles.push(triangle.unwrap_or_default());
            }
            for tile in tiles.clone() {
                for &i in chunk.in_tile(tile) {
                    if known[i as usize] {
                        let small = chunk.triangles[i as usize].small();
                        let list = if small { &mut batch.small } else { &mut batch.large };
                        list.push(Item { triangle: first + i, tile });
                    }
                }
            }
        }
        batch
    }
}

/// What one call of an operation works on.
pub struct Work {
    pub frame: Frame,
    pub pixels: usize,
    pub batches: Vec<Batch>,
}

impl Work {
    pub fn new(prepared: &Prepared, band: &Band, room: &Room) -> Result<Self, GpuError> {
        let (view, grid) = (&prepared.view, &prepared.grid);
        let frame = Frame {
            width: view.width,
            height: view.height,
            first_row: band.rows.start,
            columns: grid.columns,
            side: grid.side,
            perspective: u32::from(prepared.camera.perspective),
            ..Frame::default()
        };
        let batches = batches(prepared, room)?.into_par_iter();
        let batches = batches.map(|(chunks, base)| Batch::new(prepared, chunks, base, band.tiles.clone())).collect();
        Ok(Self { frame, pixels: band.rows.len() * view.width as usize, batches })
    }

    /// Whether shaders cannot decide on some of the view's triangles.
    pub fn some_left(&self) -> bool {
        self.batches.iter().any(|b| b.some_left)
    }
}

/// The view's chunks in ranges whose triangles, and the copy that they are uploaded from, take a quarter of the memory, each with
/// the number of its first triangle.
fn batches(prepared: &Prepared, room: &Room) -> Result<Vec<(Range<usize>, u32)>, GpuError> {
    let mut out: Vec<(Range<usize>, u32)> = Vec::new();
    let (mut taken, mut number) = (0, 0);
    for (i, chunk) in prepared.chunks().iter().enumerate() {
        let bytes = (chunk.triangles.len() * size_of::<Triangle>()) as u64;
        if bytes > room.of(8) {
            return Err(GpuError::TooSmall { need: bytes * 8, limit: room.memory });
        }
        match out.last_mut() {
            Some((range, _)) if taken + bytes <= room.of(8) => {
                range.end = i + 1;
                taken += bytes;
            }
            _ => {
                out.push((i..i + 1, number));
                taken = bytes;
            }
        }
        number += chunk.triangles.len() as u32;
    }
    Ok(out)
}

/// Bytes that a device's buffers may take together, and the largest may take.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    pub memory: u64,
    pub largest: u64,
}

impl Room {
    /// The `n`-th part of the memory, or the largest buffer.
    pub fn of(&self, n: u64) -> u64 {
        (self.memory / n).min(self.largest)
    }
}

/// Consecutive rows of tiles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Band {
    pub tiles: Range<u32>,
    /// Pixel rows.
    pub rows: Range<u32>,
}

impl Band {
    fn of(prepared: &Prepared, lines: Range<u32>) -> Self {
        let grid = &prepared.grid;
        Self {
            tiles: lines.start * grid.columns..lines.end * grid.columns,
            rows: lines.start * grid.side..(lines.end * grid.side).min(grid.height),
        }
    }

    /// `None` where it is a single row of tiles.
    pub fn halves(&self, prepared: &Prepared) -> Option<[Self; 2]> {
        let columns = prepared.grid.columns;
        let (first, last) = (self.tiles.start / columns, self.tiles.end / columns);
        let middle = first.midpoint(last);
        (middle > first).then(|| [first..middle, middle..last].map(|lines| Self::of(prepared, lines)))
    }
}

/// The bands of a view whose pixels, at `bytes` each, take a quarter of the memory.
pub fn bands(prepared: &Prepared, room: &Room, bytes: u64) -> Result<Vec<Band>, GpuError> {
    let grid = &prepared.grid;
    let row = u64::from(grid.width) * u64::from(grid.side) * bytes;
    if row > room.of(4) {
        return Err(GpuError::TooSmall { need: row * 4, limit: room.memory });
    }
    let lines = (room.of(4) / row.max(1)).clamp(1, u64::from(grid.rows.max(1))) as u32;
    let firsts = (0..grid.rows).step_by(lines as usize);
    Ok(firsts.map(|first| Band::of(prepared, first..(first + lines).min(grid.rows))).collect())
}

/// The view's snapped triangles by number.
pub struct Table<'a> {
    prepared: &'a Prepared<'a>,
    /// Number of each chunk's first triangle.
    first: Vec<u32>,
    count: u32,
}

impl<'a> Table<'a> {
    pub fn new(prepared: &'a Prepared<'a>) -> Self {
        let chunks = prepared.chunks();
        let mut count = 0;
        let first = chunks.iter().map(|c| {
            count += c.triangles.len() as u32;
            count - c.triangles.len() as u32
        });
        let first = first.collect();
        Self { prepared, first, count }
    }

    /// An error where a device gives a number that no triangle has.
    pub fn get(&self, number: u32) -> Result<&'a ScreenTriangle, GpuError> {
        if number >= self.count {
            let text = format!("it names triangle {number} of {}", self.count);
            return Err(GpuError::Failed(text));
        }
        let chunk = self.first.partition_point(|f| *f <= number) - 1;
        Ok(&self.prepared.chunks()[chunk].triangles[(number - self.first[chunk]) as usize])
    }
}
