//! How the values that flow on edges are stored: `Artifact` for scenes, cells, fields, meshes and bounds.

mod bound;
mod scene;

pub use bound::Bound;
