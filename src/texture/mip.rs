//! Mip levels.
//!
//! Each level is the mean over the area of its texels, taken from the level before at full precision. Texels count by their weight, so empty ones never
//! show in the means; afterwards they get the value of the nearest texel that is not empty, for filters that reach beyond an edge.

use crate::{capture::dilate, image::srgb};
use glam::Vec3;
use rayon::prelude::*;

/// One mip level of an image, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Level<T = [u8; 4]> {
    pub width: u32,
    pub height: u32,
    /// `width` × `height`.
    pub texels: Vec<T>,
}

/// How texels become those of the next level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// sRGB-encoded colours are averaged as linear light; alpha is averaged without weights.
    Color,
    /// As [`Rule::Color`], for alpha that is tested against `cutoff`: on each level alpha is scaled so that the share of texels with an alpha of at least
    /// `cutoff` is that of the first level, as near as whole texels allow (Castaño 2010, "Computing Alpha Mipmaps"). 1 to 255.
    Cutout { cutoff: u8 },
    /// Red and green are x and y of a unit vector, from −1 to 1 as 0 to 254, and z is positive: averaged as vectors, then made unit length. Blue of the
    /// result is z in the same way; alpha is averaged.
    Normal,
    /// All four channels are averaged as they are.
    Data,
}

/// Mip levels from `base` on, at most `most` (at least 1); the last has one texel if that is enough. `weight` tells how much each texel counts, 0 for
/// empty ones.
///
/// # Panics
/// Where texels or weights are not `width` × `height`, or there are none.
pub fn chain(base: &Level, weight: &[u8], rule: Rule, most: u32) -> Vec<Level> {
    let texels = base.width as usize * base.height as usize;
    assert!(texels > 0 && base.texels.len() == texels && weight.len() == texels, "one value and one weight a texel");
    let mut means = Means {
        width: base.width,
        height: base.height,
        texels: base.texels.iter().zip(weight).map(|(t, w)| Mean::of(*t, *w, rule)).collect(),
    };
    let share = match rule {
        Rule::Cutout { cutoff } => base.texels.iter().filter(|t| t[3] >= cutoff).count() as f64 / texels as f64,
        _ => 0.0,
    };
    let mut first = base.clone();
    fill(&mut first, &weight.iter().map(|w| *w > 0).collect::<Vec<_>>(), rule);
    let mut out = vec![first];
    while out.len() < most as usize && means.width.max(means.height) > 1 {
        means = means.half();
        out.push(means.level(rule, share));
    }
    out
}

/// Mip levels of whole numbers from `base` on, at most `most` (at least 1): each texel is the `pick` of all texels that it covers. For depths, `u16::min`
/// keeps the surface that is nearest to the camera.
///
/// # Panics
/// Where texels are not `width` × `height`, or there are none.
pub fn chain16(base: &Level<u16>, pick: fn(u16, u16) -> u16, most: u32) -> Vec<Level<u16>> {
    let texels = base.width as usize * base.height as usize;
    assert!(texels > 0 && base.texels.len() == texels, "one value a texel");
    let mut out = vec![base.clone()];
    while let Some(last) = out.last().filter(|l| l.width.max(l.height) > 1) {
        if out.len() >= most as usize {
            break;
        }
        let (width, height) = (half(last.width), half(last.height));
        let texel = |i: u32| {
            let (x, y) = (i % width, i / width);
            let covered = taps(last.height, y).flat_map(|(v, _)| taps(last.width, x).map(move |(u, _)| (u, v)));
            covered.map(|(u, v)| last.texels[(v * last.width + u) as usize]).reduce(pick).unwrap_or_default()
        };
        let texels = (0..width * height).map(texel).collect();
        out.push(Level { width, height, texels });
    }
    out
}

/// Side of the next level.
fn half(side: u32) -> u32 {
    (side / 2).max(1)
}

/// The texels along a side that texel `x` of the next level covers, and the share of each that it covers.
fn taps(side: u32, x: u32) -> impl Iterator<Item = (u32, f32)> {
    let next = half(side);
    let (first, count) = match (side, side % 2) {
        (1, _) => (0, 1),
        (_, 0) => (2 * x, 2),
        _ => (2 * x, 3),
    };
    // Of an odd side, each texel covers 2 + 1/next texels.
    let share = move |i: u32| match (count, i) {
        (3, 0) => (next - x) as f32 / next as f32,
        (3, 2) => (x + 1) as f32 / next as f32,
        _ => 1.0,
    };
    (0..count).map(move |i| (first + i, share(i)))
}

/// Gives texels that are not `known` the value of the nearest that are; alphas of colours stay.
fn fill(level: &mut Level, known: &[bool], rule: Rule) {
    let alpha: Vec<u8> = level.texels.iter().map(|t| t[3]).collect();
    dilate(&mut level.texels, known, level.width as usize);
    if matches!(rule, Rule::Color | Rule::Cutout { .. }) {
        level.texels.iter_mut().zip(alpha).for_each(|(t, a)| t[3] = a);
    }
}

/// The mean over a part of the image.
#[derive(Clone, Copy, Default)]
struct Mean {
    /// By weight: linear light, a vector, or codes.
    value: [f32; 4],
    /// Without weights, for colours.
    alpha: f32,
    weight: f32,
}

impl Mean {
    fn of(texel: [u8; 4], weight: u8, rule: Rule) -> Self {
        let [r, g, b, a] = texel;
        let value = match rule {
            Rule::Color | Rule::Cutout { .. } => [srgb::to_linear(r), srgb::to_linear(g), srgb::to_linear(b), 0.0],
            Rule::Normal => {
                let (x, y) = ((f32::from(r) - 127.0) / 127.0, (f32::from(g) - 127.0) / 127.0);
                [x, y, (1.0 - x * x - y * y).max(0.0).sqrt(), f32::from(a)]
            }
            Rule::Data => texel.map(f32::from),
        };
        Self { value, alpha: f32::from(a), weight: f32::from(weight) }
    }

    fn texel(&self, rule: Rule) -> [u8; 4] {
        let code = |v: f32| v.round().clamp(0.0, 255.0) as u8;
        let [x, y, z, w] = self.value;
        match rule {
            Rule::Color | Rule::Cutout { .. } => {
                [srgb::from_linear(x), srgb::from_linear(y), srgb::from_linear(z), code(self.alpha)]
            }
            Rule::Normal => {
                let n = Vec3::new(x, y, z).normalize_or(Vec3::Z);
                let [x, y, z] = n.to_array().map(|v| code(v * 127.0 + 127.0));
                [x, y, z, code(w)]
            }
            Rule::Data => self.value.map(code),
        }
    }
}

struct Means {
    width: u32,
    height: u32,
    texels: Vec<Mean>,
}

impl Means {
    fn half(&self) -> Self {
        let (width, height) = (half(self.width), half(self.height));
        let texel = |i: u32| {
            let (x, y) = (i % width, i / width);
            let (mut sum, mut area) = (Mean::default(), 0.0);
            for (v, tall) in taps(self.height, y) {
                for (u, wide) in taps(self.width, x) {
                    let (t, share) = (&self.texels[(v * self.width + u) as usize], tall * wide);
                    for (s, v) in sum.value.iter_mut().zip(t.value) {
                        *s += share * t.weight * v;
                    }
                    sum.weight += share * t.weight;
                    sum.alpha += share * t.alpha;
                    area += share;
                }
            }
            if sum.weight > 0.0 {
                sum.value = sum.value.map(|v| v / sum.weight);
            }
            Mean { value: sum.value, alpha: sum.alpha / area, weight: sum.weight / area }
        };
        Self { width, height, texels: (0..width * height).into_par_iter().map(texel).collect() }
    }

    /// The level; `share` of its texels pass the test of [`Rule::Cutout`].
    fn level(&self, rule: Rule, share: f64) -> Level {
        let texels = self.texels.par_iter().map(|t| t.texel(rule)).collect();
        let mut level = Level { width: self.width, height: self.height, texels };
        fill(&mut level, &self.texels.iter().map(|t| t.weight > 0.0).collect::<Vec<_>>(), rule);
        if let Rule::Cutout { cutoff } = rule {
            let mut alphas: Vec<f32> = self.texels.iter().map(|t| t.alpha).collect();
            alphas.sort_by(|a, b| b.total_cmp(a));
            let scale = scale(&alphas, (share * alphas.len() as f64).round() as usize, f32::from(cutoff));
            for (t, mean) in level.texels.iter_mut().zip(&self.texels) {
                // Where one texel just passes, rounding must not fail it.
                t[3] = (mean.alpha * scale + 1e-3).floor().clamp(0.0, 255.0) as u8;
            }
        }
        level
    }
}

/// What alphas, the greatest first, are multiplied by so that `pass` of them reach `cutoff`; 1 where they do already.
fn scale(alphas: &[f32], pass: usize, cutoff: f32) -> f32 {
    match pass.checked_sub(1) {
        Some(last) if alphas[last] >= cutoff && alphas.get(pass).is_none_or(|a| *a < cutoff) => 1.0,
        Some(last) if alphas[last] > 0.0 => cutoff / alphas[last],
        Some(_) => 1.0,
        None => alphas.first().map_or(1.0, |a| if *a >= cutoff { (cutoff - 1.0) / a } else { 1.0 }),
    }
}
