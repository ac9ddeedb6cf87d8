//! Several stand-ins that together stand for one scene, each made by the method that suits its part.

use super::{Context, Drawn, OpenError, Planes, Rendering, Shot, Size, StandIn};
use crate::{
    image::{Picture, srgb},
    math::{Aabb, Stopped},
    raster::NOTHING,
    view::{Projection, View},
};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::{collections::BTreeMap, path::Path};

pub const FORMAT: &str = "farfield mix";
/// Version 2 knows volumes.
pub const VERSION: u32 = 2;
/// The manifest's name in its bundle.
pub const NAME: &str = "mix.json";

/// `mix.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    pub format: String,
    pub version: u32,
    /// All of them are drawn; what is nearest is seen.
    pub parts: Vec<Part>,
}

/// A stand-in of the mix.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// The object or the part of the scene that it stands for.
    pub name: String,
    /// Its main file, below the folder of the manifest.
    pub main: String,
    /// The manifests of depth sprites, below the same folder: what lies inside one is not drawn. Only of parts that are meshes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub clipped_by: Vec<String>,
}

impl Manifest {
    /// The manifest in `data`, whose file is called `file`.
    ///
    /// # Errors
    /// Where it is of another version or not as it should be.
    pub(super) fn read(file: &Path, data: &[u8]) -> Result<Self, OpenError> {
        let unknown = |what: String| OpenError::Unknown { file: file.display().to_string(), what };
        let manifest: Self = serde_json::from_slice(data).map_err(|e| unknown(e.to_string()))?;
        match manifest.version {
            1..=VERSION => Ok(manifest),
            other => Err(unknown(format!("`version` is {other}; expected 1 to {VERSION}"))),
        }
    }
}

/// The stand-ins of a mix, drawn into one picture.
pub struct MixStandIn<'a> {
    pub parts: Vec<Box<dyn StandIn + 'a>>,
}

/// What is nearest at points of a picture.
struct Layer<T> {
    width: usize,
    depth: Vec<f32>,
    seen: Vec<T>,
}

impl<T: Copy> Layer<T> {
    fn new(view: &View, nothing: T) -> Self {
        let count = view.width as usize * view.height as usize;
        Self { width: view.width as usize, depth: vec![f32::INFINITY; count], seen: vec![nothing; count] }
    }

    /// Takes in what a part shows in a window of the picture whose upper left corner is `at`. Of equal depths the first stays.
    fn take(&mut self, at: [u32; 2], window: &View, depth: &[f32], seen: impl Fn(usize) -> T) {
        for (i, z) in depth.iter().enumerate() {
            let (x, y) = (i % window.width as usize, i / window.width as usize);
            let to = (y + at[1] as usize) * self.width + x + at[0] as usize;
            if *z < self.depth[to] {
                (self.depth[to], self.seen[to]) = (*z, seen(i));
            }
        }
    }
}

impl StandIn for MixStandIn<'_> {
    fn bounds(&self) -> Aabb {
        self.parts.iter().map(|p| p.bounds()).fold(Aabb::EMPTY, |a, b| a.union(b))
    }

    fn size(&self) -> Size {
        self.parts.iter().map(|p| p.size()).fold(Size::default(), |a, b| Size {
            triangles: a.triangles + b.triangles,
            draw_calls: a.draw_calls + b.draw_calls,
            texels: a.texels + b.texels,
            memory_bytes: a.memory_bytes + b.memory_bytes,
        })
    }

    fn blends(&self) -> bool {
        self.parts.iter().any(|p| p.blends())
    }

    fn draw(&self, view: &View, how: &Rendering, context: Context) -> Result<Shot<'_>, Stopped> {
        let n = how.samples_per_axis;
        let times = |v: &View| View { width: v.width * n, height: v.height * n, ..*v };
        let single = how.with_samples(1);
        let mut centres = Layer::new(view, (NOTHING, NOTHING));
        let mut samples = Layer::new(&times(view), [0_u8; 4]);
        let mut planes: Vec<Planes> = Vec::new();
        let mut drawn = Drawn::default();
        for part in &self.parts {
            context.stop.check()?;
            let Some((at, window)) = window(view, &part.bounds()) else { continue };
            let shot = part.draw(&window, &single, context)?;
            let number = planes.len() as u32;
            centres.take(at, &window, &shot.depth, |i| (number, shot.surface[i]));
            planes.push(shot.planes);
            let of_part = shot.drawn.unwrap_or_else(|| Drawn { triangles: part.size().triangles, references: 0 });
            drawn.triangles += of_part.triangles;
            drawn.references += of_part.references;
            let fine = times(&window);
            let shot = part.draw(&fine, &single, context)?;
            samples.take(at.map(|a| a * n), &fine, &shot.depth, |i| shot.picture.texels[i]);
        }
        let picture = mean(&samples, view, n as usize, how.background);
        // Surfaces are numbered as they are seen.
        let mut numbers: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        let surface = centres.seen.iter().map(|seen| match seen.1 {
            NOTHING => NOTHING,
            _ => {
                let next = numbers.len() as u32;
                *numbers.entry(*seen).or_insert(next)
            }
        });
        let surface = surface.collect();
        let mut list = vec![(0, 0); numbers.len()];
        numbers.iter().for_each(|(seen, number)| list[*number as usize] = *seen);
        let planes: Planes = Box::new(move |surface| {
            let (part, own) = list[surface as usize];
            planes[part as usize](own)
        });
        Ok(Shot { picture, depth: centres.depth, surface, planes, drawn: Some(drawn) })
    }

    fn back_facing(&self, view: &View, context: Context) -> Result<u64, Stopped> {
        self.parts.iter().map(|p| p.back_facing(view, context)).sum()
    }

    fn saw(&self, point: DVec3) -> bool {
        self.parts.iter().any(|p| p.saw(point))
    }
}

/// The part of a view that shows what lies within `bounds`: its upper left corner in whole pixels, and a view of it. `None` where it shows nothing of
/// that.
fn window(view: &View, bounds: &Aabb) -> Option<([u32; 2], View)> {
    if bounds.is_empty() {
        return None;
    }
    let corner = |k: usize| {
        let pick = |bit: usize, low: f64, high: f64| if k >> bit & 1 == 0 { low } else { high };
        DVec3::new(
            pick(0, bounds.min.x, bounds.max.x),
            pick(1, bounds.min.y, bounds.max.y),
            pick(2, bounds.min.z, bounds.max.z),
        )
    };
    let depths = (0..8).map(|k| (corner(k) - view.eye).dot(view.forward));
    let (near, far) = depths.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| (a.min(z), b.max(z)));
    if far <= 0.0 {
        return None;
    }
    let size = [view.width, view.height];
    let (mut from, mut to) = ([0; 2], size);
    // What reaches behind the eye may be anywhere.
    if near > 0.0 {
        let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for (x, y, _) in (0..8).map(|k| view.project(corner(k))) {
            (min, max) = ([min[0].min(x), min[1].min(y)], [max[0].max(x), max[1].max(y)]);
        }
        for k in 0..2 {
            // A pixel around it, for what is drawn a little beyond its bounds.
            let last = f64::from(size[k]);
            from[k] = (min[k] - 1.0).floor().clamp(0.0, last) as u32;
            to[k] = (max[k] + 1.0).ceil().clamp(0.0, last) as u32;
        }
    }
    if (0..2).any(|k| from[k] >= to[k]) {
        return None;
    }
    let part = |low: f64, high: f64, at: u32, of: u32| low + (high - low) * (f64::from(at) / f64::from(of));
    let cut = |left: f64, right: f64, bottom: f64, top: f64| {
        let [w, h] = size;
        (
            part(left, right, from[0], w),
            part(left, right, to[0], w),
            part(top, bottom, to[1], h),
            part(top, bottom, from[1], h),
        )
    };
    let projection = match view.projection {
        Projection::Perspective { left, right, bottom, top } => {
            let (left, right, bottom, top) = cut(left, right, bottom, top);
            Projection::Perspective { left, right, bottom, top }
        }
        Projection::Orthographic { left, right, bottom, top } => {
            let (left, right, bottom, top) = cut(left, right, bottom, top);
            Projection::Orthographic { left, right, bottom, top }
        }
    };
    Some((from, View { projection, width: to[0] - from[0], height: to[1] - from[1], ..*view }))
}

/// The means of n × n samples in linear light.
fn mean(samples: &Layer<[u8; 4]>, view: &View, n: usize, background: [f32; 3]) -> Picture {
    let background = Vec3::from(background);
    let pixel = |i: usize| {
        let (x, y) = (i % view.width as usize * n, i / view.width as usize * n);
        let mut sum = Vec3::ZERO;
        for at in (0..n * n).map(|k| (y + k / n) * samples.width + x + k % n) {
            sum += match samples.depth[at].is_finite() {
                true => Vec3::from([0, 1, 2].map(|c| srgb::to_linear(samples.seen[at][c]))),
                false => background,
            };
        }
        let [r, g, b] = (sum / (n * n) as f32).to_array().map(srgb::from_linear);
        [r, g, b, 255]
    };
    let texels = (0..view.width as usize * view.height as usize).map(pixel).collect();
    Picture { width: view.width, height: view.height, texels }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        math::Stop,
        raster::{Cpu, Geometry},
        runtime::SceneStandIn,
        scene::{Scene, builtin},
    };

    #[test]
    fn parts_of_a_scene_look_like_the_scene() {
        let whole = builtin::make("car", 1).unwrap();
        let half = |k: usize| Scene { objects: whole.objects.iter().skip(k).step_by(2).cloned().collect() };
        let scenes = [half(0), half(1)];
        let geometries = scenes.each_ref().map(Geometry::new);
        let parts = scenes.iter().zip(&geometries).map(|(s, g)| Box::new(SceneStandIn::new(s, g)) as Box<dyn StandIn>);
        let mix = MixStandIn { parts: parts.collect() };
        let geometry = Geometry::new(&whole);
        let alone = SceneStandIn::new(&whole, &geometry);
        assert_eq!((mix.bounds(), mix.size().triangles), (alone.bounds(), alone.size().triangles));
        let (centre, r) = (whole.bounds().centre(), whole.bounds().diagonal());
        let context = Context { backend: &Cpu, stop: &Stop::default() };
        let how = Rendering::default().with_samples(2);
        for (k, eye) in
            [DVec3::new(0.5, 0.3, 0.9), DVec3::new(-1.2, 0.9, 0.1), DVec3::new(0.1, 0.1, 0.35)].into_iter().enumerate()
        {
            let view =
                View::look_at(centre + eye * r, centre + DVec3::X * 0.1 * r, DVec3::Y, 0.7, 90, 70, r * 0.01, r * 9.0);
            let (a, b) = (mix.draw(&view, &how, context).unwrap(), alone.draw(&view, &how, context).unwrap());
            let same = |i: &usize| a.depth[*i] == b.depth[*i] || (a.depth[*i] - b.depth[*i]).abs() < 1e-5 * b.depth[*i];
            let wrong = (0..a.depth.len()).filter(|i| !same(i)).count();
            assert!(wrong <= 2, "view {k}: {wrong} depths");
            let seen = |i: &usize| b.surface[*i] != NOTHING && same(i);
            for i in (0..a.depth.len()).filter(seen) {
                let (p, q) = ((a.planes)(a.surface[i]), (b.planes)(b.surface[i]));
                assert!(p.distance(q) <= 1e-6 * q.length() || a.depth[i] == b.depth[i], "view {k}, pixel {i}: {p} {q}");
            }
            let off = a.picture.texels.iter().zip(&b.picture.texels);
            let off: u32 = off.map(|(a, b)| (0..3).map(|c| u32::from(a[c].abs_diff(b[c]))).sum::<u32>()).sum();
            assert!(f64::from(off) < 0.6 * a.depth.len() as f64, "view {k}: {off}");
            assert!(a.surface.iter().any(|s| *s != NOTHING));
        }
    }

    #[test]
    fn a_window_shows_what_the_view_shows_there() {
        let view = View::look_at(DVec3::new(3.0, 2.0, 5.0), DVec3::ZERO, DVec3::Y, 0.9, 64, 48, 0.1, 100.0);
        let bounds = Aabb { min: DVec3::new(-0.2, -0.3, 0.0), max: DVec3::new(0.4, 0.5, 0.3) };
        let (at, inner) = window(&view, &bounds).unwrap();
        assert!(inner.width < 30 && inner.height < 30 && at[0] > 0 && at[1] > 0);
        for p in [bounds.min, bounds.max, bounds.centre()] {
            let ((x, y, z), (u, v, w)) = (view.project(p), inner.project(p));
            assert!((u + f64::from(at[0]) - x).abs() < 1e-9 && (v + f64::from(at[1]) - y).abs() < 1e-9 && z == w);
            assert!((0.0..f64::from(inner.width)).contains(&u) && (0.0..f64::from(inner.height)).contains(&v));
        }
        let behind = Aabb { min: view.eye - view.forward * 3.0, max: view.eye - view.forward * 2.0 };
        let behind = Aabb { min: behind.min.min(behind.max), max: behind.min.max(behind.max) };
        assert!(window(&view, &behind).is_none() && window(&view, &Aabb::EMPTY).is_none());
        let around = Aabb { min: view.eye - 1.0, max: view.eye + 1.0 };
        assert_eq!(window(&view, &around).map(|(at, v)| (at, v.width, v.height)), Some(([0, 0], 64, 48)));
    }
}
