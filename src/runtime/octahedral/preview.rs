//! A GLB that any viewer opens: the frames nearest to the six axes on crossed cards. An approximation: it does not blend, and each
//! card is right only from its own side.

use super::OctahedralError;
use crate::{
    array::Array,
    formats::{GlbOptions, write_glb},
    octahedral::{Impostor, axes},
    scene::{Alpha, Image, Material, Mesh, Object, Part, Scene, Texture, Wrap},
};
use glam::{DVec3, Mat4};
use std::sync::Arc;

/// Texels along the side of a frame in the preview, at most.
const SIDE: u32 = 256;

/// The bytes of the GLB.
pub fn preview(impostor: &Impostor) -> Result<Vec<u8>, OctahedralError> {
    let grid = impostor.grid;
    let mut frames: Vec<(u32, u32)> = Vec::new();
    for axis in DVec3::AXES.into_iter().flat_map(|a| [a, -a]) {
        if grid.hemi && axis.y < 0.0 {
            continue;
        }
        let points = (0..grid.side * grid.side).map(|i| (i % grid.side, i / grid.side));
        let cosine = |p: &(u32, u32)| grid.direction(p.0, p.1).dot(axis);
        // Of equals the first, whatever the order of comparison.
        let best = points.reduce(|a, b| if cosine(&b) > cosine(&a) { b } else { a });
        frames.extend(best.filter(|b| !frames.contains(b)));
    }
    let level = crate::octahedral::levels(impostor).into_iter().find(|l| l.side / grid.side <= SIDE);
    let atlas = level.unwrap_or_else(|| impostor.atlas.clone());
    let tile = (atlas.side / grid.side) as usize;
    // The frames one below another.
    let mut texels = Vec::with_capacity(frames.len() * tile * tile);
    for (column, row) in &frames {
        for y in 0..tile {
            let first = (*row as usize * tile + y) * atlas.side as usize + *column as usize * tile;
            texels.extend_from_slice(&atlas.color[first..first + tile]);
        }
    }
    let count = frames.len() as f32;
    let height = (frames.len() * tile) as u32;
    let image = Image { name: "color".into(), width: tile as u32, height, texels: texels.into() };
    let (mut positions, mut normals, mut uv, mut triangles) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (i, (column, row)) in frames.iter().enumerate() {
        let direction = grid.direction(*column, *row);
        let [right, up] = axes(direction).map(|a| a * impostor.radius);
        let first = positions.len() as u32;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            positions.push((right * x + up * y).as_vec3().to_array());
            normals.push(direction.as_vec3().to_array());
            uv.push([0.5 + 0.5 * x as f32, (i as f32 + 0.5 - 0.5 * y as f32) / count]);
        }
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    let texture = Texture {
        image: Arc::new(image),
        uv_set: 0,
        offset: [0.0; 2],
        rotation: 0.0,
        scale: [1.0; 2],
        wrap: [Wrap::Clamp; 2],
        smooth: true,
    };
    let material = Material {
        name: "impostor".into(),
        base_color_texture: Some(texture),
        alpha: Alpha::Mask { cutoff: 0.5 },
        double_sided: false,
        unlit: true,
        ..Material::default()
    };
    let mesh = Mesh {
        positions: positions.into(),
        normals: normals.into(),
        uv: [uv.into(), Array::default()],
        triangles: triangles.into(),
        ..Mesh::default()
    };
    let part = Part { mesh: Arc::new(mesh), material: Arc::new(material) };
    let transform = Mat4::from_translation(impostor.centre.as_vec3());
    let scene = Scene { objects: vec![Object { name: "impostor".into(), transform, parts: vec![part] }] };
    Ok(write_glb(&scene, &GlbOptions::default())?)
}
