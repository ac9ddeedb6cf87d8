//! The cameras of a stand-in of a view cell.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    lod::{subject::Subject, window::WindowCamera},
    ports,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Lists the cameras that the objects of a stand-in are captured with: at the centre of its view cell and, for meshes of several views, at the centres of the
/// neighbouring cells. Each is told about its eye, so that cells that look at an object from one point share its picture. Source: Chen et al. 2003, section 3.1.3.2.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {}

ports! {
    pub struct In {
        /// What is captured.
        stand_in: Arc<Subject>,
    }
}

ports! {
    pub struct Out {
        /// The cameras, that of the cell's centre first: `w00`, `w01`, …
        cameras: List<WindowCamera>,
    }
}

pub struct CellWindows;

impl Node for CellWindows {
    const KIND: &'static str = "select-views";
    const METHOD: &'static str = "cell-windows";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        (1 << 20) + sizes.iter().sum::<u64>().saturating_mul(4)
    }

    fn run(_: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        let cameras = inputs.stand_in.cameras.iter().enumerate();
        let named = |(i, (_, camera)): (usize, &(_, WindowCamera))| (format!("w{i:02}"), Arc::new(camera.clone()));
        Ok(Out { cameras: List(cameras.map(named).collect()) })
    }
}
