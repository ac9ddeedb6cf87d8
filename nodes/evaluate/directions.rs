//! The certificate of a stand-in that can be seen from anywhere.

use crate::{
    certify::{
        Context, Panels,
        directions::{Look, Seen, measure, sheet},
        rounded,
    },
    engine::{
        node::{Ctx, List, Measure, Node, NodeError},
        plan::{Bundle, File},
    },
    formats::Limits,
    image::encode_png,
    math::Sequence,
    nodes::{contents::Contents, json_file},
    ports,
    relief::select::projected_length_threshold,
    runtime,
    scene::Scene,
    view::{Region, directions::geodesic},
};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::{collections::BTreeMap, path::Path, sync::Arc};

/// Looks at original and stand-in from many directions and certifies what the stand-in misses, what it adds, and how the lit object looks. The first
/// directions are the 320 of the paper's section 3.2; from what is missing there follows the projected length threshold, the size on the screen up to
/// which the stand-in may be used. Other directions are looked at with the object that large. Source: Andújar et al., Omni-directional Relief Impostors,
/// 2007, section 3.4.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Pixels along the longer side of the object's projection in the first directions: s0.
    #[schemars(range(min = 16, max = 4096), extend("x-unit" = "px"))]
    pub size: u32,
    /// How often the faces of an icosahedron are split in four: 2 gives 320 directions.
    #[schemars(range(min = 0, max = 4))]
    pub subdivisions: u32,
    /// Other directions, spread evenly over the sphere.
    #[schemars(range(min = 0, max = 100000))]
    pub others: u32,
    /// Of the object's projection in the other directions at most, where the threshold is larger.
    #[schemars(range(min = 16, max = 4096), extend("x-unit" = "px"))]
    pub most: u32,
    /// Samples of a pixel in x and in y for colours.
    #[schemars(range(min = 1, max = 16))]
    pub samples: u32,
}

impl Default for Params {
    fn default() -> Self {
        Self { size: 256, subdivisions: 2, others: 100, most: 512, samples: 2 }
    }
}

ports! {
    pub struct In {
        /// What the stand-in replaces.
        original: Arc<Scene>,
        /// The stand-in's files, read as an engine would read them.
        stand_in: Arc<Bundle>,
    }
}

ports! {
    pub struct Out {
        /// The certificate, JSON.
        certificate: Arc<File>,
        /// Original, stand-in and difference side by side, PNG: the directions in which most is missing, most is extra, and the object looks least alike.
        pictures: List<File>,
    }
}

/// The certificate's numbers of each set of directions: path, meaning, unit.
const MEASURES: &[(&str, &str, &str)] = &[
    ("count", "directions", ""),
    ("size_px", "pixels along the longer side of the object's projection", "px"),
    ("coverage_error.min", "pixels of the original that are missing, least of all directions, over size²", ""),
    ("coverage_error.avg", "pixels of the original that are missing, mean of all directions, over size²", ""),
    ("coverage_error.max", "pixels of the original that are missing, most of all directions, over size²", ""),
    ("extra.avg", "pixels beyond the original, mean of all directions, over size²", ""),
    ("extra.max", "pixels beyond the original, most of all directions, over size²", ""),
    ("impostors_per_frame.avg", "maps that are drawn, mean of all directions", ""),
    ("impostors_per_frame.max", "maps that are drawn, most of all directions", ""),
    ("psnr_y_object_db.mean", "PSNR of the lit object's luminance, mean of all directions", "dB"),
    ("psnr_y_object_db.min", "PSNR of the lit object's luminance, least of all directions", "dB"),
];

pub struct Directions;

impl Node for Directions {
    const KIND: &'static str = "evaluate";
    const METHOD: &'static str = "directions";
    const VERSION: u32 = 3;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        // A thread's pictures of one direction; the stand-in made ready, and the original's triangles of a view.
        let pixels = u64::from(params.size.max(params.most)).pow(2);
        (64 << 20) + pixels * 400 + sizes.iter().fold(0_u64, |s, n| s.saturating_add(*n)).saturating_mul(6)
    }

    fn measures() -> Vec<Measure> {
        let of = |set: &'static str| {
            MEASURES.iter().map(move |(path, about, unit)| Measure {
                path: format!("{set}.{path}"),
                about: format!("{about} ({set})"),
                unit: (*unit).to_owned(),
                picture: None,
            })
        };
        let plt = Measure {
            path: "plt_px".into(),
            about: "projected length threshold: the size on the screen up to which the stand-in may be used".into(),
            unit: "px".into(),
            picture: None,
        };
        std::iter::once(plt).chain(of("directions")).chain(of("others")).collect()
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        if inputs.original.bounds().is_empty() {
            return Err(NodeError::Failed("the original has no triangles".into()));
        }
        let bundle = &inputs.stand_in;
        let opened = runtime::open(Path::new(bundle.main()), &Contents(bundle), &Limits::default());
        let opened = opened.map_err(|e| NodeError::from_error(&e))?;
        let modes = opened.modes();
        let Some((_, stand_in)) = modes.first() else {
            return Err(NodeError::Failed("the stand-in cannot be drawn".into()));
        };
        let context = Context { backend: crate::nodes::backend(ctx), stop: ctx.stop, progress: ctx.progress };
        let run = |directions: &[DVec3], size: u32| {
            measure(&inputs.original, &**stand_in, directions, Look { size, samples: params.samples }, context)
        };
        let first = geodesic(params.subdivisions);
        let seen = run(&first, params.size)?;
        let worst = seen.iter().map(|s| s.missing).max().unwrap_or(0);
        let plt = projected_length_threshold(params.size, worst);
        // Sizes from 16 pixels on have something to see.
        let size = plt.floor().clamp(16.0, f64::from(params.most)) as u32;
        let sphere = Region::Sphere { centre: DVec3::ZERO, radius: 1.0 };
        let sequence = Sequence::<3>::new(1);
        let others: Vec<DVec3> = (0..params.others).map(|i| sphere.eye(sequence.point(i))).collect();
        let others_seen = run(&others, size)?;
        let mut certificate = json!({
            "plt_px": if plt.is_finite() { json!(rounded(plt, 1)) } else { Value::Null },
            "directions": figures(&seen, params.size),
            "others": figures(&others_seen, size),
        });
        let all = || {
            first.iter().zip(&seen).map(|d| (d, params.size)).chain(others.iter().zip(&others_seen).map(|d| (d, size)))
        };
        let share = |pixels: u64, size: u32| pixels as f64 / (f64::from(size) * f64::from(size));
        let worst_of = |rank: &dyn Fn(&Seen, u32) -> f64| {
            // Of equals the first, whatever the order of comparison.
            all().reduce(|a, b| if rank(b.0.1, b.1) > rank(a.0.1, a.1) { b } else { a })
        };
        let wanted: [(&str, &dyn Fn(&Seen, u32) -> f64); 3] = [
            ("worst-extra", &|s, size| share(s.extra, size)),
            ("worst-missing", &|s, size| share(s.missing, size)),
            ("worst-psnr", &|s, _| -s.psnr.unwrap_or(f64::INFINITY)),
        ];
        let (mut pictures, mut panels) = (Vec::new(), BTreeMap::new());
        for (name, rank) in wanted {
            let Some(((direction, _), size)) = worst_of(rank) else { continue };
            let look = Look { size, samples: params.samples };
            let Some(sheet) = sheet(&inputs.original, &**stand_in, *direction, look, context)? else { continue };
            panels.insert(name, Panels::thirds(sheet.original.width, sheet.original.height));
            let bytes = encode_png(&sheet.picture()).map_err(|e| NodeError::from_error(&e))?;
            pictures.push((name.to_owned(), Arc::new(File { media_type: "image/png".into(), bytes })));
        }
        // Where original, stand-in and difference lie in each picture.
        certificate["panels"] = json!(panels);
        Ok(Out { certificate: json_file(&certificate)?, pictures: List(pictures) })
    }
}

/// Decimals of a share of pixels: one of ten million shows.
const SHARE: i32 = 7;

/// The figures of a set of directions; null where it is empty, and colours where no direction shows a pixel.
fn figures(seen: &[Seen], size: u32) -> Value {
    if seen.is_empty() {
        return Value::Null;
    }
    let pixels = f64::from(size) * f64::from(size);
    let n = seen.len() as f64;
    let least = |f: &dyn Fn(&Seen) -> u64| seen.iter().map(f).min().unwrap_or(0) as f64 / pixels;
    let most = |f: &dyn Fn(&Seen) -> u64| seen.iter().map(f).max().unwrap_or(0) as f64 / pixels;
    let mean = |f: &dyn Fn(&Seen) -> u64| seen.iter().map(f).sum::<u64>() as f64 / pixels / n;
    let (missing, extra): (&dyn Fn(&Seen) -> u64, &dyn Fn(&Seen) -> u64) = (&|s| s.missing, &|s| s.extra);
    let drawn: Vec<f64> = seen.iter().filter_map(|s| s.drawn.map(f64::from)).collect();
    let psnr: Vec<f64> = seen.iter().filter_map(|s| s.psnr).collect();
    let average = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let shares =
        |f: &dyn Fn(&Seen) -> u64| -> Vec<f64> { seen.iter().map(|s| rounded(f(s) as f64 / pixels, SHARE)).collect() };
    json!({
        "count": seen.len(),
        "size_px": size,
        "coverage_error": {
            "min": rounded(least(missing), SHARE),
            "avg": rounded(mean(missing), SHARE),
            "max": rounded(most(missing), SHARE),
        },
        "extra": { "avg": rounded(mean(extra), SHARE), "max": rounded(most(extra), SHARE) },
        "impostors_per_frame": if drawn.is_empty() { Value::Null } else {
            json!({ "avg": rounded(average(&drawn), 3), "max": drawn.iter().copied().fold(0.0, f64::max) })
        },
        "psnr_y_object_db": if psnr.is_empty() { Value::Null } else {
            json!({ "mean": rounded(average(&psnr), 3), "min": rounded(psnr.iter().copied().fold(f64::INFINITY, f64::min), 3) })
        },
        // In the order of the directions.
        "per_view": {
            "psnr_y_object_db": seen.iter().map(|s| s.psnr.map(|p| rounded(p, 3))).collect::<Vec<_>>(),
            "coverage_error": shares(missing),
            "extra": shares(extra),
        },
    })
}
