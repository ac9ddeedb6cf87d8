//! Clipping polygons by planes (Sutherland and Hodgman 1974).
//!
//! A cut point depends only on the edge's two ends, never on the direction in which the polygon runs through it: two
//! triangles that share an edge are cut at the same point, and stay watertight.

use super::camera::Camera;
use glam::{DVec3, DVec4};

/// A convex polygon with at most [`Polygon::CAPACITY`] corners, on the stack.
#[derive(Clone, Copy, Debug)]
pub struct Polygon {
    corners: [DVec3; Self::CAPACITY],
    len: usize,
}

impl Polygon {
    /// A triangle and one more corner for each of nine planes.
    pub const CAPACITY: usize = 12;

    pub fn triangle(corners: [DVec3; 3]) -> Self {
        let mut all = [DVec3::ZERO; Self::CAPACITY];
        all[..3].copy_from_slice(&corners);
        Self { corners: all, len: 3 }
    }

    pub fn corners(&self) -> &[DVec3] {
        &self.corners[..self.len]
    }

    /// What lies where `distance` ≥ 0. `distance` is affine in the point.
    ///
    /// # Panics
    /// Where more than nine planes have cut the polygon.
    pub fn clip(&mut self, distance: impl Fn(DVec3) -> f64) {
        let old = *self;
        self.len = 0;
        for (i, &b) in old.corners().iter().enumerate() {
            let a = old.corners[(i + old.len - 1) % old.len];
            let (da, db) = (distance(a), distance(b));
            if da >= 0.0 && db < 0.0 {
                self.push(cut(a, da, b, db));
            }
            if db >= 0.0 {
                if da < 0.0 {
                    self.push(cut(b, db, a, da));
                }
                self.push(b);
            }
        }
        if self.len < 3 {
            self.len = 0;
        }
    }

    fn push(&mut self, p: DVec3) {
        self.corners[self.len] = p;
        self.len += 1;
    }
}

/// The point at distance 0 between an inner and an outer point; always computed from the inner one.
fn cut(inner: DVec3, di: f64, outer: DVec3, d_o: f64) -> DVec3 {
    inner + (outer - inner) * (di / (di - d_o))
}

/// A triangle of camera space cut by the near and far planes and the guard band.
pub(crate) fn clip_to_view(corners: [DVec3; 3], camera: &Camera) -> Polygon {
    let mut polygon = Polygon::triangle(corners);
    if !corners.iter().all(|p| p.is_finite()) {
        polygon.len = 0;
        return polygon;
    }
    let planes = planes(camera);
    // Most triangles outside lie beyond one plane entirely.
    if planes.iter().any(|k| corners.iter().all(|p| distance(k, *p) < 0.0)) {
        polygon.len = 0;
        return polygon;
    }
    for k in &planes {
        polygon.clip(|p| distance(k, p));
        if polygon.len == 0 {
            break;
        }
    }
    polygon
}

fn distance(k: &DVec4, p: DVec3) -> f64 {
    k.truncate().dot(p) + k.w
}

/// Near first: the others are exact only in front of the eye. An infinite far plane cuts nothing.
fn planes(camera: &Camera) -> [DVec4; 6] {
    let [x0, x1, y0, y1] = camera.band;
    let u = |px: f64| (px - camera.origin.0) / camera.scale.0;
    let v = |py: f64| (camera.origin.1 - py) / camera.scale.1;
    // On the band's side u: x − u·z ≥ 0 in perspective, x − u ≥ 0 otherwise.
    let side = |x: f64, y: f64, at: f64| match camera.perspective {
        true => DVec4::new(x, y, -at, 0.0),
        false => DVec4::new(x, y, 0.0, -at),
    };
    let far = if camera.far.is_finite() { DVec4::new(0.0, 0.0, -1.0, camera.far) } else { DVec4::W };
    [
        DVec4::new(0.0, 0.0, 1.0, -camera.near),
        far,
        side(1.0, 0.0, u(x0)),
        side(-1.0, 0.0, -u(x1)),
        side(0.0, -1.0, -v(y0)),
        side(0.0, 1.0, v(y1)),
    ]
}
