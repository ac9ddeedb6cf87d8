//! What stays geometry: triangles with a part nearer than the nearest border of a cell's layers.
//!
//! A triangle that straddles the border is kept whole and is in the voxels beyond it too, so there is no crack where
//! geometry and voxels meet.

use super::Slices;
use crate::scene::{Mesh, Object, Part, Scene};
use bytemuck::Pod;
use glam::DVec3;
use std::sync::Arc;

/// The part of a scene nearer than the layers: with some point outside every frustum's depth range on its near side.
/// `triangles` are all triangles relative to the cell's centre with their numbers in the scene (instances counted).
pub fn near_part(scene: &Scene, slices: &Slices, triangles: &[[DVec3; 3]], numbers: &[u32]) -> Scene {
    let near: Vec<u32> = triangles.iter().zip(numbers).filter(|(t, _)| is_near(slices, t)).map(|(_, n)| *n).collect();
    let mut first = 0u32;
    let mut objects = Vec::new();
    let mut rest = &near[..];
    for object in &scene.objects {
        let mut parts = Vec::new();
        for part in &object.parts {
            let end = first + part.mesh.triangles.len() as u32;
            let count = rest.partition_point(|n| *n < end);
            let (here, after) = rest.split_at(count);
            if !here.is_empty() {
                let kept: Vec<_> = here.iter().map(|n| part.mesh.triangles[(n - first) as usize]).collect();
                parts.push(Part { mesh: Arc::new(submesh(&part.mesh, &kept)), material: part.material.clone() });
            }
            (first, rest) = (end, after);
        }
        if !parts.is_empty() {
            objects.push(Object { name: object.name.clone(), transform: object.transform, parts });
        }
    }
    Scene { objects }
}

/// Whether the triangle has a point in no frustum's layers. With one frustum that is one in front of the nearest border;
/// with faces of a cube, one within the cube of that half side, which is convex: a box test.
fn is_near(slices: &Slices, t: &[DVec3; 3]) -> bool {
    let border = slices.borders[0];
    match &slices.frusta[..] {
        [f] => t.iter().any(|p| p.dot(f.forward) < border),
        _ => super::overlap::triangle_meets_box(t, DVec3::splat(border)),
    }
}

/// The triangles with only the vertices that they use, in their old order.
fn submesh(mesh: &Mesh, triangles: &[[u32; 3]]) -> Mesh {
    let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let number = |v: u32| used.partition_point(|u| *u < v) as u32;
    fn pick<T: Pod>(values: &[T], used: &[u32]) -> crate::array::Array<T> {
        if values.is_empty() { Default::default() } else { used.iter().map(|v| values[*v as usize]).collect() }
    }
    Mesh {
        positions: pick(&mesh.positions, &used),
        normals: pick(&mesh.normals, &used),
        tangents: pick(&mesh.tangents, &used),
        uv: [pick(&mesh.uv[0], &used), pick(&mesh.uv[1], &used)],
        colors: pick(&mesh.colors, &used),
        triangles: triangles.iter().map(|t| t.map(number)).collect(),
    }
}
