//! A stand-in of which depth sprites hide what lies inside them (Trapp and Döllner 2008, section 3.3): clipping against several volumes in one pass over the
//! geometry.

use super::{Context, Shot, Size, StandIn};
use crate::{
    math::{Aabb, Stop, Stopped},
    raster::{Backend, Fragment, NOTHING, OnFragments, OnNearest, Prepared, Rendering, TileFragments},
    sprite::Volume,
    view::View,
};
use glam::DVec3;

/// A stand-in that is rasterised, without what lies in the volumes. The cut stays open: what is behind shows.
pub struct Clipped<'a> {
    pub stand_in: Box<dyn StandIn + 'a>,
    pub volumes: &'a [Volume],
    /// Of the sprites in memory.
    pub bytes: u64,
}

impl Clipped<'_> {
    fn clipping<'b>(&'b self, context: Context<'b>) -> Clipping<'b> {
        Clipping { inner: context.backend, volumes: self.volumes }
    }
}

impl StandIn for Clipped<'_> {
    fn bounds(&self) -> Aabb {
        self.stand_in.bounds()
    }

    fn size(&self) -> Size {
        let size = self.stand_in.size();
        Size { texels: size.texels + self.bytes / 4, memory_bytes: size.memory_bytes + self.bytes, ..size }
    }

    fn blends(&self) -> bool {
        self.stand_in.blends()
    }

    fn draw(&self, view: &View, how: &Rendering, context: Context) -> Result<Shot<'_>, Stopped> {
        self.stand_in.draw(view, how, Context { backend: &self.clipping(context), ..context })
    }

    fn back_facing(&self, view: &View, context: Context) -> Result<u64, Stopped> {
        self.stand_in.back_facing(view, Context { backend: &self.clipping(context), ..context })
    }

    fn saw(&self, point: DVec3) -> bool {
        self.stand_in.saw(point)
    }
}

/// A back end that passes over fragments inside volumes.
struct Clipping<'a> {
    inner: &'a dyn Backend,
    volumes: &'a [Volume],
}

impl Clipping<'_> {
    /// Whether a fragment at the centre of a pixel of the view is there.
    fn shows(&self, view: &View, [x, y]: [u32; 2], fragment: &Fragment) -> bool {
        let p = view.unproject(f64::from(x) + 0.5, f64::from(y) + 0.5, f64::from(fragment.depth));
        !self.volumes.iter().any(|v| v.contains(p))
    }
}

impl Backend for Clipping<'_> {
    fn nearest(&self, prepared: &Prepared, stop: &Stop, tile: &OnNearest) -> Result<(), Stopped> {
        self.inner.fragments(prepared, stop, &|index, fragments| {
            let place = prepared.tile(index);
            let first =
                |i: usize| fragments.of(i).iter().find(|f| self.shows(&prepared.view, place.pixel(i).into(), f));
            let (depth, triangle): (Vec<f32>, Vec<u32>) = (0..place.pixels())
                .map(|i| first(i).map_or((f32::INFINITY, NOTHING), |f| (f.depth, f.triangle)))
                .unzip();
            tile(index, &depth, &triangle);
        })
    }

    fn fragments(&self, prepared: &Prepared, stop: &Stop, tile: &OnFragments) -> Result<(), Stopped> {
        self.inner.fragments(prepared, stop, &|index, fragments| {
            let place = prepared.tile(index);
            let mut left = TileFragments::default();
            left.offsets.push(0);
            for i in 0..place.pixels() {
                let shown = fragments.of(i).iter().filter(|f| self.shows(&prepared.view, place.pixel(i).into(), f));
                left.fragments.extend(shown);
                left.offsets.push(left.fragments.len() as u32);
            }
            tile(index, &left);
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        raster::{Cpu, Geometry},
        runtime::SceneStandIn,
        scene::{builtin, clip::cut_box},
        sprite::{Direction, Peeled, Peeling, Placement, Repair, peel},
    };

    /// The sprite of a box clips as the box that is cut out of the mesh does, but for what a texel of the sprite measures.
    #[test]
    fn a_sprite_clips_as_a_cut_through_the_mesh() {
        let car = builtin::make("car", 1).unwrap();
        let bounds = car.bounds();
        let cut = Aabb { min: bounds.centre() + DVec3::new(-0.33, 0.11, -9.0), max: bounds.max + 0.7 };
        let solid = builtin::closed_box(&cut);
        let direction = Direction::new(DVec3::NEG_Z).unwrap();
        let how = Peeling { resolution: 512, samples: 1, repair: Repair::None };
        let Peeled { image, frame, .. } =
            peel(&Cpu, &Geometry::new(&solid), &direction, &how, &Stop::default()).unwrap();
        let volumes = [Volume::new(image, &frame, &Placement::default())];
        let exact = cut_box(&car, &cut);
        let (geometry, exact_geometry) = (Geometry::new(&car), Geometry::new(&exact));
        let drawn = Clipped { stand_in: Box::new(SceneStandIn::new(&car, &geometry)), volumes: &volumes, bytes: 64 };
        let uncut = SceneStandIn::new(&car, &geometry);
        let expect = SceneStandIn::new(&exact, &exact_geometry);
        let context = Context { backend: &Cpu, stop: &Stop::default() };
        let r = bounds.diagonal();
        for eye in [DVec3::new(0.7, 0.5, 0.9), DVec3::new(-0.6, 0.8, -0.9), DVec3::new(0.9, 0.2, -0.1)] {
            let view =
                View::look_at(bounds.centre() + eye * r, bounds.centre(), DVec3::Y, 0.8, 200, 150, r * 0.01, r * 9.0);
            let how = Rendering::default().with_samples(1);
            let (a, b) = (drawn.draw(&view, &how, context).unwrap(), expect.draw(&view, &how, context).unwrap());
            let whole = uncut.draw(&view, &how, context).unwrap();
            let differ =
                |a: &[f32], b: &[f32]| a.iter().zip(b).filter(|(a, b)| !(a == b || (*a - *b).abs() < 1e-3)).count();
            let (wrong, cut_away) = (differ(&a.depth, &b.depth), differ(&whole.depth, &b.depth));
            assert!(cut_away > 500, "{cut_away} pixels are cut");
            assert!(wrong * 25 < cut_away, "{wrong} of {cut_away}");
            let colours = a.picture.texels.iter().zip(&b.picture.texels).filter(|(a, b)| a != b).count();
            assert!(colours * 10 < cut_away, "{colours} of {cut_away}");
        }
    }
}
