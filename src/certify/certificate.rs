//! The certificate as it is written: plain data, deterministic bytes.

use super::figures::Figures;
use crate::math::View;
use serde::Serialize;
use std::collections::BTreeMap;

/// The error that a method promises not to exceed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// What is bounded and by whom.
    pub kind: String,
    pub value: f64,
    pub unit: String,
}

/// Which stand-in was judged.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StandIn {
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Of the file's bytes, hexadecimal.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub blake3: String,
}

/// A camera that anyone can set up again.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Camera {
    /// Metres.
    pub eye: [f64; 3],
    /// Unit vectors.
    pub forward: [f64; 3],
    pub up: [f64; 3],
    /// Degrees, of the picture's height and width.
    pub fov: f64,
    /// Pixels, of the picture's height and width.
    pub resolution: u32,
}

impl Camera {
    pub fn of(view: &View, fov_degrees: f64) -> Self {
        let r = |v: glam::DVec3| v.to_array().map(|x| super::figures::rounded(x, 6));
        Self { eye: r(view.eye), forward: r(view.forward), up: r(view.up), fov: fov_degrees, resolution: view.width }
    }
}

/// The view in which a measure is worst.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorstView {
    pub value: f64,
    /// Number in the sequence of views; the first eight are the cell's corners.
    pub view: u32,
    pub camera: Camera,
    /// Name of the picture, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture: Option<String>,
}

/// How the views were drawn and rendered.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sampling {
    pub seed: u64,
    /// Pixels, of the picture's height and width.
    pub resolution: u32,
    /// Degrees.
    pub fov: f64,
    /// Samples of a pixel in x and in y.
    pub samples_per_axis: u32,
    /// Metres.
    pub cell_centre: [f64; 3],
    pub cell_half: [f64; 3],
}

/// FLIP over the views that are worst by PSNR over the object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Flip {
    pub views: u32,
    pub mean: f64,
    pub max: f64,
}

/// The figures of the mesh before it was simplified: what no simplification can beat.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ceiling {
    pub triangles: u64,
    /// How many of the views it was measured in; the first ones.
    pub views: u32,
    #[serde(flatten)]
    pub figures: Figures,
}

/// Everything that is certified.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Certificate {
    pub stand_in: StandIn,
    pub triangles: u64,
    /// Of the original.
    pub original_triangles: u64,
    /// Of all textures, base levels.
    pub texels: u64,
    /// Of the stand-in's file.
    pub bytes: u64,
    pub views: u32,
    pub shading: String,
    /// The original or the stand-in has materials that blend; they were drawn as masks at 0.5.
    pub blend_as_mask: bool,
    pub bound: Bound,
    #[serde(flatten)]
    pub figures: Figures,
    pub flip: Flip,
    pub ceiling: Option<Ceiling>,
    /// By measure.
    pub worst_view: BTreeMap<&'static str, WorstView>,
    pub sampling: Sampling,
}

impl Certificate {
    /// Indented JSON with a final newline; equal certificates have equal bytes.
    pub fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).expect("plain data serialises");
        text.push('\n');
        text
    }
}
