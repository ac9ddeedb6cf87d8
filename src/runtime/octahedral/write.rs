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
    octahedral::{Atlas, Impostor, levels},
    runtime::bundle::{BundleFile, shader_files, shader_names},
    texture::{Format, TextureArray, dds, ktx2, mip::Level},
};
use rayon::prelude::*;

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
        Self { steps: 16 }
    }
}

/// Which texture files are written beside the PNGs: with all mip levels, colours in BC3 and BC1, normals with depths as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Textures {
    pub ktx2: bool,
    pub dds: bool,
}

/// An image of an atlas, how it is stored, and whether it holds colours.
type Image = (fn(&Atlas) -> Option<&Array<[u8; 4]>>, Format, bool);

const IMAGES: [Image; 4] = [
    (|a| Some(&a.color), Format::Bc3, true),
    (|a| Some(&a.normal), Format::Rgba8, false),
    (|a| a.orm.as_ref(), Format::Bc1, false),
    (|a| a.emissive.as_ref(), Format::Bc1, true),
];

/// The files of a bundle: the manifest first, the atlases, a GLB for viewers, the shaders.
///
/// # Errors
/// Where the impostor is not as its type says, or there are more than [`MAX_STEPS`] steps.
pub fn write(impostor: &Impostor, drawing: &Drawing, textures: Textures) -> Result<Vec<BundleFile>, OctahedralError> {
    if let Some(what) = impostor.fault() {
        return Err(OctahedralError::invalid("octahedral impostor", what));
    }
    if drawing.steps > MAX_STEPS {
        return Err(OctahedralError::invalid(NAME, format!("{} steps; expected 0 to {MAX_STEPS}", drawing.steps)));
    }
    let atlas = &impostor.atlas;
    let files = |name: &str| AtlasFiles {
        png: format!("{name}.png"),
        ktx2: textures.ktx2.then(|| format!("{name}.ktx2")),
        dds: textures.dds.then(|| format!("{name}.dds")),
    };
    let atlases = Atlases {
        color: files("color-alpha"),
        normal_depth: files("normal-depth"),
        orm: atlas.orm.as_ref().map(|_| files("orm")),
        emissive: atlas.emissive.as_ref().map(|_| files("emissive")),
    };
    let all = levels(impostor);
    let rows = [Some(&atlases.color), Some(&atlases.normal_depth), atlases.orm.as_ref(), atlases.emissive.as_ref()];
    let rows: Vec<(&AtlasFiles, Image)> =
        rows.into_iter().zip(IMAGES).filter_map(|(row, image)| Some((row?, image))).collect();
    let written = rows.par_iter().map(|(row, image)| of_atlas(row, *image, &all));
    let written = written.collect::<Result<Vec<_>, OctahedralError>>()?.concat();
    let bounds =
        (!impostor.bounds.is_empty()).then(|| [impostor.bounds.min.to_array(), impostor.bounds.max.to_array()]);
    let manifest = Manifest {
        format: FORMAT.into(),
        version: VERSION,
        convention: convention(impostor.grid.hemi),
        frames: impostor.grid.side,
        mapping: mapping(impostor.grid.hemi).into(),
        tile: impostor.tile,
        levels: all.len() as u32,
        centre: impostor.centre.to_array(),
        radius: impostor.radius,
        bounds,
        card: impostor.card.clone(),
        steps: drawing.steps,
        atlases,
        preview: PREVIEW.into(),
        shaders: shader_names(&SHADERS),
    };
    let mut text =
        serde_json::to_string_pretty(&manifest).map_err(|e| OctahedralError::invalid(NAME, e.to_string()))?;
    text.push('\n');
    let mut out = vec![BundleFile { path: NAME.into(), media: "application/json", bytes: text.into_bytes() }];
    out.extend(written);
    out.push(BundleFile { path: PREVIEW.into(), media: "model/gltf-binary", bytes: preview(impostor)? });
    out.extend(shader_files(&SHADERS));
    Ok(out)
}

/// The files of one image of all levels.
fn of_atlas(
    row: &AtlasFiles,
    (image, format, srgb): Image,
    levels: &[Atlas],
) -> Result<Vec<BundleFile>, OctahedralError> {
    let level = |l: &Atlas| image(l).map(|i| Level { width: l.side, height: l.side, texels: i.to_vec() });
    let chain: Vec<Level> = levels.iter().filter_map(level).collect();
    let base = chain.first().map(|l| Picture { width: l.width, height: l.height, texels: l.texels.clone() });
    let bytes = encode_png(&base.unwrap_or_default()).map_err(|e| OctahedralError::invalid(&row.png, e.to_string()))?;
    let mut files = vec![BundleFile { path: row.png.clone(), media: "image/png", bytes }];
    if row.ktx2.is_some() || row.dds.is_some() {
        let failed = |e: crate::texture::TextureError| OctahedralError::invalid(&row.png, e.to_string());
        let array = TextureArray::encode(format, srgb, &[chain]).map_err(failed)?;
        if let Some(path) = &row.ktx2 {
            let bytes = ktx2::write(&array).map_err(failed)?;
            files.push(BundleFile { path: path.clone(), media: "image/ktx2", bytes });
        }
        if let Some(path) = &row.dds {
            let bytes = dds::write(&array).map_err(failed)?;
            files.push(BundleFile { path: path.clone(), media: "image/vnd-ms.dds", bytes });
        }
    }
    Ok(files)
}
