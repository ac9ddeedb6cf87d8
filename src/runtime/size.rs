//! How much a renderer has to hold and draw.

use crate::scene::{Image, Material, Mesh, Scene};
use std::{collections::BTreeMap, sync::Arc};

/// What a scene costs a renderer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Size {
    pub triangles: u64,
    /// One for each mesh and material of each object.
    pub draw_calls: u64,
    /// Of all images that the materials use, each image once, base levels.
    pub texels: u64,
    /// Vertices and indices of each mesh once, and 4 bytes for each texel.
    pub memory_bytes: u64,
}

impl Size {
    pub fn of(scene: &Scene) -> Self {
        let mut images: BTreeMap<*const Image, u64> = BTreeMap::new();
        let mut meshes: BTreeMap<*const Mesh, u64> = BTreeMap::new();
        let mut draw_calls = 0;
        for part in scene.objects.iter().flat_map(|o| &o.parts) {
            draw_calls += 1;
            meshes.insert(Arc::as_ptr(&part.mesh), bytes(&part.mesh));
            images.extend(used(&part.material).map(|image| (Arc::as_ptr(image), image.texels.len() as u64)));
        }
        let texels = images.values().sum();
        Self {
            triangles: scene.triangle_count() as u64,
            draw_calls,
            texels,
            memory_bytes: meshes.values().sum::<u64>() + 4 * texels,
        }
    }
}

/// The images that a material uses; one may come twice.
pub fn used(m: &Material) -> impl Iterator<Item = &Arc<Image>> {
    let textures = [
        &m.base_color_texture,
        &m.metallic_roughness_texture,
        &m.normal_texture,
        &m.emissive_texture,
        &m.occlusion_texture,
    ];
    textures.into_iter().flatten().map(|texture| &texture.image)
}

/// Of vertices and indices.
pub fn bytes(mesh: &Mesh) -> u64 {
    let floats = 3 * mesh.positions.len()
        + 3 * mesh.normals.len()
        + 4 * mesh.tangents.len()
        + 2 * (mesh.uv[0].len() + mesh.uv[1].len())
        + 4 * mesh.colors.len();
    4 * (floats + 3 * mesh.triangles.len()) as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Object, Part, Texture};

    #[test]
    fn what_is_shared_counts_once_and_what_is_drawn_counts_each_time() {
        let image =
            Arc::new(Image { name: String::new(), width: 2, height: 3, texels: vec![[0; 4]; 6].into_iter().collect() });
        let texture = Texture::clamped(image);
        let material = Material {
            base_color_texture: Some(texture.clone()),
            normal_texture: Some(texture),
            ..Material::default()
        };
        let mesh = Mesh {
            positions: [[0.0; 3]; 3].into_iter().collect(),
            triangles: [[0, 1, 2]].into_iter().collect(),
            ..Mesh::default()
        };
        let part = Part { mesh: Arc::new(mesh), material: Arc::new(material) };
        let object =
            |name: &str| Object { name: name.into(), transform: glam::Mat4::IDENTITY, parts: vec![part.clone()] };
        let size = Size::of(&Scene { objects: vec![object("a"), object("b")] });
        assert_eq!(size, Size { triangles: 2, draw_calls: 2, texels: 6, memory_bytes: 36 + 12 + 24 });
    }
}
