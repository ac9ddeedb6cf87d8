//! `voxel-mesh`: connected meshes that cover a voxel field.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    ports,
    voxel::{Field, Slices, VoxelMesh, cover_mesh},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Covers every visible voxel with triangles and joins neighbours within a layer and between adjacent layers, so that continuous
/// surfaces become connected meshes (Jeschke and Wimmer 2002, section 5).
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {}

ports! {
    pub struct In {
        /// The frusta and layers of the voxels.
        slices: Arc<Slices>,
        /// The visible voxels of every frustum.
        fields: List<Field>,
    }
}

ports! {
    pub struct Out {
        /// Connected meshes, each named by its smallest voxel: frustum, layer, y and x.
        meshes: List<VoxelMesh>,
    }
}

pub struct VoxelMeshNode;

impl Node for VoxelMeshNode {
    const KIND: &'static str = "voxel-mesh";
    const VERSION: u32 = 3;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // About eight faces and four vertices a voxel, with their tables.
        sizes.get(1).copied().unwrap_or(0).saturating_mul(40)
    }

    fn run(_: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let fields: Vec<&Field> = inputs.fields.0.iter().map(|(_, f)| f.as_ref()).collect();
        let meshes = cover_mesh::cover_meshes(&inputs.slices, &fields, ctx.stop).map_err(|e| match e {
            cover_mesh::CoverError::Stopped(stopped) => NodeError::Stopped(stopped),
            other => NodeError::from_error(&other),
        })?;
        if meshes.is_empty() {
            return Err(NodeError::Failed("there are no voxels to cover: nothing can be seen from the cell".into()));
        }
        Ok(Out { meshes: List(meshes.into_iter().map(|(name, mesh)| (name, Arc::new(mesh))).collect()) })
    }
}
