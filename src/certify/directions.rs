//! The certificate of a stand-in that can be seen from anywhere: over directions instead of a region.
//!
//! Every direction is looked at from afar, with the viewport fitted to the original's projection, so that its side in pixels is the size s of the object on
//! the screen (Andújar et al. 2007, section 3.4). What is covered is decided at pixel centres.

use super::Context;
use crate::{
    image::{
        Picture,
        measure::{luminances, psnr_within},
    },
    math::Stopped,
    raster::{Geometry, Light, Rendering, Shading},
    runtime::{self, SceneStandIn, StandIn},
    scene::Scene,
    view::{Projection, View, directions::look_along},
};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// The eye's distance in diagonals of the object: rays are parallel up to a third of a degree.
const FAR: f64 = 100.0;

/// How a direction is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Pixels along a side of the viewport.
    pub size: u32,
    /// Samples of a pixel in x and in y for colours; 0: colours are not compared.
    pub samples: u32,
}

/// What was measured in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Pixels of the original that the stand-in does not cover.
    pub missing: u64,
    /// Pixels that the stand-in covers and the original does not.
    pub extra: u64,
    /// PSNR of luminance of the lit object over what either covers, dB; `None` without colours or where neither covers a pixel.
    pub psnr: Option<f64>,
    /// Maps or captures that were drawn, where the stand-in says so.
    pub drawn: Option<u32>,
}

/// The camera that looks at `corners` from `direction`; `None` where there are none.
pub fn view(corners: &[DVec3], direction: DVec3, size: u32) -> Option<View> {
    let flat = look_along(corners.iter().copied(), direction, size, 0.0)?;
    let Projection::Orthographic { left, right, bottom, top } = flat.projection else { return None };
    let diagonal = corners.iter().copied().collect::<crate::math::Aabb>().diagonal();
    let back = diagonal.max(right - left) * FAR;
    let middle = back + (flat.near + flat.far) * 0.5;
    let [left, right, bottom, top] = [left, right, bottom, top].map(|v| v / middle);
    Some(View {
        eye: flat.eye - flat.forward * back,
        projection: Projection::Perspective { left, right, bottom, top },
        near: flat.near + back,
        far: flat.far + back,
        ..flat
    })
}

/// Pictures of original and stand-in in one direction, and what differs: red is missing, blue is extra, grey the difference of brightness, four times.
pub struct Sheet {
    pub original: Picture,
    pub stand_in: Picture,
    pub difference: Picture,
}

/// Measures a stand-in against its original in each of `directions`.
pub fn measure(
    original: &Scene,
    stand_in: &dyn StandIn,
    directions: &[DVec3],
    look: Look,
    context: Context,
) -> Result<Vec<Seen>, Stopped> {
    let geometry = Geometry::new(original);
    let drawn = SceneStandIn::new(original, &geometry);
    let corners = original.points();
    let done = AtomicU64::new(0);
    directions
        .par_iter()
        .map(|direction| {
            context.stop.check()?;
            let shots = Shots::take(&drawn, stand_in, &corners, *direction, look, context)?;
            (context.progress)(done.fetch_add(1, Ordering::Relaxed) + 1, directions.len() as u64);
            Ok(shots.map_or(Seen { missing: 0, extra: 0, psnr: None, drawn: None }, |s| s.seen(look)))
        })
        .collect()
}

/// The pictures of one direction; `None` where there is nothing to see.
pub fn sheet(
    original: &Scene,
    stand_in: &dyn StandIn,
    direction: DVec3,
    look: Look,
    context: Context,
) -> Result<Option<Sheet>, Stopped> {
    let geometry = Geometry::new(original);
    let drawn = SceneStandIn::new(original, &geometry);
    let corners = original.points();
    let shots = Shots::take(&drawn, stand_in, &corners, direction, look, context)?;
    Ok(shots.map(|s| Sheet::of(&s.original, &s.stand_in)))
}

struct Shots<'a, 'b> {
    original: runtime::Shot<'a>,
    stand_in: runtime::Shot<'b>,
}

impl<'a, 'b> Shots<'a, 'b> {
    fn take(
        original: &'a dyn StandIn,
        stand_in: &'b dyn StandIn,
        corners: &[DVec3],
        direction: DVec3,
        look: Look,
        context: Context,
    ) -> Result<Option<Self>, Stopped> {
        let Some(view) = view(corners, direction, look.size) else { return Ok(None) };
        let how = Rendering { shading: Shading::Lit(Light::default()), ..Rendering::default() };
        let how = how.with_samples(look.samples.max(1));
        let context = runtime::Context { backend: context.backend, stop: context.stop };
        Ok(Some(Self {
            original: original.draw(&view, &how, context)?,
            stand_in: stand_in.draw(&view, &how, context)?,
        }))
    }

    fn covered(&self, pixel: usize) -> (bool, bool) {
        (self.original.depth[pixel].is_finite(), self.stand_in.depth[pixel].is_finite())
    }

    fn seen(&self, look: Look) -> Seen {
        let pixels = self.original.depth.len();
        let count = |what: (bool, bool)| (0..pixels).filter(|i| self.covered(*i) == what).count() as u64;
        let psnr = (look.samples > 0).then(|| {
            let mask: Vec<bool> = (0..pixels).map(|i| self.covered(i) != (false, false)).collect();
            psnr_within(&luminances(&self.original.picture), &luminances(&self.stand_in.picture), &mask)
        });
        Seen {
            missing: count((true, false)),
            extra: count((false, true)),
            psnr: psnr.flatten(),
            drawn: self.stand_in.drawn.map(|d| d.references),
        }
    }
}

const MISSING: [u8; 3] = [255, 48, 48];
const EXTRA: [u8; 3] = [80, 128, 255];

/// What the colours of a difference mean.
pub const LEGEND: [([u8; 3], &str); 3] =
    [(MISSING, "missing: original only"), (EXTRA, "extra: stand-in only"), ([128; 3], "difference of brightness, 4 ×")];

impl Sheet {
    /// What differs between two shots of one view: missing pixels red, extra ones blue, four times the difference of luminance elsewhere.
    pub fn of(original: &runtime::Shot, stand_in: &runtime::Shot) -> Self {
        let (a, b) = (luminances(&original.picture), luminances(&stand_in.picture));
        let texel = |i: usize| match (original.depth[i].is_finite(), stand_in.depth[i].is_finite()) {
            (true, false) => MISSING,
            (false, true) => EXTRA,
            _ => [((a[i] - b[i]).abs() * 4.0).min(255.0) as u8; 3],
        };
        let texel = |i: usize| {
            let [r, g, b] = texel(i);
            [r, g, b, 255]
        };
        let (width, height) = (original.picture.width, original.picture.height);
        let difference = Picture { width, height, texels: (0..a.len()).map(texel).collect() };
        Self { original: original.picture.clone(), stand_in: stand_in.picture.clone(), difference }
    }

    /// The three side by side.
    pub fn picture(&self) -> Picture {
        let (width, height) = (self.original.width as usize, self.original.height as usize);
        let parts = [&self.original, &self.stand_in, &self.difference];
        let rows =
            (0..height).flat_map(|y| parts.iter().flat_map(move |p| p.texels[y * width..(y + 1) * width].iter()));
        Picture { width: 3 * width as u32, height: height as u32, texels: rows.copied().collect() }
    }
}
