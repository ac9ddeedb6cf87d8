//! An octahedral impostor as a stand-in that certificates can judge.

use super::Model;
use crate::{
    image::{Picture, srgb},
    math::{Aabb, Stopped},
    octahedral::axes,
    raster::{NOTHING, Rendering, Surface},
    runtime::{Context, Drawn, Planes, Shot, Size, StandIn},
    view::{Projection, View},
};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// An impostor, drawn from its atlases alone.
pub struct OctahedralStandIn {
    model: Model,
}

impl OctahedralStandIn {
    pub fn new(model: Model) -> Self {
        Self { model }
    }

    pub fn model(&self) -> &Model {
        &self.model
    }
}

/// A point counts as seen where it lies so near to a frame's surface, in texels.
const NEAR: f64 = 2.0;

impl StandIn for OctahedralStandIn {
    fn bounds(&self) -> Aabb {
        self.model.impostor().bounds
    }

    fn size(&self) -> Size {
        let triangles = self.model.impostor().card.len() as u64 - 2;
        let images = self.model.levels().iter().flat_map(|l| l.images());
        let bytes = 4 * images.map(|i| i.len() as u64).sum::<u64>();
        let texels = self.model.impostor().atlas.images().map(|i| i.len() as u64).sum();
        Size { triangles, draw_calls: 1, texels, memory_bytes: bytes }
    }

    fn draw(&self, view: &View, how: &Rendering, context: Context) -> Result<Shot<'_>, Stopped> {
        let (width, height) = (view.width as usize, view.height as usize);
        let n = how.samples_per_axis as usize;
        let share = 1.0 / (n * n) as f32;
        let background = Vec3::from(how.background);
        let (fine, coarse) = (self.model.seen_by(view, 1.0 / n as f64), self.model.seen_by(view, 1.0));
        let rows: Vec<Vec<([u8; 4], Option<(f64, DVec3)>)>> = (0..height)
            .into_par_iter()
            .map(|y| {
                context.stop.check()?;
                let pixel = |x: usize| {
                    let mut sum = Vec3::ZERO;
                    for k in 0..n * n {
                        let at = |i: usize, k: usize| i as f64 + (k as f64 + 0.5) / n as f64;
                        let (px, py) = (at(x, k % n), at(y, k / n));
                        let hit = fine.at(px, py);
                        sum += hit.map_or(background, |hit| {
                            let position = view.unproject(px, py, hit.depth);
                            let to_eye = match view.projection {
                                Projection::Perspective { .. } => (view.eye - position).normalize_or_zero(),
                                Projection::Orthographic { .. } => -view.forward,
                            };
                            let surface = Surface {
                                position,
                                color: hit.color.extend(1.0).to_array(),
                                normal: hit.normal,
                                emissive: hit.emissive.to_array(),
                                unlit: false,
                                to_eye: to_eye.as_vec3(),
                            };
                            Vec3::from(surface.seen(&how.shading))
                        });
                    }
                    let [r, g, b] = (sum * share).to_array().map(srgb::from_linear);
                    let centre = coarse.at(x as f64 + 0.5, y as f64 + 0.5);
                    ([r, g, b, 255], centre.map(|hit| (hit.depth, hit.normal.as_dvec3())))
                };
                Ok((0..width).map(pixel).collect())
            })
            .collect::<Result<_, Stopped>>()?;
        let pixels: Vec<_> = rows.into_iter().flatten().collect();
        let depth = pixels.iter().map(|p| p.1.map_or(f32::INFINITY, |hit| hit.0 as f32)).collect();
        let surface = (0..).zip(&pixels).map(|(i, p)| if p.1.is_some() { i } else { NOTHING }).collect();
        let picture = Picture { width: view.width, height: view.height, texels: pixels.iter().map(|p| p.0).collect() };
        let drawn = Some(Drawn { triangles: self.size().triangles, references: coarse.frames() as u32 });
        let view = *view;
        // Every pixel is a surface of its own: the plane through what it sees.
        let planes: Planes = Box::new(move |i| {
            let (x, y) = (f64::from(i % view.width) + 0.5, f64::from(i / view.width) + 0.5);
            let Some((z, normal)) = pixels[i as usize].1 else { return DVec3::NAN };
            let p = view.unproject(x, y, z) - view.eye;
            let n = DVec3::new(normal.dot(view.right), normal.dot(view.up), normal.dot(view.forward));
            n / normal.dot(p)
        });
        Ok(Shot { picture, depth, surface, planes, drawn })
    }

    fn saw(&self, point: DVec3) -> bool {
        let impostor = self.model.impostor();
        let (grid, atlas) = (impostor.grid, &impostor.atlas);
        let p = (point - impostor.centre) / impostor.radius;
        // Depths are stored in 255 steps.
        let slack = NEAR * 2.0 / f64::from(impostor.tile) + 1.0 / 255.0;
        (0..grid.side * grid.side).any(|i| {
            let (column, row) = (i % grid.side, i / grid.side);
            let direction = grid.direction(column, row);
            let [right, up] = axes(direction);
            let texels = f64::from(impostor.tile);
            let place = |v: f64| ((v + 1.0) * 0.5 * texels - 0.5).floor();
            let (x0, y0) = (place(p.dot(right)), place(-p.dot(up)));
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                let (x, y) = (x0 + dx, y0 + dy);
                if !((0.0..texels).contains(&x) && (0.0..texels).contains(&y)) {
                    continue;
                }
                let at = (row * impostor.tile + y as u32) as usize * atlas.side as usize
                    + (column * impostor.tile + x as u32) as usize;
                if atlas.color[at][3] > 0 {
                    let height = f64::from(atlas.normal[at][3]) / 127.5 - 1.0;
                    (low, high) = (low.min(height), high.max(height));
                }
            }
            let height = p.dot(direction);
            low - slack <= height && height <= high + slack
        })
    }
}
