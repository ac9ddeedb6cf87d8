//! Where a texel lies in voxel space.

use crate::voxel::{
    VoxelMesh,
    reproject::{Reprojection, face_barycentrics},
};
use glam::{DVec2, DVec3, dvec3};

/// A mesh with its map to the world, and the metric in which its texels are measured.
pub struct Space<'a> {
    pub mesh: &'a VoxelMesh,
    pub map: Reprojection<'a>,
    /// Texel sides that a step of one layer is worth, 1/k for a whole k: the most pixels by which the cell's viewers
    /// see two neighbouring layers of this mesh move against each other, rounded up.
    pub layer_unit: f64,
}

impl<'a> Space<'a> {
    pub fn new(mesh: &'a VoxelMesh, map: Reprojection<'a>) -> Self {
        let layers = mesh.vertices.iter().map(|v| v[2] as usize);
        let (first, last) = (layers.clone().min().unwrap_or(0), layers.max().unwrap_or(0));
        let movement = (first..last).map(|l| map.movement(l)).fold(0.0, f64::max);
        // Narrow cells can make walls as good as invisible; an eighth of a voxel's side is enough for those.
        let steps = if movement > 0.0 { (1.0 / movement).floor().clamp(1.0, 8.0) } else { 1.0 };
        Self { mesh, map, layer_unit: 1.0 / steps }
    }

    /// One voxel side along each axis, in the metric.
    pub fn unit(&self) -> DVec3 {
        dvec3(1.0, 1.0, self.layer_unit)
    }

    /// Vertex place in the metric: pixels, pixels and layers times `layer_unit`; the centre of voxel (x, y, l) is at
    /// (x + ½, y + ½, (l + ½)·layer_unit), so that texel centres fall on voxel centres.
    pub fn metric(&self, vertex: u32) -> DVec3 {
        let v = self.mesh.vertices[vertex as usize];
        dvec3(f64::from(v[0]) / 4.0, f64::from(v[1]) / 4.0, (f64::from(v[2]) + 0.5) * self.layer_unit)
    }

    pub fn depth(&self, vertex: u32) -> f64 {
        self.map.depth(self.mesh.vertices[vertex as usize][2])
    }

    /// Voxel-space place (x, y in pixels, z the layer) of the point that a renderer draws with texel coordinates `at`,
    /// on `face` with texel coordinates `t`. Outside the face its plane is continued, as far as that stays close.
    pub fn place(&self, face: u32, t: &[DVec2; 3], at: DVec2) -> DVec3 {
        let v = self.mesh.faces[face as usize];
        let q = v.map(|v| {
            let v = self.mesh.vertices[v as usize];
            dvec3(f64::from(v[0]) / 4.0, f64::from(v[1]) / 4.0, f64::from(v[2]))
        });
        let z = DVec3::from(v.map(|v| self.depth(v)));
        let point = |b: DVec3| face_barycentrics(b, z).map(|l| q[0] * l.x + q[1] * l.y + q[2] * l.z);
        let area = (t[1] - t[0]).perp_dot(t[2] - t[0]);
        let free = (area.abs() > 1e-6).then(|| {
            let b1 = (at - t[0]).perp_dot(t[2] - t[0]) / area;
            let b2 = (t[1] - t[0]).perp_dot(at - t[0]) / area;
            dvec3(1.0 - b1 - b2, b1, b2)
        });
        if let Some(b) = free.filter(|b| b.min_element() >= 0.0) {
            return point(b).unwrap_or(q[0]);
        }
        let edge = point(clamped(t, at)).unwrap_or(q[0]);
        // Slivers and faces far from flat: what lies outside them is not where their plane goes.
        let near = |p: &DVec3| p.distance(edge) <= 4.0;
        free.and_then(point).filter(near).unwrap_or(edge)
    }
}

/// Barycentrics of the point of the triangle's border that is nearest to `at`.
fn clamped(t: &[DVec2; 3], at: DVec2) -> DVec3 {
    let mut best = (f64::INFINITY, DVec3::X);
    for k in 0..3 {
        let (i, j) = (k, (k + 1) % 3);
        let edge = t[j] - t[i];
        let s = if edge == DVec2::ZERO { 0.0 } else { ((at - t[i]).dot(edge) / edge.length_squared()).clamp(0.0, 1.0) };
        let d = at.distance_squared(t[i] + edge * s);
        if d < best.0 {
            let mut b = [0.0; 3];
            b[i] = 1.0 - s;
            b[j] += s;
            best = (d, DVec3::from(b));
        }
    }
    best.1
}
