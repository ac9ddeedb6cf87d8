//! How scenes are looked at when they are compared.

use super::{shading::Choice, views::Sampling};

/// How scenes are looked at.
#[derive(Clone, Copy, Debug)]
pub struct Viewing {
    pub sampling: Sampling,
    /// Samples of a pixel in x and in y; `sampling.resolution` times this is at most [`crate::raster::MAX_SIDE`].
    pub samples_per_axis: u32,
    pub shading: Choice,
}
