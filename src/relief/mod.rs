//! Relief impostors: an object as a few height fields seen from all sides (Andújar et al., "Omni-directional Relief Impostors", 2007).
//!
//! A [`ReliefMap`] is what one orthographic camera sees, on a square of texels. [`Field`] is a map ready for rays, [`trace`] intersects one ray
//! with it, and [`resolve`] chooses among the surfaces that several maps show in one pixel. [`coverage`] and [`select`] decide which maps a
//! direction of view needs, and up to which size on the screen they may be used.

mod cell;
pub mod choose;
#[cfg(test)]
mod choose_tests;
pub mod coverage;
pub mod coverage_picture;
pub mod entropy;
#[cfg(test)]
mod entropy_tests;
mod field;
mod map;
pub mod measure;
mod pyramid;
mod resample;
pub mod select;
mod strategy;
pub mod textures;
mod trace;

pub use field::{Field, Ray};
pub use map::{DepthBits, MapFault, REACHES, ReliefMap};
pub use resample::{Resampling, resample};
pub use strategy::{Candidate, Strategy, resolve};
pub use trace::{Hit, Search, Trace, trace};

#[cfg(test)]
pub(crate) mod tests;
