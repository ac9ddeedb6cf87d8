//! Dropping faces that no place of the cell sees.
//!
//! What contractions push behind other faces is seen from nowhere, but it holds on to its neighbours. The mesh is drawn under
//! shears; a face that is never in front goes, unless a visible voxel is covered by no other.

use crate::{
    array::Array,
    math::{Stop, Stopped},
    voxel::{
        VoxelMesh,
        assemble::split_bow_ties,
        shear::{draw, under_all},
        touch::Point,
    },
};

/// Shears per axis, pixels a layer. A whole pixel is reached at the image's edge only, from a corner of the cell.
const SHEARS: [f64; 9] = [-0.75, -0.5625, -0.375, -0.1875, 0.0, 0.1875, 0.375, 0.5625, 0.75];
/// Samples per pixel and axis.
const SCALE: f64 = 2.0;
/// How many layers behind the nearest face another still counts as seen: faces that lie in each other.
const BEHIND: f32 = 0.05;

/// `mesh` without the faces that are seen from nowhere in the cell and that no voxel needs.
pub fn without_unseen(mesh: &VoxelMesh, stop: &Stop) -> Result<VoxelMesh, Stopped> {
    let faces: Vec<_> = (0..mesh.faces.len()).map(|f| mesh.triangle(f)).collect();
    let seen = seen(&faces, stop)?;
    let mut count = vec![0u32; mesh.voxels.len()];
    mesh.cover.iter().for_each(|v| count[*v as usize] += 1);
    let mut keep = vec![true; faces.len()];
    for f in (0..faces.len()).filter(|f| !seen[*f]) {
        // On a seam the other frustum has the same edge.
        let on_seam = mesh.faces[f].iter().any(|v| mesh.flags[*v as usize] & 1 == 1);
        let needed = |v: &u32| count[*v as usize] == 1 && mesh.voxels[*v as usize].ring == 0;
        if !on_seam && !mesh.covered_by(f).iter().any(needed) {
            keep[f] = false;
            mesh.covered_by(f).iter().for_each(|v| count[*v as usize] -= 1);
        }
    }
    select(mesh, |f| keep[f], stop)
}

/// The faces that `keep` admits, as a mesh over the same voxels.
fn select(mesh: &VoxelMesh, keep: impl Fn(usize) -> bool, stop: &Stop) -> Result<VoxelMesh, Stopped> {
    let (mut number, mut vertices, mut flags) = (vec![u32::MAX; mesh.vertices.len()], Vec::new(), Vec::new());
    let (mut faces, mut start, mut cover) = (Vec::new(), vec![0], Vec::new());
    for f in (0..mesh.faces.len()).filter(|f| keep(*f)) {
        faces.push(mesh.faces[f].map(|v| {
            let slot = &mut number[v as usize];
            if *slot == u32::MAX {
                *slot = vertices.len() as u32;
                vertices.push(mesh.vertices[v as usize]);
                flags.push(mesh.flags[v as usize]);
            }
            *slot
        }));
        cover.extend_from_slice(mesh.covered_by(f));
        start.push(cover.len() as u32);
    }
    // Where faces are missing, two fans may be left around a vertex.
    for v in split_bow_ties(&mut faces, vertices.len(), stop)? {
        vertices.push(vertices[v as usize]);
        flags.push(flags[v as usize]);
    }
    Ok(VoxelMesh {
        frustum: mesh.frustum,
        vertices: vertices.into(),
        flags: flags.into(),
        faces: faces.into(),
        cover_start: start.into(),
        cover: cover.into(),
        voxels: Array::clone(&mesh.voxels),
        quarters: Array::clone(&mesh.quarters),
        factor: mesh.factor,
        alpha: mesh.alpha,
    })
}

/// Per face whether it is in front anywhere under any shear.
fn seen(faces: &[[Point; 3]], stop: &Stop) -> Result<Vec<bool>, Stopped> {
    let found = under_all(&SHEARS, stop, |shear| seen_under(shear, faces))?;
    Ok((0..faces.len()).map(|f| found.iter().any(|s| s[f])).collect())
}

fn seen_under(shear: [f64; 2], faces: &[[Point; 3]]) -> Vec<bool> {
    let sheared = |p: Point| -> Point {
        let moved = |i: usize| (p[i] + shear[i] * p[2]) * (SCALE / 4.0);
        [moved(0), moved(1), p[2] / 4.0]
    };
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for p in faces.iter().flatten().map(|p| sheared(*p)) {
        low = std::array::from_fn(|i| low[i].min(p[i].floor()));
        high = std::array::from_fn(|i| high[i].max(p[i]));
    }
    let [width, height] = [0, 1].map(|i| (high[i] - low[i]).max(0.0) as usize + 2);
    let corners = |face: &[Point; 3]| face.map(sheared).map(|p| [p[0] - low[0], p[1] - low[1], p[2]]);
    let mut depth = vec![f32::INFINITY; width * height];
    for face in faces {
        draw(corners(face), width, height, |i, z| depth[i] = depth[i].min(z));
    }
    let in_front = |face: &[Point; 3]| {
        let mut any = false;
        draw(corners(face), width, height, |i, z| any |= z <= depth[i] + BEHIND);
        any
    };
    faces.iter().map(in_front).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_behind_is_unseen_and_what_a_shear_shows_is_seen() {
        let square = |x: f64, size: f64, z: f64| {
            let at = |i: f64, j: f64| [x + i * size, j * size, z];
            [[at(0.0, 0.0), at(0.0, 1.0), at(1.0, 1.0)], [at(0.0, 0.0), at(1.0, 1.0), at(1.0, 0.0)]]
        };
        // A front, a small square far inside its shadow, and one that looks out under a shear of half a pixel a layer.
        let faces = [square(0.0, 200.0, 0.0), square(90.0, 20.0, 16.0), square(180.0, 20.0, 64.0)].concat();
        let mut apart = faces.clone();
        apart[2..4].iter_mut().flatten().for_each(|p| p[1] += 90.0);
        assert_eq!(seen(&apart, &Stop::default()).unwrap(), [true, true, false, false, true, true]);
    }

    #[test]
    fn no_faces_no_answer() {
        assert_eq!(seen(&[], &Stop::default()).unwrap(), Vec::<bool>::new());
    }
}
