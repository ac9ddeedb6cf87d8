//! From the world to the pixel grid: camera space in f64, snapping to 1/256 px, the guard band.

use crate::view::{Projection, View};
use glam::{DAffine3, DMat3, DVec3, Vec3};

/// Largest width and height of a view, pixels.
pub const MAX_SIDE: u32 = 16384;
/// Fixed-point steps per pixel.
pub(crate) const STEPS: i32 = 256;
/// Extent of the guard band in pixels: snapped coordinates differ by less than 2²³ steps, so that the edge functions
/// of a tile fit 32 bits (see `cover`).
const BAND: f64 = 32760.0;

/// A view prepared for rasterisation: camera space is x right, y up, z planar depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Camera {
    eye: DVec3,
    frame: DMat3,
    pub perspective: bool,
    /// Pixels per unit of x/z (perspective) or x (orthographic), and the pixel position of 0: px = u·scale.0 + origin.0,
    /// py = origin.1 − v·scale.1.
    pub scale: (f64, f64),
    inverse_scale: (f64, f64),
    pub origin: (f64, f64),
    pub near: f64,
    pub far: f64,
    /// The guard band in pixels: least and greatest px, then py.
    pub band: [f64; 4],
}

/// A vertex in camera space with its place on the pixel grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    pub p: DVec3,
    /// In 1/256 px; [`OUTSIDE`] where the vertex lies outside the near or far plane or the guard band.
    pub s: [i32; 2],
}

/// Marks a vertex whose triangles must be clipped.
pub(crate) const OUTSIDE: [i32; 2] = [i32::MIN; 2];

impl Camera {
    /// # Panics
    /// Where the view has more than [`MAX_SIDE`] pixels along a side, or an empty window or depth range:
    /// these are mistakes of the caller.
    pub fn new(view: &View) -> Self {
        let (perspective, l, r, b, t) = match view.projection {
            Projection::Perspective { left, right, bottom, top } => (true, left, right, bottom, top),
            Projection::Orthographic { left, right, bottom, top } => (false, left, right, bottom, top),
        };
        assert!(view.width <= MAX_SIDE && view.height <= MAX_SIDE, "a view has at most {MAX_SIDE} pixels a side");
        assert!(l < r && b < t && view.near < view.far, "a view's window and depth range must not be empty");
        assert!(!perspective || view.near > 0.0, "a perspective view's near plane lies in front of the eye");
        let scale = (view.width as f64 / (r - l), view.height as f64 / (t - b));
        let margin = |side: u32| (BAND - side as f64) * 0.5;
        let (mx, my) = (margin(view.width), margin(view.height));
        Self {
            eye: view.eye,
            frame: DMat3::from_cols(view.right, view.up, view.forward).transpose(),
            perspective,
            scale,
            inverse_scale: (1.0 / scale.0, 1.0 / scale.1),
            origin: (-l * scale.0, t * scale.1),
            near: view.near,
            far: view.far,
            band: [-mx, view.width as f64 + mx, -my, view.height as f64 + my],
        }
    }

    /// Object space to camera space. The eye is subtracted first: far from the origin nothing is lost.
    pub fn object_to_camera(&self, object: &DAffine3) -> DAffine3 {
        DAffine3 { matrix3: self.frame * object.matrix3, translation: self.frame * (object.translation - self.eye) }
    }

    pub fn eye(&self) -> DVec3 {
        self.eye
    }

    pub fn forward(&self) -> DVec3 {
        self.frame.row(2)
    }

    /// The unit direction from a point of the world to the eye.
    pub fn towards(&self, p: DVec3) -> Vec3 {
        let d = if self.perspective { self.eye - p } else { -self.forward() };
        d.try_normalize().unwrap_or(-self.forward()).as_vec3()
    }

    pub fn world_to_camera(&self, p: DVec3) -> DVec3 {
        self.frame * (p - self.eye)
    }

    /// Continuous pixel position of a point of camera space.
    pub fn pixel(&self, p: DVec3) -> (f64, f64) {
        let w = if self.perspective { 1.0 / p.z } else { 1.0 };
        (p.x * w * self.scale.0 + self.origin.0, self.origin.1 - p.y * w * self.scale.1)
    }

    pub fn vertex(&self, p: DVec3) -> Vertex {
        let (x, y) = self.pixel(p);
        let [x0, x1, y0, y1] = self.band;
        // Written so that a NaN counts as outside.
        let inside = p.z >= self.near && p.z <= self.far && x >= x0 && x <= x1 && y >= y0 && y <= y1;
        Vertex { p, s: if inside { [snap(x), snap(y)] } else { OUTSIDE } }
    }

    /// The snapped place of a point that clipping has put inside, up to rounding.
    pub fn snapped(&self, p: DVec3) -> [i32; 2] {
        let (x, y) = self.pixel(p);
        let [x0, x1, y0, y1] = self.band;
        [snap(x.clamp(x0, x1)), snap(y.clamp(y0, y1))]
    }

    /// Coefficients (a, b, c) of the affine function a·px + b·py + c that equals `x·u + y·v + z`, with (u, v) the
    /// camera-space direction (or, orthographic, place) of the pixel position.
    pub fn affine(&self, k: DVec3) -> [f64; 3] {
        let (a, b) = (k.x * self.inverse_scale.0, -k.y * self.inverse_scale.1);
        [a, b, k.z - a * self.origin.0 - b * self.origin.1]
    }
}

/// Rounds pixels to the nearest 1/256, ties to even; |x| < 2²² px.
fn snap(x: f64) -> i32 {
    // Adding 1.5·2⁵² leaves the rounded integer in the low bits of the mantissa.
    const ROUND: f64 = 6755399441055744.0;
    (x * STEPS as f64 + ROUND).to_bits() as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn snapping_rounds_to_the_nearest_step() {
        for (x, expect) in [(0.0, 0), (1.0, 256), (-1.0, -256), (0.5 / 256.0 + 1e-9, 1), (-0.4 / 256.0, 0)] {
            assert_eq!(snap(x), expect, "{x}");
        }
        assert_eq!(snap(16380.25), 16380 * 256 + 64);
        assert_eq!(snap(-8191.75), -(8191 * 256 + 192));
    }

    #[test]
    fn affine_functions_follow_the_pixels() {
        let view = View::look_at(DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO, DVec3::Y, 0.9, 64, 48, 0.1, 100.0);
        let camera = Camera::new(&view);
        let k = DVec3::new(0.3, -0.7, 1.1);
        let [a, b, c] = camera.affine(k);
        for (px, py) in [(0.0, 0.0), (13.5, 7.25), (64.0, 48.0)] {
            let d = camera.world_to_camera(view.unproject(px, py, 1.0));
            assert!((a * px + b * py + c - k.dot(d)).abs() < 1e-12);
            let (x, y) = camera.pixel(d * 3.0);
            assert!((x - px).abs() < 1e-9 && (y - py).abs() < 1e-9);
        }
    }
}
