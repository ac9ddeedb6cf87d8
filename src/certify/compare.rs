//! The comparison: draws the views, renders, measures, and writes down the certificate.

use super::{
    certificate::{Bound, Camera, Ceiling, Certificate, Flip, Sampling as Sampled, StandIn, WorstView},
    figures::{Figures, rounded},
    frame::Frame,
    measure::{Reference, Setting, Shot, ViewFigures},
    pictures::panels,
    shading::{self, Choice},
    views::{self, Sampling},
};
use crate::{
    image::{Picture, measure::flip},
    math::{Stop, Stopped, View},
    raster::{self, Backend, Geometry, Rendering, Shader, nearest},
    scene::{Image, Scene},
    voxel::Cell,
};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

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
    /// and `worst-…`, the views that the certificate's `worst_view` refers to.
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

/// Compares a stand-in, rendered by `backend`, and the `ceiling` that it was simplified from, with its original, seen from `cell`.
pub fn compare(
    original: &Scene,
    stand_in: &Scene,
    ceiling: Option<&Scene>,
    cell: &Cell,
    options: &Options,
    backend: &dyn Backend,
    stop: &Stop,
) -> Result<Comparison, CompareError> {
    check(original, stand_in, options)?;
    let sampling = &options.sampling;
    let (shading, words) = shading::choose(options.shading, original, cell, sampling);
    let setting = Setting {
        cell: *cell,
        pixel: sampling.pixel_angle(),
        bound_px: options.bound.value,
        rendering: Rendering { samples_per_axis: options.samples_per_axis, shading, ..Rendering::default() },
    };
    let geometry = Geometry::new(original);
    let stand_in_geometry = Geometry::new(stand_in);
    let ceiling_geometry = ceiling.map(Geometry::new);
    let judge = Judge {
        original: Shader::new(&geometry),
        stand_in: Shader::new(&stand_in_geometry),
        ceiling: ceiling_geometry.as_ref().map(Shader::new),
        setting,
        backend,
        stop,
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
    let (mut worst, names) = worst_views(&figures, &order, |i| Camera::of(&views[i], sampling.fov.to_degrees()));
    let looked_at = judge.look(&frames, &order[..order.len().min(FLIP_VIEWS)], &names)?;
    let flips: Vec<f64> = looked_at.iter().filter_map(|l| l.flip).collect();
    let pictures = looked_at.into_iter().filter_map(|l| Some((names.get(&l.view)?.clone(), l.picture?))).collect();
    worst.values_mut().filter(|w| w.value == 0.0).for_each(|w| w.picture = None);

    let band_px = setting.bound_px.ceil() as u32;
    let certificate = Certificate {
        stand_in: options.stand_in.clone(),
        triangles: stand_in.triangle_count() as u64,
        original_triangles: original.triangle_count() as u64,
        texels: texels(stand_in),
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
    };
    Ok(Comparison { certificate, pictures })
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
    backend: &'a dyn Backend,
    stop: &'a Stop,
}

/// A view rendered once more.
struct Look {
    view: usize,
    flip: Option<f64>,
    picture: Option<Picture>,
}

impl Judge<'_> {
    /// Figures of the stand-in in every view, and of the ceiling in the first `ceiling_views`.
    fn measure(
        &self,
        frames: &[Frame],
        ceiling_views: usize,
    ) -> Result<Vec<(ViewFigures, Option<ViewFigures>)>, Stopped> {
        let one = |(i, frame): (usize, &Frame)| {
            let reference = Reference::take(self.backend, &self.original, &frame.window, &self.setting, self.stop)?;
            let judged = |shader: &Shader| -> Result<ViewFigures, Stopped> {
                let shot = Shot::take(self.backend, shader, &frame.window, &self.setting.rendering, self.stop)?;
                Ok(reference.measure(&shot, shader.geometry, frame))
            };
            let ceiling = self.ceiling.as_ref().filter(|_| i < ceiling_views).map(judged).transpose()?;
            Ok((judged(&self.stand_in)?, ceiling))
        };
        in_batches(frames.iter().enumerate().collect(), one)
    }

    /// FLIP for the views in `flips`, panels for those in `names`.
    fn look(&self, frames: &[Frame], flips: &[usize], names: &BTreeMap<usize, String>) -> Result<Vec<Look>, Stopped> {
        let wanted: BTreeSet<usize> = flips.iter().chain(names.keys()).copied().collect();
        let one = |i: usize| {
            let frame = &frames[i];
            let reference = Reference::take(self.backend, &self.original, &frame.window, &self.setting, self.stop)?;
            let stand_in = Shot::take(self.backend, &self.stand_in, &frame.window, &self.setting.rendering, self.stop)?;
            Ok(Look {
                view: i,
                flip: flips.contains(&i).then(|| flip_of(&reference.shot.picture, &stand_in.picture, frame)),
                picture: names.contains_key(&i).then(|| panels(&reference, &stand_in, frame)),
            })
        };
        in_batches(wanted.into_iter().collect(), one)
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

/// Views that see something, the worst by PSNR over the object first.
fn by_psnr(figures: &[ViewFigures]) -> Vec<usize> {
    let mut seen: Vec<(usize, f64)> =
        figures.iter().enumerate().filter_map(|(i, f)| Some((i, f.psnr_object?))).collect();
    seen.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    seen.into_iter().map(|(i, _)| i).collect()
}

/// The worst view of each measure, and the names of the views of which pictures are made.
fn worst_views(
    figures: &[ViewFigures],
    by_psnr: &[usize],
    camera: impl Fn(usize) -> Camera,
) -> (BTreeMap<&'static str, WorstView>, BTreeMap<usize, String>) {
    let mut worst = BTreeMap::new();
    let mut names: BTreeMap<usize, String> = BTreeMap::new();
    let mut add = |measure: &'static str, picture: &str, view: usize, value: f64, bad: bool| {
        let picture = bad.then(|| names.entry(view).or_insert_with(|| picture.to_owned()).clone());
        worst.insert(measure, WorstView { value: rounded(value, 3), view: view as u32, camera: camera(view), picture });
    };
    if let Some(first) = by_psnr.first() {
        add("psnr_y_object_db", "worst-psnr", *first, figures[*first].psnr_object.unwrap_or_default(), true);
    }
    type Key = fn(&ViewFigures) -> (u64, u64);
    let counts: [(&'static str, &str, Key); 5] = [
        ("missing_px", "worst-missing", |f| (f.counts.outside.missing, f.counts.inside.missing)),
        ("extra_px", "worst-extra", |f| (f.counts.outside.extra, f.counts.inside.extra)),
        ("wrong_surface_px", "worst-wrong-surface", |f| {
            (f.counts.outside.wrong_surface, f.counts.inside.wrong_surface)
        }),
        ("in_front_px", "worst-in-front", |f| (f.counts.outside.in_front, f.counts.inside.in_front)),
        ("crack_px", "worst-crack", |f| (f.counts.crack, 0)),
    ];
    for (measure, picture, key) in counts {
        // Of equals the first; those inside the band decide where there are none outside.
        let (mut view, mut most) = (0, (0, 0));
        for (i, f) in figures.iter().enumerate() {
            if key(f) > most {
                (view, most) = (i, key(f));
            }
        }
        add(measure, picture, view, most.0 as f64, most.0 > 0);
    }
    let (mut view, mut most) = (0, 0.0);
    for (i, f) in figures.iter().enumerate() {
        if f.max_deviation > most {
            (view, most) = (i, f.max_deviation);
        }
    }
    add("max_deviation_px", "worst-deviation", view, most, most > 0.0);
    if let Some(median) = by_psnr.get(by_psnr.len() / 2) {
        names.entry(*median).or_insert_with(|| "typical".to_owned());
    }
    (worst, names)
}

/// Texels of all images that the scene's materials use, each image once.
fn texels(scene: &Scene) -> u64 {
    let mut images: BTreeMap<*const Image, u64> = BTreeMap::new();
    for part in scene.objects.iter().flat_map(|o| &o.parts) {
        let m = &part.material;
        let used = [&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture, &m.emissive_texture];
        for texture in used.into_iter().flatten() {
            images.insert(std::sync::Arc::as_ptr(&texture.image), texture.image.texels.len() as u64);
        }
    }
    images.values().sum()
}
