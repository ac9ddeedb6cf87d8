//! Octahedral impostors: pictures of an object from a grid of directions, in atlases that engines blend on one card.
//!
//! The layout is the one that engines' impostor shaders share, after Ryan Brucks' for Unreal (*Octahedral Impostors*, 2018): grid points are
//! octahedral coordinates of directions, a view blends the three frames of the triangle that its direction falls into, and each frame is shifted by
//! its depth. Here is what is baked; `crate::runtime::octahedral` draws it.
//!
//! What always holds: every frame is an orthographic picture through one window, a square of side 2·radius around one centre; a frame's side is a
//! power of two texels, and its mip levels are made of its own texels alone.

mod card;
mod grid;
mod levels;
mod pack;

#[cfg(test)]
pub(crate) mod tests;

pub use card::fit_card;
pub use grid::{Grid, Pick, axes};
pub use levels::levels;
pub use pack::{PackError, pack};

use crate::{array::Array, math::Aabb};
use glam::DVec3;

/// Least and greatest side of a frame, texels.
pub const TILES: std::ops::RangeInclusive<u32> = 16..=4096;

/// Greatest side of an atlas, texels.
pub const MAX_ATLAS: u32 = 16384;

/// An object as pictures from all directions of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Impostor {
    pub grid: Grid,
    /// Texels along a frame's side, a power of two in [`TILES`].
    pub tile: u32,
    /// Centre of every frame's window, metres.
    pub centre: DVec3,
    /// Half the side of the windows and half the range of depths, metres, > 0.
    pub radius: f64,
    /// Bounding box of the object, metres.
    pub bounds: Aabb,
    /// Corners of the convex card that holds the object from every direction, counter-clockwise as the eye sees it, 3 to 8. In units of the
    /// radius along the [`axes`] of the direction of view, on the plane through `centre + radius · direction`.
    pub card: Vec<[f64; 2]>,
    /// The base level.
    pub atlas: Atlas,
}

/// The frames of one level side by side: that of grid point (column, row) begins at texel (column, row) · side / grid side; rows from
/// the top. Every image has `side²` texels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Atlas {
    /// Texels.
    pub side: u32,
    /// Base colour, sRGB-encoded, dilated into empty texels; alpha is the share of the texel that the object covers, times 255.
    pub color: Array<[u8; 4]>,
    /// World-space normal as (n + 1)/2 · 255, and the height over the plane through the centre, towards the camera of the frame:
    /// (height/radius + 1)/2 · 255. Both dilated, heights by a few texels; 128 beyond.
    pub normal: Array<[u8; 4]>,
    /// Occlusion, roughness and metallic, linear, dilated; alpha 255. `None` where they were not captured.
    pub orm: Option<Array<[u8; 4]>>,
    /// Emitted light, sRGB-encoded, dilated; alpha 255. `None` where it was not captured or there is none.
    pub emissive: Option<Array<[u8; 4]>>,
}

impl Atlas {
    /// All images, those that are there.
    pub fn images(&self) -> impl Iterator<Item = &Array<[u8; 4]>> {
        [Some(&self.color), Some(&self.normal), self.orm.as_ref(), self.emissive.as_ref()].into_iter().flatten()
    }
}

impl Impostor {
    /// What is wrong with it; `None` where it is as its type says.
    pub fn fault(&self) -> Option<String> {
        let Self { grid, tile, centre, radius, card, atlas, .. } = self;
        if !grid.is_valid() {
            return Some(format!("{} frames a side; expected {}", grid.side, grid.expected()));
        }
        if !TILES.contains(tile) || !tile.is_power_of_two() {
            return Some(format!(
                "frames of {tile} texels; expected a power of two from {} to {}",
                TILES.start(),
                TILES.end()
            ));
        }
        let side = u64::from(grid.side) * u64::from(*tile);
        if side > u64::from(MAX_ATLAS) || side != u64::from(atlas.side) {
            return Some(format!("an atlas of {} texels for {} frames of {tile}", atlas.side, grid.side));
        }
        if let Some(image) = atlas.images().find(|i| i.len() as u64 != side * side) {
            return Some(format!("an atlas image of {} texels, expected {side}²", image.len()));
        }
        if !(centre.is_finite() && radius.is_finite() && *radius > 0.0) {
            return Some(format!("a window around {centre} with a radius of {radius}"));
        }
        if !(3..=8).contains(&card.len()) || !card.iter().flatten().all(|v| v.is_finite()) {
            return Some(format!("a card of {} corners; expected 3 to 8 that are finite", card.len()));
        }
        None
    }

    /// Height over the centre's plane of a stored value, metres.
    pub fn height(&self, stored: u8) -> f64 {
        (f64::from(stored) / 127.5 - 1.0) * self.radius
    }

    /// Side of a texel of the base level, metres.
    pub fn texel(&self) -> f64 {
        2.0 * self.radius / f64::from(self.tile)
    }
}
