//! Mesh algorithms that know nothing of voxels or scenes, and the textured mesh that stands between
//! resampling and the atlas.

pub mod card;
pub mod simplify;

use crate::array::Array;

/// A mesh whose faces have their texels in charts of their own, not yet in an atlas.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChartedMesh {
    /// World space, metres, exact in 32 bits: what the positions are relative to.
    pub origin: [f64; 3],
    /// Metres.
    pub positions: Array<[f32; 3]>,
    /// Texel units within the vertex's chart, (0, 0) its top left corner; a vertex belongs to one chart.
    pub uv: Array<[f32; 2]>,
    /// Counter-clockwise seen from the view cell.
    pub triangles: Array<[u32; 3]>,
    /// Chart of every triangle.
    pub chart_of: Array<u32>,
    /// Width and height of every chart in texels, margin included.
    pub chart_size: Array<[u32; 2]>,
    /// The charts' texels one after the other, row by row; sRGB, alpha 255 where the texel is filled.
    pub color: Array<[u8; 4]>,
    /// World-space normals as RGB = (n + 1)/2 · 255 in the same layout, or empty.
    pub normal: Array<[u8; 4]>,
    /// The largest displacement on the screen that the method allows for this mesh, pixels of the output image.
    pub bound_px: f64,
}
