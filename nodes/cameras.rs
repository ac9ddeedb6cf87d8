//! Orthographic cameras around a scene, which several methods of `select-views` place.

use crate::{
    engine::node::{Ctx, List, NodeError},
    raster::MAX_SIDE,
    scene::Scene,
    view::{View, directions},
};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;

/// The pictures of the cameras.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pictures {
    /// Texels along a side.
    pub resolution: u32,
    /// Pixels along a side of a texel.
    pub samples: u32,
    /// Texels kept free on each side.
    pub margin: f64,
}

impl Pictures {
    /// What the methods' parameters start with.
    pub const DEFAULT: Self = Self { resolution: 256, samples: 2, margin: 1.0 };

    /// Refuses pictures that cannot be rendered, with the parameter that is wrong.
    pub fn check(&self) -> Result<(), (&'static str, String)> {
        let Self { resolution, samples, .. } = *self;
        if ![1, 2, 4].contains(&samples) {
            return Err(("samples", format!("{samples}; expected 1, 2 or 4")));
        }
        if resolution.saturating_mul(samples) > MAX_SIDE {
            let most = MAX_SIDE / samples;
            return Err(("resolution", format!("{resolution}; expected at most {most} texels with {samples} samples")));
        }
        Ok(())
    }

    /// Pixels along a side.
    pub fn pixels(&self) -> u32 {
        self.resolution * self.samples
    }

    /// Pixels kept free on each side.
    pub fn free(&self) -> f64 {
        self.margin * f64::from(self.samples)
    }
}

/// A camera for each direction (unit, from the scene to the eye), fitted to the scene's vertices. Sorted by name.
pub fn around(
    scene: &Scene,
    mut directions: Vec<(String, DVec3)>,
    pictures: Pictures,
) -> Result<List<View>, NodeError> {
    let points = scene.points();
    directions.sort_by(|a, b| a.0.cmp(&b.0));
    let camera = |(name, direction): (String, DVec3)| {
        let view = directions::look_along(points.iter().copied(), direction, pictures.pixels(), pictures.free());
        Ok((name, Arc::new(view.ok_or_else(nothing)?)))
    };
    Ok(List(directions.into_par_iter().map(camera).collect::<Result<_, NodeError>>()?))
}

/// Warns of cameras, by their names in ticks, that show nothing.
pub fn warn_of_blank(ctx: &Ctx, names: &[String]) {
    if !names.is_empty() {
        (ctx.warn)(format!("from {} no surface is seen: the object is flat and seen edge-on", names.join(", ")));
    }
}

/// What a scene without triangles is answered with.
pub fn nothing() -> NodeError {
    NodeError::Failed("the scene has no triangles: there is nothing to look at".into())
}
