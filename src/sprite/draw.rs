//! A scene drawn with effects that depend on which volumes a point lies in (section 3.3): clipping, borders and cut edges, hybrid
//! styles, lenses; and solids drawn from their sprites.
//!
//! The effects look at every surface of a sample, from near to far: what is hidden lets the next one show, in one pass over the
//! geometry, however many volumes there are.

use super::{Entry, Ray, Volume, Zone};
use crate::{
    image::{Picture, srgb},
    math::{Stop, Stopped},
    raster::{Backend, Facet, Fragment, Light, Options, Prepared, Shader, Shading, Surface, Tile, fragments_in_tiles},
    scene,
    view::{Projection, View},
};
use glam::{DVec3, Vec3};
use std::collections::BTreeMap;

/// What happens to points in a zone of a volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Index of the volume.
    pub volume: usize,
    pub zone: Zone,
    /// Half side of the cube of the eight-corner test, metres; 0 asks for the point alone, which has no border.
    pub border: f64,
    /// Pattern of the names of the objects, and of the other volumes that are drawn themselves, that it touches.
    pub objects: String,
    pub style: Style,
}

/// How a point looks. Colours are linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Style {
    /// Not at all: what lies behind shows.
    Hide,
    /// Half of the colour is this one.
    Tint([f32; 3]),
    /// In this colour's shades of brightness.
    Gray([f32; 3]),
    /// In this colour, under the light.
    Flat([f32; 3]),
    /// The direction of the normal as a colour.
    Normals,
    /// In three steps of light, dark where the surface turns away.
    Toon,
    /// Only the triangles' edges, in this colour; solids have none and stay as they are.
    Lines([f32; 3]),
}

/// A volume that is drawn itself, from its image alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    pub volume: usize,
    /// Linear.
    pub color: [f32; 3],
    /// 0 to 1.
    pub opacity: f32,
}

/// What is drawn, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing<'a> {
    pub volumes: &'a [Volume],
    /// Of the volumes, for [`Effect::objects`].
    pub names: &'a [String],
    /// Applied one after the other to every point: where volumes intersect, so do their effects.
    pub effects: &'a [Effect],
    pub solids: &'a [Solid],
    pub light: Light,
    /// Linear.
    pub background: [f32; 3],
    /// Samples along a pixel's side, 1 to 8.
    pub samples: u32,
}

/// Draws a scene.
///
/// # Panics
/// Where a side of the view times the samples exceeds [`crate::raster::MAX_SIDE`], or an effect or a solid names no volume.
pub fn draw(
    backend: &dyn Backend,
    shader: &Shader,
    objects: &[scene::Object],
    view: &View,
    drawing: &Drawing,
    stop: &Stop,
) -> Result<Picture, Stopped> {
    let n = drawing.samples;
    let samples = View { width: view.width * n, height: view.height * n, ..*view };
    let side = Tile::SIDE / n * n;
    let prepared = Prepared::with_tiles(shader.geometry, &samples, &Options::default(), side, stop)?;
    let names: Vec<&str> = objects.iter().map(|o| &*o.name).chain(drawing.names.iter().map(|n| &**n)).collect();
    let touched = |e: &Effect| names.iter().map(|name| scene::select::matches(&e.objects, name)).collect();
    let brush = Brush {
        drawing,
        touched: drawing.effects.iter().map(touched).collect(),
        objects: objects.len(),
        shader,
        prepared: &prepared,
        // Of a pixel at depth 1, or at all depths.
        pixel: match view.projection {
            Projection::Perspective { left, right, .. } | Projection::Orthographic { left, right, .. } => {
                (right - left) / f64::from(view.width)
            }
        },
    };
    let tiles = fragments_in_tiles(backend, &prepared, stop, |tile, fragments| {
        let mut facets = BTreeMap::new();
        let (columns, rows) = ((tile.width / n) as usize, (tile.height / n) as usize);
        let mut sums = vec![Vec3::ZERO; columns * rows];
        for i in 0..tile.pixels() {
            let (x, y) = tile.pixel(i);
            let at = ((y - tile.y) / n) as usize * columns + ((x - tile.x) / n) as usize;
            sums[at] += brush.sample([x, y], fragments.of(i), &mut facets);
        }
        (tile, sums)
    })?;
    let mut texels = vec![[0; 4]; view.width as usize * view.height as usize];
    for (tile, sums) in tiles {
        let columns = (tile.width / n) as usize;
        for (row, sums) in sums.chunks(columns.max(1)).enumerate() {
            let first = (tile.y / n) as usize + row;
            for (texel, sum) in texels[first * view.width as usize + (tile.x / n) as usize..].iter_mut().zip(sums) {
                let [r, g, b] = (*sum / (n * n) as f32).to_array().map(srgb::from_linear);
                *texel = [r, g, b, 255];
            }
        }
    }
    Ok(Picture { width: view.width, height: view.height, texels })
}

struct Brush<'a> {
    drawing: &'a Drawing<'a>,
    /// For each effect which objects it touches, and after them which volumes.
    touched: Vec<Vec<bool>>,
    objects: usize,
    shader: &'a Shader<'a>,
    prepared: &'a Prepared<'a>,
    pixel: f64,
}

impl<'a> Brush<'a> {
    /// Linear colour of a sample: its surfaces and the solids, from near to far.
    fn sample(&self, at: [u32; 2], fragments: &[Fragment], facets: &mut BTreeMap<u32, Facet<'a>>) -> Vec3 {
        let [px, py] = at.map(|c| f64::from(c) + 0.5);
        let ray = Ray::of_pixel(&self.prepared.view, px, py);
        let mut solids = self.solids(&ray).into_iter().peekable();
        let (mut color, mut rest) = (Vec3::ZERO, 1.0f32);
        for fragment in fragments {
            while let Some((_, shade, opacity)) = solids.next_if(|s| s.0 <= f64::from(fragment.depth)) {
                color += shade * (opacity * rest);
                rest *= 1.0 - opacity;
            }
            let facet = facets
                .entry(fragment.triangle)
                .or_insert_with(|| self.shader.facet(&self.prepared.camera, fragment.triangle));
            if let Some(shade) = self.surface(fragment, &facet.surface(px, py), &ray) {
                return color + shade * rest;
            }
        }
        for (_, shade, opacity) in solids {
            color += shade * (opacity * rest);
            rest *= 1.0 - opacity;
        }
        color + Vec3::from(self.drawing.background) * rest
    }

    /// Depth, colour and opacity of the solids that a ray enters, sorted. What an effect hides shows where the ray enters next.
    fn solids(&self, ray: &Ray) -> Vec<(f64, Vec3, f32)> {
        let hit = |solid: &Solid| {
            let volume = &self.drawing.volumes[solid.volume];
            let seen = |entry: Entry| {
                let point = Point {
                    position: ray.at(entry.t),
                    normal: volume.normal(ray, &entry).as_vec3(),
                    base: Vec3::from(solid.color),
                    edges: None,
                };
                let lit = point.base * self.lit(point.normal);
                Some((entry.t, self.after_effects(lit, self.objects + solid.volume, &point, ray)?, solid.opacity))
            };
            // Mostly nothing is hidden.
            volume.enter(ray).and_then(|e| seen(e).or_else(|| volume.spans(ray).iter().find_map(|s| seen(s.enter))))
        };
        let mut hits: Vec<_> = self.drawing.solids.iter().filter_map(hit).collect();
        hits.sort_by(|a, b| a.0.total_cmp(&b.0));
        hits
    }

    fn lit(&self, normal: Vec3) -> Vec3 {
        Vec3::from(self.drawing.light.on(normal))
    }

    /// How a surface looks; `None` where an effect hides it.
    fn surface(&self, fragment: &Fragment, surface: &Surface, ray: &Ray) -> Option<Vec3> {
        let perspective = matches!(self.prepared.view.projection, Projection::Perspective { .. });
        let pixel = self.pixel * if perspective { f64::from(fragment.depth) } else { 1.0 };
        let point = Point {
            position: surface.position,
            normal: surface.normal,
            base: Vec3::from_slice(&surface.color[..3]),
            edges: Some((self.prepared.geometry.positions(fragment.triangle), pixel)),
        };
        let lit = Vec3::from(surface.seen(&Shading::Lit(self.drawing.light)));
        let object = self.prepared.geometry.object_of(fragment.triangle) as usize;
        self.after_effects(lit, object, &point, ray)
    }

    fn after_effects(&self, mut color: Vec3, object: usize, point: &Point, ray: &Ray) -> Option<Vec3> {
        for (effect, touched) in self.drawing.effects.iter().zip(&self.touched) {
            // A solid's surface is on its own border everywhere.
            if object == self.objects + effect.volume {
                continue;
            }
            let volume = &self.drawing.volumes[effect.volume];
            if touched[object] && volume.zone(point.position, effect.border) == effect.zone {
                color = self.styled(&effect.style, color, point, ray)?;
            }
        }
        Some(color)
    }

    fn styled(&self, style: &Style, color: Vec3, point: &Point, ray: &Ray) -> Option<Vec3> {
        let luminance = |c: Vec3| c.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        Some(match style {
            Style::Hide => return None,
            Style::Tint(with) => (color + Vec3::from(*with)) * 0.5,
            Style::Gray(with) => Vec3::from(*with) * luminance(color),
            Style::Flat(with) => Vec3::from(*with) * self.lit(point.normal),
            Style::Normals => point.normal * 0.5 + 0.5,
            Style::Toon => {
                let light = luminance(self.lit(point.normal));
                let step = if light > 0.7 {
                    1.0
                } else if light > 0.4 {
                    0.65
                } else {
                    0.35
                };
                let away = point.normal.dot(-ray.direction.normalize().as_vec3()).abs() < 0.25;
                point.base * if away { 0.1 } else { step }
            }
            Style::Lines(with) => match point.edges {
                Some((corners, pixel)) if distance_to_edges(corners, point.position) > 0.7 * pixel => return None,
                Some(_) => Vec3::from(*with),
                None => color,
            },
        })
    }
}

/// A point of a surface, as styles need it.
struct Point {
    position: DVec3,
    normal: Vec3,
    /// Its colour without light.
    base: Vec3,
    /// The corners of its triangle, and what a pixel measures there, metres.
    edges: Option<([DVec3; 3], f64)>,
}

/// From a point of a triangle to its nearest edge.
fn distance_to_edges(corners: [DVec3; 3], p: DVec3) -> f64 {
    let edge = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        let along = (b - a).normalize_or_zero();
        ((p - a) - along * (p - a).dot(along)).length()
    };
    edge(0).min(edge(1)).min(edge(2))
}
