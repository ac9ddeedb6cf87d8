//! Mip levels, made for each frame by itself.

use super::{Atlas, Impostor};
use crate::{array::Array, image::srgb};
use glam::Vec3;
use rayon::prelude::*;

/// Frames of the last level have this many texels a side: filters read one texel beyond, and coarser frames would show nothing.
const LAST: u32 = 4;

/// The base level and those below it, each half as large, down to frames of 4 texels. Texels are means weighted by coverage, made in linear
/// light; where nothing is covered, of the dilated values. Frames' sides are powers of two, so no texel mixes two frames.
pub fn levels(impostor: &Impostor) -> Vec<Atlas> {
    let mut out = vec![impostor.atlas.clone()];
    let mut tile = impostor.tile;
    while tile > LAST
        && let Some(last) = out.last()
    {
        out.push(halved(last));
        tile /= 2;
    }
    out
}

fn halved(from: &Atlas) -> Atlas {
    let side = from.side / 2;
    let texels: Vec<[[u8; 4]; 4]> = (0..side as usize * side as usize)
        .into_par_iter()
        .map(|i| {
            let (x, y) = (i % side as usize * 2, i / side as usize * 2);
            let width = from.side as usize;
            texel(from, [y * width + x, y * width + x + 1, (y + 1) * width + x, (y + 1) * width + x + 1])
        })
        .collect();
    let image = |k: usize| -> Array<[u8; 4]> { texels.iter().map(|t| t[k]).collect() };
    Atlas {
        side,
        color: image(0),
        normal: image(1),
        orm: from.orm.as_ref().map(|_| image(2)),
        emissive: from.emissive.as_ref().map(|_| image(3)),
    }
}

/// The mean of four texels, in all images.
fn texel(from: &Atlas, at: [usize; 4]) -> [[u8; 4]; 4] {
    let alpha = at.map(|i| f32::from(from.color[i][3]));
    let total: f32 = alpha.iter().sum();
    let weight = if total > 0.0 { alpha.map(|a| a / total) } else { [0.25; 4] };
    let mean = |image: &Array<[u8; 4]>, k: usize, decode: fn(u8) -> f32| -> f32 {
        at.iter().zip(weight).map(|(i, w)| decode(image[*i][k]) * w).sum()
    };
    let linear = |image: &Array<[u8; 4]>| [0, 1, 2, 3].map(|k| byte(mean(image, k, plain)));
    let light = |image: &Array<[u8; 4]>| [0, 1, 2].map(|k| srgb::from_linear(mean(image, k, srgb::to_linear)));
    let opaque = |[r, g, b]: [u8; 3]| [r, g, b, 255];
    let [r, g, b] = light(&from.color);
    let n = Vec3::from([0, 1, 2].map(|k| mean(&from.normal, k, plain) / 127.5 - 1.0)).normalize_or_zero();
    let [nx, ny, nz] = n.to_array().map(|c| byte((c + 1.0) * 127.5));
    [
        [r, g, b, byte(total * 0.25)],
        [nx, ny, nz, byte(mean(&from.normal, 3, plain))],
        from.orm.as_ref().map_or([0; 4], linear),
        from.emissive.as_ref().map_or([0; 4], |image| opaque(light(image))),
    ]
}

fn plain(v: u8) -> f32 {
    f32::from(v)
}

fn byte(v: f32) -> u8 {
    (v + 0.5) as u8
}
