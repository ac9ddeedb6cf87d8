//! An impostor made ready to be drawn.

use super::{
    Drawing, OctahedralError,
    march::{Met, Ray, Tilted},
    sample::Frame,
};
use crate::{
    octahedral::{Atlas, Impostor, Pick, axes, levels},
    view::{Projection, View},
};
use glam::{DVec2, DVec3, Vec3};

/// An impostor with its mip levels.
pub struct Model {
    impostor: Impostor,
    levels: Vec<Atlas>,
    drawing: Drawing,
}

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Planar depth, metres.
    pub depth: f64,
    /// Linear base colour.
    pub color: Vec3,
    /// Unit, world space.
    pub normal: Vec3,
    /// Linear.
    pub emissive: Vec3,
}

impl Model {
    /// # Errors
    /// Where the impostor is not as its type says.
    pub fn new(impostor: Impostor, drawing: Drawing) -> Result<Self, OctahedralError> {
        if let Some(what) = impostor.fault() {
            return Err(OctahedralError::invalid("octahedral impostor", what));
        }
        let levels = levels(&impostor);
        Ok(Self { impostor, levels, drawing })
    }

    pub fn impostor(&self) -> &Impostor {
        &self.impostor
    }

    pub fn drawing(&self) -> &Drawing {
        &self.drawing
    }

    /// The base level and those below it.
    pub fn levels(&self) -> &[Atlas] {
        &self.levels
    }

    /// Unit vector from the centre to the eye; for orthographic views against the direction of view.
    pub fn towards(&self, view: &View) -> DVec3 {
        match view.projection {
            Projection::Perspective { .. } => (view.eye - self.impostor.centre).normalize_or(DVec3::Y),
            Projection::Orthographic { .. } => -view.forward,
        }
    }

    /// What `view` needs of the impostor. `pixels`: along a sample's side, 1/n with n × n samples a pixel.
    pub fn seen_by<'a>(&'a self, view: &View, pixels: f64) -> Seen<'a> {
        let Impostor { grid, tile, centre, radius, card, .. } = &self.impostor;
        let towards = self.towards(view);
        let picked = grid.select(towards).into_iter().filter(|p| p.weight > 0.0);
        let frames = picked.map(|Pick { column, row, weight }| {
            let direction = grid.direction(column, row);
            let [right, up] = axes(direction);
            let frame = Frame { levels: &self.levels, column, row, tile: *tile };
            Tilted { frame, weight: weight as f32, direction, right, up }
        });
        let [right, up] = axes(towards);
        let (perspective, width) = match view.projection {
            Projection::Perspective { left, right, .. } => (true, right - left),
            Projection::Orthographic { left, right, .. } => (false, right - left),
        };
        let front = *centre + towards * *radius;
        // From within the sphere around the object the card cannot hold all of it.
        let outside = !perspective || (view.eye - front).dot(towards) > 0.0;
        Seen {
            view: *view,
            centre: *centre,
            radius: *radius,
            frames: frames.collect(),
            card: outside.then(|| Card {
                front,
                towards,
                right,
                up,
                corners: card.iter().map(|c| DVec2::from(*c) * *radius).collect(),
            }),
            steps: self.drawing.steps,
            scale: width / f64::from(view.width) * pixels / self.impostor.texel(),
            perspective,
        }
    }
}

struct Card {
    /// On the plane, whose normal is `towards`.
    front: DVec3,
    towards: DVec3,
    right: DVec3,
    up: DVec3,
    /// Metres, about `front`.
    corners: Vec<DVec2>,
}

/// An impostor as one view sees it.
pub struct Seen<'a> {
    view: View,
    centre: DVec3,
    radius: f64,
    frames: Vec<Tilted<'a>>,
    card: Option<Card>,
    steps: u32,
    /// Texels that a sample measures, at planar depth 1 in perspective.
    scale: f64,
    perspective: bool,
}

/// Rays that meet a frame's plane at less than this cosine times their length pass it by.
const GRAZING: f64 = 0.05;

impl Seen<'_> {
    /// The frames that are blended.
    pub fn frames(&self) -> usize {
        self.frames.len()
    }

    /// What is seen at the continuous pixel position (px, py); `None` beside the object.
    pub fn at(&self, px: f64, py: f64) -> Option<Hit> {
        // The ray's parameter is the planar depth.
        let origin = self.view.unproject(px, py, 0.0);
        let ray = self.view.unproject(px, py, 1.0) - origin;
        if self.card.as_ref().is_some_and(|c| !c.holds(origin, ray)) {
            return None;
        }
        let (mut weight, mut coverage) = (0.0, 0.0);
        let (mut depth, mut color, mut normal, mut emissive) = (0.0, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
        for tilted in &self.frames {
            let slope = ray.dot(tilted.direction);
            if slope > -GRAZING * ray.length() {
                continue;
            }
            weight += tilted.weight;
            let middle = (self.centre - origin).dot(tilted.direction) / slope;
            let level = self.level(middle);
            let ray = Ray { start: origin - self.centre, ray, middle, slope, radius: self.radius, level };
            match ray.met(tilted, self.steps) {
                Met::Surface(uv) => {
                    let t = ray.at(tilted.frame.height(uv, level));
                    let w = tilted.weight;
                    coverage += w;
                    depth += t * f64::from(w);
                    color += tilted.frame.color(uv, level) * w;
                    normal += tilted.frame.normal(uv, level) * w;
                    emissive += tilted.frame.emissive(uv, level) * w;
                }
                Met::Nothing => {}
                // What another frame sees there decides.
                Met::Hidden => weight -= tilted.weight,
            }
        }
        let depth = depth / f64::from(coverage);
        if !(coverage > 0.0 && coverage >= 0.5 * weight) || (self.perspective && depth <= 0.0) {
            return None;
        }
        let normal = normal.normalize_or(-ray.as_vec3().normalize_or_zero());
        Some(Hit { depth, color: color / coverage, normal, emissive: emissive / coverage })
    }

    /// The mip level whose texels are as large as a sample at planar depth `z`.
    fn level(&self, z: f64) -> f32 {
        let texels = if self.perspective { self.scale * z } else { self.scale };
        if texels > 1.0 { libm::log2(texels) as f32 } else { 0.0 }
    }
}

impl Card {
    fn holds(&self, origin: DVec3, ray: DVec3) -> bool {
        let slope = ray.dot(self.towards);
        if slope >= 0.0 {
            return false;
        }
        let p = origin + ray * ((self.front - origin).dot(self.towards) / slope) - self.front;
        let p = DVec2::new(p.dot(self.right), p.dot(self.up));
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).all(|(a, b)| (*b - *a).perp_dot(p - *a) >= 0.0)
    }
}
