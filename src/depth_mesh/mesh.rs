//! Triangulations with what a renderer or a file needs.

use super::{emit::Triangulation, hierarchy::Hierarchy, normals, strips::Strips};
use glam::DVec3;
use rayon::prelude::*;

/// An indexed mesh in world space and its strips. Triangles are counter-clockwise as the reference camera sees them; all lists of vertices
/// have the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DepthMesh {
    /// Grid point of each vertex, y · side + x, ascending.
    pub grid: Vec<u32>,
    /// World space, metres.
    pub positions: Vec<[f32; 3]>,
    /// World space, of unit length, towards the camera.
    pub normals: Vec<[f32; 3]>,
    /// ρ of section 4.2, 0 to 1.
    pub quality: Vec<f32>,
    /// Of the pixel's centre, (0, 0) at the top left corner of the image.
    pub uv: Vec<[f32; 2]>,
    pub triangles: Vec<[u32; 3]>,
    pub strips: Strips,
    /// Triangles that were left out because they are cut.
    pub cut: usize,
}

impl DepthMesh {
    /// Triangles per strip; 0 without strips.
    pub fn mean_strip_length(&self) -> f64 {
        if self.strips.is_empty() { 0.0 } else { self.triangles.len() as f64 / self.strips.len() as f64 }
    }
}

impl Hierarchy {
    /// A triangulation of this hierarchy with the attributes of its vertices.
    pub fn mesh(&self, triangulation: &Triangulation) -> DepthMesh {
        let side = self.map().side();
        let view = self.map().view();
        let turn = |v: DVec3| view.right * v.x + view.up * v.y + view.forward * v.z;
        let vertex = |&at: &u32| {
            let (x, y) = (at as usize % side, at as usize / side);
            let z = self.map().depth()[at as usize];
            let normal = self.camera_normal(x, y);
            let pixel = [x as f64 + 0.5, y as f64 + 0.5];
            let position = view.unproject(pixel[0], pixel[1], f64::from(z));
            let uv = pixel.map(|c| (c / side as f64) as f32);
            let quality = normals::quality(&self.rays, x, y, normal);
            (position.as_vec3().to_array(), turn(normal.as_dvec3()).normalize().as_vec3().to_array(), quality, uv)
        };
        let mut mesh = DepthMesh {
            grid: triangulation.vertices.clone(),
            triangles: triangulation.triangles.clone(),
            strips: triangulation.strips.clone(),
            cut: triangulation.cut,
            ..DepthMesh::default()
        };
        let vertices: Vec<_> = triangulation.vertices.par_iter().with_min_len(1024).map(vertex).collect();
        for (position, normal, quality, uv) in vertices {
            mesh.positions.push(position);
            mesh.normals.push(normal);
            mesh.quality.push(quality);
            mesh.uv.push(uv);
        }
        mesh
    }
}
