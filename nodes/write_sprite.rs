//! `write-sprite`: a packed layered depth image for shaders and programs.

use super::values::Sprite;
use crate::{
    engine::{
        node::{Ctx, Node, NodeError},
        plan::File,
    },
    ports, sprite,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::sync::Arc;

/// Writes a packed layered depth image as it lies in memory, little-endian, and a JSON manifest that says where its sections begin, what
/// they hold, and with which matrix a point of the world becomes a point of the image (Trapp and Döllner 2008, equation 2).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Name of the data file in the manifest.
    pub data: String,
}

impl Default for Params {
    fn default() -> Self {
        Self { data: "vds.bin".into() }
    }
}

ports! {
    pub struct In {
        /// What to write.
        sprite: Arc<Sprite>,
    }
}

ports! {
    pub struct Out {
        /// The manifest, JSON.
        manifest: Arc<File>,
        /// The sections, one after the other, each at a multiple of 16 bytes.
        data: Arc<File>,
        /// The parity test for shaders, WGSL.
        shader: Arc<File>,
    }
}

pub struct WriteSprite;

impl Node for WriteSprite {
    const KIND: &'static str = "write-sprite";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        (16 << 20) + sizes[0].saturating_mul(3)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        let plain = !params.data.is_empty() && !params.data.contains(['/', '\\', '\0']);
        if plain { Ok(()) } else { Err(("data", format!("expected the name of a file, found `{}`", params.data))) }
    }

    fn run(params: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        let Sprite { packed, frame } = &*inputs.sprite;
        let (bytes, sections) = packed.file();
        let sections: Vec<_> = sections
            .iter()
            .map(|s| json!({ "name": s.name, "element": s.element, "count": s.count, "offset": s.offset }))
            .collect();
        let (m, region) = (frame.to_texture(), packed.region());
        let rows: Vec<[f64; 4]> =
            (0..3).map(|i| [m.matrix3.row(i).x, m.matrix3.row(i).y, m.matrix3.row(i).z, m.translation[i]]).collect();
        let manifest = json!({
            "format": "farfield depth sprite",
            "version": 1,
            "size": packed.size(),
            "region": [region.x, region.y, region.width, region.height],
            "layout": packed.layout().name(),
            "depth_complexity": packed.depth_complexity(),
            "world_to_texture": rows,
            "data": { "file": params.data, "bytes": bytes.len(), "blake3": blake3::hash(&bytes).to_hex().as_str() },
            "sections": sections,
        });
        let mut text = serde_json::to_vec_pretty(&manifest).map_err(|e| NodeError::from_error(&e))?;
        text.push(b'\n');
        Ok(Out {
            manifest: Arc::new(File { media_type: "application/json".into(), bytes: text }),
            data: Arc::new(File { media_type: "application/octet-stream".into(), bytes }),
            shader: Arc::new(File { media_type: "text/wgsl".into(), bytes: sprite::SHADER.into() }),
        })
    }
}
