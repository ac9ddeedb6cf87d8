//! All depths of a solid along one direction.

use crate::{
    engine::node::{Ctx, Node, NodeError},
    nodes::{backend, peel_error, samples_per_side, values::ChosenDirection},
    ports,
    raster::{Geometry, MAX_SIDE},
    scene::Scene,
    sprite::{self, Direction, Peeled, Peeling, Repair},
};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Peels a solid: every ray through the unit cube around it keeps all depths at which it crosses the surface, equal ones too. A
/// surface that is not closed gives rays that cross it an odd number of times; they are counted, named, and treated as
/// `repair` says. Source: Trapp and Döllner 2008, section 3.1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Texels along a side of the image, 1 to 16384.
    #[schemars(range(min = 1, max = 16384), extend("x-unit" = "texels"))]
    pub resolution: u32,
    /// Rays in a texel: 1, 4 or 16. With more than one a texel holds what at least half of its rays hold: no thin part is decided by one ray;
    /// `resolution` times their root may not exceed 16384.
    pub samples: u32,
    /// What happens to rays that cross the surface an odd number of times.
    pub repair: Repair,
}

impl Default for Params {
    fn default() -> Self {
        Self { resolution: 1024, samples: 1, repair: Repair::None }
    }
}

ports! {
    pub struct In {
        /// The solid. Where shapes overlap, inside is what an odd number of them holds.
        scene: Arc<Scene>,
        /// Along which direction; without it along −Z.
        direction: Option<Arc<ChosenDirection>>,
    }
}

ports! {
    pub struct Out {
        /// The layered depth image with its place in the world.
        image: Arc<Peeled>,
    }
}

pub struct Solid;

impl Node for Solid {
    const KIND: &'static str = "peel";
    const METHOD: &'static str = "solid";
    const VERSION: u32 = 3;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        // Per texel its list, and some depths twice.
        (32 << 20) + sizes[0] * 4 + u64::from(params.resolution).pow(2) * 100
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        let Some(side) = samples_per_side(params.samples) else {
            return Err(("samples", format!("expected 1, 4 or 16, found {}", params.samples)));
        };
        if params.resolution * side > MAX_SIDE {
            let what =
                format!("{} texels of {side} × {side} rays are more than {MAX_SIDE} in a row", params.resolution);
            return Err(("samples", what));
        }
        Ok(())
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let geometry = Geometry::new(&inputs.scene);
        let chosen = inputs.direction.map(|d| d.direction).or_else(|| Direction::new(DVec3::NEG_Z));
        let direction = chosen.ok_or_else(|| NodeError::Failed("no direction".into()))?;
        let how = Peeling {
            resolution: params.resolution,
            samples: samples_per_side(params.samples).unwrap_or(1),
            repair: params.repair,
        };
        let peeled = sprite::peel(backend(ctx), &geometry, &direction, &how, ctx.stop);
        let peeled = peeled.map_err(peel_error)?;
        if let Some(first) = peeled.odd.first() {
            let open = sprite::closedness(&geometry).open_edges;
            (ctx.warn)(format!(
                "{} rays cross the surface an odd number of times, the first at texel ({}, {}); it has {open} open edges",
                peeled.odd.len(),
                first.texel[0],
                first.texel[1]
            ));
        }
        Ok(Out { image: Arc::new(peeled) })
    }
}
