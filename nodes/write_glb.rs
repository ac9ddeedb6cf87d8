//! `write-glb`: a scene as a file that other programs open.

use crate::{
    engine::{
        node::{Ctx, Node, NodeError},
        plan::File,
    },
    formats::{self, GlbOptions},
    ports,
    scene::{Scene, names},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Writes a scene as GLB (glTF 2.0 in one file), textures inside as PNG. Without the colour of lamps or the sun: the
/// materials are unlit, so that every viewer shows the same captured colour.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Marks all materials as unlit (KHR_materials_unlit) and keeps only their base colour.
    pub unlit: bool,
    /// Keeps normal maps although the materials are unlit, for engines that light the stand-in with a shader of their own.
    pub normal_maps: bool,
}

impl Default for Params {
    fn default() -> Self {
        let GlbOptions { unlit, normal_maps } = GlbOptions::default();
        Self { unlit, normal_maps }
    }
}

ports! {
    pub struct In {
        /// What to write.
        scene: Arc<Scene>,
        /// What is written beside it as it is, such as geometry that is too near for a stand-in.
        near: Option<Arc<Scene>>,
    }
}

ports! {
    pub struct Out {
        /// The file, `model/gltf-binary`.
        glb: Arc<File>,
    }
}

pub struct WriteGlb;

impl Node for WriteGlb {
    const KIND: &'static str = "write-glb";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // Arrays once in the binary chunk and once in the file, images as RGB while they are encoded.
        sizes.iter().sum::<u64>().saturating_mul(3)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let mut objects = inputs.scene.objects.clone();
        objects.extend(inputs.near.iter().flat_map(|near| near.objects.iter().cloned()));
        let scene = names::assemble(objects);
        if scene.triangle_count() == 0 {
            return Err(NodeError::Failed("there is no triangle to write".into()));
        }
        ctx.stop.check()?;
        let options = GlbOptions { unlit: params.unlit, normal_maps: params.normal_maps };
        let bytes = formats::write_glb(&scene, &options).map_err(|e| NodeError::from_error(&e))?;
        Ok(Out { glb: Arc::new(File { media_type: "model/gltf-binary".into(), bytes }) })
    }
}
