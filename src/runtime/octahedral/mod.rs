//! Drawing octahedral impostors.
//!
//! For every view the direction from the object's centre to the eye selects three frames and their weights
//! ([`Grid::select`](crate::octahedral::Grid::select)). Each pixel's ray is followed through each frame ([`Model`]) from the plane nearest to the
//! frame's camera to the farthest, in a fixed number of steps and bisections, to the first covered point where it crosses the surface. Frames that
//! find one are blended by weight. Frames where the ray passes behind an outline do not count; where those with a surface have less than half the
//! weight of the others nothing is seen.
//!
//! What always holds: colours blend in linear light; a view along a grid direction shows one frame alone; results do not depend on the
//! number of threads. `shaders/octahedral.wgsl` does the same.

mod error;
mod manifest;
mod march;
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
