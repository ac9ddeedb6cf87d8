//! The writer of captures.

use super::{Capture, Layer, pack_normal};
use crate::{
    array::Array,
    image::srgb,
    math::{Aabb, Stop, Stopped},
    raster::{Backend, Fragment, Geometry, NOTHING, Options, Prepared, Shader, fragments_in_tiles, nearest},
    view::{Projection, View},
};
use rayon::prelude::*;

/// What is captured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capturing {
    /// Surfaces of a pixel that are kept, at least 1.
    pub layers: u32,
    /// Deeper layers keep surfaces that show their back too. The first layer shows what the materials say.
    pub backs: bool,
}

/// Captures what `view` sees; materials too where `shader` was made by [`Shader::with_finishes`].
pub fn capture(
    backend: &dyn Backend,
    shader: &Shader,
    bounds: Aabb,
    view: &View,
    how: Capturing,
    stop: &Stop,
) -> Result<Capture, Stopped> {
    let geometry = shader.geometry;
    let layers = if how.layers <= 1 {
        let seen = nearest(backend, geometry, view, &Options::default(), stop)?;
        vec![seen.depth.iter().copied().zip(seen.triangle.iter().copied()).collect()]
    } else {
        deep(backend, geometry, view, how, stop)?
    };
    let layers = layers.iter().map(|l| shade(shader, view, l, stop)).collect::<Result<_, _>>()?;
    Ok(Capture { view: *view, bounds, double_sided: geometry.draws().iter().any(|d| d.material.double_sided), layers })
}

/// Depth and triangle of each pixel.
type Seen = Vec<(f32, u32)>;

/// The first surfaces of every pixel, one list a layer.
fn deep(
    backend: &dyn Backend,
    geometry: &Geometry,
    view: &View,
    how: Capturing,
    stop: &Stop,
) -> Result<Vec<Seen>, Stopped> {
    let prepared = Prepared::new(geometry, view, &Options::default(), stop)?;
    let layers = how.layers as usize;
    let front = |t: u32, px: f64, py: f64| {
        let [a, b, c] = geometry.positions(t);
        let towards = match view.projection {
            Projection::Perspective { .. } => a - view.eye,
            Projection::Orthographic { .. } => view.unproject(px, py, 1.0) - view.unproject(px, py, 0.0),
        };
        (b - a).cross(c - a).dot(towards) < 0.0
    };
    let tiles = fragments_in_tiles(backend, &prepared, stop, |tile, fragments| {
        let mut kept = vec![(f32::INFINITY, NOTHING); tile.pixels() * layers];
        for i in 0..tile.pixels() {
            let (x, y) = tile.pixel(i);
            let (px, py) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
            let mut at = 0;
            let mut last: Option<Fragment> = None;
            for f in fragments.of(i) {
                if at == layers {
                    break;
                }
                // Two triangles that share an edge or lie on each other are one surface.
                let same = last.is_some_and(|l| f.depth - l.depth <= l.depth * 1e-6);
                if same || (at > 0 && !how.backs && !front(f.triangle, px, py)) {
                    continue;
                }
                kept[i * layers + at] = (f.depth, f.triangle);
                at += 1;
                last = Some(*f);
            }
        }
        (tile, kept)
    })?;
    let pixels = view.width as usize * view.height as usize;
    let mut out = vec![vec![(f32::INFINITY, NOTHING); pixels]; layers];
    for (tile, kept) in tiles {
        for (i, kept) in kept.chunks_exact(layers).enumerate() {
            let (x, y) = tile.pixel(i);
            for (layer, seen) in out.iter_mut().zip(kept) {
                layer[y as usize * view.width as usize + x as usize] = *seen;
            }
        }
    }
    Ok(out)
}

fn shade(shader: &Shader, view: &View, seen: &Seen, stop: &Stop) -> Result<Layer, Stopped> {
    let width = view.width as usize;
    let rows: Vec<Vec<([u8; 4], [i16; 4])>> = seen
        .par_chunks(width.max(1))
        .enumerate()
        .map(|(y, row)| {
            stop.check()?;
            let pixel = |(x, (_, triangle)): (usize, &(f32, u32))| {
                if *triangle == NOTHING {
                    return ([0; 4], [0; 4]);
                }
                let surface = shader.shade(view, x as f64 + 0.5, y as f64 + 0.5, *triangle);
                let [r, g, b, _] = surface.color;
                let [r, g, b] = [r, g, b].map(srgb::from_linear);
                ([r, g, b, 255], pack_normal(surface.normal.as_dvec3()))
            };
            Ok(row.iter().enumerate().map(pixel).collect())
        })
        .collect::<Result<_, Stopped>>()?;
    let (orm, emissive) = match shader.has_finishes() {
        true => finishes(shader, view, seen, stop)?,
        false => Default::default(),
    };
    let object = |t: u32| if t == NOTHING { NOTHING } else { shader.geometry.object_of(t) };
    Ok(Layer {
        depth: seen.iter().map(|s| s.0).collect(),
        color: rows.iter().flatten().map(|p| p.0).collect(),
        normal: rows.iter().flatten().map(|p| p.1).collect(),
        object: seen.iter().map(|s| object(s.1)).collect(),
        triangle: seen.iter().map(|s| s.1).collect(),
        orm,
        emissive,
    })
}

/// The images of what materials do with light.
fn finishes(
    shader: &Shader,
    view: &View,
    seen: &Seen,
    stop: &Stop,
) -> Result<(Array<[u8; 4]>, Array<[u8; 4]>), Stopped> {
    let byte = |v: f32| (v * 255.0).round().clamp(0.0, 255.0) as u8;
    let rows: Vec<Vec<([u8; 4], [u8; 4])>> = seen
        .par_chunks((view.width as usize).max(1))
        .enumerate()
        .map(|(y, row)| {
            stop.check()?;
            let pixel = |(x, (_, triangle)): (usize, &(f32, u32))| {
                let at = (*triangle != NOTHING).then_some(*triangle);
                let finish = at.and_then(|t| shader.finish(view, x as f64 + 0.5, y as f64 + 0.5, t));
                finish.map_or_else(Default::default, |f| {
                    let [r, g, b] = f.emissive.map(srgb::from_linear);
                    ([byte(f.occlusion), byte(f.roughness), byte(f.metallic), 255], [r, g, b, 255])
                })
            };
            Ok(row.iter().enumerate().map(pixel).collect())
        })
        .collect::<Result<_, Stopped>>()?;
    Ok((rows.iter().flatten().map(|p| p.0).collect(), rows.iter().flatten().map(|p| p.1).collect()))
}
