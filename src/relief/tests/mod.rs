//! Relief maps against what they stand for.

mod choice;
mod maps;
mod rays;

use super::{DepthBits, ReliefMap, Resampling, resample};
use crate::{
    capture::{Capturing, capture},
    math::Stop,
    raster::{Cpu, Geometry, Shader},
    scene::{Material, Mesh, Object, Part, Scene},
    view::directions::look_along,
};
use glam::{DVec3, Mat4};
use std::sync::Arc;

/// A scene of one mesh.
pub fn scene(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Scene {
    let mesh = Mesh { positions: positions.into(), triangles: triangles.into(), ..Mesh::default() };
    let part =
        Part { mesh: Arc::new(mesh), material: Arc::new(Material { double_sided: false, ..Material::default() }) };
    Scene { objects: vec![Object { name: "object".into(), transform: Mat4::IDENTITY, parts: vec![part] }] }
}

/// A sphere of radius 1 with 20·4^levels triangles.
pub fn sphere(levels: u32) -> Scene {
    // Four corners of a tetrahedron, split and moved outwards.
    let mut faces: Vec<[DVec3; 3]> = octahedron();
    for _ in 0..levels {
        faces = faces
            .iter()
            .flat_map(|[a, b, c]| {
                let [ab, bc, ca] = [(*a + *b).normalize(), (*b + *c).normalize(), (*c + *a).normalize()];
                [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]]
            })
            .collect();
    }
    let positions = faces.iter().flatten().map(|p| p.as_vec3().to_array()).collect();
    scene(positions, (0..faces.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

fn octahedron() -> Vec<[DVec3; 3]> {
    let mut out = Vec::new();
    for x in [DVec3::X, DVec3::NEG_X] {
        for y in [DVec3::Y, DVec3::NEG_Y] {
            for z in [DVec3::Z, DVec3::NEG_Z] {
                let outwards = (y - x).cross(z - x).dot(x + y + z) > 0.0;
                out.push(if outwards { [x, y, z] } else { [x, z, y] });
            }
        }
    }
    out
}

/// The cube from −1 to 1.
pub fn cube() -> Scene {
    let corner = |i: u32| std::array::from_fn(|k| if i >> k & 1 == 1 { 1.0 } else { -1.0 });
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    scene((0..8).map(corner).collect(), triangles)
}

/// A map of `side` texels with `samples` pixels along a texel's side, seen from `direction`.
pub fn map(scene: &Scene, direction: DVec3, side: u32, samples: u32, bits: DepthBits) -> ReliefMap {
    let geometry = Geometry::new(scene);
    let shader = Shader::new(&geometry);
    let view = look_along(scene.points().into_iter(), direction, side * samples, f64::from(samples)).unwrap();
    let how = Capturing { layers: 1, backs: false };
    let capture = capture(&Cpu, &shader, scene.bounds(), &view, how, &Stop::default()).unwrap();
    resample(&capture, Resampling { samples, bits }).unwrap()
}
