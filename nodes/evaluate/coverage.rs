//! How well captures sample an object.

use crate::{
    capture::Capture,
    engine::{
        node::{Ctx, List, Measure, Node, NodeError},
        plan::File,
    },
    image::encode_png,
    nodes::{backend, json_file},
    ports,
    raster::Geometry,
    relief::coverage_picture::{count_samples, coverage_colors, coverage_picture},
    scene::Scene,
    view::directions::look_along,
};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::sync::Arc;

/// Counts for each triangle the captures that see it, and draws the object in the colours of these numbers: black for none, red for one or two, by way of
/// yellow to green for ten or more. Source: Andújar et al., Omni-directional Relief Impostors, 2007, figure 2.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Pixels along a side of a picture.
    #[schemars(range(min = 16, max = 8192), extend("x-unit" = "px"))]
    pub size: u32,
}

impl Default for Params {
    fn default() -> Self {
        Self { size: 512 }
    }
}

ports! {
    pub struct In {
        /// What was captured.
        original: Arc<Scene>,
        /// What the cameras saw.
        captures: List<Capture>,
    }
}

ports! {
    pub struct Out {
        /// Triangles by the number of captures that see them, JSON.
        certificate: Arc<File>,
        /// The object from both sides in the colours of these numbers, PNG.
        pictures: List<File>,
    }
}

pub struct Coverage;

/// The certificate's numbers: path, meaning.
const MEASURES: [(&str, &str); 4] = [
    ("triangles", "triangles of the object"),
    ("unsampled", "triangles that no capture sees"),
    ("sampled_once_or_twice", "triangles that one or two captures see"),
    ("sampled_ten_times", "triangles that ten captures or more see"),
];

impl Node for Coverage {
    const KIND: &'static str = "evaluate";
    const METHOD: &'static str = "coverage";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        let pixels = u64::from(params.size) * u64::from(params.size);
        (16 << 20) + pixels * 32 + sizes.iter().fold(0_u64, |s, n| s.saturating_add(*n)).saturating_mul(2)
    }

    fn measures() -> Vec<Measure> {
        MEASURES.iter().map(|(path, about)| Measure::new(path, about, "")).collect()
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let geometry = Geometry::new(&inputs.original);
        let triangles = inputs.original.triangle_count() as u32;
        let seen = inputs.captures.0.iter().map(|(_, capture)| &capture.layers[0].triangle[..]);
        let counts = count_samples(seen, triangles);
        let of = |range: std::ops::RangeInclusive<u32>| counts.iter().filter(|n| range.contains(n)).count();
        let certificate = json!({
            "triangles": triangles,
            "unsampled": of(0..=0),
            "sampled_once_or_twice": of(1..=2),
            "sampled_ten_times": of(10..=u32::MAX),
        });
        let colors = coverage_colors(&counts);
        let points = inputs.original.points();
        let mut pictures = Vec::new();
        for (name, direction) in [("coverage-back", DVec3::NEG_ONE), ("coverage-front", DVec3::ONE)] {
            let direction = (direction * DVec3::new(1.0, 0.4, 2.0)).normalize();
            let Some(view) = look_along(points.iter().copied(), direction, params.size, 4.0) else {
                return Err(NodeError::Failed("the scene is empty: there is nothing to sample".into()));
            };
            let picture = coverage_picture(backend(ctx), &geometry, &view, &colors, ctx.stop)?;
            let bytes = encode_png(&picture).map_err(|e| NodeError::from_error(&e))?;
            pictures.push((name.to_owned(), Arc::new(File { media_type: "image/png".into(), bytes })));
        }
        Ok(Out { certificate: json_file(&certificate)?, pictures: List(pictures) })
    }
}
