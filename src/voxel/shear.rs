//! Drawing triangles in voxel space under a shear.
//!
//! Seen from another place of the view cell, layers move against each other by up to a pixel a layer (section 4.1): in voxel space
//! that picture is a parallel projection of a shear.

use crate::math::{Stop, Stopped};
use rayon::prelude::*;

/// Shears per axis, pixels a layer, nearly all over the cell: a whole pixel is reached at the image's edge only, from a corner of the cell.
pub const WIDE: [f64; 9] = [-0.95, -0.7125, -0.475, -0.2375, 0.0, 0.2375, 0.475, 0.7125, 0.95];
/// A surface is continuous where it spans at most so many layers over three by three pixels: farther apart, what lies behind is another one.
pub const CONTINUOUS: f32 = 4.0;

/// What `look` finds under every shear of x and y by one of `steps` each, pixels a layer.
pub fn under_all<T: Send>(steps: &[f64], stop: &Stop, look: impl Fn([f64; 2]) -> T + Sync) -> Result<Vec<T>, Stopped> {
    let shears: Vec<[f64; 2]> = steps.iter().flat_map(|y| steps.iter().map(|x| [*x, *y])).collect();
    shears
        .par_iter()
        .map(|shear| {
            stop.check()?;
            Ok(look(*shear))
        })
        .collect()
}

/// Calls `each` with every pixel that a triangle covers, corners in pixels (centres at integers) and layers, and its depth there.
pub fn draw(corners: [[f64; 3]; 3], width: usize, height: usize, mut each: impl FnMut(usize, f32)) {
    let [a, b, c] = corners;
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if area == 0.0 {
        return;
    }
    let slope = |i: usize| {
        let (u, v) = ((b[2] - a[2]) / area, (c[2] - a[2]) / area);
        if i == 0 { u * (c[1] - a[1]) - v * (b[1] - a[1]) } else { v * (b[0] - a[0]) - u * (c[0] - a[0]) }
    };
    let (zx, zy) = (slope(0), slope(1));
    let [low, high] = [f64::min, f64::max].map(|f| f(f(a[1], b[1]), c[1]));
    let rows = low.ceil().max(0.0) as usize..(high.floor() + 1.0).clamp(0.0, height as f64) as usize;
    for y in rows {
        let t = y as f64;
        let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            if (p[1] <= t && t <= q[1]) || (q[1] <= t && t <= p[1]) {
                for x in
                    if p[1] == q[1] { [p[0], q[0]] } else { [p[0] + (q[0] - p[0]) * (t - p[1]) / (q[1] - p[1]); 2] }
                {
                    from = from.min(x);
                    to = to.max(x);
                }
            }
        }
        let columns = from.ceil().max(0.0) as usize..(to.floor() + 1.0).clamp(0.0, width as f64) as usize;
        for x in columns {
            let z = (a[2] + zx * (x as f64 - a[0]) + zy * (t - a[1])) as f32;
            each(y * width + x, z);
        }
    }
}
