//! From voxel space to the world and back (Jeschke and Wimmer 2002, section 8).
//!
//! The paper's formulas hold for a symmetric field of view; here the frustum's window is given by four tangents, so
//! that x and y each have their own. A vertex (x, y, l) lies on the ray through its place in the image, at the planar
//! depth `layer[l]` from the cell's centre. Equal vertices give equal bits, and a seam between two faces of a cube has
//! the same bits from both sides.

use super::{Frustum, Slices, VoxelMesh};
use crate::{
    math::{Aabb, shift},
    view::Cell,
};
use glam::{DVec2, DVec3, dvec2, dvec3};

/// A mesh and the slices that it was made from do not fit together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MisfitError {
    #[error("the mesh lies in frustum {found}, but the slices have {count}")]
    Frustum { found: u32, count: usize },
    #[error("vertex {vertex} lies in layer {found}, but the slices have {count}")]
    Layer { vertex: usize, found: i32, count: usize },
    #[error("face {face} names vertex {found} of {count}")]
    Vertex { face: usize, found: u32, count: usize },
    #[error("face {face}: its covered voxels {start}..{end} are no range of the {count} stored")]
    Cover { face: usize, start: u32, end: u32, count: usize },
    #[error("face {face} covers voxel {found} of {count}")]
    Voxel { face: usize, found: u32, count: usize },
    #[error("the mesh has no voxels to take its colours from")]
    NoVoxels,
}

/// One frustum of a cell: the map between its voxel space and the world.
#[derive(Clone, Copy, Debug)]
pub struct Reprojection<'a> {
    slices: &'a Slices,
    frustum: &'a Frustum,
}

impl<'a> Reprojection<'a> {
    /// `None` where the slices have no such frustum.
    pub fn new(slices: &'a Slices, frustum: u32) -> Option<Self> {
        Some(Self { slices, frustum: slices.frusta.get(frustum as usize)? })
    }

    /// What world positions are stored relative to, the same for all meshes of the cell: zero, or where the cell lies far
    /// from the origin a round place near it.
    pub fn origin(&self) -> DVec3 {
        // How far from the cell its objects are held to be, in half extents: twice what a default cell's are.
        const NEAR: f64 = 80.0;
        let Cell { centre, half } = self.slices.cell;
        let reach = half * NEAR;
        shift(&Aabb { min: centre - reach, max: centre + reach })
    }

    /// The map for `mesh`, after checking that all its numbers exist.
    pub fn of(slices: &'a Slices, mesh: &VoxelMesh) -> Result<Self, MisfitError> {
        let this = Self::new(slices, mesh.frustum)
            .ok_or(MisfitError::Frustum { found: mesh.frustum, count: slices.frusta.len() })?;
        let layers = slices.layers.len();
        for (vertex, v) in mesh.vertices.iter().enumerate() {
            if usize::try_from(v[2]).is_ok_and(|l| l < layers) {
                continue;
            }
            return Err(MisfitError::Layer { vertex, found: v[2], count: layers });
        }
        let vertices = mesh.vertices.len();
        for (face, f) in mesh.faces.iter().enumerate() {
            if let Some(found) = f.iter().find(|v| **v as usize >= vertices) {
                return Err(MisfitError::Vertex { face, found: *found, count: vertices });
            }
            let range = (mesh.cover_start.get(face).copied(), mesh.cover_start.get(face + 1).copied());
            let (start, end) = (range.0.unwrap_or(u32::MAX), range.1.unwrap_or(u32::MAX));
            let Some(cover) = mesh.cover.get(start as usize..end as usize) else {
                return Err(MisfitError::Cover { face, start, end, count: mesh.cover.len() });
            };
            if let Some(found) = cover.iter().find(|v| **v as usize >= mesh.voxels.len()) {
                return Err(MisfitError::Voxel { face, found: *found, count: mesh.voxels.len() });
            }
        }
        if mesh.voxels.is_empty() && !mesh.faces.is_empty() {
            return Err(MisfitError::NoVoxels);
        }
        Ok(this)
    }

    pub fn frustum(&self) -> &'a Frustum {
        self.frustum
    }

    /// Planar depth of layer `l` from the cell's centre, metres.
    pub fn depth(&self, l: i32) -> f64 {
        self.slices.layers[l as usize]
    }

    /// World position of a mesh vertex (x, y in quarter pixels, l a layer that exists).
    pub fn world(&self, v: [i32; 3]) -> DVec3 {
        let f = self.frustum;
        let z = self.depth(v[2]);
        // Written so that mirroring an axis negates the bits: both sides of a seam agree.
        let mix = |from: f64, to: f64, at: i32, size: u32| {
            let n = 4.0 * f64::from(size);
            (from * (n - f64::from(at)) + to * f64::from(at)) / n
        };
        let u = mix(f.left, f.right_tan, v[0], f.size[0]);
        let w = mix(f.top, f.bottom, v[1], f.size[1]);
        self.slices.cell.centre + (f.right * (u * z) + f.up * (w * z) + f.forward * z)
    }

    /// Voxel-space place (x, y in pixels, layer by linear interpolation between the layers' depths, beyond the last
    /// ones by the last step) of a world point. `None` where the point does not lie in front of the cell's centre.
    pub fn voxel(&self, p: DVec3) -> Option<DVec3> {
        let f = self.frustum;
        let d = p - self.slices.cell.centre;
        let z = d.dot(f.forward);
        if z <= 0.0 {
            return None;
        }
        let x = (d.dot(f.right) / z - f.left) / (f.right_tan - f.left) * f64::from(f.size[0]);
        let y = (f.top - d.dot(f.up) / z) / (f.top - f.bottom) * f64::from(f.size[1]);
        Some(dvec3(x, y, self.layer(z)))
    }

    /// Continuous layer number of planar depth `z`.
    fn layer(&self, z: f64) -> f64 {
        let layers = &self.slices.layers;
        if layers.len() < 2 {
            return 0.0;
        }
        let above = layers.partition_point(|s| *s <= z).clamp(1, layers.len() - 1);
        let (a, b) = (layers[above - 1], layers[above]);
        (above - 1) as f64 + (z - a) / (b - a)
    }

    /// The cell that the slices were made for.
    pub fn cell(&self) -> &'a Cell {
        &self.slices.cell
    }

    /// Where the ray from `viewer` (its offset from the cell's centre) through `p` (x, y in pixels, z the layer) meets
    /// layer `l`, a layer that exists or the nearest that does: x and y in pixels.
    pub fn seen_at(&self, viewer: DVec3, p: DVec3, l: i32) -> DVec2 {
        let f = self.frustum;
        let last = self.slices.layers.len() as i32 - 1;
        let base = p.z.floor().clamp(0.0, f64::from((last - 1).max(0)));
        let [a, b] = [0.0, 1.0].map(|k| self.depth(((base + k) as i32).min(last)));
        let through = a + (b - a) * (p.z - base);
        let z = self.depth(l.clamp(0, last));
        let (scale, origin) = (
            dvec2((f.right_tan - f.left) / f64::from(f.size[0]), (f.bottom - f.top) / f64::from(f.size[1])),
            dvec2(f.left, f.top),
        );
        let from = dvec2(viewer.dot(f.right), viewer.dot(f.up));
        let forward = viewer.dot(f.forward);
        let place = (origin + p.truncate() * scale) * through;
        let at = from + (place - from) * ((z - forward) / (through - forward));
        (at / z - origin) / scale
    }

    /// How many pixels layer l + 1 moves at most against layer l, seen from anywhere in the cell (section 4.1,
    /// with the cell's own half extents).
    pub fn movement(&self, l: usize) -> f64 {
        let (Some(&p), Some(&next)) = (self.slices.layers.get(l), self.slices.layers.get(l + 1)) else { return 0.0 };
        let f = self.frustum;
        let along = |axis: DVec3| self.slices.cell.half.dot(axis.abs());
        let az = along(f.forward);
        let one = |half: f64, t: f64, pixel: f64| (next - p) * (half + t * az) / ((next - az) * p * pixel);
        let x = one(along(f.right), f.left.abs().max(f.right_tan.abs()), (f.right_tan - f.left) / f64::from(f.size[0]));
        let y = one(along(f.up), f.top.abs().max(f.bottom.abs()), (f.top - f.bottom) / f64::from(f.size[1]));
        x.max(y)
    }
}

/// Where a point with world barycentrics `b` on a world-space face lies on the voxel-space face, as barycentrics λ:
/// λ_i = b_i·z_i / Σ b_j·z_j with the vertices' planar depths z. `None` where the sum is not positive.
pub fn face_barycentrics(b: DVec3, z: DVec3) -> Option<DVec3> {
    let w = b * z;
    let sum = w.x + w.y + w.z;
    (sum > 0.0).then(|| w / sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxel::testing;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn there_and_back(x in 0..400i32, y in 0..240i32, l in 0..6i32) {
            let slices = testing::slices();
            let r = Reprojection::new(&slices, 0).unwrap();
            let back = r.voxel(r.world([x, y, l])).unwrap();
            let d = back - dvec3(f64::from(x) / 4.0, f64::from(y) / 4.0, f64::from(l));
            prop_assert!(d.length() < 1e-9, "{back}");
        }

        /// A face that is no wall: the place by λ is where the world point projects to.
        #[test]
        fn lambda_is_perspective(v in prop::array::uniform3((0..400i32, 0..240i32, 0..6i32)), b in (0.0..1.0f64, 0.0..1.0f64)) {
            let slices = testing::slices();
            let r = Reprojection::new(&slices, 0).unwrap();
            let v = v.map(|(x, y, l)| [x, y, l]);
            let (s, t) = if b.0 + b.1 > 1.0 { (1.0 - b.0, 1.0 - b.1) } else { b };
            let b = dvec3(1.0 - s - t, s, t);
            let z = DVec3::from(v.map(|v| r.depth(v[2])));
            let world = r.world(v[0]) * b.x + r.world(v[1]) * b.y + r.world(v[2]) * b.z;
            let lambda = face_barycentrics(b, z).unwrap();
            let pixel = |i: usize| DVec2::new(f64::from(v[i][0]), f64::from(v[i][1])) / 4.0;
            let by_lambda = pixel(0) * lambda.x + pixel(1) * lambda.y + pixel(2) * lambda.z;
            let direct = r.voxel(world).unwrap();
            prop_assert!((by_lambda - DVec2::new(direct.x, direct.y)).length() < 1e-8);
        }
    }

    /// Two faces of a cube: the vertices on the shared edge have the same bits.
    #[test]
    fn seams_agree() {
        let mut slices = testing::slices();
        let square = |right, forward| Frustum {
            right,
            up: DVec3::Y,
            forward,
            left: -1.0,
            right_tan: 1.0,
            bottom: -1.0,
            top: 1.0,
            size: [37, 37],
            across: [None; 4],
        };
        slices.frusta = vec![square(DVec3::X, DVec3::NEG_Z), square(DVec3::Z, DVec3::X)];
        let (a, b) = (Reprojection::new(&slices, 0).unwrap(), Reprojection::new(&slices, 1).unwrap());
        for y in 0..=37 * 4 {
            for l in 0..6 {
                assert_eq!(a.world([37 * 4, y, l]), b.world([0, y, l]));
            }
        }
    }

    #[test]
    fn misfits_are_errors() {
        let slices = testing::slices();
        let good = testing::wall(&slices);
        assert!(Reprojection::of(&slices, &good).is_ok());
        let bad = |change: fn(&mut VoxelMesh)| {
            let mut m = good.clone();
            change(&mut m);
            assert!(Reprojection::of(&slices, &m).is_err());
        };
        bad(|m| m.frustum = 9);
        bad(|m| m.vertices = vec![[0, 0, -1]; m.vertices.len()].into());
        bad(|m| m.vertices = vec![[0, 0, 99]; m.vertices.len()].into());
        bad(|m| m.faces = vec![[0, 1, 4000]].into());
        bad(|m| m.cover_start = vec![0].into());
        bad(|m| m.cover_start = vec![2, 1, 0, 0, 0].into());
        bad(|m| m.cover = vec![u32::MAX; m.cover.len()].into());
        bad(|m| m.voxels = Vec::new().into());
    }
}
