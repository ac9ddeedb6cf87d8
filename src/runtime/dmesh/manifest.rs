//! `dmesh.json`: what a bundle holds and how it is drawn.
//!
//! Lengths are metres, directions unit vectors of a right-handed world with +Y up. Nothing in it depends on light: colours are
//! unlit and normals are those of the surface. Paths are relative to the manifest's folder.

use super::{Blending, DmeshError, MAX_REFERENCES, Weights};
use crate::{depth_mesh::Options, runtime::Camera};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

pub const FORMAT: &str = "farfield dmesh";
pub const VERSION: u32 = 1;
/// Name of the manifest in a bundle.
pub const NAME: &str = "dmesh.json";
/// Name of the GLB of all references.
pub const ALL: &str = "dmesh.glb";

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// [`FORMAT`].
    pub format: String,
    /// [`VERSION`].
    pub version: u32,
    /// How far the meshes may lie from the captured surface.
    pub epsilon: f64,
    /// Diagonal of the object's bounding box.
    pub diagonal: f64,
    /// Backs of faces are drawn too.
    pub double_sided: bool,
    pub blending: BlendingRow,
    /// How meshes are made for a view; null where the bundle has no depth images.
    #[serde(default)]
    pub view_dependent: Option<ViewDependent>,
    pub references: Vec<Row>,
    /// GLB of all references, one object each, for viewers.
    pub all: String,
    /// Shader files by language.
    pub shaders: BTreeMap<String, Vec<String>>,
}

/// [`Blending`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BlendingRow {
    /// `positional`, `angular` or `uniform`.
    pub weights: String,
    /// Fragments count by their quality.
    pub quality: bool,
    /// Offset of the depth test; null: 2·epsilon plus a texel of the reference.
    pub offset: Option<f64>,
}

/// See [`super::Frames`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewDependent {
    /// Pixels.
    pub tau: f64,
    pub hierarchy: Options,
}

/// One reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    pub name: String,
    pub camera: Camera,
    /// One mesh with POSITION, NORMAL, TEXCOORD_0 and _QUALITY; its base colour texture is the picture.
    pub glb: String,
    /// PNG of world-space normals, n·0.5 + 0.5; null where those of the vertices count.
    pub normals: Option<String>,
    /// Planar depths of the camera's pixels, 32-bit floats, little-endian, row by row from the top, infinite where there is nothing.
    #[serde(default)]
    pub depth: Option<String>,
    pub triangles: u64,
    /// Triangle strips that the mesh was drawn with; null where they are not known.
    pub strips: Option<u64>,
}

impl Manifest {
    /// Parses a manifest and checks what it says of itself.
    pub fn parse(text: &[u8]) -> Result<Self, DmeshError> {
        let bad = |what: String| DmeshError::invalid(NAME, what);
        let manifest: Self = serde_json::from_slice(text).map_err(|e| bad(e.to_string()))?;
        if manifest.format != FORMAT {
            return Err(bad(format!("format `{}`; expected `{FORMAT}`", manifest.format)));
        }
        if manifest.version != VERSION {
            return Err(bad(format!("version {}; expected {VERSION}", manifest.version)));
        }
        if manifest.references.len() > MAX_REFERENCES {
            return Err(bad(format!("{} references; expected at most {MAX_REFERENCES}", manifest.references.len())));
        }
        Ok(manifest)
    }
}

impl BlendingRow {
    pub fn of(b: &Blending) -> Self {
        Self { weights: b.weights.name().into(), quality: b.quality, offset: b.offset }
    }

    pub fn blending(&self) -> Result<Blending, String> {
        let Some(weights) = Weights::named(&self.weights) else {
            return Err(format!("weights `{}`; expected `positional`, `angular` or `uniform`", self.weights));
        };
        if let Some(offset) = self.offset.filter(|o| !(*o >= 0.0 && o.is_finite())) {
            return Err(format!("offset {offset}; expected a length of at least 0"));
        }
        Ok(Blending { weights, quality: self.quality, offset: self.offset })
    }
}
