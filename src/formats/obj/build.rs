//! Meshes of an OBJ file: faces cut into triangles, one vertex for every distinct corner.

use super::{
    Pool,
    library::Library,
    shape::{ABSENT, Corner, Faces},
};
use crate::{
    formats::{
        FormatError,
        colors::{full_scale, linear, opacity, survey},
        loader::Loader,
        mesh::{self, BEYOND, BROKEN, FLAT, Left},
        polygon::Polygons,
        weld::Weld,
    },
    math::{
        Aabb, Stop, Stopped,
        shift::{shift, storable},
    },
    scene::{Mesh, Object, Part},
};
use glam::DVec3;
use std::{collections::BTreeSet, path::Path, sync::Arc};

type Shape = (String, String, Faces);

/// What became of faces and corners that are not as they should be.
#[derive(Default)]
struct Notes {
    /// Faces with a vertex that does not exist; with one that is no finite number; without area.
    beyond: Left,
    broken: Left,
    flat: Left,
    /// Faces whose texture coordinates or normals do not exist or are no finite numbers.
    bare: Left,
    /// Triangles that rounding to 32 bits has collapsed.
    rounded: u64,
}

pub(super) fn objects(
    loader: &mut Loader,
    file: &Path,
    pool: &Pool,
    shapes: Vec<Shape>,
    materials: &Library,
) -> Result<Vec<Object>, FormatError> {
    let mut notes = Notes::default();
    let origin = shift(&bounds(pool, &shapes, loader.stop)?);
    let colors = colors(loader, file, pool);
    let mut builder = Builder::new(pool, &colors, origin);
    let mut missing = BTreeSet::new();
    let mut out: Vec<Object> = Vec::new();
    for (name, material, faces) in shapes {
        let groups = builder.cut(&faces, loader.stop, &mut notes)?;
        let shown = materials.find(&material);
        if shown.is_none() && !material.is_empty() {
            missing.insert(material);
        }
        let shown = shown.unwrap_or_else(|| materials.plain());
        for triangles in groups.iter().filter(|g| !g.is_empty()) {
            let whole = builder.mesh(triangles, loader.stop, &mut notes)?;
            let mesh = mesh::finish(whole)
                .map_err(|(at, what)| FormatError::invalid(file, format!("object `{name}`, {at}"), what))?;
            let part = Part { mesh: Arc::new(mesh), material: shown.clone() };
            match out.last_mut().filter(|o| o.name == name) {
                Some(object) => object.parts.push(part),
                None => out.push(Object {
                    name: name.clone(),
                    transform: glam::Mat4::from_translation(origin.as_vec3()),
                    parts: vec![part],
                }),
            }
        }
    }
    if !missing.is_empty() {
        let names: Vec<_> = missing.into_iter().take(10).collect();
        loader.warn(file, format!("materials without a definition, shown white: {}", names.join(", ")));
    }
    notes.tell(loader, file);
    for o in &out {
        loader.count_object(file, &o.name, o.triangle_count() as u64)?;
    }
    Ok(out)
}

impl Notes {
    fn tell(&self, loader: &mut Loader, file: &Path) {
        let reasons = [
            (&self.beyond, "left out", BEYOND),
            (&self.broken, "left out", BROKEN),
            (&self.flat, "left out", FLAT),
            (&self.bare, "shown without texture coordinates or normals", "whose own do not exist or are not finite"),
        ];
        for (left, what, which) in reasons {
            if left.count > 0 {
                let Left { count, first } = left;
                loader.warn(file, format!("faces {what}: {count} {which}, the first in line {first}"));
            }
        }
        if self.rounded > 0 {
            let what =
                "triangles collapse where coordinates are rounded to 32 bits; parts of the file lie too far apart";
            loader.warn(file, format!("{} {what}", self.rounded));
        }
    }
}

/// The box around what faces use.
fn bounds(pool: &Pool, shapes: &[Shape], stop: &Stop) -> Result<Aabb, Stopped> {
    let mut out = Aabb::EMPTY;
    for (_, _, faces) in shapes {
        stop.check()?;
        for corner in faces.iter().flat_map(|(_, corners)| corners) {
            if let Some(p) = pool.position(corner[0]).filter(|p| storable(*p)) {
                out.add(p);
            }
        }
    }
    Ok(out)
}

/// The linear colours of all vertices.
fn colors(loader: &mut Loader, file: &Path, pool: &Pool) -> Vec<[f32; 4]> {
    let scale = |channels: std::ops::Range<usize>| {
        let values = pool.colors.iter().flat_map(|c| &c[channels.clone()]);
        let (most, whole) = survey(values.map(|c| *c as f64));
        full_scale(most, whole) as f32
    };
    let (color, alpha) = (scale(0..3), scale(3..4));
    if color != 1.0 {
        loader.warn(file, format!("colours of vertices are written 0 to {color}; they are read so"));
    }
    let one = |c: &[f32; 4]| {
        let [r, g, b, a] = *c;
        let [r, g, b] = [r, g, b].map(|c| linear(c / color));
        [r, g, b, opacity(a / alpha)]
    };
    pool.colors.iter().map(one).collect()
}

impl Pool {
    fn position(&self, at: u32) -> Option<DVec3> {
        self.positions.get(at as usize).map(|p| DVec3::from(*p))
    }
}

/// Makes meshes of triangles: one vertex for every distinct corner, in the order of first use.
struct Builder<'a> {
    pool: &'a Pool,
    colors: &'a [[f32; 4]],
    origin: DVec3,
    polygons: Polygons,
    weld: Weld<[u32; 2]>,
}

impl<'a> Builder<'a> {
    fn new(pool: &'a Pool, colors: &'a [[f32; 4]], origin: DVec3) -> Self {
        Self { pool, colors, origin, polygons: Polygons::new(), weld: Weld::new(pool.positions.len()) }
    }

    /// The triangles of faces that have neither texture coordinates nor normals at every corner, that have texture
    /// coordinates, normals, and both: one face without them takes them from no other.
    fn cut(&mut self, faces: &Faces, stop: &Stop, notes: &mut Notes) -> Result<[Vec<[Corner; 3]>; 4], Stopped> {
        let pool = self.pool;
        let mut out: [Vec<[Corner; 3]>; 4] = Default::default();
        let mut points = Vec::new();
        for (i, (line, corners)) in faces.iter().enumerate() {
            if i % 4096 == 0 || corners.len() > 1024 {
                stop.check()?;
            }
            points.clear();
            points.extend(corners.iter().map_while(|c| pool.position(c[0])));
            if points.len() < corners.len() {
                notes.beyond.add(line.into());
                continue;
            }
            if !points.iter().all(|p| storable(*p)) {
                notes.broken.add(line.into());
                continue;
            }
            let triangles = self.polygons.triangles(points.iter().copied());
            if triangles.is_empty() {
                notes.flat.add(line.into());
                continue;
            }
            let finite = |v: &[f32]| v.iter().all(|x| x.is_finite());
            let textured = |c: &Corner| pool.uv.get(c[1] as usize).is_some_and(|uv| finite(uv));
            let lit = |c: &Corner| pool.normals.get(c[2] as usize).is_some_and(|n| finite(n));
            let named = |k: usize| corners.iter().all(|c| c[k] != ABSENT);
            let (has_uv, has_normals) = (corners.iter().all(textured), corners.iter().all(lit));
            if named(1) && !has_uv || named(2) && !has_normals {
                notes.bare.add(line.into());
            }
            let corner = |i: u32| {
                let [v, uv, n] = corners[i as usize];
                [v, if has_uv { uv } else { ABSENT }, if has_normals { n } else { ABSENT }]
            };
            let group = &mut out[usize::from(has_uv) + 2 * usize::from(has_normals)];
            group.extend(triangles.iter().map(|t| t.map(corner)));
        }
        Ok(out)
    }

    fn mesh(&mut self, faces: &[[Corner; 3]], stop: &Stop, notes: &mut Notes) -> Result<Mesh, Stopped> {
        let mut triangles = Vec::with_capacity(faces.len());
        for (i, face) in faces.iter().enumerate() {
            if i % 4096 == 0 {
                stop.check()?;
            }
            triangles.push(face.map(|[v, uv, n]| self.weld.number(v, [uv, n])));
        }
        let corners = self.weld.take();
        let pool = self.pool;
        let place =
            |c: &(u32, [u32; 2])| (DVec3::from(pool.positions[c.0 as usize]) - self.origin).as_vec3().to_array();
        let positions: Vec<_> = corners.iter().map(place).collect();
        let collapsed = |t: &&[u32; 3]| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            a == b || b == c || a == c
        };
        notes.rounded += triangles.iter().filter(collapsed).count() as u64;
        Ok(Mesh {
            positions: positions.into(),
            normals: corners.iter().filter_map(|c| pool.normals.get(c.1[1] as usize).copied()).collect(),
            uv: [corners.iter().filter_map(|c| pool.uv.get(c.1[0] as usize).copied()).collect(), Default::default()],
            colors: match self.colors.is_empty() {
                true => Default::default(),
                false => corners.iter().map(|c| self.colors[c.0 as usize]).collect(),
            },
            triangles: triangles.into(),
            ..Mesh::default()
        })
    }
}
