//! Relief impostors of the parts of an object as one bundle.

use crate::{
    engine::{
        node::{Ctx, List, Node, NodeError},
        plan::{Bundle, File},
    },
    formats::{GlbOptions, write_glb},
    nodes::json_bytes,
    ports,
    runtime::{
        ori::{self, RegionRow, TREE_FORMAT, TREE_NAME, TREE_VERSION, TreeManifest},
        shader_files, shader_names,
    },
    scene::{Scene, split::RegionTree},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{collections::BTreeMap, sync::Arc};

/// Writes the relief impostors of a tree of regions as one stand-in: `ori-tree.json` with the boxes, thresholds and children of the regions, a folder with the
/// impostor of each, and for regions without children a mesh for near eyes. Source: Andújar et al., Omni-directional Relief Impostors, 2007, section 5.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Regions whose impostor bears this many pixels are not divided: what lies below them is left out. 0 keeps all regions.
    #[schemars(range(min = 0.0, max = 1e9), extend("x-unit" = "px"))]
    pub stop_plt: f64,
    /// Writes the meshes of regions without children, which are drawn where their impostors are not good enough.
    pub meshes: bool,
}

impl Default for Params {
    fn default() -> Self {
        Self { stop_plt: 0.0, meshes: true }
    }
}

ports! {
    pub struct In {
        /// The regions.
        tree: Arc<RegionTree>,
        /// What lies in each of them.
        regions: List<Scene>,
        /// Their impostors, by the regions' names.
        impostors: List<Bundle>,
    }
}

ports! {
    pub struct Out {
        /// The stand-in's files; `ori-tree.json` is the one to open first.
        bundle: Arc<Bundle>,
    }
}

pub struct OriTree;

impl Node for OriTree {
    const KIND: &'static str = "write";
    const METHOD: &'static str = "ori-tree";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        (64 << 20) + sizes.iter().sum::<u64>().saturating_mul(3)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let failed = |what: String| NodeError::Failed(what);
        let impostor = |name: &str| {
            let found = inputs.impostors.0.iter().find(|(n, _)| n == name);
            found.map(|(_, b)| b).ok_or_else(|| failed(format!("region `{name}` has no impostor")))
        };
        let region = |name: &str| inputs.regions.0.iter().find(|(n, _)| n == name).map(|(_, s)| s);
        let mut files: BTreeMap<String, File> = BTreeMap::new();
        let mut rows: Vec<RegionRow> = Vec::new();
        let mut open = vec!["root".to_owned()];
        while let Some(name) = open.pop() {
            ctx.stop.check()?;
            let node = inputs.tree.regions.iter().find(|r| r.name == name);
            let node = node.ok_or_else(|| failed(format!("the tree has no region `{name}`")))?;
            let bundle = impostor(&name)?;
            let manifest = bundle.files().get(bundle.main()).map(|f| &f.bytes[..]).unwrap_or_default();
            let plt = ori::stated_threshold(manifest).map_err(|e| NodeError::from_error(&e))?;
            let divided = params.stop_plt == 0.0 || plt < params.stop_plt;
            let children = if divided { node.children.clone() } else { Vec::new() };
            for (path, file) in bundle.files() {
                files.insert(format!("{name}/{path}"), file.clone());
            }
            let mut mesh = None;
            if children.is_empty() && params.meshes {
                let scene = region(&name).ok_or_else(|| failed(format!("region `{name}` has no scene")))?;
                let bytes = write_glb(scene, &GlbOptions { unlit: false, normal_maps: true })
                    .map_err(|e| NodeError::from_error(&e))?;
                let path = format!("{name}/mesh.glb");
                files.insert(path.clone(), File { media_type: "model/gltf-binary".into(), bytes });
                mesh = Some(path);
            }
            open.extend(children.iter().rev().cloned());
            rows.push(RegionRow {
                bounds: node.bounds,
                plt_px: plt.is_finite().then_some(plt),
                children,
                folder: name.clone(),
                mesh,
                name,
            });
        }
        for f in shader_files(&ori::SHADERS) {
            files.insert(f.path, File { media_type: f.media.into(), bytes: f.bytes });
        }
        let manifest = TreeManifest {
            format: TREE_FORMAT.into(),
            version: TREE_VERSION,
            regions: rows,
            shaders: shader_names(&ori::SHADERS),
        };
        let json = serde_json::to_value(&manifest).map_err(|e| NodeError::from_error(&e))?;
        files.insert(TREE_NAME.into(), File { media_type: "application/json".into(), bytes: json_bytes(&json)? });
        Ok(Out { bundle: Arc::new(Bundle::new(TREE_NAME, files).map_err(NodeError::Failed)?) })
    }
}
