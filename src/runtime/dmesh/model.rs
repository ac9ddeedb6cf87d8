//! A DMesh made ready to be drawn.

use super::{Dmesh, DmeshError, Mesh, Reference};
use crate::{
    raster::{Geometry, Mips, Role},
    scene::{self, Material, Object, Scene},
};
use glam::{DVec3, DVec4, Mat4};
use rayon::prelude::*;
use std::sync::Arc;

/// A DMesh with what drawing needs of it: mip levels, and the meshes as the rasteriser takes them.
pub struct Model {
    dmesh: Dmesh,
    parts: Vec<Part>,
}

/// One reference.
pub(crate) struct Part {
    pub geometry: Geometry,
    pub color: Arc<Mips>,
    pub normals: Option<Arc<Mips>>,
    /// [`Reference::texel`].
    pub texel: DVec4,
    /// Number of its first triangle among those of all references.
    pub first: u32,
}

impl Model {
    /// # Errors
    /// As [`Dmesh::check`].
    pub fn new(dmesh: Dmesh) -> Result<Self, DmeshError> {
        dmesh.check()?;
        let mips = |r: &Reference| {
            let normals = r.normal_map.as_ref().map(|n| Arc::new(Mips::new(n, Role::Data)));
            (Arc::new(Mips::new(&r.color, Role::Color)), normals)
        };
        let mips: Vec<_> = dmesh.references.par_iter().map(mips).collect();
        Ok(Self::of(dmesh, mips))
    }

    /// The same with other meshes, one a reference: those that were triangulated for a frame (section 4.4). Pictures are shared.
    ///
    /// # Errors
    /// As [`Dmesh::check`], and where there is not one mesh for each reference.
    pub fn with_meshes(&self, meshes: &[Arc<Mesh>]) -> Result<Self, DmeshError> {
        let mut dmesh = self.dmesh.clone();
        if meshes.len() != dmesh.references.len() {
            let what = format!("{} meshes; expected {}, one a reference", meshes.len(), dmesh.references.len());
            return Err(DmeshError::invalid("dmesh", what));
        }
        for (reference, mesh) in dmesh.references.iter_mut().zip(meshes) {
            reference.mesh = mesh.clone();
        }
        dmesh.check()?;
        let mips = self.parts.iter().map(|p| (p.color.clone(), p.normals.clone())).collect();
        Ok(Self::of(dmesh, mips))
    }

    fn of(dmesh: Dmesh, mips: Vec<(Arc<Mips>, Option<Arc<Mips>>)>) -> Self {
        let mut first = 0;
        let mut parts = Vec::with_capacity(mips.len());
        for (reference, (color, normals)) in dmesh.references.iter().zip(mips) {
            let geometry = Geometry::new(&plain(reference, dmesh.double_sided));
            let count = geometry.triangle_count();
            parts.push(Part { geometry, color, normals, texel: reference.texel(), first });
            first += count;
        }
        Self { dmesh, parts }
    }

    pub fn dmesh(&self) -> &Dmesh {
        &self.dmesh
    }

    pub(crate) fn part(&self, reference: usize) -> (&Reference, &Part) {
        (&self.dmesh.references[reference], &self.parts[reference])
    }

    /// Corners in world space, metres, of a triangle in the numbering of [`super::Drawn::surface`].
    ///
    /// # Panics
    /// Where there is no such triangle.
    pub fn positions(&self, surface: u32) -> [DVec3; 3] {
        let part = &self.parts[self.parts.partition_point(|p| p.first <= surface) - 1];
        part.geometry.positions(surface - part.first)
    }
}

/// The shape alone, as a scene of one object.
fn plain(reference: &Reference, double_sided: bool) -> Scene {
    let Mesh { positions, triangles, .. } = &*reference.mesh;
    let mesh = scene::Mesh { positions: positions.clone(), triangles: triangles.clone(), ..scene::Mesh::default() };
    let material = Material { double_sided, ..Material::default() };
    let part = scene::Part { mesh: Arc::new(mesh), material: Arc::new(material) };
    Scene { objects: vec![Object { name: reference.name.clone(), transform: Mat4::IDENTITY, parts: vec![part] }] }
}
