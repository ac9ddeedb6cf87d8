//! `octahedral.json`: what a bundle holds and how it is drawn.
//!
//! Lengths are metres, directions unit vectors of a right-handed world with +Y up. Paths are relative to the manifest's folder.

use super::OctahedralError;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

pub const FORMAT: &str = "farfield octahedral";
pub const VERSION: u32 = 1;
/// Name of the manifest in a bundle.
pub const NAME: &str = "octahedral.json";
/// Name of the GLB for viewers.
pub const PREVIEW: &str = "octahedral.glb";

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// [`FORMAT`].
    pub format: String,
    /// [`VERSION`].
    pub version: u32,
    /// What the numbers mean, in words; see [`convention`].
    pub convention: BTreeMap<String, String>,
    /// Frames along a side of the grid.
    pub frames: u32,
    /// `octahedral` or `hemi-octahedral`.
    pub mapping: String,
    /// Texels along a frame's side.
    pub tile: u32,
    /// Mip levels of the atlases, the base included: those of the texture files, and how far a renderer may go that makes its own.
    pub levels: u32,
    /// Centre of the windows.
    pub centre: [f64; 3],
    /// Half the side of the windows, and half the range of depths.
    pub radius: f64,
    /// Least and greatest corner of the object's bounding box; null where there is none.
    pub bounds: Option<[[f64; 3]; 2]>,
    /// Corners of the card, see [`crate::octahedral::Impostor::card`].
    pub card: Vec<[f64; 2]>,
    /// Steps in which a ray is followed through a frame; 0 for flat pictures.
    pub steps: u32,
    pub atlases: Atlases,
    /// GLB of crossed cards, for viewers.
    pub preview: String,
    /// Shader files by language.
    pub shaders: BTreeMap<String, Vec<String>>,
}

/// The atlases by what they hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Atlases {
    pub color: AtlasFiles,
    pub normal_depth: AtlasFiles,
    /// Null where it was not captured.
    pub orm: Option<AtlasFiles>,
    /// Null where it was not captured.
    pub emissive: Option<AtlasFiles>,
}

/// An atlas in several formats.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AtlasFiles {
    /// 8-bit RGBA, the base level.
    pub png: String,
    /// All levels as a texture array of one layer; null where it was not written.
    #[serde(default)]
    pub ktx2: Option<String>,
    #[serde(default)]
    pub dds: Option<String>,
}

/// What the numbers of the manifest and the atlases mean.
pub fn convention(hemi: bool) -> BTreeMap<String, String> {
    let coordinates = if hemi {
        "e = (x + z, x - z)/(|x| + |y| + |z|) of the unit vector (x, y, z) from the centre to the eye; y is at least 0.001"
    } else {
        "e = (x, z)/(|x| + |y| + |z|) of the unit vector (x, y, z) from the centre to the eye; where y < 0, e = ((1 - |e.y|) sign(e.x), (1 - |e.x|) sign(e.y)), sign(0) = 1"
    };
    let rows = [
        ("world", "right-handed, +Y up, metres"),
        ("coordinates", coordinates),
        (
            "order",
            "frame (column, row) looks from e = (column, row)/(frames - 1)*2 - 1; it begins at texel (column, row)*tile, rows from the top",
        ),
        (
            "blending",
            "g = (e*0.5 + 0.5)*(frames - 1), cell = floor(g), f = g - cell; where f.x >= f.y frames cell, cell + (1, 0), cell + (1, 1) with weights 1 - f.x, f.x - f.y, f.y; else cell, cell + (0, 1), cell + (1, 1) with 1 - f.y, f.y - f.x, f.x",
        ),
        (
            "frame",
            "orthographic, from the direction d to the eye: right = normalize(cross(+Y, d)), up = cross(d, right); where d is vertical, +Z takes the place of +Y; texel (u, v) shows centre + radius*((2u - 1) right + (1 - 2v) up) and what lies before and behind it along d",
        ),
        (
            "color",
            "sRGB base colour without light, dilated into empty texels; alpha = share of the texel that is covered, a texel counts as covered from 0.5 on",
        ),
        ("normal", "world space, rgb = n*0.5 + 0.5, linear"),
        (
            "depth",
            "alpha of the normal atlas: 1 is the plane centre + radius*d, nearest to the eye, 0.5 the centre, 0 the plane centre - radius*d",
        ),
        ("orm", "red occlusion, green roughness, blue metallic, linear"),
        ("emissive", "sRGB emitted light"),
        (
            "card",
            "corners c: centre + radius*(d + c.x right + c.y up) with right and up of the direction d to the eye, counter-clockwise as the eye sees them",
        ),
    ];
    rows.into_iter().map(|(k, v)| (k.to_owned(), v.to_owned())).collect()
}

/// Names in `mapping`.
pub fn mapping(hemi: bool) -> &'static str {
    if hemi { "hemi-octahedral" } else { "octahedral" }
}

impl Manifest {
    /// Parses a manifest and checks what it says of itself.
    pub fn parse(text: &[u8]) -> Result<Self, OctahedralError> {
        let bad = |what: String| OctahedralError::invalid(NAME, what);
        let manifest: Self = serde_json::from_slice(text).map_err(|e| bad(e.to_string()))?;
        if manifest.format != FORMAT {
            return Err(bad(format!("format `{}`; expected `{FORMAT}`", manifest.format)));
        }
        if manifest.version != VERSION {
            return Err(bad(format!("version {}; expected {VERSION}", manifest.version)));
        }
        Ok(manifest)
    }

    pub fn hemi(&self) -> Result<bool, OctahedralError> {
        let found = [false, true].into_iter().find(|hemi| mapping(*hemi) == self.mapping);
        found.ok_or_else(|| {
            let what = format!("mapping `{}`; expected `{}` or `{}`", self.mapping, mapping(false), mapping(true));
            OctahedralError::invalid(NAME, what)
        })
    }
}
