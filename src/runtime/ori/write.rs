//! A relief impostor as a bundle of files.

use super::{
    Ori, OriError,
    manifest::{DepthRow, DrawingRow, FORMAT, Manifest, MapRow, NAME, SelectionRow, TextureRow, VERSION},
    preview,
    shaders::SHADERS,
};
use crate::{
    relief::{
        measure::{Selection, Spread},
        textures::Textures,
    },
    runtime::bundle::{BundleFile, Camera, ShaderFile, shader_files, shader_names},
    texture::{dds, ktx2},
};
use std::collections::BTreeMap;

/// Names of the other files.
const PREVIEW: &str = "preview.png";
const CARDS: &str = "cards.glb";

/// The files of a bundle, the manifest first. `textures` are those of the maps, `selection` that which the subsets come from; `extras` say what else is written.
///
/// # Errors
/// As [`Ori::check`]; where textures do not belong to the maps.
pub fn write(
    ori: &Ori,
    selection: &Selection,
    textures: &Textures,
    extras: Extras,
) -> Result<Vec<BundleFile>, OriError> {
    ori.check()?;
    let bits = ori.maps[0].1.bits;
    let layers = ori.maps.len() as u32;
    for (name, array) in textures.named() {
        if (array.layers, array.width, array.height) != (layers, ori.maps[0].1.side(), ori.maps[0].1.side()) {
            let what = format!("{} layers of {}×{} texels for {layers} maps", array.layers, array.width, array.height);
            return Err(OriError::invalid(name, what));
        }
    }
    if textures.depth_bits() != Some(bits) {
        return Err(OriError::invalid(
            "depth",
            format!("{:?} for depths of {} bits", textures.depth.format, bits.codes().ilog2()),
        ));
    }
    let mut rows = BTreeMap::new();
    let mut files = Vec::new();
    for (name, array) in textures.named() {
        let failed = |error| OriError::Texture { file: name.into(), error };
        let row = TextureRow {
            ktx2: format!("{name}.ktx2"),
            dds: extras.dds.then(|| format!("{name}.dds")),
            format: format!("{:?}", array.format),
            srgb: array.srgb,
        };
        files.push(BundleFile {
            path: row.ktx2.clone(),
            media: "image/ktx2",
            bytes: ktx2::write(array).map_err(failed)?,
        });
        if let Some(path) = &row.dds {
            files.push(BundleFile {
                path: path.clone(),
                media: "image/vnd-ms.dds",
                bytes: dds::write(array).map_err(failed)?,
            });
        }
        rows.insert(name.to_owned(), row);
    }
    let shaders: &[ShaderFile] = if extras.shaders { &SHADERS } else { &[] };
    let spread = |s: Spread| [s.min, s.avg, s.max];
    let manifest = Manifest {
        format: FORMAT.into(),
        version: VERSION,
        bounds: [ori.bounds.min.to_array(), ori.bounds.max.to_array()],
        plt_px: ori.plt.is_finite().then_some(ori.plt),
        depth: DepthRow::of(bits),
        maps: ori.maps.iter().map(|(name, map)| MapRow { name: name.clone(), camera: Camera::of(&map.view) }).collect(),
        selection: SelectionRow {
            size: selection.size,
            missing: spread(selection.missing()),
            extra: spread(selection.extra()),
            directions: ori.directions.iter().map(|d| d.to_array()).collect(),
            maps: ori.subsets.clone(),
        },
        drawing: DrawingRow::of(&ori.drawing),
        textures: rows,
        preview: PREVIEW.into(),
        cards: CARDS.into(),
        shaders: shader_names(shaders),
    };
    let mut text = serde_json::to_string_pretty(&manifest).map_err(|e| OriError::invalid(NAME, e.to_string()))?;
    text.push('\n');
    files.insert(0, BundleFile { path: NAME.into(), media: "application/json", bytes: text.into_bytes() });
    files.push(BundleFile { path: PREVIEW.into(), media: "image/png", bytes: preview::sheet(ori)? });
    files.push(BundleFile { path: CARDS.into(), media: "model/gltf-binary", bytes: preview::cards(ori)? });
    files.extend(shader_files(shaders));
    Ok(files)
}

/// What a bundle may do without.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extras {
    /// DDS files beside the KTX2 files.
    pub dds: bool,
    pub shaders: bool,
}
