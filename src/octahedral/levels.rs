//! Mip levels, made for each frame by itself.

use super::{Atlas, Impostor};
use crate::{
    array::Array,
    image::srgb,
    texture::mip::{Level, Rule, chain},
};
use glam::Vec3;
use rayon::prelude::*;

/// Frames of the last level have this many texels a side: filters read one texel beyond, and coarser frames would show nothing.
const LAST: u32 = 4;

/// Alpha from which a texel counts as covered.
const COVERED: u8 = 128;

/// The base level and those below it, each half as large, down to frames of 4 texels. Texels are means weighted by coverage, made in linear
/// light; where nothing is covered, of the dilated values. Alpha is scaled so that on every level of a frame the share of its texels with an alpha
/// of at least 128 is that of the base ([`Rule::Cutout`]). Frames' sides are powers of two, so no texel mixes two frames.
pub fn levels(impostor: &Impostor) -> Vec<Atlas> {
    let base = &impostor.atlas;
    let (tile, grid) = (impostor.tile, impostor.grid.side);
    let count = (tile / LAST).max(1).ilog2() + 1;
    let frames: Vec<Vec<Level>> = (0..grid * grid)
        .into_par_iter()
        .map(|i| {
            let first = ((i / grid * tile * base.side) + i % grid * tile) as usize;
            let row = |y: u32| &base.color[first + (y * base.side) as usize..][..tile as usize];
            let texels: Vec<[u8; 4]> = (0..tile).flat_map(row).copied().collect();
            let weight: Vec<u8> = texels.iter().map(|t| t[3]).collect();
            chain(&Level { width: tile, height: tile, texels }, &weight, Rule::Cutout { cutoff: COVERED }, count)
        })
        .collect();
    let mut cover: Vec<f32> = base.color.iter().map(|t| f32::from(t[3])).collect();
    let mut out = vec![base.clone()];
    for l in 1..count {
        let Some(last) = out.last() else { break };
        let (mut next, halves) = halved(last, &cover);
        next.color = joined(&frames, l as usize, grid);
        cover = halves;
        out.push(next);
    }
    out
}

/// A level of all frames side by side.
fn joined(frames: &[Vec<Level>], l: usize, grid: u32) -> Array<[u8; 4]> {
    let tile = frames[0][l].width as usize;
    let row = |row: usize, y: usize| {
        let frames = &frames[row * grid as usize..][..grid as usize];
        frames.iter().flat_map(move |f| f[l].texels[y * tile..][..tile].iter().copied())
    };
    (0..grid as usize).flat_map(|r| (0..tile).flat_map(move |y| row(r, y))).collect()
}

/// The next level but for its colours, and its coverage.
fn halved(from: &Atlas, cover: &[f32]) -> (Atlas, Vec<f32>) {
    let side = from.side / 2;
    let texels: Vec<([[u8; 4]; 3], f32)> = (0..side as usize * side as usize)
        .into_par_iter()
        .map(|i| {
            let (x, y) = (i % side as usize * 2, i / side as usize * 2);
            let width = from.side as usize;
            let at = [y * width + x, y * width + x + 1, (y + 1) * width + x, (y + 1) * width + x + 1];
            texel(from, at, at.map(|i| cover[i]))
        })
        .collect();
    let image = |k: usize| -> Array<[u8; 4]> { texels.iter().map(|t| t.0[k]).collect() };
    let next = Atlas {
        side,
        color: Array::default(),
        normal: image(0),
        orm: from.orm.as_ref().map(|_| image(1)),
        emissive: from.emissive.as_ref().map(|_| image(2)),
    };
    (next, texels.iter().map(|t| t.1).collect())
}

/// The mean of four texels, in all images but that of colours, and of their coverage.
fn texel(from: &Atlas, at: [usize; 4], cover: [f32; 4]) -> ([[u8; 4]; 3], f32) {
    let total: f32 = cover.iter().sum();
    let weight = if total > 0.0 { cover.map(|a| a / total) } else { [0.25; 4] };
    let mean = |image: &Array<[u8; 4]>, k: usize, decode: fn(u8) -> f32| -> f32 {
        at.iter().zip(weight).map(|(i, w)| decode(image[*i][k]) * w).sum()
    };
    let linear = |image: &Array<[u8; 4]>| [0, 1, 2, 3].map(|k| byte(mean(image, k, plain)));
    let light = |image: &Array<[u8; 4]>| [0, 1, 2].map(|k| srgb::from_linear(mean(image, k, srgb::to_linear)));
    let opaque = |[r, g, b]: [u8; 3]| [r, g, b, 255];
    let n = Vec3::from([0, 1, 2].map(|k| mean(&from.normal, k, plain) / 127.5 - 1.0)).normalize_or_zero();
    let [nx, ny, nz] = n.to_array().map(|c| byte((c + 1.0) * 127.5));
    let images = [
        [nx, ny, nz, byte(mean(&from.normal, 3, plain))],
        from.orm.as_ref().map_or([0; 4], linear),
        from.emissive.as_ref().map_or([0; 4], |image| opaque(light(image))),
    ];
    (images, total * 0.25)
}

fn plain(v: u8) -> f32 {
    f32::from(v)
}

fn byte(v: f32) -> u8 {
    (v + 0.5) as u8
}
