//! What a camera of a stand-in sees of its objects.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    lod::{render, weights::Window, window::WindowCamera},
    nodes::backend,
    ports,
    scene::{Part, Scene},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Captures the objects of a stand-in with one of its cameras: colour without light, and depth, of the window that holds them. Cells that look from the same
/// point share the result. Source: Chen et al. 2003, sections 3.1.3 and 3.1.4.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Samples of a pixel in x and in y, whose colours are averaged.
    #[schemars(range(min = 1, max = 4))]
    pub samples: u32,
}

impl Default for Params {
    fn default() -> Self {
        Self { samples: 2 }
    }
}

ports! {
    pub struct In {
        /// The camera, and what it looks at.
        camera: Arc<WindowCamera>,
        /// The shapes of its objects.
        shapes: List<Scene>,
    }
}

ports! {
    pub struct Out {
        /// The images.
        window: Arc<Window>,
    }
}

pub struct Windows;

impl Node for Windows {
    const KIND: &'static str = "peel";
    const METHOD: &'static str = "windows";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        // The camera's size is not known here: as much as for 512² pixels. `run` refuses what is larger than the budget.
        (8 << 20) + sizes[1].saturating_mul(2) + images(params, 512 * 512)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let view = &inputs.camera.view;
        let need = images(params, u64::from(view.width) * u64::from(view.height));
        if need > ctx.memory {
            return Err(NodeError::Failed(format!(
                "its window of {} × {} pixels takes {} MiB, but the memory is limited to {} MiB; give a smaller `resolution`, or more by --memory",
                view.width,
                view.height,
                need >> 20,
                ctx.memory >> 20
            )));
        }
        let parts = |(name, _): &(String, _)| {
            let shape = inputs.shapes.0.iter().find(|(n, _)| n == name).and_then(|(_, s)| s.objects.first());
            shape.map(|s| &s.parts[..]).ok_or_else(|| NodeError::Failed(format!("the object `{name}` has no shape")))
        };
        let shapes: Vec<&[Part]> = inputs.camera.members.iter().map(parts).collect::<Result<_, _>>()?;
        let window = render::window(backend(ctx), &inputs.camera, &shapes, params.samples, ctx.stop)?;
        Ok(Out { window: Arc::new(window) })
    }
}

/// Bytes of the images of one window while it is made.
fn images(params: &Params, pixels: u64) -> u64 {
    pixels.saturating_mul(u64::from(params.samples * params.samples) * 40 + 24)
}
