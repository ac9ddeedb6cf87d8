//! Depths of 16 bits: beyond the paper, and the only form that loses anything.

use super::{LayeredDepthImage, layered::within};
use std::ops::Range;

/// Depths that 16 bits can name: (base + k)/2^exponent for k = 0 to 65,535. They are sums of whole numbers times a power of two, so that every
/// machine computes the same 32-bit float, whether or not it fuses operations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DepthQuantizer {
    exponent: u32,
    base: u32,
}

impl DepthQuantizer {
    /// The finest for the depths of an image; steps of 1/65,536 where they reach through the whole cube.
    pub fn around(image: &LayeredDepthImage) -> Self {
        let least = image.depths().iter().copied().fold(1.0, f32::min);
        let most = image.depths().iter().copied().fold(0.0, f32::max);
        let fine = (17..=23).rev().map(|exponent| Self { exponent, base: Self::steps(exponent, least) });
        let holds = |grid: &Self| Self::steps(grid.exponent, most).saturating_sub(grid.base) <= 65535;
        fine.into_iter().find(holds).unwrap_or(Self { exponent: 16, base: 0 })
    }

    /// From [`DepthQuantizer::parts`]; `None` where a depth would reach 1.
    pub fn from_parts([exponent, base]: [u32; 2]) -> Option<Self> {
        ((16..=23).contains(&exponent) && base < 1 << exponent).then_some(Self { exponent, base })
    }

    /// Exponent and base.
    pub fn parts(&self) -> [u32; 2] {
        [self.exponent, self.base]
    }

    /// Largest change of a depth by rounding, as a share of the cube's side: half a step, and a whole one just below 1.
    pub fn bound(&self) -> f64 {
        f64::from(self.step())
    }

    /// From one depth to the next.
    pub fn step(&self) -> f32 {
        1.0 / (1u32 << self.exponent) as f32
    }

    /// The nearest number of steps, below 1.
    fn steps(exponent: u32, depth: f32) -> u32 {
        let most = (1u32 << exponent) - 1;
        ((f64::from(depth) * f64::from(1u32 << exponent)).round() as u32).min(most)
    }

    fn short(&self, depth: f32) -> u16 {
        Self::steps(self.exponent, depth).saturating_sub(self.base).min(65535) as u16
    }

    #[inline]
    fn depth(&self, short: u16) -> f32 {
        (self.base + u32::from(short)) as f32 * self.step()
    }
}

/// Ranges one after the other, in either form.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Ranges {
    Floats(Vec<[f32; 2]>),
    Shorts(DepthQuantizer, Vec<[u16; 2]>),
}

impl Ranges {
    pub fn floats(image: &LayeredDepthImage) -> Self {
        Self::Floats(image.depths().chunks_exact(2).map(|r| [r[0], r[1]]).collect())
    }

    pub fn shorts(image: &LayeredDepthImage, grid: DepthQuantizer) -> Self {
        Self::Shorts(grid, image.depths().chunks_exact(2).map(|r| [grid.short(r[0]), grid.short(r[1])]).collect())
    }

    pub fn grid(&self) -> Option<DepthQuantizer> {
        match self {
            Self::Floats(_) => None,
            Self::Shorts(grid, _) => Some(*grid),
        }
    }

    pub fn len(&self) -> usize {
        match self {
            Self::Floats(ranges) => ranges.len(),
            Self::Shorts(_, ranges) => ranges.len(),
        }
    }

    /// Of 32 bits.
    pub fn values(&self) -> usize {
        self.bytes().len() / 4
    }

    pub fn element(&self) -> &'static str {
        match self {
            Self::Floats(_) => "f32x2",
            Self::Shorts(..) => "u16x2",
        }
    }

    pub fn bytes(&self) -> &[u8] {
        match self {
            Self::Floats(ranges) => bytemuck::cast_slice(ranges),
            Self::Shorts(_, ranges) => bytemuck::cast_slice(ranges),
        }
    }

    /// The depths of some ranges.
    pub fn depths(&self, of: Range<usize>) -> Vec<f32> {
        match self {
            Self::Floats(ranges) => ranges[of].as_flattened().to_vec(),
            Self::Shorts(grid, ranges) => ranges[of].as_flattened().iter().map(|short| grid.depth(*short)).collect(),
        }
    }

    /// Whether one of some ranges holds a depth.
    #[inline]
    pub fn hold(&self, of: Range<usize>, depth: f32) -> bool {
        match self {
            Self::Floats(ranges) => within(ranges[of].as_flattened(), depth),
            Self::Shorts(grid, ranges) => {
                ranges[of].iter().any(|r| grid.depth(r[0]) <= depth && depth <= grid.depth(r[1]))
            }
        }
    }
}
