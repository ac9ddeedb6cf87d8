//! Finding what shows through gaps of a simplified mesh.
//!
//! Boundaries that face each other across a slit may each keep their tolerance and still let the eye through. So the result is
//! looked at: seen from another place of the view cell, layers move against each other by up to a pixel a layer
//! (section 4.1), which makes the picture in voxel space a shear. Both the voxels and the faces are drawn under shears of up to half
//! of that, and where faces miss the inside of a surface, its voxels are reported. Where alpha cuts outlines, a face in front may be transparent:
//! then only one that lies near the surface shows it.

use super::{
    Voxel,
    shear::{draw, under_all},
    touch::Point,
};
use crate::math::{Stop, Stopped};

/// Shears per axis, pixels a layer.
const SHEARS: [f64; 7] = [-0.5, -0.35, -0.2, 0.0, 0.2, 0.35, 0.5];
/// How many layers behind its voxels a face still shows them.
const BEHIND: f32 = 2.5;

/// Numbers of the visible voxels that `faces` leave bare, ascending.
pub fn bare(voxels: &[Voxel], faces: &[[Point; 3]], alpha: bool, stop: &Stop) -> Result<Vec<u32>, Stopped> {
    let Some(bounds) = VoxelBounds::around(voxels) else { return Ok(Vec::new()) };
    let found = under_all(&SHEARS, stop, |shear| {
        let picture = Picture::new(voxels, &bounds, shear, |_| true);
        let mut shown = vec![false; picture.pixels()];
        for face in faces {
            picture.draw(picture.seen(*face, [0.0; 2]), |i, z| shown[i] |= picture.shows(i, z, alpha));
        }
        let bare = (0..shown.len()).filter(|i| !shown[*i] && picture.is_inside(*i));
        bare.flat_map(|i| picture.around(i)).map(|j| picture.nearest[j] - 1).collect::<Vec<_>>()
    })?;
    let mut all = found.concat();
    all.sort_unstable();
    all.dedup();
    Ok(all)
}

/// The part of voxel space that holds the visible voxels.
pub struct VoxelBounds {
    low: [i32; 3],
    high: [i32; 3],
}

impl VoxelBounds {
    /// `None` where no voxel is visible.
    pub fn around(voxels: &[Voxel]) -> Option<Self> {
        let mut frame: Option<Self> = None;
        for v in voxels.iter().filter(|v| v.ring == 0) {
            let at = [v.x, v.y, v.layer].map(i32::from);
            let f = frame.get_or_insert(Self { low: at, high: at });
            f.low = std::array::from_fn(|i| f.low[i].min(at[i]));
            f.high = std::array::from_fn(|i| f.high[i].max(at[i]));
        }
        frame
    }
}

/// The visible voxels as they are seen under a shear, with a margin of one pixel.
pub struct Picture {
    shear: [f64; 2],
    /// The layer that the shear leaves in place.
    base: i32,
    origin: [i32; 2],
    width: usize,
    height: usize,
    /// The number of the voxel in front, + 1; 0: none.
    nearest: Vec<u32>,
    /// First and last layer of what is in front at a pixel and at its eight neighbours; the last is infinite where one of them is
    /// empty: beside empty pixels no surface is whole.
    surface: Vec<[f32; 2]>,
}

impl Picture {
    /// Of those voxels that are `drawn`.
    pub fn new(voxels: &[Voxel], bounds: &VoxelBounds, shear: [f64; 2], drawn: impl Fn(usize) -> bool) -> Self {
        let VoxelBounds { low, high } = bounds;
        let shift = |axis: usize, layer: i32| (shear[axis] * f64::from(layer - low[2]) + 0.5).floor() as i32;
        let ends = |axis: usize| [shift(axis, low[2]), shift(axis, high[2])];
        let origin: [i32; 2] = std::array::from_fn(|i| low[i] + ends(i)[0].min(ends(i)[1]) - 1);
        let size: [i32; 2] = std::array::from_fn(|i| high[i] + ends(i)[0].max(ends(i)[1]) + 2 - origin[i]);
        let [width, height] = size.map(|s| s as usize);
        let mut nearest = vec![0u32; width * height];
        for (n, v) in voxels.iter().enumerate().rev().filter(|(n, v)| v.ring == 0 && drawn(*n)) {
            let layer = i32::from(v.layer);
            let x = (i32::from(v.x) + shift(0, layer) - origin[0]) as usize;
            let y = (i32::from(v.y) + shift(1, layer) - origin[1]) as usize;
            // Voxels are sorted by layer: the last written is the nearest.
            nearest[y * width + x] = n as u32 + 1;
        }
        let layer = |i: usize| nearest[i].checked_sub(1).map_or(f32::INFINITY, |n| f32::from(voxels[n as usize].layer));
        let mut surface = vec![[f32::INFINITY; 2]; width * height];
        for y in 1..height - 1 {
            for i in y * width + 1..(y + 1) * width - 1 {
                let around = around(i, width).map(layer);
                surface[i] = around.fold([f32::INFINITY, 0.0], |[a, b], l| [a.min(l), b.max(l)]);
            }
        }
        Self { shear, base: low[2], origin, width, height, nearest, surface }
    }

    pub fn pixels(&self) -> usize {
        self.surface.len()
    }

    /// Whether a surface is whole at a pixel and all around it.
    pub fn is_inside(&self, pixel: usize) -> bool {
        self.surface[pixel][1] < f32::INFINITY
    }

    /// Whether a face in layer `z` shows what is in front at a pixel: from in front of it, or where it may be transparent from near it, to a
    /// little behind it.
    pub fn shows(&self, pixel: usize, z: f32, alpha: bool) -> bool {
        let [low, high] = self.surface[pixel];
        z <= high + BEHIND && (!alpha || low - BEHIND <= z)
    }

    /// Layers between a face in layer `z` and what is in front at a pixel and around it.
    pub fn away(&self, pixel: usize, z: f32) -> f32 {
        let [low, high] = self.surface[pixel];
        (low - z).max(z - high).max(0.0)
    }

    /// Calls `each` with the pixels that a face covers, whose corners are `seen`, and its layer there.
    pub fn draw(&self, seen: [Point; 3], each: impl FnMut(usize, f32)) {
        draw(seen, self.width, self.height, each);
    }

    /// The corners of a face in the picture, looked at `offset` pixels beside the centres of pixels: pixels, so that these places are integers, and
    /// layers.
    pub fn seen(&self, face: [Point; 3], offset: [f64; 2]) -> [Point; 3] {
        let base = 4.0 * f64::from(self.base);
        face.map(|p| {
            let moved =
                |i: usize| (p[i] + self.shear[i] * (p[2] - base)) / 4.0 - f64::from(self.origin[i]) - 0.5 - offset[i];
            [moved(0), moved(1), p[2] / 4.0]
        })
    }

    /// A pixel's column and row.
    pub fn at(&self, pixel: usize) -> [f64; 2] {
        [(pixel % self.width) as f64, (pixel / self.width) as f64]
    }

    fn around(&self, pixel: usize) -> impl Iterator<Item = usize> {
        around(pixel, self.width)
    }
}

/// A pixel that is not at the border, and its eight neighbours.
fn around(pixel: usize, width: usize) -> impl Iterator<Item = usize> {
    [pixel - width - 1, pixel - 1, pixel + width - 1].into_iter().flat_map(|j| j..j + 3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        sample_fields as fields,
        voxel::{cover_mesh::cover_meshes, touch},
    };

    fn plane() -> (Vec<Voxel>, Vec<[Point; 3]>) {
        let mut solid = fields::Solid::new(30, 20, 2);
        solid.patch([2.0, 2.0, 0.0], [26.0, 0.0, 0.0], [0.0, 16.0, 0.0]);
        let slices = fields::slices(solid.size, solid.layers);
        let (_, mesh) = cover_meshes(&slices, &[&solid.field()], &Stop::default()).unwrap().remove(0);
        let faces = mesh.faces.iter().map(|f| f.map(|v| touch::point(mesh.vertices[v as usize])));
        (mesh.voxels.to_vec(), faces.collect())
    }

    #[test]
    fn a_whole_surface_is_not_bare() {
        let (voxels, faces) = plane();
        assert_eq!(bare(&voxels, &faces, false, &Stop::default()).unwrap(), Vec::<u32>::new());
    }

    #[test]
    fn what_lies_under_a_hole_is_bare_and_an_edge_drawn_back_is_not() {
        let (voxels, faces) = plane();
        let left_of = |limit: f64, t: &[Point; 3]| t.iter().all(|p| p[0] <= limit);
        let hole = |t: &[Point; 3]| t.iter().all(|p| (40.0..=52.0).contains(&p[0]) && (36.0..=44.0).contains(&p[1]));
        let with_hole: Vec<_> = faces.iter().filter(|t| !hole(t)).copied().collect();
        let found = bare(&voxels, &with_hole, false, &Stop::default()).unwrap();
        assert!(!found.is_empty());
        let near = |v: &Voxel| (9..=14).contains(&v.x) && (8..=12).contains(&v.y);
        assert!(found.iter().all(|v| near(&voxels[*v as usize])));
        let last = voxels.iter().map(|v| v.x).max().unwrap();
        let drawn_back: Vec<_> = faces.iter().filter(|t| left_of(4.0 * f64::from(last), t)).copied().collect();
        assert!(drawn_back.len() < faces.len());
        assert_eq!(bare(&voxels, &drawn_back, false, &Stop::default()).unwrap(), Vec::<u32>::new());
    }
}
