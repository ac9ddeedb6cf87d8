//! Drawing octahedral impostors.
//!
//! For every view the direction from the object's centre to the eye selects three frames and their weights
//! ([`Grid::select`](crate::octahedral::Grid::select)). Each pixel's ray is followed into each frame ([`Model`]): it first meets the plane through
//! the centre that faces the frame's camera, reads the height there, meets the plane at that height, and so on, a fixed number of steps.
//! The samples found there are blended by weight and coverage; where the blended coverage is below one half nothing is seen.
//!
//! What always holds: colours blend in linear light; a view along a grid direction shows one frame alone; results do not depend on the
//! number of threads. `shaders/octahedral.wgsl` does the same.

mod error;
mod manifest;
mod model;
mod preview;
mod read;
mod sample;
mod shaders;
mod stand_in;
mod write;

#[cfg(test)]
pub(crate) mod tests;

pub use error::OctahedralError;
pub use manifest::FORMAT;
pub use model::{Hit, Model};
pub use read::{Bundle, read};
pub use shaders::{SHADER, SHADERS};
pub use stand_in::OctahedralStandIn;
pub use write::{Drawing, MAX_STEPS, Textures, write};
