//! A novel view in the frame of the reference camera: what it cannot see, and how large errors look there.

use super::bounds::Sphere;
use crate::view::{Projection, View};
use glam::{DVec3, Vec3};

/// Six planes and a measure of pixels.
pub(super) struct Frustum {
    pub eye: Vec3,
    /// Inward unit normals with offsets, with room for rounding.
    planes: [(Vec3, f32); 6],
    perspective: bool,
    /// Squared pixels per metre, at distance 1 in perspective.
    scale: f32,
}

impl Frustum {
    pub fn new(reference: &View, view: &View) -> Self {
        let turn = |v: DVec3| DVec3::new(v.dot(reference.right), v.dot(reference.up), v.dot(reference.forward));
        let [right, up, forward] = [view.right, view.up, view.forward].map(turn);
        let eye = turn(view.eye - reference.eye);
        let (perspective, [l, r, b, t]) = match view.projection {
            Projection::Perspective { left, right, bottom, top } => (true, [left, right, bottom, top]),
            Projection::Orthographic { left, right, bottom, top } => (false, [left, right, bottom, top]),
        };
        // Points at which `normal · (p − eye) + offset` is positive are inside.
        let side = |axis: DVec3, at: f64| if perspective { (axis - forward * at, 0.0) } else { (axis, -at) };
        let opposite = |(n, d): (DVec3, f64)| (-n, -d);
        let planes = [
            side(right, l),
            opposite(side(right, r)),
            side(up, b),
            opposite(side(up, t)),
            (forward, -view.near),
            (-forward, view.far),
        ];
        let planes = planes.map(|(n, d)| {
            let length = n.length();
            let (n, d) = (n / length, d / length);
            // Rounding of the eye, of far planes and of the dot product.
            (n.as_vec3(), (d - n.dot(eye) + 1e-5 * eye.length()) as f32)
        });
        let scale = (f64::from(view.width) / (r - l)).max(f64::from(view.height) / (t - b));
        Self { eye: eye.as_vec3(), planes, perspective, scale: (scale * scale) as f32 }
    }

    /// No point of the sphere is seen.
    pub fn misses(&self, sphere: &Sphere) -> bool {
        let slack = sphere.radius + 1e-5 * sphere.centre.length();
        sphere.is_empty() || self.planes.iter().any(|(n, d)| n.dot(sphere.centre) + d < -slack)
    }

    /// The squared error that shows as `tau` pixels (f·d/|p − e| = τ, equation 4) from a squared distance, divided by that distance.
    pub fn tolerance(&self, tau: f32) -> f32 {
        tau.max(0.0) * tau.max(0.0) / self.scale
    }

    /// What [`Frustum::tolerance`] gives, at a squared distance.
    #[inline]
    pub fn at(&self, tolerance: f32, distance: f32) -> f32 {
        if self.perspective { tolerance * distance } else { tolerance }
    }
}
