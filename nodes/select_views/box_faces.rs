//! Cameras around the bounding box.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    math::Aabb,
    ports,
    raster::MAX_SIDE,
    scene::Scene,
    view::{Projection, View},
};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Places a camera outside each face of the scene's bounding box, so that its picture holds the whole box: the six reference views of an
/// image-based object (Pajarola, Sainz and Meng 2003, section 6.1). Other cameras can be added.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Width and height of a picture, pixels; depth-meshes need 2^k + 1.
    #[schemars(range(min = 2, max = 16384))]
    pub resolution: u32,
    /// How the faces' cameras project.
    pub projection: Lens,
    /// Field of view of the faces' cameras, degrees. Up to 50° the quick error measure of depth-meshes holds.
    #[schemars(range(min = 1.0, max = 120.0))]
    pub fov: f64,
    /// Pixels kept free around the box.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub margin: f64,
    /// Faces that get a camera.
    pub faces: Vec<Face>,
    /// Further perspective cameras, one table each: `{ name = "low", eye = [3, 0.5, 2], target = [0, 0, 0], fov = 40 }`.
    pub more: Vec<Extra>,
}

/// How a camera projects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Lens {
    #[default]
    Perspective,
    Orthographic,
}

/// A face of the box, by the direction that it faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Face {
    PosX,
    NegX,
    PosY,
    NegY,
    PosZ,
    NegZ,
}

impl Face {
    const ALL: [Self; 6] = [Self::PosX, Self::NegX, Self::PosY, Self::NegY, Self::PosZ, Self::NegZ];

    fn name(self) -> &'static str {
        match self {
            Self::PosX => "pos-x",
            Self::NegX => "neg-x",
            Self::PosY => "pos-y",
            Self::NegY => "neg-y",
            Self::PosZ => "pos-z",
            Self::NegZ => "neg-z",
        }
    }

    /// Outwards.
    fn direction(self) -> DVec3 {
        match self {
            Self::PosX => DVec3::X,
            Self::NegX => DVec3::NEG_X,
            Self::PosY => DVec3::Y,
            Self::NegY => DVec3::NEG_Y,
            Self::PosZ => DVec3::Z,
            Self::NegZ => DVec3::NEG_Z,
        }
    }
}

/// A camera that is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Extra {
    /// Unlike all others: letters, digits and `-_.`.
    pub name: String,
    /// Metres.
    pub eye: [f64; 3],
    /// What it looks at, metres.
    pub target: [f64; 3],
    /// Field of view, degrees; that of the faces where it is left out.
    #[serde(default)]
    pub fov: Option<f64>,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            resolution: 513,
            projection: Lens::Perspective,
            fov: 45.0,
            margin: 1.0,
            faces: Face::ALL.to_vec(),
            more: Vec::new(),
        }
    }
}

ports! {
    pub struct In {
        /// What is looked at; only its bounding box matters.
        scene: Arc<Scene>,
    }
}

ports! {
    pub struct Out {
        /// The cameras, by the direction that their face looks in, such as `pos-x`.
        views: List<View>,
    }
}

pub struct BoxFaces;

impl Node for BoxFaces {
    const KIND: &'static str = "select-views";
    const METHOD: &'static str = "box-faces";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, _: &[u64]) -> u64 {
        1 << 20
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        if params.faces.is_empty() && params.more.is_empty() {
            return Err(("faces", "no camera is asked for: name a face, or give a camera in `more`".into()));
        }
        let mut names: Vec<&str> = params.faces.iter().map(|f| f.name()).collect();
        if let Some((i, name)) = names.iter().enumerate().find(|(i, n)| names[..*i].contains(*n)) {
            return Err(("faces", format!("`{name}` stands there twice, the second time at place {}", i + 1)));
        }
        for extra in &params.more {
            let Extra { name, eye, target, fov } = extra;
            let usable = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
            if name.is_empty() || name.starts_with('.') || name.len() > 60 || !name.chars().all(usable) {
                return Err(("more", format!("`{name}`: a name has 1 to 60 letters, digits and `-_.`")));
            }
            if names.iter().any(|n| n.eq_ignore_ascii_case(name)) {
                return Err(("more", format!("`{name}`: another camera has this name")));
            }
            if !eye.iter().chain(target).all(|v| v.is_finite()) || eye == target {
                return Err(("more", format!("`{name}`: expected an eye and a target that are finite and differ")));
            }
            if fov.is_some_and(|fov| !(1.0..=120.0).contains(&fov)) {
                return Err(("more", format!("`{name}`: expected a field of view of 1 to 120 degrees")));
            }
            names.push(name);
        }
        Ok(())
    }

    fn doubts(params: &Params) -> Vec<(&'static str, String)> {
        crate::nodes::doubt_fov(params.fov)
    }

    fn run(params: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        let bounds = inputs.scene.bounds();
        if bounds.is_empty() {
            return Err(NodeError::Failed("the scene is empty: there is nothing to look at".into()));
        }
        debug_assert!(params.resolution <= MAX_SIDE);
        let mut views: Vec<(String, View)> = params
            .faces
            .iter()
            .map(|face| (face.name().to_owned(), camera(params, &bounds, face.direction())))
            .collect();
        views.extend(params.more.iter().map(|extra| (extra.name.clone(), given(params, &bounds, extra))));
        views.sort_by(|a, b| a.0.cmp(&b.0));
        Ok(Out { views: List(views.into_iter().map(|(name, view)| (name, Arc::new(view))).collect()) })
    }
}

/// The camera outside the face of the box that looks in `direction`.
fn camera(params: &Params, bounds: &Aabb, direction: DVec3) -> View {
    let half = (bounds.max - bounds.min) * 0.5;
    // A box without extent is looked at as if it had one.
    let least = (half.length() * 1e-3).max(1e-6);
    let deep = half.dot(direction.abs());
    // Of the two half extents across, the larger.
    let wide = (half * (DVec3::ONE - direction.abs())).max_element().max(least);
    let n = f64::from(params.resolution);
    // The box takes the picture without its margin, of which some pixels are always left.
    let share = ((n - 2.0 * params.margin) / n).max(0.1);
    let fov = params.fov.to_radians();
    let away = wide / (libm::tan(fov * 0.5) * share);
    let eye = bounds.centre() + direction * (deep + away);
    let (near, far) = (away * 0.99, (away + 2.0 * deep) * 1.01);
    let view = View::look_at(eye, bounds.centre(), DVec3::Y, fov, params.resolution, params.resolution, near, far);
    match params.projection {
        Lens::Perspective => view,
        Lens::Orthographic => {
            let s = wide / share;
            View { projection: Projection::Orthographic { left: -s, right: s, bottom: -s, top: s }, ..view }
        }
    }
}

fn given(params: &Params, bounds: &Aabb, extra: &Extra) -> View {
    let (eye, target) = (DVec3::from(extra.eye), DVec3::from(extra.target));
    let farthest = bounds.corners().iter().map(|p| p.distance(eye)).fold(0.0, f64::max) * 1.01;
    let fov = extra.fov.unwrap_or(params.fov).to_radians();
    let nearest = eye.clamp(bounds.min, bounds.max).distance(eye);
    // What lies aside of the axis is nearer in planar depth than in space.
    let near = (nearest * 0.99 * libm::cos(fov * 0.5) * std::f64::consts::FRAC_1_SQRT_2).max(farthest * 1e-5);
    View::look_at(eye, target, DVec3::Y, fov, params.resolution, params.resolution, near, farthest)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: Aabb = Aabb { min: DVec3::new(-1.0, 0.0, -3.0), max: DVec3::new(2.0, 1.0, 4.0) };

    #[test]
    fn every_picture_holds_the_whole_box_and_fills_one_direction() {
        for projection in [Lens::Perspective, Lens::Orthographic] {
            let params = Params { projection, resolution: 257, margin: 2.0, ..Params::default() };
            for face in Face::ALL {
                let view = camera(&params, &BOX, face.direction());
                assert!((view.forward + face.direction()).length() < 1e-12);
                let (mut lo, mut hi) = (f64::INFINITY, 0.0f64);
                for corner in BOX.corners() {
                    let (x, y, z) = view.project(corner);
                    assert!((view.near..=view.far).contains(&z), "{face:?} {z}");
                    (lo, hi) = (lo.min(x).min(y), hi.max(x).max(y));
                }
                assert!((lo - 2.0).abs() < 1e-6 && (hi - 255.0).abs() < 1e-6, "{face:?} {lo} {hi}");
            }
        }
    }

    #[test]
    fn flat_boxes_and_points_are_looked_at_too() {
        for max in [BOX.min, BOX.min + DVec3::X, BOX.min + DVec3::new(1.0, 0.0, 1.0)] {
            let bounds = Aabb { max, ..BOX };
            for face in Face::ALL {
                let view = camera(&Params::default(), &bounds, face.direction());
                assert!(view.near > 0.0 && view.near < view.far && view.eye.is_finite());
            }
        }
    }

    #[test]
    fn a_given_camera_sees_the_box_between_its_depths() {
        let extra = Extra { name: "low".into(), eye: [6.0, 0.5, 9.0], target: [0.0, 0.0, 0.0], fov: Some(50.0) };
        let view = given(&Params::default(), &BOX, &extra);
        for corner in BOX.corners() {
            let z = view.project(corner).2;
            assert!(z > view.near && z < view.far);
        }
    }

    #[test]
    fn cameras_that_cannot_be_are_refused() {
        let extra = |name: &str, eye: [f64; 3]| Extra { name: name.into(), eye, target: [0.0; 3], fov: None };
        for (change, param) in [
            (Params { faces: vec![], ..Params::default() }, "faces"),
            (Params { faces: vec![Face::PosX, Face::PosX], ..Params::default() }, "faces"),
            (Params { more: vec![extra("pos-x", [1.0; 3])], ..Params::default() }, "more"),
            (Params { more: vec![extra("a/b", [1.0; 3])], ..Params::default() }, "more"),
            (Params { more: vec![extra("a", [0.0; 3])], ..Params::default() }, "more"),
            (Params { more: vec![extra("a", [1.0; 3]), extra("A", [2.0; 3])], ..Params::default() }, "more"),
        ] {
            assert_eq!(BoxFaces::check(&change).unwrap_err().0, param);
        }
        assert_eq!(BoxFaces::check(&Params::default()), Ok(()));
    }
}
