//! DMeshes for tests: full-resolution grid meshes of what the rasteriser sees.

use super::super::*;
use crate::{
    math::Stop,
    raster::{Cpu, Geometry, NOTHING, Nearest, Options, Shader, nearest},
    scene::{Image, Scene},
    view::View,
};
use glam::{DVec3, Vec3};
use std::sync::Arc;

pub const SIDES: [(&str, DVec3); 6] = [
    ("+x", DVec3::X),
    ("-x", DVec3::NEG_X),
    ("+y", DVec3::Y),
    ("-y", DVec3::NEG_Y),
    ("+z", DVec3::Z),
    ("-z", DVec3::NEG_Z),
];

/// A square view towards the scene's centre from the direction `d`, in which its bounding sphere fits.
pub fn towards(scene: &Scene, d: DVec3, side: u32) -> View {
    let bounds = scene.bounds();
    let (centre, radius) = (bounds.centre(), bounds.diagonal() * 0.5);
    let eye = centre + d.normalize() * radius * 2.7;
    View::look_at(eye, centre, DVec3::Y, 0.8, side, side, radius, radius * 4.0)
}

/// The scene captured from six sides, with normal maps.
pub fn captured(scene: &Scene, side: u32) -> Dmesh {
    let diagonal = scene.bounds().diagonal();
    let references = SIDES.map(|(name, d)| reference(scene, name, &towards(scene, d, side)));
    Dmesh { references: references.to_vec(), epsilon: diagonal / 1000.0, diagonal, double_sided: false }
}

/// What a view sees as a mesh with a vertex at every pixel centre, cut where its depth jumps by more than six texels.
pub fn reference(scene: &Scene, name: &str, view: &View) -> Reference {
    let geometry = Geometry::new(scene);
    let shader = Shader::new(&geometry);
    let seen = nearest(&Cpu, &geometry, view, &Options::default(), &Stop::default()).unwrap();
    let (w, h) = (view.width, view.height);
    let mut mesh = Vertices::default();
    let (mut color, mut normals) = (vec![[0; 4]; seen.depth.len()], vec![[128, 128, 128, 0]; seen.depth.len()]);
    let mut number = vec![u32::MAX; seen.depth.len()];
    for (i, triangle) in seen.triangle.iter().enumerate().filter(|(_, t)| **t != NOTHING) {
        let (px, py) = ((i as u32 % w) as f64 + 0.5, (i as u32 / w) as f64 + 0.5);
        let surface = shader.shade(view, px, py, *triangle);
        let position = view.unproject(px, py, seen.depth[i] as f64);
        let towards = (position - view.eye).normalize().as_vec3();
        number[i] = mesh.positions.len() as u32;
        mesh.positions.push(position.as_vec3().to_array());
        mesh.normals.push(surface.normal.to_array());
        mesh.quality.push(surface.normal.dot(towards).abs().min(1.0));
        mesh.uv.push([px as f32 / w as f32, py as f32 / h as f32]);
        let [r, g, b, _] = surface.color.map(crate::image::srgb::from_linear);
        color[i] = [r, g, b, 255];
        let [x, y, z] = (surface.normal * 0.5 + 0.5).to_array().map(|c| (c * 255.0 + 0.5) as u8);
        normals[i] = [x, y, z, 255];
    }
    let triangles = faces(&seen, &number, 6.0 * texel(view));
    let image = |mut texels: Vec<[u8; 4]>| {
        dilate(&mut texels, w as usize, 6);
        Arc::new(Image { name: name.into(), width: w, height: h, texels: texels.into() })
    };
    let mesh = Mesh {
        positions: mesh.positions.into(),
        normals: mesh.normals.into(),
        quality: mesh.quality.into(),
        uv: mesh.uv.into(),
        triangles: triangles.into(),
    };
    Reference {
        name: name.into(),
        view: *view,
        mesh: Arc::new(mesh),
        color: image(color),
        normal_map: Some(image(normals)),
    }
}

#[derive(Default)]
struct Vertices {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    quality: Vec<f32>,
    uv: Vec<[f32; 2]>,
}

/// Size of a texel at depth 1.
fn texel(view: &View) -> f32 {
    match view.projection {
        crate::view::Projection::Perspective { left, right, .. } => (right - left) as f32 / view.width as f32,
        crate::view::Projection::Orthographic { .. } => unreachable!("tests capture in perspective"),
    }
}

/// Two triangles in every square of pixels, without those whose depth jumps by more than `limit` times their depth.
fn faces(seen: &Nearest, number: &[u32], limit: f32) -> Vec<[u32; 3]> {
    let (w, h) = (seen.width as usize, seen.height as usize);
    let mut faces = Vec::new();
    for y in 0..h - 1 {
        for x in 0..w - 1 {
            let i = y * w + x;
            let [a, b, c, d] = [i, i + w, i + w + 1, i + 1];
            for corners in [[a, b, c], [a, c, d]] {
                let z = corners.map(|i| seen.depth[i]);
                let (low, high) = (z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2]));
                if high < f32::INFINITY && high - low <= limit * low {
                    faces.push(corners.map(|i| number[i]));
                }
            }
        }
    }
    faces
}

/// Gives texels of alpha 0 the mean of their neighbours, `rings` times, then alpha 255 to all.
pub fn dilate(texels: &mut [[u8; 4]], width: usize, rings: usize) {
    for _ in 0..rings {
        let before = texels.to_vec();
        for i in (0..texels.len()).filter(|i| before[*i][3] == 0) {
            let (x, y) = ((i % width) as isize, (i / width) as isize);
            let height = (texels.len() / width) as isize;
            let near = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
            let inside = near.filter(|(x, y)| (0..width as isize).contains(x) && (0..height).contains(y));
            let known: Vec<_> =
                inside.map(|(x, y)| before[y as usize * width + x as usize]).filter(|t| t[3] > 0).collect();
            if !known.is_empty() {
                let mean = |k: usize| (known.iter().map(|t| t[k] as usize).sum::<usize>() / known.len()) as u8;
                texels[i] = [mean(0), mean(1), mean(2), 255];
            }
        }
    }
    texels.iter_mut().for_each(|t| t[3] = 255);
}

/// A square of side 2 in the plane through `centre`, facing +Z, of one colour and quality, captured from `eye`.
pub fn square(name: &str, eye: DVec3, centre: DVec3, color: [u8; 3], quality: f32) -> Reference {
    let at = |x: f32, y: f32| (Vec3::new(x, y, 0.0) + centre.as_vec3()).to_array();
    let mesh = Mesh {
        positions: vec![at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)].into(),
        normals: vec![[0.0, 0.0, 1.0]; 4].into(),
        quality: vec![quality; 4].into(),
        uv: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]].into(),
        triangles: vec![[0, 1, 2], [0, 2, 3]].into(),
    };
    let [r, g, b] = color;
    let texels = vec![[r, g, b, 255]; 4].into();
    Reference {
        name: name.into(),
        view: View::look_at(eye, centre, DVec3::Y, 0.8, 100, 100, 0.1, 100.0),
        mesh: Arc::new(mesh),
        color: Arc::new(Image { name: name.into(), width: 2, height: 2, texels }),
        normal_map: None,
    }
}
