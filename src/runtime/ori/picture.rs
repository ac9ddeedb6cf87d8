//! Pictures of what rays see, sampled finely where they need it.

use crate::{
    image::{Picture, srgb},
    math::{Stop, Stopped},
    raster::Rendering,
    view::View,
};
use glam::Vec3;
use rayon::prelude::*;

/// What the rays of a view see.
pub(super) trait Scope: Sync {
    type Seen: Copy + Send + Sync;

    /// At a continuous pixel position.
    fn see(&self, px: f64, py: f64) -> Option<Self::Seen>;

    /// Whether there is an edge between what a pixel sees and what one beside it sees.
    fn apart(&self, own: &Self::Seen, other: &Self::Seen) -> bool;

    /// Linear colour.
    fn color(&self, seen: &Self::Seen, how: &Rendering) -> Vec3;
}

/// What the pixel centres of a view see, row by row, and its picture. Pixels at edges are sampled as finely as `how` asks, others once.
pub(super) fn paint<S: Scope>(
    scope: &S,
    view: &View,
    how: &Rendering,
    stop: &Stop,
) -> Result<(Vec<Option<S::Seen>>, Picture), Stopped> {
    let (width, height) = (view.width as usize, view.height as usize);
    let rows: Vec<Vec<Option<S::Seen>>> = (0..height)
        .into_par_iter()
        .map(|y| {
            stop.check()?;
            Ok((0..width).map(|x| scope.see(x as f64 + 0.5, y as f64 + 0.5)).collect())
        })
        .collect::<Result<_, Stopped>>()?;
    let centres: Vec<Option<S::Seen>> = rows.into_iter().flatten().collect();
    let background = Vec3::from(how.background);
    let n = how.samples_per_axis.max(1) as usize;
    let texels: Vec<Vec<[u8; 4]>> = (0..height)
        .into_par_iter()
        .map(|y| {
            stop.check()?;
            let pixel = |x: usize| {
                let own = &centres[y * width + x];
                let color = if n > 1 && is_edge(scope, &centres, [width, height], [x, y]) {
                    let at = |i: usize, k: usize| i as f64 + (k as f64 + 0.5) / n as f64;
                    let sample = |k: usize| {
                        let seen = scope.see(at(x, k % n), at(y, k / n));
                        seen.map_or(background, |s| scope.color(&s, how))
                    };
                    (0..n * n).map(sample).sum::<Vec3>() / (n * n) as f32
                } else {
                    own.as_ref().map_or(background, |s| scope.color(s, how))
                };
                let [r, g, b] = color.to_array().map(srgb::from_linear);
                [r, g, b, 255]
            };
            Ok((0..width).map(pixel).collect())
        })
        .collect::<Result<_, Stopped>>()?;
    let texels = texels.into_iter().flatten().collect();
    Ok((centres, Picture { width: view.width, height: view.height, texels }))
}

/// A pixel whose neighbours show something else.
fn is_edge<S: Scope>(scope: &S, centres: &[Option<S::Seen>], [width, height]: [usize; 2], [x, y]: [usize; 2]) -> bool {
    let own = &centres[y * width + x];
    let (x0, x1, y0, y1) = (x.saturating_sub(1), (x + 1).min(width - 1), y.saturating_sub(1), (y + 1).min(height - 1));
    (y0..=y1).any(|y| {
        (x0..=x1).any(|x| match (own, &centres[y * width + x]) {
            (Some(a), Some(b)) => scope.apart(a, b),
            (None, None) => false,
            _ => true,
        })
    })
}
