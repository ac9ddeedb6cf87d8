//! Stand-ins of several methods as one bundle.

use crate::{
    engine::{
        node::{Ctx, Node, NodeError},
        plan::{Bundle, File},
        publish::names,
    },
    formats::{GlbOptions, write_glb},
    math::Stop,
    nodes::json_bytes,
    ports,
    runtime::mix::{FORMAT, Manifest, NAME, Part, VERSION},
    scene::Scene,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

/// Writes stand-ins of two methods, or one and what is drawn as it is, as one stand-in that `evaluate` measures as a whole: `mix.json` lists the parts, each of
/// which keeps the files and formats of its method. All are drawn, and depth decides what is seen. A mix may hold another. `mix-objects` takes a list
/// of stand-ins besides.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Marks the materials of `scene` as unlit (KHR_materials_unlit), as those of captured stand-ins are.
    pub unlit: bool,
}

impl Default for Params {
    fn default() -> Self {
        Self { unlit: true }
    }
}

ports! {
    pub struct In {
        /// What is drawn as it is: `scene.glb`.
        scene: Option<Arc<Scene>>,
        /// A stand-in, in the folder `whole/`.
        whole: Arc<Bundle>,
        /// Another, in the folder `other/`.
        other: Option<Arc<Bundle>>,
    }
}

ports! {
    pub struct Out {
        /// The files; `mix.json` is the one to open first.
        bundle: Arc<Bundle>,
    }
}

pub struct Mix;

impl Node for Mix {
    const KIND: &'static str = "write";
    const METHOD: &'static str = "mix";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        memory(sizes)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let whole = ("whole".to_owned(), "whole".to_owned(), inputs.whole);
        let other = inputs.other.map(|bundle| ("other".to_owned(), "other".to_owned(), bundle));
        let parts = std::iter::once(whole).chain(other);
        Ok(Out { bundle: Arc::new(bundle(inputs.scene.as_deref(), None, parts, params.unlit, ctx.stop)?) })
    }
}

/// The folder of the sprite that clips.
const VOLUME: &str = "volume";

pub(super) fn memory(sizes: &[u64]) -> u64 {
    (1 << 20) + sizes.iter().sum::<u64>().saturating_mul(3)
}

/// One scene of several: what is drawn as it is, and objects of other lists under their own names, or `NAME OBJECT` where a name is taken.
pub(super) fn joined(scene: Option<&Scene>, meshes: &[(String, Arc<Scene>)]) -> Scene {
    let mut objects = scene.map_or_else(Vec::new, |s| s.objects.clone());
    let mut taken: BTreeSet<String> = objects.iter().map(|o| o.name.clone()).collect();
    for (name, mesh) in meshes {
        for object in &mesh.objects {
            let mut object = object.clone();
            while !taken.insert(object.name.clone()) {
                object.name = format!("{name} {}", object.name);
            }
            objects.push(object);
        }
    }
    objects.sort_by(|a, b| a.name.cmp(&b.name));
    Scene { objects }
}

/// The mix of a scene, without what lies in the solid of a depth sprite, and of stand-ins: name, folder and files of each.
pub(super) fn bundle(
    scene: Option<&Scene>,
    volume: Option<Arc<Bundle>>,
    stand_ins: impl Iterator<Item = (String, String, Arc<Bundle>)>,
    unlit: bool,
    stop: &Stop,
) -> Result<Bundle, NodeError> {
    let mut files: BTreeMap<String, File> = BTreeMap::new();
    let mut parts: Vec<Part> = Vec::new();
    if let Some(scene) = scene.filter(|scene| scene.triangle_count() > 0) {
        let options = GlbOptions { unlit, normal_maps: false };
        let bytes = write_glb(scene, &options).map_err(|e| NodeError::from_error(&e))?;
        files.insert("scene.glb".into(), File { media_type: "model/gltf-binary".into(), bytes });
        let clipped_by = volume.iter().map(|v| format!("{VOLUME}/{}", v.main())).collect();
        parts.push(Part { name: "scene".into(), main: "scene.glb".into(), clipped_by });
    } else if volume.is_some() {
        return Err(NodeError::Failed("volume: there is no scene that it clips".into()));
    }
    files.extend(volume.iter().flat_map(|v| v.files()).map(|(path, file)| (format!("{VOLUME}/{path}"), file.clone())));
    for (name, folder, bundle) in stand_ins {
        stop.check()?;
        parts.push(Part { name, main: format!("{folder}/{}", bundle.main()), clipped_by: Vec::new() });
        files.extend(bundle.files().iter().map(|(path, file)| (format!("{folder}/{path}"), file.clone())));
    }
    if parts.is_empty() {
        return Err(NodeError::Failed("there is nothing to write: no scene, no stand-in".into()));
    }
    let manifest = Manifest { format: FORMAT.into(), version: VERSION, parts };
    let manifest = serde_json::to_value(&manifest).map_err(|e| NodeError::from_error(&e))?;
    files.insert(NAME.into(), File { media_type: "application/json".into(), bytes: json_bytes(&manifest)? });
    Bundle::new(NAME, files).map_err(NodeError::Failed)
}

/// The folder of an object, which no other has where upper and lower case are one.
pub(super) fn folder(name: &str, taken: &mut BTreeSet<String>) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-_+=@,() ".contains(c) { c } else { '-' };
    let short: String = name.chars().map(plain).take(100).collect();
    let short = format!("objects/o-{}", short.trim_end());
    let numbered = (2..).map(|n| format!("{short}-{n}"));
    let free = std::iter::once(short.clone()).chain(numbered).find(|f| taken.insert(names::folded(f)));
    free.unwrap_or(short)
}
