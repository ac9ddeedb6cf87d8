//! Drawing depth-meshes: Pajarola, Sainz and Meng, *DMesh: Fast Depth-Image Meshing and Warping* (2003), section 6.
//!
//! Several reference views of an object, each a textured triangle mesh, are drawn over each other and blended pixel by
//! pixel. The steps of section 6.1: references are selected and weighted by direction and distance (i, [`select`]); their meshes
//! are given (ii); Z_e is the nearest depth over all of them (iii); every mesh within an offset behind Z_e gives
//! C_i = w_i·ρ̄·(R, G, B, 1) (iv); I = Σ C_i (v) is divided by its alpha (vi).
//!
//! The paper draws every mesh twice. Here each is rasterised once, which finds its nearest fragment at every sample: their
//! minimum is Z_e, and comparing each with it is the second pass. The paper's read-only depth buffer also lets
//! farther fragments of the same mesh pass where they lie within the offset, and keeps whichever is drawn last; here
//! the nearest of each mesh counts, whatever the order of its triangles. `shaders/dmesh.wgsl` does the same.
//!
//! What always holds: colours blend in linear light, the weights of the selected references add up to 1, and results do not
//! depend on the number of threads.

mod blend;
mod draw;
mod error;
mod facet;
mod frames;
mod manifest;
mod model;
mod read;
mod reference;
mod shaders;
mod stand_in;
mod weight;
mod write;

#[cfg(test)]
pub(crate) mod tests;

pub use draw::{Blending, Drawn};
pub use error::DmeshError;
pub use frames::{Frames, Meshes};
pub use manifest::FORMAT;
pub use model::Model;
pub use read::{Bundle, read};
pub use reference::{Dmesh, MAX_REFERENCES, Mesh, Reference};
pub use shaders::{SHADER, SHADERS};
pub use stand_in::DmeshStandIn;
pub use weight::{Selected, Weights, angular_weight, distance_weight, select};
pub use write::{manifest, write};
