//! What of a ray lies inside a surface by its winding number.
//!
//! Where the ray meets no triangle the winding number is smooth. So a range between two crossings is inside or outside as a whole,
//! unless it passes through a hole: there it crosses the *membrane*, the surface |w| = ½ that closes the hole, and the crossing is
//! found by bisection.

use super::{CubeFrame, solid::is_balanced, winding::Winding};
use crate::{
    math::{Stop, Stopped},
    raster::Geometry,
};
use glam::DVec3;
use rayon::prelude::*;

/// Places along each axis at which membranes are looked for before any ray is.
const PLACES: usize = 48;
/// Halvings of a range in which a membrane is crossed.
const HALVINGS: u32 = 16;

/// A surface with the winding number of every place, in the texture space of a frame.
pub struct Solid {
    winding: Winding,
    /// Whether the surface closes all its holes itself. Then w is a whole number everywhere.
    closed: bool,
    /// Whether the places of a lattice lie inside: (s, t, r), r first.
    places: Vec<bool>,
}

impl Solid {
    pub fn new(geometry: &Geometry, frame: &CubeFrame, stop: &Stop) -> Result<Self, Stopped> {
        let m = frame.to_texture();
        let triangles = (0..geometry.triangle_count()).into_par_iter();
        let triangles = triangles.map(|t| geometry.positions(t).map(|p| m.transform_point3(p))).collect();
        let (winding, closed) = (Winding::new(triangles), is_balanced(geometry));
        stop.check()?;
        let count = if closed { 0 } else { PLACES * PLACES };
        let at = |i: usize| (i as f64 + 0.5) / PLACES as f64;
        let columns: Vec<Vec<bool>> = (0..count)
            .into_par_iter()
            .map(|c| {
                stop.check()?;
                let (s, t) = (at(c % PLACES), at(c / PLACES));
                Ok((0..PLACES).map(|r| winding.contains(DVec3::new(s, t, at(r)))).collect())
            })
            .collect::<Result<_, Stopped>>()?;
        Ok(Self { winding, closed, places: columns.concat() })
    }

    /// Whether a point of texture space lies inside: |w| > ½.
    pub fn contains(&self, p: DVec3) -> bool {
        p.min_element() >= 0.0 && p.max_element() <= 1.0 && self.winding.contains(p)
    }

    /// The ranges of the ray through (s, t) that lie inside: depths where it enters and leaves in turn. `crossings` are the depths
    /// at which it meets triangles, ascending; `texel` is the side of a texel.
    pub fn ranges(&self, s: f64, t: f64, crossings: &[f32], texel: f64) -> Vec<f32> {
        let inside = |r: f64| self.winding.contains(DVec3::new(s, t, r));
        let column = self.column(s, t);
        if crossings.is_empty() && !column.contains(&true) {
            return Vec::new();
        }
        let mut ranges = Ranges::default();
        let ends = [0.0].into_iter().chain(crossings.iter().map(|d| f64::from(*d))).chain([1.0]);
        let (mut from, mut first) = (None, true);
        for to in ends {
            let Some(from) = from.replace(to) else { continue };
            let before = std::mem::replace(&mut first, false);
            let length: f64 = to - from;
            if length <= 0.0 || (self.closed && (before || to == 1.0)) {
                continue;
            }
            if self.closed || length < 2.0 * texel {
                if inside(0.5 * (from + to)) {
                    ranges.add(from, to);
                }
                continue;
            }
            // Near both ends, and where the lattice has places.
            let margin = 0.25 * texel;
            // Beyond the cube all is outside.
            let mut last = (from, !before && inside(from + margin));
            let ahead = self.places_between(from + margin, to - margin);
            let ends = to < 1.0 && inside(to - margin);
            let mut step = |at: f64, is: bool, last: &mut (f64, bool)| {
                if is == last.1 {
                    if is {
                        ranges.add(last.0, at);
                    }
                } else {
                    let cut = bisect(last.0, at, last.1, &inside);
                    if last.1 { ranges.add(last.0, cut) } else { ranges.add(cut, at) }
                }
                *last = (at, is);
            };
            for k in ahead {
                // Places that agree with both ends tell nothing new.
                let hint = column.get(k).copied().unwrap_or(last.1);
                if hint != last.1 || hint != ends {
                    let at = (k as f64 + 0.5) / PLACES as f64;
                    step(at, inside(at), &mut last);
                }
            }
            step(to, ends, &mut last);
        }
        ranges.0
    }

    /// The lattice's places nearest to a ray; none where the surface is closed.
    fn column(&self, s: f64, t: f64) -> &[bool] {
        let cell = |x: f64| ((x * PLACES as f64) as usize).min(PLACES - 1);
        let first = (cell(t) * PLACES + cell(s)) * PLACES;
        self.places.get(first..first + PLACES).unwrap_or(&[])
    }

    /// Those with a depth in a range.
    fn places_between(&self, low: f64, high: f64) -> std::ops::Range<usize> {
        let first = (low * PLACES as f64 - 0.5).ceil().max(0.0) as usize;
        let end = ((high * PLACES as f64 - 0.5).ceil().max(0.0) as usize).min(PLACES);
        first.min(end)..end
    }
}

/// Where between `low`, which is inside or not, and `high`, which is the other, that changes.
fn bisect(mut low: f64, mut high: f64, is_low: bool, inside: &impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if inside(middle) == is_low {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Depths in pairs; ranges that touch are one.
#[derive(Default)]
struct Ranges(Vec<f32>);

impl Ranges {
    fn add(&mut self, from: f64, to: f64) {
        /// The greatest below 1, which stands for no depth.
        const MOST: f32 = 1.0 - f32::EPSILON / 2.0;
        let [from, to] = [from, to].map(|d| (d as f32).min(MOST));
        match self.0.last_mut() {
            Some(last) if *last >= from => *last = to,
            _ => self.0.extend([from, to]),
        }
    }
}
