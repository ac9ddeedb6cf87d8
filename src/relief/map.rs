//! Relief maps.

use crate::{
    array::Array,
    view::{Projection, View},
};

/// Codes at the end of the range of depths that mark texels without surface, see [`ReliefMap::depth`].
pub const REACHES: u32 = 16;

/// Bits of a depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DepthBits {
    Eight,
    Sixteen,
}

impl DepthBits {
    /// Number of depths that codes can tell apart.
    pub fn levels(self) -> u32 {
        self.codes() - REACHES
    }

    /// Number of codes.
    pub fn codes(self) -> u32 {
        match self {
            Self::Eight => 1 << 8,
            Self::Sixteen => 1 << 16,
        }
    }
}

/// What one orthographic camera sees of an object, as a height field with colour (Andújar et al. 2007, section 3.1).
///
/// All images have `view.width × view.height` texels, row by row from the top; the two are equal.
#[derive(Clone, Debug, PartialEq)]
pub struct ReliefMap {
    /// Orthographic with square texels. The depths between `near` and `far`, metres, are those that codes can tell.
    pub view: View,
    pub bits: DepthBits,
    /// With L levels, codes c < L are a surface at depth near + c/(L − 1)·(far − near). The [`REACHES`] codes from L on are texels without surface:
    /// from the centre of a neighbour with a surface, that surface reaches the share (L + 16 − c − ½)/16 of the way to the centre of this texel. The
    /// last code also marks texels far from any surface.
    pub depth: Array<u16>,
    /// Base colour, sRGB; alpha 255 where there is a surface, else 0. Texels without surface have the colour of the nearest one.
    pub color: Array<[u8; 4]>,
    /// Components of the unit normal along the view's `right` and `up`, from −1 to 1 as 0 to 254; the third points against `forward`.
    pub normal: Array<[u8; 2]>,
    /// Occlusion, roughness, metallic; empty where they were not captured.
    pub orm: Array<[u8; 4]>,
    /// sRGB; empty where it was not captured.
    pub emissive: Array<[u8; 4]>,
}

/// Why something is no relief map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct MapFault(pub String);

impl ReliefMap {
    /// Texels along a side.
    pub fn side(&self) -> u32 {
        self.view.width
    }

    /// Side of a texel, metres.
    pub fn texel(&self) -> f64 {
        match self.view.projection {
            Projection::Orthographic { left, right, .. } | Projection::Perspective { left, right, .. } => {
                (right - left) / f64::from(self.view.width)
            }
        }
    }

    /// Planar depth of a texel in metres; `None` where it has no surface.
    pub fn depth_of(&self, texel: usize) -> Option<f64> {
        let (code, last) = (u32::from(self.depth[texel]), self.bits.levels() - 1);
        (code <= last).then(|| self.view.near + f64::from(code) / f64::from(last) * (self.view.far - self.view.near))
    }

    /// Texels with a surface.
    pub fn covered(&self) -> usize {
        self.depth.iter().filter(|c| u32::from(**c) < self.bits.levels()).count()
    }

    /// Checks that images and camera are as their documentation says.
    pub fn check(&self) -> Result<(), MapFault> {
        let fault = |what: String| Err(MapFault(what));
        let view = &self.view;
        let Projection::Orthographic { left, right, bottom, top } = view.projection else {
            return fault("expected an orthographic camera".into());
        };
        if view.width != view.height || view.width < 2 {
            return fault(format!("{}×{} texels; expected a square of 2 or more a side", view.width, view.height));
        }
        let (w, h) = (right - left, top - bottom);
        if !(w > 0.0 && (w - h).abs() <= 1e-9 * w.max(h) && view.near < view.far) {
            return fault("expected square texels and a range of depths".into());
        }
        let texels = view.width as usize * view.height as usize;
        let optional = |n: usize| n == 0 || n == texels;
        let lengths = [self.depth.len(), self.color.len(), self.normal.len()];
        if lengths.iter().any(|n| *n != texels) || !optional(self.orm.len()) || !optional(self.emissive.len()) {
            return fault(format!("images of {lengths:?} texels, expected {texels}"));
        }
        if let Some(code) = self.depth.iter().find(|c| u32::from(**c) >= self.bits.codes()) {
            return fault(format!("a depth code of {code}; expected less than {}", self.bits.codes()));
        }
        Ok(())
    }
}
