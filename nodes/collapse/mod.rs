//! `collapse`: fewer triangles for a connected mesh, by one of two policies.

pub mod quadric;
pub mod voxel_cover;

use super::values::Factor;
use crate::{
    engine::node::{Ctx, Node, NodeError},
    ports,
    voxel::VoxelMesh,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{ops::RangeInclusive, sync::Arc};
use voxel_cover::fit::{FitError, fit};

/// How edges are chosen and what forbids their collapse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Policy {
    /// The cheapest edge first, as long as every voxel stays covered (Jeschke and Wimmer 2002, section 6).
    #[default]
    VoxelCover,
    /// meshoptimizer's quadric simplifier down to `triangles`; covers nothing for certain. For comparison.
    Quadric,
}

/// Contracts the edges of a connected mesh until its policy forbids every further contraction.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// `voxel-cover` or `quadric`.
    pub policy: Policy,
    /// Side of the box in which a voxel must be touched, in voxels; 1 to 8. Larger: fewer triangles, a larger error
    /// (about `factor` pixels seen from the cell). The paper: 1.5 to 2.
    pub factor: f64,
    /// Triangles to which each connected mesh is simplified at most; 1 or more. Policy `voxel-cover`: instead of `factor` the smallest factor
    /// of 1 to 8 that leaves no more, found by a search. The error bound follows the factor. An error where 8 leaves more. For a number of all
    /// meshes together connect `fit-factor` (in `tdm` the knob `triangles`). Policy `quadric`: 1000 where there is none.
    pub triangles: Option<u32>,
    /// Policy `quadric`: whether boundary vertices stay where they are.
    pub lock_border: bool,
}

impl Default for Params {
    fn default() -> Self {
        Self { policy: Policy::VoxelCover, factor: 2.0, triangles: None, lock_border: false }
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

/// Factors that make sense.
pub const FACTORS: RangeInclusive<f64> = 1.0..=8.0;

/// A target that was not met, as a node's error.
pub fn unfit(e: FitError) -> NodeError {
    match e {
        FitError::Stopped(s) => NodeError::Stopped(s),
        other => NodeError::from_error(&other),
    }
}

pub struct Collapse;

impl Node for Collapse {
    const KIND: &'static str = "collapse";
    const VERSION: u32 = 4;
    /// meshoptimizer is C++; the default policy gives the same bytes on every machine.
    const NATIVE_WHEN: Option<(&'static str, &'static str)> = Some(("policy", "quadric"));
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // Corner table, points, lists and the queue beside the mesh itself.
        sizes.first().copied().unwrap_or(0).saturating_mul(6)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        if !FACTORS.contains(&params.factor) {
            return Err(("factor", format!("expected 1 to 8 voxels, found {}", params.factor)));
        }
        if params.triangles == Some(0) {
            return Err(("triangles", "expected 1 or more".into()));
        }
        Ok(())
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let mesh = &*inputs.mesh;
        let factor = inputs.fitted.and_then(|f| f.0).unwrap_or(params.factor);
        let mesh = match (params.policy, params.triangles) {
            (Policy::VoxelCover, None) => voxel_cover::simplify_in_steps(mesh, factor, ctx.stop, &ctx.progress)?,
            (Policy::VoxelCover, Some(target)) => {
                let fitted = fit(&[mesh], target as usize, FACTORS, ctx.stop).map_err(unfit)?;
                fitted.meshes.into_iter().next().unwrap_or_default()
            }
            (Policy::Quadric, target) => {
                let target =
                    quadric::Target { triangles: target.unwrap_or(1000) as usize, lock_border: params.lock_border };
                quadric::simplify(mesh, target, factor, ctx.stop)?
            }
        };
        Ok(Out { mesh: Arc::new(mesh) })
    }
}
