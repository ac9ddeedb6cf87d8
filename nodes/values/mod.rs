//! How the values that flow on edges are stored: `Artifact` for scenes, cameras, captures, cells, fields, meshes, factors, bounds, ceilings, sprites and octahedral impostors.

mod bound;
mod camera;
mod capture;
mod ceiling;
mod charted_mesh;
mod depth_meshes;
mod factor;
mod lod;
mod octahedral;
mod region_tree;
mod relief;
mod scene;
mod slices;
mod sprite;
mod textures;
mod view_cell;
mod voxel_mesh;

pub use bound::Bound;
pub use ceiling::Ceiling;
pub use factor::Factor;
pub use sprite::{ChosenDirection, Sprite};
