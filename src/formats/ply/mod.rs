//! PLY (Turk 1994): ASCII and both binary byte orders, as one object named after the file.
//!
//! Own reader: the crates there are keep every value in a map of its own, tens of times the file's size, or trust the
//! header's counts. Known properties: vertex `x y z`, `nx ny nz`, `red green blue alpha` (sRGB, as scanners and viewers
//! write it), `s t`, `u v`, `texture_u texture_v` (v up); face `vertex_indices` or `vertex_index` and `red green blue
//! alpha`, which counts where vertices have no colour; `tristrips`. Everything else is skipped, of textures it is said.
//!
//! A face that cannot be shown is left out and counted in a warning: one that names a vertex that does not exist, one
//! with a corner that is no finite number, one without area.

mod body;
mod build;
mod face;
mod header;
mod vertex;

use super::{FormatError, loader::Loader, text};
use crate::{
    array::Bytes,
    math::Stopped,
    scene::{Material, Object, Part},
};
use body::Body;
use face::Faces;
use header::{Element, Header, Kind, Property};
use std::{borrow::Cow, path::Path, sync::Arc};
use vertex::Vertices;

pub(super) fn read(loader: &mut Loader, file: &Path, bytes: Bytes) -> Result<Vec<Object>, FormatError> {
    let invalid = |(place, what): (String, String)| FormatError::invalid(file, place, what);
    let all = bytes_of((*bytes).as_ref()).map_err(invalid)?;
    let (header, start) = header::parse(&all).map_err(invalid)?;
    let name = file.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    if !header.textures.is_empty() {
        let names = header.textures.join(", ");
        loader.warn(file, format!("textures of PLY files are left out: {names}; as glTF or OBJ the model keeps them"));
    }
    let (mut vertices, mut faces) = (Vertices::default(), Faces::default());
    let mut body = Body::new(&all[start..], &header, loader.stop);
    for element in &header.elements {
        loader.stop.check()?;
        let fault = |f: Fault| match f {
            Fault::At(place, what) => FormatError::invalid(file, place, what),
            Fault::Stopped(s) => s.into(),
        };
        // Where every element takes its least, this many could still follow.
        body.expect(element).map_err(fault)?;
        match element.name.as_str() {
            "vertex" => {
                loader.count_vertices(file, "vertex", element.count)?;
                vertices = Vertices::read(&mut body, element).map_err(fault)?;
            }
            "face" => {
                if element.properties.iter().any(|p| p.name == "texcoord") {
                    loader.warn(file, "texture coordinates of faces are left out");
                }
                faces.read(&mut body, element).map_err(fault)?;
            }
            "tristrips" => faces.read_strips(&mut body, element).map_err(fault)?,
            _ => body.skip(element).map_err(fault)?,
        }
    }
    let Some((mesh, origin)) = build::mesh(loader, file, &name, &vertices, &faces)? else {
        return Ok(Vec::new());
    };
    loader.count_object(file, &name, mesh.triangles.len() as u64)?;
    let part = Part { mesh: Arc::new(mesh), material: Arc::new(material()) };
    let transform = glam::Mat4::from_translation(origin.as_vec3());
    Ok(vec![Object { name, transform, parts: vec![part] }])
}

/// The bytes without a byte order mark; UTF-16 as UTF-8, which only text can be.
fn bytes_of(bytes: &[u8]) -> Result<Cow<'_, [u8]>, (String, String)> {
    match text::is_utf16(bytes) {
        true => Ok(text::decode(bytes)?.into_owned().into_bytes().into()),
        false => Ok(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).into()),
    }
}

/// PLY has no materials: white, neither metal nor glossy.
fn material() -> Material {
    Material { metallic: 0.0, ..Material::default() }
}

/// What is wrong, and where; or that nobody wants to know any more.
enum Fault {
    At(String, String),
    Stopped(Stopped),
}

impl From<(String, String)> for Fault {
    fn from((place, what): (String, String)) -> Self {
        Self::At(place, what)
    }
}

impl From<Stopped> for Fault {
    fn from(stopped: Stopped) -> Self {
        Self::Stopped(stopped)
    }
}

/// Where in an element each of `names` stands; `None` unless all do. Several spellings, the first found wins.
fn columns<const N: usize>(element: &Element, spellings: &[[&str; N]]) -> Option<[usize; N]> {
    spellings.iter().find_map(|names| {
        let at = names.map(|name| element.properties.iter().position(|p| p.name == name && p.list.is_none()));
        at.iter().all(Option::is_some).then(|| at.map(Option::unwrap_or_default))
    })
}

/// Where the colour of an element stands.
struct ColorColumns {
    rgb: [usize; 3],
    alpha: Option<usize>,
}

impl ColorColumns {
    fn of(element: &Element) -> Option<Self> {
        let rgb = columns(
            element,
            &[["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"], ["r", "g", "b"]],
        )?;
        let alpha = columns(element, &[["alpha"], ["diffuse_alpha"], ["a"]]).map(|[a]| a);
        Some(Self { rgb, alpha })
    }

    /// The colour in `row`, as it is written; NaN for an opacity that is not.
    fn pick(&self, element: &Element, row: &[f64]) -> [f32; 4] {
        let value = |at: usize| match element.properties[at].kind {
            // Some exporters write bytes as signed ones.
            Kind::I8 if row[at] < 0.0 => row[at] + 256.0,
            _ => row[at],
        };
        let [r, g, b] = self.rgb.map(value);
        [r, g, b, self.alpha.map_or(f64::NAN, value)].map(|v| v as f32)
    }

    fn kinds(&self, element: &Element) -> [Kind; 2] {
        let kind = |at: usize| element.properties[at].kind;
        [kind(self.rgb[0]), self.alpha.map_or(Kind::U8, kind)]
    }
}

/// Colours as they are written, with the types of their channels and of their opacity.
struct Colors {
    rows: Vec<[f32; 4]>,
    kinds: [Kind; 2],
}
