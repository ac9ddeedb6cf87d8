//! `select-objects`: part of a scene.

use crate::{
    engine::node::{Ctx, Node, NodeError},
    math::Aabb,
    ports,
    scene::{
        Scene,
        select::{Selection, select},
    },
    view::Cell,
};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Selects part of a scene by name, position and distance. The selection says what is to be replaced; visibility is decided later by
/// the renderer. Objects that are not selected do not enter the output, so moving one re-runs nothing downstream.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Names to keep; `*` stands for any text, `?` for any one character. One pattern must match.
    pub include: Vec<String>,
    /// Names to leave out, as patterns; they take precedence over `include`.
    pub exclude: Vec<String>,
    /// Two corners, metres: `[[x, y, z], [x, y, z]]`. Objects whose bounds do not touch this box are left out.
    pub region: Option<[[f64; 3]; 2]>,
    /// Objects whose bounds are nearer to the cell than this are left out, metres. Needs `cell`.
    #[schemars(range(min = 0.0), extend("x-unit" = "m"))]
    pub min_distance: Option<f64>,
    /// Objects whose bounds are as far from the cell as this or farther are left out, metres. Needs `cell`.
    #[schemars(range(min = 0.0), extend("x-unit" = "m"))]
    pub max_distance: Option<f64>,
}

impl Default for Params {
    fn default() -> Self {
        Self { include: vec!["*".into()], exclude: Vec::new(), region: None, min_distance: None, max_distance: None }
    }
}

ports! {
    pub struct In {
        /// The whole scene.
        scene: Arc<Scene>,
        /// The view cell from which distances are measured.
        cell: Option<Arc<Cell>>,
    }
}

ports! {
    pub struct Out {
        /// The selected objects.
        scene: Arc<Scene>,
    }
}

pub struct SelectObjects;

impl Node for SelectObjects {
    const KIND: &'static str = "select-objects";
    const VERSION: u32 = 2;
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
        if let (Some(min), Some(max)) = (params.min_distance, params.max_distance)
            && min >= max
        {
            return Err(("max_distance", format!("{max} m is not beyond min_distance, {min} m")));
        }
        Ok(())
    }

    fn run(params: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        let region = params.region.map(|[a, b]| {
            let (a, b) = (DVec3::from(a), DVec3::from(b));
            Aabb { min: a.min(b), max: a.max(b) }
        });
        let (include, exclude) = (params.include.clone(), params.exclude.clone());
        let ranged = params.min_distance.is_some() || params.max_distance.is_some();
        let distance = match (&inputs.cell, ranged) {
            (_, false) => None,
            (None, true) => return Err(NodeError::Failed("min_distance and max_distance need the port `cell`".into())),
            (Some(cell), true) => {
                let bounds = Aabb { min: cell.centre - cell.half, max: cell.centre + cell.half };
                Some((bounds, params.min_distance.unwrap_or(0.0), params.max_distance.unwrap_or(f64::INFINITY)))
            }
        };
        let selection = Selection { include, exclude, region, distance };
        let scene = select(&inputs.scene, &selection).map_err(|e| NodeError::from_error(&e))?;
        Ok(Out { scene: Arc::new(scene) })
    }
}
