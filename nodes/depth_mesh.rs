//! `depth-mesh`: captures as adaptively triangulated meshes.

use crate::{
    capture::Capture,
    depth_mesh::{
        DepthRange, Distance, ErrorMeasure, LayerError, MeshedView, Meshing, Options, Propagation, Segmentation,
        mesh_capture,
    },
    engine::node::{Ctx, Node, NodeError},
    ports,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Turns every layer of a capture into a textured triangle mesh: a restricted quadtree over its pixels, as fine as the tolerance asks, without the
/// triangles that would stretch between different surfaces. Source: Pajarola, Sainz and Meng, DMesh, 2003, sections 4 and 5.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// ε: how far the mesh may lie from the captured surface, as a share of the diagonal of the scene's bounding box. 0 keeps all that is not flat.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub epsilon: f64,
    /// What the error of a grid point says.
    pub error: ErrorMeasure,
    /// How distances are measured.
    pub distance: Distance,
    /// Which triangles stretch between surfaces.
    pub segmentation: Segmentation,
    /// κ of `connectedness`: least error of the predicted depth over the length of an edge, for which it is cut.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub kappa: f64,
    /// σ of `disparity`: least change of the relative slope of depth at a corner, for which it counts.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub sigma: f64,
    /// ω of `orthogonality`: triangles seen at less than this angle are cut, degrees.
    #[schemars(range(min = 0.0, max = 90.0))]
    pub omega: f64,
    /// What `lambda` is a share of.
    pub depth_range: DepthRange,
    /// λ: triangles that span less depth are never cut. A share of the box's largest extent with `depth_range = "absolute"`, of the
    /// triangle's depth with `"relative"`. The paper's experiments use 0.05, which leaves steps of up to 25 pixels as rubber sheets.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub lambda: f64,
    /// What a cut triangle does to the coarser ones that stand for it.
    pub propagation: Propagation,
    /// What happens to captures whose sides are not 2^k + 1 pixels.
    pub size: Size,
}

/// What happens to captures whose sides are not 2^k + 1 pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Size {
    /// They are an error.
    #[default]
    Refuse,
    /// They are resampled to the next larger such size, each pixel from its nearest one.
    Resample,
}

impl Default for Params {
    fn default() -> Self {
        let Options { error, distance, segmentation, kappa, sigma, omega, depth_range, propagation, .. } =
            Options::default();
        Self {
            epsilon: 0.001,
            error,
            distance,
            segmentation,
            // Their decimal values, not those of the nearest 32-bit floats.
            kappa: decimal(kappa),
            sigma: decimal(sigma),
            omega: decimal(omega),
            depth_range,
            lambda: 0.02,
            propagation,
            size: Size::Refuse,
        }
    }
}

fn decimal(v: f32) -> f64 {
    (f64::from(v) * 1e6).round() / 1e6
}

ports! {
    pub struct In {
        /// What one camera sees.
        capture: Arc<Capture>,
    }
}

ports! {
    pub struct Out {
        /// Its layers as meshes, with their pictures.
        meshes: Arc<MeshedView>,
    }
}

pub struct DepthMesh;

impl Node for DepthMesh {
    const KIND: &'static str = "depth-mesh";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // A capture takes 28 bytes a pixel and layer; one layer's hierarchy, mesh and pictures about five times as much.
        (16 << 20) + sizes[0].saturating_mul(6)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let capture = &*inputs.capture;
        let size = capture.bounds.max - capture.bounds.min;
        let extent = if capture.bounds.is_empty() { 0.0 } else { size.max_element() };
        let lambda = match params.depth_range {
            DepthRange::Absolute => params.lambda * extent,
            DepthRange::Relative => params.lambda,
        };
        let options = Options {
            error: params.error,
            distance: params.distance,
            segmentation: params.segmentation,
            kappa: params.kappa as f32,
            sigma: params.sigma as f32,
            omega: params.omega as f32,
            depth_range: params.depth_range,
            lambda: lambda as f32,
            propagation: params.propagation,
        };
        let epsilon = (params.epsilon * capture.bounds.diagonal()) as f32;
        let resample = params.size == Size::Resample;
        let meshed = mesh_capture(capture, &Meshing { options, epsilon, resample }, ctx.stop);
        let meshed = meshed.map_err(|e| match e {
            LayerError::Stopped(stopped) => NodeError::Stopped(stopped),
            LayerError::Map(e) if !resample => NodeError::Failed(format!("{e}; size = \"resample\" takes other sizes")),
            e => NodeError::from_error(&e),
        })?;
        let (was, is) = (&capture.view, &meshed.view);
        if (was.width, was.height) != (is.width, is.height) {
            (ctx.warn)(format!(
                "the capture of {} × {} pixels was resampled to {} × {}",
                was.width, was.height, is.width, is.height
            ));
        }
        if meshed.layers.is_empty() {
            (ctx.warn)("this view has no mesh: no surface of it spans a triangle".into());
        }
        Ok(Out { meshes: Arc::new(meshed) })
    }
}
