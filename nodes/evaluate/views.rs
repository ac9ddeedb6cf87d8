//! The certificate of a stand-in: how it looks.

use crate::{
    certify::{self, Choice, CompareError, Mode, Sampled, Sampling, VIEWS_AT_ONCE, Viewing},
    engine::{
        node::{Ctx, List, Measure, Node, NodeError},
        plan::{Bundle, File},
    },
    formats::Limits,
    image::encode_png,
    nodes::{
        contents::Contents,
        values::{Bound, Ceiling},
    },
    ports,
    raster::MAX_SIDE,
    runtime,
    scene::Scene,
    view::{Cell, Region},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{path::Path, sync::Arc};

/// Which colours are compared; always the same for original and stand-in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shading {
    /// `unlit`, or `noise` where the original has no colour at all.
    #[default]
    Auto,
    /// The base colour as it is.
    Unlit,
    /// A sun and a sky. Materials that say they are unlit, such as those of a stand-in into which the light was
    /// baked, stay as they are.
    Lit,
    /// Base colour times a 3D noise of the surface point: shows displacement where there is no texture.
    Noise,
}

impl From<Shading> for Choice {
    fn from(s: Shading) -> Self {
        match s {
            Shading::Auto => Choice::Auto,
            Shading::Unlit => Choice::Unlit,
            Shading::Lit => Choice::Lit,
            Shading::Noise => Choice::Noise,
        }
    }
}

/// Renders original and stand-in from many views of the cell and certifies the difference. The views are drawn from the whole
/// cell by a low-discrepancy sequence, its eight corners first. Which surface a pixel shows is decided by depth at its centre,
/// never by colour; PSNR is that of luminance (Chen et al. 2003, section 4.2).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Number of views, 8 or more: the corners of the cell are always among them.
    pub views: u32,
    /// Seed of the sequence of views.
    pub seed: u64,
    /// Width and height of a picture in pixels; the resolution that the stand-in was made for.
    pub resolution: u32,
    /// Field of view of a picture, degrees. What is larger is looked at in parts.
    pub fov: f64,
    /// Samples of a pixel in x and in y for colour, 1 to 16; `resolution` times this is at most 16384.
    pub samples: u32,
    /// Which colours are compared.
    pub shading: Shading,
    /// The bound in pixels where no `bound` is connected.
    pub assumed_bound: f64,
    /// Whether it is no error that no view shows the original, as with an object that is less than a pixel: nothing of it can differ then.
    pub may_be_unseen: bool,
    /// Name of the stand-in in the certificate.
    pub name: String,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            views: 64,
            seed: 1,
            resolution: 1024,
            fov: 45.0,
            samples: 4,
            shading: Shading::Auto,
            assumed_bound: 1.0,
            may_be_unseen: false,
            name: String::new(),
        }
    }
}

ports! {
    pub struct In {
        /// What the stand-in replaces.
        original: Arc<Scene>,
        /// The stand-in's files, read as an engine would read them.
        stand_in: Arc<Bundle>,
        /// What the mesh before simplification reaches, from `measure-ceiling`.
        ceiling: Option<Arc<Ceiling>>,
        /// The cell from which the stand-in will be seen. Either it or a `region` is connected.
        cell: Option<Arc<Cell>>,
        /// Another place from which it will be seen, such as a sphere around it.
        region: Option<Arc<Region>>,
        /// The error that the method promises not to exceed, in pixels.
        bound: Option<Arc<Bound>>,
    }
}

ports! {
    pub struct Out {
        /// The certificate, JSON.
        certificate: Arc<File>,
        /// None where nothing is seen. Original, stand-in and difference side by side, PNG: the view of median PSNR (`typical`) and the worst of each
        /// measure.
        pictures: List<File, true>,
    }
}

pub struct Views;

impl Node for Views {
    const KIND: &'static str = "evaluate";
    const METHOD: &'static str = "views";
    const VERSION: u32 = 8;
    /// FLIP is C++.
    const NATIVE: bool = true;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        memory(params.resolution, sizes)
    }

    fn measures() -> Vec<Measure> {
        let measure = |m: &certify::Measure| Measure {
            path: m.path.clone(),
            about: m.about.clone(),
            unit: m.unit.to_owned(),
            picture: m.picture.map(str::to_owned),
        };
        certify::measures().iter().map(measure).collect()
    }

    fn doubts(params: &Params) -> Vec<(&'static str, String)> {
        crate::nodes::doubt_fov(params.fov)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        let Params { views, resolution, fov, samples, assumed_bound, .. } = params;
        check_viewing(*views, *resolution, *fov, *samples)?;
        check_bound("assumed_bound", *assumed_bound)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let region = region(inputs.cell, inputs.region)?;
        let bundle = &inputs.stand_in;
        let opened = runtime::open(Path::new(bundle.main()), &Contents(bundle), &Limits::default());
        let opened = opened.map_err(|e| NodeError::from_error(&e))?;
        let bound = inputs.bound.as_deref().map_or_else(
            || certify::Bound {
                kind: "assumed: none was stated".into(),
                value: params.assumed_bound,
                unit: "px".into(),
                held: false,
            },
            |b| certify::Bound { kind: b.kind.clone(), value: b.value, unit: b.unit.clone(), held: false },
        );
        let Params { views, seed, resolution, fov, samples, shading, .. } = *params;
        let viewing = viewing([views, resolution, samples], seed, fov, shading);
        let ceiling = inputs.ceiling.as_deref().map(|c| seen_alike(c, &viewing, &region)).transpose()?;
        let options = certify::Options {
            viewing,
            bound,
            stand_in: certify::Subject { name: params.name.clone(), blake3: hash(bundle) },
            bytes: bundle.size(),
            ceiling,
            may_be_unseen: params.may_be_unseen,
        };
        let context = certify::Context { backend: crate::nodes::backend(ctx), stop: ctx.stop, progress: ctx.progress };
        let drawn = opened.modes();
        let modes: Vec<Mode> = drawn.iter().map(|m| Mode { name: m.0.to_owned(), stand_in: &*m.1 }).collect();
        let result = certify::compare(&inputs.original, &modes, &region, &options, context);
        let comparison = result.map_err(failed)?;
        let mut pictures = Vec::new();
        for (name, picture) in &comparison.pictures {
            ctx.stop.check()?;
            let bytes = encode_png(picture).map_err(|e| NodeError::from_error(&e))?;
            pictures.push((name.clone(), Arc::new(File { media_type: "image/png".into(), bytes })));
        }
        let certificate =
            File { media_type: "application/json".into(), bytes: comparison.certificate.to_json().into_bytes() };
        Ok(Out { certificate: Arc::new(certificate), pictures: List(pictures) })
    }
}

/// What a comparison of scenes needs, bytes.
pub(in crate::nodes) fn memory(resolution: u32, sizes: &[u64]) -> u64 {
    // Per pixel two scenes' depths, numbers, pictures and luminance, those of few views kept, the measures' maps, FLIP's own images. Per byte
    // of a scene the triangles of a view, prepared twice.
    let pixels = u64::from(resolution).saturating_mul(resolution.into());
    let views = VIEWS_AT_ONCE as u64;
    let scenes = sizes.iter().take(2).fold(0_u64, |s, n| s.saturating_add(*n));
    pixels.saturating_mul(220 * views).saturating_add(scenes.saturating_mul(2 * views)).saturating_add(64 << 20)
}

pub(in crate::nodes) fn check_viewing(
    views: u32,
    resolution: u32,
    fov: f64,
    samples: u32,
) -> Result<(), (&'static str, String)> {
    if !(8..=100_000).contains(&views) {
        return Err(("views", format!("{views}; expected 8 (the corners of the cell) to 100,000")));
    }
    if !(1..=16).contains(&samples) {
        return Err(("samples", format!("{samples}; expected 1 to 16")));
    }
    if !(16..=MAX_SIDE / samples).contains(&resolution) {
        let most = MAX_SIDE / samples;
        return Err(("resolution", format!("{resolution}; expected 16 to {most} pixels with {samples} samples")));
    }
    if !(0.1..=160.0).contains(&fov) {
        return Err(("fov", format!("{fov}; expected 0.1 to 160 degrees")));
    }
    Ok(())
}

pub(in crate::nodes) fn check_bound(name: &'static str, bound: f64) -> Result<(), (&'static str, String)> {
    match bound > 0.0 && bound <= 1000.0 {
        true => Ok(()),
        false => Err((name, format!("{bound}; expected more than 0 and at most 1000 pixels"))),
    }
}

/// How scenes are looked at, `fov` in degrees.
pub(in crate::nodes) fn viewing(
    [views, resolution, samples]: [u32; 3],
    seed: u64,
    fov: f64,
    shading: Shading,
) -> Viewing {
    let sampling = Sampling { views, seed, resolution, fov: fov.to_radians() };
    Viewing { sampling, samples_per_axis: samples, shading: shading.into() }
}

/// Where the viewer is: what one of the two ports says.
pub(in crate::nodes) fn region(cell: Option<Arc<Cell>>, region: Option<Arc<Region>>) -> Result<Region, NodeError> {
    match (cell, region) {
        (Some(cell), None) => Ok(Region::Box(*cell)),
        (None, Some(region)) => Ok((*region).clone()),
        _ => {
            let what = "from where is the stand-in seen? Connect either `cell` or `region`";
            Err(NodeError::Failed(what.into()))
        }
    }
}

pub(in crate::nodes) fn failed(error: CompareError) -> NodeError {
    match error {
        CompareError::Stopped(s) => NodeError::Stopped(s),
        e => NodeError::from_error(&e),
    }
}

/// The ceiling, where it was looked at as the stand-in will be.
fn seen_alike(ceiling: &Ceiling, viewing: &Viewing, region: &Region) -> Result<certify::Ceiling, NodeError> {
    let here = serde_json::to_value(Sampled::of(viewing, region)).map_err(|e| NodeError::from_error(&e))?;
    if here == ceiling.sampling {
        return Ok(ceiling.ceiling.clone());
    }
    let differing =
        here.as_object().into_iter().flatten().find(|(key, value)| ceiling.sampling.get(key) != Some(value));
    let (key, value) = differing.map_or(("cell", &here), |(key, value)| (key.as_str(), value));
    let of_ceiling = ceiling.sampling.get(key).map_or_else(|| "another".to_owned(), ToString::to_string);
    Err(NodeError::Failed(format!(
        "ceiling: it was looked at otherwise: `{key}` is {of_ceiling} there and {value} here; give `measure-ceiling` the same"
    )))
}

/// Of a file alone that of its bytes; of several that of all paths, lengths and bytes in their order.
fn hash(bundle: &Bundle) -> String {
    if let [file] = &bundle.files().values().collect::<Vec<_>>()[..] {
        return blake3::hash(&file.bytes).to_hex().to_string();
    }
    let mut hasher = blake3::Hasher::new();
    for (path, file) in bundle.files() {
        hasher.update(&(path.len() as u64).to_le_bytes()).update(path.as_bytes());
        hasher.update(&(file.bytes.len() as u64).to_le_bytes()).update(&file.bytes);
    }
    hasher.finalize().to_hex().to_string()
}
