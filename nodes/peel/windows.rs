//! What the cameras of a stand-in see of its objects.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    lod::{render, subject::Subject, weights::Windows as Captured},
    nodes::backend,
    ports,
    scene::{Object, Scene},
};
use glam::DMat4;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Captures the objects of a stand-in from the centre of its cell and, for meshes of several views, from the centres of the neighbouring cells: colour without light,
/// and depth, of the window that holds them. Source: Chen et al. 2003, sections 3.1.3 and 3.1.4.
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
        /// What is captured, and the cameras.
        stand_in: Arc<Subject>,
        /// The shapes of its objects.
        shapes: List<Scene>,
    }
}

ports! {
    pub struct Out {
        /// The images.
        windows: Arc<Captured>,
    }
}

pub struct Windows;

impl Node for Windows {
    const KIND: &'static str = "peel";
    const METHOD: &'static str = "windows";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        // The cameras' sizes are not known here: as much as for 512² pixels. `run` refuses what is larger than the budget.
        (8 << 20) + sizes[1].saturating_mul(2) + images(params, 512 * 512)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let pixels = inputs.stand_in.cameras.iter().map(|v| u64::from(v.width) * u64::from(v.height));
        let (most, all) = pixels.fold((0, 0), |(most, all): (u64, u64), n| (most.max(n), all + n));
        let need = images(params, most) + all * 8;
        if need > ctx.memory {
            return Err(NodeError::Failed(format!(
                "its windows of up to {most} pixels take {} MiB, but the memory is limited to {} MiB; give a smaller `resolution`, or more by --memory",
                need >> 20,
                ctx.memory >> 20
            )));
        }
        let object = |(name, transform): &(String, glam::DAffine3)| {
            let shape = inputs.shapes.0.iter().find(|(n, _)| n == name).and_then(|(_, s)| s.objects.first());
            let shape = shape.ok_or_else(|| NodeError::Failed(format!("the object `{name}` has no shape")))?;
            Ok(Object { name: name.clone(), transform: DMat4::from(*transform).as_mat4(), parts: shape.parts.clone() })
        };
        let objects = inputs.stand_in.members.iter().map(object).collect::<Result<_, NodeError>>()?;
        let windows =
            render::windows(backend(ctx), &Scene { objects }, &inputs.stand_in.cameras, params.samples, ctx.stop)?;
        Ok(Out { windows: Arc::new(windows) })
    }
}

/// Bytes of the images of one window while it is made.
fn images(params: &Params, pixels: u64) -> u64 {
    pixels.saturating_mul(u64::from(params.samples * params.samples) * 40 + 16)
}
