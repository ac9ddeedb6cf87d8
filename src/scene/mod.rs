//! Scenes: named objects that place shared meshes with shared materials.
//!
//! What always holds: indices of a mesh lie inside its arrays; attribute arrays are empty or as long as the
//! positions; every object's mesh, material and image numbers exist; object names are unique and the objects
//! are sorted by name, so that equal scenes have equal bytes. All coordinates are finite.

pub mod builtin;
pub mod clip;
#[cfg(test)]
mod clip_tests;
pub mod names;
pub mod select;
pub mod split;
pub mod tables;

use crate::{array::Array, math::Aabb};
use glam::{DVec3, Mat4, Vec3};
use std::{collections::BTreeMap, sync::Arc};

/// A scene. Objects share meshes, materials and images through `Arc`s.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    pub objects: Vec<Object>,
}

/// A named object: one or more mesh parts at one place.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Stable name: the node path in its file, duplicates with a content-hash suffix.
    pub name: String,
    /// Object to world, affine, metres.
    pub transform: Mat4,
    pub parts: Vec<Part>,
}

/// Triangles with one material.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    pub mesh: Arc<Mesh>,
    pub material: Arc<Material>,
}

/// An indexed triangle mesh in object space. Empty attribute arrays mean "absent".
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Metres, finite.
    pub positions: Array<[f32; 3]>,
    /// Unit length.
    pub normals: Array<[f32; 3]>,
    /// xyz unit, w the handedness (±1), as in glTF.
    pub tangents: Array<[f32; 4]>,
    /// Two sets of texture coordinates, v down, as in glTF.
    pub uv: [Array<[f32; 2]>; 2],
    /// Linear RGBA in [0, 1], multiplied with the material's base colour.
    pub colors: Array<[f32; 4]>,
    /// Counter-clockwise seen from the front.
    pub triangles: Array<[u32; 3]>,
}

/// How a surface looks; the metallic-roughness material of glTF 2.0.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    pub name: String,
    /// Linear RGBA factor.
    pub base_color: [f32; 4],
    pub base_color_texture: Option<Texture>,
    pub metallic: f32,
    pub roughness: f32,
    pub metallic_roughness_texture: Option<Texture>,
    pub normal_scale: f32,
    pub normal_texture: Option<Texture>,
    /// Linear RGB factor.
    pub emissive: [f32; 3],
    pub emissive_texture: Option<Texture>,
    /// How much of the occlusion that its texture tells counts, 0 to 1.
    pub occlusion_strength: f32,
    /// Red: the share of ambient light that arrives.
    pub occlusion_texture: Option<Texture>,
    pub alpha: Alpha,
    /// False: only the front is there.
    pub double_sided: bool,
    /// KHR_materials_unlit.
    pub unlit: bool,
}

/// Both sides are shown: what formats without a say in it mean.
impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [1.0; 4],
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_scale: 1.0,
            normal_texture: None,
            emissive: [0.0; 3],
            emissive_texture: None,
            occlusion_strength: 1.0,
            occlusion_texture: None,
            alpha: Alpha::Opaque,
            double_sided: true,
            unlit: false,
        }
    }
}

/// glTF's alpha modes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alpha {
    Opaque,
    /// Texels below the cutoff are holes.
    Mask {
        cutoff: f32,
    },
    /// Counts as a mask at 0.5 in farfield's rasteriser.
    Blend,
}

/// An image with its sampling.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    pub image: Arc<Image>,
    /// 0 or 1: which of the mesh's coordinate sets.
    pub uv_set: u8,
    /// KHR_texture_transform: offset, rotation (radians), scale.
    pub offset: [f32; 2],
    pub rotation: f32,
    pub scale: [f32; 2],
    pub wrap: [Wrap; 2],
    /// False for `NEAREST` magnification.
    pub smooth: bool,
}

impl Texture {
    /// An image by the first set of coordinates as it is, smooth, its border going on beyond it.
    pub fn clamped(image: Arc<Image>) -> Self {
        Self {
            image,
            uv_set: 0,
            offset: [0.0; 2],
            rotation: 0.0,
            scale: [1.0; 2],
            wrap: [Wrap::Clamp; 2],
            smooth: true,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    Repeat,
    Mirror,
    Clamp,
}

/// Decoded 8-bit RGBA, row by row from the top; sRGB-encoded where it holds colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    pub name: String,
    pub width: u32,
    pub height: u32,
    /// `width * height` texels.
    pub texels: Array<[u8; 4]>,
}

impl Object {
    /// Bounds in world space, over the vertices that faces use.
    pub fn bounds(&self) -> Aabb {
        let mut b = Aabb::EMPTY;
        let transform = self.transform.as_dmat4();
        for part in &self.parts {
            for i in part.mesh.triangles.iter().flatten() {
                let p = Vec3::from(part.mesh.positions[*i as usize]);
                b.add(transform.transform_point3(p.as_dvec3()));
            }
        }
        b
    }

    pub fn triangle_count(&self) -> usize {
        self.parts.iter().map(|p| p.mesh.triangles.len()).sum()
    }
}

impl Scene {
    pub fn bounds(&self) -> Aabb {
        self.objects.iter().fold(Aabb::EMPTY, |b, o| b.union(o.bounds()))
    }

    /// The scene with every material double-sided.
    pub fn with_both_sides(mut self) -> Self {
        let mut known = BTreeMap::new();
        for part in self.objects.iter_mut().flat_map(|o| &mut o.parts) {
            let from = part.material.clone();
            // The original is kept beside its copy, so that no other takes its address.
            let (_, both) = known.entry(Arc::as_ptr(&from).addr()).or_insert_with(|| {
                let both = Arc::new(Material { double_sided: true, ..(*from).clone() });
                (from, both)
            });
            part.material = both.clone();
        }
        self
    }

    /// The vertices that faces use, in world space, metres; those of instances once for each.
    pub fn points(&self) -> Vec<DVec3> {
        let mut points = Vec::new();
        for object in &self.objects {
            let transform = object.transform.as_dmat4();
            for mesh in object.parts.iter().map(|p| &p.mesh) {
                let mut used = vec![false; mesh.positions.len()];
                mesh.triangles.iter().flatten().for_each(|i| used[*i as usize] = true);
                let positions = mesh.positions.iter().zip(&used).filter(|(_, used)| **used);
                points.extend(positions.map(|(p, _)| transform.transform_point3(Vec3::from(*p).as_dvec3())));
            }
        }
        points
    }

    pub fn triangle_count(&self) -> usize {
        self.objects.iter().map(Object::triangle_count).sum()
    }
}
