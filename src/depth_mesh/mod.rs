//! Depth images as adaptively triangulated meshes (Pajarola, Sainz and Meng, *DMesh: Fast depth-image meshing and
//! warping*, 2003, sections 3 to 5).
//!
//! The pixel centres of a [`DepthMap`] form a grid of (2^k+1)² points. A [`Hierarchy`] is the restricted quadtree over
//! that grid: what error a point avoids, and which triangles are rubber sheets between surfaces. From it any number of
//! triangulations follow, for a tolerance in metres ([`Hierarchy::static_mesh`]) or in pixels of another view
//! ([`Hierarchy::view_dependent`]), each crack-free by construction.
//!
//! What always holds: a selection of points is closed under the dependency relation of figure 3 before it is triangulated;
//! triangles with a background corner are never emitted; triangles are counter-clockwise as the reference camera sees
//! them; results do not depend on the number of threads.

mod bounds;
mod edge_error;
mod emit;
mod exact_error;
mod frustum;
mod grid;
mod hierarchy;
mod layers;
mod map;
mod measure;
mod mesh;
mod normals;
mod options;
mod propagate;
mod rays;
mod segment;
mod select;
mod selection;
mod strips;

#[cfg(test)]
mod tests;

pub use emit::Triangulation;
pub use hierarchy::Hierarchy;
pub use layers::{LayerError, MeshedLayer, MeshedView, Meshing, mesh_capture};
pub use map::{DepthMap, MapError, Resampled, resample};
pub use measure::{Measured, measure};
pub use mesh::DepthMesh;
pub use options::{DepthRange, Distance, ErrorMeasure, Options, OptionsError, Propagation, Segmentation};
pub use select::Workspace;
pub use selection::Selection;
pub use strips::Strips;
