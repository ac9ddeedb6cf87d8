//! `collapse`: fewer triangles, a file or folder per method.

mod quadric;
pub mod voxel_cover;
pub mod voxel_quadric;

pub use quadric::Quadric;
