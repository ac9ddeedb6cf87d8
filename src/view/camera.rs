//! A view: a camera frame, a projection and a pixel grid.
//!
//! Right-handed; the view looks along `forward`; pixel (0, 0) is the top left one, its centre at (0.5, 0.5).

use glam::DVec3;

/// What a view's pixels subtend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Tangents of the frustum's sides at planar depth 1: `left < right`, `bottom < top`.
    Perspective { left: f64, right: f64, bottom: f64, top: f64 },
    /// Extents in metres.
    Orthographic { left: f64, right: f64, bottom: f64, top: f64 },
}

/// Where a viewer stands and looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Metres.
    pub eye: DVec3,
    /// The aiming vector; any length but 0.
    pub aim: DVec3,
}

/// A camera with its pixel grid. `right`, `up`, `forward` are orthonormal, `right × up = −forward`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    pub eye: DVec3,
    pub right: DVec3,
    pub up: DVec3,
    pub forward: DVec3,
    pub projection: Projection,
    pub width: u32,
    pub height: u32,
    /// Planar depths (metres along `forward`) between which surfaces are kept, `0 < near < far` in perspective.
    pub near: f64,
    pub far: f64,
}

impl View {
    /// A symmetric perspective view from `eye` towards `target`; `fov_y` in radians.
    /// `up` is replaced by another axis where it is parallel to the direction of view.
    pub fn look_at(
        eye: DVec3,
        target: DVec3,
        up: DVec3,
        fov_y: f64,
        width: u32,
        height: u32,
        near: f64,
        far: f64,
    ) -> Self {
        let forward = (target - eye).normalize();
        let up = if forward.cross(up).length_squared() < 1e-12 { DVec3::Z } else { up };
        let right = forward.cross(up).normalize();
        let t = libm::tan(fov_y * 0.5);
        let s = t * width as f64 / height as f64;
        Self {
            eye,
            right,
            up: right.cross(forward),
            forward,
            projection: Projection::Perspective { left: -s, right: s, bottom: -t, top: t },
            width,
            height,
            near,
            far,
        }
    }

    /// (x, y) in pixels (continuous, y down) and planar depth of a world point; perspective needs depth > 0.
    pub fn project(&self, p: DVec3) -> (f64, f64, f64) {
        let d = p - self.eye;
        let (x, y, z) = (d.dot(self.right), d.dot(self.up), d.dot(self.forward));
        let (l, r, b, t, w) = match self.projection {
            Projection::Perspective { left, right, bottom, top } => (left, right, bottom, top, z),
            Projection::Orthographic { left, right, bottom, top } => (left, right, bottom, top, 1.0),
        };
        let px = (x / w - l) / (r - l) * self.width as f64;
        let py = (t - y / w) / (t - b) * self.height as f64;
        (px, py, z)
    }

    /// The world point at continuous pixel position (px, py) and planar depth z. Inverse of [`View::project`].
    pub fn unproject(&self, px: f64, py: f64, z: f64) -> DVec3 {
        let (l, r, b, t, w) = match self.projection {
            Projection::Perspective { left, right, bottom, top } => (left, right, bottom, top, z),
            Projection::Orthographic { left, right, bottom, top } => (left, right, bottom, top, 1.0),
        };
        let x = (l + px / self.width as f64 * (r - l)) * w;
        let y = (t - py / self.height as f64 * (t - b)) * w;
        self.eye + self.right * x + self.up * y + self.forward * z
    }
}
