//! Materials, textures and images of a GLB.

use super::{Binary, FormatError, GlbOptions, schema};
use crate::scene::{
    Image,
    tables::{AlphaRow, MaterialRow, Tables, TextureRow, WrapRow},
};
use image::{
    ExtendedColorType, ImageEncoder,
    codecs::png::{CompressionType, FilterType, PngEncoder},
};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// glTF's materials, made as primitives need them.
pub(super) struct Materials<'a> {
    rows: Vec<MaterialRow>,
    /// glTF's number of each image of the table.
    images: Vec<u64>,
    options: &'a GlbOptions,
    known: BTreeMap<(u32, [bool; 2]), u64>,
    samplers: Vec<schema::Sampler>,
    textures: Vec<schema::Texture>,
    materials: Vec<schema::Material>,
}

impl<'a> Materials<'a> {
    /// Encodes the images.
    pub fn new(
        tables: &'a Tables,
        options: &'a GlbOptions,
        root: &mut schema::Root,
        binary: &mut Binary,
    ) -> Result<Self, FormatError> {
        let rows: Vec<_> = tables.materials.iter().map(|(_, row)| kept(row, options)).collect();
        let mut used = vec![false; tables.images.len()];
        rows.iter().flat_map(textures).for_each(|t| used[t.image as usize] = true);
        let used: Vec<_> = (0..used.len()).filter(|i| used[*i]).collect();
        let encoded: Vec<_> = used.par_iter().map(|i| png(tables.images[*i])).collect();
        let mut images = vec![0; tables.images.len()];
        for (i, bytes) in used.into_iter().zip(encoded) {
            let image = tables.images[i];
            images[i] = root.images.len() as u64;
            let object = format!("image `{}`", image.name);
            let bytes = bytes.map_err(|what| FormatError::Unwritable { object, what })?;
            let view = binary.view(root, &bytes, None);
            let name = (!image.name.is_empty()).then(|| image.name.clone());
            let mime_type = Some("image/png".into());
            root.images.push(schema::Image { name, mime_type, buffer_view: Some(view), uri: None });
        }
        let (known, samplers, textures, materials) = Default::default();
        Ok(Self { rows, images, options, known, samplers, textures, materials })
    }

    /// The number of material `row` on a mesh that has the coordinate sets `uv`.
    pub fn number(&mut self, row: u32, uv: [bool; 2]) -> u64 {
        if let Some(n) = self.known.get(&(row, uv)) {
            return *n;
        }
        let row_of = self.rows[row as usize].clone();
        let material = self.material(&row_of, uv);
        self.materials.push(material);
        let n = self.materials.len() as u64 - 1;
        self.known.insert((row, uv), n);
        n
    }

    /// Hands everything over, with the names of the extensions in use.
    pub fn finish(self, root: &mut schema::Root) {
        let infos = |m: &schema::Material| {
            let pbr = m.pbr_metallic_roughness.clone().unwrap_or_default();
            [
                pbr.base_color_texture,
                pbr.metallic_roughness_texture,
                m.normal_texture.clone(),
                m.emissive_texture.clone(),
                m.occlusion_texture.clone(),
            ]
        };
        let moved = |m: &schema::Material| infos(m).iter().flatten().any(|t| t.extensions.transform.is_some());
        for (name, used) in [
            (
                "KHR_materials_emissive_strength",
                self.materials.iter().any(|m| m.extensions.emissive_strength.is_some()),
            ),
            ("KHR_materials_unlit", self.materials.iter().any(|m| m.extensions.unlit.is_some())),
            ("KHR_texture_transform", self.materials.iter().any(moved)),
        ] {
            if used {
                root.extensions_used.push(name.into());
            }
        }
        (root.materials, root.textures, root.samplers) = (self.materials, self.textures, self.samplers);
    }

    fn material(&mut self, row: &MaterialRow, uv: [bool; 2]) -> schema::Material {
        let options = self.options;
        let mut texture =
            |t: &Option<TextureRow>| t.as_ref().filter(|t| uv[t.uv_set as usize]).map(|t| self.texture(t));
        let base_color_texture = texture(&row.base_color_texture);
        let metallic_roughness_texture = texture(&row.metallic_roughness_texture);
        let normal_texture = texture(&row.normal_texture)
            .map(|t| schema::TextureInfo { scale: (row.normal_scale != 1.0).then_some(row.normal_scale), ..t });
        let emissive_texture = texture(&row.emissive_texture);
        let occlusion_texture = row.occlusion.as_ref().and_then(|o| {
            let strength = (o.strength != 1.0).then_some(o.strength.clamp(0.0, 1.0));
            texture(&o.texture).map(|t| schema::TextureInfo { strength, ..t })
        });
        let differs = |v: f32| (v != 1.0).then_some(v.clamp(0.0, 1.0));
        let brightest = row.emissive.iter().fold(1.0f32, |m, c| m.max(*c));
        let emissive = row.emissive.map(|c| (c / brightest).clamp(0.0, 1.0));
        let strength = (brightest > 1.0).then_some(schema::EmissiveStrength { emissive_strength: Some(brightest) });
        let (alpha_mode, alpha_cutoff) = match row.alpha {
            AlphaRow::Opaque => (None, None),
            AlphaRow::Mask(cutoff) => (Some("MASK".into()), (cutoff != 0.5).then_some(cutoff.max(0.0))),
            AlphaRow::Blend => (Some("BLEND".into()), None),
        };
        schema::Material {
            name: (!row.name.is_empty()).then(|| row.name.clone()),
            pbr_metallic_roughness: Some(schema::Pbr {
                base_color_factor: (row.base_color != [1.0; 4]).then(|| row.base_color.map(|c| c.clamp(0.0, 1.0))),
                base_color_texture,
                metallic_factor: differs(row.metallic),
                roughness_factor: differs(row.roughness),
                metallic_roughness_texture,
            })
            .filter(|p| *p != schema::Pbr::default()),
            normal_texture,
            emissive_texture,
            occlusion_texture,
            emissive_factor: (emissive != [0.0; 3]).then_some(emissive),
            alpha_mode,
            alpha_cutoff,
            double_sided: row.double_sided,
            extensions: schema::MaterialExtensions {
                unlit: (options.unlit || row.unlit).then_some(schema::Unlit {}),
                emissive_strength: strength,
                ..Default::default()
            },
        }
    }

    fn texture(&mut self, t: &TextureRow) -> schema::TextureInfo {
        let wrap = |w| match w {
            WrapRow::Repeat => None,
            WrapRow::Mirror => Some(33648),
            WrapRow::Clamp => Some(33071),
        };
        let sampler = schema::Sampler {
            mag_filter: Some(if t.smooth { 9729 } else { 9728 }),
            min_filter: Some(9987),
            wrap_s: wrap(t.wrap[0]),
            wrap_t: wrap(t.wrap[1]),
        };
        let sampler = position(&mut self.samplers, sampler);
        let texture = schema::Texture {
            sampler: Some(sampler),
            source: Some(self.images[t.image as usize]),
            ..Default::default()
        };
        let index = position(&mut self.textures, texture);
        let transform = schema::TextureTransform {
            offset: (t.offset != [0.0; 2]).then_some(t.offset),
            rotation: (t.rotation != 0.0).then_some(t.rotation),
            scale: (t.scale != [1.0; 2]).then_some(t.scale),
            tex_coord: None,
        };
        let transform = Some(transform).filter(|t| *t != schema::TextureTransform::default());
        let extensions = schema::TextureInfoExtensions { transform };
        schema::TextureInfo { index, tex_coord: t.uv_set as u64, scale: None, strength: None, extensions }
    }
}

/// What is written of a material: one that is unlit shows its base colour and nothing else.
fn kept(row: &MaterialRow, options: &GlbOptions) -> MaterialRow {
    let mut row = row.clone();
    if options.unlit {
        row.metallic_roughness_texture = None;
        row.emissive_texture = None;
        row.occlusion = None;
        row.emissive = [0.0; 3];
        if !options.normal_maps {
            row.normal_texture = None;
        }
    }
    row
}

fn textures(row: &MaterialRow) -> impl Iterator<Item = &TextureRow> {
    let all = [&row.base_color_texture, &row.metallic_roughness_texture, &row.normal_texture, &row.emissive_texture];
    all.into_iter().flatten().chain(row.occlusion.as_ref().and_then(|o| o.texture.as_ref()))
}

/// Where `item` stands in `all`, appended if it is new. There are few.
fn position<T: PartialEq>(all: &mut Vec<T>, item: T) -> u64 {
    let at = all.iter().position(|x| *x == item);
    at.unwrap_or_else(|| {
        all.push(item);
        all.len() - 1
    }) as u64
}

/// The image as PNG, without its alpha where that is 255 everywhere.
fn png(image: &Image) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    // Level 3 is within a few percent of the default level in a third of its time.
    let encoder = PngEncoder::new_with_quality(&mut out, CompressionType::Level(3), FilterType::Adaptive);
    let (w, h) = (image.width, image.height);
    if image.texels.is_empty() || image.texels.len() as u64 != w as u64 * h as u64 {
        return Err(format!("{} texels for {w} × {h}", image.texels.len()));
    }
    let written = if image.texels.iter().all(|t| t[3] == 255) {
        let rgb: Vec<u8> = image.texels.iter().flat_map(|t| [t[0], t[1], t[2]]).collect();
        encoder.write_image(&rgb, w, h, ExtendedColorType::Rgb8)
    } else {
        encoder.write_image(bytemuck::cast_slice(&image.texels), w, h, ExtendedColorType::Rgba8)
    };
    written.map_err(|e| e.to_string())?;
    Ok(out)
}
