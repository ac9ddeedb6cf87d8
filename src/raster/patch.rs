//! A triangle's barycentric coordinates as functions of the pixel position, and the test of its alpha.

use super::{
    Geometry, Prepared,
    camera::Camera,
    geometry::Cutout,
    texture::{AlphaMap, Coordinates},
};
use glam::DVec3;

/// Three affine functions of the pixel position whose ratios are the barycentric coordinates of the point that the
/// pixel's ray meets on the triangle's plane: perspective-correct, because they are ratios of volumes in camera space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    functions: [[f64; 3]; 3],
}

impl Patch {
    /// `p`: the corners in camera space.
    pub fn new(camera: &Camera, p: [DVec3; 3]) -> Self {
        let opposite = |b: DVec3, c: DVec3| match camera.perspective {
            true => b.cross(c),
            false => DVec3::new(b.y - c.y, c.x - b.x, b.x * c.y - b.y * c.x),
        };
        let [a, b, c] = p;
        Self { functions: [opposite(b, c), opposite(c, a), opposite(a, b)].map(|k| camera.affine(k)) }
    }

    /// The barycentric coordinates at a pixel position and 1/sum of the three functions there. A point outside the triangle
    /// (a sample on a snapped edge, or a plane seen edge-on) is clamped to it.
    #[inline]
    pub fn weights(&self, px: f64, py: f64) -> ([f64; 3], f64) {
        let f = self.functions.map(|[a, b, c]| a * px + (b * py + c));
        let inverse = 1.0 / (f[0] + f[1] + f[2]);
        let w = f.map(|f| f * inverse);
        if w[0] >= 0.0 && w[1] >= 0.0 && w[2] >= 0.0 {
            return (w, inverse);
        }
        let w = w.map(|w| w.clamp(0.0, 1.0));
        let sum = w[0] + w[1] + w[2];
        // Not finite where the triangle has no area as seen from the eye.
        if sum > 0.0 { (w.map(|w| w / sum), inverse) } else { ([1.0 / 3.0; 3], inverse) }
    }

    /// For values that are ratios of affine functions on the triangle, such as the coordinates of a picture that a camera has cast on
    /// it; `denominators`: of those ratios, at the corners.
    pub fn projective(&self, denominators: [f64; 3]) -> Self {
        let f = &self.functions;
        Self { functions: std::array::from_fn(|i| f[i].map(|c| c * denominators[i])) }
    }

    /// Change of Σ fᵢ·valueᵢ from pixel to pixel in x and in y.
    pub fn slope(&self, value: [f64; 3]) -> [f64; 2] {
        let f = &self.functions;
        [0, 1].map(|k| f[0][k] * value[0] + f[1][k] * value[1] + f[2][k] * value[2])
    }
}

/// Tells for masked triangles which points are there. Remembers the last triangle.
pub(crate) struct Holes<'a> {
    geometry: &'a Geometry,
    camera: Camera,
    last: Option<Last<'a>>,
}

struct Last<'a> {
    triangle: u32,
    cutoff: f32,
    patch: Patch,
    texture: Option<(Coordinates, AlphaMap<'a>)>,
    /// Material alpha times vertex alpha, at the corners.
    alpha: [f32; 3],
}

impl<'a> Holes<'a> {
    pub fn new(prepared: &'a Prepared<'a>) -> Self {
        Self::seen_by(prepared.geometry, prepared.camera)
    }

    /// For pixel positions of `camera`.
    pub fn seen_by(geometry: &'a Geometry, camera: Camera) -> Self {
        Self { geometry, camera, last: None }
    }

    /// Whether the triangle's alpha at a pixel position reaches its cutoff.
    pub fn solid(&mut self, triangle: u32, px: f64, py: f64) -> bool {
        let last = self.get(triangle);
        last.solid(last.patch.weights(px, py).0)
    }

    /// The same at barycentric coordinates, in the order of the mesh's indices.
    pub fn solid_at(&mut self, triangle: u32, weights: [f64; 3]) -> bool {
        self.get(triangle).solid(weights)
    }

    fn get(&mut self, triangle: u32) -> &Last<'a> {
        if self.last.as_ref().is_some_and(|last| last.triangle != triangle) {
            self.last = None;
        }
        self.last.get_or_insert_with(|| Last::new(self.geometry, &self.camera, triangle))
    }
}

impl<'a> Last<'a> {
    fn new(geometry: &'a Geometry, camera: &Camera, triangle: u32) -> Self {
        let draw = geometry.draw_of(triangle);
        let local = triangle - draw.first;
        let corners = draw.corners(local).map(|p| camera.world_to_camera(p));
        let factor = draw.material.base_color[3];
        let indices = draw.mesh.triangles[local as usize];
        let texture = draw.material.base_color_texture.as_ref();
        Self {
            triangle,
            cutoff: match draw.cutout {
                Cutout::Masked(cutoff) => cutoff,
                Cutout::Solid => f32::NEG_INFINITY,
                Cutout::Hidden => f32::INFINITY,
            },
            patch: Patch::new(camera, corners),
            texture: texture.map(|t| (Coordinates::new(t, &draw.mesh, indices), AlphaMap::new(t))),
            alpha: indices.map(|i| factor * draw.mesh.colors.get(i as usize).map_or(1.0, |c| c[3])),
        }
    }

    fn solid(&self, w: [f64; 3]) -> bool {
        let mut alpha =
            (self.alpha[0] as f64 * w[0] + self.alpha[1] as f64 * w[1] + self.alpha[2] as f64 * w[2]) as f32;
        if let Some((coordinates, map)) = &self.texture {
            alpha *= map.at(coordinates.at(w));
        }
        alpha >= self.cutoff
    }
}
