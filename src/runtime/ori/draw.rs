//! A view of a relief impostor.

use super::{
    instances::Instance,
    model::{Drawing, Loaded, Model},
    picture::{Scope, paint},
};
use crate::{
    image::Picture,
    math::{Stop, Stopped},
    raster::{NOTHING, Rendering, Surface},
    relief::{Candidate, Hit, Ray, Strategy, resolve, trace},
    scene::Wrap,
    view::{Projection, View},
};
use glam::{DVec3, Vec3};

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
    let (centres, picture) = paint(&eye, view, how, stop)?;
    Ok(Drawn {
        picture,
        depth: centres.iter().map(|s| s.as_ref().map_or(f32::INFINITY, |s| s.depth as f32)).collect(),
        normal: centres.iter().map(|s| s.as_ref().map_or(Vec3::ZERO, |s| eye.face(s))).collect(),
        map: centres.iter().map(|s| s.as_ref().map_or(NOTHING, |s| s.map)).collect(),
        selected,
    })
}

/// What a ray sees.
#[derive(Clone, Copy)]
pub(super) struct Seen {
    pub map: u32,
    hit: Hit,
    /// Planar depth, metres of the impostor's own space.
    pub depth: f64,
}

/// An eye that looks at a model.
pub(super) struct Eye<'a> {
    model: &'a Model,
    /// In the impostor's own space.
    view: &'a View,
    selected: &'a [u32],
    /// Where the impostor stands in the world.
    place: Instance,
    /// Planar depth of the middle of the object, from which rays are measured so that 32 bits suffice.
    middle: f64,
}

impl<'a> Eye<'a> {
    fn new(model: &'a Model, view: &'a View, selected: &'a [u32]) -> Self {
        Self::of_instance(model, view, selected, Instance::default())
    }

    /// `view` as the instance sees it, see [`Instance::view`].
    pub fn of_instance(model: &'a Model, view: &'a View, selected: &'a [u32], place: Instance) -> Self {
        Self { model, view, selected, place, middle: (model.centre - view.eye).dot(view.forward) }
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

    /// Width of a pixel at a planar depth, metres.
    pub fn footprint(&self, depth: f64) -> f64 {
        match self.view.projection {
            Projection::Perspective { left, right, .. } => (right - left) / f64::from(self.view.width) * depth,
            Projection::Orthographic { left, right, .. } => (right - left) / f64::from(self.view.width),
        }
    }

    /// The normal of the height field.
    pub fn face(&self, seen: &Seen) -> Vec3 {
        let map = &self.model.maps[seen.map as usize];
        let [x, y, z] = map.axes;
        let n = map.field.normal(seen.hit.point, self.model.ori.drawing.trace.wall);
        (x * n.x - y * n.y - z * n.z).normalize_or(z)
    }
}

impl Scope for Eye<'_> {
    type Seen = Seen;

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
            candidates[k] = Some(candidate(map, &ray, &hit, drawing));
        }
        let k = resolve(drawing.strategy, &candidates[..count])?;
        let hit = hits[k]?;
        Some(Seen { map: self.selected[k], hit, depth: self.middle + f64::from(hit.t) })
    }

    fn apart(&self, own: &Seen, other: &Seen) -> bool {
        (own.depth - other.depth).abs() > self.footprint(own.depth) * EDGE
    }

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
        let turn = self.place.rotation;
        let position = map.field.world(seen.hit.point);
        let to_eye = match self.view.projection {
            Projection::Perspective { .. } => (self.view.eye - position).normalize_or_zero(),
            Projection::Orthographic { .. } => -self.view.forward,
        };
        let [er, eg, eb, _] = map.emissive.as_ref().map_or([0.0; 4], sample);
        let surface = Surface {
            position: self.place.point(position),
            color: [r, g, b, 1.0],
            normal: turn.as_quat() * normal,
            to_eye: (turn * to_eye).as_vec3(),
            emissive: [er, eg, eb],
            unlit: false,
        };
        Vec3::from(surface.seen(&how.shading))
    }
}

/// More maps than this are not drawn for a view.
pub const MAPS: usize = 8;

/// Pixels of depth from one pixel to the next that count as an edge.
pub(super) const EDGE: f64 = 4.0;

fn candidate(map: &Loaded, ray: &Ray, hit: &Hit, drawing: &Drawing) -> Candidate {
    let wall = drawing.trace.wall;
    // Normals cost as much as the ray: only strategies that rank by them ask for them.
    let ranked = matches!(drawing.strategy, Strategy::Normal | Strategy::BiasedDepth);
    Candidate {
        plane: -ray.origin.z / ray.direction.z,
        depth: hit.t,
        range: map.range as f32,
        cos: if ranked { -map.field.normal(hit.point, wall).z } else { 0.0 },
        tolerance: (f64::from(wall) * map.field.texel) as f32,
    }
}
