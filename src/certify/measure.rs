//! One view of one stand-in: its pictures and what was measured in them.

use super::{
    classes::{Classes, Counts, Rule, classify},
    deviation::{Seen, max_deviation},
    edges::{Surfaces, dilate_square, discontinuities},
    frame::Frame,
    parallax::{Angle, Parallax},
};
use crate::{
    image::{
        Picture,
        measure::{decibel, luminance, mean_within, psnr_within, squared_error, ssim_map},
    },
    math::{Stop, Stopped},
    raster::{Backend, Geometry, NOTHING, Nearest, Options, Rendering, Shader, nearest, picture},
    view::Cell,
    view::View,
};
use glam::DVec3;

/// The object's pixels are those of both coverages, dilated by so many pixels to each side.
const OBJECT_MARGIN: usize = 4;

/// How views are compared.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    pub cell: Cell,
    /// A pixel's angle, radians.
    pub pixel: f64,
    /// The bound, pixels.
    pub bound_px: f64,
    pub rendering: Rendering,
}

/// What one scene shows in a view.
pub struct Shot {
    pub nearest: Nearest,
    pub picture: Picture,
    /// Luminance of `picture`, [0, 255].
    luminance: Vec<f32>,
}

/// A view of the original with everything that its comparisons share.
pub struct Reference {
    pub shot: Shot,
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
    /// See [`back_facing`].
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

impl Shot {
    pub fn take(
        backend: &dyn Backend,
        shader: &Shader,
        view: &View,
        rendering: &Rendering,
        stop: &Stop,
    ) -> Result<Self, Stopped> {
        let picture = picture(backend, shader, view, rendering, stop)?;
        let luminance = picture.texels.iter().map(|t| luminance([t[0].into(), t[1].into(), t[2].into()])).collect();
        Ok(Self { nearest: nearest(backend, shader.geometry, view, &Options::default(), stop)?, picture, luminance })
    }

    pub fn surfaces(&self) -> Surfaces<'_> {
        let n = &self.nearest;
        Surfaces { width: n.width as usize, depth: &n.depth, triangle: &n.triangle }
    }
}

impl Reference {
    pub fn take(
        backend: &dyn Backend,
        original: &Shader,
        view: &View,
        setting: &Setting,
        stop: &Stop,
    ) -> Result<Self, Stopped> {
        let shot = Shot::take(backend, original, view, &setting.rendering, stop)?;
        let rule = Rule {
            parallax: Parallax::new(view, &setting.cell),
            bound: Angle::new(setting.bound_px * setting.pixel),
            band_px: setting.bound_px.ceil() as u32,
        };
        let pixel = Angle::new(setting.pixel);
        let edges = edges(&shot, original.geometry, view, &rule.parallax, pixel);
        Ok(Self { shot, edges, rule, pixel })
    }

    /// `geometry` is that of `stand_in`.
    fn max_deviation(&self, stand_in: &Shot, geometry: &Geometry, view: &View) -> f64 {
        let edges = edges(stand_in, geometry, view, &self.rule.parallax, self.pixel);
        let original = Seen { surfaces: self.shot.surfaces(), edges: &self.edges };
        max_deviation(&original, &Seen { surfaces: stand_in.surfaces(), edges: &edges }, &self.rule)
    }

    pub fn classes(&self, stand_in: &Shot) -> Classes {
        classify(&self.shot.surfaces(), &stand_in.surfaces(), &self.edges, &self.rule)
    }

    /// `back_facing`: see there. Beside `frame`'s window both scenes show the background alone.
    pub fn measure(&self, stand_in: &Shot, geometry: &Geometry, frame: &Frame, back_facing: u64) -> ViewFigures {
        let (a, b) = (&self.shot, stand_in);
        let width = a.nearest.width as usize;
        let (sa, sb) = (a.surfaces(), b.surfaces());
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
            counts: self.classes(b).counts,
            max_deviation: self.max_deviation(b, geometry, &frame.window),
            back_facing,
        }
    }
}

/// The discontinuities of what `geometry` shows in `shot`.
fn edges(shot: &Shot, geometry: &Geometry, view: &View, parallax: &Parallax, pixel: Angle) -> Vec<u8> {
    discontinuities(&shot.surfaces(), parallax, pixel, &|t| plane(geometry, view, t))
}

/// The k of a triangle's plane, with 1/depth = k·d along the ray direction d in camera axes. Not finite where the plane
/// holds the eye.
fn plane(geometry: &Geometry, view: &View, triangle: u32) -> DVec3 {
    let [a, b, c] = geometry.positions(triangle).map(|p| {
        let d = p - view.eye;
        DVec3::new(d.dot(view.right), d.dot(view.up), d.dot(view.forward))
    });
    let n = (b - a).cross(c - a);
    n / n.dot(a)
}

/// Pixels that would show the back of a single-sided material if it were drawn. Engines do not draw it, nor do the pictures here.
pub fn back_facing(backend: &dyn Backend, geometry: &Geometry, view: &View, stop: &Stop) -> Result<u64, Stopped> {
    if geometry.draws().iter().all(|d| d.material.double_sided) {
        return Ok(0);
    }
    let seen = nearest(backend, geometry, view, &Options::BOTH, stop)?;
    let mut last = (NOTHING, false);
    let back = |t: &&u32| {
        if last.0 != **t {
            let [a, b, c] = geometry.positions(**t);
            let away = (b - a).cross(c - a).dot(a - view.eye) > 0.0;
            last = (**t, away && !geometry.material_of(**t).double_sided);
        }
        last.1
    };
    Ok(seen.triangle.iter().filter(|t| **t != NOTHING).filter(back).count() as u64)
}
