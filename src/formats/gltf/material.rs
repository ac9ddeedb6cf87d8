//! Materials, their textures and images.

use super::{FormatError, accessor::Numbers, container::Span, fetch, schema};
use crate::{
    formats::{
        appearance,
        loader::{Loader, Picture},
    },
    scene::{Alpha, Image, Material, Texture, Wrap},
};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
    sync::Arc,
};

/// The materials with these numbers; equal ones share an `Arc`. `None` is glTF's default material.
pub(super) fn materials(
    loader: &mut Loader,
    numbers: &Numbers,
    used: &BTreeSet<Option<u64>>,
) -> Result<BTreeMap<Option<u64>, Arc<Material>>, FormatError> {
    let mut rows = BTreeMap::new();
    for index in used.iter().copied().flatten() {
        let all = &numbers.root.materials;
        let missing = || format!("does not exist; there are {}", all.len());
        let row = usize::try_from(index).ok().and_then(|i| all.get(i));
        rows.insert(
            index,
            row.ok_or_else(|| FormatError::invalid(numbers.file, format!("materials[{index}]"), missing()))?,
        );
    }
    let infos = |m: &schema::Material| {
        let pbr = metallic_roughness(m);
        let all = [
            pbr.base_color_texture,
            pbr.metallic_roughness_texture,
            m.normal_texture.clone(),
            m.emissive_texture.clone(),
            m.occlusion_texture.clone(),
        ];
        all.into_iter().flatten().map(|t| t.index)
    };
    let textures: BTreeSet<u64> = rows.values().flat_map(|m| infos(m)).collect();
    let images = images(loader, numbers, &textures)?;
    let mut out = BTreeMap::<Option<u64>, Arc<Material>>::new();
    for (index, row) in rows {
        let (material, shown) = appearance::as_viewers_show(material(loader, numbers, index, row, &images)?);
        let told = shown.or_else(|| appearance::trouble(&material)).or_else(|| transmits(row));
        if let Some(what) = told {
            loader.note(numbers.file, &place(numbers.root, index), what);
        }
        // Few materials: comparing with each is cheap beside what they are used for.
        let same = out.values().find(|m| ***m == material).cloned();
        out.insert(Some(index), same.unwrap_or_else(|| Arc::new(material)));
    }
    if used.contains(&None) {
        out.insert(None, Arc::new(Material { double_sided: false, ..Material::default() }));
    }
    Ok(out)
}

/// The decoded image of every texture; `None` for textures whose image only an extension names.
fn images(
    loader: &mut Loader,
    numbers: &Numbers,
    textures: &BTreeSet<u64>,
) -> Result<BTreeMap<u64, Option<Arc<Image>>>, FormatError> {
    let file = numbers.file;
    let mut source_of = BTreeMap::new();
    for t in textures {
        let texture = usize::try_from(*t).ok().and_then(|i| numbers.root.textures.get(i));
        let texture = texture.ok_or_else(|| FormatError::invalid(file, format!("textures[{t}]"), "does not exist"))?;
        source_of.insert(*t, source(loader, file, *t, texture)?);
    }
    let sources: BTreeSet<u64> = source_of.values().copied().flatten().collect();
    let mut pictures = Vec::new();
    for s in &sources {
        let place = format!("images[{s}]");
        let image = usize::try_from(*s).ok().and_then(|i| numbers.root.images.get(i));
        let image = image.ok_or_else(|| FormatError::invalid(file, &place, "does not exist"))?;
        let span = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => Span::whole(fetch(loader, file, &place, uri)?),
            (None, Some(view)) => numbers.view(view, &place)?.0,
            (None, None) => return Err(FormatError::invalid(file, &place, "neither a URI nor a buffer view")),
        };
        let named_file = image.uri.as_deref().filter(|u| !u.starts_with("data:")).map(str::to_owned);
        let name = image.name.clone().or(named_file).unwrap_or_default();
        pictures.push(Picture { name, place, bytes: span.bytes, range: span.range });
    }
    let decoded: BTreeMap<u64, Arc<Image>> = sources.iter().copied().zip(loader.pictures(file, &pictures)?).collect();
    Ok(source_of.into_iter().map(|(t, s)| (t, s.and_then(|s| decoded.get(&s).cloned()))).collect())
}

/// A material's number and name.
pub(super) fn place(root: &schema::Root, index: u64) -> String {
    let row = usize::try_from(index).ok().and_then(|i| root.materials.get(i));
    let name = row.and_then(|m| m.name.as_deref()).map(|n| format!(" `{n}`")).unwrap_or_default();
    format!("materials[{index}]{name}")
}

/// The image of a texture: the one that an extension names, where that is read; else the plain one.
fn source(loader: &mut Loader, file: &Path, index: u64, texture: &schema::Texture) -> Result<Option<u64>, FormatError> {
    let e = &texture.extensions;
    if let Some(webp) = e.webp.as_ref().and_then(|w| w.source).or(texture.source) {
        return Ok(Some(webp));
    }
    let place = format!("textures[{index}]");
    let unread = [
        (&e.basisu, "a KTX2 image (KHR_texture_basisu)"),
        (&e.avif, "an AVIF image (EXT_texture_avif)"),
        (&e.dds, "a DDS image (MSFT_texture_dds)"),
    ];
    if let Some((_, what)) = unread.iter().find(|(e, _)| e.is_some()) {
        let what = format!("has only {what}, which cannot be read; export the file with PNG, JPEG or WebP textures");
        return Err(FormatError::invalid(file, place, what));
    }
    loader.note(file, &place, "has no image; left out");
    Ok(None)
}

/// The material's metallic-roughness model. A specular-glossiness material's diffuse colour is its base colour.
fn metallic_roughness(m: &schema::Material) -> schema::Pbr {
    match &m.extensions.specular_glossiness {
        None => m.pbr_metallic_roughness.clone().unwrap_or_default(),
        Some(sg) => schema::Pbr {
            base_color_factor: sg.diffuse_factor,
            base_color_texture: sg.diffuse_texture.clone(),
            metallic_factor: Some(0.0),
            roughness_factor: Some(1.0 - sg.glossiness_factor.unwrap_or(1.0)),
            metallic_roughness_texture: None,
        },
    }
}

fn transmits(m: &schema::Material) -> Option<&'static str> {
    let factor = m.extensions.transmission.as_ref().and_then(|t| t.transmission_factor).unwrap_or(0.0);
    (factor > 0.0)
        .then_some("lets light through (KHR_materials_transmission); it is drawn opaque, what is behind it is hidden")
}

fn material(
    loader: &mut Loader,
    numbers: &Numbers,
    index: u64,
    m: &schema::Material,
    images: &BTreeMap<u64, Option<Arc<Image>>>,
) -> Result<Material, FormatError> {
    let place = format!("materials[{index}]");
    let bad = |what: String| FormatError::invalid(numbers.file, &place, what);
    let pbr = metallic_roughness(m);
    let alpha = match m.alpha_mode.as_deref().unwrap_or("OPAQUE") {
        "OPAQUE" => Alpha::Opaque,
        "MASK" => Alpha::Mask { cutoff: m.alpha_cutoff.unwrap_or(0.5) },
        "BLEND" => Alpha::Blend,
        other => return Err(bad(format!("alpha mode `{other}`; expected OPAQUE, MASK or BLEND"))),
    };
    let strength = m.extensions.emissive_strength.as_ref().and_then(|e| e.emissive_strength).unwrap_or(1.0);
    let mut use_of = |info: &Option<schema::TextureInfo>| match info {
        Some(info) => texture(loader, numbers, info, images),
        None => Ok(None),
    };
    let out = Material {
        name: m.name.clone().unwrap_or_default(),
        base_color: pbr.base_color_factor.unwrap_or([1.0; 4]),
        base_color_texture: use_of(&pbr.base_color_texture)?,
        metallic: pbr.metallic_factor.unwrap_or(1.0),
        roughness: pbr.roughness_factor.unwrap_or(1.0),
        metallic_roughness_texture: use_of(&pbr.metallic_roughness_texture)?,
        normal_scale: m.normal_texture.as_ref().and_then(|t| t.scale).unwrap_or(1.0),
        normal_texture: use_of(&m.normal_texture)?,
        emissive: m.emissive_factor.unwrap_or_default().map(|c| c * strength),
        emissive_texture: use_of(&m.emissive_texture)?,
        occlusion_strength: m.occlusion_texture.as_ref().and_then(|t| t.strength).unwrap_or(1.0),
        occlusion_texture: use_of(&m.occlusion_texture)?,
        alpha,
        double_sided: m.double_sided,
        unlit: m.extensions.unlit.is_some(),
    };
    let factors = out.base_color.iter().chain(&out.emissive).chain([
        &out.metallic,
        &out.roughness,
        &out.normal_scale,
        &out.occlusion_strength,
    ]);
    let wild = factors.copied().find(|f| !f.is_finite());
    wild.map_or(Ok(()), |f| Err(bad(format!("a factor is {f}; it must be finite"))))?;
    Ok(out)
}

fn texture(
    loader: &mut Loader,
    numbers: &Numbers,
    info: &schema::TextureInfo,
    images: &BTreeMap<u64, Option<Arc<Image>>>,
) -> Result<Option<Texture>, FormatError> {
    let Some(image) = images.get(&info.index).cloned().flatten() else { return Ok(None) };
    let place = format!("textures[{}]", info.index);
    let bad = |what: String| FormatError::invalid(numbers.file, &place, what);
    let transform = info.extensions.transform.clone().unwrap_or_default();
    let uv_set = transform.tex_coord.unwrap_or(info.tex_coord);
    if uv_set > 1 {
        loader
            .warn(numbers.file, format!("{place} uses texture coordinates {uv_set}; only 0 and 1 are kept; left out"));
        return Ok(None);
    }
    let sampler = usize::try_from(info.index).ok().and_then(|i| numbers.root.textures.get(i)).and_then(|t| t.sampler);
    let sampler = match sampler {
        None => schema::Sampler::default(),
        Some(s) => {
            let found = usize::try_from(s).ok().and_then(|s| numbers.root.samplers.get(s));
            found.ok_or_else(|| bad(format!("sampler {s} does not exist")))?.clone()
        }
    };
    let wrap = |code: Option<u64>| match code.unwrap_or(10497) {
        10497 => Ok(Wrap::Repeat),
        33648 => Ok(Wrap::Mirror),
        33071 => Ok(Wrap::Clamp),
        other => Err(bad(format!("unknown wrapping {other}"))),
    };
    let (offset, scale) = (transform.offset.unwrap_or([0.0; 2]), transform.scale.unwrap_or([1.0; 2]));
    let rotation = transform.rotation.unwrap_or(0.0);
    if !offset.iter().chain(&scale).chain([&rotation]).all(|v| v.is_finite()) {
        return Err(bad("its transform is not finite".into()));
    }
    Ok(Some(Texture {
        image,
        uv_set: uv_set as u8,
        offset,
        rotation,
        scale,
        wrap: [wrap(sampler.wrap_s)?, wrap(sampler.wrap_t)?],
        smooth: sampler.mag_filter != Some(9728),
    }))
}
