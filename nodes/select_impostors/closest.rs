//! The nearest maps of each direction.

use crate::{
    engine::node::{Ctx, Node, NodeError},
    ports,
    relief::{
        measure::{Coverage, Selection},
        select::Choice,
    },
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Takes for each direction the maps whose cameras lie nearest to it. Source: Andújar et al., Omni-directional Relief Impostors, 2007, section 3.2, i.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// How many: m.
    #[schemars(range(min = 1, max = 6))]
    pub count: u32,
}

impl Default for Params {
    fn default() -> Self {
        Self { count: 3 }
    }
}

ports! {
    pub struct In {
        /// What original and maps cover.
        coverage: Arc<Coverage>,
    }
}

ports! {
    pub struct Out {
        /// The maps of each direction.
        selection: Arc<Selection>,
    }
}

pub struct Closest;

impl Node for Closest {
    const KIND: &'static str = "select-impostors";
    const METHOD: &'static str = "closest";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        (1 << 20) + sizes[0].saturating_mul(2)
    }

    fn run(params: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        Ok(Out { selection: Arc::new(inputs.coverage.select(Choice::Closest(params.count))) })
    }
}
