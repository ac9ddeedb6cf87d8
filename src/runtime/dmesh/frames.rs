//! Meshes that are made for a view: section 4.4, step (ii) of section 6.1.

use super::{Dmesh, DmeshError, Mesh, Selected};
use crate::{
    array::Array,
    depth_mesh::{DepthMap, DepthMesh, Hierarchy, Options, Workspace},
    view::View,
};
use rayon::prelude::*;
use std::sync::Arc;

/// What meshes for a view are made from: the depth images of the references. Clones share them.
#[derive(Clone, Debug, PartialEq)]
pub struct Frames {
    /// τ: how far the mesh may lie from the captured surface in the picture, pixels, ≥ 0.
    pub tau: f64,
    pub options: Options,
    /// For each reference the planar depths of its camera's pixels, metres; infinite where there is nothing.
    pub depths: Vec<Array<f32>>,
}

impl Frames {
    /// Whether they are those of `dmesh`.
    pub(super) fn check(&self, dmesh: &Dmesh) -> Result<(), DmeshError> {
        let bad = |what: String| Err(DmeshError::invalid("view_dependent", what));
        if !(self.tau >= 0.0 && self.tau.is_finite()) {
            return bad(format!("tau {}; expected pixels, at least 0", self.tau));
        }
        if self.depths.len() != dmesh.references.len() {
            return bad(format!("{} depth images for {} references", self.depths.len(), dmesh.references.len()));
        }
        Ok(())
    }
}

/// The references' hierarchies, made once, from which meshes for any view follow.
pub struct Meshes {
    tau: f32,
    hierarchies: Vec<Hierarchy>,
    empty: Arc<Mesh>,
}

impl Meshes {
    /// # Errors
    /// Where a depth image is none: see [`DepthMap::new`].
    pub fn new(dmesh: &Dmesh, frames: &Frames) -> Result<Self, DmeshError> {
        frames.check(dmesh)?;
        let pairs = dmesh.references.par_iter().zip(&frames.depths);
        let hierarchies = pairs.map(|(reference, depth)| {
            let bad = |what: String| DmeshError::invalid(format!("reference `{}`", reference.name), what);
            let map = DepthMap::new(reference.view, depth.to_vec()).map_err(|e| bad(e.to_string()))?;
            Hierarchy::new(map, &frames.options).map_err(|e| bad(e.to_string()))
        });
        Ok(Self { tau: frames.tau as f32, hierarchies: hierarchies.collect::<Result<_, _>>()?, empty: Arc::default() })
    }

    /// One mesh a reference; those that are not selected have none.
    pub fn for_view(&self, view: &View, selected: &[Selected]) -> Vec<Arc<Mesh>> {
        let mesh = |(i, hierarchy): (usize, &Hierarchy)| {
            if selected.iter().all(|s| s.reference != i) {
                return self.empty.clone();
            }
            let mut workspace = Workspace::default();
            hierarchy.view_dependent(view, self.tau, &mut workspace);
            Arc::new(hierarchy.mesh(workspace.triangulation()).into())
        };
        self.hierarchies.par_iter().enumerate().map(mesh).collect()
    }
}

impl From<DepthMesh> for Mesh {
    fn from(mesh: DepthMesh) -> Self {
        Self {
            positions: mesh.positions.into(),
            normals: mesh.normals.into(),
            quality: mesh.quality.into(),
            uv: mesh.uv.into(),
            triangles: mesh.triangles.into(),
        }
    }
}
