//! The comparison: draws the views, renders, measures, and writes down the certificate.

use super::{
    certificate::{Bound, Camera, Ceiling, Certificate, Flip, Overdraw, Sampling as Sampled, Subject},
    classes::Classes,
    figures::{Figures, rounded},
    frame::CropWindow,
    measure::{Reference, Setting, Shot, ViewFigures},
    modes::{ModeFigures, ModeView},
    per_view::PerView,
    pictures::{Caption, Panels, sheet},
    requirements::Verdict,
    shading,
    viewing::Viewing,
    views,
    worst::{Wanted, by_psnr, worst_views},
};
use crate::{
    image::{Picture, measure::flip},
    math::{Stop, Stopped},
    raster::{self, Backend, Geometry, Rendering, nearest},
    runtime::{self, SceneStandIn, StandIn},
    scene::Scene,
    view::{Region, View},
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
    pub viewing: Viewing,
    /// In pixels.
    pub bound: Bound,
    pub stand_in: Subject,
    /// Size of the stand-in's files.
    pub bytes: u64,
    /// What the mesh before simplification reaches, see [`ceiling`].
    pub ceiling: Option<Ceiling>,
    /// An original that no view shows is no error: nothing of it can differ.
    pub may_be_unseen: bool,
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
/// FLIP is measured in so many views. Where there are no more, their pictures are kept for it rather than drawn again.
const FLIP_VIEWS: usize = 8;
/// A view of the original, and one of the stand-in as it is usually drawn.
type Pair<'a> = (Reference<'a>, Shot<'a>);

/// What a comparison works with.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The back end that renders.
    pub backend: &'a dyn Backend,
    pub stop: &'a Stop,
    /// Is told how many of how many views are done, from any thread.
    pub progress: &'a (dyn Fn(u64, u64) + Sync),
}

/// A way in which a stand-in is drawn: static or view-dependent, say.
pub struct Mode<'a> {
    /// As it stands in the certificate; empty where there is only one way.
    pub name: String,
    pub stand_in: &'a dyn StandIn,
}

/// Measures the mesh that a stand-in was simplified from, as [`compare`] measures the stand-in: what no simplification can beat. `bound_px` is the error
/// that it may have itself.
pub fn ceiling(
    original: &Scene,
    mesh: &Scene,
    region: &Region,
    viewing: &Viewing,
    bound_px: f64,
    context: Context,
) -> Result<Ceiling, CompareError> {
    let geometry = Geometry::new(mesh);
    let drawn = SceneStandIn::new(mesh, &geometry);
    let modes = [Mode { name: String::new(), stand_in: &drawn }];
    check(original, &modes, viewing, bound_px)?;
    let geometry = Geometry::new(original);
    let judge = Judge::new(original, &geometry, &modes, region, viewing, bound_px, context)?;
    let figures = first_mode(&judge.measure(false)?.0, false)?;
    Ok(Ceiling {
        triangles: mesh.triangle_count() as u64,
        views: figures.len() as u32,
        figures: Figures::of(&figures, judge.band_px()),
    })
}

/// Compares a stand-in with its original, seen from `region`. The certificate's own figures are those of the first of its `modes`, of which
/// there is at least one.
pub fn compare(
    original: &Scene,
    modes: &[Mode],
    region: &Region,
    options: &Options,
    context: Context,
) -> Result<Comparison, CompareError> {
    let Options { viewing, bound, .. } = options;
    if bound.unit != "px" {
        return Err(CompareError::Bound { value: bound.value, unit: bound.unit.clone() });
    }
    let stand_in = modes.first().ok_or(CompareError::EmptyStandIn)?.stand_in;
    check(original, modes, viewing, bound.value)?;
    let geometry = Geometry::new(original);
    let judge = Judge::new(original, &geometry, modes, region, viewing, bound.value, context)?;
    let (views, band_px) = (&judge.views, judge.band_px());
    let (measured, kept) = judge.measure(judge.frames.len() <= FLIP_VIEWS)?;
    let figures = first_mode(&measured, options.may_be_unseen)?;
    let named = modes.iter().enumerate().filter(|(_, m)| !m.name.is_empty());
    let of_modes = named
        .map(|(k, m)| (m.name.clone(), ModeFigures::of(&measured.iter().map(|v| v[k]).collect::<Vec<_>>())))
        .collect();

    let order = by_psnr(&figures);
    let fov = viewing.sampling.fov.to_degrees();
    let (worst, wanted) = worst_views(&figures, &order, |i| Camera::of(&views[i], fov));
    let model = model(original);
    let caption = |w: &Wanted| Caption {
        lines: vec![
            format!("{model}: {}; view {} (views 0 to {})", w.title, w.view, views.len() - 1),
            figures[w.view].to_string(),
        ],
        band_px,
    };
    let looked_at = judge.look(kept, &order[..order.len().min(FLIP_VIEWS)], &wanted, &caption)?;
    let flips: Vec<f64> = looked_at.iter().filter_map(|l| l.flip).collect();
    let overdraws: Vec<runtime::Overdraw> = looked_at.iter().filter_map(|l| l.overdraw).collect();
    let looked_at = looked_at.into_iter().flat_map(|l| l.pictures);
    let (mut pictures, mut panels) = (BTreeMap::new(), BTreeMap::new());
    for (name, picture, places) in looked_at {
        panels.insert(name.clone(), places);
        pictures.insert(name, picture);
    }

    let (size, original_size) = (stand_in.size(), judge.original.size());
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
        shading: judge.words.clone(),
        blend_as_mask: judge.original.blends() || stand_in.blends(),
        bound: Bound { value: rounded(options.bound.value, 4), ..options.bound.clone() },
        figures: Figures::of(&figures, band_px),
        flip: Flip {
            views: flips.len() as u32,
            mean: rounded(flips.iter().sum::<f64>() / flips.len().max(1) as f64, 4),
            max: rounded(flips.iter().copied().fold(0.0, f64::max), 4),
        },
        overdraw: Overdraw::of(&overdraws),
        ceiling: options.ceiling.clone(),
        modes: of_modes,
        worst_view: worst,
        sampling: Sampled::of(viewing, region),
        about: BTreeMap::new(),
        panels,
        per_view: PerView::of(&figures),
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

fn check(original: &Scene, modes: &[Mode], viewing: &Viewing, bound_px: f64) -> Result<(), CompareError> {
    if original.triangle_count() == 0 {
        return Err(CompareError::EmptyOriginal);
    }
    if modes.first().is_none_or(|m| m.stand_in.bounds().is_empty()) {
        return Err(CompareError::EmptyStandIn);
    }
    if !(bound_px > 0.0 && bound_px <= 1000.0) {
        return Err(CompareError::Bound { value: bound_px, unit: "px".into() });
    }
    let (resolution, samples) = (viewing.sampling.resolution, viewing.samples_per_axis);
    let fits = resolution.checked_mul(samples).is_some_and(|n| n <= raster::MAX_SIDE);
    if !fits || resolution < 16 || !(1..=16).contains(&samples) {
        return Err(CompareError::Resolution { resolution, samples });
    }
    let fov = viewing.sampling.fov.to_degrees();
    if !(0.1..=160.0).contains(&fov) {
        return Err(CompareError::FieldOfView(fov));
    }
    Ok(())
}

/// The figures of the first mode in every view; an error where the stand-in is seen in none, or the original unless that may be.
fn first_mode(measured: &[Vec<ModeView>], may_be_unseen: bool) -> Result<Vec<ViewFigures>, CompareError> {
    let figures: Vec<ViewFigures> = measured.iter().map(|modes| modes[0].figures).collect();
    if figures.iter().all(|f| f.counts.covered == 0) {
        if may_be_unseen {
            return Ok(figures);
        }
        return Err(CompareError::Unseen("original", figures.len()));
    }
    if figures.iter().all(|f| f.counts.missing_everywhere()) {
        return Err(CompareError::Unseen("stand-in", figures.len()));
    }
    Ok(figures)
}

/// What is compared, made ready.
struct Judge<'a> {
    original: SceneStandIn<'a>,
    modes: &'a [Mode<'a>],
    setting: Setting,
    /// The certificate's words for the shading.
    words: String,
    views: Vec<View>,
    /// The parts of the views that show something.
    frames: Vec<CropWindow>,
    context: Context<'a>,
}

/// What one view says of one way to draw.
struct Judged<'a> {
    figures: ViewFigures,
    classes: Classes,
    shot: Shot<'a>,
}

/// A view rendered once more.
struct Retake {
    flip: Option<f64>,
    overdraw: Option<runtime::Overdraw>,
    pictures: Vec<(String, Picture, Panels)>,
}

impl<'a> Judge<'a> {
    /// `geometry` is that of `original`.
    fn new(
        original: &Scene,
        geometry: &'a Geometry,
        modes: &'a [Mode<'a>],
        region: &Region,
        viewing: &Viewing,
        bound_px: f64,
        context: Context<'a>,
    ) -> Result<Self, CompareError> {
        let Viewing { sampling, samples_per_axis, shading } = viewing;
        let (shading, words) = shading::choose(*shading, original, region, sampling);
        // Samples are shaded in equal squares: an odd number of them one by one.
        let shades_per_axis = if samples_per_axis.is_multiple_of(2) { 2 } else { *samples_per_axis };
        let rendering =
            Rendering { samples_per_axis: *samples_per_axis, shades_per_axis, shading, ..Rendering::default() };
        let setting = Setting { region: region.clone(), pixel: sampling.pixel_angle(), bound_px, rendering };
        let selection = original.bounds();
        let all = modes.iter().fold(selection, |b, m| b.union(m.stand_in.bounds()));
        let seen = match views::surrounds(region, &selection) {
            true => directions(context.backend, geometry, region, context.stop)?,
            false => Vec::new(),
        };
        let views = views::draw(region, &selection, &all, &seen, sampling);
        let frames = views.iter().map(|v| CropWindow::around(v, &all, bound_px)).collect();
        Ok(Self { original: SceneStandIn::new(original, geometry), modes, setting, words, views, frames, context })
    }

    /// Half the width of the band around discontinuities, pixels.
    fn band_px(&self) -> u32 {
        self.setting.bound_px.ceil() as u32
    }

    fn drawing(&self) -> runtime::Context<'a> {
        runtime::Context { backend: self.context.backend, stop: self.context.stop }
    }

    fn reference(&self, view: &View) -> Result<Reference<'_>, Stopped> {
        Reference::take(&self.original, view, &self.setting, self.drawing())
    }

    fn shot(&self, stand_in: &'a dyn StandIn, view: &View) -> Result<Shot<'a>, Stopped> {
        Shot::take(stand_in, view, &self.setting.rendering, self.drawing())
    }

    /// Every mode in every view; the views themselves only where they are to be kept.
    fn measure(&self, keep: bool) -> Result<(Vec<Vec<ModeView>>, Vec<Pair<'_>>), Stopped> {
        let done = AtomicU64::new(0);
        let one = |frame: &CropWindow| {
            let reference = self.reference(&frame.window)?;
            let (mut modes, mut usual) = (Vec::new(), None);
            for mode in self.modes {
                let Judged { figures, classes, shot } = self.judged(&reference, mode.stand_in, frame)?;
                // Only named modes are told apart.
                modes.push(match mode.name.is_empty() {
                    true => ModeView { figures, ..ModeView::default() },
                    false => {
                        let unseen = reference.unseen(mode.stand_in, &frame.window);
                        ModeView::of(figures, shot.drawn.drawn.unwrap_or_default(), &classes, &unseen)
                    }
                });
                if keep && usual.is_none() {
                    usual = Some(shot);
                }
            }
            (self.context.progress)(done.fetch_add(1, Ordering::Relaxed) + 1, self.frames.len() as u64);
            Ok((modes, usual.map(|shot| (reference, shot))))
        };
        let (modes, kept): (Vec<_>, Vec<_>) = in_batches(self.frames.iter().collect(), one)?.into_iter().unzip();
        Ok((modes, kept.into_iter().flatten().collect()))
    }

    fn judged(
        &self,
        reference: &Reference,
        stand_in: &'a dyn StandIn,
        frame: &CropWindow,
    ) -> Result<Judged<'a>, Stopped> {
        let backs = stand_in.back_facing(&frame.window, self.drawing())?;
        let shot = self.shot(stand_in, &frame.window)?;
        let classes = reference.classes(&shot);
        let figures = reference.measure(&shot, &classes, frame, backs);
        Ok(Judged { figures, classes, shot })
    }

    /// FLIP and overdraw for the views in `flips`, and the pictures that are wanted. `kept`: all views, or none, which are then drawn again.
    fn look(
        &self,
        kept: Vec<Pair>,
        flips: &[usize],
        wanted: &[Wanted],
        caption: &(impl Fn(&Wanted) -> Caption + Sync),
    ) -> Result<Vec<Retake>, Stopped> {
        let views: BTreeSet<usize> = flips.iter().copied().chain(wanted.iter().map(|w| w.view)).collect();
        let one = |i: usize| {
            let frame = &self.frames[i];
            let again;
            let (reference, stand_in) = match kept.get(i) {
                Some(pair) => pair,
                None => {
                    again = (self.reference(&frame.window)?, self.shot(self.modes[0].stand_in, &frame.window)?);
                    &again
                }
            };
            let picture = |w: &Wanted| {
                let (picture, panels) = sheet(reference, stand_in, w.focus, &caption(w));
                (w.name.to_owned(), picture, panels)
            };
            let measured = flips.contains(&i);
            let overdraw = || self.modes[0].stand_in.overdraw(&frame.window, self.drawing());
            Ok(Retake {
                flip: measured.then(|| flip_of(reference.shot.picture(), stand_in.picture(), frame)),
                overdraw: measured.then(overdraw).transpose()?.flatten(),
                pictures: wanted.iter().filter(|w| w.view == i).map(picture).collect(),
            })
        };
        in_batches(views.into_iter().collect(), one)
    }
}

/// FLIP over the whole frame; it is nothing outside the window, where both pictures show the background.
fn flip_of(a: &Picture, b: &Picture, frame: &CropWindow) -> f64 {
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

/// The directions from the region's middle in which the scene is seen, with their solid angles: pixels of a cube.
fn directions(
    backend: &dyn Backend,
    geometry: &Geometry,
    region: &Region,
    stop: &Stop,
) -> Result<Vec<(DVec3, f64)>, Stopped> {
    const N: u32 = 32;
    let bounds = region.bounds();
    let (centre, far) = (bounds.centre(), (bounds.max - bounds.min).length() * 0.5 * 1e6);
    let mut all = Vec::new();
    for axis in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
        let fov = std::f64::consts::FRAC_PI_2;
        let view = View::look_at(centre, centre + axis, DVec3::Y, fov, N, N, far * 1e-9, far);
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
