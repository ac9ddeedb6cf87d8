//! A scene as a GLB file.

use crate::{
    engine::{
        node::{Ctx, Node, NodeError},
        plan::{Bundle, File},
    },
    formats::{self, GlbOptions},
    ports,
    scene::{Scene, names},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{collections::BTreeMap, sync::Arc};

/// Writes a scene as GLB (glTF 2.0 in one file), with its textures embedded as PNG. Materials are
/// unlit by default, so that every viewer shows the captured colour.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Name of the file, to which `.glb` is added.
    pub name: String,
    /// Marks all materials as unlit (KHR_materials_unlit) and keeps only their base colour.
    pub unlit: bool,
    /// Keeps normal maps although the materials are unlit, for engines that light the stand-in with a shader of their own.
    pub normal_maps: bool,
}

impl Default for Params {
    fn default() -> Self {
        let GlbOptions { unlit, normal_maps } = GlbOptions::default();
        Self { name: "stand-in".into(), unlit, normal_maps }
    }
}

ports! {
    pub struct In {
        /// The scene to write.
        scene: Arc<Scene>,
        /// Written beside it unchanged, such as geometry that is too near for a stand-in.
        near: Option<Arc<Scene>>,
    }
}

ports! {
    pub struct Out {
        /// The file alone, `model/gltf-binary`.
        bundle: Arc<Bundle>,
    }
}

pub struct Glb;

impl Node for Glb {
    const KIND: &'static str = "write";
    const METHOD: &'static str = "glb";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // Arrays once in the binary chunk and once in the file, images as RGB while they are encoded.
        sizes.iter().sum::<u64>().saturating_mul(3)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        crate::nodes::check_name(&params.name)
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
        let path = format!("{}.glb", params.name);
        let files = BTreeMap::from([(path.clone(), File { media_type: "model/gltf-binary".into(), bytes })]);
        Ok(Out { bundle: Arc::new(Bundle::new(path, files).map_err(NodeError::Failed)?) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        array::Bytes,
        engine::node::Door,
        formats::{Limits, from_glb},
        math::Stop,
        scene::builtin,
    };
    use std::path::Path;

    struct Closed;

    impl Door for Closed {
        fn read(&self, _: &Path) -> Result<Option<Bytes>, NodeError> {
            panic!("writing reads nothing")
        }
    }

    fn write(scene: Scene, near: Option<Scene>) -> Result<File, String> {
        let stop = Stop::default();
        let ctx = Ctx {
            stop: &stop,
            door: &Closed,
            element: None,
            device: None,
            memory: 1 << 32,
            warn: &|_| {},
            progress: &|_, _| {},
        };
        let inputs = In { scene: Arc::new(scene), near: near.map(Arc::new) };
        let bundle = Glb::run(&Params::default(), inputs, &ctx).map(|o| o.bundle).map_err(|e| e.to_string())?;
        Ok(bundle.files()[bundle.main()].clone())
    }

    #[test]
    fn near_geometry_stands_beside_the_scene_under_its_own_names() {
        let scene = builtin::make("solids", 1).unwrap();
        let [first, rest @ ..] = &scene.objects[..] else { panic!() };
        let near = Scene { objects: vec![first.clone()] };
        let far = Scene { objects: rest.to_vec() };
        let file = write(far, Some(near)).unwrap();
        assert_eq!(file.media_type, "model/gltf-binary");
        let back = from_glb(Path::new("x.glb"), Arc::new(file.bytes.clone()), &Limits::default()).unwrap();
        let names = |s: &Scene| s.objects.iter().map(|o| o.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&back), names(&scene));
        assert_eq!(back.triangle_count(), scene.triangle_count());
        assert!(back.objects.iter().all(|o| o.parts.iter().all(|p| p.material.unlit)));
    }

    #[test]
    fn nothing_to_write_is_an_error() {
        assert_eq!(write(Scene::default(), None).unwrap_err(), "there is no triangle to write");
    }
}
