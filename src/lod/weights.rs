//! Weights of vertices and the views that see them (Chen et al. 2003, sections 3.1.3.2 and 3.1.4).

use super::{
    faces::Surface,
    pixels::{Steps, classify},
};
use crate::{array::Array, view::View};
use glam::DVec3;

/// What one of a subject's cameras sees.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// About the eye as it is captured, about the cell's centre in [`Windows`].
    pub view: View,
    /// Planar depth of the nearest surface of each pixel, metres; infinite where there is none.
    pub depth: Array<f32>,
    /// Base colour, sRGB-encoded: the mean of the samples that show a surface. Alpha is their share of the pixel.
    pub color: Array<[u8; 4]>,
}

/// The windows of a subject, that of the cell's centre first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Windows(pub Vec<Window>);

impl Window {
    /// Metres that a pixel is wide at depth 1.
    pub fn pixel(&self) -> f64 {
        match self.view.projection {
            crate::view::Projection::Perspective { left, right, .. } => (right - left) / f64::from(self.view.width),
            crate::view::Projection::Orthographic { .. } => 0.0,
        }
    }

    fn index(&self, px: f64, py: f64) -> Option<(i64, i64)> {
        let (x, y) = (px.floor(), py.floor());
        let inside = x >= 0.0 && y >= 0.0 && x < f64::from(self.view.width) && y < f64::from(self.view.height);
        inside.then_some((x as i64, y as i64))
    }

    /// The pixel that shows `p`, or one beside it that does: the nearest of the nine whose depth agrees within `slack` metres. `None` where
    /// something nearer hides it.
    pub fn sees(&self, p: DVec3, slack: f64) -> Option<usize> {
        let (px, py, z) = self.view.project(p);
        if z <= 0.0 {
            return None;
        }
        let (x, y) = self.index(px, py)?;
        let shows = |x: i64, y: i64| {
            let inside = (0..i64::from(self.view.width)).contains(&x) && (0..i64::from(self.view.height)).contains(&y);
            let i = (y * i64::from(self.view.width) + x) as usize;
            (inside && self.depth[i].is_finite() && z <= f64::from(self.depth[i]) + slack).then_some(i)
        };
        // At an outline the pixel under the vertex may show what is behind, or nothing: its neighbours tell.
        if let Some(i) = shows(x, y) {
            return Some(i);
        }
        let own = self.depth[(y * i64::from(self.view.width) + x) as usize];
        if own.is_finite() {
            // What is there is nearer: the vertex is hidden.
            return None;
        }
        let beside = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];
        beside.into_iter().find_map(|(dx, dy)| shows(x + dx, y + dy))
    }
}

/// Weight of a vertex whose faces all show their back.
const BACK: f64 = 0.5;
/// Weight of a vertex that is hidden.
const HIDDEN: f64 = 0.05;

/// What is known of a surface's vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Weights {
    /// The largest over the views.
    pub weight: Vec<f64>,
    /// One bit for each view that sees the vertex.
    pub views: Vec<u32>,
}

/// Weights of the vertices of `surface`, whose `front` bits belong to the eyes of `windows`.
pub fn weights(surface: &Surface, windows: &Windows, steps: &Steps) -> Weights {
    let n = surface.positions.len();
    let mut out = Weights { weight: vec![0.0; n], views: vec![0; n] };
    for (k, window) in windows.0.iter().enumerate() {
        let pixel = window.pixel();
        let classes = classify(&window.depth, window.view.width as usize, 1.0 / pixel.max(f64::MIN_POSITIVE), steps);
        for (v, p) in surface.positions.iter().enumerate() {
            let weight = if surface.front[v] >> k & 1 == 0 {
                BACK
            } else {
                let z = (*p - window.view.eye).dot(window.view.forward);
                // A pixel's depth is that of its centre: steep surfaces differ by some footprints beside it.
                match window.sees(*p, surface.error + SLACK * pixel * z) {
                    Some(i) => {
                        out.views[v] |= 1 << k;
                        classes[i].weight()
                    }
                    None => HIDDEN,
                }
            };
            out.weight[v] = out.weight[v].max(weight);
        }
    }
    out
}

/// Footprints of a pixel by which a visible vertex may lie behind its pixel's depth.
pub const SLACK: f64 = 4.0;
