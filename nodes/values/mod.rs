//! How the values that flow on edges are stored: `Artifact` for scenes, cells, fields, meshes and bounds.

mod bound;
mod charted_mesh;
mod scene;
mod voxel_mesh;
mod slices;
mod view_cell;

pub use bound::Bound;
