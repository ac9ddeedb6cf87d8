//! Relief maps as textures.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    ports,
    relief::{
        ReliefMap,
        textures::{self, CompressError, Compression},
    },
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Makes texture arrays of relief maps: depth in 8 bits (16 where the maps have them), normals as BC5, colours and materials as BC1, with mip levels into
/// which nothing bleeds from outside the object: 2.5 bytes a texel. Source: Andújar et al., Omni-directional Relief Impostors, 2007, section 4.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// How colours, normals and materials are stored.
    pub encoding: Encoding,
    /// Mip levels of each image at most; depth has one.
    #[schemars(range(min = 1, max = 16))]
    pub levels: u32,
}

/// How texels are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Encoding {
    /// BC1 and BC5.
    #[default]
    Blocks,
    /// RGBA8 and RG8: 6 bytes a texel in place of 1.5.
    Plain,
}

impl Default for Params {
    fn default() -> Self {
        Self { encoding: Encoding::Blocks, levels: 16 }
    }
}

ports! {
    pub struct In {
        /// Maps of one size, by name.
        maps: List<ReliefMap>,
    }
}

ports! {
    pub struct Out {
        /// Their textures; layers are in the order of the maps' names.
        textures: Arc<textures::Textures>,
    }
}

pub struct Textures;

impl Node for Textures {
    const KIND: &'static str = "compress";
    const METHOD: &'static str = "textures";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // The levels of one image of all maps before they are encoded, in 32 bits a channel and again in 8.
        (32 << 20) + sizes.iter().sum::<u64>().saturating_mul(6)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let maps: Vec<&ReliefMap> = inputs.maps.0.iter().map(|(_, map)| &**map).collect();
        let how = Compression { blocks: params.encoding == Encoding::Blocks, levels: params.levels };
        let textures = textures::compress(&maps, how, ctx.stop).map_err(|e| match e {
            CompressError::Stopped(stopped) => NodeError::Stopped(stopped),
            e => NodeError::from_error(&e),
        })?;
        Ok(Out { textures: Arc::new(textures) })
    }
}
