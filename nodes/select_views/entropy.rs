//! The directions that show most.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    nodes::{
        backend,
        cameras::{self, Pictures},
    },
    ports,
    raster::Geometry,
    relief::{choose::greedy, entropy::Probe},
    scene::Scene,
    view::{View, directions},
};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Places orthographic cameras one after the other where most is seen that no other camera sees, measured by viewpoint entropy: strategy (b) of omni-directional relief
/// impostors (Andújar et al. 2007, section 3.1). The candidates are the 320 faces of a subdivided icosahedron. Faces that a chosen camera
/// sees count no more; once none are left, all count again. Directions that show little new get no camera, which an object that is seen from
/// anywhere may miss: `entropy-perturbed` keeps cameras on all sides.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Number of cameras.
    #[schemars(range(min = 1, max = 320), extend("x-unit" = "cameras"))]
    pub n: u32,
    /// Width and height of the pictures that directions are judged by. Faces below 16 pixels count with their exact projection.
    #[schemars(range(min = 64, max = 4096), extend("x-unit" = "pixels"))]
    pub ids: u32,
    /// Width and height of a relief map, texels.
    #[schemars(range(min = 4, max = 8192), extend("x-unit" = "texels"))]
    pub resolution: u32,
    /// Pixels of the picture along a side of a texel: 1, 2 or 4; those of `resample` `relief`. `resolution` times this is at most 16384.
    pub samples: u32,
    /// Kept free around the object.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-unit" = "texels"))]
    pub margin: f64,
}

impl Default for Params {
    fn default() -> Self {
        let Pictures { resolution, samples, margin } = Pictures::DEFAULT;
        Self { n: 20, ids: 256, resolution, samples, margin }
    }
}

impl Params {
    fn pictures(&self) -> Pictures {
        Pictures { resolution: self.resolution, samples: self.samples, margin: self.margin }
    }
}

ports! {
    pub struct In {
        /// What is looked at.
        scene: Arc<Scene>,
    }
}

ports! {
    pub struct Out {
        /// The cameras, under the names that `icosahedron` gives their directions, such as `v07` and `v07db`.
        views: List<View>,
    }
}

pub struct Entropy;

impl Node for Entropy {
    const KIND: &'static str = "select-views";
    const METHOD: &'static str = "entropy";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        // What 320 directions show: 8 bytes for each face of theirs, less than half of all. A face is stored in 18 bytes or more.
        (64 << 20) + sizes[0].saturating_mul(16 + 320 * 4 / 18) + u64::from(params.ids).pow(2) * 64
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        params.pictures().check()
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let geometry = Geometry::new(&inputs.scene);
        let points = inputs.scene.points();
        let probe = Probe::new(backend(ctx), &geometry, &points, params.ids).ok_or_else(cameras::nothing)?;
        let candidates = directions::named_geodesic(2);
        let directions: Vec<DVec3> = candidates.iter().map(|c| c.1).collect();
        let found = greedy(&probe, &directions, params.n as usize, ctx.stop)?;
        let mut blank: Vec<String> = found.blank.iter().map(|i| format!("`{}`", candidates[*i].0)).collect();
        blank.sort();
        cameras::warn_of_blank(ctx, &blank);
        let chosen = found.chosen.iter().map(|i| candidates[*i].clone()).collect();
        Ok(Out { views: cameras::around(&inputs.scene, chosen, params.pictures())? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::testing::run;

    #[test]
    fn cameras_are_those_of_the_icosahedron_set_under_its_names() {
        let scene = Arc::new(crate::scene::builtin::make("car", 1).unwrap());
        let params = Params { n: 6, ids: 64, resolution: 16, ..Params::default() };
        let views = run::<Entropy>(&params, In { scene: scene.clone() }).0.unwrap().views.0;
        assert_eq!(views.len(), 6);
        let all =
            cameras::around(&scene, directions::named_geodesic(2), params.pictures()).unwrap_or_else(|e| panic!("{e}"));
        assert!(views.iter().all(|named| all.0.contains(named)));
        // The same first cameras for every n.
        let three = run::<Entropy>(&Params { n: 3, ..params }, In { scene }).0.unwrap().views.0;
        assert!(three.len() == 3 && three.iter().all(|named| views.contains(named)));
    }

    #[test]
    fn an_empty_scene_is_an_error() {
        assert!(run::<Entropy>(&Params::default(), In { scene: Arc::default() }).0.is_err());
    }
}
