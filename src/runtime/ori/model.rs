//! A relief impostor, and what is made ready once for all its views.

use super::OriError;
use crate::{
    math::Aabb,
    raster::{Mips, Role},
    relief::{Field, ReliefMap, Strategy, Trace},
    scene::Image,
    view::{Projection, View},
};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// An object as relief maps, with the maps that each direction of view needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Ori {
    /// Names and maps; all of one size.
    pub maps: Vec<(String, ReliefMap)>,
    /// Unit vectors from the object towards the eye.
    pub directions: Vec<DVec3>,
    /// Numbers of the maps of each direction.
    pub subsets: Vec<Vec<u32>>,
    /// Around the object, metres.
    pub bounds: Aabb,
    /// The projected length threshold, pixels; infinite where nothing is missing.
    pub plt: f64,
    pub drawing: Drawing,
}

/// How an impostor is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawing {
    pub trace: Trace,
    pub strategy: Strategy,
}

/// An impostor ready to be drawn.
pub struct Model {
    pub(super) ori: Ori,
    pub(crate) maps: Vec<Loaded>,
    pub(crate) centre: DVec3,
}

/// A map ready to be drawn.
pub(crate) struct Loaded {
    pub field: Field,
    pub color: Mips,
    pub normal: Mips,
    pub emissive: Option<Mips>,
    /// The map's axes in world space; the third points towards its camera.
    pub axes: [Vec3; 3],
    /// Range of depths, metres.
    pub range: f64,
}

impl Ori {
    /// Checks that numbers refer to maps and that there is something to draw.
    pub fn check(&self) -> Result<(), OriError> {
        let fault = |what: String| Err(OriError::invalid("impostor", what));
        let Some((_, first)) = self.maps.first() else { return fault("expected a relief map".into()) };
        for (name, map) in &self.maps {
            map.check().map_err(|e| OriError::invalid(format!("map `{name}`"), e.to_string()))?;
            if map.side() != first.side() || map.bits != first.bits {
                return fault(format!("map `{name}`: expected {} texels a side, as the first map has", first.side()));
            }
        }
        if self.directions.is_empty() || self.directions.len() != self.subsets.len() {
            return fault("expected a subset of maps for each direction".into());
        }
        if self.directions.iter().any(|d| (d.length_squared() - 1.0).abs() > 1e-6) {
            return fault("expected directions of length 1".into());
        }
        if self.subsets.iter().flatten().any(|m| *m as usize >= self.maps.len()) {
            return fault("a subset names a map that there is not".into());
        }
        if self.bounds.is_empty() || !(self.bounds.min.is_finite() && self.bounds.max.is_finite()) {
            return fault("expected the bounding box of the object".into());
        }
        if !(self.plt > 0.0) {
            return fault(format!("a projected length threshold of {}; expected more than 0 px", self.plt));
        }
        Ok(())
    }
}

impl Model {
    /// # Errors
    /// As [`Ori::check`].
    pub fn new(ori: Ori) -> Result<Self, OriError> {
        ori.check()?;
        let wall = ori.drawing.trace.wall;
        let maps = ori.maps.par_iter().map(|(_, map)| Loaded::new(map, wall)).collect();
        let centre = ori.bounds.centre();
        Ok(Self { ori, maps, centre })
    }

    pub fn ori(&self) -> &Ori {
        &self.ori
    }

    /// Around all that rays can meet: surfaces reach less than two texels beyond the object.
    pub fn reach(&self) -> Aabb {
        let beyond = self.maps.iter().map(|m| m.field.texel).fold(0.0, f64::max) * 2.0;
        let bounds = &self.ori.bounds;
        Aabb { min: bounds.min - beyond, max: bounds.max + beyond }
    }

    /// The maps that a view needs, the one nearest to its direction first.
    pub fn select(&self, view: &View) -> Vec<u32> {
        let towards = match view.projection {
            Projection::Perspective { .. } => (view.eye - self.centre).normalize_or(-view.forward),
            Projection::Orthographic { .. } => -view.forward,
        };
        let near = |d: &DVec3| d.dot(towards);
        let mut best = 0;
        for (i, d) in self.ori.directions.iter().enumerate() {
            if near(d) > near(&self.ori.directions[best]) {
                best = i;
            }
        }
        let mut maps = self.ori.subsets[best].clone();
        let near = |m: u32| self.maps[m as usize].field.towards.dot(towards);
        maps.sort_by(|a, b| near(*b).total_cmp(&near(*a)).then(a.cmp(b)));
        maps
    }
}

impl Loaded {
    fn new(map: &ReliefMap, wall: f32) -> Self {
        let side = map.side();
        let image =
            |texels: crate::array::Array<[u8; 4]>| Image { name: String::new(), width: side, height: side, texels };
        let normals = map.normal.iter().map(|[x, y]| [*x, *y, 0, 255]).collect();
        let view = &map.view;
        Self {
            field: Field::new(map, wall),
            color: Mips::new(&image(map.color.clone()), Role::Color),
            normal: Mips::new(&image(normals), Role::Data),
            emissive: (!map.emissive.is_empty()).then(|| Mips::new(&image(map.emissive.clone()), Role::Color)),
            axes: [view.right.as_vec3(), view.up.as_vec3(), -view.forward.as_vec3()],
            range: view.far - view.near,
        }
    }
}
