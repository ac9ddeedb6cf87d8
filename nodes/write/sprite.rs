//! A packed layered depth image for shaders and programs.

use crate::{
    engine::{
        node::{Ctx, Node, NodeError},
        plan::{Bundle, File},
    },
    formats::exr::{Depths, write_depths},
    nodes::{draw_sprites, json_bytes, values},
    ports,
    sprite::{self, LayeredDepthImage, Layout, Packed, Placement, Volume},
    texture::dds::write_rg32_uint,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::{collections::BTreeMap, sync::Arc};

/// Writes a packed layered depth image as it lies in memory, little-endian, and a JSON manifest that says where its sections begin, what
/// they hold, and with which matrix a point of the world becomes a point of the image (Trapp and Döllner 2008, equation 2). Beside them
/// its layers, the paper's texture, the tests for shaders, and a picture of the solid as the sprite shows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Name of the files, to which endings are added.
    pub name: String,
}

impl Default for Params {
    fn default() -> Self {
        Self { name: "vds".into() }
    }
}

ports! {
    pub struct In {
        /// What to write.
        sprite: Arc<values::Sprite>,
    }
}

ports! {
    pub struct Out {
        /// `.json`, the manifest, is the file to open first; `.bin` holds the sections, one after the other, each at a multiple of 16 bytes;
        /// `.exr` the layers of the cropped image, a part for each, 1 where there is no depth; `.dds` the paper's compressed texture (section
        /// 4.3), whose two channels are the numbers and the bits of the floats of the layout `ranges`, whatever the layout of the data is; `.wgsl`
        /// parity test, eight-corner test and rays for shaders; `.comp`, `.hlsl`, `.metal` and `.spv` the same in GLSL 4.5 (with an entry point that
        /// classifies points), HLSL for shader model 5.1, Metal 2 and SPIR-V 1.3; `.png` a picture of the solid, drawn from the sprite alone, 640 × 480.
        bundle: Arc<Bundle>,
    }
}

pub struct Sprite;

impl Node for Sprite {
    const KIND: &'static str = "write";
    const METHOD: &'static str = "sprite";
    const VERSION: u32 = 3;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // The layers once as they are and once as a file; most of them hold nothing.
        (32 << 20) + sizes[0].saturating_mul(16)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        crate::nodes::check_name(&params.name)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let values::Sprite { packed, frame } = &*inputs.sprite;
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
            "format": sprite::SPRITE_FORMAT,
            "version": 2,
            "size": packed.size(),
            "region": [region.x, region.y, region.width, region.height],
            "layout": packed.layout().name(),
            "depth_complexity": packed.depth_complexity(),
            "depths": depths,
            "world_to_texture": rows,
            "data": { "file": format!("{}.bin", params.name), "bytes": bytes.len(), "blake3": blake3::hash(&bytes).to_hex().as_str() },
            "sections": sections,
        });
        let image = packed.unpack();
        let portrait = || draw_sprites::portrait(Volume::new(packed.unpack(), frame, &Placement::default()), ctx);
        let files = [
            ("json", "application/json", json_bytes(&manifest)?),
            ("bin", "application/octet-stream", bytes),
            ("exr", "image/x-exr", layers(&image)?),
            ("dds", "image/vnd-ms.dds", texture(&image)?),
            ("wgsl", "text/wgsl", sprite::SHADER.into()),
            ("comp", "text/x-glsl", sprite::GLSL.into()),
            ("hlsl", "text/x-hlsl", sprite::HLSL.into()),
            ("metal", "text/x-metal", sprite::METAL.into()),
            ("spv", "application/x-spirv", sprite::SPIRV.into()),
            ("png", "image/png", portrait()?),
        ];
        let path = |end: &str| format!("{}.{end}", params.name);
        let files = files
            .into_iter()
            .map(|(end, media_type, bytes)| (path(end), File { media_type: media_type.into(), bytes }));
        let bundle = Bundle::new(path("json"), files.collect::<BTreeMap<_, _>>()).map_err(NodeError::Failed)?;
        Ok(Out { bundle: Arc::new(bundle) })
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
