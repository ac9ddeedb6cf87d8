//! Stand-ins of several methods as one bundle.

use crate::{
    engine::{
        node::{Ctx, List, Node, NodeError},
        plan::{Bundle, File},
        publish::names,
    },
    formats::{GlbOptions, write_glb},
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

/// Writes stand-ins of several methods as one that `evaluate` measures as a whole: `mix.json` lists the parts, each of which keeps the files and formats of its
/// method. All are drawn, and depth decides what is seen. The far part of a scene can be a textured depth mesh while objects nearer by are impostors
/// and the nearest are drawn as they are. A mix may hold another.
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
        /// A stand-in of one piece, in the folder `whole/`.
        whole: Option<Arc<Bundle>>,
        /// Stand-ins of objects, each in a folder below `objects/` that has its name, with `-` for what file names cannot hold.
        objects: List<Bundle, true>,
    }
}

ports! {
    pub struct Out {
        /// The files; `mix.json` is the one to open first.
        bundle: Arc<Bundle>,
    }
}

pub struct Mix;

/// The folder of an object, which no other has where upper and lower case are one.
fn folder(name: &str, taken: &mut BTreeSet<String>) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-_+=@,() ".contains(c) { c } else { '-' };
    let short: String = name.chars().map(plain).take(100).collect();
    let short = format!("objects/o-{}", short.trim_end());
    let numbered = (2..).map(|n| format!("{short}-{n}"));
    let free = std::iter::once(short.clone()).chain(numbered).find(|f| taken.insert(names::folded(f)));
    free.unwrap_or(short)
}

impl Node for Mix {
    const KIND: &'static str = "write";
    const METHOD: &'static str = "mix";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        (1 << 20) + sizes.iter().sum::<u64>().saturating_mul(3)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let mut files: BTreeMap<String, File> = BTreeMap::new();
        let mut parts: Vec<Part> = Vec::new();
        if let Some(scene) = inputs.scene.filter(|scene| scene.triangle_count() > 0) {
            let options = GlbOptions { unlit: params.unlit, normal_maps: false };
            let bytes = write_glb(&scene, &options).map_err(|e| NodeError::from_error(&e))?;
            files.insert("scene.glb".into(), File { media_type: "model/gltf-binary".into(), bytes });
            parts.push(Part { name: "scene".into(), main: "scene.glb".into() });
        }
        let whole =
            inputs.whole.into_iter().map(|bundle| Ok::<_, NodeError>(("whole".to_owned(), "whole".to_owned(), bundle)));
        let mut taken = BTreeSet::new();
        let objects = inputs.objects.0.into_iter().map(|(name, bundle)| {
            let folder = folder(&name, &mut taken);
            Ok((name, folder, bundle))
        });
        for part in whole.chain(objects) {
            ctx.stop.check()?;
            let (name, folder, bundle) = part?;
            parts.push(Part { name, main: format!("{folder}/{}", bundle.main()) });
            files.extend(bundle.files().iter().map(|(path, file)| (format!("{folder}/{path}"), file.clone())));
        }
        if parts.is_empty() {
            return Err(NodeError::Failed("there is nothing to write: no scene, no stand-in".into()));
        }
        let manifest = Manifest { format: FORMAT.into(), version: VERSION, parts };
        let manifest = serde_json::to_value(&manifest).map_err(|e| NodeError::from_error(&e))?;
        files.insert(NAME.into(), File { media_type: "application/json".into(), bytes: json_bytes(&manifest)? });
        Ok(Out { bundle: Arc::new(Bundle::new(NAME, files).map_err(NodeError::Failed)?) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        formats::Limits,
        nodes::{contents::Contents, testing::run},
        runtime::{self, Opened},
        scene::builtin,
    };
    use std::path::Path;

    fn bundle(scene: &Scene) -> Arc<Bundle> {
        let bytes = write_glb(scene, &GlbOptions::default()).unwrap();
        let file = File { media_type: "model/gltf-binary".into(), bytes };
        Arc::new(Bundle::new("a.glb", BTreeMap::from([("a.glb".into(), file)])).unwrap())
    }

    #[test]
    fn what_is_written_opens_as_one_stand_in() {
        let car = builtin::make("car", 1).unwrap();
        let one = |k: usize| bundle(&Scene { objects: vec![car.objects[k].clone()] });
        let objects = List(vec![("block 1.8/a".into(), one(1)), ("block 1.8:A".into(), one(2))]);
        let mix = |scene: Option<&Scene>, objects| {
            let scene = scene.map(|s| Arc::new(s.clone()));
            run::<Mix>(&Params::default(), In { scene, whole: Some(one(0)), objects }).0
        };
        let inner = mix(None, objects).unwrap().bundle;
        let folders: Vec<&str> = inner.files().keys().map(String::as_str).collect();
        assert_eq!(
            folders,
            ["mix.json", "objects/o-block 1-8-A-2/a.glb", "objects/o-block 1-8-a/a.glb", "whole/a.glb"]
        );
        // A mix may hold another.
        let outer = mix(Some(&car), List(vec![("again".into(), inner)])).unwrap().bundle;
        let opened = runtime::open(Path::new(outer.main()), &Contents(&outer), &Limits::default()).unwrap();
        assert!(matches!(&opened, Opened::Mix(parts) if parts.len() == 3));
        let triangles = |k: usize| car.objects[k].triangle_count() as u64;
        let all = car.triangle_count() as u64 + 2 * triangles(0) + triangles(1) + triangles(2);
        assert_eq!(opened.modes()[0].1.size().triangles, all);
    }

    #[test]
    fn nothing_is_no_mix() {
        let nothing = In { scene: None, whole: None, objects: List(Vec::new()) };
        assert!(run::<Mix>(&Params::default(), nothing).0.is_err_and(|e| e.to_string().contains("nothing to write")));
    }
}
