//! The best maps of each direction.

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

/// Chooses for each direction the fewest of the six nearest relief maps that together miss no more than a share of the viewport's pixels; of equally many
/// those that miss least. Where all six miss more, all six are used. Source: Andújar et al., Omni-directional Relief Impostors, 2007, section 3.2, ii.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Missing pixels over all pixels of the viewport.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub goal: f64,
    /// In so many directions nearest to its own a choice must miss no more than twice the goal, so that it holds between directions; 0 is the paper's choice.
    #[schemars(range(min = 0, max = 16))]
    pub neighbours: u32,
}

impl Default for Params {
    fn default() -> Self {
        Self { goal: 0.002, neighbours: 3 }
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

pub struct Best;

impl Node for Best {
    const KIND: &'static str = "select-impostors";
    const METHOD: &'static str = "best";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        (1 << 20) + sizes[0].saturating_mul(2)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let selection = inputs.coverage.select(Choice::Best { goal: params.goal, neighbours: params.neighbours });
        let beyond = selection.beyond_goal();
        if beyond > 0 {
            (ctx.warn)(format!(
                "{beyond} of {} directions miss more than {:.3} % of the viewport with all six maps; the impostor may be used up to {:.0} px",
                selection.directions.len(),
                params.goal * 100.0,
                selection.plt()
            ));
        }
        Ok(Out { selection: Arc::new(selection) })
    }
}
