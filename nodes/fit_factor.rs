//! `fit-factor`: how far meshes must be simplified for a number of triangles.

use super::{
    collapse::voxel_cover::{
        Silhouette,
        fit::{FACTORS, fit},
        node::unfit,
    },
    values::Factor,
};
use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    ports,
    voxel::VoxelMesh,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Finds the smallest `factor` of `collapse` (method `voxel-cover`) with which all meshes have at most a number of triangles together. That is a search: it
/// simplifies all meshes up to eight times. Geometry that lies too near for layers is not counted.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Triangles of all meshes together; 0: no target, `collapse` takes its own `factor`.
    pub triangles: u32,
    /// How `collapse` shows outlines.
    pub silhouette: Silhouette,
}

ports! {
    pub struct In {
        /// The connected meshes, not simplified.
        meshes: List<VoxelMesh>,
    }
}

ports! {
    pub struct Out {
        /// The factor, or none where there is no target.
        factor: Arc<Factor>,
    }
}

pub struct FitFactor;

impl Node for FitFactor {
    const KIND: &'static str = "fit-factor";
    const VERSION: u32 = 5;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        // As `collapse`, for all meshes at once.
        if params.triangles == 0 { 1 << 20 } else { sizes.iter().sum::<u64>().saturating_mul(7) }
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let meshes: Vec<&VoxelMesh> = inputs.meshes.0.iter().map(|(_, m)| &**m).collect();
        let factor = match params.triangles as usize {
            0 => None,
            target => Some(fit(&meshes, target, FACTORS, params.silhouette, ctx.stop).map_err(unfit)?.factor),
        };
        Ok(Out { factor: Arc::new(Factor(factor)) })
    }
}
