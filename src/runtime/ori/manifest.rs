//! `ori.json`: what a bundle holds and how it is drawn.
//!
//! Lengths are metres, directions unit vectors of a right-handed world with +Y up. Colours are unlit and normals are those of the surface. Paths are
//! relative to the manifest's folder. Layer i of each texture array is map i.

use super::{Drawing, OriError};
use crate::{
    relief::{DepthBits, REACHES, Search, Strategy, Trace},
    runtime::Camera,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

pub const FORMAT: &str = "farfield ori";
pub const VERSION: u32 = 1;
/// Name of the manifest in a bundle.
pub const NAME: &str = "ori.json";
/// Maps, and directions, that a bundle may have.
pub const MAX_MAPS: usize = 1024;
pub const MAX_DIRECTIONS: usize = 1 << 17;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// [`FORMAT`].
    pub format: String,
    /// [`VERSION`].
    pub version: u32,
    /// Bounding box of the object: least and greatest corner.
    pub bounds: [[f64; 3]; 2],
    /// The projected length threshold: up to how many pixels, along the longer side of its projection, the impostor may be used. Null: nothing is
    /// missing at any size.
    pub plt_px: Option<f64>,
    pub depth: DepthRow,
    pub maps: Vec<MapRow>,
    pub selection: SelectionRow,
    pub drawing: DrawingRow,
    /// KTX2 and DDS files by what they hold: `color`, `normal`, `depth`, and where they were captured `orm` and `emissive`.
    pub textures: BTreeMap<String, TextureRow>,
    /// PNG of all maps' colours.
    pub preview: String,
    /// GLB of the maps nearest to the six axes on cards, for viewers: an approximation.
    pub cards: String,
    /// Shader files by language.
    pub shaders: BTreeMap<String, Vec<String>>,
}

/// How codes of the depth texture are read. With L levels, code c < L is a surface at planar depth near + c/(L − 1)·(far − near) of its map's camera. Other
/// codes have no surface: one beside it reaches the share (codes − c − ½)/`reaches` of the way from the centre of its texel to that of this one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DepthRow {
    /// 8 or 16.
    pub bits: u32,
    pub levels: u32,
    pub reaches: u32,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapRow {
    pub name: String,
    /// Its pixels are the texels.
    pub camera: Camera,
}

/// Which maps are drawn: those of the direction that is nearest to the direction from the object towards the eye.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SelectionRow {
    /// Side of the viewport that it was measured in, pixels.
    pub size: u32,
    /// Missing pixels of the object over size², and pixels beyond it: least, mean and greatest over the directions.
    pub missing: [f64; 3],
    pub extra: [f64; 3],
    pub directions: Vec<[f64; 3]>,
    /// Numbers of maps, the one nearest to the direction first.
    pub maps: Vec<Vec<u32>>,
}

/// [`Drawing`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrawingRow {
    /// `pyramid` or `linear`.
    pub search: String,
    /// Of a linear search.
    pub steps: u32,
    pub halvings: u32,
    /// Texel sides.
    pub wall: f32,
    /// `plane`, `depth`, `direction`, `normal` or `biased-depth`: strategies 1 to 5 of the paper's section 3.3.
    pub strategy: Strategy,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TextureRow {
    pub ktx2: String,
    /// Null where it was not asked for.
    pub dds: Option<String>,
    /// Such as `Bc1`.
    pub format: String,
    pub srgb: bool,
}

impl Manifest {
    /// Parses a manifest and checks what it says of itself.
    ///
    /// # Errors
    /// Where it is not a manifest of this format and version, or claims more than a bundle may hold.
    pub fn parse(text: &[u8]) -> Result<Self, OriError> {
        let bad = |what: String| Err(OriError::invalid(NAME, what));
        let manifest: Self = serde_json::from_slice(text).map_err(|e| OriError::invalid(NAME, e.to_string()))?;
        if manifest.format != FORMAT {
            return bad(format!("format `{}`; expected `{FORMAT}`", manifest.format));
        }
        if manifest.version != VERSION {
            return bad(format!("version {}; expected {VERSION}", manifest.version));
        }
        if !(1..=MAX_MAPS).contains(&manifest.maps.len()) {
            return bad(format!("{} maps; expected 1 to {MAX_MAPS}", manifest.maps.len()));
        }
        if manifest.selection.directions.len() > MAX_DIRECTIONS {
            return bad(format!(
                "{} directions; expected at most {MAX_DIRECTIONS}",
                manifest.selection.directions.len()
            ));
        }
        if manifest.depth.reaches != REACHES {
            return bad(format!("{} reaches; expected {REACHES}", manifest.depth.reaches));
        }
        Ok(manifest)
    }
}

impl DepthRow {
    pub fn of(bits: DepthBits) -> Self {
        Self { bits: bits.codes().ilog2(), levels: bits.levels(), reaches: REACHES }
    }
}

impl DrawingRow {
    pub fn of(drawing: &Drawing) -> Self {
        let (search, steps, halvings) = match drawing.trace.search {
            Search::Pyramid => ("pyramid", 16, 7),
            Search::Linear { steps, halvings } => ("linear", steps, halvings),
        };
        Self { search: search.into(), steps, halvings, wall: drawing.trace.wall, strategy: drawing.strategy }
    }

    pub fn drawing(&self) -> Result<Drawing, String> {
        let search = match &*self.search {
            "pyramid" => Search::Pyramid,
            "linear" if (1..=1024).contains(&self.steps) && self.halvings <= 32 => {
                Search::Linear { steps: self.steps, halvings: self.halvings }
            }
            "linear" => {
                return Err(format!(
                    "{} steps and {} halvings; expected 1 to 1024 and 0 to 32",
                    self.steps, self.halvings
                ));
            }
            other => return Err(format!("search `{other}`; expected `pyramid` or `linear`")),
        };
        if !(self.wall > 0.0 && self.wall.is_finite()) {
            return Err(format!("a wall of {} texels; expected more than 0", self.wall));
        }
        Ok(Drawing { trace: Trace { search, wall: self.wall }, strategy: self.strategy })
    }
}
