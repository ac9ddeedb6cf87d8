//! The certificate of a solid: what is inside and what is outside.

use crate::{
    engine::{
        node::{Ctx, Measure, Node, NodeError},
        plan::File,
    },
    math::Sequence,
    nodes::{
        json_file,
        values::{ChosenDirection, Sprite},
    },
    ports,
    raster::Geometry,
    scene::Scene,
    sprite::{Exact, Layout, Packed, Peeled, Repair, WindingSolid},
};
use glam::DVec3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::sync::Arc;

/// Classifies points spread over the unit cube around a solid by the sprite, by the image that was packed, in every layout, and by the
/// mesh itself, and counts what differs. Points nearer to the surface than 0.75 texel may fall on either side of it in an image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Number of points, 1 to 1,000,000,000.
    pub points: u32,
    /// Seed of the sequence of points.
    pub seed: u64,
}

impl Default for Params {
    fn default() -> Self {
        Self { points: 200_000, seed: 1 }
    }
}

ports! {
    pub struct In {
        /// The solid.
        scene: Arc<Scene>,
        /// The image as it was peeled.
        image: Arc<Peeled>,
        /// What was made of it.
        sprite: Arc<Sprite>,
        /// How its direction was chosen.
        direction: Option<Arc<ChosenDirection>>,
    }
}

ports! {
    pub struct Out {
        /// The certificate, JSON.
        certificate: Arc<File>,
    }
}

/// The certificate's numbers: path, meaning, unit. Ratios of layouts are by the layouts' names.
const MEASURES: &[(&str, &str, &str)] = &[
    ("resolution", "width and height of the image before it was cropped", "texels"),
    ("depth_complexity.chosen", "most crossings of a ray in the direction that was chosen", ""),
    ("depth_complexity.min", "most crossings of a ray in the best direction that was tried", ""),
    ("depth_complexity.max", "most crossings of a ray in the worst direction that was tried", ""),
    ("texels_cropped", "texels of all layers of the cropped image", ""),
    ("texels_compressed", "values that the sprite stores", ""),
    ("compression_ratio", "texels of the cropped image for each stored value", ""),
    ("compression_ratio_of_layouts.raw", "compression ratio of the layout `raw`", ""),
    ("compression_ratio_of_layouts.ranges", "compression ratio of the layout `ranges`", ""),
    ("compression_ratio_of_layouts.rows", "compression ratio of the layout `rows`", ""),
    ("compression_ratio_of_layouts.runs", "compression ratio of the layout `runs`", ""),
    ("depth_error.bound", "largest error of a depth that the quantisation allows, as a share of the cube's side", ""),
    ("depth_error.max", "largest error of a depth, as a share of the cube's side", ""),
    ("odd_rays", "rays that cross the surface an odd number of times: the mesh is not closed there", ""),
    ("points", "points that were classified", ""),
    ("inside_points", "points inside the solid", ""),
    (
        "wrong_points",
        "points that the sprite classifies otherwise than the mesh, beyond 0.75 texel from the surface",
        "",
    ),
    (
        "wrong_points_within_0.75_texel",
        "points that the sprite classifies otherwise than the mesh, near the surface",
        "",
    ),
    ("differing_answers_of_layouts", "points that the layouts classify differently", ""),
    ("answers_changed_by_rounding", "points whose class changes with the depths' quantisation", ""),
];

pub struct Points;

/// A point's distance from the surface, in texels, from which on images must answer as the mesh does.
const NEAR: f64 = 0.75;
/// Points worked on at once.
const CHUNK: u32 = 4096;

#[derive(Clone, Copy, Default)]
struct Counts {
    inside: u64,
    /// Answers that differ from the mesh's, near the surface and farther away.
    near: u64,
    wrong: u64,
    /// Answers of a layout that differ from those of the image that it packs.
    layouts: u64,
    /// Answers of that image that differ from those of the one that was peeled.
    changed: u64,
}

impl Counts {
    fn plus(self, o: Self) -> Self {
        Self {
            inside: self.inside + o.inside,
            near: self.near + o.near,
            wrong: self.wrong + o.wrong,
            layouts: self.layouts + o.layouts,
            changed: self.changed + o.changed,
        }
    }
}

impl Node for Points {
    const KIND: &'static str = "evaluate";
    const METHOD: &'static str = "points";
    const VERSION: u32 = 3;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn measures() -> Vec<Measure> {
        MEASURES.iter().map(|(path, about, unit)| Measure::new(path, about, unit)).collect()
    }

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        (32 << 20) + sizes[0].saturating_mul(6) + sizes[1].saturating_mul(16)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        if !(1..=1_000_000_000).contains(&params.points) {
            return Err(("points", format!("expected 1 to 1,000,000,000, found {}", params.points)));
        }
        Ok(())
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let (peeled, sprite) = (&*inputs.image, &*inputs.sprite);
        let geometry = Geometry::new(&inputs.scene);
        let exact = Exact::new(&geometry, &peeled.frame);
        let winding = match peeled.repair {
            Repair::Winding => Some(WindingSolid::new(&geometry, &peeled.frame, ctx.stop)?),
            _ => None,
        };
        let truth = |p: DVec3| winding.as_ref().map_or_else(|| exact.contains(p), |w| w.contains(p));
        // The surface, or the membrane with which the winding number closes a hole.
        let is_near = |p: DVec3, distance: f64| {
            let beside = |axis: DVec3| truth(p + axis * distance) != truth(p - axis * distance);
            exact.is_near(p, distance) || winding.is_some() && DVec3::AXES.into_iter().any(beside)
        };
        let cropped = sprite.packed.unpack();
        let mut layouts: Vec<Packed> = Layout::ALL.into_iter().filter_map(|l| Packed::new(&cropped, l)).collect();
        let floats = layouts.len();
        if let Some(grid) = sprite.packed.grid() {
            layouts.extend(Layout::ALL.into_iter().filter_map(|l| Packed::short(&cropped, l, grid)));
        }
        let sequence = Sequence::<3>::new(params.seed);
        let texel = NEAR / f64::from(peeled.image.size()[0]);
        let one = |i: u32| {
            // A little beyond the cube, where all is outside.
            let p = DVec3::from(sequence.point(i)) * 1.02 - 0.01;
            let point = p.as_vec3();
            let found = cropped.contains(point.to_array());
            let changed = u64::from(found != peeled.image.contains(point.to_array()));
            let mut counts = Counts { inside: u64::from(found), changed, ..Counts::default() };
            counts.layouts = layouts.iter().filter(|l| l.contains(point.to_array()) != found).count() as u64;
            if found != truth(point.as_dvec3()) {
                let near = is_near(point.as_dvec3(), texel);
                *(if near { &mut counts.near } else { &mut counts.wrong }) = 1;
            }
            counts
        };
        let chunks: Vec<Counts> = (0..params.points.div_ceil(CHUNK))
            .into_par_iter()
            .map(|k| {
                ctx.stop.check()?;
                let points = k * CHUNK..(k * CHUNK).saturating_add(CHUNK).min(params.points);
                Ok(points.map(one).fold(Counts::default(), Counts::plus))
            })
            .collect::<Result<_, crate::math::Stopped>>()?;
        let counts = chunks.into_iter().fold(Counts::default(), Counts::plus);
        let complexity = sprite.packed.depth_complexity();
        let of_directions = inputs.direction.map_or([complexity; 2], |d| d.depth_complexity);
        let raw = u64::from(complexity) * cropped.region().texels() as u64;
        let ratio = |values: usize| (values as f64 / raw as f64 * 1e4).round() / 1e4;
        let of_layouts: serde_json::Map<_, _> =
            layouts[..floats].iter().map(|l| (l.layout().name().to_owned(), json!(ratio(l.values())))).collect();
        let lost = peeled
            .image
            .depths()
            .iter()
            .zip(cropped.depths())
            .map(|(a, b)| f64::from((a - b).abs()))
            .fold(0.0, f64::max);
        let certificate = json!({
            "layout": sprite.packed.layout().name(),
            "resolution": peeled.image.size(),
            "depth_complexity": { "chosen": complexity, "min": of_directions[0], "max": of_directions[1] },
            "texels_cropped": raw,
            "texels_compressed": sprite.packed.values(),
            "compression_ratio": ratio(sprite.packed.values()),
            "compression_ratio_of_layouts": of_layouts,
            // As shares of the cube's side.
            "depth_error": { "bound": sprite.packed.grid().map_or(0.0, |g| g.bound()), "max": lost },
            "odd_rays": peeled.odd.len(),
            // What answers are judged by.
            "inside": if winding.is_some() { "the winding number w of the surface: |w| > 1/2" } else { "the parity of crossings" },
            "points": params.points,
            "inside_points": counts.inside,
            "wrong_points": counts.wrong,
            "wrong_points_within_0.75_texel": counts.near,
            "differing_answers_of_layouts": counts.layouts,
            "answers_changed_by_rounding": counts.changed,
        });
        Ok(Out { certificate: json_file(&certificate)? })
    }
}
