//! Which pixels original and impostors cover, as bits.

use super::{Field, Ray, Search, Trace, trace};
use crate::{
    math::{Stop, Stopped},
    view::View,
};
use glam::{DVec2, DVec3, Vec3};

/// A bit for each pixel of a picture, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask(pub Vec<u64>);

impl Mask {
    /// Of `pixels` pixels, those of which `covered` is true.
    pub fn new(pixels: usize, covered: impl Fn(usize) -> bool) -> Self {
        let word = |w: usize| {
            let bits = (w * 64..((w + 1) * 64).min(pixels)).filter(|i| covered(*i));
            bits.fold(0_u64, |word, i| word | 1 << (i % 64))
        };
        Self((0..pixels.div_ceil(64)).map(word).collect())
    }

    pub fn empty(pixels: usize) -> Self {
        Self(vec![0; pixels.div_ceil(64)])
    }

    /// Adds what another mask of as many pixels covers.
    pub fn join(&mut self, other: &Self) {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            *a |= b;
        }
    }

    /// Drops what `covered` has and `visible` has not.
    pub fn remove(&mut self, covered: &Self, visible: &Self) {
        for ((a, c), v) in self.0.iter_mut().zip(&covered.0).zip(&visible.0) {
            *a &= !(c & !v);
        }
    }

    pub fn count(&self) -> u64 {
        self.0.iter().map(|w| u64::from(w.count_ones())).sum()
    }

    /// Pixels that this mask covers and `other` does not.
    pub fn beyond(&self, other: &Self) -> u64 {
        self.0.iter().zip(&other.0).map(|(a, b)| u64::from((a & !b).count_ones())).sum()
    }

    pub fn set(&mut self, pixel: usize) {
        self.0[pixel / 64] |= 1 << (pixel % 64);
    }

    pub fn covers(&self, pixel: usize) -> bool {
        self.0.get(pixel / 64).is_some_and(|w| w >> (pixel % 64) & 1 == 1)
    }
}

/// What one map shows in an orthographic view: the pixels whose centre's ray meets its surface.
pub fn of_map(field: &Field, view: &View, how: &Trace, stop: &Stop) -> Result<Mask, Stopped> {
    stop.check()?;
    let (width, height) = (view.width as usize, view.height as usize);
    let rays = Rays::new(field, view);
    let mut mask = Mask::empty(width * height);
    if how.search != Search::Pyramid {
        for i in 0..width * height {
            if trace(field, &rays.of(i % width, i / width), f32::NEG_INFINITY, f32::INFINITY, how).is_some() {
                mask.set(i);
            }
        }
        return Ok(mask);
    }
    // From the cells to the pixels: far fewer tests than along every ray, and the same ones.
    for (cell, [lo, hi]) in field.pyramid.cells() {
        let [x0, x1, y0, y1] = rays.pixels(lo, hi);
        for y in y0..y1 {
            for x in x0..x1 {
                let i = y * width + x;
                if !mask.covers(i) && field.pyramid.meets_cell(field, cell, &rays.of(x, y)) {
                    mask.set(i);
                }
            }
        }
    }
    Ok(mask)
}

/// The rays of an orthographic view in texel units, and the way back.
struct Rays {
    size: [usize; 2],
    /// Origin of the ray through the corner of pixel (0, 0), and the way from pixel to pixel.
    corner: Vec3,
    right: Vec3,
    down: Vec3,
    direction: Vec3,
    /// Pixel of the origin of the texel units, and the pixels of their axes.
    origin: [f32; 2],
    axes: [[f32; 2]; 3],
}

impl Rays {
    fn new(field: &Field, view: &View) -> Self {
        let at = |x: f64, y: f64| view.unproject(x, y, 0.0);
        let ray = field.ray(at(0.0, 0.0), view.forward);
        let step = |p: DVec3| field.ray(at(0.0, 0.0), p - at(0.0, 0.0)).direction;
        let pixel = |p: Vec3| {
            let (x, y, _) = view.project(field.world(p));
            DVec2::new(x, y)
        };
        let origin = pixel(Vec3::ZERO);
        Self {
            size: [view.width as usize, view.height as usize],
            corner: ray.origin,
            right: step(at(1.0, 0.0)),
            down: step(at(0.0, 1.0)),
            direction: ray.direction,
            origin: origin.as_vec2().to_array(),
            axes: [Vec3::X, Vec3::Y, Vec3::Z].map(|a| (pixel(a) - origin).as_vec2().to_array()),
        }
    }

    fn of(&self, x: usize, y: usize) -> Ray {
        let origin = self.corner + self.right * (x as f32 + 0.5) + self.down * (y as f32 + 0.5);
        Ray { origin, direction: self.direction }
    }

    /// Columns and rows of the pixels whose centres a box in texel units may cover, those after the last excluded.
    fn pixels(&self, lo: Vec3, hi: Vec3) -> [usize; 4] {
        let side = |axis: usize| {
            let (mut least, mut most) = (self.origin[axis], self.origin[axis]);
            for k in 0..3 {
                let (a, b) = (self.axes[k][axis] * lo[k], self.axes[k][axis] * hi[k]);
                (least, most) = (least + a.min(b), most + a.max(b));
            }
            // A little more for rounding. Conversions saturate.
            let slack = 0.02;
            let n = self.size[axis];
            (((least - 0.5 - slack).ceil().max(0.0) as usize).min(n), ((most + 0.5 + slack).max(0.0) as usize).min(n))
        };
        let ((x0, x1), (y0, y1)) = (side(0), side(1));
        [x0, x1, y0, y1]
    }
}
