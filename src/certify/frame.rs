//! The part of a view that is worth rendering.
//!
//! Beside the scenes' bounds both pictures show the background and nothing differs; only a window around them is
//! rendered and measured, and figures over the whole picture count the rest as equal.

use crate::{
    math::Aabb,
    view::{Projection, View},
};

/// Pixels around the bounds that belong to the window: what the filters of SSIM and FLIP reach (5 and about 20), and
/// what the dilations do.
const MARGIN: f64 = 32.0;

/// A view and its window.
#[derive(Clone, Copy, Debug)]
pub struct CropWindow {
    /// The part that is rendered: the same camera and pixels, cut out.
    pub window: View,
    /// Pixels of the whole picture.
    pub pixels: f64,
}

impl CropWindow {
    /// The window of `view` (a perspective one) around everything in `bounds`; the whole view where some of it lies beside
    /// or behind the eye.
    pub fn around(view: &View, bounds: &Aabb, bound_px: f64) -> Self {
        let size = [view.width, view.height];
        let (mut lo, mut hi) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in bounds.corners() {
            let (x, y, z) = view.project(p);
            if z < view.near * 0.5 {
                (lo, hi) = ([0.0; 2], [f64::from(size[0]), f64::from(size[1])]);
                break;
            }
            (lo, hi) = ([lo[0].min(x), lo[1].min(y)], [hi[0].max(x), hi[1].max(y)]);
        }
        let margin = MARGIN + bound_px.ceil();
        let range = |k: usize| {
            let n = f64::from(size[k]);
            let first = (lo[k] - margin).floor().clamp(0.0, n - 1.0);
            let last = (hi[k] + margin).ceil().clamp(first + 1.0, n);
            (first, last)
        };
        let ((x0, x1), (y0, y1)) = (range(0), range(1));
        let window = match view.projection {
            Projection::Perspective { left, right, bottom, top } => {
                let (sx, sy) = ((right - left) / f64::from(size[0]), (top - bottom) / f64::from(size[1]));
                let projection = Projection::Perspective {
                    left: left + x0 * sx,
                    right: left + x1 * sx,
                    bottom: top - y1 * sy,
                    top: top - y0 * sy,
                };
                View { projection, width: (x1 - x0) as u32, height: (y1 - y0) as u32, ..*view }
            }
            Projection::Orthographic { .. } => *view,
        };
        Self { window, pixels: f64::from(size[0]) * f64::from(size[1]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn the_window_cuts_out_the_same_pixels() {
        let view = View::look_at(DVec3::ZERO, DVec3::new(0.1, 0.0, -1.0), DVec3::Y, 0.8, 512, 512, 0.5, 50.0);
        let bounds = Aabb { min: DVec3::new(0.0, -1.0, -22.0), max: DVec3::new(4.0, 1.0, -20.0) };
        let frame = CropWindow::around(&view, &bounds, 2.5);
        assert!(frame.pixels == 512.0 * 512.0 && frame.window.width < 300 && frame.window.height < 200);
        let ((x, y, _), (u, v, _)) = (view.project(bounds.min), frame.window.project(bounds.min));
        // The window's first pixel in the whole picture.
        let origin = [(x - u).round(), (y - v).round()];
        for p in bounds.corners() {
            let ((x, y, z), (u, v, w)) = (view.project(p), frame.window.project(p));
            assert!((x - u - origin[0]).abs() < 1e-9 && (y - v - origin[1]).abs() < 1e-9);
            assert!(z == w && u >= 34.0 && v >= 34.0);
            assert!(u <= f64::from(frame.window.width) - 34.0 && v <= f64::from(frame.window.height) - 34.0);
        }
    }

    #[test]
    fn what_surrounds_the_eye_takes_the_whole_view() {
        let view = View::look_at(DVec3::ZERO, -DVec3::Z, DVec3::Y, 0.8, 64, 64, 0.1, 50.0);
        let frame = CropWindow::around(&view, &Aabb { min: DVec3::splat(-5.0), max: DVec3::splat(5.0) }, 2.5);
        assert_eq!(frame.window, view);
    }
}
