//! Relief impostors as a bundle.

use crate::{
    engine::{
        node::{Ctx, List, Node, NodeError},
        plan::Bundle,
    },
    nodes::bundle,
    ports,
    relief::{ReliefMap, Strategy, measure::Selection, textures::Textures},
    runtime::ori::{self, Drawing, Extras, Ori},
    scene::Scene,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Writes relief maps and their selection as one stand-in: `ori.json` with cameras, the maps of each direction and the size up to which they may be used;
/// the maps as texture arrays in KTX2 and DDS; the shaders that draw them; a picture of all maps; and `cards.glb`, an approximation that any viewer opens.
/// Source: Andújar et al., Omni-directional Relief Impostors, 2007.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Which of several maps decides a pixel: strategies 1 to 5 of the paper's section 3.3.
    pub strategy: Strategy,
    /// Writes DDS files beside the KTX2 files.
    pub dds: bool,
    /// Writes the shaders.
    pub shaders: bool,
}

impl Default for Params {
    fn default() -> Self {
        Self { strategy: Strategy::Direction, dds: true, shaders: true }
    }
}

ports! {
    pub struct In {
        /// What the impostor stands in for; only its bounding box matters.
        original: Arc<Scene>,
        /// The maps by name.
        maps: List<ReliefMap>,
        /// The maps of each direction.
        selection: Arc<Selection>,
        /// The maps' textures.
        textures: Arc<Textures>,
    }
}

ports! {
    pub struct Out {
        /// The stand-in's files; `ori.json` is the one to open first.
        bundle: Arc<Bundle>,
    }
}

pub struct OriNode;

impl Node for OriNode {
    const KIND: &'static str = "write";
    const METHOD: &'static str = "ori";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // Textures are written twice, with a copy of each file.
        (64 << 20) + sizes.iter().sum::<u64>().saturating_mul(5)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let maps: Vec<(String, ReliefMap)> =
            inputs.maps.0.iter().map(|(name, map)| (name.clone(), (**map).clone())).collect();
        let selection = &*inputs.selection;
        if !selection.maps.iter().eq(maps.iter().map(|m| &m.0)) {
            return Err(NodeError::Failed("the selection was made for other maps than these".into()));
        }
        if inputs.textures.color.layers as usize != maps.len() {
            let (layers, maps) = (inputs.textures.color.layers, maps.len());
            return Err(NodeError::Failed(format!("textures of {layers} layers for {maps} maps")));
        }
        ctx.stop.check()?;
        let ori = Ori {
            maps,
            directions: selection.directions.clone(),
            subsets: selection.subsets.iter().map(|s| s.maps.clone()).collect(),
            bounds: inputs.original.bounds(),
            plt: selection.plt(),
            drawing: Drawing { trace: selection.trace, strategy: params.strategy },
        };
        let written =
            ori::write(&ori, selection, &inputs.textures, Extras { dds: params.dds, shaders: params.shaders })
                .map_err(|e| NodeError::from_error(&e))?;
        Ok(Out { bundle: bundle(written)? })
    }
}
