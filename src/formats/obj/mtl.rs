//! MTL: materials of OBJ files.
//!
//! Where exporters and the format disagree, a material looks as common viewers show it, and a warning says so.

use super::{
    lower, numbers,
    paths::{self, Found},
    plain,
};
use crate::{
    formats::{
        FormatError,
        colors::{linear, opacity},
        loader::{Loader, Picture},
        text::{self, unquote, word},
    },
    scene::{Alpha, Image, Material, Texture, Wrap},
};
use std::{collections::BTreeMap, path::Path, sync::Arc};

/// A material and the files of its textures, as the MTL names them.
#[derive(Default)]
struct Row {
    material: Material,
    /// `d`, and `Tr`.
    dissolve: Option<f32>,
    transparency: Option<f32>,
    base: Option<Map>,
    emissive: Option<Map>,
    normal: Option<Map>,
    alpha: Option<Map>,
}

/// A texture statement.
#[derive(Clone)]
struct Map {
    line: usize,
    file: String,
    offset: [f32; 2],
    scale: [f32; 2],
    clamp: bool,
}

/// What a material is shown as other than written, or shows nothing for: reasons with the names of materials.
#[derive(Default)]
struct Doubts(BTreeMap<&'static str, Vec<String>>);

impl Doubts {
    fn add(&mut self, material: &str, reason: &'static str) {
        self.0.entry(reason).or_default().push(format!("`{material}`"));
    }

    fn tell(self, loader: &mut Loader, file: &Path) {
        for (reason, names) in self.0 {
            let more = if names.len() > 10 { format!(" and {} more", names.len() - 10) } else { String::new() };
            let word = if names.len() == 1 { "material" } else { "materials" };
            let first: Vec<_> = names.into_iter().take(10).collect();
            loader.warn(file, format!("{word} {}{more}: {reason}", first.join(", ")));
        }
    }
}

/// The materials in `text` that are `wanted`, in the order of their names.
pub(super) fn materials(
    loader: &mut Loader,
    file: &Path,
    home: &Path,
    text: &str,
    wanted: &dyn Fn(&str) -> bool,
) -> Result<Vec<(String, Arc<Material>)>, FormatError> {
    let mut rows = parse(loader, file, text)?;
    rows.retain(|name, _| wanted(name));
    let images = images(loader, file, home, &rows)?;
    let mut doubts = Doubts::default();
    let out = rows.into_iter().map(|(name, row)| (name, Arc::new(finish(row, &images, &mut doubts)))).collect();
    doubts.tell(loader, file);
    Ok(out)
}

fn parse(loader: &mut Loader, file: &Path, text: &str) -> Result<BTreeMap<String, Row>, FormatError> {
    let mut rows = BTreeMap::new();
    let mut current: Option<(String, Row)> = None;
    let mut bumps = 0;
    for (line, statement) in text::statements(text) {
        let bad = |what: String| FormatError::invalid(file, format!("line {line}"), what);
        let (key, rest) = word(&statement);
        let mut buffer = [0; 8];
        let key = lower(key, &mut buffer);
        if key == "newmtl" {
            if let Some((name, row)) = current.take() {
                rows.entry(name).or_insert(row);
            }
            let name = unquote(rest).to_owned();
            let material = Material { name: name.clone(), metallic: 0.0, ..Material::default() };
            current = Some((name, Row { material, ..Row::default() }));
            continue;
        }
        let Some((_, row)) = &mut current else { continue };
        let m = &mut row.material;
        let number = |text: &str| Ok::<f32, FormatError>(numbers::<1>(plain(text), &[]).map_err(bad)?[0] as f32);
        let color = |text: &str| {
            let text = plain(text);
            // Spectral curves and CIE colours are as good as never met.
            let grey = text::words(text).nth(1).is_none();
            let rgb = if grey { numbers::<1>(text, &[]).map(|[v]| [v; 3]) } else { numbers(text, &[]) };
            Ok::<_, FormatError>(rgb.map_err(bad)?.map(|c| linear(c as f32)))
        };
        let map = || map(line, rest).map_err(bad);
        match key {
            "kd" => {
                let [r, g, b] = color(rest)?;
                m.base_color = [r, g, b, 1.0];
            }
            "ke" => m.emissive = color(rest)?,
            "d" => {
                let (option, value) = word(rest);
                row.dissolve = Some(opacity(number(if option == "-halo" { value } else { rest })?));
            }
            "tr" => row.transparency = Some(opacity(number(rest)?)),
            "pm" => m.metallic = opacity(number(rest)?),
            "pr" => m.roughness = opacity(number(rest)?),
            "map_kd" => row.base = map()?,
            "map_ke" => row.emissive = map()?,
            "norm" | "map_kn" => row.normal = map()?,
            "map_d" => row.alpha = map()?,
            "map_bump" | "bump" => bumps += 1,
            _ => {}
        }
    }
    if let Some((name, row)) = current {
        rows.entry(name).or_insert(row);
    }
    if bumps > 0 {
        loader.warn(file, format!("{bumps} bump maps are left out"));
    }
    Ok(rows)
}

/// A texture statement: options, then the file's name, which may hold blanks.
fn map(line: usize, text: &str) -> Result<Option<Map>, String> {
    let mut out = Map { line, file: String::new(), offset: [0.0; 2], scale: [1.0; 2], clamp: false };
    let mut rest = text;
    while rest.starts_with('-') {
        let (option, mut tail) = word(rest);
        let mut buffer = [0; 8];
        match lower(option, &mut buffer) {
            option @ ("-o" | "-s" | "-t") => {
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
                out.clamp = value.eq_ignore_ascii_case("on");
                tail = after;
            }
            "-mm" => tail = word(word(tail).1).1,
            "-bm" | "-blendu" | "-blendv" | "-cc" | "-texres" | "-boost" | "-imfchan" | "-type" => tail = word(tail).1,
            // A file's name that begins so.
            _ => break,
        }
        rest = tail;
    }
    if out.offset.iter().chain(&out.scale).any(|v| !v.is_finite()) {
        return Err("an offset or scale that is not finite".into());
    }
    out.file = rest.to_owned();
    Ok((!out.file.is_empty()).then_some(out))
}

/// The images of all textures, by the name that the MTL gives them.
fn images(
    loader: &mut Loader,
    file: &Path,
    home: &Path,
    rows: &BTreeMap<String, Row>,
) -> Result<BTreeMap<String, Arc<Image>>, FormatError> {
    let maps = rows.values().flat_map(|r| [&r.base, &r.emissive, &r.normal, &r.alpha].into_iter().flatten());
    let mut lines = BTreeMap::new();
    for map in maps {
        lines.entry(&map.file).or_insert(map.line);
    }
    let mut pictures = Vec::with_capacity(lines.len());
    for (name, line) in &lines {
        let (path, bytes) = image(loader, file, home, name, *line)?;
        let range = 0..(*bytes).as_ref().len();
        let title = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        pictures.push(Picture { name: title, place: format!("line {line}, `{name}`"), bytes, range });
    }
    let decoded = loader.pictures(file, &pictures)?;
    Ok(lines.into_keys().cloned().zip(decoded).collect())
}

/// The file of one texture: the whole text is its name, or what stands before a comment.
fn image(
    loader: &mut Loader,
    file: &Path,
    home: &Path,
    name: &str,
    line: usize,
) -> Result<(std::path::PathBuf, crate::array::Bytes), FormatError> {
    let mut tried = match paths::find(loader, file, home, unquote(name))? {
        Found::File(path, bytes) => return Ok((path, bytes)),
        Found::Nothing(tried) => tried,
    };
    let mut shown = name;
    if let Some(at) = text::comment(name).filter(|at| *at > 0) {
        shown = text::trim(&name[..at]);
        match paths::find(loader, file, home, unquote(shown))? {
            Found::File(path, bytes) => return Ok((path, bytes)),
            Found::Nothing(more) => tried = more,
        }
    }
    Err(FormatError::invalid(file, format!("line {line}"), format!("the texture {}", paths::nowhere(shown, &tried))))
}

/// The material with its textures.
fn finish(row: Row, images: &BTreeMap<String, Arc<Image>>, doubts: &mut Doubts) -> Material {
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
    let alpha = alpha(&row, doubts);
    let mut m = row.material;
    m.base_color[3] = alpha;
    if alpha < 1.0 {
        m.alpha = Alpha::Blend;
    }
    m.base_color_texture = row.base.as_ref().map(texture);
    m.emissive_texture = row.emissive.as_ref().map(texture);
    if m.emissive_texture.is_some() && m.emissive == [0.0; 3] {
        m.emissive = [1.0; 3];
    }
    m.normal_texture = row.normal.as_ref().map(texture);
    let black = m.base_color[..3] == [0.0; 3];
    if black && m.base_color_texture.is_some() {
        m.base_color = [1.0, 1.0, 1.0, alpha];
        doubts.add(&m.name, "Kd 0 0 0 beside map_Kd; the texture is shown as it is");
    } else if black && m.emissive != [0.0; 3] {
        glow(&mut m);
        doubts.add(&m.name, "black but for Ke or map_Ke; shown unlit in the colour that it emits");
    } else if black && alpha > 0.0 {
        doubts.add(&m.name, "shown black: Kd 0 0 0, and no texture");
    }
    if let Some(alpha) = &row.alpha {
        m.alpha = Alpha::Mask { cutoff: 0.5 };
        m.base_color_texture = Some(match (m.base_color_texture, texture(alpha)) {
            (Some(base), holes) => Texture { image: with_alpha(&base.image, &holes.image), ..base },
            (None, holes) => Texture { image: with_alpha(&white(&holes.image), &holes.image), ..holes },
        });
    }
    m
}

/// The opacity that `d` and `Tr` mean. Several exporters write `Tr 1` for what is opaque.
fn alpha(row: &Row, doubts: &mut Doubts) -> f32 {
    let name = &row.material.name;
    let alpha = match (row.dissolve, row.transparency) {
        (None, None) => 1.0,
        (None, Some(1.0)) => {
            doubts.add(name, "Tr 1 without d; shown opaque, as the exporters that write it mean");
            1.0
        }
        (None, Some(tr)) => 1.0 - tr,
        (Some(0.0), Some(0.0)) => {
            doubts.add(name, "d 0 says invisible, Tr 0 says opaque; shown opaque");
            1.0
        }
        (Some(d), _) => d,
    };
    // Blending is drawn as a cutoff at 0.5.
    match alpha {
        0.0 => doubts.add(name, "invisible: d 0"),
        a if a < 0.5 => doubts.add(name, "invisible: d or Tr gives less than half of opacity, and nothing is blended"),
        a if a < 1.0 => doubts.add(name, "shown opaque: d or Tr gives half of opacity or more, and nothing is blended"),
        _ => {}
    }
    alpha
}

/// Shows what a black material emits as its own colour.
fn glow(m: &mut Material) {
    let [r, g, b] = std::mem::take(&mut m.emissive).map(opacity);
    m.base_color = [r, g, b, m.base_color[3]];
    m.base_color_texture = m.emissive_texture.take();
    m.unlit = true;
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
