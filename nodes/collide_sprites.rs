//! `collide-sprites`: which solids share space.

use super::{
    json_file,
    values::Sprite,
    volumes::{self, SpritePlace},
};
use crate::{
    engine::{
        node::{Ctx, List, Node, NodeError},
        plan::File,
    },
    ports,
    sprite::overlap,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::sync::Arc;

/// Tests every pair of depth sprites for collision: the ranges of one are clipped against the other as rays, which gives
/// whether they overlap, the shared volume, and where it lies. Source: Trapp and Döllner 2008, section 3.3; the rays are their future work.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Where sprites are put; [] leaves each where its solid was, under its own name.
    pub places: Vec<SpritePlace>,
}

ports! {
    pub struct In {
        /// The sprites, by name.
        sprites: List<Sprite>,
    }
}

ports! {
    pub struct Out {
        /// For each pair that collides the shared volume (m³) and its bounds (m), JSON.
        report: Arc<File>,
    }
}

pub struct CollideSprites;

impl Node for CollideSprites {
    const KIND: &'static str = "collide-sprites";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        (16 << 20) + sizes.iter().sum::<u64>().saturating_mul(4)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        volumes::check(&params.places)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let volumes = volumes::volumes(&params.places, &inputs.sprites)?;
        let mut pairs = Vec::new();
        for (i, (a, of_a)) in volumes.iter().enumerate() {
            for (b, of_b) in &volumes[i + 1..] {
                let found = if of_a.bounds().overlaps(&of_b.bounds()) {
                    Some(overlap(of_a, of_b, ctx.stop)?).filter(|o| o.collides())
                } else {
                    None
                };
                pairs.push(match found {
                    Some(o) => json!({
                        "a": a, "b": b, "collide": true, "volume": o.volume,
                        "bounds": [o.bounds.min.to_array(), o.bounds.max.to_array()],
                    }),
                    None => json!({ "a": a, "b": b, "collide": false, "volume": 0.0 }),
                });
            }
        }
        let colliding = pairs.iter().filter(|p| p["collide"] == true).count();
        let report = json!({ "pairs": pairs, "colliding_pairs": colliding });
        Ok(Out { report: json_file(&report)? })
    }
}
