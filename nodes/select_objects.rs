//! `select-objects`: part of a scene.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    math::Aabb,
    ports,
    scene::{
        Scene,
        select::{Selection, select},
    },
};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Selects part of a scene by name and place. It says what is meant to be replaced, not what can be seen: that is the
/// renderer's business. What is not selected leaves no trace: moving it changes nothing downstream.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Names to keep; `*` stands for any text, `?` for any one character. One pattern must match.
    pub include: Vec<String>,
    /// Names to leave out, as patterns; they win over `include`.
    pub exclude: Vec<String>,
    /// Two corners, metres: `[[x, y, z], [x, y, z]]`. Objects whose bounds do not touch this box are left out.
    pub region: Option<[[f64; 3]; 2]>,
}

impl Default for Params {
    fn default() -> Self {
        Self { include: vec!["*".into()], exclude: Vec::new(), region: None }
    }
}

ports! {
    pub struct In {
        /// The whole scene.
        scene: Arc<Scene>,
    }
}

ports! {
    pub struct Out {
        /// The selected objects as one scene.
        scene: Arc<Scene>,
        /// The selected objects one by one, under their names.
        objects: List<Scene>,
    }
}

pub struct SelectObjects;

impl Node for SelectObjects {
    const KIND: &'static str = "select-objects";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, _: &[u64]) -> u64 {
        // What is selected is shared, not copied.
        1 << 20
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        if params.include.is_empty() {
            return Err(("include", "no pattern: nothing can be selected".into()));
        }
        if let Some(corners) = &params.region
            && !corners.iter().flatten().all(|v| v.is_finite())
        {
            return Err(("region", "its corners must be finite".into()));
        }
        Ok(())
    }

    fn run(params: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        let region = params.region.map(|[a, b]| {
            let (a, b) = (DVec3::from(a), DVec3::from(b));
            Aabb { min: a.min(b), max: a.max(b) }
        });
        let (include, exclude) = (params.include.clone(), params.exclude.clone());
        let selection = Selection { include, exclude, region, distance: None };
        let scene = select(&inputs.scene, &selection).map_err(|e| NodeError::from_error(&e))?;
        let one = |o: &crate::scene::Object| (o.name.clone(), Arc::new(Scene { objects: vec![o.clone()] }));
        let objects = List(scene.objects.iter().map(one).collect());
        Ok(Out { scene: Arc::new(scene), objects })
    }
}
