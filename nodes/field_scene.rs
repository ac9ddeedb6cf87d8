//! `field-scene`: the uncollapsed field as a scene.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    ports,
    scene::Scene,
    voxel::{
        Slices, VoxelMesh,
        field_scene::{FieldSceneError, field_scene},
    },
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The initial meshes before simplification, with vertex colours: an upper bound for the quality of any simplified version. The
/// certificate gives its figures beside the stand-in's as the ceiling.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {}

ports! {
    pub struct In {
        /// Connected voxel meshes before simplification.
        meshes: List<VoxelMesh>,
        /// The frusta and layers of their voxels.
        slices: Arc<Slices>,
        /// Geometry nearer than the first layer, which is kept unchanged; added as it is.
        near: Option<Arc<Scene>>,
    }
}

ports! {
    pub struct Out {
        /// One object per mesh, and those of `near`.
        scene: Arc<Scene>,
    }
}

pub struct FieldScene;

impl Node for FieldScene {
    const KIND: &'static str = "field-scene";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        sizes.first().copied().unwrap_or(0)
    }

    fn run(_: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let meshes: Vec<_> = inputs.meshes.0.iter().map(|(name, m)| (name.as_str(), m.as_ref())).collect();
        let mut scene = field_scene(&meshes, &inputs.slices, ctx.stop).map_err(|e| match e {
            FieldSceneError::Stopped(s) => NodeError::Stopped(s),
            other => NodeError::from_error(&other),
        })?;
        for object in inputs.near.iter().flat_map(|n| &n.objects) {
            let mut object = object.clone();
            // Names of meshes are of this program's making, those of objects the user's: the latter give way.
            while scene.objects.iter().any(|o| o.name == object.name) {
                object.name.push_str(" near");
            }
            scene.objects.push(object);
        }
        scene.objects.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(Out { scene: Arc::new(scene) })
    }
}
