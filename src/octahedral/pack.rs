//! From captures to atlases.

use super::{Atlas, Grid, Impostor, MAX_ATLAS, TILES, fit_card};
use crate::{
    capture::{Capture, dilate},
    image::srgb,
    math::{Aabb, Stop, Stopped},
    view::Projection,
};
use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

/// Why captures are no octahedral impostor.
#[derive(Debug, thiserror::Error)]
pub enum PackError {
    #[error("{0} captures; expected those of a square grid: 9, 16, 25, …")]
    Count(usize),
    #[error("{name}: {what}")]
    View { name: String, what: String },
    #[error("{0}")]
    Tile(String),
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// How far a camera may be from where the grid has it: a share of the window's side, and of a unit vector.
const SLACK: f64 = 1e-6;

/// Packs the captures of a grid, row by row, into atlases; of each the first layer. `tile`: texels along a frame's side, a power of two that divides the
/// captures' pixels; each texel is the mean of the pixels that it covers. `None`: one texel a pixel.
///
/// Whether the grid goes around the object or only over its upper half follows from the cameras: a grid all around looks from
/// below.
///
/// # Errors
/// Where the captures are not orthographic pictures through one window from the directions of a [`Grid`], or do not fit the tile.
pub fn pack(captures: &[(&str, &Capture)], tile: Option<u32>, stop: &Stop) -> Result<Impostor, PackError> {
    let side = captures.len().isqrt();
    let hemi = captures.iter().all(|(_, c)| c.view.forward.y <= SLACK);
    let grid = Grid { side: side as u32, hemi };
    if side * side != captures.len() || !grid.is_valid() {
        return Err(PackError::Count(captures.len()));
    }
    let pixels = captures[0].1.view.width;
    let tile = tile.unwrap_or(pixels);
    if !TILES.contains(&tile) || !tile.is_power_of_two() || !pixels.is_multiple_of(tile) {
        let (least, most) = (TILES.start(), TILES.end());
        return Err(PackError::Tile(format!(
            "frames of {tile} texels from captures of {pixels} pixels; expected a power of two from {least} to {most} that divides them"
        )));
    }
    if grid.side * tile > MAX_ATLAS {
        let what = format!("{side} frames of {tile} texels are {}; expected at most {MAX_ATLAS}", grid.side * tile);
        return Err(PackError::Tile(what));
    }
    let (centre, radius) = window(captures, grid)?;
    let materials = !captures[0].1.layers[0].orm.is_empty();
    if let Some((name, _)) = captures.iter().find(|(_, c)| c.layers[0].orm.is_empty() == materials) {
        let what = if materials { "no images of materials" } else { "images of materials" };
        return Err(PackError::View {
            name: (*name).to_owned(),
            what: format!("{what}, other than the first capture"),
        });
    }
    let frames = captures.par_iter().map(|(_, capture)| {
        stop.check()?;
        Ok(frame(capture, tile, centre, radius))
    });
    let frames: Vec<Frame> = frames.collect::<Result<_, Stopped>>()?;
    let emits = frames.iter().flat_map(|f| &f.emissive).any(|t| t[..3] != [0; 3]);
    let bounds = captures.iter().fold(Aabb::EMPTY, |b, (_, c)| b.union(c.bounds));
    let atlas = Atlas {
        side: grid.side * tile,
        color: joined(&frames, grid, tile, |f| &f.color),
        normal: joined(&frames, grid, tile, |f| &f.normal),
        orm: materials.then(|| joined(&frames, grid, tile, |f| &f.orm)),
        emissive: emits.then(|| joined(&frames, grid, tile, |f| &f.emissive)),
    };
    let mut out = Impostor { grid, tile, centre, radius, bounds, card: Vec::new(), atlas };
    stop.check()?;
    out.card = fit_card(&out);
    Ok(out)
}

/// Centre and half side of the window that all captures look through.
fn window(captures: &[(&str, &Capture)], grid: Grid) -> Result<(DVec3, f64), PackError> {
    let wrong = |name: &str, what: String| PackError::View { name: name.to_owned(), what };
    // The point nearest to the axes of all windows: Σ (1 − ddᵀ) (c − e) = 0.
    let (mut sum, mut side) = (DMat3::ZERO, DVec3::ZERO);
    let mut axes = Vec::with_capacity(captures.len());
    for (i, (name, capture)) in captures.iter().enumerate() {
        let v = &capture.view;
        let Projection::Orthographic { left, right, bottom, top } = v.projection else {
            return Err(wrong(name, "a perspective camera; expected an orthographic one".into()));
        };
        let (column, row) = (i as u32 % grid.side, i as u32 / grid.side);
        let direction = grid.direction(column, row);
        if v.forward.distance(-direction) > SLACK {
            let what = format!(
                "looks along {}; the point of column {column} and row {row} of the grid looks along {}",
                v.forward, -direction
            );
            return Err(wrong(name, what));
        }
        let [r, u] = super::axes(direction);
        if v.right.distance(r) > SLACK || v.up.distance(u) > SLACK {
            return Err(wrong(name, format!("its picture is turned: right is {}, expected {r}", v.right)));
        }
        let on = v.eye + v.right * ((left + right) * 0.5) + v.up * ((bottom + top) * 0.5);
        let half = (right - left) * 0.5;
        if v.width != v.height || (top - bottom - right + left).abs() > half * SLACK {
            return Err(wrong(name, "its window is not square".into()));
        }
        if v.width != captures[0].1.view.width {
            return Err(wrong(name, format!("{} pixels, another number than the first camera's", v.width)));
        }
        let d = v.forward;
        let across = DMat3::IDENTITY - DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        sum += across;
        side += across * on;
        axes.push((on, d, half));
    }
    let centre = sum.inverse() * side;
    let radius = axes[0].2;
    for ((name, _), (on, d, half)) in captures.iter().zip(axes) {
        let off = (centre - on).cross(d).length();
        if !(off <= radius * SLACK && (half - radius).abs() <= radius * SLACK) {
            return Err(wrong(name, "its window is not that of the other cameras".into()));
        }
    }
    Ok((centre, radius))
}

/// A frame's texels.
struct Frame {
    color: Vec<[u8; 4]>,
    normal: Vec<[u8; 4]>,
    /// Empty where it was not captured.
    orm: Vec<[u8; 4]>,
    /// Empty where it was not captured.
    emissive: Vec<[u8; 4]>,
}

/// How far heights are dilated, texels. Farther from the object they are those of the plane through the centre.
const HEIGHTS: usize = 4;

/// One capture as a frame, dilated.
fn frame(capture: &Capture, tile: u32, centre: DVec3, radius: f64) -> Frame {
    let view = &capture.view;
    let layer = &capture.layers[0];
    let n = (view.width / tile) as usize;
    let width = view.width as usize;
    let to_centre = (centre - view.eye).dot(view.forward);
    let materials = !layer.orm.is_empty();
    let (mut texels, mut covered) = (Vec::new(), Vec::new());
    let (mut orms, mut emissives) = (Vec::new(), Vec::new());
    let mut heights: Vec<f64> = Vec::new();
    for y in 0..tile as usize {
        for x in 0..tile as usize {
            let (mut color, mut normal) = (Vec3::ZERO, Vec3::ZERO);
            let (mut orm, mut emissive) = (Vec3::ZERO, Vec3::ZERO);
            heights.clear();
            for k in 0..n * n {
                let at = (y * n + k / n) * width + x * n + k % n;
                let z = f64::from(layer.depth[at]);
                if z.is_finite() {
                    let [r, g, b, _] = layer.color[at];
                    color += Vec3::from([r, g, b].map(srgb::to_linear));
                    let [i, j, k, _] = layer.normal[at];
                    normal += Vec3::new(i.into(), j.into(), k.into());
                    heights.push(to_centre - z);
                    if materials {
                        let ([o, r, m, _], [red, green, blue, _]) = (layer.orm[at], layer.emissive[at]);
                        orm += Vec3::from([o, r, m].map(f32::from));
                        emissive += Vec3::from([red, green, blue].map(srgb::to_linear));
                    }
                }
            }
            let count = heights.len();
            covered.push(count > 0);
            if materials {
                let share = 1.0 / count.max(1) as f32;
                let [o, r, m] = (orm * share).to_array().map(|v| (v + 0.5) as u8);
                let [red, green, blue] = (emissive * share).to_array().map(srgb::from_linear);
                orms.push([o, r, m, 255]);
                emissives.push([red, green, blue, 255]);
            }
            if count == 0 {
                // The plane through the centre, facing the camera: what dilation keeps where nothing is seen at all.
                texels.push(([0; 4], encoded(-view.forward.as_vec3(), 0.0)));
                continue;
            }
            // The median belongs to one of the surfaces; the mean of two lies where there is none.
            heights.sort_by(f64::total_cmp);
            let height = heights[(count - 1) / 2] / radius;
            let [r, g, b] = (color / count as f32).to_array().map(srgb::from_linear);
            let alpha = (255 * count + n * n / 2) / (n * n);
            texels.push(([r, g, b, alpha as u8], encoded(normal.normalize_or(-view.forward.as_vec3()), height)));
        }
    }
    let alpha: Vec<u8> = texels.iter().map(|t| t.0[3]).collect();
    let tile = tile as usize;
    dilate(&mut texels, &covered, tile);
    for (texel, near) in texels.iter_mut().zip(within(&covered, tile, HEIGHTS)) {
        if !near {
            texel.1[3] = encoded(Vec3::ZERO, 0.0)[3];
        }
    }
    if materials {
        dilate(&mut orms, &covered, tile);
        dilate(&mut emissives, &covered, tile);
    }
    let color = texels.iter().zip(alpha).map(|(t, a)| [t.0[0], t.0[1], t.0[2], a]).collect();
    Frame { color, normal: texels.iter().map(|t| t.1).collect(), orm: orms, emissive: emissives }
}

/// Where a texel at most `reach` rows and columns away is covered, in an image whose side is `side`.
fn within(covered: &[bool], side: usize, reach: usize) -> Vec<bool> {
    let around = |v: usize| v.saturating_sub(reach)..=(v + reach).min(side - 1);
    let rows: Vec<bool> = (0..side * side).map(|i| around(i % side).any(|x| covered[i / side * side + x])).collect();
    (0..side * side).map(|i| around(i / side).any(|y| rows[y * side + i % side])).collect()
}

/// A normal, and a height in radii, as they are stored.
fn encoded(normal: Vec3, height: f64) -> [u8; 4] {
    let [x, y, z] = normal.to_array().map(|c| ((c + 1.0) * 127.5 + 0.5) as u8);
    [x, y, z, ((height + 1.0) * 127.5 + 0.5) as u8]
}

/// Frames side by side.
fn joined(frames: &[Frame], grid: Grid, tile: u32, image: fn(&Frame) -> &Vec<[u8; 4]>) -> crate::array::Array<[u8; 4]> {
    let (tile, side) = (tile as usize, grid.side as usize);
    let mut out = Vec::with_capacity(frames.len() * tile * tile);
    for row in frames.chunks(side) {
        for y in 0..tile {
            for frame in row {
                out.extend_from_slice(&image(frame)[y * tile..(y + 1) * tile]);
            }
        }
    }
    out.into()
}
