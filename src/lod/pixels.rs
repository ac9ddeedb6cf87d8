//! Classes of a depth image's pixels (Chen et al. 2003, section 3.1.3.1): where an outline, a step or an edge runs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    Background,
    /// Beside the background.
    ExteriorSilhouette,
    /// The nearer side of a step (C0).
    InteriorSilhouette,
    /// A crease (C1).
    SharpEdge,
    Interior,
}

impl Class {
    /// How much a vertex there matters, as the authors chose by experience. 0 for the background.
    pub fn weight(self) -> f64 {
        match self {
            Self::Background => 0.0,
            Self::ExteriorSilhouette => 0.5,
            Self::InteriorSilhouette => 0.4,
            Self::SharpEdge => 0.25,
            Self::Interior => 0.125,
        }
    }
}

/// In which unit T_C0 and T_C1 are given; the paper does not say which its own is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Unit {
    /// The footprint of a pixel at its depth, z/f metres: the same for large and small scenes.
    #[default]
    Footprint,
    /// A depth buffer's value, from 0 at one hundredth of the object's distance to 1 at infinity: 1 − near/z. The paper's 3.4e-4 and 1.28e-4 are read as this.
    DepthBuffer,
}

/// Where steps and creases begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    pub t_c0: f64,
    pub t_c1: f64,
    pub unit: Unit,
}

/// The class of each pixel of a depth image (metres, row by row, infinite where there is nothing), with `focal` pixels per unit of the tangent.
///
/// # Panics
/// Where the number of depths is no multiple of `width`.
pub fn classify(depth: &[f32], width: usize, focal: f64, steps: &Steps) -> Vec<Class> {
    let height = depth.len() / width.max(1);
    assert_eq!(width * height, depth.len(), "whole rows");
    let nearest = depth.iter().copied().fold(f32::INFINITY, f32::min);
    // Depth in the unit of the steps, and how many of the steps' units a step at that depth is.
    let near = f64::from(nearest) * 0.01;
    let value = |z: f32| match steps.unit {
        Unit::Footprint => f64::from(z),
        Unit::DepthBuffer => 1.0 - near / f64::from(z),
    };
    let unit = |z: f32| match steps.unit {
        Unit::Footprint => f64::from(z) / focal,
        Unit::DepthBuffer => 1.0,
    };
    let at = |x: i64, y: i64| -> f32 {
        let inside = (0..width as i64).contains(&x) && (0..height as i64).contains(&y);
        if inside { depth[y as usize * width + x as usize] } else { f32::INFINITY }
    };
    let class = |i: usize| {
        let (x, y, z) = ((i % width) as i64, (i / width) as i64, depth[i]);
        if !z.is_finite() {
            return Class::Background;
        }
        let around = [[at(x - 1, y), at(x + 1, y)], [at(x, y - 1), at(x, y + 1)]];
        if around.as_flattened().iter().any(|n| !n.is_finite()) {
            return Class::ExteriorSilhouette;
        }
        let (here, scale) = (value(z), unit(z));
        if around.as_flattened().iter().any(|n| value(*n) - here > steps.t_c0 * scale) {
            return Class::InteriorSilhouette;
        }
        let bends = |[a, b]: &[f32; 2]| ((value(*a) - here) - (here - value(*b))).abs() > steps.t_c1 * scale;
        if around.iter().any(bends) { Class::SharpEdge } else { Class::Interior }
    };
    (0..depth.len()).map(class).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use Class::{Background as B, ExteriorSilhouette as E, Interior as I, InteriorSilhouette as S, SharpEdge as C};

    const STEPS: Steps = Steps { t_c0: 8.0, t_c1: 3.0, unit: Unit::Footprint };

    /// One row of depths, three rows high so that nothing is beside the background above and below.
    fn row(depths: &[f32]) -> Vec<Class> {
        let image: Vec<f32> = depths.iter().copied().cycle().take(depths.len() * 3).collect();
        classify(&image, depths.len(), 100.0, &STEPS)[depths.len()..2 * depths.len()].to_vec()
    }

    #[test]
    fn the_nearer_side_of_a_step_is_marked() {
        let n = f32::INFINITY;
        // A pixel's footprint is 0.1 at depth 10.
        let classes = row(&[n, 10.0, 10.0, 10.0, 12.0, 12.0, 12.0, 12.0, n]);
        // The deeper side bends too: from flat to a step towards it.
        assert_eq!(classes, [B, E, I, S, C, I, I, E, B]);
    }

    #[test]
    fn slopes_are_no_edges_and_creases_are() {
        let slope: Vec<f32> = (0..9).map(|i| 10.0 + 0.5 * i as f32).collect();
        assert_eq!(row(&slope)[1..8], [I; 7]);
        let roof: Vec<f32> = (0..9).map(|i| 12.0 - 0.4 * (4 - (i - 4_i32).abs()) as f32).collect();
        assert_eq!(row(&roof)[1..8], [I, I, I, C, I, I, I]);
    }

    #[test]
    fn the_papers_numbers_find_a_bunnys_ear() {
        let steps = Steps { t_c0: 3.4e-4, t_c1: 1.28e-4, unit: Unit::DepthBuffer };
        // 40 units deep at 400: a step of 20 is one, a slope of 1 a pixel is none.
        let mut depths: Vec<f32> = (0..12).map(|i| 400.0 + i as f32).collect();
        depths.iter_mut().skip(6).for_each(|z| *z += 20.0);
        let image: Vec<f32> = depths.iter().copied().cycle().take(36).collect();
        let classes = &classify(&image, 12, 887.0, &steps)[12..24];
        assert_eq!(classes[5], S);
        assert!(classes[1..5].iter().chain(&classes[7..11]).all(|c| *c == I), "{classes:?}");
    }
}
