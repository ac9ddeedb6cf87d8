//! `lod-levels`: simplified meshes of an object for every distance.

use crate::{
    engine::node::{Ctx, Node, NodeError},
    lod::levels::{Levels, levels},
    ports,
    scene::Scene,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Simplifies an object again and again, each time within twice the error, by meshoptimizer. Stand-ins for far cells start from a level that differs from the
/// original by a fraction of a pixel instead of from the original, which costs a fraction of the time. The first level is the original with vertices of one
/// position joined.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Levels, at most; 1 gives the original only.
    #[schemars(range(min = 1, max = 11))]
    pub most: u32,
}

impl Default for Params {
    fn default() -> Self {
        Self { most: 11 }
    }
}

ports! {
    pub struct In {
        /// The object.
        shape: Arc<Scene>,
    }
}

ports! {
    pub struct Out {
        /// Its meshes, finest first; none where it has no triangles.
        levels: Arc<Levels>,
    }
}

pub struct LodLevels;

impl Node for LodLevels {
    const KIND: &'static str = "lod-levels";
    const VERSION: u32 = 1;
    const NATIVE: bool = true;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        (8 << 20) + sizes[0].saturating_mul(6)
    }

    fn run(params: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        // An object without triangles has no outline, so no stand-in asks for its levels.
        let levels = levels(&inputs.shape, params.most).unwrap_or_else(Levels::empty);
        Ok(Out { levels: Arc::new(levels) })
    }
}
