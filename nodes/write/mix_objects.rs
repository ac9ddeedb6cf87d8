//! Stand-ins of objects, and of what is around them, as one bundle.

use super::mix::{Out, Params as MixParams, bundle, folder, joined, memory};
use crate::{
    engine::{
        node::{Ctx, List, Node, NodeError},
        plan::Bundle,
    },
    ports,
    scene::Scene,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{collections::BTreeSet, sync::Arc};

/// Writes stand-ins of objects, with one of all that is behind them and what is drawn as it is, as one stand-in that `evaluate` measures as a whole: `mix.json` lists the
/// parts, as that of `mix` does. The far part of a scene can be a textured depth mesh while objects nearer by are impostors and the nearest are drawn as
/// they are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Marks the materials of `scene` as unlit (KHR_materials_unlit), as those of captured stand-ins are.
    pub unlit: bool,
}

impl Default for Params {
    fn default() -> Self {
        Self { unlit: MixParams::default().unlit }
    }
}

ports! {
    pub struct In {
        /// What is drawn as it is: `scene.glb`.
        scene: Option<Arc<Scene>>,
        /// Stand-ins that are ordinary meshes; they are in `scene.glb` too.
        meshes: Option<List<Scene, true>>,
        /// A depth sprite, in the folder `volume/`: what of `scene.glb` lies inside it is not drawn. The scene's mesh stays as it is, and the renderer asks the sprite.
        volume: Option<Arc<Bundle>>,
        /// A stand-in of one piece, in the folder `whole/`.
        whole: Option<Arc<Bundle>>,
        /// Stand-ins of objects, each in a folder below `objects/` that has its name, with `-` for what file names cannot hold.
        objects: Option<List<Bundle, true>>,
    }
}

pub struct MixObjects;

impl Node for MixObjects {
    const KIND: &'static str = "write";
    const METHOD: &'static str = "mix-objects";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        memory(sizes)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let whole = inputs.whole.map(|bundle| ("whole".to_owned(), "whole".to_owned(), bundle));
        let mut taken = BTreeSet::new();
        let objects = inputs.objects.into_iter().flat_map(|list| list.0).map(|(name, bundle)| {
            let folder = folder(&name, &mut taken);
            (name, folder, bundle)
        });
        let parts = whole.into_iter().chain(objects);
        let scene = match inputs.meshes {
            Some(meshes) => Some(Arc::new(joined(inputs.scene.as_deref(), &meshes.0))),
            None => inputs.scene,
        };
        Ok(Out { bundle: Arc::new(bundle(scene.as_deref(), inputs.volume, parts, params.unlit, ctx.stop)?) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        engine::plan::File,
        formats::{self, GlbOptions, Limits, write_glb},
        math::{Aabb, Stop},
        nodes::{contents::Contents, testing::run, values},
        raster::{Cpu, Geometry},
        runtime::{self, Opened},
        scene::builtin,
        sprite::{Direction, Layout, Packed, Peeling, Repair, peel},
    };
    use glam::DVec3;
    use std::{collections::BTreeMap, path::Path};

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
            run::<MixObjects>(
                &Params::default(),
                In { scene, meshes: None, volume: None, whole: Some(one(0)), objects: Some(objects) },
            )
            .0
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

    /// The sprite of the box as a bundle.
    fn sprite(bounds: &Aabb) -> Arc<Bundle> {
        use super::super::sprite;
        let solid = builtin::closed_box(bounds);
        let direction = Direction::new(DVec3::NEG_Y).unwrap();
        let how = Peeling { resolution: 64, samples: 1, repair: Repair::None };
        let peeled = peel(&Cpu, &Geometry::new(&solid), &direction, &how, &Stop::default()).unwrap();
        let packed = Packed::new(&peeled.image, Layout::Raw).unwrap();
        let sprite = Arc::new(values::Sprite { packed, frame: peeled.frame });
        run::<sprite::Sprite>(&sprite::Params::default(), sprite::In { sprite }).0.unwrap().bundle
    }

    #[test]
    fn a_sprite_clips_the_meshes() {
        let car = builtin::make("car", 1).unwrap();
        let half = Aabb { min: car.bounds().min - 1.0, max: car.bounds().max + DVec3::new(1.0, -0.7, 1.0) };
        let part = |k: usize| Arc::new(Scene { objects: vec![car.objects[k].clone()] });
        let make = |scene, meshes, volume| {
            let inputs = In { scene, meshes, volume, whole: None, objects: None };
            run::<MixObjects>(&Params::default(), inputs).0.map(|out| out.bundle)
        };
        let all = || List(vec![("a".to_owned(), Arc::new(car.clone())), ("b".to_owned(), part(0))]);
        let mix = make(Some(part(0)), Some(all()), Some(sprite(&half))).unwrap();
        let opened = runtime::open(Path::new(mix.main()), &Contents(&mix), &Limits::default()).unwrap();
        let Opened::Mix(parts) = &opened else { panic!("a mix") };
        assert!(matches!(parts[..], [Opened::Clipped(_)]));
        let first = car.objects[0].triangle_count() as u64;
        assert_eq!(opened.modes()[0].1.size().triangles, car.triangle_count() as u64 + 2 * first);
        // Objects of one name are told apart in the file.
        let scene = formats::from_glb(
            Path::new("scene.glb"),
            Arc::new(mix.files()["scene.glb"].bytes.clone()),
            &Limits::default(),
        )
        .unwrap();
        let names: BTreeSet<&str> = scene.objects.iter().map(|o| &*o.name).collect();
        assert_eq!(names.len(), car.objects.len() + 2);
        assert!(names.contains(&*format!("b {}", car.objects[0].name)), "{names:?}");

        let nothing = make(None, None, Some(sprite(&half)));
        assert!(nothing.is_err_and(|e| e.to_string().contains("there is no scene that it clips")));
        // Only meshes can be clipped, and only by sprites.
        let changed = |from: &str, to: &str| {
            let mut files = mix.files().clone();
            let text = String::from_utf8(files["mix.json"].bytes.clone()).unwrap();
            assert!(text.contains(from));
            files.get_mut("mix.json").unwrap().bytes = text.replace(from, to).into_bytes();
            let bundle = Bundle::new("mix.json", files).unwrap();
            runtime::open(Path::new("mix.json"), &Contents(&bundle), &Limits::default()).err().unwrap().to_string()
        };
        let error = changed("\"main\": \"scene.glb\"", "\"main\": \"volume/vds.json\"");
        assert!(error.contains("a sprite clips meshes"), "{error}");
        let error = changed("volume/vds.json", "scene.glb");
        assert!(error.contains("`scene.glb` is no depth sprite"), "{error}");
    }

    #[test]
    fn two_methods_are_one_stand_in() {
        use super::super::mix;
        let car = builtin::make("car", 1).unwrap();
        let inputs = |other| mix::In { scene: Some(Arc::new(car.clone())), whole: bundle(&car), other };
        let files = |other| {
            let made = run::<mix::Mix>(&MixParams::default(), inputs(other)).0.unwrap().bundle;
            made.files().keys().cloned().collect::<Vec<_>>()
        };
        assert_eq!(files(None), ["mix.json", "scene.glb", "whole/a.glb"]);
        assert_eq!(files(Some(bundle(&car))), ["mix.json", "other/a.glb", "scene.glb", "whole/a.glb"]);
    }

    #[test]
    fn nothing_is_no_mix() {
        let nothing = In { scene: None, meshes: None, volume: None, whole: None, objects: None };
        assert!(
            run::<MixObjects>(&Params::default(), nothing).0.is_err_and(|e| e.to_string().contains("nothing to write"))
        );
    }
}
