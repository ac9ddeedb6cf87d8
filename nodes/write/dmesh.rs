//! Depth-meshes as a bundle.

use crate::{
    depth_mesh::{MeshedLayer, MeshedView},
    engine::{
        node::{Ctx, List, Node, NodeError},
        plan::Bundle,
    },
    nodes::bundle,
    ports,
    runtime::dmesh::{self, Blending, Frames, Reference, Weights},
    scene::Image,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Writes the depth-meshes of several cameras as one stand-in: `dmesh.json` with cameras, weights and files; for each camera and layer a GLB
/// file, a normal map and a depth image; `dmesh.glb` with all of them for ordinary viewers; the shaders that blend them. Source: Pajarola,
/// Sainz and Meng, DMesh, 2003, section 6.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// How the references of a view are weighted.
    pub weights: Weights,
    /// Fragments count by the quality of their vertices, how squarely the camera saw them.
    pub quality: bool,
    /// How far behind the nearest surface others still blend with it, as a share of the diagonal of the scene's bounding box. Without it
    /// twice the tolerance of the meshes, and a texel of the reference.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub offset: Option<f64>,
    /// Writes normal maps, with which the stand-in can be lit.
    pub normal_maps: bool,
    /// Writes depth images, from which a program can make meshes for a view.
    pub depth_images: bool,
    /// τ: the tolerance of meshes that are made for a view, pixels.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub tau: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            weights: Weights::Positional,
            quality: true,
            offset: None,
            normal_maps: true,
            depth_images: true,
            tau: 1.0,
        }
    }
}

ports! {
    pub struct In {
        /// The meshes of each camera, by its name.
        meshes: List<MeshedView>,
    }
}

ports! {
    pub struct Out {
        /// The stand-in's files; `dmesh.json` is the one to open first.
        bundle: Arc<Bundle>,
    }
}

pub struct Dmesh;

impl Node for Dmesh {
    const KIND: &'static str = "write";
    const METHOD: &'static str = "dmesh";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // Pictures are stored twice, with each reference and with all of them.
        (64 << 20) + sizes.iter().sum::<u64>().saturating_mul(3)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let views = &inputs.meshes.0;
        let mut references = Vec::new();
        let mut strips = Vec::new();
        let mut depths = Vec::new();
        for (name, view) in views {
            for layer in &view.layers {
                references.push(reference(params, name, view, layer));
                strips.push(layer.mesh.strips.len() as u64);
                depths.push(layer.depth.clone());
            }
        }
        ctx.stop.check()?;
        if references.is_empty() {
            let what = "no camera has a mesh: nothing of the scene is seen, or all of it was cut";
            return Err(NodeError::Failed(what.into()));
        }
        // One box and one way of meshing for all: that of the first.
        let (_, first) = &views[0];
        if let Some((name, _)) = views.iter().find(|(_, v)| v.options != first.options || v.epsilon != first.epsilon) {
            let what = format!("`{name}` was meshed with other parameters than `{}`", views[0].0);
            return Err(NodeError::Failed(what));
        }
        let dmesh = dmesh::Dmesh {
            references,
            epsilon: first.epsilon.into(),
            diagonal: views.iter().map(|(_, v)| v.diagonal).fold(0.0, f64::max),
            double_sided: views.iter().any(|(_, v)| v.double_sided),
        };
        let blending = Blending {
            weights: params.weights,
            quality: params.quality,
            offset: params.offset.map(|share| share * dmesh.diagonal),
        };
        let frames = params.depth_images.then(|| Frames { tau: params.tau, options: first.options.clone(), depths });
        let files = dmesh::write(&dmesh, &blending, &strips, frames.as_ref()).map_err(|e| NodeError::from_error(&e))?;
        Ok(Out { bundle: bundle(files)? })
    }
}

/// A layer as the runtime draws it. Layers behind the first are named `pos-x.2` and so on.
fn reference(params: &Params, name: &str, view: &MeshedView, layer: &MeshedLayer) -> Reference {
    let name = match layer.layer {
        0 => name.to_owned(),
        n => format!("{name}.{}", n + 1),
    };
    let image = |texels: &crate::array::Array<[u8; 4]>| {
        Arc::new(Image {
            name: String::new(),
            width: view.view.width,
            height: view.view.height,
            texels: texels.clone(),
        })
    };
    Reference {
        name,
        view: view.view,
        mesh: Arc::new(layer.mesh.clone().into()),
        color: image(&layer.color),
        normal_map: params.normal_maps.then(|| image(&layer.normal)),
    }
}
