//! Wavefront OBJ with MTL: an object for every `o` or `g` that has faces, a part for every material in it.
//!
//! Own reader: `tobj` names no line in its errors and cuts words inside a character. Polygons are fanned into triangles;
//! vertices with equal numbers of position, texture coordinate and normal become one. Texture coordinates have v up
//! in the file. Colours of vertices (`v x y z r g b`) and of materials are sRGB, as viewers show them.

mod mtl;
mod shape;

use super::{FormatError, loader::Loader, mesh, ply::linear};
use crate::{
    array::Bytes,
    math::{Stop, Stopped},
    scene::{Material, Mesh, Object, Part},
};
use shape::{Corner, Shapes};
use std::{collections::BTreeMap, path::Path, sync::Arc};

/// The numbers of a file, as faces refer to them.
#[derive(Default)]
struct Pool {
    positions: Vec<[f32; 3]>,
    /// As long as the positions, or empty while no vertex has had a colour.
    colors: Vec<[f32; 4]>,
    uv: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
}

pub(super) fn read(loader: &mut Loader, file: &Path, bytes: Bytes) -> Result<Vec<Object>, FormatError> {
    let text = String::from_utf8_lossy((*bytes).as_ref());
    let mut pool = Pool::default();
    let stem = file.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let mut shapes = Shapes::new(stem);
    let mut libraries = Vec::new();
    let mut skipped = 0u64;
    for (number, line) in lines(&text) {
        if number % 4096 == 0 {
            loader.stop.check()?;
        }
        let bad = |what: String| FormatError::invalid(file, format!("line {number}"), what);
        let line = line.split('#').next().unwrap_or_default().trim();
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        match word {
            "v" => {
                loader.count_vertices(file, "v", 1)?;
                let (xyz, color) = vertex(rest).map_err(bad)?;
                if color.is_some() && pool.colors.is_empty() {
                    pool.colors = vec![[1.0; 4]; pool.positions.len()];
                }
                pool.positions.push(xyz);
                if !pool.colors.is_empty() || color.is_some() {
                    pool.colors.push(color.unwrap_or([1.0; 4]));
                }
            }
            "vt" => {
                let [u, v] = numbers::<2>(rest, &[0.0]).map_err(bad)?;
                pool.uv.push([u, 1.0 - v]);
            }
            "vn" => pool.normals.push(numbers::<3>(rest, &[]).map_err(bad)?),
            "f" => {
                let counts = [pool.positions.len(), pool.uv.len(), pool.normals.len()];
                let corner = |word: &str| corner(word, counts);
                let corners = rest.split_whitespace().map(corner).collect::<Result<Vec<_>, _>>().map_err(bad)?;
                shapes.face(&corners).map_err(bad)?;
            }
            "o" | "g" => shapes.name(rest.trim()),
            "usemtl" => shapes.material(rest.trim()),
            "mtllib" => libraries.push(rest.trim().to_owned()),
            "p" | "l" | "curv" | "curv2" | "surf" => skipped += 1,
            // Smoothing groups, and what else is no geometry.
            _ => {}
        }
    }
    if skipped > 0 {
        loader.warn(file, format!("{skipped} points, lines and curves are left out"));
    }
    let materials = mtl::materials(loader, file, &libraries)?;
    objects(loader, file, &pool, shapes, &materials)
}

/// Lines with their numbers, from 1; a backslash at the end of a line continues it.
fn lines(text: &str) -> impl Iterator<Item = (usize, std::borrow::Cow<'_, str>)> {
    let mut all = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (i, first) = all.next()?;
        let mut line = std::borrow::Cow::Borrowed(first);
        while let Some(head) = line.strip_suffix('\\') {
            let Some((_, more)) = all.next() else { break };
            line = format!("{head} {more}").into();
        }
        Some((i + 1, line))
    })
}

/// `N` numbers; the last ones may be missing where `defaults` has them.
fn numbers<const N: usize>(text: &str, defaults: &[f32]) -> Result<[f32; N], String> {
    let mut out = [0.0; N];
    let mut words = text.split_whitespace();
    for (i, v) in out.iter_mut().enumerate() {
        *v = match words.next() {
            Some(word) => word.parse().map_err(|_| format!("`{word}` is no number"))?,
            None => match defaults.len().checked_sub(N - i) {
                Some(k) => defaults[k],
                None => return Err(format!("{i} numbers where {N} are needed")),
            },
        };
    }
    Ok(out)
}

/// `x y z`, `x y z w`, `x y z r g b` or `x y z r g b a`.
fn vertex(text: &str) -> Result<([f32; 3], Option<[f32; 4]>), String> {
    let xyz = numbers::<3>(text, &[])?;
    if text.split_whitespace().nth(5).is_none() {
        return Ok((xyz, None));
    }
    let [_, _, _, r, g, b, a] = numbers::<7>(text, &[1.0])?;
    Ok((xyz, Some([linear(r), linear(g), linear(b), a])))
}

/// `v`, `v/vt`, `v//vn` or `v/vt/vn`; numbers count from 1, negative ones from the end.
fn corner(word: &str, counts: [usize; 3]) -> Result<Corner, String> {
    let mut out = [None; 3];
    let mut fields = word.split('/');
    for ((slot, count), what) in out.iter_mut().zip(counts).zip(["vertex", "texture coordinate", "normal"]) {
        let Some(field) = fields.next().filter(|f| !f.is_empty()) else { continue };
        let n: i64 = field.parse().map_err(|_| format!("`{word}` is no corner of a face"))?;
        let at = if n > 0 { n.checked_sub(1) } else { n.checked_add(count as i64).filter(|_| n < 0) };
        let at = at.filter(|at| (0..count as i64).contains(at));
        *slot = Some(at.ok_or_else(|| format!("{what} {n} does not exist; there are {count} so far"))? as u32);
    }
    match (out, fields.next()) {
        ([Some(v), uv, normal], None) => Ok((v, uv, normal)),
        _ => Err(format!("`{word}` is no corner of a face")),
    }
}

fn objects(
    loader: &mut Loader,
    file: &Path,
    pool: &Pool,
    shapes: Shapes,
    materials: &BTreeMap<String, Arc<Material>>,
) -> Result<Vec<Object>, FormatError> {
    let plain = Arc::new(Material { metallic: 0.0, ..Material::default() });
    let mut missing = std::collections::BTreeSet::new();
    let mut out: Vec<Object> = Vec::new();
    let mut builder = Builder::new(pool);
    for (name, material, faces) in shapes.finish() {
        loader.stop.check()?;
        let whole = builder.build(&faces, loader.stop)?;
        let mesh = mesh::finish(whole)
            .map_err(|(at, what)| FormatError::invalid(file, format!("object `{name}`, {at}"), what))?;
        let material = match materials.get(&material) {
            Some(m) => m.clone(),
            None => {
                missing.insert(material);
                plain.clone()
            }
        };
        let part = Part { mesh: Arc::new(mesh), material };
        match out.last_mut().filter(|o| o.name == name) {
            Some(object) => object.parts.push(part),
            None => out.push(Object { name, transform: glam::Mat4::IDENTITY, parts: vec![part] }),
        }
    }
    missing.remove("");
    if !missing.is_empty() {
        let names: Vec<_> = missing.into_iter().take(10).collect();
        loader.warn(file, format!("materials without a definition, shown white: {}", names.join(", ")));
    }
    for o in &out {
        loader.count_object(file, &o.name, o.triangle_count() as u64)?;
    }
    Ok(out)
}

/// Makes meshes of triangles: one vertex for every distinct corner, in the order of first use.
struct Builder<'a> {
    pool: &'a Pool,
    /// For every position the last vertex made of it in the current mesh.
    last: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl<'a> Builder<'a> {
    fn new(pool: &'a Pool) -> Self {
        Self { pool, last: vec![NONE; pool.positions.len()] }
    }

    fn build(&mut self, faces: &[[Corner; 3]], stop: &Stop) -> Result<Mesh, Stopped> {
        let all = |has: fn(&Corner) -> bool| faces.iter().flatten().all(has);
        let (textured, lit) = (all(|c| c.1.is_some()), all(|c| c.2.is_some()));
        let mut corners: Vec<Corner> = Vec::new();
        // Vertices of the same position are chained: there are few of each.
        let mut before: Vec<u32> = Vec::new();
        let mut triangles = Vec::with_capacity(faces.len());
        for (i, face) in faces.iter().enumerate() {
            if i % 4096 == 0 {
                stop.check()?;
            }
            triangles.push(face.map(|(v, uv, n)| {
                let corner = (v, uv.filter(|_| textured), n.filter(|_| lit));
                let last = &mut self.last[v as usize];
                let mut at = *last;
                while at != NONE && corners[at as usize] != corner {
                    at = before[at as usize];
                }
                if at == NONE {
                    at = corners.len() as u32;
                    before.push(std::mem::replace(last, at));
                    corners.push(corner);
                }
                at
            }));
        }
        corners.iter().for_each(|c| self.last[c.0 as usize] = NONE);
        let pool = self.pool;
        Ok(Mesh {
            positions: corners.iter().map(|c| pool.positions[c.0 as usize]).collect(),
            normals: corners.iter().filter_map(|c| Some(pool.normals[c.2? as usize])).collect(),
            uv: [corners.iter().filter_map(|c| Some(pool.uv[c.1? as usize])).collect(), Default::default()],
            colors: match pool.colors.is_empty() {
                true => Default::default(),
                false => corners.iter().map(|c| pool.colors[c.0 as usize]).collect(),
            },
            triangles: triangles.into(),
            ..Mesh::default()
        })
    }
}
