//! Regular directions, moved to where pictures tell more.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    nodes::{
        backend,
        cameras::{self, Pictures},
    },
    ports,
    raster::Geometry,
    relief::{
        choose::{Perturbation, perturb},
        entropy::Probe,
    },
    scene::Scene,
    view::{View, directions},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Places orthographic cameras in the directions of an icosahedron's faces, each moved to where its picture tells more and changes least: strategy (c) of
/// omni-directional relief impostors (Andújar et al. 2007, section 3.1). The score of a direction is its viewpoint entropy less `stability` times the share of the
/// picture that shows unseen faces after a turn of 2°. Directions are tried in steps of 2°, uphill from the regular one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// How far a direction may move; 0 keeps the regular ones.
    #[schemars(range(min = 0.0, max = 15.0), extend("x-unit" = "degrees"))]
    pub reach: f64,
    /// Bits of entropy that are given up for a picture in which a turn of 2° reveals nothing, where it revealed faces that fill it.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-unit" = "bits"))]
    pub stability: f64,
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
        Self { reach: 4.0, stability: 10.0, ids: 256, resolution, samples, margin }
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
        /// The cameras, by the number of the icosahedron's face that they come from, such as `v07`.
        views: List<View>,
    }
}

pub struct EntropyPerturbed;

impl Node for EntropyPerturbed {
    const KIND: &'static str = "select-views";
    const METHOD: &'static str = "entropy-perturbed";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        // Faces and vertices in 64 bits; for each thread a picture, its triangles and what up to 37 directions show.
        (64 << 20) + sizes[0].saturating_mul(16) + u64::from(params.ids).pow(2) * 64
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        params.pictures().check()
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let geometry = Geometry::new(&inputs.scene);
        let points = inputs.scene.points();
        let probe = Probe::new(backend(ctx), &geometry, &points, params.ids).ok_or_else(cameras::nothing)?;
        let (names, regular): (Vec<_>, Vec<_>) = directions::named_geodesic(0).into_iter().unzip();
        let how = Perturbation { reach: params.reach, stability: params.stability };
        let moved = perturb(&probe, &regular, how, ctx.stop)?;
        let blank: Vec<_> = names.iter().zip(&moved).filter(|(_, m)| m.blank).map(|(n, _)| format!("`{n}`")).collect();
        cameras::warn_of_blank(ctx, &blank);
        let directions = names.into_iter().zip(moved.iter().map(|m| m.direction)).collect();
        Ok(Out { views: cameras::around(&inputs.scene, directions, params.pictures())? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::testing::{refused, run};

    fn car() -> Arc<Scene> {
        Arc::new(crate::scene::builtin::make("car", 1).unwrap())
    }

    fn small() -> Params {
        Params { ids: 64, resolution: 16, ..Params::default() }
    }

    #[test]
    fn cameras_stay_within_reach() {
        let regular = directions::icosahedron();
        let views =
            |reach: f64| run::<EntropyPerturbed>(&Params { reach, ..small() }, In { scene: car() }).0.unwrap().views.0;
        let angles = |reach: f64| -> Vec<f64> {
            let views = views(reach);
            assert!(views.len() == 20 && views.is_sorted_by(|a, b| a.0 < b.0));
            views.iter().zip(&regular).map(|((_, v), d)| v.forward.cross(*d).length()).collect()
        };
        let most = libm::sin(4.001_f64.to_radians());
        let moved = angles(4.0);
        assert!(moved.iter().all(|a| *a <= most) && moved.iter().any(|a| *a > 0.01), "{moved:?}");
        assert!(angles(0.0).iter().all(|a| *a < 1e-9));
    }

    #[test]
    fn flat_objects_are_looked_at_from_their_edge_with_a_warning() {
        let mesh = crate::scene::Mesh {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].into(),
            triangles: vec![[0, 1, 2]].into(),
            ..crate::scene::Mesh::default()
        };
        let part = crate::scene::Part { mesh: Arc::new(mesh), material: Arc::default() };
        // One of the icosahedron's faces looks along the triangle's plane.
        let edge = directions::icosahedron()[0];
        let turn = glam::Quat::from_rotation_arc(glam::Vec3::X, edge.as_vec3());
        let object = |turn| crate::scene::Object {
            name: "card".into(),
            transform: glam::Mat4::from_quat(turn),
            parts: vec![part.clone()],
        };
        let scene = Arc::new(Scene { objects: vec![object(turn)] });
        let params = Params { reach: 0.0, ..small() };
        let (out, warnings) = run::<EntropyPerturbed>(&params, In { scene });
        assert_eq!(out.unwrap().views.0.len(), 20);
        assert!(warnings.len() == 1 && warnings[0].contains("`v00`"), "{warnings:?}");
        let nothing = run::<EntropyPerturbed>(&params, In { scene: Arc::default() }).0;
        assert!(nothing.is_err_and(|e| e.to_string().contains("no triangles")));
    }

    #[test]
    fn ranges_are_checked() {
        for (params, name) in [
            (Params { reach: 16.0, ..small() }, "reach"),
            (Params { ids: 32, ..small() }, "ids"),
            (Params { stability: -1.0, ..small() }, "stability"),
            (Params { samples: 0, ..small() }, "samples"),
        ] {
            assert_eq!(refused::<EntropyPerturbed>(&params).as_deref(), Some(name));
        }
    }
}
