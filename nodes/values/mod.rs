//! How the values that flow on edges are stored: `Artifact` for scenes, cells, fields, meshes and bounds.

mod bound;
mod charted_mesh;
mod scene;
mod slices;
mod view_cell;
mod voxel_mesh;

pub use bound::Bound;
