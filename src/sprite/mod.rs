//! Volumetric depth sprites: layered depth images of solids, in which a point is inside or outside (Trapp and Döllner,
//! *Efficient Representation of Layered Depth Images for Real-time Volumetric Tests*, 2008).
//!
//! A solid is *peeled* along one direction: every ray through the unit cube around it keeps all depths at which it crosses
//! the surface. They come in pairs, which are the ranges of the ray that lie inside. The image is *cropped* to the texels
//! that hold any, and *packed* into the smallest of several layouts, each of which answers the *parity test* directly.

/// Parity test, eight-corner test and rays for shaders: WGSL, with its bindings.
pub const SHADER: &str = include_str!("../../shaders/sprite.wgsl");
/// An entry point that classifies points; comes after [`SHADER`].
pub const CLASSIFY: &str = include_str!("../../shaders/classify.wgsl");
/// [`SHADER`] with [`CLASSIFY`] in other languages, translated by naga; `tests/shaders.rs` keeps them current.
pub const GLSL: &str = include_str!("../../shaders/translated/sprite.comp");
pub const HLSL: &str = include_str!("../../shaders/translated/sprite.hlsl");
pub const METAL: &str = include_str!("../../shaders/translated/sprite.metal");
pub const SPIRV: &[u8] = include_bytes!("../../shaders/translated/sprite.spv");

mod direction;
mod draw;
mod exact;
mod grid;
mod layered;
mod membrane;
mod overlap;
mod packed;
mod peel;
pub mod read;
mod solid;
mod volume;
mod winding;

#[cfg(test)]
mod effect_tests;
#[cfg(test)]
mod membrane_tests;
#[cfg(test)]
mod tests;

pub use direction::{Candidate, Direction, candidates, judge, spread};
pub use draw::{Drawing, Effect, Solid, Style, draw};
pub use exact::Exact;
pub use grid::DepthQuantizer;
pub use layered::{LayeredDepthImage, Region};
pub use membrane::Solid as WindingSolid;
pub use overlap::{Overlap, overlap};
pub use packed::{Layout, Packed, Section};
pub use peel::{CubeFrame, OddRay, PeelError, Peeled, Peeling, Repair, peel};
pub use read::{FORMAT as SPRITE_FORMAT, ReadError};
pub use solid::{Closedness, closedness};
pub use volume::{Entry, Placement, Ray, Span, Volume, Zone};
