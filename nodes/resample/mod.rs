//! `resample`: textures for simplified meshes, a file per method.

mod voxels;

pub use voxels::Voxels;

#[cfg(test)]
mod tests;
