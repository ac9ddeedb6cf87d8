//! A depth sprite as a stand-in: a solid that rays meet, of one colour.

use super::{Context, Planes, Shot, Size, StandIn};
use crate::{
    formats::{Files, FormatError},
    image::{Picture, srgb},
    math::{Aabb, Stopped},
    raster::{NOTHING, Rendering, Surface},
    sprite::{Entry, Placement, Ray, ReadError, Volume, read},
    view::View,
};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use serde_json::Value;
use std::path::{Component, Path};

/// A solid, drawn from its sprite alone. It has no colour of its own: it is white, as a surface without a material is.
pub struct SpriteStandIn {
    volume: Volume,
    bytes: u64,
}

impl SpriteStandIn {
    /// Reads a sprite by its manifest, which lies at `main`; the data file lies beside it.
    ///
    /// # Errors
    /// Where the data file is missing, or one of both is not as it should be.
    pub fn read(main: &Path, manifest: &Value, files: &dyn Files) -> Result<Self, ReadError> {
        let name = read::data_file(manifest)?;
        let plain = Path::new(name).components().all(|c| matches!(c, Component::Normal(_)));
        if !plain || name.is_empty() {
            return Err(ReadError::new("data.file", format!("`{name}`: expected a path beside the manifest")));
        }
        let path = main.with_file_name(name);
        let data = files.read(&path).map_err(|e| ReadError::new("data.file", e.to_string()))?;
        let missing = || ReadError::new("data.file", FormatError::Missing { file: path.clone() }.to_string());
        let data = data.ok_or_else(missing)?;
        let data: &[u8] = (*data).as_ref();
        let (image, frame) = read::sprite(manifest, data)?;
        Ok(Self { volume: Volume::new(image, &frame, &Placement::default()), bytes: data.len() as u64 })
    }

    pub fn into_volume(self) -> Volume {
        self.volume
    }
}

impl StandIn for SpriteStandIn {
    fn bounds(&self) -> Aabb {
        self.volume.bounds()
    }

    fn size(&self) -> Size {
        Size { triangles: 0, draw_calls: 1, texels: self.bytes / 4, memory_bytes: self.bytes }
    }

    fn draw(&self, view: &View, how: &Rendering, context: Context) -> Result<Shot<'_>, Stopped> {
        let (width, height) = (view.width as usize, view.height as usize);
        let n = how.samples_per_axis as usize;
        let share = 1.0 / (n * n) as f32;
        let background = Vec3::from(how.background);
        let rows: Vec<Vec<([u8; 4], Option<(f64, DVec3)>)>> = (0..height)
            .into_par_iter()
            .map(|y| {
                context.stop.check()?;
                let pixel = |x: usize| {
                    let mut sum = Vec3::ZERO;
                    for k in 0..n * n {
                        let at = |i: usize, k: usize| i as f64 + (k as f64 + 0.5) / n as f64;
                        sum += self.seen(view, at(x, k % n), at(y, k / n), how).unwrap_or(background);
                    }
                    let [r, g, b] = (sum * share).to_array().map(srgb::from_linear);
                    let (ray, centre) = self.meet(view, x as f64 + 0.5, y as f64 + 0.5);
                    let hit = centre.map(|entry| (entry.t, self.volume.normal(&ray, &entry)));
                    ([r, g, b, 255], hit)
                };
                Ok((0..width).map(pixel).collect())
            })
            .collect::<Result<_, Stopped>>()?;
        let pixels: Vec<_> = rows.into_iter().flatten().collect();
        let depth: Vec<f32> = pixels.iter().map(|p| p.1.map_or(f32::INFINITY, |hit| hit.0 as f32)).collect();
        let surface = (0..).zip(&pixels).map(|(i, p)| if p.1.is_some() { i } else { NOTHING }).collect();
        let picture = Picture { width: view.width, height: view.height, texels: pixels.iter().map(|p| p.0).collect() };
        let view = *view;
        // Every pixel is a surface of its own: the plane through what it sees.
        let planes: Planes = Box::new(move |i| {
            let (x, y) = (f64::from(i % view.width) + 0.5, f64::from(i / view.width) + 0.5);
            let Some((z, normal)) = pixels[i as usize].1 else { return DVec3::NAN };
            let p = view.unproject(x, y, z) - view.eye;
            let n = DVec3::new(normal.dot(view.right), normal.dot(view.up), normal.dot(view.forward));
            n / normal.dot(p)
        });
        Ok(Shot { picture, depth, surface, planes, drawn: None })
    }
}

impl SpriteStandIn {
    /// The ray of a pixel position, whose parameter is the planar depth, and where it enters.
    fn meet(&self, view: &View, px: f64, py: f64) -> (Ray, Option<Entry>) {
        let ray = Ray::of_pixel(view, px, py);
        (ray, self.volume.enter(&ray))
    }

    /// Linear colour; `None` where nothing is seen.
    fn seen(&self, view: &View, px: f64, py: f64, how: &Rendering) -> Option<Vec3> {
        let (ray, entry) = self.meet(view, px, py);
        let entry = entry?;
        let surface = Surface {
            position: ray.at(entry.t),
            color: [1.0; 4],
            normal: self.volume.normal(&ray, &entry).as_vec3(),
            emissive: [0.0; 3],
            unlit: false,
            to_eye: (view.eye - ray.at(entry.t)).normalize_or_zero().as_vec3(),
        };
        Some(Vec3::from(surface.seen(&how.shading)))
    }
}
