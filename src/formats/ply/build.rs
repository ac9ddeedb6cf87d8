//! The mesh of a PLY file: faces cut into triangles, vertices split where faces of different colours meet.

use super::{Colors, Faces, Vertices};
use crate::{
    formats::{
        FormatError,
        colors::{linear, opacity, survey},
        loader::Loader,
        mesh::{self, BEYOND, BROKEN, FLAT, Left},
        polygon::Polygons,
        weld::Weld,
    },
    math::{
        Aabb, Stop, Stopped,
        shift::{shift, storable},
    },
    scene::Mesh,
};
use glam::DVec3;
use std::path::Path;

/// Triangles over the file's vertices, with the face that each comes from.
#[derive(Default)]
struct Cut {
    triangles: Vec<[u32; 3]>,
    /// As long as the triangles.
    faces: Vec<u32>,
    beyond: Left,
    broken: Left,
    flat: Left,
}

/// The mesh and the origin that its positions are relative to; `None`, and a warning, where it has no triangle.
pub(super) fn mesh(
    loader: &mut Loader,
    file: &Path,
    name: &str,
    vertices: &Vertices,
    faces: &Faces,
) -> Result<Option<(Mesh, DVec3)>, FormatError> {
    let cut = Cut::of(vertices, faces, loader.stop)?;
    cut.tell(loader, file);
    if cut.triangles.is_empty() {
        loader.warn(file, "has no faces");
        return Ok(None);
    }
    let position = |v: u32| DVec3::from(vertices.positions[v as usize]);
    let bounds: Aabb = cut.triangles.iter().flatten().map(|v| position(*v)).collect();
    let origin = shift(&bounds);
    let of_faces = faces.colors.as_ref().filter(|_| vertices.colors.is_none());
    let face_colors = of_faces.map(|c| linear_colors(loader, file, "faces", c)).unwrap_or_default();
    let vertex_colors = vertices.colors.as_ref().map(|c| linear_colors(loader, file, "vertices", c));

    let all = 0..vertices.positions.len() as u32;
    let (sources, triangles, colors) = match face_colors.is_empty() {
        true => (all.collect(), cut.triangles, vertex_colors.unwrap_or_default()),
        false => split(vertices.positions.len(), &cut, &face_colors),
    };
    let place = |v: &u32| (position(*v) - origin).as_vec3().to_array();
    fn pick<T: Copy + bytemuck::Pod>(all: &[T], sources: &[u32]) -> crate::array::Array<T> {
        if all.is_empty() { Default::default() } else { sources.iter().map(|v| all[*v as usize]).collect() }
    }
    let mut uv = pick(&vertices.uv, &sources);
    let no_number = uv.iter().filter(|uv| !uv.iter().all(|v| v.is_finite())).count();
    if no_number > 0 {
        loader.warn(file, format!("{no_number} texture coordinates are no finite numbers; they are read as 0"));
        uv = uv.iter().map(|uv| uv.map(|v| if v.is_finite() { v } else { 0.0 })).collect();
    }
    let mut out = Mesh {
        positions: sources.iter().map(place).collect(),
        normals: pick(&vertices.normals, &sources),
        uv: [uv, Default::default()],
        colors: colors.into(),
        triangles: triangles.into(),
        ..Mesh::default()
    };
    if !out.positions.iter().flatten().all(|x| x.is_finite()) {
        // No face uses the vertices that are no finite numbers any more.
        out = mesh::compact(&out);
    }
    let collapsed = |t: &&[u32; 3]| {
        let [a, b, c] = t.map(|v| out.positions[v as usize]);
        a == b || b == c || a == c
    };
    let rounded = out.triangles.iter().filter(collapsed).count();
    if rounded > 0 {
        let what = "triangles collapse where coordinates are rounded to 32 bits; parts of the file lie too far apart";
        loader.warn(file, format!("{rounded} {what}"));
    }
    let wrong = |(at, what): (String, String)| FormatError::invalid(file, format!("mesh `{name}`, {at}"), what);
    Ok(Some((mesh::finish(out).map_err(wrong)?, origin)))
}

impl Cut {
    fn of(vertices: &Vertices, faces: &Faces, stop: &Stop) -> Result<Self, Stopped> {
        let mut out = Self::default();
        let mut polygons = Polygons::new();
        let mut points = Vec::new();
        let strips = faces.strips.iter().map(|t| &t[..]);
        for (i, corners) in faces.iter().chain(strips).enumerate() {
            if i % 4096 == 0 || corners.len() > 1024 {
                stop.check()?;
            }
            if corners.is_empty() {
                continue;
            }
            points.clear();
            let position = |v: &u32| vertices.positions.get(*v as usize).map(|p| DVec3::from(*p));
            points.extend(corners.iter().map_while(position));
            if points.len() < corners.len() {
                out.beyond.add(i as u64);
            } else if !points.iter().all(|p| storable(*p)) {
                out.broken.add(i as u64);
            } else {
                let triangles = polygons.triangles(points.iter().copied());
                if triangles.is_empty() {
                    out.flat.add(i as u64);
                }
                out.triangles.extend(triangles.iter().map(|t| t.map(|k| corners[k as usize])));
                out.faces.resize(out.triangles.len(), i as u32);
            }
        }
        Ok(out)
    }

    fn tell(&self, loader: &mut Loader, file: &Path) {
        for (left, reason) in [(&self.beyond, BEYOND), (&self.broken, BROKEN), (&self.flat, FLAT)] {
            if left.count > 0 {
                let Left { count, first } = left;
                loader.warn(file, format!("faces left out: {count} {reason}, the first is face {first}"));
            }
        }
    }
}

fn linear_colors(loader: &mut Loader, file: &Path, what: &str, colors: &Colors) -> Vec<[f32; 4]> {
    let channels =
        |range: std::ops::Range<usize>| survey(colors.rows.iter().flat_map(|c| &c[range.clone()]).map(|c| *c as f64));
    let (rgb, a) = (channels(0..3), channels(3..4));
    let scale = colors.kinds[0].full_scale(rgb);
    let usual = colors.kinds[0].full_scale((f64::INFINITY, true));
    if scale != usual {
        loader.warn(file, format!("colours of {what} are written 0 to {scale}; they are read so"));
    }
    let (color, alpha) = (scale as f32, colors.kinds[1].full_scale(a) as f32);
    let one = |c: &[f32; 4]| {
        let [r, g, b, a] = *c;
        let [r, g, b] = [r, g, b].map(|c| linear(c / color));
        [r, g, b, opacity(a / alpha)]
    };
    colors.rows.iter().map(one).collect()
}

/// A vertex for every vertex and colour of a face that meet: the vertices they come from, triangles, colours.
fn split(vertices: usize, cut: &Cut, face_colors: &[[f32; 4]]) -> (Vec<u32>, Vec<[u32; 3]>, Vec<[f32; 4]>) {
    let mut weld = Weld::new(vertices);
    let triangles = cut.triangles.iter().zip(&cut.faces).map(|(t, face)| {
        // Strips have no colour.
        let color = face_colors.get(*face as usize).copied().unwrap_or([1.0; 4]);
        t.map(|v| weld.number(v, color.map(f32::to_bits)))
    });
    let triangles = triangles.collect();
    let (sources, colors) = weld.take().into_iter().map(|(v, color)| (v, color.map(f32::from_bits))).unzip();
    (sources, triangles, colors)
}
