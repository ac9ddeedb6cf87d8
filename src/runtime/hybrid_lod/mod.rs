//! Hybrid textured LOD meshes at run time (Chen et al. 2003, section 3.2): which cell the eye is in, and what is drawn there.

mod cell;
mod manifest;

pub use cell::{CellFiles, cell_files, cell_scene};
pub use manifest::{FORMAT, MANIFEST, Manifest, ManifestError};
