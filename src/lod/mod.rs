//! Hybrid textured LOD meshes (Chen et al., *Rendering complex scenes using spatial subdivision and textured LOD meshes*, Computers & Graphics 27,
//! 2003): for every view cell, each object outside it is a simplified mesh with textures captured from the cell.
//!
//! Everything about a cell is told about its centre: a stand-in does not know where in the world it stands.

pub mod build;
pub mod cluster;
pub mod collapse;
pub mod entry;
pub mod faces;
pub mod levels;
pub mod occluder;
pub mod occlusion;
pub mod outline;
pub mod parallax;
pub mod pixels;
pub mod quadric;
pub mod render;
pub mod simplified;
pub mod subject;
pub mod texture;
pub mod umbra;
pub mod weights;
pub mod window;

#[cfg(test)]
pub(crate) mod tests;
#[cfg(test)]
mod umbra_tests;
