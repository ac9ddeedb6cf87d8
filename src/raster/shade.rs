//! Deferred shading: how a triangle looks at a pixel position.

use super::{
    Geometry, Light, Noise,
    camera::Camera,
    geometry::{Cutout, Draw},
    patch::Patch,
    texture::{Coordinates, Mips, Role},
};
use crate::{
    scene::{Image, Mesh, Texture, Wrap},
    view::View,
};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::{collections::BTreeMap, sync::Arc};

/// Turns triangle numbers into colour. Holds the mip chains of the textures that are needed, made up front.
pub struct Shader<'a> {
    pub geometry: &'a Geometry,
    /// One for each draw.
    looks: Vec<Look>,
    finishes: bool,
    /// Of each draw, whether its texture was cast on it by a camera. Empty: none.
    cast: Vec<bool>,
}

struct Look {
    base: Option<Arc<Mips>>,
    normal: Option<Arc<Mips>>,
    emissive: Option<Arc<Mips>>,
    metallic_roughness: Option<Arc<Mips>>,
    occlusion: Option<Arc<Mips>>,
}

/// What a material does with light, beside its colour and normal; all linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finish {
    /// Share of ambient light that arrives, 0 to 1.
    pub occlusion: f32,
    pub roughness: f32,
    pub metallic: f32,
    pub emissive: [f32; 3],
}

/// How surfaces become colours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Shading {
    /// The base colour as it is.
    #[default]
    Unlit,
    /// Base colour under a sun and a sky, plus what the surface emits. Materials that say they are unlit stay so.
    Lit(Light),
    /// Base colour times a noise of the surface point, for scenes without colour. Materials' `unlit` is ignored.
    Noise(Noise),
}

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// World space, metres.
    pub position: DVec3,
    /// Linear: base colour factor × texture × vertex colour. Alpha is not yet compared with a cutoff.
    pub color: [f32; 4],
    /// Unit, world space, with the normal map; flipped where the triangle is seen from behind.
    pub normal: Vec3,
    /// Unit, towards the eye.
    pub to_eye: Vec3,
    /// Linear.
    pub emissive: [f32; 3],
    /// The material wants no light.
    pub unlit: bool,
}

impl Surface {
    /// Linear colour after shading.
    pub fn seen(&self, shading: &Shading) -> [f32; 3] {
        let [r, g, b, _] = self.color;
        match shading {
            Shading::Lit(light) if !self.unlit => {
                let (on, c) = (light.on(self.normal), [r, g, b]);
                let lit = std::array::from_fn(|k| c[k] * on[k] + self.emissive[k]);
                match light.gloss {
                    Some(_) => light.with_highlight(lit, self.normal, self.to_eye),
                    None => lit,
                }
            }
            Shading::Noise(noise) => {
                let n = noise.at(self.position);
                [r * n, g * n, b * n]
            }
            _ => [r, g, b],
        }
    }
}

impl<'a> Shader<'a> {
    pub fn new(geometry: &'a Geometry) -> Self {
        Self::make(geometry, false)
    }

    /// One that can tell [`Shader::finish`] too.
    pub fn with_finishes(geometry: &'a Geometry) -> Self {
        Self::make(geometry, true)
    }

    /// For these objects (indices into [`crate::scene::Scene::objects`]) the base colour's coordinates are projective: they were cast by a camera, from
    /// which each corner has the depth that is the first number of its second texture coordinates. u·d, v·d and d are interpolated and divided. Parts where one of the depths
    /// is not above 0 keep affine coordinates.
    pub fn with_projective(mut self, object: impl Fn(u32) -> bool) -> Self {
        self.cast = self.geometry.draws().iter().map(|d| object(d.object) && has_depths(&d.mesh)).collect();
        self
    }

    /// Whether [`Shader::finish`] tells something.
    pub fn has_finishes(&self) -> bool {
        self.finishes
    }

    fn make(geometry: &'a Geometry, finishes: bool) -> Self {
        // Each image once for each role, numbered in the order of first use.
        let mut number = BTreeMap::new();
        let mut wanted: Vec<(&'a Image, Role)> = Vec::new();
        let mut want = |texture: &'a Option<Texture>, role: Role| {
            let image = &**texture.as_ref().map(|t| &t.image)?;
            Some(*number.entry((std::ptr::from_ref(image), role)).or_insert_with(|| {
                wanted.push((image, role));
                wanted.len() - 1
            }))
        };
        let numbers: Vec<_> = geometry
            .draws()
            .iter()
            .map(|d| {
                let base = if d.cutout == Cutout::Solid { Role::Color } else { Role::CutoutColor };
                let m = &*d.material;
                [
                    want(&m.base_color_texture, base),
                    want(&m.normal_texture, Role::Data),
                    want(&m.emissive_texture, Role::Color),
                    if finishes { want(&m.metallic_roughness_texture, Role::Data) } else { None },
                    if finishes { want(&m.occlusion_texture, Role::Data) } else { None },
                ]
            })
            .collect();
        let mips: Vec<_> = wanted.par_iter().map(|(image, role)| Arc::new(Mips::new(image, *role))).collect();
        let get = |i: Option<usize>| i.map(|i| mips[i].clone());
        let looks = numbers.iter().map(|n| Look {
            base: get(n[0]),
            normal: get(n[1]),
            emissive: get(n[2]),
            metallic_roughness: get(n[3]),
            occlusion: get(n[4]),
        });
        Self { geometry, looks: looks.collect(), finishes, cast: Vec::new() }
    }

    /// What the material does with light where [`Shader::shade`] has its surface; `None` for a shader made by [`Shader::new`].
    pub fn finish(&self, view: &View, px: f64, py: f64, triangle: u32) -> Option<Finish> {
        self.finishes.then(|| self.facet(&Camera::new(view), triangle).finish(px, py))
    }

    /// The point of a triangle's plane at a continuous pixel position of `view`. Textures are filtered over the pixel's
    /// footprint, from the ray through (px, py) to those one pixel to the right and below.
    pub fn shade(&self, view: &View, px: f64, py: f64, triangle: u32) -> Surface {
        self.facet(&Camera::new(view), triangle).surface(px, py)
    }

    /// For many pixel positions of one triangle.
    pub(crate) fn facet(&self, camera: &Camera, triangle: u32) -> Facet<'_> {
        let index = self.geometry.draw_index(triangle);
        let draw = &self.geometry.draws()[index];
        let local = triangle - draw.first;
        let indices = draw.mesh.triangles[local as usize];
        let corners = draw.corners(local);
        let patch = Patch::new(camera, corners.map(|p| camera.world_to_camera(p)));
        let look = &self.looks[index];
        let colors = (!draw.mesh.colors.is_empty()).then(|| indices.map(|i| draw.mesh.colors[i as usize]));
        let depths = self.cast.get(index).is_some_and(|cast| *cast);
        let depths = depths.then(|| indices.map(|i| f64::from(draw.mesh.uv[1][i as usize][0])));
        let cast = depths.map_or(patch, |d| patch.projective(d));
        let base = Layer::of(&cast, draw, indices, &draw.material.base_color_texture, &look.base);
        Facet { draw, look, camera: *camera, indices, corners, patch, colors, base, depths }
    }
}

/// A triangle prepared for shading in one view.
pub(crate) struct Facet<'a> {
    draw: &'a Draw,
    look: &'a Look,
    camera: Camera,
    indices: [u32; 3],
    /// World space, in the order of the mesh's indices.
    corners: [DVec3; 3],
    patch: Patch,
    colors: Option<[[f32; 4]; 3]>,
    base: Option<Layer<'a>>,
    /// Of the corners, from the camera that cast `base`.
    depths: Option<[f64; 3]>,
}

/// Whether the second texture coordinates can be depths.
fn has_depths(mesh: &Mesh) -> bool {
    mesh.uv[1].len() == mesh.positions.len() && mesh.uv[1].iter().all(|d| d[0] > 0.0 && d[0].is_finite())
}

/// One texture of a facet.
pub(crate) struct Layer<'a> {
    wrap: [Wrap; 2],
    smooth: bool,
    mips: &'a Mips,
    coordinates: Coordinates,
    /// Change of Σ fᵢ·uᵢ, Σ fᵢ·vᵢ and Σ fᵢ (see [`Patch`]) from pixel to pixel, in texels for the first two.
    slopes: [[f64; 2]; 3],
}

impl<'a> Layer<'a> {
    fn of(
        patch: &Patch,
        draw: &Draw,
        indices: [u32; 3],
        texture: &Option<Texture>,
        mips: &'a Option<Arc<Mips>>,
    ) -> Option<Self> {
        let (texture, mips) = (texture.as_ref()?, mips.as_deref()?);
        let coordinates = Coordinates::new(texture, &draw.mesh, indices);
        Some(Self::new(patch, coordinates, mips, texture.wrap, texture.smooth))
    }

    pub fn new(patch: &Patch, coordinates: Coordinates, mips: &'a Mips, wrap: [Wrap; 2], smooth: bool) -> Self {
        let along = |k: usize| patch.slope(coordinates.corners.map(|c| c[k]));
        Self { wrap, smooth, mips, coordinates, slopes: [along(0), along(1), patch.slope([1.0; 3])] }
    }

    /// Linear RGBA at barycentric coordinates `w`, filtered over the footprint; `inverse` as [`Patch::weights`] gives it.
    pub fn sample(&self, w: [f64; 3], inverse: f64) -> [f32; 4] {
        let uv = self.coordinates.at(w);
        let [du, dv, d1] = self.slopes;
        let size = self.mips.size();
        // u = U/F, so its change is (dU − u·dF)/F.
        let length = |k: usize| {
            let x = (du[k] - uv[0] * d1[k]) * inverse * size[0];
            let y = (dv[k] - uv[1] * d1[k]) * inverse * size[1];
            x * x + y * y
        };
        let footprint = length(0).max(length(1)) as f32;
        self.mips.sample(uv, footprint, self.wrap, self.smooth)
    }
}

impl Facet<'_> {
    pub fn surface(&self, px: f64, py: f64) -> Surface {
        let (w, inverse) = self.patch.weights(px, py);
        self.surface_at(w, inverse)
    }

    /// The point with barycentric coordinates `w` (in the order of the mesh's indices), textures unfiltered: for
    /// triangles seen edge-on, whose footprint has no bound.
    pub fn point(&self, w: [f64; 3]) -> Surface {
        self.surface_at(w, 0.0)
    }

    fn surface_at(&self, w: [f64; 3], inverse: f64) -> Surface {
        let position = self.position_at(w);
        Surface {
            position,
            to_eye: self.camera.towards(position),
            color: self.color_at(w, inverse),
            normal: self.normal_at(w, inverse),
            emissive: self.emissive_at(w, inverse),
            unlit: self.draw.material.unlit,
        }
    }

    /// Linear colour as seen at a pixel position.
    pub fn seen(&self, px: f64, py: f64, shading: &Shading) -> [f32; 3] {
        match shading {
            Shading::Lit(_) if !self.draw.material.unlit => self.surface(px, py).seen(shading),
            Shading::Noise(noise) => {
                let (w, inverse) = self.patch.weights(px, py);
                let ([r, g, b, _], n) = (self.color_at(w, inverse), noise.at(self.position_at(w)));
                [r * n, g * n, b * n]
            }
            _ => {
                let (w, inverse) = self.patch.weights(px, py);
                let [r, g, b, _] = self.color_at(w, inverse);
                [r, g, b]
            }
        }
    }

    /// `w` and `inverse` as [`Patch::projective`] of the depths would give them.
    #[inline]
    fn cast(&self, w: [f64; 3], inverse: f64) -> ([f64; 3], f64) {
        let Some(d) = self.depths else { return (w, inverse) };
        let w: [f64; 3] = std::array::from_fn(|k| w[k] * d[k]);
        let over = 1.0 / (w[0] + w[1] + w[2]);
        (w.map(|w| w * over), inverse * over)
    }

    fn position_at(&self, w: [f64; 3]) -> DVec3 {
        self.corners[0] * w[0] + self.corners[1] * w[1] + self.corners[2] * w[2]
    }

    fn color_at(&self, w: [f64; 3], inverse: f64) -> [f32; 4] {
        let mut c = self.draw.material.base_color;
        if let Some(layer) = &self.base {
            let (w, inverse) = self.cast(w, inverse);
            let t = layer.sample(w, inverse);
            c = std::array::from_fn(|k| c[k] * t[k]);
        }
        if let Some(v) = &self.colors {
            let w = w.map(|w| w as f32);
            c = std::array::from_fn(|k| c[k] * (v[0][k] * w[0] + v[1][k] * w[1] + v[2][k] * w[2]));
        }
        c
    }

    fn emissive_at(&self, w: [f64; 3], inverse: f64) -> [f32; 3] {
        let m = &self.draw.material;
        match Layer::of(&self.patch, self.draw, self.indices, &m.emissive_texture, &self.look.emissive) {
            Some(layer) => {
                let t = layer.sample(w, inverse);
                std::array::from_fn(|k| m.emissive[k] * t[k])
            }
            None => m.emissive,
        }
    }

    fn finish(&self, px: f64, py: f64) -> Finish {
        let (w, inverse) = self.patch.weights(px, py);
        let (m, look) = (&*self.draw.material, self.look);
        let sample = |texture, mips| {
            let layer = Layer::of(&self.patch, self.draw, self.indices, texture, mips);
            layer.map_or([1.0; 4], |layer| layer.sample(w, inverse))
        };
        let [_, roughness, metallic, _] = sample(&m.metallic_roughness_texture, &look.metallic_roughness);
        let [occlusion, ..] = sample(&m.occlusion_texture, &look.occlusion);
        Finish {
            occlusion: 1.0 + m.occlusion_strength * (occlusion - 1.0),
            roughness: m.roughness * roughness,
            metallic: m.metallic * metallic,
            emissive: self.emissive_at(w, inverse),
        }
    }

    fn normal_at(&self, w: [f64; 3], inverse: f64) -> Vec3 {
        let [a, b, c] = self.corners;
        let flat = (b - a).cross(c - a) * if self.draw.mirrored { -1.0 } else { 1.0 };
        let flat = flat.try_normalize().unwrap_or(-self.camera.forward());
        let towards = if self.camera.perspective { a - self.camera.eye() } else { self.camera.forward() };
        let back = flat.dot(towards) > 0.0;
        let mesh = &self.draw.mesh;
        let smooth = (!mesh.normals.is_empty()).then(|| {
            let n = self.indices.map(|i| Vec3::from(mesh.normals[i as usize]).as_dvec3());
            self.draw.normals * (n[0] * w[0] + n[1] * w[1] + n[2] * w[2])
        });
        // A mirrored transform turns neither the inverse transpose's normals nor the flat normal as defined above.
        let smooth = smooth.and_then(DVec3::try_normalize).unwrap_or(flat);
        let n = self.bent(smooth, w, inverse).unwrap_or(smooth);
        (if back { -n } else { n }).as_vec3()
    }

    /// The normal with the normal map; `None` where there is none, or no direction for it.
    fn bent(&self, n: DVec3, w: [f64; 3], inverse: f64) -> Option<DVec3> {
        let m = &self.draw.material;
        let layer = Layer::of(&self.patch, self.draw, self.indices, &m.normal_texture, &self.look.normal)?;
        let t = layer.sample(w, inverse);
        let [x, y] = [t[0], t[1]].map(|c| ((c * 2.0 - 1.0) * m.normal_scale) as f64);
        let z = (t[2] * 2.0 - 1.0) as f64;
        let mesh = &self.draw.mesh;
        let (tangent, bitangent) = if mesh.tangents.is_empty() {
            self.tangents_from_coordinates(&layer.coordinates)?
        } else {
            let corner = self.indices.map(|i| mesh.tangents[i as usize]);
            let mean = |k: usize| corner[0][k] as f64 * w[0] + corner[1][k] as f64 * w[1] + corner[2][k] as f64 * w[2];
            let tangent = self.draw.to_world.matrix3 * DVec3::new(mean(0), mean(1), mean(2));
            let hand = if (mean(3) < 0.0) != self.draw.mirrored { -1.0 } else { 1.0 };
            let tangent = (tangent - n * n.dot(tangent)).try_normalize()?;
            (tangent, n.cross(tangent) * hand)
        };
        (tangent * x + bitangent * y + n * z).try_normalize()
    }

    /// Unit directions on the surface in which u grows and v falls: a normal map's green points up in its image.
    fn tangents_from_coordinates(&self, c: &Coordinates) -> Option<(DVec3, DVec3)> {
        let [p, uv] = [self.corners, c.corners.map(|c| DVec3::new(c[0], c[1], 0.0))];
        let (e1, e2, d1, d2) = (p[1] - p[0], p[2] - p[0], uv[1] - uv[0], uv[2] - uv[0]);
        let sign = (d1.x * d2.y - d2.x * d1.y).signum();
        let tangent = (e1 * d2.y - e2 * d1.y) * sign;
        let up = (e1 * d2.x - e2 * d1.x) * sign;
        Some((tangent.try_normalize()?, up.try_normalize()?))
    }
}
