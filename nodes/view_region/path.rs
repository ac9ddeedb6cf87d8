//! Eyes along a path.

use crate::{
    engine::node::{Ctx, Node, NodeError},
    ports,
    view::Region,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A path of straight lines from point to point, along which the stand-in is looked at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// At least one, metres: `[[0, 1.7, 5], [3, 1.7, 5]]`.
    pub points: Vec<[f64; 3]>,
}

/// One eye at the origin.
impl Default for Params {
    fn default() -> Self {
        Self { points: vec![[0.0; 3]] }
    }
}

ports! {
    pub struct In {}
}

ports! {
    pub struct Out {
        /// Where eyes are.
        region: Arc<Region>,
    }
}

pub struct Path;

impl Node for Path {
    const KIND: &'static str = "view-region";
    const METHOD: &'static str = "path";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, _: &[u64]) -> u64 {
        1 << 20
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        if params.points.is_empty() {
            return Err(("points", "expected at least one point".into()));
        }
        match params.points.iter().find(|p| !p.iter().all(|v| v.is_finite())) {
            Some(p) => Err(("points", format!("expected finite coordinates, found {p:?}"))),
            None => Ok(()),
        }
    }

    fn run(params: &Params, _: In, _: &Ctx) -> Result<Out, NodeError> {
        let points = params.points.iter().copied().map(Into::into).collect();
        Ok(Out { region: Arc::new(Region::Path(points)) })
    }
}
