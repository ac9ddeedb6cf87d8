//! farfield bakes distant geometry into image-based stand-ins.

pub mod array;
pub mod atlas;
pub mod certify;
pub mod cli;
pub mod engine;
pub mod formats;
pub mod image;
pub mod math;
pub mod mesh;
pub mod raster;
pub mod scene;
pub mod voxel;

#[path = "../nodes/mod.rs"]
pub mod nodes;
