//! Atlases of an octahedral impostor from captures.

use crate::{
    capture::Capture,
    engine::node::{Ctx, List, Node, NodeError},
    octahedral::{Impostor, PackError, pack},
    ports,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Packs the captures of a grid of directions into the atlases of an octahedral impostor, and fits the card on which it is drawn. Colours, normals
/// and depths are dilated into empty texels; occlusion, roughness, metallic and emitted light are packed where they were captured. Over a list of objects say `per = ["split.objects"]`: one impostor for each. Source: Ryan Brucks,
/// Octahedral Impostors, 2018.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Texels along a frame's side: a power of two that divides the captures' pixels, of which each texel takes the mean. Without it one texel a
    /// pixel.
    #[schemars(range(min = 16, max = 4096), extend("x-unit" = "texels"))]
    pub tile: Option<u32>,
}

ports! {
    pub struct In {
        /// What the cameras of `select-views` `octahedral` see.
        captures: List<Capture>,
    }
}

ports! {
    pub struct Out {
        /// The atlases, with grid, window and card.
        impostor: Arc<Impostor>,
    }
}

pub struct Octahedral;

impl Node for Octahedral {
    const KIND: &'static str = "resample";
    const METHOD: &'static str = "octahedral";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // A capture takes 28 bytes a pixel and layer; a texel and what is made of it on the way 40.
        (64 << 20) + sizes.iter().fold(0_u64, |s, n| s.saturating_add(*n)).saturating_mul(2)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        match params.tile {
            Some(tile) if !tile.is_power_of_two() => {
                Err(("tile", format!("{tile}; expected a power of two from 16 to 4096 texels")))
            }
            _ => Ok(()),
        }
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let captures: Vec<(&str, &Capture)> =
            inputs.captures.0.iter().map(|(name, capture)| (name.as_str(), &**capture)).collect();
        let impostor = pack(&captures, params.tile, ctx.stop).map_err(|e| match e {
            PackError::Stopped(stopped) => NodeError::Stopped(stopped),
            e => NodeError::from_error(&e),
        })?;
        if captures.iter().all(|(_, c)| c.layers[0].is_empty()) {
            (ctx.warn)("no camera sees a surface: the impostor is empty".into());
        }
        Ok(Out { impostor: Arc::new(impostor) })
    }
}
