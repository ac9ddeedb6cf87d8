//! The first surfaces that a camera's pixels meet.

use crate::{
    capture::{self, Capture, Capturing},
    engine::node::{Ctx, Node, NodeError},
    nodes::backend,
    ports,
    raster::{Geometry, Shader},
    scene::Scene,
    view::View,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Captures what a camera sees: for every pixel the first surfaces that its ray meets, each with depth, colour without light, normal, object
/// and triangle. Layers behind the first hold what the first hides (Shade et al. 1998).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Surfaces of a pixel that are kept.
    #[schemars(range(min = 1, max = 16))]
    pub layers: u32,
    /// Layers behind the first keep surfaces that turn their back to the camera too: those of closed objects are seen by other cameras.
    pub backs: bool,
    /// Keeps what the materials do with light too: occlusion, roughness, metallic and emitted light.
    pub materials: bool,
}

impl Default for Params {
    fn default() -> Self {
        Self { layers: 1, backs: false, materials: false }
    }
}

ports! {
    pub struct In {
        /// What is captured.
        scene: Arc<Scene>,
        /// From where.
        view: Arc<View>,
    }
}

ports! {
    pub struct Out {
        /// Its images.
        capture: Arc<Capture>,
    }
}

pub struct Layers;

impl Node for Layers {
    const KIND: &'static str = "peel";
    const METHOD: &'static str = "layers";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        // The view's size is not known here: as much as for 2049² pixels. `run` refuses what is larger than the budget.
        (64 << 20) + sizes[0].saturating_mul(3) + images(params, 2049 * 2049)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let (width, height) = (inputs.view.width, inputs.view.height);
        let need = images(params, u64::from(width) * u64::from(height));
        if need > ctx.memory {
            let (need, most) = (need >> 20, ctx.memory >> 20);
            return Err(NodeError::Failed(format!(
                "a capture of {width} × {height} pixels in {} layers takes {need} MiB, but the memory is limited to {most} MiB; give the views fewer pixels, or more by --memory",
                params.layers
            )));
        }
        let geometry = Geometry::new(&inputs.scene);
        let shader = if params.materials { Shader::with_finishes(&geometry) } else { Shader::new(&geometry) };
        let how = Capturing { layers: params.layers, backs: params.backs };
        let capture = capture::capture(backend(ctx), &shader, inputs.scene.bounds(), &inputs.view, how, ctx.stop)?;
        if capture.layers[0].is_empty() {
            (ctx.warn)("no pixel shows a surface: the camera looks past the scene".into());
        }
        Ok(Out { capture: Arc::new(capture) })
    }
}

/// Bytes of a capture's images while it is made: 28 a pixel and layer, and 8 more with materials, with what the rasteriser holds of them.
fn images(params: &Params, pixels: u64) -> u64 {
    pixels.saturating_mul(u64::from(params.layers) * if params.materials { 56 } else { 40 })
}
