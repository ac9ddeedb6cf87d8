//! A view of a relief impostor.

use super::model::{Loaded, Model};
use crate::{
    image::{Picture, srgb},
    math::{Stop, Stopped},
    raster::{NOTHING, Rendering, Surface},
    relief::{Candidate, Hit, Ray, resolve, trace},
    scene::Wrap,
    view::{Projection, View},
};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// What a view shows.
pub struct Drawn {
    pub picture: Picture,
    /// At every pixel centre, row by row: planar depth in metres, infinite where there is nothing.
    pub depth: Vec<f32>,
    /// Likewise the unit normal of the surface without its normal map, world space; zero where there is nothing.
    pub normal: Vec<Vec3>,
    /// Likewise the number of the map that shows the pixel; [`NOTHING`] where none does.
    pub map: Vec<u32>,
    /// The maps of this view, the one nearest to its direction first.
    pub selected: Vec<u32>,
}

/// Draws a view. Pixels beside a jump in depth or beside another map are sampled as finely as `how` asks, others once, with textures filtered over the
/// pixel.
pub fn draw(model: &Model, view: &View, how: &Rendering, stop: &Stop) -> Result<Drawn, Stopped> {
    let selected = model.select(view);
    let eye = Eye::new(model, view, &selected);
    let (width, height) = (view.width as usize, view.height as usize);
    let rows: Vec<Vec<Option<Seen>>> = (0..height)
        .into_par_iter()
        .map(|y| {
            stop.check()?;
            Ok((0..width).map(|x| eye.see(x as f64 + 0.5, y as f64 + 0.5)).collect())
        })
        .collect::<Result<_, Stopped>>()?;
    let centres: Vec<Option<Seen>> = rows.into_iter().flatten().collect();
    let background = Vec3::from(how.background);
    let n = how.samples_per_axis.max(1) as usize;
    let texels: Vec<Vec<[u8; 4]>> = (0..height)
        .into_par_iter()
        .map(|y| {
            stop.check()?;
            let pixel = |x: usize| {
                let own = &centres[y * width + x];
                let color = if n > 1 && eye.is_edge(&centres, [width, height], [x, y]) {
                    let at = |i: usize, k: usize| i as f64 + (k as f64 + 0.5) / n as f64;
                    let sample = |k: usize| {
                        let seen = eye.see(at(x, k % n), at(y, k / n));
                        seen.map_or(background, |s| eye.color(&s, how))
                    };
                    (0..n * n).map(sample).sum::<Vec3>() / (n * n) as f32
                } else {
                    own.as_ref().map_or(background, |s| eye.color(s, how))
                };
                let [r, g, b] = color.to_array().map(srgb::from_linear);
                [r, g, b, 255]
            };
            Ok((0..width).map(pixel).collect())
        })
        .collect::<Result<_, Stopped>>()?;
    Ok(Drawn {
        picture: Picture { width: view.width, height: view.height, texels: texels.into_iter().flatten().collect() },
        depth: centres.iter().map(|s| s.as_ref().map_or(f32::INFINITY, |s| s.depth as f32)).collect(),
        normal: centres.iter().map(|s| s.as_ref().map_or(Vec3::ZERO, |s| eye.face(s))).collect(),
        map: centres.iter().map(|s| s.as_ref().map_or(NOTHING, |s| s.map)).collect(),
        selected,
    })
}

/// What a ray sees.
#[derive(Clone, Copy)]
struct Seen {
    map: u32,
    hit: Hit,
    /// Planar depth, metres.
    depth: f64,
}

/// An eye that looks at a model.
struct Eye<'a> {
    model: &'a Model,
    view: &'a View,
    selected: &'a [u32],
    /// Planar depth of the middle of the object, from which rays are measured so that 32 bits suffice.
    middle: f64,
}

impl<'a> Eye<'a> {
    fn new(model: &'a Model, view: &'a View, selected: &'a [u32]) -> Self {
        Self { model, view, selected, middle: (model.centre - view.eye).dot(view.forward) }
    }

    /// A point of the ray of a pixel position at the depth of the object's middle, and the way per metre of planar depth.
    fn ray(&self, px: f64, py: f64) -> (DVec3, DVec3) {
        match self.view.projection {
            Projection::Perspective { .. } => {
                let direction = self.view.unproject(px, py, 1.0) - self.view.eye;
                (self.view.eye + direction * self.middle, direction)
            }
            Projection::Orthographic { .. } => (self.view.unproject(px, py, self.middle), self.view.forward),
        }
    }

    fn see(&self, px: f64, py: f64) -> Option<Seen> {
        let (origin, direction) = self.ray(px, py);
        let near = (self.view.near - self.middle) as f32;
        let far = (self.view.far - self.middle) as f32;
        let drawing = &self.model.ori.drawing;
        let mut hits: [Option<Hit>; MAPS] = [None; MAPS];
        let mut candidates: [Option<Candidate>; MAPS] = [None; MAPS];
        let count = self.selected.len().min(MAPS);
        for (k, m) in self.selected.iter().take(count).enumerate() {
            let map = &self.model.maps[*m as usize];
            let ray = map.field.ray(origin, direction);
            let Some(hit) = trace(&map.field, &ray, near, far, &drawing.trace) else { continue };
            hits[k] = Some(hit);
            candidates[k] = Some(candidate(map, &ray, &hit, drawing.trace.wall));
        }
        let k = resolve(drawing.strategy, &candidates[..count])?;
        let hit = hits[k]?;
        Some(Seen { map: self.selected[k], hit, depth: self.middle + f64::from(hit.t) })
    }

    /// A pixel whose neighbours show something else.
    fn is_edge(&self, centres: &[Option<Seen>], [width, height]: [usize; 2], [x, y]: [usize; 2]) -> bool {
        let own = &centres[y * width + x];
        let (x0, x1, y0, y1) =
            (x.saturating_sub(1), (x + 1).min(width - 1), y.saturating_sub(1), (y + 1).min(height - 1));
        let jump = self.footprint(own.as_ref().map_or(self.middle, |s| s.depth)) * EDGE;
        (y0..=y1).any(|y| {
            (x0..=x1).any(|x| match (own, &centres[y * width + x]) {
                (Some(a), Some(b)) => (a.depth - b.depth).abs() > jump,
                (None, None) => false,
                _ => true,
            })
        })
    }

    /// Width of a pixel at a planar depth, metres.
    fn footprint(&self, depth: f64) -> f64 {
        match self.view.projection {
            Projection::Perspective { left, right, .. } => (right - left) / f64::from(self.view.width) * depth,
            Projection::Orthographic { left, right, .. } => (right - left) / f64::from(self.view.width),
        }
    }

    /// Linear colour of what is seen.
    fn color(&self, seen: &Seen, how: &Rendering) -> Vec3 {
        let map = &self.model.maps[seen.map as usize];
        let side = f64::from(map.field.side);
        let uv = [f64::from(seen.hit.point.x) / side, f64::from(seen.hit.point.y) / side];
        let texels = (self.footprint(seen.depth) / map.field.texel) as f32;
        let footprint = texels * texels;
        let sample = |mips: &crate::raster::Mips| mips.sample(uv, footprint, [Wrap::Clamp; 2], true);
        let [r, g, b, _] = sample(&map.color);
        let [x, y, ..] = sample(&map.normal).map(|v| (v * 255.0 - 127.0) / 127.0);
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let normal = (map.axes[0] * x + map.axes[1] * y + map.axes[2] * z).normalize_or(map.axes[2]);
        let position = map.field.world(seen.hit.point);
        let to_eye = match self.view.projection {
            Projection::Perspective { .. } => (self.view.eye - position).normalize_or_zero(),
            Projection::Orthographic { .. } => -self.view.forward,
        };
        let [er, eg, eb, _] = map.emissive.as_ref().map_or([0.0; 4], sample);
        let surface = Surface {
            position,
            color: [r, g, b, 1.0],
            normal,
            to_eye: to_eye.as_vec3(),
            emissive: [er, eg, eb],
            unlit: false,
        };
        Vec3::from(surface.seen(&how.shading))
    }

    /// The normal of the height field.
    fn face(&self, seen: &Seen) -> Vec3 {
        let map = &self.model.maps[seen.map as usize];
        let [x, y, z] = map.axes;
        let n = map.field.normal(seen.hit.point, self.model.ori.drawing.trace.wall);
        (x * n.x - y * n.y - z * n.z).normalize_or(z)
    }
}

/// More maps than this are not drawn for a view.
pub(super) const MAPS: usize = 8;

/// Pixels of depth from one pixel to the next that count as an edge.
const EDGE: f64 = 4.0;

fn candidate(map: &Loaded, ray: &Ray, hit: &Hit, wall: f32) -> Candidate {
    Candidate {
        plane: -ray.origin.z / ray.direction.z,
        depth: hit.t,
        range: map.range as f32,
        cos: -map.field.normal(hit.point, wall).z,
        tolerance: (f64::from(wall) * map.field.texel) as f32,
    }
}
