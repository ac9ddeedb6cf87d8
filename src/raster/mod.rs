//! The rasteriser: which surfaces a view's pixels see, and how they look there. Here is the preparation that every back end shares
//! and the one that runs on the CPU; [`Backend`] is what another has to do.
//!
//! Coverage is decided in fixed point (vertices snapped to 1/256 px) by the top-left rule; equal depths are ordered
//! by triangle number. Shading is deferred: operations return triangle numbers, a [`Shader`] turns them into colour.
//!
//! What always holds: a triangle's number is its place among all triangles of the scene, objects in their sorted order,
//! parts and triangles in theirs; results do not depend on the number of threads or on how a view is cut into tiles.
//! Backs of single-sided materials are not drawn unless [`Options`] says so. Texels of a masked material whose alpha lies below
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
mod memo;
mod nearest;
mod noise;
mod patch;
mod prepare;
mod render;
mod samples;
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
pub use geometry::{Geometry, TriangleOrigin};
pub use light::{Gloss, Light};
pub use nearest::{NOTHING, Nearest, nearest, nearest_in_tiles};
pub use noise::Noise;
pub(crate) use prepare::faces_any;
pub use prepare::{Prepared, ScreenTriangle};
pub use render::{Rendered, Rendering, picture, render};
pub use shade::{Finish, Shader, Shading, Surface};
pub use tile::Tile;

pub(crate) use camera::Camera;
pub(crate) use geometry::Cutout;
pub(crate) use memo::Memo;
pub(crate) use patch::{Holes, Patch};
pub(crate) use samples::Samples;
pub(crate) use shade::{Facet, Layer};
pub(crate) use texture::{Coordinates, Mips, Role, texel_at};
pub(crate) use tile::TileGrid;

use glam::DVec3;

/// What the rasteriser leaves out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    pub sides: Sides,
}

/// Which sides of single-sided materials are there. Double-sided ones show both whatever is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Sides {
    /// Those that face the view, as engines draw.
    #[default]
    Facing,
    /// Those that face one of these points (metres, world): what a view cell with these corners can see.
    FacingAny([DVec3; 8]),
    /// Both: a ray through a closed solid meets its back too.
    Both,
}

impl Options {
    /// With the backs of single-sided materials.
    pub const BOTH: Self = Self { sides: Sides::Both };
}
