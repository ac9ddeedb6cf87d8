//! `split-objects`: a scene as a list of its objects.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    ports,
    scene::Scene,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Splits a scene into one scene per object; the nodes after it run once per object. It is a separate kind rather than an
/// output of `select-objects`, because every element is stored with its own copy of its textures.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {}

ports! {
    pub struct In {
        /// The scene to split.
        scene: Arc<Scene>,
    }
}

ports! {
    pub struct Out {
        /// The objects, under their names in the scene.
        objects: List<Scene>,
    }
}

pub struct SplitObjects;

impl Node for SplitObjects {
    const KIND: &'static str = "split-objects";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, _: &[u64]) -> u64 {
        // Objects share what they show with the scene.
        1 << 20
    }

    fn run(_: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        let one = |o: &crate::scene::Object| (o.name.clone(), Arc::new(Scene { objects: vec![o.clone()] }));
        Ok(Out { objects: List(inputs.scene.objects.iter().map(one).collect()) })
    }
}
