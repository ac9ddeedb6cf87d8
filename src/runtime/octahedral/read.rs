//! Reading a bundle. Any bytes give an impostor that can be drawn or an error.

use super::{
    Drawing, MAX_STEPS, OctahedralError,
    manifest::{AtlasFiles, Manifest, NAME},
};
use crate::{
    array::Array,
    formats::{Files, Limits, image_from_bytes},
    math::Aabb,
    octahedral::{Atlas, Grid, Impostor},
    runtime::bundle::{self, load},
};
use glam::DVec3;
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// What a bundle holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Bundle {
    pub impostor: Impostor,
    /// How it is meant to be drawn.
    pub drawing: Drawing,
}

/// Reads the bundle whose `octahedral.json` lies in `folder`. Only what drawing needs is read: the atlases, as PNG.
///
/// # Errors
/// Where a file is missing or not as it should be; paths that leave the folder are refused.
pub fn read(folder: &Path, files: &(dyn Files + Sync), limits: &Limits) -> Result<Bundle, OctahedralError> {
    let text = load(&folder.join(NAME), files)?;
    let manifest = Manifest::parse((*text).as_ref())?;
    let bad = |what: String| OctahedralError::invalid(NAME, what);
    if manifest.steps > MAX_STEPS {
        return Err(bad(format!("{} steps; expected 0 to {MAX_STEPS}", manifest.steps)));
    }
    let bounds = manifest.bounds.map_or(Aabb::EMPTY, |[min, max]| Aabb { min: min.into(), max: max.into() });
    if manifest.bounds.is_some() && !(bounds.min.is_finite() && bounds.max.is_finite() && !bounds.is_empty()) {
        return Err(bad("bounds that are no box".into()));
    }
    let side = u64::from(manifest.frames) * u64::from(manifest.tile);
    let image = |row: &AtlasFiles| atlas(folder, row, side, files, limits);
    let rows = &manifest.atlases;
    let impostor = Impostor {
        grid: Grid { side: manifest.frames, hemi: manifest.hemi()? },
        tile: manifest.tile,
        centre: DVec3::from(manifest.centre),
        radius: manifest.radius,
        bounds,
        card: manifest.card.clone(),
        atlas: Atlas {
            side: u32::try_from(side).map_err(|_| bad(format!("an atlas of {side} texels")))?,
            color: image(&rows.color)?,
            normal: image(&rows.normal_depth)?,
            orm: rows.orm.as_ref().map(image).transpose()?,
            emissive: rows.emissive.as_ref().map(image).transpose()?,
        },
    };
    match impostor.fault() {
        Some(what) => Err(bad(what)),
        None => Ok(Bundle { impostor, drawing: Drawing { steps: manifest.steps } }),
    }
}

/// The base level of an atlas of `side`² texels.
fn atlas(
    folder: &Path,
    row: &AtlasFiles,
    side: u64,
    files: &dyn Files,
    limits: &Limits,
) -> Result<Array<[u8; 4]>, OctahedralError> {
    let path = inside(folder, &row.png)?;
    let bytes = load(&path, files)?;
    let image = Arc::new(image_from_bytes(&path, (*bytes).as_ref(), limits)?);
    if (u64::from(image.width), u64::from(image.height)) != (side, side) {
        let what = format!("`{}` has {} × {} texels; expected {side}²", row.png, image.width, image.height);
        return Err(OctahedralError::invalid(NAME, what));
    }
    Ok(image.texels.clone())
}

/// The path of a file of the bundle.
fn inside(folder: &Path, name: &str) -> Result<PathBuf, OctahedralError> {
    bundle::inside(folder, name).map_err(|what| OctahedralError::invalid(NAME, what))
}
