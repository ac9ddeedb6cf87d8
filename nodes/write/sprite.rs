//! `write-sprite`: a packed layered depth image for shaders and programs.

use super::{draw_sprites, json_file, values::Sprite};
use crate::{
    engine::{
        node::{Ctx, Node, NodeError},
        plan::File,
    },
    formats::{
        dds::write_rg32_uint,
        exr::{Depths, write_depths},
    },
    ports,
    sprite::{self, LayeredDepthImage, Layout, Packed, Placement, Volume},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::sync::Arc;

/// Writes a packed layered depth image as it lies in memory, little-endian, and a JSON manifest that says where its sections begin, what
/// they hold, and with which matrix a point of the world becomes a point of the image (Trapp and Döllner 2008, equation 2). Beside them
/// its layers, the paper's texture, the tests for shaders, and a picture of the solid as the sprite shows it.
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
        /// The layers of the cropped image, EXR: a part for each, 1 where there is no depth.
        layers: Arc<File>,
        /// The paper's compressed texture (section 4.3), DDS: its two channels are the numbers and the bits of the floats of the layout
        /// `ranges`, whatever the layout of `data` is.
        texture: Arc<File>,
        /// Parity test, eight-corner test and rays for shaders, WGSL.
        shader: Arc<File>,
        /// The same with an entry point that classifies points, GLSL 4.5.
        glsl: Arc<File>,
        /// The same, HLSL for shader model 5.1.
        hlsl: Arc<File>,
        /// The same, Metal 2.
        metal: Arc<File>,
        /// The same, SPIR-V 1.3.
        spirv: Arc<File>,
        /// The solid, drawn from the sprite alone, 640 × 480, PNG.
        picture: Arc<File>,
    }
}

pub struct WriteSprite;

impl Node for WriteSprite {
    const KIND: &'static str = "write-sprite";
    const VERSION: u32 = 3;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // The layers once as they are and once as a file; most of them hold nothing.
        (32 << 20) + sizes[0].saturating_mul(16)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        let plain = !params.data.is_empty() && !params.data.contains(['/', '\\', '\0']);
        if plain { Ok(()) } else { Err(("data", format!("expected the name of a file, found `{}`", params.data))) }
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let Sprite { packed, frame } = &*inputs.sprite;
        let (bytes, sections) = packed.file();
        let sections: Vec<_> = sections
            .iter()
            .map(|s| json!({ "name": s.name, "element": s.element, "count": s.count, "offset": s.offset }))
            .collect();
        let (m, region) = (frame.to_texture(), packed.region());
        let rows: Vec<[f64; 4]> =
            (0..3).map(|i| [m.matrix3.row(i).x, m.matrix3.row(i).y, m.matrix3.row(i).z, m.translation[i]]).collect();
        let depths = match packed.grid() {
            None => json!({ "form": "f32" }),
            // A depth is (base + number)·step.
            Some(g) => json!({ "form": "u16", "base": g.parts()[1], "step": g.step(), "bound": g.bound() }),
        };
        let manifest = json!({
            "format": "farfield depth sprite",
            "version": 2,
            "size": packed.size(),
            "region": [region.x, region.y, region.width, region.height],
            "layout": packed.layout().name(),
            "depth_complexity": packed.depth_complexity(),
            "depths": depths,
            "world_to_texture": rows,
            "data": { "file": params.data, "bytes": bytes.len(), "blake3": blake3::hash(&bytes).to_hex().as_str() },
            "sections": sections,
        });
        let file = |media_type: &str, bytes: Vec<u8>| Arc::new(File { media_type: media_type.into(), bytes });
        let image = packed.unpack();
        Ok(Out {
            manifest: json_file(&manifest)?,
            data: file("application/octet-stream", bytes),
            layers: file("image/x-exr", layers(&image)?),
            texture: file("image/vnd-ms.dds", texture(&image)?),
            shader: file("text/wgsl", sprite::SHADER.into()),
            glsl: file("text/x-glsl", sprite::GLSL.into()),
            hlsl: file("text/x-hlsl", sprite::HLSL.into()),
            metal: file("text/x-metal", sprite::METAL.into()),
            spirv: file("application/x-spirv", sprite::SPIRV.into()),
            picture: draw_sprites::portrait(Volume::new(image, frame, &Placement::default()), ctx)?,
        })
    }
}

fn layers(image: &LayeredDepthImage) -> Result<Vec<u8>, NodeError> {
    let region = image.region();
    let layers = (0..image.depth_complexity() as usize).map(|i| (format!("depth {i}"), image.layer(i)));
    let depths = Depths {
        size: image.size(),
        window: [region.x, region.y, region.width, region.height],
        layers: &layers.collect::<Vec<_>>(),
    };
    write_depths(&depths).map_err(|e| NodeError::from_error(&e))
}

fn texture(image: &LayeredDepthImage) -> Result<Vec<u8>, NodeError> {
    let packed = Packed::new(image, Layout::Ranges);
    let (side, texels) = packed
        .as_ref()
        .and_then(Packed::texture)
        .ok_or_else(|| NodeError::Failed("the paper's texture cannot hold as many ranges".into()))?;
    write_rg32_uint(side, texels).map_err(|e| NodeError::from_error(&e))
}
