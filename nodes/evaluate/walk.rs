//! The certificate of stand-ins that change from cell to cell.

use crate::{
    certify::{
        Panels, rounded,
        walk::{Frame, FrameFigures, Pace, WalkError, poses, walk},
    },
    engine::{
        node::{Ctx, List, Measure, Node, NodeError},
        plan::{Bundle, File},
    },
    formats::{Limits, from_glb},
    image::{Picture, encode_png},
    lod::entry::Entry,
    nodes::{backend, json_file},
    ports,
    raster::{Noise, Rendering, Shading},
    runtime::{
        Context,
        hybrid_lod::{
            Manifest, cell_scene,
            prefetch::Footprint,
            simulate::{CellData, Cells, Settings, simulate},
        },
    },
    scene::Scene,
    view::View,
};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::{collections::BTreeMap, path::Path, sync::Arc};

/// Walks along a path through the cells and compares each frame with the original: PSNR of luminance, triangles, what is missing, and what changes where another cell
/// is entered. Stand-ins are read from their files, as a program would load them. Source: Chen et al. 2003, section 4.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// The walk: `[[x, z], …]`. Empty for a line along the longer middle of the baked cells.
    #[schemars(extend("x-unit" = "m"))]
    pub path: Vec<[f64; 2]>,
    /// Metres a second.
    #[schemars(range(min = 1e-6, max = 1e9), extend("x-unit" = "m/s"))]
    pub speed: f64,
    /// Degrees a second.
    #[schemars(range(min = 0.1, max = 3600.0), extend("x-unit" = "°/s"))]
    pub turn: f64,
    /// Frames, spread evenly over the time of the walk.
    #[schemars(range(min = 2, max = 100_000))]
    pub frames: u32,
    /// Of a picture's side.
    #[schemars(range(min = 16, max = 4096), extend("x-unit" = "px"))]
    pub resolution: u32,
    /// Of the disk that the cells' files are read from as the walk goes on.
    #[schemars(range(min = 1e-3, max = 1e9), extend("x-unit" = "MB/s"))]
    pub disk: f64,
    /// Of textures that go to texture memory before each of 60 frames a second. A texture that is larger goes alone.
    #[schemars(range(min = 1, max = 1_000_000_000), extend("x-unit" = "KiB"))]
    pub texture_budget: u32,
    /// What a picture shows in height and width.
    #[schemars(range(min = 5.0, max = 150.0), extend("x-unit" = "°"))]
    pub fov: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            path: Vec::new(),
            speed: 30.0,
            turn: 45.0,
            frames: 60,
            resolution: 1024,
            disk: 35.0,
            texture_budget: 256,
            fov: 60.0,
        }
    }
}

ports! {
    pub struct In {
        /// What the stand-ins replace.
        original: Arc<Scene>,
        /// The manifest, as `write` `hybrid-lod` gives it.
        stand_in: Arc<Bundle>,
        /// The GLB files of the cells, by name.
        cells: List<File>,
    }
}

ports! {
    pub struct Out {
        /// The certificate, JSON.
        certificate: Arc<File>,
        /// Original, stand-in and difference side by side, PNG: the frame of least PSNR, and that in the middle of the walk.
        pictures: List<File>,
    }
}

/// The certificate's numbers: path, meaning, unit.
const MEASURES: &[(&str, &str, &str)] = &[
    ("psnr_y_db.avg", "PSNR of luminance over whole frames, mean", "dB"),
    ("psnr_y_db.min", "PSNR of luminance over whole frames, least", "dB"),
    ("psnr_y_object_db.avg", "PSNR of luminance over what is covered, mean", "dB"),
    ("psnr_y_object_db.min", "PSNR of luminance over what is covered, least", "dB"),
    ("missing.avg", "pixels of the original that are missing, mean share", ""),
    ("missing.max", "pixels of the original that are missing, largest share", ""),
    (
        "holes.avg_px",
        "width of the widest hole of a frame at most: where what lies far behind is seen, or nothing, mean",
        "px",
    ),
    ("holes.max_px", "width of the widest hole of all frames, at most", "px"),
    ("extra.avg", "pixels beyond the original, mean share", ""),
    ("extra.max", "pixels beyond the original, largest share", ""),
    ("triangles_per_frame.avg", "triangles in the frustum, mean", ""),
    ("triangles_per_frame.max", "triangles in the frustum, most", ""),
    ("original_triangles_per_frame.avg", "triangles of the original in the frustum, mean", ""),
    ("popping.count", "changes of the cell", ""),
    ("popping.share_max", "pixels that change visibly where the cell does, largest share", ""),
    ("popping.psnr_y_db_min", "PSNR between the two cells' pictures, least", "dB"),
    ("prefetch.stalls", "frames of 1/60 s that wait for the disk, neighbours being read ahead from a cold cache", ""),
    ("prefetch.longest_stall_ms", "the longest such wait", "ms"),
    ("without_prefetch.stalls", "frames of 1/60 s that wait for the disk if nothing is read ahead", ""),
    ("without_prefetch.longest_stall_ms", "the longest such wait", "ms"),
    ("cells.triangles_avg", "triangles of a cell's stand-ins, mean", ""),
    ("cells.inside_triangles_avg", "triangles of objects that are drawn as they are, mean of cells", ""),
    ("cells.ratio", "triangles of the original over those of a cell, mean", ""),
];

pub struct Walk;

impl Node for Walk {
    const KIND: &'static str = "evaluate";
    const METHOD: &'static str = "walk";
    const VERSION: u32 = 4;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        let pixels = u64::from(params.resolution).pow(2);
        // One cell is open at a time.
        (64 << 20) + pixels * 400 + sizes[0].saturating_mul(4) + sizes[1].saturating_mul(4)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        match params.path.iter().find(|p| !p.iter().all(|v| v.is_finite())) {
            Some(p) => Err(("path", format!("expected finite coordinates, found {p:?}"))),
            None => Ok(()),
        }
    }

    fn measures() -> Vec<Measure> {
        let one = |(path, about, unit): &(&str, &str, &str)| Measure {
            picture: path.starts_with("psnr").then(|| "worst-psnr".into()),
            ..Measure::new(path, about, unit)
        };
        MEASURES.iter().map(one).collect()
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let bundle = &inputs.stand_in;
        let bytes = bundle.files().get(bundle.main()).map(|f| &f.bytes[..]).unwrap_or_default();
        let manifest = Manifest::read(bytes).map_err(|e| NodeError::from_error(&e))?;
        let path = path(params, &manifest);
        let pace = Pace { speed: params.speed, turn: params.turn.to_radians(), step: 1.0 };
        let frames = frames(params, &manifest, &path, pace)?;
        let files: BTreeMap<&str, &Arc<File>> = inputs.cells.0.iter().map(|(n, f)| (n.as_str(), f)).collect();
        let scene_of = |cell: usize| -> Result<Scene, NodeError> {
            let entry = &manifest.cells[cell];
            let name = format!("{}.glb", entry.name);
            let file = files.get(entry.name.as_str());
            let file = file.ok_or_else(|| NodeError::Failed(format!("the cell {} has no file", entry.name)))?;
            let scene = from_glb(Path::new(&name), Arc::new(file.bytes.clone()), &Limits::default());
            Ok(cell_scene(scene.map_err(|e| NodeError::from_error(&e))?, entry, &inputs.original))
        };
        let shading = if crate::certify::colorless(&inputs.original) {
            // A pattern of some pixels on objects one cell away.
            Shading::Noise(Noise { period: manifest.size * 0.02 })
        } else {
            Shading::Unlit
        };
        let how = Rendering { shading, ..Rendering::default() };
        let context = Context { backend: backend(ctx), stop: ctx.stop };
        let walked = walk(&inputs.original, &frames, &scene_of, &how, context, ctx.progress).map_err(|e| match e {
            WalkError::Cell(e) => e,
            WalkError::Stopped(stopped) => stopped.into(),
        })?;
        let mut pictures = Vec::new();
        // Where original, stand-in and difference lie in each picture.
        let mut panels = BTreeMap::new();
        let mut place = |name: &'static str, picture: &Picture| {
            panels.insert(name, Panels::thirds(picture.width / 3, picture.height));
        };
        let png = |picture| -> Result<Arc<File>, NodeError> {
            let bytes = encode_png(picture).map_err(|e| NodeError::from_error(&e))?;
            Ok(Arc::new(File { media_type: "image/png".into(), bytes }))
        };
        if let Some(middle) = &walked.middle {
            place("middle", middle);
            pictures.push(("middle".to_owned(), png(middle)?));
        }
        if let Some((_, worst)) = &walked.worst {
            place("worst-psnr", worst);
            pictures.push(("worst-psnr".to_owned(), png(worst)?));
        }
        let all = inputs.original.triangle_count() as u64;
        let mut certificate = certificate(&walked.frames, &manifest, all, walked.worst.as_ref().map(|w| w.0));
        [certificate["prefetch"], certificate["without_prefetch"]] = played(params, &manifest, &path, pace)?;
        certificate["panels"] = json!(panels);
        Ok(Out { certificate: json_file(&certificate)?, pictures: List(pictures) })
    }
}

/// The walk's points at half of the cells' height.
fn path(params: &Params, manifest: &Manifest) -> Vec<DVec3> {
    let height = manifest.origin[1];
    if !params.path.is_empty() {
        return params.path.iter().map(|p| DVec3::new(p[0], height, p[1])).collect();
    }
    // From the first to the last of the cells that were baked.
    let centres = || manifest.cells.iter().map(|e| DVec3::from(e.centre));
    let ends = [0, 2].map(|k| {
        let by = |a: &DVec3, b: &DVec3| a[k].total_cmp(&b[k]);
        (centres().min_by(by), centres().max_by(by))
    });
    let long = |e: &(Option<DVec3>, Option<DVec3>)| e.0.zip(e.1).map_or(0.0, |(a, b)| a.distance(b));
    let (a, b) = if long(&ends[0]) >= long(&ends[1]) { ends[0] } else { ends[1] };
    a.into_iter().chain(b).collect()
}

fn frames(params: &Params, manifest: &Manifest, path: &[DVec3], pace: Pace) -> Result<Vec<Frame>, NodeError> {
    // The time of the walk by one frame a second; then as many as are wanted.
    let length: f64 = path.windows(2).map(|p| p[0].distance(p[1])).sum::<f64>() / pace.speed;
    let turns: f64 = path.windows(3).map(|p| (p[1] - p[0]).angle_between(p[2] - p[1])).filter(|a| a.is_finite()).sum();
    let seconds = length + turns / pace.turn;
    let step = (seconds / f64::from(params.frames - 1)).max(1e-9);
    let mut poses = poses(path, &Pace { step, ..pace });
    poses.truncate(params.frames as usize);
    let bounds = manifest.size * 1e-4;
    poses
        .iter()
        .map(|p| {
            let cell = manifest.locate(p.eye).ok_or_else(|| {
                NodeError::Failed(format!("`path` leaves the baked cells at x = {:.3}, z = {:.3} m", p.eye.x, p.eye.z))
            })?;
            let n = params.resolution;
            let view = View::look_at(
                p.eye,
                p.eye + p.aim,
                DVec3::Y,
                params.fov.to_radians(),
                n,
                n,
                bounds,
                manifest.size * 1e5,
            );
            Ok(Frame { view, cell })
        })
        .collect()
}

/// What the simulator says of the walk at 60 frames a second, from a cold cache, with neighbours read ahead and without. A program reads a cell's GLB
/// and its KTX2.
fn played(params: &Params, manifest: &Manifest, path: &[DVec3], pace: Pace) -> Result<[Value; 2], NodeError> {
    let time_step = 1.0 / 60.0;
    let data = |e: &Entry| CellData {
        footprint: Footprint { centre: DVec3::from(e.centre), radius: manifest.size },
        geometry: e.glb_bytes,
        textures: if e.texture_bytes > 0 { vec![e.texture_bytes] } else { Vec::new() },
    };
    let cells: Vec<CellData> = manifest.cells.iter().map(data).collect();
    let around = |e: &Entry| e.neighbours.iter().filter_map(|n| manifest.number(n)).collect();
    let neighbours: Vec<Vec<usize>> = manifest.cells.iter().map(around).collect();
    let world = Cells { cells: &cells, neighbours: &neighbours, find: &|p| manifest.locate(p) };
    let walk = poses(path, &Pace { step: time_step, ..pace });
    let settings = Settings {
        disk: params.disk * 1e6,
        texture_budget: u64::from(params.texture_budget) << 10,
        fov: params.fov.to_radians(),
        time_step,
        ..Settings::default()
    };
    let figures = |prefetch| -> Result<Value, NodeError> {
        let report =
            simulate(&world, &walk, &Settings { prefetch, ..settings }).map_err(|e| NodeError::from_error(&e))?;
        let t = &report.totals;
        // The first frame has to wait for its cell whatever is done.
        let later = report.frames.iter().skip(1).map(|f| f.stall_ms).fold(0.0, f64::max);
        Ok(json!({
            "frames": report.frames.len(),
            "stalls": t.stalls,
            "longest_stall_ms": rounded(t.longest_stall_ms, 3),
            "stall_ms": rounded(t.stall_ms, 3),
            "longest_stall_after_first_ms": rounded(later, 3),
            "bytes_read": t.bytes_read,
            "cells_read": t.cells_read,
            "frames_over_budget": t.frames_over_budget,
            "frames_with_missing_textures": t.frames_with_missing_textures,
            "peak_memory_bytes": t.peak_memory,
            "peak_texture_memory_bytes": t.peak_texture_memory,
        }))
    };
    Ok([figures(true)?, figures(false)?])
}

fn certificate(frames: &[FrameFigures], manifest: &Manifest, original_triangles: u64, worst: Option<usize>) -> Value {
    let mean = |values: &[f64]| if values.is_empty() { 0.0 } else { values.iter().sum::<f64>() / values.len() as f64 };
    let of = |f: &dyn Fn(&FrameFigures) -> f64| -> Vec<f64> { frames.iter().map(f).collect() };
    let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    let share = |n: u64, f: &FrameFigures| n as f64 / f.covered.max(1) as f64;
    let psnr = of(&|f| f.psnr_y_db);
    let object: Vec<f64> = frames.iter().filter_map(|f| f.psnr_y_object_db).collect();
    let holes = of(&|f| f64::from(f.hole_px));
    let (missing, extra) = (of(&|f| share(f.missing, f)), of(&|f| share(f.extra, f)));
    let (drawn, full) = (of(&|f| f.triangles as f64), of(&|f| f.original_triangles as f64));
    let pops: Vec<_> = frames.iter().filter_map(|f| f.popping).collect();
    let cells = |f: &dyn Fn(&Entry) -> f64| mean(&manifest.cells.iter().map(f).collect::<Vec<_>>());
    let ratio = original_triangles as f64 / cells(&|c| (c.triangles + c.inside_triangles) as f64).max(1.0);
    let ends = |values: &[f64], places: i32| {
        if values.is_empty() {
            Value::Null
        } else {
            json!({ "avg": rounded(mean(values), places), "min": rounded(least(values), places) })
        }
    };
    let tops = |values: &[f64], places: i32| json!({ "avg": rounded(mean(values), places), "max": rounded(most(values), places) });
    json!({
        "frames": frames.len(),
        "psnr_y_db": ends(&psnr, 3),
        "psnr_y_object_db": ends(&object, 3),
        "missing": tops(&missing, 6),
        "holes": { "avg_px": rounded(mean(&holes), 3), "max_px": most(&holes) },
        "extra": tops(&extra, 6),
        "triangles_per_frame": tops(&drawn, 1),
        "original_triangles_per_frame": tops(&full, 1),
        "popping": {
            "count": pops.len(),
            "share_avg": rounded(mean(&pops.iter().map(|p| p.share).collect::<Vec<_>>()), 6),
            "share_max": rounded(most(&pops.iter().map(|p| p.share).collect::<Vec<_>>()), 6),
            "psnr_y_db_min": if pops.is_empty() { Value::Null } else { json!(least(&pops.iter().map(|p| p.psnr_y_db).collect::<Vec<_>>())) },
        },
        "cells": {
            "count": manifest.cells.len(),
            "triangles_avg": rounded(cells(&|c| c.triangles as f64), 1),
            "inside_triangles_avg": rounded(cells(&|c| c.inside_triangles as f64), 1),
            "original_triangles": original_triangles,
            "ratio": rounded(ratio, 2),
            "texels_avg": rounded(cells(&|c| c.texels as f64), 1),
            "glb_bytes_avg": rounded(cells(&|c| c.glb_bytes as f64), 1),
            "texture_bytes_avg": rounded(cells(&|c| c.texture_bytes as f64), 1),
            "stand_ins_avg": rounded(cells(&|c| c.stand_ins.len() as f64), 3),
            "mv_share": rounded(stand_ins(manifest, &|s| s.kind == "mv"), 4),
            "cluster_share": rounded(stand_ins(manifest, &|s| s.objects.len() > 1), 4),
        },
        "worst_frame": worst,
        "per_frame": frames,
    })
}

/// The share of stand-ins of which something holds.
fn stand_ins(manifest: &Manifest, what: &dyn Fn(&crate::lod::entry::StandInRow) -> bool) -> f64 {
    let all: Vec<_> = manifest.cells.iter().flat_map(|c| &c.stand_ins).collect();
    all.iter().filter(|s| what(s)).count() as f64 / all.len().max(1) as f64
}
