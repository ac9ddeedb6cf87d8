//! Layered voxel fields seen from a view cell (Jeschke and Wimmer 2002, section 4) and the meshes that cover them.
//!
//! Every frustum has its own *voxel space*: x to the right, y down, in pixels of the frustum's image, z the layer
//! number, 0 the nearest. One step of a layer and one pixel have the same length there (section 4.3).

pub mod assemble;
pub mod columns;
pub mod cover_mesh;
pub mod field_scene;
pub mod frusta;
pub mod gaps;
pub mod lattice;
pub mod layers;
pub mod near;
pub mod outline;
pub mod overlap;
pub mod reproject;
pub mod resample;
pub mod shear;
mod sites;
pub mod slicing;
#[cfg(test)]
pub mod testing;
pub mod touch;
pub mod valid;
mod voxel_mesh;

use crate::{array::Array, view::Cell};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// How a cell's surroundings are cut into frusta and layers. Distances are planar depths from the cell's centre, metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Slices {
    pub cell: Cell,
    /// One frustum, or faces of the cube around the cell.
    pub frusta: Vec<Frustum>,
    /// Sampling layers s_l, strictly ascending (0 is the nearest).
    pub layers: Vec<f64>,
    /// `layers.len() + 1` borders: layer l holds what lies between `borders[l]` and `borders[l + 1]`,
    /// `borders[l] < layers[l] < borders[l + 1]`; the last may be infinite.
    pub borders: Vec<f64>,
    /// The parallax angle that the placement keeps, radians.
    pub alpha: f64,
}

/// A frustum with its apex at the cell's centre and its image's window in tangents.
#[derive(Clone, Debug, PartialEq)]
pub struct Frustum {
    pub right: DVec3,
    pub up: DVec3,
    pub forward: DVec3,
    /// Tangents of the window's sides: left < right, bottom < top.
    pub left: f64,
    pub right_tan: f64,
    pub bottom: f64,
    pub top: f64,
    /// Pixels of a layer: width, height.
    pub size: [u32; 2],
    /// The frustum across the left, right, top and bottom side of the image, where one shares that edge (cube faces only).
    pub across: [Option<Across>; 4],
}

/// Where a side of an image continues: pixel i along this side (from the top, or from the left) lies next to
/// pixel i (or n−1−i if `reversed`) along side `side` of frustum `frustum`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Across {
    pub frustum: u32,
    pub side: Side,
    pub reversed: bool,
}

/// A side of a frustum's image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Left = 0,
    Right = 1,
    Top = 2,
    Bottom = 3,
}

impl Side {
    /// Pixels to the neighbour on that side, right and down.
    pub fn step(self) -> [i32; 2] {
        match self {
            Side::Left => [-1, 0],
            Side::Right => [1, 0],
            Side::Top => [0, -1],
            Side::Bottom => [0, 1],
        }
    }
}

/// One visible voxel. Order: by (layer, y, x).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Voxel {
    pub x: u16,
    pub y: u16,
    pub layer: u16,
    /// 0: visible. Otherwise hidden, and part of the skirt: so many steps from the next visible voxel.
    pub ring: u8,
    /// Bit [`Side`] is set where the neighbour on that side of the layer lies deeper among what is hidden than this voxel:
    /// nothing that is seen faces it.
    pub inside: u8,
    /// sRGB colour; the fourth is the share of the pixel's samples in which its surface lies, 255: all.
    pub color: [u8; 4],
    /// Unit normal in world space, octahedral, scaled to ±32767; (0, 0, 1) where unknown.
    pub normal: [i16; 2],
    /// Number into the field's object table.
    pub object: u32,
}

/// sRGB colours of a voxel's quarters: top left, top right, bottom left, bottom right. The fourth byte is 255.
pub type Quarters = [[u8; 4]; 4];

/// The visible voxels of one frustum.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Field {
    /// Index into [`Slices::frusta`].
    pub frustum: u32,
    /// Sorted by (layer, y, x), no two equal.
    pub voxels: Array<Voxel>,
    /// Colours finer than the voxels, see [`Quarters`]: one for each voxel, or none.
    pub quarters: Array<Quarters>,
    /// Names of the objects seen, sorted.
    pub objects: Vec<String>,
}

/// A connected mesh over voxels of one frustum: the initial mesh (section 5), and what `collapse` leaves of it (section 6).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VoxelMesh {
    /// Index into [`Slices::frusta`].
    pub frustum: u32,
    /// Voxel space, x and y in quarter pixels (pixel p has vertices at 4p+1 and 4p+3; a seam lies at 4·size or 0), z the layer.
    pub vertices: Array<[i32; 3]>,
    /// Bit 0: locked (lies on a seam between frusta and may not move).
    pub flags: Array<u8>,
    /// Vertex numbers, counter-clockwise seen from the cell's centre where the face is not a wall.
    pub faces: Array<[u32; 3]>,
    /// Voxels that face f covers: `cover[cover_start[f]..cover_start[f + 1]]`, numbers into `voxels`.
    pub cover_start: Array<u32>,
    pub cover: Array<u32>,
    /// This mesh's own voxels, sorted by (layer, y, x).
    pub voxels: Array<Voxel>,
    /// Colours of their quarters: one for each voxel, or none.
    pub quarters: Array<Quarters>,
    /// By which factor the voxel boxes were enlarged when the mesh was simplified (section 6); 0: not simplified.
    pub factor: f64,
    /// Whether its outline is cut by alpha: boundaries may lie outside of the surface then.
    pub alpha: bool,
}

#[cfg(test)]
mod cover_tests;
