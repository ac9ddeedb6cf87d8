//! Kinds that do nothing, for checks of pipeline files.

use farfield::{
    engine::{
        artifact::{Artifact, DecodeError, Decoder, Encoder},
        node::{Ctx, Head, List, Measure, Node, NodeError, SourcePath},
        plan::{File, Relation},
        registry::{Planned, Registry, Renamed},
    },
    ports,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{path::Path, sync::Arc};

macro_rules! value {
    ($($name:ident)*) => { $(
        pub struct $name;
        impl Artifact for $name {
            const TYPE: &'static str = stringify!($name);
            const FORMAT: u32 = 1;
            fn encode(&self, _: &mut Encoder) {}
            fn decode(_: &Decoder) -> Result<Self, DecodeError> {
                Ok(Self)
            }
        }
    )* };
}
value!(Scene Mesh Cell);

macro_rules! node {
    ($kind:ident, $name:literal $($method:literal)?, $params:ty, $in:ty, $out:ty $(, $check:expr)?) => {
        pub struct $kind;
        impl Node for $kind {
            const KIND: &'static str = $name;
            $(const METHOD: &'static str = $method;)?
            const VERSION: u32 = 1;
            type Params = $params;
            type In = $in;
            type Out = $out;
            fn memory(_: &Self::Params, _: &[u64]) -> u64 {
                0
            }
            $(fn check(params: &Self::Params) -> Result<(), (&'static str, String)> {
                $check(params)
            })?
            fn run(_: &Self::Params, _: $in, _: &Ctx) -> Result<$out, NodeError> {
                Err(NodeError::Failed("only for checks".into()))
            }
        }
    };
}

/// Loads.
#[derive(Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LoadParams {
    /// The file.
    pub path: SourcePath,
}

/// Collapses.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CollapseParams {
    /// How far.
    #[schemars(range(min = 1.0, max = 8.0))]
    pub factor: f64,
    /// Most layers.
    #[schemars(range(min = 1))]
    pub max_layers: u32,
    /// How.
    pub policy: Policy,
    /// Whether walls stay.
    pub keep_walls: bool,
    /// Where from, in metres.
    pub centre: Option<[f64; 3]>,
    /// A label.
    pub label: String,
    /// Limits.
    pub limits: Limits,
}

impl Default for CollapseParams {
    fn default() -> Self {
        Self {
            factor: 2.0,
            max_layers: 100,
            policy: Policy::VoxelCover,
            keep_walls: false,
            centre: None,
            label: String::new(),
            limits: Limits::default(),
        }
    }
}

/// How to collapse.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Policy {
    /// Covers.
    VoxelCover,
    /// Quadrics.
    Quadric,
}

/// Limits.
#[derive(Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// In degrees.
    pub angle: f64,
}

/// Nothing.
#[derive(Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Nothing {}

/// Keeps edges. More is not said here.
#[derive(Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SharpParams {
    /// In degrees.
    pub angle: f64,
    /// How far.
    pub factor: f64,
}

/// Keeps curves.
#[derive(Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SmoothParams {
    /// How far.
    pub factor: f64,
}

/// Seeds.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SeedParams {
    /// A seed.
    pub seed: u64,
}

ports! { pub struct None {} }
ports! { pub struct OneScene {
    /// A scene.
    scene: Arc<Scene>,
} }
ports! { pub struct OneMesh {
    /// A mesh.
    mesh: Arc<Mesh>,
    /// A cell.
    cell: Option<Arc<Cell>>,
} }
ports! { pub struct MeshOut {
    /// A mesh.
    mesh: Arc<Mesh>,
    /// A picture of it.
    picture: Arc<File>,
} }
ports! { pub struct Meshes {
    /// Meshes.
    meshes: List<Mesh>,
} }
ports! { pub struct MeshesIn {
    /// Meshes.
    meshes: List<Mesh>,
    /// A scene.
    scene: Option<Arc<Scene>>,
} }
ports! { pub struct Cells {
    /// Cells.
    cells: List<Cell>,
    /// Which are side by side.
    neighbours: Arc<Relation>,
} }
ports! { pub struct Written {
    /// A file.
    file: Arc<File>,
    /// What was measured.
    certificate: Arc<File>,
} }
ports! { pub struct PairIn {
    /// A mesh.
    mesh: Arc<Mesh>,
    /// A cell.
    cell: Arc<Cell>,
} }
ports! { pub struct ViewsIn {
    /// A cell.
    cell: Arc<Cell>,
    /// Meshes of it and of others.
    meshes: List<Mesh>,
} }

fn judge(params: &CollapseParams) -> Result<(), (&'static str, String)> {
    if params.factor > 4.0 && params.keep_walls {
        return Err(("factor", format!("{} is too far while walls are kept; at most 4", params.factor)));
    }
    Ok(())
}

node!(Load, "load-scene", LoadParams, None, OneScene);
node!(Mesher, "voxel-mesh", Nothing, OneScene, Meshes);
node!(Collapse, "collapse", CollapseParams, OneMesh, MeshOut, judge);
node!(Sharp, "simplify" "sharp", SharpParams, OneMesh, MeshOut);
node!(Smooth, "simplify" "smooth", SmoothParams, OneMesh, MeshOut);
node!(Round, "bend" "round", Nothing, OneMesh, MeshOut);
node!(HexCells, "hex-cells", Nothing, OneScene, Cells);
node!(Pair, "pair", Nothing, PairIn, MeshOut);
node!(Neighbours, "neighbours", Nothing, ViewsIn, MeshOut);
node!(Write, "write-glb", Nothing, MeshesIn, Written);
node!(Single, "single-mesh", Nothing, None, MeshOut);
node!(Make, "make-scene", SeedParams, None, OneScene);

/// Judges a file that begins with `scene`.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct JudgeParams {
    /// The file.
    pub path: SourcePath,
    /// Degrees.
    pub fov: f64,
}

impl Default for JudgeParams {
    fn default() -> Self {
        Self { path: SourcePath("builtin:x".into()), fov: 45.0 }
    }
}

pub struct Judge;

impl Node for Judge {
    const KIND: &'static str = "judge";
    const VERSION: u32 = 1;
    type Params = JudgeParams;
    type In = None;
    type Out = Written;
    fn memory(_: &JudgeParams, _: &[u64]) -> u64 {
        0
    }
    fn doubts(params: &JudgeParams) -> Vec<(&'static str, String)> {
        if params.fov < 5.0 { vec![("fov", "degrees are meant".into())] } else { Vec::new() }
    }
    fn check_source(_: &str, _: &Path, head: Head) -> Result<(), String> {
        let is = head.bytes.starts_with(b"scene");
        if is { Ok(()) } else { Err(format!("is no scene ({} bytes, whole: {})", head.bytes.len(), head.whole)) }
    }
    fn measures() -> Vec<Measure> {
        let measure = |path: &str| Measure { path: path.into(), about: format!("about {path}"), ..Measure::default() };
        ["crack_px.ratio", "crack_px.total", "psnr_y_object_db.mean", "psnr_y_object_db.min"].map(measure).into()
    }
    fn run(_: &JudgeParams, _: None, _: &Ctx) -> Result<Written, NodeError> {
        Err(NodeError::Failed("only for checks".into()))
    }
}

pub fn registry() -> Registry {
    const PLANNED: [Planned; 1] = [Planned { kind: "simplify", methods: &["silky"] }];
    const RENAMED: [Renamed; 2] = [
        Renamed { kind: "soften", param: "", now: "kind = \"simplify\" and method = \"smooth\"" },
        Renamed { kind: "simplify", param: "style", now: "method = \"sharp\" or method = \"smooth\"" },
    ];
    let mut r = Registry::new(&PLANNED, &RENAMED);
    r.add::<Load>();
    r.add::<Mesher>();
    r.add::<Collapse>();
    r.add::<Sharp>();
    r.add::<Smooth>();
    r.add::<Round>();
    r.add::<HexCells>();
    r.add::<Pair>();
    r.add::<Neighbours>();
    r.add::<Write>();
    r.add::<Make>();
    r.add::<Single>();
    r.add::<Judge>();
    r
}
