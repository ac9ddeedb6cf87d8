//! `collapse`: fewer triangles, a file or folder per method.

pub mod voxel_cover;
pub mod voxel_quadric;
