//! The largest deviation on the screen: how far a wrong pixel is from the nearest pixel where it would be right.
//!
//! Where the stand-in is missing or deeper than the bound allows at pixel p, the original's surface at p would be right at
//! any pixel q where the stand-in is at most as deep; where the stand-in is extra or in front, its surface would be right
//! where the original is at most as deep. Depths are compared as in [`super::classes`]. The distance between the centres
//! of p and q, less half a pixel, estimates the distance to the stand-in's outline between q and its neighbour to
//! within half a pixel.

use super::{classes::Rule, edges::Surfaces};

/// Larger deviations are reported as this many pixels less one half.
pub const DEVIATION_CAP_PX: i32 = 32;

/// The largest deviation of a view in pixels; 0 where no pixel deviates.
pub fn max_deviation(original: &Surfaces, stand_in: &Surfaces, rule: &Rule) -> f64 {
    let squared = one_way(original, stand_in, rule).max(one_way(stand_in, original, rule));
    if squared == 0 { 0.0 } else { f64::from(squared).sqrt() - 0.5 }
}

/// The largest squared distance from a pixel where `b` lies behind `a` to the nearest where it does not.
fn one_way(a: &Surfaces, b: &Surfaces, rule: &Rule) -> i32 {
    let offsets = offsets();
    let (w, h) = (a.width as i32, (a.depth.len() / a.width) as i32);
    // Offsets up to `most` are those nearer than the largest deviation so far.
    let mut most = 0;
    for p in 0..a.depth.len() {
        let z = a.depth[p];
        if !rule.parallax.deeper(p, z, b.depth[p], rule.bound) {
            continue;
        }
        let (x0, y0) = ((p % a.width) as i32, (p / a.width) as i32);
        let right = |&(dx, dy): &(i32, i32)| {
            let (x, y) = (x0 + dx, y0 + dy);
            x >= 0 && y >= 0 && x < w && y < h && {
                let q = (y * w + x) as usize;
                !rule.parallax.deeper(q, z, b.depth[q], rule.bound)
            }
        };
        if offsets[..most].iter().any(right) {
            continue;
        }
        most += offsets[most..].iter().position(right).unwrap_or(offsets.len() - most - 1);
        if most == offsets.len() - 1 {
            break;
        }
    }
    let (dx, dy) = offsets[most];
    dx * dx + dy * dy
}

/// The offsets within the cap, by distance; the first is (0, 0), the last one at the cap.
fn offsets() -> Vec<(i32, i32)> {
    let r = DEVIATION_CAP_PX;
    let mut all: Vec<(i32, i32)> = (-r..=r)
        .flat_map(|dy| (-r..=r).map(move |dx| (dx, dy)))
        .filter(|(dx, dy)| dx * dx + dy * dy <= r * r)
        .collect();
    all.sort_by_key(|(dx, dy)| (dx * dx + dy * dy, *dy, *dx));
    all
}
