//! A relief impostor as a stand-in that certificates can judge.

use super::{Model, draw};
use crate::{
    math::{Aabb, Stopped},
    raster::Rendering,
    relief::textures::Textures,
    runtime::{Context, Drawn, Planes, Shot, Size, StandIn},
    view::View,
};
use glam::{DVec3, Vec3};

/// A relief impostor.
pub struct OriStandIn {
    model: Model,
    size: Size,
}

/// Triangles of the box that a map is drawn with.
pub(super) const BOX: u64 = 12;

impl OriStandIn {
    /// `textures` are those of the model's maps.
    pub fn new(model: Model, textures: &Textures) -> Self {
        let texels =
            textures.named().map(|(_, a)| u64::from(a.width) * u64::from(a.height) * u64::from(a.layers)).sum();
        let size = Size { triangles: BOX, draw_calls: 1, texels, memory_bytes: textures.bytes() };
        Self { model, size }
    }

    pub fn model(&self) -> &Model {
        &self.model
    }
}

impl StandIn for OriStandIn {
    fn bounds(&self) -> Aabb {
        self.model.ori().bounds
    }

    fn size(&self) -> Size {
        self.size
    }

    fn draw(&self, view: &View, how: &Rendering, context: Context) -> Result<Shot<'_>, Stopped> {
        let drawn = draw(&self.model, view, how, context.stop)?;
        let surface =
            (0..).zip(&drawn.depth).map(|(i, z)| if z.is_finite() { i } else { crate::raster::NOTHING }).collect();
        let (depth, normal, view) = (drawn.depth.clone(), drawn.normal, *view);
        let planes = planes(view, depth, normal);
        let of_view = Drawn { triangles: BOX, references: drawn.selected.len() as u32 };
        Ok(Shot { picture: drawn.picture, depth: drawn.depth, surface, planes, drawn: Some(of_view) })
    }
}

/// Every pixel is a surface of its own: the plane through what it sees.
pub(super) fn planes(view: View, depth: Vec<f32>, normal: Vec<Vec3>) -> Planes<'static> {
    Box::new(move |i| {
        let (x, y) = (f64::from(i % view.width) + 0.5, f64::from(i / view.width) + 0.5);
        let p = view.unproject(x, y, f64::from(depth[i as usize])) - view.eye;
        let normal = normal[i as usize].as_dvec3();
        let n = DVec3::new(normal.dot(view.right), normal.dot(view.up), normal.dot(view.forward));
        n / normal.dot(p)
    })
}
