//! MTL: materials of OBJ files.

use super::{Loader, linear, lines, numbers};
use crate::{
    formats::{FormatError, loader::Picture},
    scene::{Alpha, Image, Material, Texture, Wrap},
};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
    sync::Arc,
};

/// A material and the files of its textures, as the MTL names them.
#[derive(Default)]
struct Row {
    material: Material,
    base: Option<Map>,
    emissive: Option<Map>,
    normal: Option<Map>,
    alpha: Option<Map>,
}

/// A texture statement.
#[derive(Clone)]
struct Map {
    file: String,
    offset: [f32; 2],
    scale: [f32; 2],
    clamp: bool,
}

/// The materials of all libraries by name; of two with one name the first counts. A library that is not there is a
/// warning, as in every viewer; a texture that is not there is an error.
pub(super) fn materials(
    loader: &mut Loader,
    file: &Path,
    libraries: &[String],
) -> Result<BTreeMap<String, Arc<Material>>, FormatError> {
    let mut out = BTreeMap::new();
    for name in libraries {
        let path = loader.resolve(file, name)?;
        let bytes = match loader.read(&path) {
            Ok(bytes) => bytes,
            Err(FormatError::Missing { .. }) => {
                loader.warn(file, format!("the material library `{name}` does not exist"));
                continue;
            }
            Err(e) => return Err(e),
        };
        let text = String::from_utf8_lossy((*bytes).as_ref());
        let rows = parse(loader, &path, &text)?;
        let images = images(loader, &path, &rows)?;
        for (name, row) in rows {
            let material = Arc::new(finish(row, &images));
            out.entry(name).or_insert(material);
        }
    }
    Ok(out)
}

fn parse(loader: &mut Loader, file: &Path, text: &str) -> Result<BTreeMap<String, Row>, FormatError> {
    let mut rows = BTreeMap::new();
    let mut current: Option<(String, Row)> = None;
    for (number, line) in lines(text) {
        let bad = |what: String| FormatError::invalid(file, format!("line {number}"), what);
        let line = line.split('#').next().unwrap_or_default().trim();
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        if word == "newmtl" {
            if let Some((name, row)) = current.take() {
                rows.entry(name).or_insert(row);
            }
            let name = rest.trim().to_owned();
            let material = Material { name: name.clone(), metallic: 0.0, ..Material::default() };
            current = Some((name, Row { material, ..Row::default() }));
            continue;
        }
        let Some((_, row)) = &mut current else { continue };
        let m = &mut row.material;
        let number = |text: &str| Ok::<f32, FormatError>(numbers::<1>(text, &[]).map_err(bad)?[0]);
        let color = |text: &str| {
            // Spectral curves and CIE colours are as good as never met.
            let grey = text.split_whitespace().nth(1).is_none();
            let rgb =
                if grey { [numbers::<1>(text, &[]).map_err(bad)?[0]; 3] } else { numbers(text, &[]).map_err(bad)? };
            Ok::<_, FormatError>(rgb.map(|c: f32| linear(c.clamp(0.0, 1.0))))
        };
        match word {
            "Kd" => {
                let [r, g, b] = color(rest)?;
                m.base_color = [r, g, b, m.base_color[3]];
            }
            "Ke" => m.emissive = color(rest)?,
            "d" => m.base_color[3] = number(rest.trim_start_matches("-halo"))?.clamp(0.0, 1.0),
            "Tr" => m.base_color[3] = 1.0 - number(rest)?.clamp(0.0, 1.0),
            "Pm" => m.metallic = number(rest)?.clamp(0.0, 1.0),
            "Pr" => m.roughness = number(rest)?.clamp(0.0, 1.0),
            "map_Kd" => row.base = map(rest).map_err(bad)?,
            "map_Ke" => row.emissive = map(rest).map_err(bad)?,
            "norm" | "map_Kn" => row.normal = map(rest).map_err(bad)?,
            "map_d" => row.alpha = map(rest).map_err(bad)?,
            "map_bump" | "map_Bump" | "bump" => loader.warn(file, format!("bump map `{rest}` is left out")),
            _ => {}
        }
    }
    if let Some((name, row)) = current {
        rows.entry(name).or_insert(row);
    }
    Ok(rows)
}

/// A texture statement: options, then the file's name, which may hold blanks.
fn map(text: &str) -> Result<Option<Map>, String> {
    let mut out = Map { file: String::new(), offset: [0.0; 2], scale: [1.0; 2], clamp: false };
    let mut rest = text.trim();
    while rest.starts_with('-') {
        let (option, mut tail) = word(rest);
        match option {
            "-o" | "-s" | "-t" => {
                let mut values = Vec::new();
                while let (w, after) = word(tail)
                    && let Ok(v) = w.parse::<f32>()
                    && values.len() < 3
                {
                    values.push(v);
                    tail = after;
                }
                let target = match option {
                    "-o" => &mut out.offset,
                    "-s" => &mut out.scale,
                    _ => &mut [0.0; 2],
                };
                target.iter_mut().zip(values).for_each(|(t, v)| *t = v);
            }
            "-clamp" => {
                let (value, after) = word(tail);
                out.clamp = value == "on";
                tail = after;
            }
            "-mm" => tail = word(word(tail).1).1,
            "-bm" | "-blendu" | "-blendv" | "-cc" | "-texres" | "-boost" | "-imfchan" | "-type" => tail = word(tail).1,
            _ => return Err(format!("unknown option `{option}`")),
        }
        rest = tail;
    }
    if out.offset.iter().chain(&out.scale).any(|v| !v.is_finite()) {
        return Err("an offset or scale that is not finite".into());
    }
    out.file = rest.replace('\\', "/");
    Ok((!out.file.is_empty()).then_some(out))
}

/// The first word, and what follows it.
fn word(text: &str) -> (&str, &str) {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim_start())
}

/// The images of all textures, by the name that the MTL gives them.
fn images(
    loader: &mut Loader,
    file: &Path,
    rows: &BTreeMap<String, Row>,
) -> Result<BTreeMap<String, Arc<Image>>, FormatError> {
    let maps = rows.values().flat_map(|r| [&r.base, &r.emissive, &r.normal, &r.alpha].into_iter().flatten());
    let names: BTreeSet<&String> = maps.map(|m| &m.file).collect();
    let mut pictures = Vec::with_capacity(names.len());
    for name in &names {
        let bytes = loader.read(&loader.resolve(file, name)?)?;
        let range = 0..(*bytes).as_ref().len();
        pictures.push(Picture { name: (*name).clone(), place: format!("`{name}`"), bytes, range });
    }
    let decoded = loader.pictures(file, &pictures)?;
    Ok(names.into_iter().cloned().zip(decoded).collect())
}

/// The material with its textures.
fn finish(row: Row, images: &BTreeMap<String, Arc<Image>>) -> Material {
    let texture = |map: &Map| {
        let wrap = if map.clamp { Wrap::Clamp } else { Wrap::Repeat };
        Texture {
            image: images[&map.file].clone(),
            uv_set: 0,
            // v' = s v + o with v up is v' = s v + (1 - s - o) with v down.
            offset: [map.offset[0], 1.0 - map.scale[1] - map.offset[1]],
            rotation: 0.0,
            scale: map.scale,
            wrap: [wrap; 2],
            smooth: true,
        }
    };
    let mut m = row.material;
    if m.base_color[3] < 1.0 {
        m.alpha = Alpha::Blend;
    }
    m.base_color_texture = row.base.as_ref().map(texture);
    m.emissive_texture = row.emissive.as_ref().map(texture);
    if m.emissive_texture.is_some() && m.emissive == [0.0; 3] {
        m.emissive = [1.0; 3];
    }
    m.normal_texture = row.normal.as_ref().map(texture);
    if let Some(alpha) = &row.alpha {
        m.alpha = Alpha::Mask { cutoff: 0.5 };
        m.base_color_texture = Some(match (m.base_color_texture, texture(alpha)) {
            (Some(base), holes) => Texture { image: with_alpha(&base.image, &holes.image), ..base },
            (None, holes) => Texture { image: with_alpha(&white(&holes.image), &holes.image), ..holes },
        });
    }
    m
}

fn white(like: &Image) -> Arc<Image> {
    let (width, height) = (like.width, like.height);
    let texels = vec![[255; 4]; like.texels.len()].into();
    Arc::new(Image { name: like.name.clone(), width, height, texels })
}

/// `base` with the opacity that `holes` shows: its alpha where it has any, else its red, at the nearest texel.
fn with_alpha(base: &Arc<Image>, holes: &Image) -> Arc<Image> {
    let channel = if holes.texels.iter().any(|t| t[3] < 255) { 3 } else { 0 };
    let (w, h) = (base.width as u64, base.height as u64);
    let at = |i: u64| {
        let (x, y) = (i % w * holes.width as u64 / w, i / w * holes.height as u64 / h);
        holes.texels[(y * holes.width as u64 + x) as usize][channel]
    };
    let texels = base.texels.iter().enumerate().map(|(i, t)| [t[0], t[1], t[2], at(i as u64)]).collect();
    Arc::new(Image { name: base.name.clone(), texels, ..(**base).clone() })
}
