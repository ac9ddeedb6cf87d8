//! The files of one cell's stand-ins.

use crate::{
    engine::{
        node::{Ctx, List, Node, NodeError},
        plan::File,
    },
    formats::{GlbOptions, write_glb},
    lod::{entry::Entry, subject::Subject, texture::Textured},
    ports,
    runtime::hybrid_lod::cell_files,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Writes the stand-ins of a cell as one GLB that opens as it is, a node for each stand-in and atlases for all, and the atlases as BC1 in KTX2. The second set of
/// texture coordinates holds the depth of each vertex in the view that its texture was captured by: texture coordinates are exact where u, v and 1 are
/// interpolated times that depth and divided (projective texture mapping). Source: Chen et al. 2003, section 3.2.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Of an atlas' side, at most.
    #[schemars(range(min = 256, max = 16384), extend("x-unit" = "texels"))]
    pub page: u32,
    /// Writes BC1 textures in KTX2.
    pub ktx2: bool,
}

impl Default for Params {
    fn default() -> Self {
        Self { page: 4096, ktx2: true }
    }
}

ports! {
    pub struct In {
        /// The cell's row, as `classify-occlusion` gives it.
        entry: Arc<Entry>,
        /// What its stand-ins are of.
        stand_ins: List<Subject, true>,
        /// Their meshes and textures, by the same names.
        textured: List<Textured, true>,
    }
}

ports! {
    pub struct Out {
        /// The meshes with their textures; a file without meshes where nothing is seen from the cell.
        glb: Arc<File>,
        /// The atlases, a layer each; an empty file where there are none.
        textures: Arc<File>,
        /// The cell's row of the manifest.
        row: Arc<Entry>,
    }
}

pub struct HybridLodCell;

impl Node for HybridLodCell {
    const KIND: &'static str = "write";
    const METHOD: &'static str = "hybrid-lod-cell";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // Atlases, which may be a quarter full, their blocks and their PNG.
        (32 << 20) + sizes[2].saturating_mul(6)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let In { entry, stand_ins, textured } = inputs;
        let rows: Vec<(&str, &Subject, &Textured)> = stand_ins
            .0
            .iter()
            .map(|(name, subject)| {
                let found = textured.0.iter().find(|(n, _)| n == name);
                let (_, t) = found.ok_or_else(|| NodeError::Failed(format!("the stand-in `{name}` has no mesh")))?;
                Ok((name.as_str(), &**subject, &**t))
            })
            .collect::<Result<_, NodeError>>()?;
        let cell = cell_files(&entry, &rows, params.page).map_err(NodeError::Failed)?;
        ctx.stop.check()?;
        let glb = write_glb(&cell.scene, &GlbOptions::default()).map_err(|e| NodeError::from_error(&e))?;
        ctx.stop.check()?;
        let textures = if params.ktx2 { cell.ktx2().map_err(NodeError::Failed)? } else { Vec::new() };
        let mut row = cell.row;
        (row.glb_bytes, row.texture_bytes) = (glb.len() as u64, textures.len() as u64);
        let file = |media: &str, bytes| Arc::new(File { media_type: media.into(), bytes });
        Ok(Out { glb: file("model/gltf-binary", glb), textures: file("image/ktx2", textures), row: Arc::new(row) })
    }
}
