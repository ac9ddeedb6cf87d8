//! How a hierarchy is made.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the error of a grid point says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorMeasure {
    /// Its distance from the edge that it bisects, made monotonic up the hierarchy (section 4.2). Local: the mesh may deviate by a small
    /// multiple of the tolerance.
    #[default]
    Edge,
    /// The largest distance of a covered grid point from the two triangles that it splits. Wherever no triangle is cut, the mesh deviates
    /// by the tolerance at most.
    Exact,
}

/// How distances are measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Distance {
    /// Equation (2) for points between neighbours of a row or column, (1) for the others: exact for orthographic views, up to 9.4 % too
    /// small within 25° of the view's axis. Views that reach further use `full`. With `exact` errors it is `full`.
    #[default]
    Planar,
    /// Distance in space, equation (1).
    Full,
    /// Difference of planar depth at the same pixel: the vertical error of a height field.
    Depth,
}

/// Which triangles are rubber sheets between surfaces (section 5.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Segmentation {
    /// None; only triangles that touch background are cut.
    None,
    /// A horizontal or vertical edge whose end lies off the curve that the normals predict (equations 5 and 6, `kappa`).
    Connectedness,
    /// At least two corners at which the slope of depth changes abruptly (equation 9, `sigma`).
    Disparity,
    /// Triangles seen at less than `omega` (equation 10).
    #[default]
    Orthogonality,
}

/// How the depth range is measured that a triangle must span to be cut (equation 11).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DepthRange {
    /// `lambda` is in metres; the paper's experiments use 5 % of the object's largest extent.
    #[default]
    Absolute,
    /// `lambda` is a fraction of the triangle's depth.
    Relative,
}

/// What a cut triangle does to the coarser triangles that stand for it (section 5.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Propagation {
    /// They are cut too.
    Paper,
    /// They are split, so that only triangles of the full resolution are cut: one or two triangles in a hundred more, and fewer holes.
    #[default]
    Refine,
}

/// How a hierarchy is made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Options {
    pub error: ErrorMeasure,
    pub distance: Distance,
    pub segmentation: Segmentation,
    /// κ of equation (6), ≥ 0: depth error over edge length. Not stated in the paper.
    pub kappa: f32,
    /// σ of equation (9), ≥ 0. Not stated in the paper. In orthographic views planes are linear in depth instead of disparity, so
    /// the second difference of depth over the height of the window takes the place of the left side.
    pub sigma: f32,
    /// ω of equation (10), degrees, 0 to 90.
    pub omega: f32,
    pub depth_range: DepthRange,
    /// λ of equation (11), ≥ 0.
    pub lambda: f32,
    pub propagation: Propagation,
}

impl Options {
    /// The paper's: ω = 5°, λ = 5 % of the object's largest extent, metres, and its propagation.
    pub fn for_extent(extent: f32) -> Self {
        Self { lambda: 0.05 * extent, propagation: Propagation::Paper, ..Self::default() }
    }

    pub(super) fn check(&self) -> Result<(), OptionsError> {
        let ranges = [
            ("kappa", self.kappa, f32::MAX),
            ("sigma", self.sigma, f32::MAX),
            ("omega", self.omega, 90.0),
            ("lambda", self.lambda, f32::MAX),
        ];
        for (name, value, most) in ranges {
            if !(0.0..=most).contains(&value) {
                return Err(OptionsError { name, value, most });
            }
        }
        Ok(())
    }
}

impl Default for Options {
    fn default() -> Self {
        Self {
            error: ErrorMeasure::default(),
            distance: Distance::default(),
            segmentation: Segmentation::default(),
            kappa: 0.5,
            sigma: 0.02,
            omega: 5.0,
            depth_range: DepthRange::default(),
            lambda: 0.0,
            propagation: Propagation::default(),
        }
    }
}

/// A threshold out of its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} is {value}, expected 0 to {most}")]
pub struct OptionsError {
    pub name: &'static str,
    pub value: f32,
    pub most: f32,
}
