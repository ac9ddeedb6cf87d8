//! `load-scene`: a scene from a file.

use crate::{
    array::Bytes,
    engine::node::{Ctx, Door, Head, Node, NodeError, SourcePath},
    formats::{self, Files, FormatError, Limits},
    ports,
    scene::{Scene, builtin},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

/// Loads a scene: glTF 2.0 and GLB, OBJ with MTL, PLY, or a scene TOML that places such files: a table `[[place]]` for
/// each copy, with `file`, `name`, `translate` (metres), `rotate_deg` or `quaternion`, and `scale`. docs/scene.md describes
/// it and what is read of each format. Lengths are metres, Y is up. Objects are the nodes that have a mesh, named by their path
/// in the file; skins and morph weights are read in the pose that the file's nodes hold, animations are not played.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// The file (`.glb`, `.gltf`, `.obj`, `.ply`, `.toml`), or `builtin:city`, `builtin:car`, `builtin:park`,
    /// `builtin:solids`.
    pub path: SourcePath,
    /// Whether the scene may name files outside its own folder.
    pub allow_outside: bool,
    /// Which sides of single-sided materials are there: `file` shows what engines show, so that the near wall of a room is no obstacle
    /// where its back is seen (glTF: `doubleSided`); `double` shows both sides of everything. Materials of OBJ and PLY have two sides.
    pub sides: SidesOf,
    /// Most texels that all images together may have, in millions.
    #[schemars(range(max = 1e6), extend("exclusiveMinimum" = 0.0))]
    pub max_megatexels: f64,
    /// Most triangles, every instance counted, in millions.
    #[schemars(range(max = 1e6), extend("exclusiveMinimum" = 0.0))]
    pub max_megatriangles: f64,
    /// Most vertices stored, in millions.
    #[schemars(range(max = 1e6), extend("exclusiveMinimum" = 0.0))]
    pub max_megavertices: f64,
}

/// Whose word counts for the sides of materials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SidesOf {
    /// The file's.
    #[default]
    File,
    /// Nobody's: all materials have two sides.
    Double,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            path: SourcePath::default(),
            allow_outside: false,
            sides: SidesOf::File,
            max_megatexels: 512.0,
            max_megatriangles: 1000.0,
            max_megavertices: 250.0,
        }
    }
}

ports! {
    pub struct In {}
}

ports! {
    pub struct Out {
        /// The whole scene.
        scene: Arc<Scene>,
    }
}

pub struct LoadScene;

impl Node for LoadScene {
    const KIND: &'static str = "load-scene";
    const VERSION: u32 = 3;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, _: &[u64]) -> u64 {
        let path = Path::new(&params.path.0);
        let size = std::fs::metadata(path).map_or(0, |m| m.len());
        working_memory(path, size)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        if params.path.0.is_empty() {
            return Err(("path", "names no file".into()));
        }
        if let Some(name) = builtin_name(&params.path.0)
            && !builtin::NAMES.contains(&name)
        {
            return Err(("path", unknown(name)));
        }
        Ok(())
    }

    fn check_source(_: &str, path: &Path, head: Head) -> Result<(), String> {
        formats::probe(path, head.bytes, head.whole)
    }

    fn run(params: &Params, _: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let path = &params.path.0;
        let scene = match builtin_name(path) {
            Some(name) => builtin::make(name, 1).ok_or_else(|| NodeError::Failed(unknown(name)))?,
            None => load(params, ctx)?,
        };
        if scene.triangle_count() == 0 {
            return Err(NodeError::Failed(format!("{path}: the scene has no triangles")));
        }
        let scene = if params.sides == SidesOf::Double { scene.with_both_sides() } else { scene };
        Ok(Out { scene: Arc::new(scene) })
    }
}

/// Working memory for a file of so many bytes, the scene included. Measured: 6 times the size of an OBJ without texture
/// coordinates, 3 times that of one with all, 6.5 times that of a binary PLY with colours.
fn working_memory(path: &Path, size: u64) -> u64 {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let (base, multiple) = match extension.as_str() {
        "obj" | "ply" | "glb" => (16 << 20, 8),
        // These name other files, whose sizes are not known before they are read.
        _ => (256 << 20, 8),
    };
    size.saturating_mul(multiple).saturating_add(base)
}

/// The `NAME` of `builtin:NAME`.
fn builtin_name(path: &str) -> Option<&str> {
    path.strip_prefix("builtin:")
}

fn unknown(name: &str) -> String {
    format!("there is no built-in scene `{name}`; there are {}", builtin::NAMES.join(", "))
}

fn load(params: &Params, ctx: &Ctx) -> Result<Scene, NodeError> {
    let millions = |m: f64| (m * 1e6) as u64;
    let limits = Limits {
        allow_outside: params.allow_outside,
        texels: millions(params.max_megatexels),
        bytes: ctx.memory,
        triangles: millions(params.max_megatriangles),
        vertices: millions(params.max_megavertices),
        ..Limits::default()
    };
    let files = ThroughDoor { door: ctx.door, failed: Mutex::new(None) };
    let result = formats::load_with(Path::new(&params.path.0), &files, &limits, ctx.stop, &mut |w| (ctx.warn)(w));
    result.map_err(|e| match (e, files.failed.into_inner().unwrap_or_else(PoisonError::into_inner)) {
        (FormatError::Stopped(s), _) => NodeError::Stopped(s),
        // The door's own error says more than the reader that met it.
        (_, Some(failed)) => failed,
        (e @ FormatError::Limit { what: formats::DECODING, .. }, None) => {
            NodeError::Failed(format!("{e}; --memory gives more"))
        }
        (e, None) => NodeError::from_error(&e),
    })
}

/// Files read through the engine's door.
struct ThroughDoor<'a> {
    door: &'a dyn Door,
    failed: Mutex<Option<NodeError>>,
}

impl Files for ThroughDoor<'_> {
    fn read(&self, path: &Path) -> Result<Option<Bytes>, FormatError> {
        self.door.read(path).map_err(|e| {
            let file = PathBuf::from(path);
            let what = e.to_string();
            *self.failed.lock().unwrap_or_else(PoisonError::into_inner) = Some(e);
            FormatError::Unreadable { file, what }
        })
    }

    fn real(&self, path: &Path) -> Option<PathBuf> {
        // Decides only what is refused; what is read passes the door.
        formats::real(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::testing::World;
    use std::sync::Mutex;

    const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

    /// One file, with what was asked for.
    struct Files(&'static str, Mutex<Vec<PathBuf>>);

    impl Door for Files {
        fn read(&self, path: &Path) -> Result<Option<Bytes>, NodeError> {
            self.1.lock().unwrap().push(path.to_owned());
            match path.to_str() {
                Some("/w/a.obj" | "/w/a.gltf") => Ok(Some(Arc::new(self.0.as_bytes().to_vec()))),
                Some("/w/locked.glb") => Err(NodeError::Failed("/w/locked.glb: permission denied".into())),
                _ => Ok(None),
            }
        }
    }

    fn run(path: &str, text: &'static str) -> (Result<Arc<Scene>, String>, Vec<PathBuf>, Vec<String>) {
        let files = Files(text, Mutex::default());
        let params = Params { path: SourcePath(path.into()), ..Params::default() };
        let (out, warnings) = World { door: &files, ..World::default() }.run::<LoadScene>(&params, In {});
        (out.map(|o| o.scene).map_err(|e| e.to_string()), files.1.into_inner().unwrap(), warnings)
    }

    #[test]
    fn everything_passes_the_door() {
        let (scene, read, _) = run("/w/a.obj", TRIANGLE);
        assert_eq!(scene.unwrap().triangle_count(), 1);
        assert_eq!(read, [PathBuf::from("/w/a.obj")]);
        // A file that is looked for and is not there passes it too: its appearance must be noticed.
        let (scene, read, warnings) = run("/w/a.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        assert!(scene.is_ok());
        assert_eq!(read[1], PathBuf::from("/w/m.mtl"));
        assert_eq!(warnings, ["/w/a.obj: line 1: the material library `m.mtl` does not exist; looked for /w/m.mtl"]);
    }

    #[test]
    fn working_memory_follows_the_size_of_the_file() {
        let need = |name: &str, size| working_memory(Path::new(name), size);
        assert!(need("a.ply", 1000) < 32 << 20);
        assert!(need("a.OBJ", 1 << 30) >= 4 << 30);
        assert!(need("a.glb", 1 << 30) > need("a.glb", 1 << 20));
        assert!(need("a.gltf", 1000) >= 256 << 20);
        assert_eq!(need("a.glb", u64::MAX), u64::MAX);
    }

    #[test]
    fn the_documented_places_of_sprites_are_places() {
        #[derive(serde::Deserialize)]
        struct Document {
            places: Vec<crate::nodes::volumes::SpritePlace>,
        }
        let text = include_str!("../docs/scene.md");
        let (_, rest) = text.split_once("```toml places\n").unwrap();
        let document: Document = toml::from_str(rest.split("```").next().unwrap()).unwrap();
        crate::nodes::volumes::check(&document.places).unwrap();
        assert_eq!(document.places.len(), 2);
    }

    #[test]
    fn built_in_scenes_need_no_file() {
        let (scene, read, _) = run("builtin:solids", TRIANGLE);
        assert!(scene.unwrap().triangle_count() > 100);
        assert!(read.is_empty());
        let bad = Params { path: SourcePath("builtin:town".into()), ..Params::default() };
        let (param, text) = LoadScene::check(&bad).unwrap_err();
        assert_eq!(
            (param, text.as_str()),
            ("path", "there is no built-in scene `town`; there are car, city, park, solids")
        );
        assert_eq!(LoadScene::check(&Params::default()).unwrap_err().0, "path");
    }

    #[test]
    fn what_gives_no_scene_is_an_error() {
        assert_eq!(run("/w/no.glb", "").0.unwrap_err(), "/w/no.glb: no such file");
        assert_eq!(run("/w/locked.glb", "").0.unwrap_err(), "/w/locked.glb: permission denied");
        assert_eq!(run("/w/a.obj", "v 0 0 0\n").0.unwrap_err(), "/w/a.obj: the scene has no triangles");
    }

    /// A triangle of glTF's default sides whose texture claims 2000 × 2000 texels.
    const LARGE: &str = r#"{ "asset": { "version": "2.0" }, "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
        "textures": [{ "source": 0 }],
        "images": [{ "uri": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAB9AAAAfQCAYAAACaOMR5AAAAAElEQVQ1rwYeAAAAAElFTkSuQmCC" }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "byteLength": 36, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }] }"#;

    fn run_gltf(text: &'static str, sides: SidesOf, memory: u64) -> Result<Arc<Scene>, String> {
        let files = Files(text, Mutex::default());
        let params = Params { path: SourcePath("/w/a.gltf".into()), sides, ..Params::default() };
        let (out, _) = World { door: &files, memory, ..World::default() }.run::<LoadScene>(&params, In {});
        out.map(|o| o.scene).map_err(|e| e.to_string())
    }

    #[test]
    fn pictures_obey_the_memory_of_the_run() {
        assert_eq!(
            run_gltf(LARGE, SidesOf::File, 30_000_000).unwrap_err(),
            "/w/a.gltf: images[0], 2000 × 2000: 32000000 bytes to decode all images; the limit is 30000000; --memory \
             gives more"
        );
    }

    #[test]
    fn sides_are_the_files_or_both() {
        let plain = LARGE.replace(r#", "material": 0"#, "").leak();
        for (sides, both) in [(SidesOf::File, false), (SidesOf::Double, true)] {
            let scene = run_gltf(plain, sides, 1 << 20).unwrap();
            assert_eq!(scene.objects[0].parts[0].material.double_sided, both);
        }
    }
}
