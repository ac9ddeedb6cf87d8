//! An octahedral impostor as a bundle of files.

use super::{
    OctahedralError,
    manifest::{AtlasFiles, Atlases, FORMAT, Manifest, NAME, PREVIEW, VERSION, convention, mapping},
    preview::preview,
    shaders::SHADERS,
};
use crate::{
    array::Array,
    image::{Picture, encode_png},
    octahedral::{Impostor, levels},
    runtime::dmesh::BundleFile,
};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Parallax steps that a manifest may ask for.
pub const MAX_STEPS: u32 = 64;

/// How an impostor is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Drawing {
    /// Times that a ray is moved by the height of a frame, 0 to [`MAX_STEPS`]; 0 shows the frames as flat pictures.
    pub steps: u32,
}

impl Default for Drawing {
    fn default() -> Self {
        Self { steps: 2 }
    }
}

/// The files of a bundle: the manifest first, the atlases, a GLB for viewers, the shaders.
///
/// # Errors
/// Where the impostor is not as its type says, or there are more than [`MAX_STEPS`] steps.
pub fn write(impostor: &Impostor, drawing: &Drawing) -> Result<Vec<BundleFile>, OctahedralError> {
    if let Some(what) = impostor.fault() {
        return Err(OctahedralError::invalid("octahedral impostor", what));
    }
    if drawing.steps > MAX_STEPS {
        return Err(OctahedralError::invalid(NAME, format!("{} steps; expected 0 to {MAX_STEPS}", drawing.steps)));
    }
    let atlas = &impostor.atlas;
    let files = |name: &str| AtlasFiles { png: format!("{name}.png") };
    let atlases = Atlases {
        color: files("color-alpha"),
        normal_depth: files("normal-depth"),
        orm: atlas.orm.as_ref().map(|_| files("orm")),
        emissive: atlas.emissive.as_ref().map(|_| files("emissive")),
    };
    let rows = [Some(&atlases.color), Some(&atlases.normal_depth), atlases.orm.as_ref(), atlases.emissive.as_ref()];
    let images: Vec<(&AtlasFiles, &Array<[u8; 4]>)> = rows.into_iter().flatten().zip(atlas.images()).collect();
    let written: Vec<BundleFile> = images
        .into_par_iter()
        .map(|(row, texels)| {
            let picture = Picture { width: atlas.side, height: atlas.side, texels: texels.to_vec() };
            let bytes = encode_png(&picture).map_err(|e| OctahedralError::invalid(&row.png, e.to_string()))?;
            Ok(BundleFile { path: row.png.clone(), media: "image/png", bytes })
        })
        .collect::<Result<_, OctahedralError>>()?;
    let mut shaders = BTreeMap::<String, Vec<String>>::new();
    for s in &SHADERS {
        shaders.entry(s.language.into()).or_default().push(s.name.into());
    }
    let bounds =
        (!impostor.bounds.is_empty()).then(|| [impostor.bounds.min.to_array(), impostor.bounds.max.to_array()]);
    let manifest = Manifest {
        format: FORMAT.into(),
        version: VERSION,
        convention: convention(impostor.grid.hemi),
        frames: impostor.grid.side,
        mapping: mapping(impostor.grid.hemi).into(),
        tile: impostor.tile,
        levels: levels(impostor).len() as u32,
        centre: impostor.centre.to_array(),
        radius: impostor.radius,
        bounds,
        card: impostor.card.clone(),
        steps: drawing.steps,
        atlases,
        preview: PREVIEW.into(),
        shaders,
    };
    let mut text =
        serde_json::to_string_pretty(&manifest).map_err(|e| OctahedralError::invalid(NAME, e.to_string()))?;
    text.push('\n');
    let mut out = vec![BundleFile { path: NAME.into(), media: "application/json", bytes: text.into_bytes() }];
    out.extend(written);
    out.push(BundleFile { path: PREVIEW.into(), media: "model/gltf-binary", bytes: preview(impostor)? });
    out.extend(SHADERS.iter().map(|s| BundleFile { path: s.name.into(), media: s.media, bytes: s.bytes.to_vec() }));
    Ok(out)
}
