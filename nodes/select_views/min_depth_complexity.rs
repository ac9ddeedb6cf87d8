//! The direction along which a solid has the fewest layers.

use crate::{
    engine::node::{Ctx, Node, NodeError},
    nodes::{backend, peel_error, values::ChosenDirection},
    ports,
    raster::Geometry,
    scene::Scene,
    sprite,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Chooses the direction along which a solid has the fewest layers; ties go to the direction that uses most of its image. Fewer layers
/// are smaller and faster to test. Source: Trapp and Döllner, Efficient Representation of Layered Depth Images for Real-time
/// Volumetric Tests, 2008, section 4.1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Number of candidate directions, spread over a hemisphere, 1 to 4096.
    #[schemars(range(min = 1, max = 4096), extend("x-unit" = "directions"))]
    pub count: u32,
    /// The paper's steps about the x and the y axis instead of `count`, each 1 to 64; [8, 8] are 13 different axes. [] for none.
    pub grid: Vec<u32>,
    /// Width and height of the image in which a candidate is judged, texels, 16 to 4096.
    #[schemars(range(min = 16, max = 4096), extend("x-unit" = "texels"))]
    pub probe: u32,
}

impl Default for Params {
    fn default() -> Self {
        Self { count: 64, grid: Vec::new(), probe: 256 }
    }
}

ports! {
    pub struct In {
        /// The solid.
        scene: Arc<Scene>,
    }
}

ports! {
    pub struct Out {
        /// The direction, with the least and the greatest depth complexity of all candidates.
        direction: Arc<ChosenDirection>,
    }
}

pub struct MinDepthComplexity;

impl Node for MinDepthComplexity {
    const KIND: &'static str = "select-views";
    const METHOD: &'static str = "min-depth-complexity";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        (32 << 20) + sizes[0] * 4 + u64::from(params.probe).pow(2) * 64
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        if !(params.grid.is_empty() || matches!(params.grid[..], [1..=64, 1..=64])) {
            return Err((
                "grid",
                format!("expected two numbers of steps from 1 to 64, or [], found {:?}", params.grid),
            ));
        }
        Ok(())
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let geometry = Geometry::new(&inputs.scene);
        let directions = match params.grid[..] {
            [h, v] => sprite::candidates([h, v]),
            _ => sprite::spread(params.count),
        };
        let judged = sprite::judge(backend(ctx), &geometry, &directions, params.probe, ctx.stop);
        let judged = judged.map_err(peel_error)?;
        let all = || judged.iter().map(|c| c.depth_complexity);
        let depth_complexity = [all().min().unwrap_or(0), all().max().unwrap_or(0)];
        Ok(Out { direction: Arc::new(ChosenDirection { direction: judged[0].direction, depth_complexity }) })
    }
}
