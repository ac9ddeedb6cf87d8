//! A scene as it is: how the original is drawn, and stand-ins that are ordinary textured meshes.

use super::{Context, Overdraw, Planes, Shot, Size, StandIn, plane};
use crate::{
    math::{Aabb, Stopped},
    raster::{Geometry, NOTHING, Options, Prepared, Rendering, Shader, fragments_in_tiles, nearest, picture},
    scene::{Alpha, Scene},
    view::View,
};

/// A scene made ready to be drawn.
pub struct Drawn<'a> {
    shader: Shader<'a>,
    bounds: Aabb,
    size: Size,
    blends: bool,
}

impl<'a> Drawn<'a> {
    /// `geometry` is that of `scene`.
    pub fn new(scene: &Scene, geometry: &'a Geometry) -> Self {
        Self::shaded(scene, Shader::new(geometry))
    }

    /// One whose objects of these names show textures that cameras cast on them, see [`Shader::with_projective`].
    pub fn projective(scene: &Scene, geometry: &'a Geometry, named: impl Fn(&str) -> bool) -> Self {
        let object = |o: u32| scene.objects.get(o as usize).is_some_and(|o| named(&o.name));
        Self::shaded(scene, Shader::new(geometry).with_projective(object))
    }

    fn shaded(scene: &Scene, shader: Shader<'a>) -> Self {
        let parts = || scene.objects.iter().flat_map(|o| &o.parts);
        Self {
            shader,
            bounds: scene.bounds(),
            size: Size::of(scene),
            blends: parts().any(|p| p.material.alpha == Alpha::Blend),
        }
    }

    pub fn geometry(&self) -> &'a Geometry {
        self.shader.geometry
    }
}

impl StandIn for Drawn<'_> {
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn size(&self) -> Size {
        self.size
    }

    fn blends(&self) -> bool {
        self.blends
    }

    fn draw(&self, view: &View, how: &Rendering, context: Context) -> Result<Shot<'_>, Stopped> {
        let Context { backend, stop } = context;
        let (geometry, view) = (self.shader.geometry, *view);
        let picture = picture(backend, &self.shader, &view, how, stop)?;
        let seen = nearest(backend, geometry, &view, &Options::default(), stop)?;
        let planes: Planes = Box::new(move |t| plane(&view, geometry.positions(t)));
        Ok(Shot { picture, depth: seen.depth, surface: seen.triangle, planes, drawn: None })
    }

    fn back_facing(&self, view: &View, context: Context) -> Result<u64, Stopped> {
        let Context { backend, stop } = context;
        let geometry = self.shader.geometry;
        if geometry.draws().iter().all(|d| d.material.double_sided) {
            return Ok(0);
        }
        let seen = nearest(backend, geometry, view, &Options::BOTH, stop)?;
        let mut last = (NOTHING, false);
        let back = |t: &&u32| {
            if last.0 != **t {
                let [a, b, c] = geometry.positions(**t);
                let away = (b - a).cross(c - a).dot(a - view.eye) > 0.0;
                last = (**t, away && !geometry.material_of(**t).double_sided);
            }
            last.1
        };
        Ok(seen.triangle.iter().filter(|t| **t != NOTHING).filter(back).count() as u64)
    }

    fn overdraw(&self, view: &View, context: Context) -> Result<Option<Overdraw>, Stopped> {
        let [covered, opaque] = drawn(self.shader.geometry, view, context)?;
        let [_, all] = drawn(&self.shader.geometry.uncut(), view, context)?;
        Ok(Some(Overdraw { covered, opaque, transparent: all - opaque }))
    }
}

/// Pixels that show something, and surfaces at all of their centres.
fn drawn(geometry: &Geometry, view: &View, context: Context) -> Result<[u64; 2], Stopped> {
    let prepared = Prepared::new(geometry, view, &Options::default(), context.stop)?;
    let tiles = fragments_in_tiles(context.backend, &prepared, context.stop, |_, f| {
        let covered = f.offsets.windows(2).filter(|w| w[0] < w[1]).count();
        [covered as u64, f.fragments.len() as u64]
    })?;
    Ok(tiles.into_iter().fold([0; 2], |sum, tile| [sum[0] + tile[0], sum[1] + tile[1]]))
}
