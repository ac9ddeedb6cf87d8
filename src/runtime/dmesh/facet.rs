//! How a triangle of a reference looks at a pixel position.

use super::{Reference, model::Part};
use crate::{
    raster::{Camera, Coordinates, Layer, Patch, Shading, Surface},
    scene::Wrap,
};
use glam::{DVec3, Vec3};

/// A triangle prepared for one camera.
pub(super) struct Facet<'a> {
    camera: &'a Camera,
    corners: [DVec3; 3],
    /// Unit; of the triangle itself where the vertices have none.
    normals: [Vec3; 3],
    flat: Vec3,
    /// The camera sees its back.
    back: bool,
    quality: [f32; 3],
    patch: Patch,
    /// Of the pictures.
    cast: Patch,
    color: Layer<'a>,
    normal_map: Option<Layer<'a>>,
}

/// Colour and quality of a fragment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Shade {
    /// Linear, shaded.
    pub color: Vec3,
    /// ρ̄, 0 to 1.
    pub quality: f32,
}

impl<'a> Facet<'a> {
    pub fn new(reference: &'a Reference, part: &'a Part, camera: &'a Camera, triangle: u32) -> Self {
        let mesh = &*reference.mesh;
        let indices = mesh.triangles[triangle as usize].map(|i| i as usize);
        let corners = indices.map(|i| Vec3::from(mesh.positions[i]).as_dvec3());
        let patch = Patch::new(camera, corners.map(|p| camera.world_to_camera(p)));
        let coordinates = Coordinates { corners: indices.map(|i| mesh.uv[i].map(f64::from)) };
        // The reference camera cast its picture on the triangle: on large ones, coordinates that were affine would shift it.
        let cast = patch.projective(corners.map(|p| part.texel.dot(p.extend(1.0))));
        let layer = |mips| Layer::new(&cast, coordinates, mips, [Wrap::Clamp; 2], true);
        let [a, b, c] = corners;
        let flat = (b - a).cross(c - a).try_normalize().unwrap_or(-camera.forward());
        let towards = if camera.perspective { a - camera.eye() } else { camera.forward() };
        let normal = |i: usize| mesh.normals.get(i).map_or(flat.as_vec3(), |n| Vec3::from(*n));
        Self {
            camera,
            corners,
            normals: indices.map(normal),
            flat: flat.as_vec3(),
            back: flat.dot(towards) > 0.0,
            quality: indices.map(|i| mesh.quality[i]),
            color: layer(&part.color),
            normal_map: part.normals.as_deref().map(layer),
            patch,
            cast,
        }
    }

    /// At a continuous pixel position.
    pub fn shade(&self, px: f64, py: f64, shading: &Shading) -> Shade {
        let (w, _) = self.patch.weights(px, py);
        let cast = self.cast.weights(px, py);
        let weights = w.map(|w| w as f32);
        let quality = (0..3).map(|k| self.quality[k] * weights[k]).sum::<f32>();
        let color = self.color.sample(cast.0, cast.1);
        let [r, g, b, _] = color;
        let color = match shading {
            Shading::Unlit => [r, g, b],
            Shading::Lit(_) | Shading::Noise(_) => {
                let position = self.corners[0] * w[0] + self.corners[1] * w[1] + self.corners[2] * w[2];
                let normal = self.normal(weights, cast);
                let to_eye = self.camera.towards(position);
                Surface { position, color, normal, to_eye, emissive: [0.0; 3], unlit: false }.seen(shading)
            }
        };
        Shade { color: Vec3::from(color), quality }
    }

    fn normal(&self, weights: [f32; 3], cast: ([f64; 3], f64)) -> Vec3 {
        let mapped = self.normal_map.as_ref().and_then(|map| {
            let [x, y, z, _] = map.sample(cast.0, cast.1);
            (Vec3::new(x, y, z) * 2.0 - 1.0).try_normalize()
        });
        let n = mapped.unwrap_or_else(|| {
            let mean = self.normals[0] * weights[0] + self.normals[1] * weights[1] + self.normals[2] * weights[2];
            mean.try_normalize().unwrap_or(self.flat)
        });
        if self.back { -n } else { n }
    }
}
