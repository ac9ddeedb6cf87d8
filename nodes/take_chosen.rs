//! `take-chosen`: the stand-in that was chosen for an object.

use crate::{
    engine::{
        node::{Ctx, List, Node, NodeError},
        plan::{Bundle, Relation},
    },
    ports,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Takes of an object's stand-ins the one that `choose` chose, if it chose one of them; of the stand-ins of groups where it is not mapped over objects.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {}

ports! {
    pub struct In {
        /// What was chosen, of `choose`.
        chosen: Arc<Relation>,
        /// The stand-ins under the names that `choose` knows them by: `{ impostor = "impostor.bundle", … }`, with `per = ["objects"]` where they are those of objects.
        stand_ins: List<Bundle, true>,
    }
}

ports! {
    pub struct Out {
        /// The stand-in that was chosen; none where the object is kept, part of a group, or one of another list.
        stand_in: List<Bundle, true>,
    }
}

pub struct TakeChosen;

impl Node for TakeChosen {
    const KIND: &'static str = "take-chosen";
    const VERSION: u32 = 1;
    const USES_NAME: bool = true;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, _: &[u64]) -> u64 {
        1 << 20
    }

    fn run(_: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let of = inputs.chosen.0.get(ctx.element.unwrap_or_default()).map_or(&[][..], Vec::as_slice);
        let taken = inputs.stand_ins.0.into_iter().filter(|(name, _)| of.contains(name));
        Ok(Out { stand_in: List(taken.collect()) })
    }
}
