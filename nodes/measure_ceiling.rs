//! `measure-ceiling`: what no simplification of a mesh can beat.

use super::{
    evaluate::views::{Shading, check_bound, check_viewing, failed, memory, region, viewing},
    values::Ceiling,
};
use crate::{
    certify::{self, Sampled},
    engine::node::{Ctx, Node, NodeError},
    ports,
    scene::Scene,
    view::{Cell, Region},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Measures the mesh that a stand-in is simplified from, as `evaluate` measures the stand-in: no simplification can beat it. Its figures are the same
/// however far the mesh is simplified and whatever its textures are, so they are measured once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Number of views, 8 or more: those of `evaluate`.
    pub views: u32,
    /// Seed of the sequence of views.
    pub seed: u64,
    /// Width and height of a picture in pixels.
    pub resolution: u32,
    /// Field of view of a picture, degrees.
    pub fov: f64,
    /// Samples of a pixel in x and in y for colour, 1 to 16.
    pub samples: u32,
    /// Which colours are compared.
    pub shading: Shading,
    /// The error of the mesh itself, pixels: what lies nearer than this to an edge counts as being at the edge.
    pub bound: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self { views: 64, seed: 1, resolution: 1024, fov: 45.0, samples: 4, shading: Shading::Auto, bound: 1.0 }
    }
}

ports! {
    pub struct In {
        /// What the stand-in replaces.
        original: Arc<Scene>,
        /// The mesh before simplification.
        mesh: Arc<Scene>,
        /// The cell from which the stand-in will be seen. Either it or a `region` is connected.
        cell: Option<Arc<Cell>>,
        /// Another place from which it will be seen, such as a sphere around it.
        region: Option<Arc<Region>>,
    }
}

ports! {
    pub struct Out {
        /// For `evaluate`.
        ceiling: Arc<Ceiling>,
    }
}

pub struct MeasureCeiling;

impl Node for MeasureCeiling {
    const KIND: &'static str = "measure-ceiling";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        memory(params.resolution, sizes)
    }

    fn doubts(params: &Params) -> Vec<(&'static str, String)> {
        super::doubt_fov(params.fov)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        check_viewing(params.views, params.resolution, params.fov, params.samples)?;
        check_bound("bound", params.bound)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let region = region(inputs.cell, inputs.region)?;
        let Params { views, seed, resolution, fov, samples, shading, bound } = *params;
        let viewing = viewing([views, resolution, samples], seed, fov, shading);
        let context = certify::Context { backend: super::backend(ctx), stop: ctx.stop, progress: ctx.progress };
        let ceiling = certify::ceiling(&inputs.original, &inputs.mesh, &region, &viewing, bound, context);
        let sampling = serde_json::to_value(Sampled::of(&viewing, &region)).map_err(|e| NodeError::from_error(&e))?;
        Ok(Out { ceiling: Arc::new(Ceiling { sampling, ceiling: ceiling.map_err(failed)? }) })
    }
}
