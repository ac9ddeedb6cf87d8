//! A layered depth image in the fewest values.

use crate::{
    engine::node::{Ctx, Node, NodeError},
    nodes::values::Sprite,
    ports,
    sprite::{self, DepthQuantizer, Packed, Peeled},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Crops a layered depth image to the texels that hold depths and packs it, without loss unless `depths` says so. The parity test answers on every layout
/// directly. Source: Trapp and Döllner 2008, sections 4.2 to 4.4; `rows` and `runs` are not in the paper.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// How the depths are packed.
    pub layout: Layout,
    /// What the depths of the layouts `rows` and `runs` are.
    pub depths: Depths,
}

/// What a depth is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Depths {
    /// 32-bit floats: nothing is lost.
    #[default]
    F32,
    /// 16 bits: depths change by at most 1/65536 of the cube's side, less where the solid is flat along the rays.
    U16,
}

/// How the depths are packed; n texels, h rows, d layers, r ranges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    /// That with the fewest values.
    #[default]
    Smallest,
    /// The layers as they are: n·d values.
    Raw,
    /// The paper's index and range segments in one texture: 2(n + r) values.
    Ranges,
    /// Offsets of rows and 16-bit offsets in them: h + 1 + n/2 + 2r values.
    Rows,
    /// Runs of texels with equally many ranges: h + 1 + 3·runs + 2r values.
    Runs,
}

ports! {
    pub struct In {
        /// What to pack.
        image: Arc<Peeled>,
    }
}

ports! {
    pub struct Out {
        /// The packed image with its place in the world.
        sprite: Arc<Sprite>,
    }
}

pub struct Ranges;

impl Node for Ranges {
    const KIND: &'static str = "compress";
    const METHOD: &'static str = "ranges";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // Every layout once, the layers being the largest.
        (16 << 20) + sizes[0].saturating_mul(16)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        if params.depths == Depths::U16 && matches!(params.layout, Layout::Raw | Layout::Ranges) {
            return Err(("depths", "only the layouts `rows` and `runs` have depths of 16 bits".into()));
        }
        Ok(())
    }

    fn run(params: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        let image = inputs.image.image.crop();
        let image = image.ok_or_else(|| NodeError::Failed("the image is empty: no texel holds a depth".into()))?;
        let grid = (params.depths == Depths::U16).then(|| DepthQuantizer::around(&image));
        let new = |layout| grid.map_or_else(|| Packed::new(&image, layout), |grid| Packed::short(&image, layout, grid));
        let packed = match params.layout {
            Layout::Smallest => Packed::smallest(&image, grid),
            Layout::Raw => new(sprite::Layout::Raw),
            Layout::Ranges => new(sprite::Layout::Ranges),
            Layout::Rows => new(sprite::Layout::Rows),
            Layout::Runs => new(sprite::Layout::Runs),
        };
        let packed = packed.ok_or_else(|| {
            NodeError::Failed(format!(
                "the layout {:?} cannot hold {} depths in {} texels; choose another",
                params.layout,
                image.depths().len(),
                image.region().texels()
            ))
        })?;
        Ok(Out { sprite: Arc::new(Sprite { packed, frame: inputs.image.frame }) })
    }
}
