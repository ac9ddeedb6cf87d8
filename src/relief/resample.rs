//! Relief maps from captures.

use super::{DepthBits, MapFault, REACHES, ReliefMap};
use crate::{
    array::Array,
    capture::{Capture, Layer, dilate},
    image::srgb,
    view::{Projection, View},
};
use glam::DVec3;
use rayon::prelude::*;

/// How captures become relief maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resampling {
    /// Pixels of the capture along a side of a texel, at least 1; they divide the capture's width.
    pub samples: u32,
    pub bits: DepthBits,
}

/// Depths of a texel's pixels that differ by more, in texel sides, are different surfaces.
const WALL: f64 = 4.0;

/// Makes a relief map of the first layer of an orthographic capture.
///
/// A texel has a surface where at least half of its pixels have one. So that thin parts are not lost, it also has one where fewer have, but no texel
/// beside it has more. Depth and normal are means over the pixels of the surface that most of a texel's pixels show; colours are means in linear light.
/// How far surfaces reach towards the centres of texels without surface follows from the pixels of both.
///
/// # Errors
/// Where the capture is not orthographic, not square, or its width is no multiple of `samples`.
pub fn resample(capture: &Capture, how: Resampling) -> Result<ReliefMap, MapFault> {
    let view = &capture.view;
    let k = how.samples.max(1);
    if !matches!(view.projection, Projection::Orthographic { .. }) {
        return Err(MapFault("expected an orthographic capture".into()));
    }
    if view.width != view.height || !view.width.is_multiple_of(k) || view.width / k < 2 {
        let what = format!(
            "a capture of {}×{} pixels; expected a square of {k} or more texels a side, {k} pixels each",
            view.width, view.height
        );
        return Err(MapFault(what));
    }
    let side = view.width / k;
    let layer = &capture.layers[0];
    let blocks = Blocks { layer, width: view.width as usize, k: k as usize, side: side as usize };
    let texel = match view.projection {
        Projection::Orthographic { left, right, .. } | Projection::Perspective { left, right, .. } => {
            (right - left) / f64::from(side)
        }
    };
    let share: Vec<f32> = (0..blocks.side * blocks.side).map(|i| blocks.share(i)).collect();
    let surface: Vec<bool> = (0..share.len()).map(|i| has_surface(&share, blocks.side, i)).collect();
    let texels: Vec<Option<Averages>> =
        (0..share.len()).into_par_iter().map(|i| surface[i].then(|| blocks.average(i, view, texel * WALL))).collect();
    let (mut near, mut far) = (f64::INFINITY, f64::NEG_INFINITY);
    for t in texels.iter().flatten() {
        (near, far) = (near.min(t.depth), far.max(t.depth));
    }
    if near > far {
        (near, far) = (view.near, view.far);
    }
    // Flat parts get a range of one texel, so that depths have a scale.
    if far - near < texel {
        far = near + texel;
    }
    let levels = how.bits.levels();
    let depth: Array<u16> = texels
        .iter()
        .enumerate()
        .map(|(i, t)| match t {
            Some(t) => ((t.depth - near) / (far - near) * f64::from(levels - 1)).round() as u16,
            None => {
                let reach = reach(&share, &surface, blocks.side, i);
                let from_last = (reach * REACHES as f32 - 0.5).round().clamp(0.0, (REACHES - 1) as f32) as u32;
                (how.bits.codes() - 1 - from_last) as u16
            }
        })
        .collect();
    let filled = |value: &dyn Fn(&Averages) -> [u8; 4]| {
        let mut out: Vec<[u8; 4]> = texels.iter().map(|t| t.as_ref().map_or([0; 4], value)).collect();
        dilate(&mut out, &surface, blocks.side);
        out
    };
    let mut color = filled(&|t| t.color);
    for (c, s) in color.iter_mut().zip(&surface) {
        c[3] = if *s { 255 } else { 0 };
    }
    let normal = filled(&|t| [t.normal[0], t.normal[1], 0, 0]);
    let materials = |value: &dyn Fn(&Averages) -> [u8; 4]| match layer.orm.is_empty() {
        true => Array::default(),
        false => filled(value).into(),
    };
    let map = ReliefMap {
        view: View { width: side, height: side, near, far, ..*view },
        bits: how.bits,
        depth,
        color: color.into(),
        normal: normal.iter().map(|n| [n[0], n[1]]).collect(),
        orm: materials(&|t| t.orm),
        emissive: materials(&|t| t.emissive),
    };
    map.check()?;
    Ok(map)
}

/// Whether a texel has a surface, see [`resample`].
fn has_surface(share: &[f32], side: usize, i: usize) -> bool {
    let own = share[i];
    if own >= 0.5 {
        return true;
    }
    own > 0.0 && neighbours(side, i).all(|j| share[j] < 0.5 && (share[j], j) <= (own, i) || share[j] == 0.0)
}

/// The up to eight texels around one.
fn neighbours(side: usize, i: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (i % side, i / side);
    let (x0, x1, y0, y1) = (x.saturating_sub(1), (x + 1).min(side - 1), y.saturating_sub(1), (y + 1).min(side - 1));
    (y0..=y1).flat_map(move |y| (x0..=x1).map(move |x| y * side + x)).filter(move |j| *j != i)
}

/// How far surfaces beside texel `i`, which has none, reach towards its centre: 0 to 1, the mean over its four neighbours that have a surface.
fn reach(share: &[f32], surface: &[bool], side: usize, i: usize) -> f32 {
    let (x, y) = ((i % side) as isize, (i / side) as isize);
    let at = |dx: isize, dy: isize| {
        let (x, y) = (x + dx, y + dy);
        let inside = x >= 0 && y >= 0 && x < side as isize && y < side as isize;
        inside.then(|| y as usize * side + x as usize)
    };
    let (mut sum, mut count) = (0.0_f32, 0.0_f32);
    for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
        let Some(j) = at(dx, dy).filter(|j| surface[*j]) else { continue };
        // Of the neighbour's pixels half lie on the far side of its centre, where the surface goes on there; else they lie around the centre.
        let goes_on = at(2 * dx, 2 * dy).is_some_and(|j| surface[j]);
        let near = if goes_on { share[j] - 0.5 } else { share[j] * 0.5 };
        sum += (near + share[i]).clamp(0.0, 1.0);
        count += 1.0;
    }
    // A texel that meets a surface at a corner only.
    if count == 0.0 { 0.25 } else { sum / count }
}

/// The pixels of a capture by texels.
struct Blocks<'a> {
    layer: &'a Layer,
    width: usize,
    k: usize,
    side: usize,
}

/// What a texel shows.
struct Averages {
    depth: f64,
    color: [u8; 4],
    normal: [u8; 2],
    /// As [`ReliefMap`] has them; 0 where they were not captured.
    orm: [u8; 4],
    emissive: [u8; 4],
}

impl Blocks<'_> {
    fn pixels(&self, texel: usize) -> impl Iterator<Item = usize> {
        let (x, y) = (texel % self.side * self.k, texel / self.side * self.k);
        let (k, width) = (self.k, self.width);
        (0..k).flat_map(move |dy| (0..k).map(move |dx| (y + dy) * width + x + dx))
    }

    /// Of the texel's pixels, the share with a surface.
    fn share(&self, texel: usize) -> f32 {
        let covered = self.pixels(texel).filter(|p| self.layer.depth[*p].is_finite()).count();
        covered as f32 / (self.k * self.k) as f32
    }

    fn average(&self, texel: usize, view: &View, wall: f64) -> Averages {
        let mut seen: Vec<(f32, usize)> =
            self.pixels(texel).map(|p| (self.layer.depth[p], p)).filter(|(d, _)| d.is_finite()).collect();
        seen.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let median = f64::from(seen[(seen.len() - 1) / 2].0);
        let (mut depth, mut normal, mut color, mut count) = (0.0, DVec3::ZERO, [0.0_f32; 3], 0.0);
        for (d, p) in seen.iter().filter(|(d, _)| (f64::from(*d) - median).abs() <= wall) {
            depth += f64::from(*d);
            let [x, y, z, _] = self.layer.normal[*p].map(f64::from);
            normal += DVec3::new(x, y, z) / 32767.0;
            for (sum, c) in color.iter_mut().zip(self.layer.color[*p]) {
                *sum += srgb::to_linear(c);
            }
            count += 1.0;
        }
        let kept = seen.iter().filter(|(d, _)| (f64::from(*d) - median).abs() <= wall).map(|(_, p)| *p);
        let (orm, emissive) = if self.layer.orm.is_empty() { Default::default() } else { self.materials(kept, count) };
        let n = normal.normalize_or(-view.forward);
        let byte = |v: f64| (v * 127.0 + 127.0).round().clamp(0.0, 254.0) as u8;
        let [r, g, b] = color.map(|c| srgb::from_linear(c / count as f32));
        Averages {
            depth: depth / count,
            color: [r, g, b, 255],
            normal: [byte(n.dot(view.right)), byte(n.dot(view.up))],
            orm,
            emissive,
        }
    }

    /// Means of the material images over `count` pixels.
    fn materials(&self, pixels: impl Iterator<Item = usize>, count: f64) -> ([u8; 4], [u8; 4]) {
        let (mut orm, mut light) = ([0.0_f64; 3], [0.0_f32; 3]);
        for p in pixels {
            orm.iter_mut().zip(self.layer.orm[p]).for_each(|(sum, v)| *sum += f64::from(v));
            light.iter_mut().zip(self.layer.emissive[p]).for_each(|(sum, v)| *sum += srgb::to_linear(v));
        }
        let [o, r, m] = orm.map(|v| (v / count).round() as u8);
        let [red, green, blue] = light.map(|v| srgb::from_linear(v / count as f32));
        ([o, r, m, 255], [red, green, blue, 255])
    }
}
