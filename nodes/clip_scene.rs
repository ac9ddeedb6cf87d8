//! `clip-scene`: a box cut out of a scene.

use crate::{
    engine::node::{Ctx, Node, NodeError},
    math::Aabb,
    ports,
    scene::{Scene, builtin, clip::cut_box},
};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Cuts a box out of a scene: triangles that reach into it are divided at its sides, and what lies inside goes. The cut stays open, so one looks into
/// what was cut. `volume` is the box itself, a closed solid: a depth sprite made of it shows the same while the scene is drawn, without dividing anything.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Two corners of the box, metres: `[[x, y, z], [x, y, z]]`. Required.
    pub region: Option<[[f64; 3]; 2]>,
}

ports! {
    pub struct In {
        /// What is cut.
        scene: Arc<Scene>,
    }
}

ports! {
    pub struct Out {
        /// What lies outside the box.
        scene: Arc<Scene>,
        /// The box.
        volume: Arc<Scene>,
    }
}

pub struct ClipScene;

impl Node for ClipScene {
    const KIND: &'static str = "clip-scene";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // At worst every triangle is divided.
        (1 << 20) + sizes.iter().sum::<u64>().saturating_mul(8)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        match params.region {
            None => Err(("region", "missing; expected two corners of the box, [[x, y, z], [x, y, z]]".into())),
            Some([a, b]) => match (0..3).find(|k| a[*k] == b[*k]) {
                Some(k) => Err(("region", format!("the box has no extent along {}", ["x", "y", "z"][k]))),
                None => Ok(()),
            },
        }
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let Some([a, b]) = params.region.map(|r| r.map(DVec3::from)) else {
            return Err(NodeError::Failed("region: missing".into()));
        };
        let bounds = Aabb { min: a.min(b), max: a.max(b) };
        let scene = cut_box(&inputs.scene, &bounds);
        if scene.triangle_count() == 0 {
            return Err(NodeError::Failed("nothing is left: the box holds the whole scene".into()));
        }
        if scene == *inputs.scene {
            (ctx.warn)(format!("nothing was cut: no triangle of the scene reaches into the box from {a} to {b}"));
        }
        Ok(Out { scene: Arc::new(scene), volume: Arc::new(builtin::closed_box(&bounds)) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::testing::{refused, run};

    fn cut(region: [[f64; 3]; 2]) -> (Result<Out, NodeError>, Vec<String>) {
        let scene = Arc::new(builtin::make("car", 1).unwrap());
        run::<ClipScene>(&Params { region: Some(region) }, In { scene })
    }

    #[test]
    fn a_box_is_cut_out() {
        let car = builtin::make("car", 1).unwrap();
        let (lo, hi) = (car.bounds().min - 1.0, car.bounds().centre());
        // Corners in any order.
        let Out { scene, volume } = cut([hi.into(), lo.into()]).0.unwrap();
        assert_eq!(volume.bounds(), Aabb { min: lo.as_vec3().as_dvec3(), max: hi.as_vec3().as_dvec3() });
        assert_eq!(volume.triangle_count(), 12);
        assert!(scene.triangle_count() != car.triangle_count());
        let corner = Aabb { min: lo, max: hi - 1e-3 };
        assert!(crate::scene::clip::clip_scene(&scene, &corner).objects.is_empty());
    }

    #[test]
    fn a_box_that_cuts_nothing_or_all_is_said() {
        let (out, warnings) = cut([[90.0; 3], [91.0; 3]]);
        assert!(out.is_ok() && warnings.len() == 1 && warnings[0].contains("nothing was cut"), "{warnings:?}");
        let error = cut([[-90.0; 3], [90.0; 3]]).0.err().unwrap().to_string();
        assert!(error.contains("nothing is left"), "{error}");
        assert!(refused::<ClipScene>(&Params::default()).is_some());
        assert!(refused::<ClipScene>(&Params { region: Some([[0.0; 3], [1.0, 0.0, 1.0]]) }).is_some());
    }
}
