//! What relief maps cover of their original.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    nodes::backend,
    ports,
    raster::Geometry,
    relief::{
        ReliefMap, Search, Trace,
        measure::{Coverage, Original, measure},
    },
    scene::Scene,
    view::directions::geodesic,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Draws the original and its relief maps from many directions and keeps which pixels each of them covers, so that maps can be chosen without drawing
/// anything again. Of each direction the six nearest maps are drawn. Source: Andújar et al., Omni-directional Relief Impostors, 2007, section 3.2.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Pixels along a side of the viewport, fitted to the object's projection: s0.
    #[schemars(range(min = 16, max = 4096), extend("x-unit" = "px"))]
    pub size: u32,
    /// How often the faces of an icosahedron are split in four: 2 gives the paper's 320 directions.
    #[schemars(range(min = 0, max = 4))]
    pub subdivisions: u32,
    /// How rays look for the surface.
    pub search: RaySearch,
    /// Steps of equal length of a linear search.
    #[schemars(range(min = 1, max = 1024))]
    pub steps: u32,
    /// Halvings that follow them.
    #[schemars(range(min = 0, max = 32))]
    pub halvings: u32,
    /// Neighbouring texels whose depths differ by more, in texel sides, are not connected.
    #[schemars(range(min = 0.5, max = 64.0), extend("x-unit" = "texels"))]
    pub wall: f64,
}

/// How rays look for the surface of a relief map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RaySearch {
    /// Along a pyramid of depth ranges: misses nothing, and goes on behind walls.
    #[default]
    Pyramid,
    /// The paper's: equal steps, then halvings. Thin parts can be missed, and rays end at walls.
    Linear,
}

impl Default for Params {
    fn default() -> Self {
        Self { size: 256, subdivisions: 2, search: RaySearch::Pyramid, steps: 16, halvings: 7, wall: 4.0 }
    }
}

ports! {
    pub struct In {
        /// What the maps stand in for.
        original: Arc<Scene>,
        /// The scene that it is a part of, for a region of one. What the rest of this hides need not be covered.
        whole: Option<Arc<Scene>>,
        /// The maps of all directions.
        maps: List<ReliefMap>,
    }
}

ports! {
    pub struct Out {
        /// What original and maps cover.
        coverage: Arc<Coverage>,
    }
}

pub struct MeasureCoverage;

impl Node for MeasureCoverage {
    const KIND: &'static str = "measure-coverage";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        // Seven masks of a bit a pixel for each direction; maps with their pyramids take twice their bytes; a view of the original per thread.
        let pixels = u64::from(params.size) * u64::from(params.size);
        let masks = (20_u64 << (2 * params.subdivisions)) * pixels * 7 / 8;
        let inputs = sizes.iter().sum::<u64>().saturating_mul(4);
        (64 << 20) + inputs.saturating_add(masks.saturating_mul(2)).saturating_add(pixels * 64)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let maps: Vec<(&str, &ReliefMap)> = inputs.maps.0.iter().map(|(name, map)| (&**name, &**map)).collect();
        if maps.is_empty() {
            return Err(NodeError::Failed("there is no relief map: no direction was selected".into()));
        }
        let corners = inputs.original.points();
        if corners.is_empty() {
            return Err(NodeError::Failed("the scene is empty: there is nothing to cover".into()));
        }
        let search = match params.search {
            RaySearch::Pyramid => Search::Pyramid,
            RaySearch::Linear => Search::Linear { steps: params.steps, halvings: params.halvings },
        };
        let trace = Trace { search, wall: params.wall as f32 };
        let geometry = Geometry::new(&inputs.original);
        let directions = geodesic(params.subdivisions);
        let whole = inputs.whole.as_deref().map(|scene| (Geometry::new(scene), scene.points()));
        let original = Original {
            geometry: &geometry,
            corners: &corners,
            whole: whole.as_ref().map(|(geometry, corners)| (geometry, &corners[..])),
        };
        let coverage = measure(backend(ctx), original, &maps, directions, params.size, trace, ctx.stop)?;
        Ok(Out { coverage: Arc::new(coverage) })
    }
}
