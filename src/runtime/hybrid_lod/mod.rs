//! Hybrid textured LOD meshes at run time (Chen et al. 2003, section 3.2): which cell the eye is in, what is drawn there, what is read before it is
//! needed, the shader that draws it with projective texture coordinates and its CPU twin, and a simulator that tells how long a walk has to wait for the disk.

mod cell;
#[cfg(test)]
pub(crate) mod cell_tests;
mod manifest;
pub mod prefetch;
mod shaders;
pub mod simulate;
#[cfg(test)]
mod simulate_tests;

pub use cell::{CellFiles, cell_files, cell_scene, cell_stand_in};
pub use manifest::{FORMAT, MANIFEST, Manifest, ManifestError};
pub use shaders::{SHADER, SHADERS};
