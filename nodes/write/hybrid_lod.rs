//! The manifest of hybrid textured LOD meshes.

use crate::{
    engine::{
        node::{Ctx, List, Node, NodeError},
        plan::Bundle,
    },
    lod::entry::Entry,
    nodes::{bundle, json_bytes},
    ports,
    runtime::{
        BundleFile,
        hybrid_lod::{MANIFEST, Manifest, SHADERS},
        shader_files,
    },
    view::HexGrid,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Writes what a program needs to walk through the cells: the grid, and for each cell its neighbours, the objects that are drawn as they are, its stand-ins and the
/// sizes of its files; beside it the shader that draws stand-ins with projective texture coordinates, in WGSL, GLSL, HLSL, Metal and SPIR-V. `[files]` publishes the cells' files beside it: `"cells/{name}.glb"` and `"cells/{name}.ktx2"`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {}

ports! {
    pub struct In {
        /// The grid of the cells.
        grid: Arc<HexGrid>,
        /// The rows of all cells.
        rows: List<Entry>,
    }
}

ports! {
    pub struct Out {
        /// `hybrid-lod.json` and the shaders.
        bundle: Arc<Bundle>,
    }
}

pub struct HybridLod;

impl Node for HybridLod {
    const KIND: &'static str = "write";
    const METHOD: &'static str = "hybrid-lod";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        (4 << 20) + sizes.iter().sum::<u64>().saturating_mul(6)
    }

    fn run(_: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        let rows = inputs.rows.0.iter().map(|(_, row)| (**row).clone()).collect();
        let manifest = Manifest::new(&inputs.grid, rows);
        let json = serde_json::to_value(&manifest).map_err(|e| NodeError::from_error(&e))?;
        let file = BundleFile { path: MANIFEST.into(), media: "application/json", bytes: json_bytes(&json)? };
        Ok(Out { bundle: bundle(std::iter::once(file).chain(shader_files(&SHADERS)).collect())? })
    }
}
