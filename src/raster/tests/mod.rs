//! Tests of the rasteriser as a whole, and the scenes that they share.

mod coverage;
pub mod literal;
mod look;

use super::*;
use crate::{
    math::Stop,
    scene::{Material, Mesh, Object, Part, Scene},
    view::View,
};
use glam::{DVec3, Mat4, Vec3};
use std::sync::Arc;

pub fn mesh(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Mesh {
    Mesh { positions: positions.to_vec().into(), triangles: triangles.to_vec().into(), ..Mesh::default() }
}

pub fn object(name: &str, mesh: Mesh, material: Material) -> Object {
    let part = Part { mesh: Arc::new(mesh), material: Arc::new(material) };
    Object { name: name.to_owned(), transform: Mat4::IDENTITY, parts: vec![part] }
}

pub fn scene(mesh: Mesh) -> Scene {
    Scene { objects: vec![object("a", mesh, Material::default())] }
}

/// A square of side 2 around the origin, facing +Z, with (0, 0) of its texture coordinates at the top left.
pub fn square() -> Mesh {
    let mut m =
        mesh(&[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]], &[[0, 1, 2], [0, 2, 3]]);
    m.uv[0] = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]].into();
    m
}

/// An octahedron whose faces are cut into four `levels` times; closed, with 8·4^levels triangles.
pub fn octahedron(levels: u32) -> Mesh {
    let mut points = vec![Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let mut faces: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..levels {
        let mut middle = std::collections::BTreeMap::new();
        let mut cut = |a: u32, b: u32| {
            *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (cut(a, b), cut(b, c), cut(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let positions: Vec<[f32; 3]> = points.iter().map(|p| p.to_array()).collect();
    mesh(&positions, &faces)
}

/// Looks along −Z from (0, 0, `distance`); the square fills the view's height at distance 1 / tan(fov/2).
pub fn ahead(distance: f64, width: u32, height: u32) -> View {
    let eye = DVec3::new(0.0, 0.0, distance);
    View::look_at(eye, DVec3::ZERO, DVec3::Y, std::f64::consts::FRAC_PI_2, width, height, 0.1, 100.0)
}

pub fn all(scene: &Scene, view: &View) -> Fragments {
    fragments(&Cpu, &Geometry::new(scene), view, &Options::default(), &Stop::default()).unwrap()
}

pub fn first(scene: &Scene, view: &View) -> Nearest {
    nearest(&Cpu, &Geometry::new(scene), view, &Options::default(), &Stop::default()).unwrap()
}
