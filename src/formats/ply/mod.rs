//! PLY (Turk 1994): ASCII and both binary byte orders, as one object named after the file.
//!
//! Own reader: the crates there are keep every value in a map of its own, tens of times the file's size, or trust the header's counts.
//! Known properties: vertex `x y z`, `nx ny nz`, `red green blue alpha` (integers as fractions of their maximum; sRGB,
//! as scanners and viewers write it), `s t`, `u v`, `texture_u texture_v` (v up); face `vertex_indices` or `vertex_index`, polygons fanned
//! into triangles; `tristrips`. Everything else is skipped, of textures it is said.

mod body;
mod header;

use super::{FormatError, loader::Loader, mesh};
use crate::{
    array::Bytes,
    math::Stopped,
    scene::{Material, Mesh, Object, Part},
};
use body::Body;
use header::{Element, Header, Kind, Property};
use std::{path::Path, sync::Arc};

pub(super) fn read(loader: &mut Loader, file: &Path, bytes: Bytes) -> Result<Vec<Object>, FormatError> {
    let all: &[u8] = (*bytes).as_ref();
    let (header, start) = header::parse(all).map_err(|(place, what)| FormatError::invalid(file, place, what))?;
    let name = file.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    if !header.textures.is_empty() {
        let names = header.textures.join(", ");
        loader.warn(file, format!("textures of PLY files are left out: {names}; as glTF or OBJ the model keeps them"));
    }
    let mut mesh = Mesh::default();
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
                vertices(&mut body, element, &mut mesh).map_err(fault)?;
            }
            "face" => {
                if element.properties.iter().any(|p| p.name == "texcoord") {
                    loader.warn(file, "texture coordinates of faces are left out");
                }
                mesh.triangles = faces(&mut body, element).map_err(fault)?.into();
            }
            "tristrips" => mesh.triangles = strips(&mut body, element).map_err(fault)?.into(),
            _ => body.skip(element).map_err(fault)?,
        }
    }
    let place = |at: String| format!("mesh `{name}`, {at}");
    let mesh = mesh::finish(mesh).map_err(|(at, what)| FormatError::invalid(file, place(at), what))?;
    if mesh.triangles.is_empty() {
        loader.warn(file, "has no faces");
        return Ok(Vec::new());
    }
    loader.count_object(file, &name, mesh.triangles.len() as u64)?;
    let part = Part { mesh: Arc::new(mesh), material: Arc::new(material()) };
    Ok(vec![Object { name, transform: glam::Mat4::IDENTITY, parts: vec![part] }])
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

/// Where in a vertex each of `names` stands; `None` unless all do. Several spellings, the first found wins.
fn columns<const N: usize>(element: &Element, spellings: &[[&str; N]]) -> Option<[usize; N]> {
    spellings.iter().find_map(|names| {
        let at = names.map(|name| element.properties.iter().position(|p| p.name == name && p.list.is_none()));
        at.iter().all(Option::is_some).then(|| at.map(Option::unwrap_or_default))
    })
}

fn vertices(body: &mut Body, element: &Element, mesh: &mut Mesh) -> Result<(), Fault> {
    let Some(xyz) = columns(element, &[["x", "y", "z"]]) else {
        return Err(Fault::At("header".into(), "vertices without x, y, z".into()));
    };
    let normal = columns(element, &[["nx", "ny", "nz"], ["normal_x", "normal_y", "normal_z"]]);
    let color = columns(
        element,
        &[["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"], ["r", "g", "b"]],
    );
    let alpha = columns(element, &[["alpha"], ["diffuse_alpha"], ["a"]]).filter(|_| color.is_some());
    let uv = columns(element, &[["s", "t"], ["u", "v"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]]);
    let count = element.count as usize;
    let room = |wanted: bool| if wanted { count } else { 0 };
    let mut positions = Vec::with_capacity(count);
    let mut normals = Vec::with_capacity(room(normal.is_some()));
    let mut colors = Vec::with_capacity(room(color.is_some()));
    let mut uvs = Vec::with_capacity(room(uv.is_some()));
    let largest = |at: usize| element.properties[at].kind.largest();
    let mut row = vec![0.0f64; element.properties.len()];
    for i in 0..count {
        body.row(element, i as u64, &mut row)?;
        let pick = |at: [usize; 3]| at.map(|at| row[at] as f32);
        positions.push(pick(xyz));
        if let Some(at) = normal {
            normals.push(pick(at));
        }
        if let Some(at) = color {
            let [r, g, b] = at.map(|at| linear((row[at] / largest(at)) as f32));
            let a = alpha.map_or(1.0, |[at]| (row[at] / largest(at)) as f32);
            colors.push([r, g, b, a]);
        }
        if let Some([u, v]) = uv {
            uvs.push([row[u] as f32, 1.0 - row[v] as f32]);
        }
    }
    mesh.positions = positions.into();
    mesh.normals = normals.into();
    mesh.colors = colors.into();
    mesh.uv[0] = uvs.into();
    Ok(())
}

/// sRGB to linear (IEC 61966-2-1); what is not finite stays so, for the mesh's check to find.
pub(super) fn linear(c: f32) -> f32 {
    if c <= 0.04045 { c / 12.92 } else { libm::powf((c + 0.055) / 1.055, 2.4) }
}

fn faces(body: &mut Body, element: &Element) -> Result<Vec<[u32; 3]>, Fault> {
    let at = element.properties.iter().position(|p| p.list.is_some() && p.name.starts_with("vertex_ind"));
    let Some(at) = at else {
        return Err(Fault::At("header".into(), "faces without the list vertex_indices".into()));
    };
    let mut out = Vec::with_capacity(element.count as usize);
    let mut polygon = Vec::new();
    for i in 0..element.count {
        body.list(element, i, at, &mut polygon)?;
        let corner = |v: i64| u32::try_from(v).map_err(|_| (format!("face {i}"), format!("vertex number {v}")));
        let Some((first, rest)) = polygon.split_first() else { continue };
        let first = corner(*first)?;
        for pair in rest.windows(2) {
            out.push([first, corner(pair[0])?, corner(pair[1])?]);
        }
    }
    Ok(out)
}

/// Strips of triangles in one list, -1 between them.
fn strips(body: &mut Body, element: &Element) -> Result<Vec<[u32; 3]>, Fault> {
    let at = element.properties.iter().position(|p| p.list.is_some());
    let Some(at) = at else { return Err(Fault::At("header".into(), "tristrips without a list".into())) };
    let mut out = Vec::new();
    let mut order = Vec::new();
    for i in 0..element.count {
        body.list(element, i, at, &mut order)?;
        for strip in order.split(|v| *v < 0) {
            let corner = |v: i64| u32::try_from(v).map_err(|_| (format!("strip {i}"), format!("vertex number {v}")));
            for (k, w) in strip.windows(3).enumerate() {
                let [a, b, c] = [corner(w[0])?, corner(w[1])?, corner(w[2])?];
                let t = if k % 2 == 0 { [a, b, c] } else { [a, c, b] };
                // Strips turn corners by repeating vertices.
                if a != b && b != c && a != c {
                    out.push(t);
                }
            }
        }
    }
    Ok(out)
}
