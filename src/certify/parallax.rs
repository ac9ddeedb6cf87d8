//! Depth errors as angles: how far apart two points of one viewing ray are, seen from elsewhere in the region.
//!
//! From the eye V itself both points fall on one pixel. From another point C of the region they are separated by the
//! angle between P_near − C and P_far − C; the largest one over the region's extremes (the eight corners of a cell) is what a depth error shows as.
//! With d the ray's direction and w = V − C, sin α = (z_far − z_near)·|d × w| / (|z_near·d + w|·|z_far·d + w|).

use crate::view::{Projection, Region, View};
use glam::DVec3;

/// The rays of a view's pixels and the region that they are judged from.
#[derive(Clone, Debug)]
pub struct Parallax {
    /// V − C for each extreme C, in camera axes (right, up, forward).
    offsets: Vec<DVec3>,
    /// The longest of them.
    reach: f64,
    width: usize,
    /// Direction of pixel (x, y): (`left` + (x + ½)·`step`, `top` − (y + ½)·`step`, 1).
    left: f64,
    top: f64,
    step: [f64; 2],
}

/// An angle as its sine; angles of a right angle and more are never within one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angle(f64);

impl Angle {
    /// From radians in [0, π/2].
    pub fn new(radians: f64) -> Self {
        Self(libm::sin(radians.clamp(0.0, std::f64::consts::FRAC_PI_2)))
    }
}

impl Parallax {
    /// `view` is a perspective one: certificates have no others.
    pub fn new(view: &View, region: &Region) -> Self {
        let offset = |corner: DVec3| {
            let w = view.eye - corner;
            DVec3::new(w.dot(view.right), w.dot(view.up), w.dot(view.forward))
        };
        let offsets: Vec<DVec3> = region.extremes().into_iter().map(offset).collect();
        let (Projection::Perspective { left, right, bottom, top }
        | Projection::Orthographic { left, right, bottom, top }) = view.projection;
        Self {
            reach: offsets.iter().map(|w| w.length()).fold(0.0, f64::max),
            offsets,
            width: view.width as usize,
            left,
            top,
            step: [(right - left) / f64::from(view.width), (top - bottom) / f64::from(view.height)],
        }
    }

    /// The direction (x, y, 1) in camera axes of the centre of pixel `i`, counted row by row.
    #[inline]
    pub fn ray(&self, i: usize) -> DVec3 {
        let (x, y) = (i % self.width, i / self.width);
        DVec3::new(self.left + (x as f64 + 0.5) * self.step[0], self.top - (y as f64 + 0.5) * self.step[1], 1.0)
    }

    /// True where a point at planar depth `far` on the ray of pixel `i` lies behind one at depth `near` by more than
    /// `angle`. Infinite depths mean nothing: nothing lies behind everything.
    #[inline]
    pub fn deeper(&self, i: usize, near: f32, far: f32, angle: Angle) -> bool {
        far > near && (far == f32::INFINITY || self.separated(self.ray(i), f64::from(near), f64::from(far), angle))
    }

    fn separated(&self, d: DVec3, near: f64, far: f64, angle: Angle) -> bool {
        let length = d.length();
        // At most this much seen from any corner: |d × w| ≤ |d||w| and |z·d + w| ≥ z|d| − |w|.
        let closest = near * length - self.reach;
        if closest > 0.0 && (far - near) * length * self.reach <= angle.0 * closest * (far * length - self.reach) {
            return false;
        }
        self.offsets.iter().any(|w| {
            let (p, q) = (d * near + *w, d * far + *w);
            let across = (far - near) * (far - near) * d.cross(*w).length_squared();
            p.dot(q) < 0.0 || across > angle.0 * angle.0 * p.length_squared() * q.length_squared()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::Cell;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_quick_test_agrees_with_measured_angles(
            eye in prop::array::uniform3(-1.0_f64..1.0),
            near in 0.5_f32..60.0,
            gap in 0.0_f32..20.0,
            pixel in 0_usize..64 * 64,
            limit in 0.0005_f64..0.5,
        ) {
            let cell = Cell { centre: DVec3::ZERO, half: DVec3::ONE };
            let eye = DVec3::from(eye);
            let view = View::look_at(eye, eye + DVec3::new(0.3, -0.2, -1.0), DVec3::Y, 0.9, 64, 64, 0.1, 100.0);
            let far = near + gap;
            let (x, y) = ((pixel % 64) as f64 + 0.5, (pixel / 64) as f64 + 0.5);
            let (p, q) = (view.unproject(x, y, near.into()), view.unproject(x, y, far.into()));
            let most = cell
                .corners()
                .iter()
                .map(|c| (p - *c).angle_between(q - *c))
                .fold(0.0, f64::max);
            prop_assume!((most - limit).abs() > 1e-6);
            let deeper = Parallax::new(&view, &Region::Box(cell)).deeper(pixel, near, far, Angle::new(limit));
            prop_assert_eq!(deeper, most > limit, "{} {}", most, limit);
        }
    }

    #[test]
    fn nothing_lies_behind_everything() {
        let cell = Cell { centre: DVec3::ZERO, half: DVec3::ONE };
        let view = View::look_at(DVec3::ZERO, -DVec3::Z, DVec3::Y, 0.9, 8, 8, 0.1, 100.0);
        let (p, angle) = (Parallax::new(&view, &Region::Box(cell)), Angle::new(0.1));
        assert!(p.deeper(3, 5.0, f32::INFINITY, angle));
        assert!(!p.deeper(3, f32::INFINITY, f32::INFINITY, angle));
        assert!(!p.deeper(3, f32::INFINITY, 5.0, angle));
    }
}
