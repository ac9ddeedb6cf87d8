//! The node: parameters and ports.

use super::{
    Goal, Silhouette,
    fit::{FACTORS, FitError, fit},
    simplify_in_steps,
};
use crate::{
    engine::node::{Ctx, Node, NodeError},
    nodes::values::Factor,
    ports,
    voxel::VoxelMesh,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Contracts the edges of a connected mesh over voxels, the cheapest first, as long as every voxel stays covered (Jeschke and Wimmer 2002,
/// section 6).
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Side of the box in which a voxel must be touched, in voxels; 1 to 8. Larger: fewer triangles, a larger error
    /// (about `factor` pixels seen from the cell). The paper: 1.5 to 2.
    #[schemars(range(min = 1.0, max = 8.0), extend("x-unit" = "voxels"))]
    pub factor: f64,
    /// Triangles to which each connected mesh is simplified at most; 1 or more. Instead of `factor` the smallest factor
    /// of 1 to 8 that leaves no more, found by a search. The error bound follows the factor. An error where 8 leaves more. For a number of all
    /// meshes together connect `fit-factor` (in `tdm` the knob `triangles`).
    #[schemars(range(min = 1))]
    pub triangles: Option<u32>,
    /// How outlines are shown.
    pub silhouette: Silhouette,
}

impl Default for Params {
    fn default() -> Self {
        Self { factor: 2.0, triangles: None, silhouette: Silhouette::default() }
    }
}

ports! {
    pub struct In {
        /// A connected mesh over voxels.
        mesh: Arc<VoxelMesh>,
        /// Takes the place of `factor` where it holds one.
        fitted: Option<Arc<Factor>>,
    }
}

ports! {
    pub struct Out {
        /// The same surface in fewer triangles; every face names the voxels that it covers.
        mesh: Arc<VoxelMesh>,
    }
}

/// A target that was not met, as a node's error.
pub fn unfit(e: FitError) -> NodeError {
    match e {
        FitError::Stopped(s) => NodeError::Stopped(s),
        other => NodeError::from_error(&other),
    }
}

pub struct VoxelCover;

impl Node for VoxelCover {
    const KIND: &'static str = "collapse";
    const METHOD: &'static str = "voxel-cover";
    const VERSION: u32 = 9;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // Corner table, points, lists and the queue beside the mesh itself.
        sizes.first().copied().unwrap_or(0).saturating_mul(6)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let mesh = &*inputs.mesh;
        let factor = inputs.fitted.and_then(|f| f.0).unwrap_or(params.factor);
        let mesh = match params.triangles {
            None => {
                let goal = Goal { factor, silhouette: params.silhouette };
                simplify_in_steps(mesh, goal, ctx.stop, &ctx.progress)?
            }
            Some(target) => {
                let fitted = fit(&[mesh], target as usize, FACTORS, params.silhouette, ctx.stop).map_err(unfit)?;
                fitted.meshes.into_iter().next().unwrap_or_default()
            }
        };
        Ok(Out { mesh: Arc::new(mesh) })
    }
}
