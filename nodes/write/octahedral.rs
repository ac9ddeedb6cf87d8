//! An octahedral impostor as a bundle.

use crate::{
    engine::{
        node::{Ctx, Node, NodeError},
        plan::Bundle,
    },
    nodes::bundle,
    octahedral::Impostor,
    ports,
    runtime::octahedral::{self, Drawing, Textures},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Writes an octahedral impostor as a stand-in: `octahedral.json` with grid, window, card and conventions; the atlases in the layout that
/// engines' impostor shaders expect; `octahedral.glb`, crossed cards for ordinary viewers; the shaders that blend the frames. Source: Ryan Brucks,
/// Octahedral Impostors, 2018.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Steps in which a ray is followed through a frame's depths, before the one in which it meets the surface is bisected. 0 shows the frames as
    /// flat pictures.
    #[schemars(range(min = 0, max = 64), extend("x-unit" = "steps"))]
    pub steps: u32,
    /// Writes KTX2 files beside the PNGs, with all mip levels: colours in BC3, normals and depths as they are.
    pub ktx2: bool,
    /// Writes the same as DDS files.
    pub dds: bool,
}

impl Default for Params {
    fn default() -> Self {
        Self { steps: Drawing::default().steps, ktx2: true, dds: false }
    }
}

ports! {
    pub struct In {
        /// The impostor.
        impostor: Arc<Impostor>,
    }
}

ports! {
    pub struct Out {
        /// The stand-in's files; `octahedral.json` is the one to open first.
        bundle: Arc<Bundle>,
    }
}

pub struct Octahedral;

impl Node for Octahedral {
    const KIND: &'static str = "write";
    const METHOD: &'static str = "octahedral";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // The mip levels, the files of all images at once, and what encoding takes.
        (64 << 20) + sizes.iter().fold(0_u64, |s, n| s.saturating_add(*n)).saturating_mul(4)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        ctx.stop.check()?;
        let drawing = Drawing { steps: params.steps };
        let textures = Textures { ktx2: params.ktx2, dds: params.dds };
        let files = octahedral::write(&inputs.impostor, &drawing, textures).map_err(|e| NodeError::from_error(&e))?;
        Ok(Out { bundle: bundle(files)? })
    }
}
