//! `resample`: textures for simplified meshes, a file per method.

mod voxels;

pub use voxels::Resample;

#[cfg(test)]
mod tests;
