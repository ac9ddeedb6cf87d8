//! Eyes on a sphere around the object.

use crate::{
    engine::node::{Ctx, Node, NodeError},
    ports,
    scene::Scene,
    view::Region,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A sphere around the scene, from whose surface the stand-in is looked at. Without a centre it lies around the middle of the bounding box;
/// without a radius this is `distance` times the box's diagonal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Metres.
    pub centre: Option<[f64; 3]>,
    /// Metres, above 0.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius: Option<f64>,
    /// Radius in diagonals of the scene's bounding box.
    #[schemars(range(min = 0.51, max = 1000.0))]
    pub distance: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self { centre: None, radius: None, distance: 1.5 }
    }
}

ports! {
    pub struct In {
        /// The scene from which a missing centre or radius is derived; only its bounding box matters.
        scene: Arc<Scene>,
    }
}

ports! {
    pub struct Out {
        /// Where eyes are.
        region: Arc<Region>,
    }
}

pub struct Sphere;

impl Node for Sphere {
    const KIND: &'static str = "view-region";
    const METHOD: &'static str = "sphere";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, _: &[u64]) -> u64 {
        1 << 20
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        match params.centre {
            Some(c) if !c.iter().all(|v| v.is_finite()) => {
                Err(("centre", format!("expected finite coordinates, found {c:?}")))
            }
            _ => Ok(()),
        }
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let bounds = inputs.scene.bounds();
        if bounds.is_empty() || !(bounds.diagonal() > 0.0) {
            return Err(NodeError::Failed("a sphere around a scene without extent".into()));
        }
        let centre = params.centre.map_or_else(|| bounds.centre(), Into::into);
        let radius = params.radius.unwrap_or(params.distance * bounds.diagonal());
        if bounds.corners().iter().any(|p| p.distance(centre) >= radius) {
            (ctx.warn)(format!(
                "the sphere of radius {radius:.4} m does not hold the whole scene: some eyes lie in it"
            ));
        }
        Ok(Out { region: Arc::new(Region::Sphere { centre, radius }) })
    }
}
