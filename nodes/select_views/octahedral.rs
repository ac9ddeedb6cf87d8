//! Cameras for octahedral impostors.

use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    nodes::cameras::{self, Pictures},
    ports,
    scene::Scene,
    view::{View, directions, enclosing_sphere},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Places orthographic cameras on an octahedral grid around the object, as engines' octahedral impostors expect. All pictures have one square window, a
/// small bounding sphere of the object. The frame in column x and row y, counted from the top left of the atlas, looks from octahedral coordinates
/// (2x/(frames − 1) − 1, 2y/(frames − 1) − 1): +Y is the middle of the grid, +X the middle of its right side, +Z the middle of its lower side, −Y its corners. In
/// a hemi-octahedral grid +X and −X are the lower right and the upper left corner, +Z and −Z the upper right and the lower left one. Pictures
/// have +Y up; those from straight above and below have +Z up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Along a side of the grid.
    #[schemars(range(min = 2, max = 32), extend("x-unit" = "frames"))]
    pub frames: u32,
    /// Only directions from above, for what is never seen from below: a hemi-octahedral grid.
    pub hemi: bool,
    /// Width and height of a frame, texels.
    #[schemars(range(min = 4, max = 8192), extend("x-unit" = "texels"))]
    pub resolution: u32,
    /// Pixels of the picture along a side of a texel: 1, 2 or 4. `resolution` times this is at most 16384.
    pub samples: u32,
    /// Kept free around the sphere.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-unit" = "texels"))]
    pub margin: f64,
}

impl Default for Params {
    fn default() -> Self {
        let Pictures { resolution, samples, margin } = Pictures::DEFAULT;
        Self { frames: 8, hemi: false, resolution, samples, margin }
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
        /// The cameras by row and column of their frame, such as `r00c07`.
        views: List<View>,
    }
}

pub struct Octahedral;

impl Node for Octahedral {
    const KIND: &'static str = "select-views";
    const METHOD: &'static str = "octahedral";
    const VERSION: u32 = 2;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // The vertices in 64 bits.
        (8 << 20) + sizes[0].saturating_mul(3)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        params.pictures().check()
    }

    fn run(params: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        let Params { frames, hemi, .. } = *params;
        let (centre, radius) = enclosing_sphere(&inputs.scene.points()).ok_or_else(cameras::nothing)?;
        let (pixels, free) = (params.pictures().pixels(), params.pictures().free());
        let frame = |y: u32, x: u32| {
            let direction = directions::octahedral_frame(x, y, frames, hemi);
            let view = directions::look_along_sphere(centre, radius, direction, pixels, free);
            (format!("r{y:02}c{x:02}"), Arc::new(view))
        };
        Ok(Out { views: List((0..frames).flat_map(|y| (0..frames).map(move |x| frame(y, x))).collect()) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::testing::{refused, run};
    use glam::DVec3;

    fn views(params: &Params) -> Vec<(String, Arc<View>)> {
        let scene = Arc::new(crate::scene::builtin::make("car", 1).unwrap());
        run::<Octahedral>(params, In { scene }).0.unwrap().views.0
    }

    #[test]
    fn frames_share_a_window_that_holds_the_object() {
        let points = crate::scene::builtin::make("car", 1).unwrap().points();
        for hemi in [false, true] {
            let params = Params { frames: 5, hemi, ..Params::default() };
            let views = views(&params);
            assert!(views.len() == 25 && views.is_sorted_by(|a, b| a.0 < b.0));
            let first = &views[0].1;
            for (_, view) in &views {
                assert_eq!((view.projection, view.far, view.width), (first.projection, first.far, first.width));
                assert!(!hemi || view.forward.y <= 0.0);
                let inside = |p: &DVec3| {
                    let (x, y, z) = view.project(*p);
                    let frame = 2.0 - 1e-6..=510.0 + 1e-6;
                    frame.contains(&x) && frame.contains(&y) && z > 0.0 && z < view.far
                };
                assert!(points.iter().all(inside));
            }
        }
    }

    #[test]
    fn the_grid_is_laid_out_as_documented() {
        let at = |hemi: bool, name: &str| {
            let views = views(&Params { frames: 3, hemi, ..Params::default() });
            -views.iter().find(|v| v.0 == name).unwrap().1.forward
        };
        for (hemi, name, direction) in [
            (false, "r01c01", DVec3::Y),
            (false, "r01c02", DVec3::X),
            (false, "r02c01", DVec3::Z),
            (false, "r00c00", -DVec3::Y),
            (true, "r01c01", DVec3::Y),
            (true, "r02c02", DVec3::X),
            (true, "r00c00", -DVec3::X),
            (true, "r00c02", DVec3::Z),
            (true, "r02c00", -DVec3::Z),
        ] {
            assert!(at(hemi, name).distance(direction) < 1e-12, "{hemi} {name} {}", at(hemi, name));
        }
    }

    #[test]
    fn impossible_grids_are_refused() {
        assert_eq!(refused::<Octahedral>(&Params { frames: 1, ..Params::default() }).as_deref(), Some("frames"));
        assert_eq!(refused::<Octahedral>(&Params { frames: 33, ..Params::default() }).as_deref(), Some("frames"));
        assert!(run::<Octahedral>(&Params::default(), In { scene: Arc::default() }).0.is_err());
    }
}
