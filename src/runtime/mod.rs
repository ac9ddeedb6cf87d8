//! How stand-ins are drawn: the CPU twins of what ships to engines, behind one interface.

mod bundle;
mod cards;
mod clipped;
pub mod dmesh;
pub mod hybrid_lod;
pub mod mix;
pub mod octahedral;
mod open;
pub mod ori;
mod scene;
pub mod size;
mod sprite;
#[cfg(test)]
mod testing;

pub use bundle::{BundleFile, Camera, ShaderFile, shader_files, shader_names};
pub use open::{OpenError, Opened, open};
pub use scene::Drawn as SceneStandIn;
pub use size::Size;
pub use sprite::SpriteStandIn;

use crate::{
    image::Picture,
    math::{Aabb, Stop, Stopped},
    raster::{Backend, Rendering},
    view::View,
};
use glam::DVec3;

/// What drawing works with.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The back end that rasterises.
    pub backend: &'a dyn Backend,
    pub stop: &'a Stop,
}

/// Something that can be looked at in place of an original, by whatever method it was made.
pub trait StandIn: Sync {
    /// Around all that is drawn, metres; empty where nothing is.
    fn bounds(&self) -> Aabb;

    /// What it costs a renderer.
    fn size(&self) -> Size;

    /// Some material blends; it is drawn as a mask at 0.5.
    fn blends(&self) -> bool {
        false
    }

    /// Draws a perspective view.
    fn draw(&self, view: &View, how: &Rendering, context: Context) -> Result<Shot<'_>, Stopped>;

    /// Pixels that would show the back of a single-sided surface if it were drawn.
    fn back_facing(&self, _view: &View, _context: Context) -> Result<u64, Stopped> {
        Ok(0)
    }

    /// How often pixels are drawn over; `None` where that is not counted.
    fn overdraw(&self, _view: &View, _context: Context) -> Result<Option<Overdraw>, Stopped> {
        Ok(None)
    }

    /// Whether the captures that it was made from saw the point of the original's surface (metres). What none of them saw,
    /// no stand-in made of them can show.
    fn saw(&self, _point: DVec3) -> bool {
        true
    }
}

impl<T: StandIn + ?Sized> StandIn for &T {
    fn bounds(&self) -> Aabb {
        (**self).bounds()
    }
    fn size(&self) -> Size {
        (**self).size()
    }
    fn blends(&self) -> bool {
        (**self).blends()
    }
    fn draw(&self, view: &View, how: &Rendering, context: Context) -> Result<Shot<'_>, Stopped> {
        (**self).draw(view, how, context)
    }
    fn back_facing(&self, view: &View, context: Context) -> Result<u64, Stopped> {
        (**self).back_facing(view, context)
    }
    fn overdraw(&self, view: &View, context: Context) -> Result<Option<Overdraw>, Stopped> {
        (**self).overdraw(view, context)
    }
    fn saw(&self, point: DVec3) -> bool {
        (**self).saw(point)
    }
}

/// What one view of a stand-in shows.
pub struct Shot<'a> {
    /// Antialiased as [`Rendering`] asks.
    pub picture: Picture,
    /// At every pixel centre, row by row: planar depth in metres, infinite where there is nothing.
    pub depth: Vec<f32>,
    /// Likewise the number of the surface that is seen; pixels of one number lie in one plane.
    pub surface: Vec<u32>,
    /// The plane of a surface of this view.
    pub planes: Planes<'a>,
    /// What was drawn for this view, where that depends on it.
    pub drawn: Option<Drawn>,
}

/// Planes of surfaces: the k with 1/depth = k·d along the ray direction d = (x, y, 1) in camera axes, by the surface's number. Not
/// finite where the plane holds the eye.
pub type Planes<'a> = Box<dyn Fn(u32) -> DVec3 + Sync + Send + 'a>;

/// How often the pixels of a view are drawn over: what a renderer shades at most, in whatever order it draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Overdraw {
    /// Pixels that show something.
    pub covered: u64,
    /// Surfaces at their centres that pass the alpha test, hidden ones included.
    pub opaque: u64,
    /// Surfaces at any pixel's centre that the alpha test discards.
    pub transparent: u64,
}

/// What was drawn for one view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drawn {
    pub triangles: u64,
    /// Reference views that took part.
    pub references: u32,
}

/// The k of the plane through three points, see [`Planes`].
pub fn plane(view: &View, corners: [DVec3; 3]) -> DVec3 {
    let [a, b, c] = corners.map(|p| {
        let d = p - view.eye;
        DVec3::new(d.dot(view.right), d.dot(view.up), d.dot(view.forward))
    });
    let n = (b - a).cross(c - a);
    n / n.dot(a)
}
