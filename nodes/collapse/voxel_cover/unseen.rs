//! Dropping faces that no place of the cell sees.
//!
//! What contractions push behind other faces is seen from nowhere, but it holds on to its neighbours. The mesh is drawn under
//! shears; a face that is never in front goes, unless a visible voxel is covered by no other.

use super::surface::Surface;
use crate::{
    math::{Stop, Stopped},
    voxel::{
        Voxel,
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

impl Surface {
    /// Drops the faces that are seen from nowhere in the cell and that no voxel needs; `voxels` are the mesh's.
    pub fn drop_unseen(&mut self, voxels: &[Voxel], stop: &Stop) -> Result<(), Stopped> {
        let faces: Vec<u32> = self.faces().collect();
        let triangles: Vec<_> = faces.iter().map(|f| self.triangle(*f)).collect();
        let seen = seen(&triangles, stop)?;
        let mut kept = Vec::with_capacity(faces.len());
        for (f, seen) in faces.into_iter().zip(seen) {
            let corners = self.topology.corners(f);
            // On a seam the other frustum has the same edge.
            let on_seam = || corners.iter().any(|v| self.locked[*v as usize]);
            let needed = |v: &u32| self.cover.is_named_once(*v) && voxels[*v as usize].ring == 0;
            if seen || on_seam() || self.cover.list(f).iter().any(needed) {
                kept.push(f);
            } else {
                self.cover.clear(f);
                corners.iter().for_each(|v| self.note(*v));
            }
        }
        self.select(&kept, stop)
    }
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
