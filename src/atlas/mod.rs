//! Packing charts into atlas pages with gutters that survive mip-maps.
//!
//! [`pack`] places rectangles, [`page`] copies texels and makes the textured scene.

pub mod pack;
pub mod page;

pub use page::{AtlasError, Settings, atlas};
