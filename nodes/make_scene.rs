//! `make-scene`: a procedural scene.

use crate::{
    engine::node::{Ctx, Node, NodeError},
    ports,
    scene::{Scene, builtin},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Generates a procedural scene from a seed: the same on every machine, without any file. The city and the car have
/// the size and the triangle count of the two models in table 1 of Jeschke and Wimmer 2002.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Which scene to generate.
    pub what: What,
    /// Seed of the random generator.
    pub seed: u64,
}

impl Default for Params {
    fn default() -> Self {
        Self { what: What::City, seed: 1 }
    }
}

/// The procedural scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum What {
    /// 450 × 450 × 50 m, about 700 objects, 158,944 triangles.
    City,
    /// 4.7 × 1.8 × 1.5 m, about 1,188 triangles.
    Car,
    /// A box, a sphere and a torus, all closed.
    Solids,
}

ports! {
    pub struct In {}
}

ports! {
    pub struct Out {
        /// The scene.
        scene: Arc<Scene>,
    }
}

pub struct MakeScene;

impl Node for MakeScene {
    const KIND: &'static str = "make-scene";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, _: &[u64]) -> u64 {
        64 << 20
    }

    fn run(params: &Params, _: In, _: &Ctx) -> Result<Out, NodeError> {
        let name = match params.what {
            What::City => "city",
            What::Car => "car",
            What::Solids => "solids",
        };
        let scene = builtin::make(name, params.seed)
            .ok_or_else(|| NodeError::Failed(format!("no procedural scene `{name}`")))?;
        Ok(Out { scene: Arc::new(scene) })
    }
}
