//! Compression (section 4.3) and the test on what it gives (section 4.4).
//!
//! All layouts are lossless; sizes are counted in values of 32 bits, as the paper's table 1 counts them. Depths of `rows` and `runs` may
//! be rounded to 16 bits first, see [`DepthQuantizer`]: then a range takes one value instead of two.
//!
//! - `raw`: the d layers, the paper's cropped image: n·d values.
//! - `ranges`: the paper's index and range segments in one texture of two channels and side ⌈√(|IS| + |RS|)⌉. Offsets are whole
//!   numbers, as floats would hold them exactly up to 2²⁴ only, count from the texture's beginning, and 0 means no range: 2·(n + r).
//! - `rows`: for each row the number of ranges before it, for each texel the number of ranges before it in its row, in 16
//!   bits: h + 1 + n/2 + 2·r. Where a row holds more than 65,535 ranges this layout does not exist.
//! - `runs`: for each row where its runs begin, and for each run of neighbouring texels with equally many ranges, at least one, its
//!   first texel, its length, their number of ranges and the first of them: h + 1 + 3·runs + 2·r. For convex shapes.

use super::{
    DepthQuantizer, LayeredDepthImage, Region,
    grid::Ranges,
    layered::{INVALID, texel},
};
use std::ops::Range;

/// How an image is packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Layout {
    Raw,
    Ranges,
    Rows,
    Runs,
}

impl Layout {
    pub const ALL: [Self; 4] = [Self::Raw, Self::Ranges, Self::Rows, Self::Runs];

    /// As it stands in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Ranges => "ranges",
            Self::Rows => "rows",
            Self::Runs => "runs",
        }
    }
}

/// A part of a packed image's file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    pub name: &'static str,
    /// What it holds: `u16x2` are two numbers side by side.
    pub element: &'static str,
    pub count: usize,
    /// Its first byte.
    pub offset: usize,
}

/// A packed image.
#[derive(Clone, Debug, PartialEq)]
pub struct Packed {
    size: [u32; 2],
    region: Region,
    depth_complexity: u32,
    data: Data,
}

#[derive(Clone, Debug, PartialEq)]
enum Data {
    /// Layer by layer.
    Raw { depths: Vec<f32> },
    /// (offset, count) for every texel, then (start, end) of every range as the bits of floats, then zeros.
    Ranges { side: u32, ranges: usize, texels: Vec<[u32; 2]> },
    /// `before[row]` ranges come before the row, `prefix[texel]` of its row before the texel.
    Rows { before: Vec<u32>, prefix: Vec<u16>, ranges: Ranges },
    /// The runs of a row are `runs[first[row]..first[row + 1]]`, by their first texel. `blocks` is made from them and stored nowhere: for
    /// every [`BLOCK`] texels of every row the first run of the row that ends in or behind them.
    Runs { first: Vec<u32>, runs: Vec<Run>, blocks: Vec<u32>, ranges: Ranges },
}

/// Texels for which a search among the runs of a row begins at the same one.
const BLOCK: usize = 32;

/// Neighbouring texels of a row with equally many ranges.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::NoUninit)]
struct Run {
    /// Column of the first.
    x: u16,
    length: u16,
    /// Ranges of each texel.
    count: u32,
    /// First range of the first texel.
    start: u32,
}

impl Packed {
    /// `None` where the layout cannot hold the image: `rows` no row with more than 65,535 ranges, `rows` and `runs` no region wider
    /// than 65,535 texels, none of them more than 2³² − 1 values.
    pub fn new(image: &LayeredDepthImage, layout: Layout) -> Option<Self> {
        let data = match layout {
            Layout::Raw => raw(image)?,
            Layout::Ranges => ranges(image)?,
            Layout::Rows => rows(image, Ranges::floats(image))?,
            Layout::Runs => runs(image, Ranges::floats(image))?,
        };
        Some(Self::of(image, data))
    }

    /// As [`Packed::new`] with depths of 16 bits, to which those of the image are rounded; `None` also for `raw` and `ranges`, which have
    /// no such form.
    pub fn short(image: &LayeredDepthImage, layout: Layout, grid: DepthQuantizer) -> Option<Self> {
        let data = match layout {
            Layout::Raw | Layout::Ranges => return None,
            Layout::Rows => rows(image, Ranges::shorts(image, grid))?,
            Layout::Runs => runs(image, Ranges::shorts(image, grid))?,
        };
        Some(Self::of(image, data))
    }

    fn of(image: &LayeredDepthImage, data: Data) -> Self {
        Self { size: image.size(), region: image.region(), depth_complexity: image.depth_complexity(), data }
    }

    /// In the layout with the fewest values, with depths of 16 bits if there is a grid; of equals the first of [`Layout::ALL`]. `None`
    /// where none holds the image.
    pub fn smallest(image: &LayeredDepthImage, grid: Option<DepthQuantizer>) -> Option<Self> {
        let new = |layout| grid.map_or_else(|| Self::new(image, layout), |grid| Self::short(image, layout, grid));
        Layout::ALL.into_iter().filter_map(new).min_by_key(Self::values)
    }

    /// That of its depths, where they have 16 bits.
    pub fn grid(&self) -> Option<DepthQuantizer> {
        match &self.data {
            Data::Rows { ranges, .. } | Data::Runs { ranges, .. } => ranges.grid(),
            Data::Raw { .. } | Data::Ranges { .. } => None,
        }
    }

    pub fn layout(&self) -> Layout {
        match self.data {
            Data::Raw { .. } => Layout::Raw,
            Data::Ranges { .. } => Layout::Ranges,
            Data::Rows { .. } => Layout::Rows,
            Data::Runs { .. } => Layout::Runs,
        }
    }

    /// Texels of the whole image.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Most depths of a texel.
    pub fn depth_complexity(&self) -> u32 {
        self.depth_complexity
    }

    pub fn region(&self) -> Region {
        self.region
    }

    /// Values of 32 bits, without what only fills up the texture.
    pub fn values(&self) -> usize {
        match &self.data {
            Data::Raw { depths } => depths.len(),
            Data::Ranges { ranges, .. } => 2 * (self.region.texels() + ranges),
            Data::Rows { before, prefix, ranges } => before.len() + prefix.len().div_ceil(2) + ranges.values(),
            Data::Runs { first, runs, ranges, .. } => first.len() + 3 * runs.len() + ranges.values(),
        }
    }

    /// The texture of the layout `ranges`: its side in texels, and the bits of its two channels, row by row.
    pub fn texture(&self) -> Option<(u32, &[[u32; 2]])> {
        match &self.data {
            Data::Ranges { side, texels, .. } => Some((*side, texels)),
            _ => None,
        }
    }

    /// What readers find in a file: the layout's sections in their order, little-endian, each at a multiple of 16 bytes.
    pub fn file(&self) -> (Vec<u8>, Vec<Section>) {
        let (mut bytes, mut sections) = (Vec::new(), Vec::new());
        let mut put = |name, element, count: usize, section: &[u8]| {
            bytes.resize(bytes.len().next_multiple_of(16), 0);
            sections.push(Section { name, element, count, offset: bytes.len() });
            bytes.extend_from_slice(section);
        };
        match &self.data {
            Data::Raw { depths } => put("depths", "f32", depths.len(), bytemuck::cast_slice(depths)),
            Data::Ranges { texels, .. } => put("texels", "u32x2", texels.len(), bytemuck::cast_slice(texels)),
            Data::Rows { before, prefix, ranges } => {
                put("before", "u32", before.len(), bytemuck::cast_slice(before));
                put("prefix", "u16", prefix.len(), bytemuck::cast_slice(prefix));
                put("ranges", ranges.element(), ranges.len(), ranges.bytes());
            }
            Data::Runs { first, runs, ranges, .. } => {
                put("first", "u32", first.len(), bytemuck::cast_slice(first));
                put("runs", "u16x2 u32x2", runs.len(), bytemuck::cast_slice(runs));
                put("ranges", ranges.element(), ranges.len(), ranges.bytes());
            }
        }
        (bytes, sections)
    }

    /// The image that was packed.
    pub fn unpack(&self) -> LayeredDepthImage {
        LayeredDepthImage::from_region(self.size, self.region, (0..self.region.texels()).map(|i| self.ray(i)))
    }

    /// The depths of texel `i` of the region.
    fn ray(&self, i: usize) -> Vec<f32> {
        let width = self.region.width as usize;
        match &self.data {
            Data::Raw { depths } => {
                let n = self.region.texels();
                let ray = depths.iter().skip(i).step_by(n).copied();
                ray.take_while(|d| *d != INVALID).collect()
            }
            Data::Ranges { texels, .. } => {
                let [offset, count] = texels[i];
                let list = &texels[offset as usize..offset as usize + count as usize];
                list.iter().flatten().map(|bits| f32::from_bits(*bits)).collect()
            }
            Data::Rows { before, prefix, ranges } => ranges.depths(row_ranges(width, before, prefix, i)),
            Data::Runs { first, runs, blocks, ranges } => ranges.depths(run_ranges(width, first, runs, blocks, i)),
        }
    }

    /// The parity test (figure 13); the same as [`LayeredDepthImage::contains`].
    #[inline]
    pub fn contains(&self, point: [f32; 3]) -> bool {
        let Some(i) = texel(self.size, &self.region, point) else { return false };
        let (z, width) = (point[2], self.region.width as usize);
        match &self.data {
            Data::Raw { depths } => {
                let n = self.region.texels();
                for k in (0..self.depth_complexity as usize).step_by(2) {
                    // Ranges are sorted: what begins deeper, and all that is invalid, cannot hold the point.
                    if depths[k * n + i] > z {
                        return false;
                    }
                    if z <= depths[(k + 1) * n + i] && depths[k * n + i] != INVALID {
                        return true;
                    }
                }
                false
            }
            Data::Ranges { texels, .. } => {
                let [offset, count] = texels[i];
                let list = &texels[offset as usize..offset as usize + count as usize];
                list.iter().any(|[s, e]| f32::from_bits(*s) <= z && z <= f32::from_bits(*e))
            }
            Data::Rows { before, prefix, ranges } => ranges.hold(row_ranges(width, before, prefix, i), z),
            Data::Runs { first, runs, blocks, ranges } => ranges.hold(run_ranges(width, first, runs, blocks, i), z),
        }
    }
}

impl Packed {
    /// The parity test on many points: what [`Packed::contains`] says of each. Quicker than one by one, because a block's ranges are looked up
    /// before any of them is compared: memory answers for several points at once.
    ///
    /// # Panics
    /// Where `inside` has another length than `points`.
    pub fn contain(&self, points: &[[f32; 3]], inside: &mut [bool]) {
        assert_eq!(points.len(), inside.len(), "an answer for every point");
        let width = self.region.width as usize;
        match &self.data {
            Data::Raw { .. } => inside.iter_mut().zip(points).for_each(|(inside, p)| *inside = self.contains(*p)),
            Data::Ranges { texels, .. } => {
                let list = |i: usize| texels[i][0] as usize..(texels[i][0] + texels[i][1]) as usize;
                let hold = |list: Range<usize>, z: f32| {
                    texels[list].iter().any(|[s, e]| f32::from_bits(*s) <= z && z <= f32::from_bits(*e))
                };
                self.in_blocks(points, inside, list, hold);
            }
            Data::Rows { before, prefix, ranges } => {
                let list = |i| row_ranges(width, before, prefix, i);
                self.in_blocks(points, inside, list, |list, z| ranges.hold(list, z));
            }
            Data::Runs { first, runs, blocks, ranges } => {
                let list = |i| run_ranges(width, first, runs, blocks, i);
                self.in_blocks(points, inside, list, |list, z| ranges.hold(list, z));
            }
        }
    }

    #[inline]
    fn in_blocks(
        &self,
        points: &[[f32; 3]],
        inside: &mut [bool],
        list: impl Fn(usize) -> Range<usize>,
        hold: impl Fn(Range<usize>, f32) -> bool,
    ) {
        const POINTS: usize = 64;
        let mut lists = [const { 0..0 }; POINTS];
        for (points, inside) in points.chunks(POINTS).zip(inside.chunks_mut(POINTS)) {
            for (place, p) in lists.iter_mut().zip(points) {
                *place = texel(self.size, &self.region, *p).map_or(0..0, &list);
            }
            for ((inside, place), p) in inside.iter_mut().zip(&lists).zip(points) {
                *inside = hold(place.clone(), p[2]);
            }
        }
    }
}

/// The ranges of texel `i` of the layout `rows`.
#[inline]
fn row_ranges(width: usize, before: &[u32], prefix: &[u16], i: usize) -> Range<usize> {
    let (row, last) = (i / width, (i + 1).is_multiple_of(width));
    let start = before[row] as usize;
    let end = if last { before[row + 1] as usize } else { start + usize::from(prefix[i + 1]) };
    start + usize::from(prefix[i])..end
}

/// The ranges of texel `i` of the layout `runs`.
#[inline]
fn run_ranges(width: usize, first: &[u32], runs: &[Run], blocks: &[u32], i: usize) -> Range<usize> {
    let (row, x) = (i / width, i % width);
    let begin = blocks[row * width.div_ceil(BLOCK) + x / BLOCK];
    for run in &runs[begin as usize..first[row + 1] as usize] {
        let Some(along) = x.checked_sub(usize::from(run.x)) else { break };
        if along < usize::from(run.length) {
            let from = run.start as usize + along * run.count as usize;
            return from..from + run.count as usize;
        }
    }
    0..0
}

/// See [`Data::Runs`].
fn blocks(width: usize, first: &[u32], runs: &[Run]) -> Vec<u32> {
    let mut blocks = Vec::with_capacity((first.len() - 1) * width.div_ceil(BLOCK));
    for row in first.windows(2) {
        let mut at = row[0];
        for x in (0..width).step_by(BLOCK) {
            while at < row[1] && usize::from(runs[at as usize].x) + usize::from(runs[at as usize].length) <= x {
                at += 1;
            }
            blocks.push(at);
        }
    }
    blocks
}

fn raw(image: &LayeredDepthImage) -> Option<Data> {
    let layers = image.depth_complexity();
    u32::try_from(layers as usize * image.region().texels()).ok()?;
    Some(Data::Raw { depths: (0..layers as usize).flat_map(|i| image.layer(i)).collect() })
}

/// Extract and pack.
fn ranges(image: &LayeredDepthImage) -> Option<Data> {
    let n = image.region().texels();
    let filled = n + image.depths().len() / 2;
    u32::try_from(filled).ok()?;
    let mut side = (filled as f64).sqrt() as u32;
    while (side as usize).pow(2) < filled {
        side += 1;
    }
    let (mut texels, mut offset) = (Vec::with_capacity((side as usize).pow(2)), n as u32);
    for i in 0..n {
        let count = image.ray(i).len() as u32 / 2;
        texels.push(if count == 0 { [0, 0] } else { [offset, count] });
        offset += count;
    }
    texels.extend(image.depths().chunks_exact(2).map(|r| [r[0].to_bits(), r[1].to_bits()]));
    texels.resize((side as usize).pow(2), [0, 0]);
    Some(Data::Ranges { side, ranges: filled - n, texels })
}

fn rows(image: &LayeredDepthImage, ranges: Ranges) -> Option<Data> {
    let region = image.region();
    u16::try_from(region.width).ok()?;
    let (mut before, mut prefix) = (vec![0u32], Vec::with_capacity(region.texels()));
    for row in 0..region.height as usize {
        let mut count = 0;
        for x in 0..region.width as usize {
            prefix.push(u16::try_from(count).ok()?);
            count += image.ray(row * region.width as usize + x).len() / 2;
        }
        before.push(before[row].checked_add(u32::try_from(count).ok()?)?);
    }
    Some(Data::Rows { before, prefix, ranges })
}

fn runs(image: &LayeredDepthImage, ranges: Ranges) -> Option<Data> {
    let region = image.region();
    u16::try_from(region.width).ok()?;
    let (mut first, mut runs, mut start) = (vec![0u32], Vec::<Run>::new(), 0u32);
    for row in 0..region.height as usize {
        let mut last: Option<Run> = None;
        for x in 0..region.width as usize {
            let count = image.ray(row * region.width as usize + x).len() as u32 / 2;
            match &mut last {
                Some(run) if run.count == count => run.length += 1,
                _ => {
                    runs.extend(last.filter(|run| run.count > 0));
                    last = Some(Run { x: x as u16, length: 1, count, start });
                }
            }
            start += count;
        }
        runs.extend(last.filter(|run| run.count > 0));
        first.push(u32::try_from(runs.len()).ok()?);
    }
    Some(Data::Runs { blocks: blocks(region.width as usize, &first, &runs), first, runs, ranges })
}
