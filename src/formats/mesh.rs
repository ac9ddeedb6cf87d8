//! The promises that every reader's meshes keep: indices inside, numbers finite, directions of unit length.

use crate::scene::Mesh;
use glam::{Vec3, Vec4};

/// Faces that are not as they should be: how many, and where the first stands, by its line or its number.
#[derive(Default)]
pub(super) struct Left {
    pub count: u64,
    pub first: u64,
}

impl Left {
    pub fn add(&mut self, at: u64) {
        if self.count == 0 {
            self.first = at;
        }
        self.count += 1;
    }
}

/// Why faces are left out.
pub(super) const BEYOND: &str = "with a vertex number that does not exist";
pub(super) const BROKEN: &str = "with a corner that is no finite number";
pub(super) const FLAT: &str = "without area";

/// Checks and tidies what a file gave: `Err((place, what))` where an index leaves the mesh or a number is not finite.
/// Directions that cannot be normalised are taken from the faces around.
pub(super) fn finish(mut mesh: Mesh) -> Result<Mesh, (String, String)> {
    let count = mesh.positions.len();
    check(&mesh.positions, "position")?;
    for (i, uv) in mesh.uv.iter().enumerate() {
        check(uv, ["texture coordinate", "second texture coordinate"][i])?;
    }
    check(&mesh.colors, "colour")?;
    if let Some((i, t)) = mesh.triangles.iter().enumerate().find(|(_, t)| t.iter().any(|v| *v as usize >= count)) {
        return Err((format!("triangle {i}"), format!("vertex numbers {t:?}; there are {count} vertices")));
    }
    if mesh.colors.iter().flatten().any(|c| !(0.0..=1.0).contains(c)) {
        mesh.colors = mesh.colors.iter().map(|c| c.map(|c| c.clamp(0.0, 1.0))).collect();
    }
    if mesh.normals.iter().any(|n| !unit(Vec3::from(*n).length_squared())) {
        mesh.normals = normals(&mesh).into();
    }
    if mesh.tangents.iter().any(|t| !unit(Vec4::from(*t).truncate().length_squared()) || t[3].abs() != 1.0) {
        mesh.tangents = tangents(&mesh.tangents).unwrap_or_default().into();
    }
    Ok(mesh)
}

fn check<const N: usize>(values: &[[f32; N]], what: &str) -> Result<(), (String, String)> {
    match values.iter().enumerate().find(|(_, v)| !v.iter().all(|x| x.is_finite())) {
        Some((i, v)) => Err((format!("vertex {i}"), format!("its {what} is {v:?}; it must be finite"))),
        None => Ok(()),
    }
}

/// Whether a squared length is one up to what storing a direction in bytes costs.
fn unit(square: f32) -> bool {
    (square - 1.0).abs() < 1e-5
}

fn normals(mesh: &Mesh) -> Vec<[f32; 3]> {
    let good = |n: &[f32; 3]| Vec3::from(*n).try_normalize();
    let mut out: Vec<_> = mesh.normals.iter().map(good).collect();
    if out.iter().any(Option::is_none) {
        let mut faces = vec![Vec3::ZERO; out.len()];
        for t in mesh.triangles.iter() {
            let [a, b, c] = t.map(|v| Vec3::from(mesh.positions[v as usize]));
            let area = (b - a).cross(c - a);
            t.iter().for_each(|v| faces[*v as usize] += area);
        }
        for (n, face) in out.iter_mut().zip(faces) {
            *n = n.or(face.try_normalize());
        }
    }
    // What no face with an area uses points up.
    out.into_iter().map(|n| n.unwrap_or(Vec3::Y).to_array()).collect()
}

fn tangents(all: &[[f32; 4]]) -> Option<Vec<[f32; 4]>> {
    let tidy = |t: &[f32; 4]| {
        let xyz = Vec4::from(*t).truncate().try_normalize()?;
        Some(xyz.extend(if t[3] < 0.0 { -1.0 } else { 1.0 }).to_array())
    };
    all.iter().map(tidy).collect()
}

/// `mesh` without the vertices that none of its faces uses.
pub(super) fn compact(mesh: &Mesh) -> Mesh {
    let mut number = vec![u32::MAX; mesh.positions.len()];
    let mut used = Vec::new();
    let triangles = mesh.triangles.iter().map(|t| {
        t.map(|v| {
            let n = &mut number[v as usize];
            if *n == u32::MAX {
                *n = used.len() as u32;
                used.push(v as usize);
            }
            *n
        })
    });
    let triangles = triangles.collect();
    fn pick<T: bytemuck::Pod>(all: &[T], used: &[usize]) -> crate::array::Array<T> {
        if all.is_empty() { Default::default() } else { used.iter().map(|v| all[*v]).collect() }
    }
    Mesh {
        positions: pick(&mesh.positions, &used),
        normals: pick(&mesh.normals, &used),
        tangents: pick(&mesh.tangents, &used),
        uv: [pick(&mesh.uv[0], &used), pick(&mesh.uv[1], &used)],
        colors: pick(&mesh.colors, &used),
        triangles,
    }
}
