//! Many instances of relief impostors in one picture.

use super::{
    draw::{EDGE, Eye, Seen},
    model::Model,
    picture::{Scope, paint},
};
use crate::{
    image::Picture,
    math::{Stop, Stopped},
    raster::{NOTHING, Rendering},
    view::{Projection, View},
};
use glam::{DQuat, DVec3, Vec3};
use rayon::prelude::*;

/// Where an impostor stands: its points are scaled, then rotated, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Number of its model.
    pub model: u32,
    /// Of length 1.
    pub rotation: DQuat,
    /// More than 0.
    pub scale: f64,
    /// Metres.
    pub translation: DVec3,
}

impl Default for Instance {
    /// The first model where it is.
    fn default() -> Self {
        Self { model: 0, rotation: DQuat::IDENTITY, scale: 1.0, translation: DVec3::ZERO }
    }
}

impl Instance {
    /// A point of the impostor's own space in the world.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.translation + self.rotation * (p * self.scale)
    }

    /// A view of the world in the impostor's own space: planar depths there are those of the world divided by the scale.
    pub fn view(&self, view: &View) -> View {
        let back = self.rotation.inverse();
        let s = 1.0 / self.scale;
        let projection = match view.projection {
            Projection::Orthographic { left, right, bottom, top } => {
                Projection::Orthographic { left: left * s, right: right * s, bottom: bottom * s, top: top * s }
            }
            perspective @ Projection::Perspective { .. } => perspective,
        };
        View {
            eye: back * (view.eye - self.translation) * s,
            right: back * view.right,
            up: back * view.up,
            forward: back * view.forward,
            projection,
            near: view.near * s,
            far: view.far * s,
            ..*view
        }
    }
}

/// What a view of instances shows.
pub struct DrawnInstances {
    pub picture: Picture,
    /// At every pixel centre, row by row: planar depth in metres, infinite where there is nothing.
    pub depth: Vec<f32>,
    /// Likewise the unit normal of the surface without its normal map, world space; zero where there is nothing.
    pub normal: Vec<Vec3>,
    /// Likewise the number of the instance; [`NOTHING`] where there is none.
    pub instance: Vec<u32>,
    /// Maps that were drawn, of all instances together.
    pub maps: u32,
}

/// Draws a view of many instances; the nearest surface wins, of equally near ones that of the first instance. Within an instance, maps are chosen as
/// its model says. Pixels are sampled as [`draw`](super::draw) samples them. An instance whose model there is not is not drawn.
pub fn draw_instances(
    models: &[&Model],
    instances: &[Instance],
    view: &View,
    how: &Rendering,
    stop: &Stop,
) -> Result<DrawnInstances, Stopped> {
    let crowd = Crowd::new(models, instances, view, stop)?;
    let (centres, picture) = paint(&crowd, view, how, stop)?;
    Ok(DrawnInstances {
        picture,
        depth: centres.iter().map(|s| s.as_ref().map_or(f32::INFINITY, |s| s.depth as f32)).collect(),
        normal: centres.iter().map(|s| s.as_ref().map_or(Vec3::ZERO, |s| crowd.face(s))).collect(),
        maps: crowd.placed.iter().map(|p| p.selected.len() as u32).sum(),
        instance: centres.iter().map(|s| s.as_ref().map_or(NOTHING, |s| crowd.placed[s.placed].number)).collect(),
    })
}

/// Side of a tile, pixels.
const TILE: u32 = 16;

/// An instance in a view.
struct Placed<'a> {
    number: u32,
    model: &'a Model,
    place: Instance,
    /// In the impostor's own space.
    view: View,
    selected: Vec<u32>,
    /// No surface is nearer: planar depth, metres.
    near: f64,
    /// Columns and rows of the tiles that it may cover, those after the last excluded.
    tiles: [u32; 4],
}

/// What a ray sees.
#[derive(Clone, Copy)]
struct Found {
    /// Number among the placed instances.
    placed: usize,
    seen: Seen,
    /// Planar depth, metres.
    depth: f64,
}

/// All instances that a view may show, the nearest first.
struct Crowd<'a> {
    placed: Vec<Placed<'a>>,
    columns: u32,
    /// Numbers of the placed instances of each tile, row by row.
    tiles: Vec<Vec<u32>>,
}

impl<'a> Crowd<'a> {
    fn new(models: &[&'a Model], instances: &[Instance], view: &View, stop: &Stop) -> Result<Self, Stopped> {
        let placed = (0..instances.len()).into_par_iter().map(|i| {
            stop.check()?;
            let place = instances[i];
            Ok(models.get(place.model as usize).and_then(|model| Placed::new(i as u32, model, place, view)))
        });
        let mut placed: Vec<Placed> = placed.collect::<Result<Vec<_>, Stopped>>()?.into_iter().flatten().collect();
        placed.sort_by(|a, b| a.near.total_cmp(&b.near).then(a.number.cmp(&b.number)));
        let (columns, rows) = (view.width.div_ceil(TILE), view.height.div_ceil(TILE));
        let mut tiles = vec![Vec::new(); columns as usize * rows as usize];
        for (i, p) in (0..).zip(&placed) {
            let [x0, y0, x1, y1] = p.tiles;
            for (x, y) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))) {
                tiles[(y * columns + x) as usize].push(i);
            }
        }
        Ok(Self { placed, columns, tiles })
    }

    /// The normal of the height field, world space.
    fn face(&self, seen: &Found) -> Vec3 {
        let placed = &self.placed[seen.placed];
        placed.place.rotation.as_quat() * placed.eye().face(&seen.seen)
    }
}

impl<'a> Placed<'a> {
    /// `None` where the view cannot show it.
    fn new(number: u32, model: &'a Model, place: Instance, view: &View) -> Option<Self> {
        let local = place.view(view);
        let corners = model.reach().corners().map(|p| local.project(p));
        let near = corners.iter().map(|c| c.2).fold(f64::INFINITY, f64::min);
        let far = corners.iter().map(|c| c.2).fold(f64::NEG_INFINITY, f64::max);
        if !(near <= local.far && far >= local.near) {
            return None;
        }
        let size = [view.width, view.height];
        let all = size.map(|n| n.div_ceil(TILE));
        let mut tiles = [0, 0, all[0], all[1]];
        // Points behind the eye have no place in a perspective picture.
        if matches!(view.projection, Projection::Orthographic { .. }) || near >= local.near {
            for axis in 0..2 {
                let at = |c: &(f64, f64, f64)| if axis == 0 { c.0 } else { c.1 };
                let least = corners.iter().map(at).fold(f64::INFINITY, f64::min);
                let most = corners.iter().map(at).fold(f64::NEG_INFINITY, f64::max);
                if !(least < f64::from(size[axis]) && most > 0.0) {
                    return None;
                }
                // Conversions saturate.
                let tile = |v: f64| (v / f64::from(TILE)) as u32;
                tiles[axis] = tile(least.floor());
                tiles[axis + 2] = tile(most.ceil()).saturating_add(1).min(all[axis]);
            }
        }
        let selected = model.select(&local);
        Some(Self { number, model, place, view: local, selected, near: near * place.scale, tiles })
    }

    fn eye(&self) -> Eye<'_> {
        Eye::of_instance(self.model, &self.view, &self.selected, self.place)
    }
}

impl Scope for Crowd<'_> {
    type Seen = Found;

    fn see(&self, px: f64, py: f64) -> Option<Found> {
        let tile = py as u32 / TILE * self.columns + px as u32 / TILE;
        let mut found: Option<Found> = None;
        for i in &self.tiles[tile as usize] {
            let placed = &self.placed[*i as usize];
            if found.is_some_and(|f| placed.near > f.depth) {
                break;
            }
            let Some(seen) = placed.eye().see(px, py) else { continue };
            let depth = seen.depth * placed.place.scale;
            let nearer =
                |f: &Found| depth < f.depth || depth == f.depth && placed.number < self.placed[f.placed].number;
            if found.as_ref().is_none_or(nearer) {
                found = Some(Found { placed: *i as usize, seen, depth });
            }
        }
        found
    }

    fn apart(&self, own: &Found, other: &Found) -> bool {
        let placed = &self.placed[own.placed];
        let pixel = placed.eye().footprint(own.seen.depth) * placed.place.scale;
        (own.depth - other.depth).abs() > pixel * EDGE
    }

    fn color(&self, seen: &Found, how: &Rendering) -> Vec3 {
        self.placed[seen.placed].eye().color(&seen.seen, how)
    }
}

#[cfg(test)]
mod tests {
    use super::{
        super::{
            draw,
            sample::{impostor, usual},
        },
        *,
    };
    use crate::{relief::DepthBits, scene::builtin};

    fn models() -> [Model; 2] {
        ["solids", "car"].map(|name| impostor(&builtin::make(name, 1).unwrap(), 48, DepthBits::Eight, usual(), false))
    }

    fn view() -> View {
        View::look_at(DVec3::new(2.0, 4.0, 8.0), DVec3::new(0.0, 0.0, -2.0), DVec3::Y, 0.9, 90, 70, 0.1, 40.0)
    }

    fn orthographic() -> View {
        View { projection: Projection::Orthographic { left: -5.0, right: 5.0, bottom: -4.0, top: 4.0 }, ..view() }
    }

    fn crowd() -> Vec<Instance> {
        let instance = |i: u32| Instance {
            model: i % 3,
            rotation: DQuat::from_rotation_y(f64::from(i) * 1.7) * DQuat::from_rotation_z(0.2),
            scale: 0.5 + 0.2 * f64::from(i % 4),
            translation: DVec3::new(f64::from(i % 4) * 2.2 - 3.0, 0.0, f64::from(i / 4) * -2.5 + 6.0),
        };
        (0..16).map(instance).collect()
    }

    #[test]
    fn one_instance_is_the_impostor_itself() {
        let [_, model] = models();
        for view in [view(), orthographic()] {
            let how = Rendering::default().with_samples(2);
            let alone = draw(&model, &view, &how, &Stop::default()).unwrap();
            let placed = draw_instances(&[&model], &[Instance::default()], &view, &how, &Stop::default()).unwrap();
            assert!(alone.depth.iter().any(|z| z.is_finite()));
            assert_eq!((alone.picture, alone.depth), (placed.picture, placed.depth));
        }
    }

    /// Tiles and order leave nothing out: the same as the nearest of all instances drawn one by one.
    #[test]
    fn the_nearest_of_all_instances_is_seen() {
        let models = models();
        let (models, instances) = ([&models[0], &models[1]], crowd());
        let how = Rendering::default().with_samples(1);
        // One looks from between the instances.
        let among =
            View { eye: DVec3::new(0.5, 0.4, 2.0), forward: -DVec3::Z, right: DVec3::X, up: DVec3::Y, ..view() };
        for view in [view(), orthographic(), among] {
            let all = draw_instances(&models, &instances, &view, &how, &Stop::default()).unwrap();
            let mut nearest = vec![(f32::INFINITY, NOTHING); all.depth.len()];
            for (i, instance) in (0..).zip(&instances) {
                // There are two models; instances of a third are not drawn.
                let Some(model) = models.get(instance.model as usize) else { continue };
                let alone = draw(model, &instance.view(&view), &how, &Stop::default()).unwrap();
                for (near, z) in nearest.iter_mut().zip(&alone.depth) {
                    let z = (f64::from(*z) * instance.scale) as f32;
                    if z < near.0 {
                        *near = (z, i);
                    }
                }
            }
            let seen = all.instance.iter().filter(|i| **i != NOTHING).count();
            let kinds: std::collections::BTreeSet<u32> = all.instance.iter().copied().collect();
            assert!(seen > 1000 && kinds.len() > 2, "{seen} pixels of {} instances", kinds.len());
            for (i, (z, number)) in nearest.into_iter().enumerate() {
                assert!((z - all.depth[i]).abs() <= 1e-5 * z || z == all.depth[i], "{z} {}", all.depth[i]);
                assert_eq!(number, all.instance[i]);
            }
        }
    }

    #[test]
    fn turned_instances_are_lit_as_they_stand() {
        let [model, _] = models();
        let place = Instance { rotation: DQuat::from_rotation_z(std::f64::consts::PI), ..Instance::default() };
        let bounds = model.reach();
        // From above: what is turned upside down gets its light on the other side.
        let eye = place.point(bounds.centre()) + DVec3::new(0.1, 6.0, 0.2);
        let view = View::look_at(eye, place.point(bounds.centre()), DVec3::Y, 0.8, 60, 60, 0.1, 20.0);
        let light = crate::raster::Light { sun: [0.0; 3], ground: [0.0; 3], sky: [1.0; 3], ..Default::default() };
        let how = |shading| Rendering { shading, ..Rendering::default() }.with_samples(1);
        let drawn = |shading| {
            draw_instances(&[&model], &[place], &view, &how(shading), &Stop::default()).unwrap().picture.texels
        };
        let (lit, unlit) = (drawn(crate::raster::Shading::Lit(light)), drawn(crate::raster::Shading::Unlit));
        // Surfaces that face up are about as bright as without light.
        let near = |(a, b): (&[u8; 4], &[u8; 4])| (0..3).all(|k| b[k].saturating_sub(a[k]) < 40);
        let bright = lit.iter().zip(&unlit).filter(|pair| near(*pair)).count();
        assert!(bright * 10 > lit.len() * 8, "{bright} of {}", lit.len());
    }
}
