//! Textures from captured views.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    lod::{build::textured, simplified::Simplified, subject::Subject, texture::Textured, weights::Window},
    ports,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Gives a simplified mesh its textures: each face takes the view from the cell's centre where that sees it, else one of few neighbours' that together see
/// the rest. Faces that no view sees take colours of the original's vertices. Source: Chen et al. 2003, sections 3.1.4 and 3.2.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// By how much the collapse may have moved the surface, as the cell sees it: so much deeper a face may lie than its view shows.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-unit" = "px"))]
    pub moved: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self { moved: 0.5 }
    }
}

ports! {
    pub struct In {
        /// What the mesh stands for.
        stand_in: Arc<Subject>,
        /// The mesh.
        mesh: Arc<Simplified>,
        /// The views.
        windows: List<Window>,
    }
}

ports! {
    pub struct Out {
        /// The mesh with the parts of the views that it needs.
        textured: Arc<Textured>,
    }
}

pub struct Views;

impl Node for Views {
    const KIND: &'static str = "resample";
    const METHOD: &'static str = "views";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        (2 << 20) + sizes[1].saturating_mul(4) + sizes[2].saturating_mul(3)
    }

    fn run(params: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        let windows = inputs.stand_in.windows(inputs.windows.0.iter().map(|(_, w)| &**w));
        let windows = windows.map_err(|e| NodeError::from_error(&e))?;
        Ok(Out { textured: Arc::new(textured(&inputs.stand_in, &inputs.mesh, &windows, params.moved)) })
    }
}
