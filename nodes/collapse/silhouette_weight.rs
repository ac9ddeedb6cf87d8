//! Simplification of what a cell sees of objects.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    lod::{
        build::{CostKind, Simplifying, simplify},
        faces::Facing,
        levels::Levels,
        pixels::{Steps, Unit},
        simplified::Simplified,
        subject::Subject,
        weights::Window,
    },
    ports,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Simplifies the objects of a stand-in for its cell: faces that turn their backs to all of it go, edges are collapsed where the cell sees it least, outlines last. The
/// cost `paper` is that of Chen et al. 2003, sections 3.1.3 and 3.1.4; `parallax` measures how many pixels the picture moves as the eye moves through the cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// What a collapse is judged by.
    pub cost: CostKind,
    /// Cost `parallax`: no collapse moves the surface by more than this, as the cell sees it.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-unit" = "px"))]
    pub tolerance: f64,
    /// Cost `paper`: T_l, beyond which no edge is collapsed.
    #[schemars(range(min = 0.0, max = 1e6), extend("x-unit" = "px"))]
    pub t_l: f64,
    /// Cost `paper`: e in (1.5 − n_i·n_j)^e. The paper's text has lost its superscripts.
    #[schemars(range(min = 0.0, max = 16.0))]
    pub exponent: f64,
    /// Which faces meshes of one view keep. Meshes of several views keep those that face the cell.
    pub facing: Facing,
    /// T_C0: a step between neighbouring pixels that is an inner outline, in `unit`.
    #[schemars(range(min = 0.0, max = 1e9))]
    pub t_c0: f64,
    /// T_C1: a change of slope between neighbouring pixels that is an edge, in `unit`.
    #[schemars(range(min = 0.0, max = 1e9))]
    pub t_c1: f64,
    /// Of `t_c0` and `t_c1`: footprints of a pixel, or values of a depth buffer, as which the paper's 3.4e-4 and 1.28e-4 can be read.
    pub unit: Unit,
    /// By how much the mesh that the collapse starts from may differ from the original, as the cell sees it. 0 starts from the original.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-unit" = "px"))]
    pub start: f64,
    /// The collapse ends at so many triangles; 0 for no limit.
    #[schemars(range(max = 1_000_000_000), extend("x-unit" = "triangles"))]
    pub triangles: u32,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            cost: CostKind::Parallax,
            tolerance: 0.35,
            t_l: 4.5,
            exponent: 2.0,
            facing: Facing::Cell,
            t_c0: 8.0,
            t_c1: 3.0,
            unit: Unit::Footprint,
            start: 0.1,
            triangles: 0,
        }
    }
}

ports! {
    pub struct In {
        /// What is simplified.
        stand_in: Arc<Subject>,
        /// The meshes of its objects.
        levels: List<Levels>,
        /// What the cell's cameras see of it.
        windows: List<Window>,
    }
}

ports! {
    pub struct Out {
        /// The mesh about the cell's centre. It is empty where no face looks at the cell.
        mesh: Arc<Simplified>,
    }
}

pub struct SilhouetteWeight;

impl Node for SilhouetteWeight {
    const KIND: &'static str = "collapse";
    const METHOD: &'static str = "silhouette-weight";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        (4 << 20) + sizes[1].saturating_mul(8) + sizes[2].saturating_mul(2)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let level = |(name, _): &(String, _)| {
            let found = inputs.levels.0.iter().find(|(n, _)| n == name).map(|(_, l)| &**l);
            found.ok_or_else(|| NodeError::Failed(format!("the object `{name}` has no levels")))
        };
        let levels: Vec<&Levels> = inputs.stand_in.members.iter().map(level).collect::<Result<_, _>>()?;
        let how = Simplifying {
            cost: params.cost,
            facing: params.facing,
            steps: Steps { t_c0: params.t_c0, t_c1: params.t_c1, unit: params.unit },
            exponent: params.exponent,
            t_l: params.t_l,
            tolerance: params.tolerance,
            start: params.start,
            triangles: params.triangles as usize,
        };
        let windows = inputs.stand_in.windows(inputs.windows.0.iter().map(|(_, w)| &**w));
        let windows = windows.map_err(|e| NodeError::from_error(&e))?;
        Ok(Out { mesh: Arc::new(simplify(&inputs.stand_in, &levels, &windows, &how, ctx.stop)?) })
    }
}
