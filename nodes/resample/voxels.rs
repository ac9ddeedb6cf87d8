//! Textures from the voxels that a mesh covers.

use crate::{
    engine::node::{Ctx, Node, NodeError},
    mesh::ChartedMesh,
    ports,
    voxel::{
        Slices, VoxelMesh,
        resample::{ResampleError, Settings, resample},
    },
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Textures a simplified mesh from the voxels that it covers, and puts its vertices to their places in the world
/// (Jeschke and Wimmer 2002, sections 7 and 8). Texels lie on the world-space faces, so an ordinary renderer with
/// perspective correction shows them where the voxels were. Where the mesh was simplified with `silhouette = "alpha"`, a texel's alpha is the share of
/// the surface that the viewer's ray meets: 255 inside of it, 0 beyond its ends.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// How many of the nearest voxels are averaged for a texel, 1 to 16: 1 is sharp, 4 (as in the paper's figure 15)
    /// smoother.
    #[schemars(range(min = 1, max = 16), extend("x-unit" = "voxels"))]
    pub n: u32,
    /// Side of a texel in voxel sides, 0.125 to 8. Smaller texels make a sharper and larger atlas.
    #[schemars(range(min = 0.125, max = 8.0), extend("x-unit" = "voxel sides"))]
    pub texel: f64,
    /// Texels around the faces of a chart, 2 to 64, so that filtering never reads beyond it.
    #[schemars(range(min = 2, max = 64), extend("x-unit" = "texels"))]
    pub margin: u32,
    /// Largest side of a chart in texels, 16 to 8192, margins included. With its gutter it must fit on an atlas page.
    #[schemars(range(min = 16, max = 8192), extend("x-unit" = "texels"))]
    pub max_chart: u32,
    /// Also make a normal map, so that the stand-in can be lit.
    pub normal_map: bool,
}

impl Default for Params {
    fn default() -> Self {
        Self { n: 4, texel: 1.0, margin: 2, max_chart: 2032, normal_map: false }
    }
}

ports! {
    pub struct In {
        /// A connected mesh over voxels, simplified or not.
        mesh: Arc<VoxelMesh>,
        /// The frusta and layers of its voxels.
        slices: Arc<Slices>,
    }
}

ports! {
    pub struct Out {
        /// The mesh in the world, with its texels in charts.
        charted: Arc<ChartedMesh>,
    }
}

pub struct Voxels;

impl Node for Voxels {
    const KIND: &'static str = "resample";
    const METHOD: &'static str = "voxels";
    const VERSION: u32 = 6;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        // A voxel of 20 bytes has a share of a face's list and about one texel of 24 bytes while it is made.
        let texels = (1.0 / (params.texel * params.texel)).max(1.0) as u64;
        sizes.first().copied().unwrap_or(0).saturating_mul(2 + 2 * texels)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        let least = 2 * params.margin + 8;
        if params.max_chart < least {
            let what = format!(
                "expected {least} to 8192 texels with a margin of {}, found {}",
                params.margin, params.max_chart
            );
            return Err(("max_chart", what));
        }
        Ok(())
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let settings = Settings {
            n: params.n as usize,
            texel: params.texel,
            margin: params.margin,
            max_size: params.max_chart,
            normals: params.normal_map,
        };
        let charted = resample(&inputs.mesh, &inputs.slices, &settings, ctx.stop).map_err(|e| match e {
            ResampleError::Stopped(s) => NodeError::Stopped(s),
            other => NodeError::from_error(&other),
        })?;
        Ok(Out { charted: Arc::new(charted) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::testing::refused;

    #[test]
    fn ranges_are_checked() {
        assert_eq!(refused::<Voxels>(&Params::default()), None);
        let bad: [(&str, Params); 6] = [
            ("n", Params { n: 0, ..Params::default() }),
            ("n", Params { n: 17, ..Params::default() }),
            ("texel", Params { texel: 0.0, ..Params::default() }),
            ("", Params { texel: f64::NAN, ..Params::default() }),
            ("margin", Params { margin: 1, ..Params::default() }),
            ("max_chart", Params { margin: 64, max_chart: 130, ..Params::default() }),
        ];
        for (name, params) in bad {
            assert_eq!(refused::<Voxels>(&params).as_deref(), Some(name));
        }
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod whole;
