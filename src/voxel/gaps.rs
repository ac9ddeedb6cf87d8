//! Finding what shows through gaps of a simplified mesh.
//!
//! Boundaries that face each other across a slit may each keep their tolerance and still let the eye through. So the result is
//! looked at: seen from another place of the view cell, layers move against each other by up to a pixel a layer
//! (section 4.1), which makes the picture in voxel space a shear. Both the voxels and the faces are drawn under shears, and where faces miss the
//! inside of a surface, the line of sight is reported. Where alpha cuts outlines, a face in front may be transparent:
//! then only one that lies near the surface shows it.

use super::{
    Voxel,
    shear::{draw, under_all},
    touch::Point,
};
use crate::math::{Stop, Stopped};

/// How many layers behind its voxels a face still shows them.
const BEHIND: f32 = 1.5;

/// How gaps are looked for.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Shears per axis, pixels a layer.
    pub shears: &'static [f64],
    /// Where pixels are looked at, beside their centres.
    pub offsets: &'static [[f64; 2]],
    /// Only surfaces that span at most so many layers over three by three pixels are looked at.
    pub most_layers: f32,
}

/// A line of sight along which the inside of a surface is seen and no face shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    shear: [f64; 2],
    /// The layer that the shear leaves in place.
    base: i32,
    /// Where the line passes that layer, pixels.
    at: [f64; 2],
    /// First and last layer in which a face shows the surface.
    shown: [f32; 2],
    /// Numbers of the voxels in front, here (in the middle) and around.
    pub voxels: [u32; 9],
}

impl Sight {
    /// The number of the voxel in front.
    pub fn voxel(&self) -> u32 {
        self.voxels[4]
    }

    /// A point as it is seen, pixels from the line and layers.
    pub fn seen(&self, p: Point) -> Point {
        let moved = |i: usize| sheared(p, i, self.shear, self.base) - self.at[i];
        [moved(0), moved(1), p[2] / 4.0]
    }

    /// Whether a face shows the surface, whose corners are `seen`.
    pub fn meets(&self, seen: [Point; 3]) -> bool {
        let [a, b, c] = seen;
        self.meets_between([a[2], b[2], c[2]], [cross(b, c), cross(c, a), cross(a, b)])
    }

    /// [`Sight::meets`] for corners in `layers`; `u`, `v` and `w` are the [`cross`] products of the two others of them, in order.
    pub fn meets_between(&self, layers: [f64; 3], [u, v, w]: [f64; 3]) -> bool {
        let area = u + v + w;
        if area == 0.0 || [u, v, w].iter().any(|x| x * area < 0.0) {
            return false;
        }
        let z = ((u * layers[0] + v * layers[1] + w * layers[2]) / area) as f32;
        self.shown[0] <= z && z <= self.shown[1]
    }
}

/// Twice the area that two points and the line of sight span, signed.
pub fn cross(p: Point, q: Point) -> f64 {
    p[0] * q[1] - p[1] * q[0]
}

/// Where a point is seen along an axis, pixels.
fn sheared(p: Point, axis: usize, shear: [f64; 2], base: i32) -> f64 {
    (p[axis] + shear[axis] * (p[2] - 4.0 * f64::from(base))) / 4.0
}

/// Every line of sight on which `faces` leave visible voxels bare. `alpha`: faces may be transparent.
pub fn bare(
    voxels: &[Voxel],
    faces: &[[Point; 3]],
    look: Look,
    alpha: bool,
    stop: &Stop,
) -> Result<Vec<Sight>, Stopped> {
    let Some(bounds) = VoxelBounds::around(voxels) else { return Ok(Vec::new()) };
    let found = under_all(look.shears, stop, |shear| {
        let picture = Picture::new(voxels, &bounds, shear, |_| true);
        let mut bare = Vec::new();
        for offset in look.offsets {
            let mut shown = vec![false; picture.pixels()];
            for face in faces {
                picture.draw(picture.seen(*face, *offset), |i, z| shown[i] |= picture.shows(i, z, alpha));
            }
            let open = |i: &usize| !shown[*i] && picture.is_inside(*i) && picture.layers(*i) <= look.most_layers;
            bare.extend((0..shown.len()).filter(open).map(|i| picture.sight(i, *offset, alpha)));
        }
        bare
    })?;
    Ok(found.concat())
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

    /// How many layers what is in front spans at a pixel and around it.
    pub fn layers(&self, pixel: usize) -> f32 {
        self.surface[pixel][1] - self.surface[pixel][0]
    }

    /// The line of sight through a pixel at the inside of a surface.
    fn sight(&self, pixel: usize, offset: [f64; 2], alpha: bool) -> Sight {
        let (at, [low, high]) = (self.at(pixel), self.surface[pixel]);
        let mut voxels = [0; 9];
        around(pixel, self.width).zip(&mut voxels).for_each(|(j, v)| *v = self.nearest[j] - 1);
        Sight {
            shear: self.shear,
            base: self.base,
            at: std::array::from_fn(|i| at[i] + f64::from(self.origin[i]) + 0.5 + offset[i]),
            shown: [if alpha { low - BEHIND } else { f32::NEG_INFINITY }, high + BEHIND],
            voxels,
        }
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
        face.map(|p| {
            let moved = |i: usize| sheared(p, i, self.shear, self.base) - f64::from(self.origin[i]) - 0.5 - offset[i];
            [moved(0), moved(1), p[2] / 4.0]
        })
    }

    /// A pixel's column and row.
    pub fn at(&self, pixel: usize) -> [f64; 2] {
        [(pixel % self.width) as f64, (pixel / self.width) as f64]
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

    const LOOK: Look =
        Look { shears: &[-0.5, -0.2, 0.0, 0.2, 0.5], offsets: &[[0.0; 2], [0.25, -0.25]], most_layers: f32::INFINITY };

    fn found(voxels: &[Voxel], faces: &[[Point; 3]]) -> Vec<Sight> {
        bare(voxels, faces, LOOK, false, &Stop::default()).unwrap()
    }

    #[test]
    fn a_whole_surface_is_not_bare() {
        let (voxels, faces) = plane();
        assert_eq!(found(&voxels, &faces), Vec::new());
    }

    #[test]
    fn what_lies_under_a_hole_is_bare_and_an_edge_drawn_back_is_not() {
        let (voxels, faces) = plane();
        let left_of = |limit: f64, t: &[Point; 3]| t.iter().all(|p| p[0] <= limit);
        let hole = |t: &[Point; 3]| t.iter().all(|p| (40.0..=52.0).contains(&p[0]) && (36.0..=44.0).contains(&p[1]));
        let (missing, with_hole): (Vec<_>, Vec<_>) = faces.iter().copied().partition(hole);
        let sights = found(&voxels, &with_hole);
        assert!(!sights.is_empty());
        let near = |v: &Voxel| (9..=14).contains(&v.x) && (8..=12).contains(&v.y);
        for sight in &sights {
            assert!(sight.voxels.iter().all(|v| near(&voxels[*v as usize])));
            let meets = |t: &[Point; 3]| sight.meets(t.map(|p| sight.seen(p)));
            assert!(missing.iter().any(meets) && !with_hole.iter().any(meets), "{sight:?}");
        }
        let flat = Look { most_layers: -1.0, ..LOOK };
        assert_eq!(bare(&voxels, &with_hole, flat, false, &Stop::default()).unwrap(), Vec::new());
        let last = voxels.iter().map(|v| v.x).max().unwrap();
        let drawn_back: Vec<_> = faces.iter().filter(|t| left_of(4.0 * f64::from(last), t)).copied().collect();
        assert!(drawn_back.len() < faces.len());
        assert_eq!(found(&voxels, &drawn_back), Vec::new());
    }
}
