//! Reading a bundle. Any bytes give an impostor that can be drawn or an error.

use super::{
    Ori, OriError,
    manifest::{Manifest, NAME, TextureRow},
};
use crate::{
    formats::Files,
    math::Aabb,
    relief::textures::Textures,
    runtime::bundle::{self, load},
    texture::{TextureArray, ktx2},
};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// What a bundle holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Bundle {
    pub ori: Ori,
    pub textures: Textures,
}

/// Reads the bundle whose `ori.json` lies in `folder`: manifest and KTX2 files.
///
/// # Errors
/// Where a file is missing or not as it should be; paths that leave the folder are refused.
pub fn read(folder: &Path, files: &(dyn Files + Sync)) -> Result<Bundle, OriError> {
    let text = load(&folder.join(NAME), files)?;
    let manifest = Manifest::parse((*text).as_ref())?;
    let bad = |what: String| OriError::invalid(NAME, what);
    let array = |name: &str| manifest.textures.get(name).map(|row| texture(folder, row, files)).transpose();
    let needed = |name: &str| array(name)?.ok_or_else(|| bad(format!("no texture `{name}`")));
    let textures = Textures {
        color: needed("color")?,
        normal: needed("normal")?,
        depth: needed("depth")?,
        orm: array("orm")?,
        emissive: array("emissive")?,
    };
    let drawing = manifest.drawing.drawing().map_err(bad)?;
    let count = manifest.maps.len() as u32;
    let mut maps = Vec::with_capacity(manifest.maps.len());
    for (layer, row) in manifest.maps.iter().enumerate() {
        let view = row.camera.view().map_err(|what| bad(format!("map `{}`: {what}", row.name)))?;
        let finite = [view.eye, view.right, view.up, view.forward].iter().all(|v| v.is_finite());
        let square =
            (view.right.cross(view.up) + view.forward).length() < 1e-6 && (view.right.length() - 1.0).abs() < 1e-6;
        if !(finite && square) || view.width != textures.depth.width || view.height != textures.depth.height {
            return Err(bad(format!(
                "map `{}`: expected a camera with as many pixels as the depth texture has texels",
                row.name
            )));
        }
        let map = textures.map(layer as u32, view).ok_or_else(|| {
            bad(format!(
                "map `{}`: expected layer {layer} of {count} of {} texels a side in all textures",
                row.name, view.width
            ))
        })?;
        maps.push((row.name.clone(), map));
    }
    let [min, max] = manifest.bounds.map(DVec3::from);
    let ori = Ori {
        maps,
        directions: manifest.selection.directions.iter().copied().map(DVec3::from).collect(),
        subsets: manifest.selection.maps,
        bounds: Aabb { min, max },
        plt: manifest.plt_px.unwrap_or(f64::INFINITY),
        drawing,
    };
    ori.check()?;
    Ok(Bundle { ori, textures })
}

fn texture(folder: &Path, row: &TextureRow, files: &dyn Files) -> Result<TextureArray, OriError> {
    let bytes = load(&inside(folder, &row.ktx2)?, files)?;
    ktx2::read((*bytes).as_ref()).map_err(|error| OriError::Texture { file: row.ktx2.clone(), error })
}

/// The path of a file of the bundle.
pub(super) fn inside(folder: &Path, name: &str) -> Result<PathBuf, OriError> {
    bundle::inside(folder, name).map_err(|what| OriError::invalid(NAME, what))
}
