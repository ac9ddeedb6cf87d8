//! The comparison: draws the views, renders, measures, and writes down the certificate.

use super::{
    certificate::{Bound, Camera, Ceiling, Certificate, Flip, Sampling as Sampled, StandIn},
    figures::{Figures, rounded},
    frame::Frame,
    measure::{Reference, Setting, Shot, ViewFigures, back_facing},
    pictures::{Caption, sheet},
    requirements::Verdict,
    shading::{self, Choice},
    size::Size,
    views::{self, Sampling},
    worst::{Wanted, by_psnr, worst_views},
};
use crate::{
    image::{Picture, measure::flip},
    math::{Stop, Stopped},
    raster::{self, Backend, Geometry, Rendering, Shader, nearest},
    scene::Scene,
    view::Cell,
    view::View,
};
use glam::DVec3;
use rayon::prelude::*;
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::atomic::{AtomicU64, Ordering},
};

/// How a stand-in is judged.
#[derive(Clone, Debug)]
pub struct Options {
    pub sampling: Sampling,
    /// Samples of a pixel in x and in y; `sampling.resolution` times this is at most [`raster::MAX_SIDE`].
    pub samples_per_axis: u32,
    pub shading: Choice,
    /// In pixels.
    pub bound: Bound,
    pub stand_in: StandIn,
    /// Size of the stand-in's file.
    pub bytes: u64,
    /// In how many views the ceiling is measured.
    pub ceiling_views: u32,
}

/// What a comparison gives.
#[derive(Clone, Debug)]
pub struct Comparison {
    pub certificate: Certificate,
    /// Original, stand-in and difference side by side, by name: `typical` (the view of median PSNR over the object)
    /// and `worst-…`, to which the certificate's `worst_view` refers, for each measure that found something.
    pub pictures: BTreeMap<String, Picture>,
}

#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    #[error("the original has no triangles")]
    EmptyOriginal,
    #[error("the stand-in is empty: it has no triangles")]
    EmptyStandIn,
    #[error("the {0} is seen from none of the {1} views of the cell")]
    Unseen(&'static str, usize),
    #[error("the bound is {value} {unit}; expected more than 0 and at most 1000 px")]
    Bound { value: f64, unit: String },
    #[error(
        "a picture of {resolution} pixels with {samples} samples an axis; expected 16 pixels or more, 1 to 16 samples, and at most {} together",
        raster::MAX_SIDE
    )]
    Resolution { resolution: u32, samples: u32 },
    #[error("a field of view of {0:.3}°; expected between 0.1° and 160°")]
    FieldOfView(f64),
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// Views worked on at once: their memory is what this needs, about 100 bytes a pixel each, with the supersampled
/// pictures' triangles.
pub const VIEWS_AT_ONCE: usize = 4;
/// FLIP is measured in so many views.
const FLIP_VIEWS: usize = 8;

/// What a comparison works with.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The back end that renders.
    pub backend: &'a dyn Backend,
    pub stop: &'a Stop,
    /// Is told how many of how many views are done, from any thread.
    pub progress: &'a (dyn Fn(u64, u64) + Sync),
}

/// Compares a stand-in and the `ceiling` that it was simplified from with its original, seen from `cell`.
pub fn compare(
    original: &Scene,
    stand_in: &Scene,
    ceiling: Option<&Scene>,
    cell: &Cell,
    options: &Options,
    context: Context,
) -> Result<Comparison, CompareError> {
    let Context { backend, stop, .. } = context;
    check(original, stand_in, options)?;
    let sampling = &options.sampling;
    let (shading, words) = shading::choose(options.shading, original, cell, sampling);
    let samples = options.samples_per_axis;
    // Samples are shaded in equal squares: an odd number of them one by one.
    let shades = if samples.is_multiple_of(2) { 2 } else { samples };
    let setting = Setting {
        cell: *cell,
        pixel: sampling.pixel_angle(),
        bound_px: options.bound.value,
        rendering: Rendering { samples_per_axis: samples, shades_per_axis: shades, shading, ..Rendering::default() },
    };
    let geometry = Geometry::new(original);
    let stand_in_geometry = Geometry::new(stand_in);
    let ceiling_geometry = ceiling.map(Geometry::new);
    let judge = Judge {
        original: Shader::new(&geometry),
        stand_in: Shader::new(&stand_in_geometry),
        ceiling: ceiling_geometry.as_ref().map(Shader::new),
        setting,
        context,
    };

    let selection = original.bounds();
    let all = [Some(stand_in), ceiling].into_iter().flatten().fold(selection, |b, s| b.union(s.bounds()));
    let seen =
        if views::surrounds(cell, &selection) { directions(backend, &geometry, cell, stop)? } else { Vec::new() };
    let views = views::draw(cell, &selection, &all, &seen, sampling);
    let frames: Vec<Frame> = views.iter().map(|v| Frame::around(v, &all, setting.bound_px)).collect();
    let measured = judge.measure(&frames, options.ceiling_views as usize)?;
    let figures: Vec<ViewFigures> = measured.iter().map(|m| m.0).collect();
    let of_ceiling: Vec<ViewFigures> = measured.iter().filter_map(|m| m.1).collect();
    if figures.iter().all(|f| f.counts.covered == 0) {
        return Err(CompareError::Unseen("original", views.len()));
    }
    if figures.iter().all(|f| f.counts.missing_everywhere()) {
        return Err(CompareError::Unseen("stand-in", views.len()));
    }

    let order = by_psnr(&figures);
    let (worst, wanted) = worst_views(&figures, &order, |i| Camera::of(&views[i], sampling.fov.to_degrees()));
    let model = model(original);
    let band_px = setting.bound_px.ceil() as u32;
    let caption = |w: &Wanted| Caption {
        lines: vec![
            format!("{model}: {}; view {} (views 0 to {})", w.title, w.view, views.len() - 1),
            figures[w.view].to_string(),
        ],
        band_px,
    };
    let looked_at = judge.look(&frames, &order[..order.len().min(FLIP_VIEWS)], &wanted, &caption)?;
    let flips: Vec<f64> = looked_at.iter().filter_map(|l| l.flip).collect();
    let pictures = looked_at.into_iter().flat_map(|l| l.pictures).collect();

    let (size, original_size) = (Size::of(stand_in), Size::of(original));
    let mut certificate = Certificate {
        verdict: Verdict::Failed,
        sentence: String::new(),
        summary: Vec::new(),
        requirements: Vec::new(),
        stand_in: options.stand_in.clone(),
        triangles: size.triangles,
        original_triangles: original_size.triangles,
        draw_calls: size.draw_calls,
        original_draw_calls: original_size.draw_calls,
        texels: size.texels,
        original_texels: original_size.texels,
        memory_bytes: size.memory_bytes,
        original_memory_bytes: original_size.memory_bytes,
        bytes: options.bytes,
        views: views.len() as u32,
        shading: words,
        blend_as_mask: shading::blends(original) || shading::blends(stand_in),
        bound: Bound { value: rounded(options.bound.value, 4), ..options.bound.clone() },
        figures: Figures::of(&figures, band_px),
        flip: Flip {
            views: flips.len() as u32,
            mean: rounded(flips.iter().sum::<f64>() / flips.len().max(1) as f64, 4),
            max: rounded(flips.iter().copied().fold(0.0, f64::max), 4),
        },
        ceiling: ceiling.filter(|_| !of_ceiling.is_empty()).map(|scene| Ceiling {
            triangles: scene.triangle_count() as u64,
            views: of_ceiling.len() as u32,
            figures: Figures::of(&of_ceiling, band_px),
        }),
        worst_view: worst,
        sampling: Sampled {
            seed: sampling.seed,
            resolution: sampling.resolution,
            fov: rounded(sampling.fov.to_degrees(), 6),
            samples_per_axis: options.samples_per_axis,
            cell_centre: cell.centre.to_array(),
            cell_half: cell.half.to_array(),
        },
        about: BTreeMap::new(),
    };
    certificate.judge();
    Ok(Comparison { certificate, pictures })
}

/// What the original is called: its object, or how many there are.
fn model(original: &Scene) -> String {
    match &original.objects[..] {
        [one] if !one.name.is_empty() => one.name.clone(),
        all => format!("{} objects ({}, ...)", all.len(), all.first().map_or("", |o| &o.name)),
    }
}

fn check(original: &Scene, stand_in: &Scene, options: &Options) -> Result<(), CompareError> {
    if original.triangle_count() == 0 {
        return Err(CompareError::EmptyOriginal);
    }
    if stand_in.triangle_count() == 0 {
        return Err(CompareError::EmptyStandIn);
    }
    let Bound { value, unit, .. } = &options.bound;
    if unit != "px" || !(*value > 0.0 && *value <= 1000.0) {
        return Err(CompareError::Bound { value: *value, unit: unit.clone() });
    }
    let (resolution, samples) = (options.sampling.resolution, options.samples_per_axis);
    let fits = resolution.checked_mul(samples).is_some_and(|n| n <= raster::MAX_SIDE);
    if !fits || resolution < 16 || !(1..=16).contains(&samples) {
        return Err(CompareError::Resolution { resolution, samples });
    }
    let fov = options.sampling.fov.to_degrees();
    if !(0.1..=160.0).contains(&fov) {
        return Err(CompareError::FieldOfView(fov));
    }
    Ok(())
}

/// The three scenes made ready.
struct Judge<'a> {
    original: Shader<'a>,
    stand_in: Shader<'a>,
    ceiling: Option<Shader<'a>>,
    setting: Setting,
    context: Context<'a>,
}

/// A view rendered once more.
struct Look {
    flip: Option<f64>,
    pictures: Vec<(String, Picture)>,
}

impl Judge<'_> {
    fn reference(&self, view: &View) -> Result<Reference, Stopped> {
        let Context { backend, stop, .. } = self.context;
        Reference::take(backend, &self.original, view, &self.setting, stop)
    }

    fn shot(&self, shader: &Shader, view: &View) -> Result<Shot, Stopped> {
        let Context { backend, stop, .. } = self.context;
        Shot::take(backend, shader, view, &self.setting.rendering, stop)
    }

    /// Figures of the stand-in in every view, and of the ceiling in the first `ceiling_views`.
    fn measure(
        &self,
        frames: &[Frame],
        ceiling_views: usize,
    ) -> Result<Vec<(ViewFigures, Option<ViewFigures>)>, Stopped> {
        let done = AtomicU64::new(0);
        let one = |(i, frame): (usize, &Frame)| {
            let reference = self.reference(&frame.window)?;
            let judged = |shader: &Shader| -> Result<ViewFigures, Stopped> {
                let backs = back_facing(self.context.backend, shader.geometry, &frame.window, self.context.stop)?;
                Ok(reference.measure(&self.shot(shader, &frame.window)?, shader.geometry, frame, backs))
            };
            let ceiling = self.ceiling.as_ref().filter(|_| i < ceiling_views).map(judged).transpose()?;
            let figures = (judged(&self.stand_in)?, ceiling);
            (self.context.progress)(done.fetch_add(1, Ordering::Relaxed) + 1, frames.len() as u64);
            Ok(figures)
        };
        in_batches(frames.iter().enumerate().collect(), one)
    }

    /// FLIP for the views in `flips`, and the pictures that are wanted.
    fn look(
        &self,
        frames: &[Frame],
        flips: &[usize],
        wanted: &[Wanted],
        caption: &(impl Fn(&Wanted) -> Caption + Sync),
    ) -> Result<Vec<Look>, Stopped> {
        let views: BTreeSet<usize> = flips.iter().copied().chain(wanted.iter().map(|w| w.view)).collect();
        let one = |i: usize| {
            let frame = &frames[i];
            let (reference, stand_in) = (self.reference(&frame.window)?, self.shot(&self.stand_in, &frame.window)?);
            let picture = |w: &Wanted| (w.name.to_owned(), sheet(&reference, &stand_in, w.focus, &caption(w)));
            Ok(Look {
                flip: flips.contains(&i).then(|| flip_of(&reference.shot.picture, &stand_in.picture, frame)),
                pictures: wanted.iter().filter(|w| w.view == i).map(picture).collect(),
            })
        };
        in_batches(views.into_iter().collect(), one)
    }
}

/// FLIP over the whole frame; it is nothing outside the window, where both pictures show the background.
fn flip_of(a: &Picture, b: &Picture, frame: &Frame) -> f64 {
    if a == b {
        return 0.0;
    }
    let rgb = |p: &Picture| -> Vec<u8> { p.texels.iter().flat_map(|t| [t[0], t[1], t[2]]).collect() };
    flip(&rgb(a), &rgb(b), a.width, a.height) * a.texels.len() as f64 / frame.pixels
}

/// Maps in parallel, a few at a time so that memory stays bounded; results in order.
fn in_batches<T: Send + Sync + Copy, R: Send>(
    items: Vec<T>,
    f: impl Fn(T) -> Result<R, Stopped> + Sync,
) -> Result<Vec<R>, Stopped> {
    let mut all = Vec::with_capacity(items.len());
    for batch in items.chunks(VIEWS_AT_ONCE) {
        all.append(&mut batch.par_iter().map(|item| f(*item)).collect::<Result<Vec<R>, Stopped>>()?);
    }
    Ok(all)
}

/// The directions from the cell's centre in which the scene is seen, with their solid angles: pixels of a cube.
fn directions(
    backend: &dyn Backend,
    geometry: &Geometry,
    cell: &Cell,
    stop: &Stop,
) -> Result<Vec<(DVec3, f64)>, Stopped> {
    const N: u32 = 32;
    let far = cell.half.length() * 1e6;
    let mut all = Vec::new();
    for axis in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
        let fov = std::f64::consts::FRAC_PI_2;
        let view = View::look_at(cell.centre, cell.centre + axis, DVec3::Y, fov, N, N, far * 1e-9, far);
        let seen = nearest(backend, geometry, &view, &raster::Options::default(), stop)?;
        for (i, depth) in seen.depth.iter().enumerate().filter(|(_, d)| d.is_finite()) {
            let (x, y) = ((i as u32 % N) as f64 + 0.5, (i as u32 / N) as f64 + 0.5);
            let d = view.unproject(x, y, 1.0) - view.eye;
            debug_assert!(*depth > 0.0);
            all.push((d.normalize(), 1.0 / (d.length_squared() * d.length())));
        }
    }
    Ok(all)
}
