//! Relief maps from captures.

use crate::{
    capture::Capture,
    engine::node::{Ctx, Node, NodeError},
    ports,
    relief::{self, DepthBits, ReliefMap, Resampling},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Makes a relief map of what an orthographic camera saw: a height field with colour and normals. Outlines are kept to a sixteenth of a texel: texels
/// without surface say how far the surface beside them reaches. Source: Andújar et al., Omni-directional Relief Impostors, 2007, section 3.1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Pixels of the capture along a side of a texel. More of them make outlines and colours more exact.
    #[schemars(range(min = 1, max = 16))]
    pub samples: u32,
    /// Bits of a depth: 8 as in the paper, or 16, which take twice the memory.
    #[schemars(range(min = 8, max = 16))]
    pub depth_bits: u32,
}

impl Default for Params {
    fn default() -> Self {
        Self { samples: 2, depth_bits: 8 }
    }
}

ports! {
    pub struct In {
        /// What one orthographic camera sees; its first layer is used.
        capture: Arc<Capture>,
    }
}

ports! {
    pub struct Out {
        /// Its relief map.
        relief: Arc<ReliefMap>,
    }
}

pub struct Relief;

impl Node for Relief {
    const KIND: &'static str = "resample";
    const METHOD: &'static str = "relief";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // A capture takes 28 bytes a pixel and layer; averages, masks and images of the map are less than that.
        (4 << 20) + sizes[0].saturating_mul(2)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        match params.depth_bits {
            8 | 16 => Ok(()),
            other => Err(("depth_bits", format!("{other}; expected 8 or 16"))),
        }
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let bits = if params.depth_bits == 8 { DepthBits::Eight } else { DepthBits::Sixteen };
        let how = Resampling { samples: params.samples, bits };
        ctx.stop.check()?;
        let map = relief::resample(&inputs.capture, how).map_err(|e| NodeError::from_error(&e))?;
        Ok(Out { relief: Arc::new(map) })
    }
}
