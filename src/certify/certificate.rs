//! The certificate as it is written: plain data, deterministic bytes.

use super::{
    about::{Better, Helps, MODES, Measure, measures},
    figures::Figures,
    modes::ModeFigures,
    per_view::PerView,
    pictures::Panels,
    requirements::{self, Requirement, Verdict},
    summary,
    viewing::Viewing,
};
use crate::{
    runtime,
    view::{Region, View},
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The error that a method promises not to exceed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// What is bounded and by whom.
    pub kind: String,
    pub value: f64,
    pub unit: String,
    /// Whether what was measured keeps to it: no outline moved farther, to within the half pixel that deviations are
    /// measured to. Set by the comparison.
    pub held: bool,
}

/// Which stand-in was judged.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Subject {
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

/// What a number of the certificate means.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct About {
    pub about: &'static str,
    #[serde(skip_serializing_if = "str::is_empty")]
    pub unit: &'static str,
    pub better: Better,
    /// Name of the picture that shows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture: Option<&'static str>,
    /// What makes it better.
    pub helps: Helps,
}

/// The view in which a measure is worst.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorstView {
    pub value: f64,
    /// Number in the sequence of views; the first are the region's extremes, such as a cell's corners.
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
    #[serde(flatten)]
    pub region: SampledRegion,
}

impl Sampling {
    pub fn of(viewing: &Viewing, region: &Region) -> Self {
        Self {
            seed: viewing.sampling.seed,
            resolution: viewing.sampling.resolution,
            fov: super::figures::rounded(viewing.sampling.fov.to_degrees(), 6),
            samples_per_axis: viewing.samples_per_axis,
            region: SampledRegion::of(region),
        }
    }
}

/// Where the eyes were. Metres.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum SampledRegion {
    Box { cell_centre: [f64; 3], cell_half: [f64; 3] },
    Sphere { sphere_centre: [f64; 3], sphere_radius: f64 },
    Path { path: Vec<[f64; 3]> },
}

impl SampledRegion {
    pub fn of(region: &Region) -> Self {
        match region {
            Region::Box(cell) => Self::Box { cell_centre: cell.centre.to_array(), cell_half: cell.half.to_array() },
            Region::Sphere { centre, radius } => {
                Self::Sphere { sphere_centre: centre.to_array(), sphere_radius: *radius }
            }
            Region::Path(points) => Self::Path { path: points.iter().map(|p| p.to_array()).collect() },
        }
    }
}

/// FLIP over the views that are worst by PSNR over the object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Flip {
    pub views: u32,
    pub mean: f64,
    pub max: f64,
}

/// How often the stand-in draws over the pixels that it covers, in the views that are worst by PSNR over the object: what a renderer shades at
/// most, hidden surfaces included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Overdraw {
    pub views: u32,
    /// Surfaces that pass the alpha test, per covered pixel.
    pub opaque: f64,
    /// Surfaces that the alpha test discards, per covered pixel.
    pub transparent: f64,
}

impl Overdraw {
    /// Of all `views` together; `None` where they show nothing.
    pub fn of(views: &[runtime::Overdraw]) -> Option<Self> {
        let sum = |of: fn(&runtime::Overdraw) -> u64| views.iter().map(of).sum::<u64>() as f64;
        let covered = Some(sum(|v| v.covered)).filter(|n| *n > 0.0)?;
        let share = |n: f64| super::figures::rounded(n / covered, 3);
        let (opaque, transparent) = (share(sum(|v| v.opaque)), share(sum(|v| v.transparent)));
        Some(Self { views: views.len() as u32, opaque, transparent })
    }
}

/// The figures of the mesh before it was simplified: what no simplification can beat.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ceiling {
    pub triangles: u64,
    /// In how many views it was measured.
    pub views: u32,
    #[serde(flatten)]
    pub figures: Figures,
}

/// Everything that is certified.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Certificate {
    pub verdict: Verdict,
    /// The verdict in words, with the figures that decide.
    pub sentence: String,
    /// What the stand-in saves and how good it is, in lines for people.
    pub summary: Vec<String>,
    /// The figures that decide on the verdict, with their limits.
    pub requirements: Vec<Requirement>,
    pub stand_in: Subject,
    pub triangles: u64,
    pub original_triangles: u64,
    /// One for each mesh and material of each object.
    pub draw_calls: u64,
    pub original_draw_calls: u64,
    /// Of all textures, base levels.
    pub texels: u64,
    pub original_texels: u64,
    /// Vertices, indices and uncompressed texels.
    pub memory_bytes: u64,
    pub original_memory_bytes: u64,
    /// Of the stand-in's file; 0 where it has none.
    pub bytes: u64,
    pub views: u32,
    pub shading: String,
    /// The original or the stand-in has materials that blend; they were drawn as masks at 0.5.
    pub blend_as_mask: bool,
    pub bound: Bound,
    #[serde(flatten)]
    pub figures: Figures,
    pub flip: Flip,
    /// Nothing where it is not counted: of stand-ins that are no meshes.
    pub overdraw: Option<Overdraw>,
    pub ceiling: Option<Ceiling>,
    /// By the way of drawing, where there are several, such as `static` and `view_dependent`.
    #[serde(flatten)]
    pub modes: BTreeMap<String, ModeFigures>,
    /// By measure.
    pub worst_view: BTreeMap<&'static str, WorstView>,
    pub sampling: Sampling,
    /// By the path of the number; a ceiling's numbers mean the same.
    pub about: BTreeMap<&'static str, About>,
    /// By picture: where original, stand-in and difference lie in it.
    pub panels: BTreeMap<String, Panels>,
    pub per_view: PerView,
}

impl Certificate {
    /// Fills in what follows from the figures: whether the bound held, requirements, verdict, sentence, summary.
    pub(super) fn judge(&mut self) {
        // A deviation is measured to within half a pixel.
        self.bound.held = self.figures.max_deviation_px <= self.bound.value + 0.5;
        self.requirements = requirements::requirements(self);
        self.verdict = requirements::verdict(&self.requirements);
        self.sentence = requirements::sentence(self);
        self.summary = summary::lines(self);
        let absent = |path: &str| {
            let of = |mode: &str| path.strip_prefix(mode).is_some_and(|rest| rest.starts_with('.'));
            MODES.iter().any(|(mode, _)| of(mode) && !self.modes.contains_key(*mode))
        };
        let own = measures().iter().filter(|m| !m.path.starts_with("ceiling.") && !absent(&m.path));
        let about = |m: &'static Measure| About {
            about: &m.about,
            unit: m.unit,
            better: m.better,
            picture: m.picture,
            helps: m.helps,
        };
        self.about = own.map(|m| (m.path.as_str(), about(m))).collect();
    }

    /// Indented JSON with a final newline; equal certificates have equal bytes.
    pub fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).expect("plain data serialises");
        text.push('\n');
        text
    }
}
