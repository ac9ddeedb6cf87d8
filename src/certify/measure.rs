//! One view of one stand-in: its pictures and what was measured in them.

use super::{
    classes::{Classes, Counts, Rule, classify},
    deviation::{Seen, max_deviation},
    edges::{Surfaces, dilate_square, discontinuities},
    frame::CropWindow,
    parallax::{Angle, Parallax},
};
use crate::{
    image::{
        Picture,
        measure::{decibel, luminances, mean_within, psnr_within, squared_error, ssim_map},
    },
    math::Stopped,
    raster::Rendering,
    runtime::{self, Context, StandIn},
    view::{Region, View},
};

/// The object's pixels are those of both coverages, dilated by so many pixels to each side.
const OBJECT_MARGIN: usize = 4;

/// How views are compared.
#[derive(Clone, Debug)]
pub struct Setting {
    pub region: Region,
    /// A pixel's angle, radians.
    pub pixel: f64,
    /// The bound, pixels.
    pub bound_px: f64,
    pub rendering: Rendering,
}

/// What one scene or stand-in shows in a view.
pub struct Shot<'a> {
    pub drawn: runtime::Shot<'a>,
    /// Luminance of the picture, [0, 255].
    luminance: Vec<f32>,
}

/// A view of the original with everything that its comparisons share.
pub struct Reference<'a> {
    pub shot: Shot<'a>,
    edges: Vec<u8>,
    rule: Rule,
    pixel: Angle,
}

/// What one view says about a stand-in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViewFigures {
    /// dB over the whole picture.
    pub psnr: f64,
    /// dB over the object's pixels; `None` where neither scene is seen.
    pub psnr_object: Option<f64>,
    pub ssim: f64,
    pub ssim_object: Option<f64>,
    pub counts: Counts,
    /// See [`super::deviation`]; pixels.
    pub max_deviation: f64,
    /// See [`StandIn::back_facing`].
    pub back_facing: u64,
}

/// One line: what the view's pictures show.
impl std::fmt::Display for ViewFigures {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let Counts { outside: o, inside: i, crack, .. } = self.counts;
        if let Some(psnr) = self.psnr_object {
            write!(f, "PSNR {psnr:.1} dB over the object; ")?;
        }
        write!(
            f,
            "pixels (and those at edges): missing {} ({}), extra {} ({}), wrong surface {} ({}), in front {} ({}), \
             lost detail {} ({}), cracks {crack}; moved {:.1} px at most",
            o.missing,
            i.missing,
            o.extra,
            i.extra,
            o.wrong_surface,
            i.wrong_surface,
            o.in_front,
            i.in_front,
            o.lost,
            i.lost,
            self.max_deviation
        )
    }
}

impl<'a> Shot<'a> {
    pub fn take(scene: &'a dyn StandIn, view: &View, rendering: &Rendering, context: Context) -> Result<Self, Stopped> {
        let drawn = scene.draw(view, rendering, context)?;
        let luminance = luminances(&drawn.picture);
        Ok(Self { drawn, luminance })
    }

    pub fn picture(&self) -> &Picture {
        &self.drawn.picture
    }

    pub fn surfaces(&self) -> Surfaces<'_> {
        let width = self.drawn.picture.width as usize;
        Surfaces { width, depth: &self.drawn.depth, triangle: &self.drawn.surface }
    }

    /// The discontinuities of what is shown.
    fn edges(&self, parallax: &Parallax, pixel: Angle) -> Vec<u8> {
        discontinuities(&self.surfaces(), parallax, pixel, &self.drawn.planes)
    }
}

impl<'a> Reference<'a> {
    pub fn take(original: &'a dyn StandIn, view: &View, setting: &Setting, context: Context) -> Result<Self, Stopped> {
        let shot = Shot::take(original, view, &setting.rendering, context)?;
        let rule = Rule {
            parallax: Parallax::new(view, &setting.region),
            bound: Angle::new(setting.bound_px * setting.pixel),
            band_px: setting.bound_px.ceil() as u32,
        };
        let pixel = Angle::new(setting.pixel);
        let edges = shot.edges(&rule.parallax, pixel);
        Ok(Self { shot, edges, rule, pixel })
    }

    fn max_deviation(&self, stand_in: &Shot) -> f64 {
        let edges = stand_in.edges(&self.rule.parallax, self.pixel);
        let original = Seen { surfaces: self.shot.surfaces(), edges: &self.edges };
        max_deviation(&original, &Seen { surfaces: stand_in.surfaces(), edges: &edges }, &self.rule)
    }

    /// For each pixel whether the original is there and no capture of `stand_in` saw its surface.
    pub fn unseen(&self, stand_in: &dyn StandIn, view: &View) -> Vec<bool> {
        let seen = self.shot.surfaces();
        let unseen = |i: usize| {
            let (x, y) = ((i % seen.width) as f64 + 0.5, (i / seen.width) as f64 + 0.5);
            seen.covered(i) && !stand_in.saw(view.unproject(x, y, seen.depth[i].into()))
        };
        (0..seen.depth.len()).map(unseen).collect()
    }

    pub fn classes(&self, stand_in: &Shot) -> Classes {
        classify(&self.shot.surfaces(), &stand_in.surfaces(), &self.edges, &self.rule)
    }

    /// `classes` are those of `stand_in`; `back_facing`: see [`StandIn::back_facing`]. Beside `frame`'s window both show the background alone.
    pub fn measure(&self, stand_in: &Shot, classes: &Classes, frame: &CropWindow, back_facing: u64) -> ViewFigures {
        let (a, b) = (&self.shot, stand_in);
        let (sa, sb) = (a.surfaces(), b.surfaces());
        let width = sa.width;
        let either: Vec<bool> = (0..sa.depth.len()).map(|i| sa.covered(i) || sb.covered(i)).collect();
        let object = dilate_square(&either, width, OBJECT_MARGIN);
        let similarity = ssim_map(&a.luminance, &b.luminance, width);
        let outside = frame.pixels - similarity.len() as f64;
        let similar: f64 = similarity.iter().map(|v| f64::from(*v)).sum();
        ViewFigures {
            psnr: decibel(squared_error(&a.luminance, &b.luminance) / frame.pixels),
            psnr_object: psnr_within(&a.luminance, &b.luminance, &object),
            ssim: (similar + outside) / frame.pixels,
            ssim_object: mean_within(&similarity, &object),
            counts: classes.counts,
            max_deviation: self.max_deviation(b),
            back_facing,
        }
    }
}
