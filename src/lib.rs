//! farfield bakes distant geometry into image-based stand-ins.

#![warn(clippy::unwrap_used)]

pub mod array;
pub mod atlas;
pub mod capture;
pub mod certify;
pub mod choice;
pub mod cli;
pub mod depth_mesh;
pub mod engine;
pub mod formats;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod image;
pub mod lod;
pub mod math;
pub mod mesh;
pub mod octahedral;
pub mod raster;
pub mod regular;
pub mod relief;
pub mod report;
pub mod runtime;
pub mod scene;
pub mod sprite;
pub mod texture;
pub mod view;
pub mod voxel;

#[path = "../nodes/mod.rs"]
pub mod nodes;

#[cfg(test)]
#[path = "../benches/support/fields.rs"]
mod sample_fields;
