//! The rasteriser: which surfaces a view's pixels see, and how they look there. Here is the preparation that every back end shares
//! and the one that runs on the CPU; [`Backend`] is what another has to do.
//!
//! Coverage is decided in fixed point (vertices snapped to 1/256 px) by the top-left rule; equal depths are ordered
//! by triangle number. Shading is deferred: operations return triangle numbers, a [`Shader`] turns them into colour.
//!
//! What always holds: a triangle's number is its place among all triangles of the scene, objects in their sorted order,
//! parts and triangles in theirs; results do not depend on the number of threads or on how a view is cut into tiles.
//! Back faces are drawn unless [`Options::cull_back`] says otherwise. Texels of a masked material whose alpha lies below
//! the cutoff are holes; `BLEND` counts as a mask at 0.5. Alpha is read from the base level of its texture, so that a
//! leaf far away is thinned out by sampling and not by an average that falls below the cutoff as a whole.

mod backend;
mod camera;
mod clip;
mod cover;
mod coverage;
mod fragments;
mod geometry;
mod light;
mod nearest;
mod noise;
mod patch;
mod prepare;
mod render;
mod shade;
mod texture;
mod tile;

#[cfg(test)]
pub(crate) mod tests;

pub use backend::{Backend, Cpu, OnFragments, OnNearest};
pub use camera::MAX_SIDE;
pub use clip::Polygon;
pub use coverage::{Coverage, coverage};
pub use fragments::{Fragment, Fragments, TileFragments, fragments, fragments_in_tiles};
pub use geometry::{Geometry, Place};
pub use light::Light;
pub use nearest::{NOTHING, Nearest, nearest, nearest_in_tiles};
pub use noise::Noise;
pub use prepare::{Prepared, ScreenTriangle};
pub use render::{Rendered, Rendering, picture, render};
pub use shade::{Shader, Shading, Surface};
pub use tile::Tile;

pub(crate) use camera::Camera;
pub(crate) use geometry::{Cutout, Draw};
#[cfg(feature = "gpu")]
pub(crate) use nearest::Samples;
pub(crate) use patch::Holes;
pub(crate) use shade::Facet;

/// What the rasteriser leaves out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Skip triangles seen from behind, except those of double-sided materials.
    pub cull_back: bool,
}
