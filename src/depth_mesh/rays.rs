//! Positions of grid points in the reference camera's frame: x right, y up, z forward (section 4.1, figure 4).

use crate::view::{Projection, View};
use glam::Vec3;

/// What a view's pixel centres see along. Coordinates are tangents in perspective, metres in orthographic views.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rays {
    pub perspective: bool,
    /// Per column.
    pub x: Vec<f32>,
    /// Per row.
    pub y: Vec<f32>,
    /// Lateral width per unit of coordinate at depth z: `scale·z + offset`.
    scale: f32,
    offset: f32,
    /// The larger side of a pixel, in coordinates.
    pixel: f32,
    /// Height of the window, in coordinates.
    pub window: f32,
    /// No ray leaves the axis by more than 25°.
    pub narrow: bool,
}

impl Rays {
    pub fn new(view: &View) -> Self {
        let (perspective, [left, right, bottom, top]) = match view.projection {
            Projection::Perspective { left, right, bottom, top } => (true, [left, right, bottom, top]),
            Projection::Orthographic { left, right, bottom, top } => (false, [left, right, bottom, top]),
        };
        let (w, h) = (f64::from(view.width), f64::from(view.height));
        let x = (0..view.width).map(|i| (left + (f64::from(i) + 0.5) / w * (right - left)) as f32).collect();
        let y = (0..view.height).map(|j| (top - (f64::from(j) + 0.5) / h * (top - bottom)) as f32).collect();
        let widest = [left, right, bottom, top].into_iter().fold(0.0, |a, b: f64| b.abs().max(a));
        Self {
            perspective,
            x,
            y,
            scale: f32::from(perspective),
            offset: f32::from(!perspective),
            pixel: ((right - left) / w).max((top - bottom) / h) as f32,
            window: (top - bottom) as f32,
            // The tolerance lets a field of view of exactly 50° pass.
            narrow: !perspective || widest <= libm::tan(25f64.to_radians()) * (1.0 + 1e-9),
        }
    }

    /// Metres per unit of coordinate at depth z.
    #[inline]
    pub fn stretch(&self, z: f32) -> f32 {
        self.scale * z + self.offset
    }

    #[inline]
    pub fn position(&self, x: usize, y: usize, z: f32) -> Vec3 {
        let w = self.stretch(z);
        Vec3::new(self.x[x] * w, self.y[y] * w, z)
    }

    /// From the camera to what pixel (x, y) sees, of planar length 1.
    #[inline]
    pub fn direction(&self, x: usize, y: usize) -> Vec3 {
        if self.perspective { Vec3::new(self.x[x], self.y[y], 1.0) } else { Vec3::Z }
    }

    /// The side of a pixel at depth z, metres.
    #[inline]
    pub fn pixel(&self, z: f32) -> f32 {
        self.pixel * self.stretch(z)
    }

    /// Depth halfway between two pixels on the line between their points.
    #[inline]
    pub fn depth_between(&self, a: f32, b: f32) -> f32 {
        if !self.perspective {
            return 0.5 * (a + b);
        }
        let sum = a + b;
        if sum > 0.0 { 2.0 * a * (b / sum) } else { 0.0 }
    }
}
