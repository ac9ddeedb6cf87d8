//! A scene as tables: every distinct mesh, material and image once, in the order of first use.
//!
//! What counts as distinct is content, not address: equal scenes have equal tables however their `Arc`s are shared.

use super::{Alpha, Image, Material, Mesh, Scene, Texture, Wrap};
use serde::{Deserialize, Serialize};
use std::{collections::BTreeMap, sync::Arc};

/// The tables of one scene.
#[derive(Default)]
pub struct Tables<'a> {
    pub images: Vec<&'a Arc<Image>>,
    pub materials: Vec<(&'a Arc<Material>, MaterialRow)>,
    pub meshes: Vec<&'a Arc<Mesh>>,
    /// For every object the numbers of mesh and material of its parts.
    pub parts: Vec<Vec<[u32; 2]>>,
}

/// A material whose images are numbers of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MaterialRow {
    pub name: String,
    pub base_color: [f32; 4],
    pub base_color_texture: Option<TextureRow>,
    pub metallic: f32,
    pub roughness: f32,
    pub metallic_roughness_texture: Option<TextureRow>,
    pub normal_scale: f32,
    pub normal_texture: Option<TextureRow>,
    pub emissive: [f32; 3],
    pub emissive_texture: Option<TextureRow>,
    pub alpha: AlphaRow,
    pub double_sided: bool,
    pub unlit: bool,
    /// Left out where it says nothing, so that rows without occlusion are stored as they were before there was any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub occlusion: Option<OcclusionRow>,
}

/// A material's occlusion, where it has some.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OcclusionRow {
    pub strength: f32,
    pub texture: Option<TextureRow>,
}

/// [`Alpha`], as stored.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AlphaRow {
    Opaque,
    Mask(f32),
    Blend,
}

/// [`Texture`], as stored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TextureRow {
    pub image: u32,
    pub uv_set: u8,
    pub offset: [f32; 2],
    pub rotation: f32,
    pub scale: [f32; 2],
    pub wrap: [WrapRow; 2],
    pub smooth: bool,
}

/// [`Wrap`], as stored.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WrapRow {
    Repeat,
    Mirror,
    Clamp,
}

/// What has been numbered so far: by address for speed, by content for meaning.
#[derive(Default)]
struct Known {
    by_address: BTreeMap<usize, u32>,
    by_content: BTreeMap<Vec<u8>, u32>,
}

impl Known {
    /// The number of `item`, and whether it is new.
    fn number<T>(&mut self, item: &Arc<T>, content: impl FnOnce() -> Vec<u8>) -> (u32, bool) {
        let address = Arc::as_ptr(item).addr();
        if let Some(n) = self.by_address.get(&address) {
            return (*n, false);
        }
        let next = self.by_content.len() as u32;
        let n = *self.by_content.entry(content()).or_insert(next);
        self.by_address.insert(address, n);
        (n, n == next)
    }
}

impl<'a> Tables<'a> {
    pub fn of(scene: &'a Scene) -> Self {
        let mut tables = Self::default();
        let (mut images, mut materials, mut meshes) = (Known::default(), Known::default(), Known::default());
        for object in &scene.objects {
            let mut parts = Vec::with_capacity(object.parts.len());
            for part in &object.parts {
                let (mesh, new) = meshes.number(&part.mesh, || mesh_hash(&part.mesh).as_bytes().to_vec());
                if new {
                    tables.meshes.push(&part.mesh);
                }
                let list = &mut tables.images;
                let mut row = None;
                let (material, new) = materials.number(&part.material, || {
                    let r = MaterialRow::of(&part.material, |image| {
                        let (n, new) = images.number(image, || image_hash(image).as_bytes().to_vec());
                        if new {
                            list.push(image);
                        }
                        n
                    });
                    let key = serde_json::to_vec(&r).expect("plain data serialises");
                    row = Some(r);
                    key
                });
                if let (true, Some(row)) = (new, row) {
                    tables.materials.push((&part.material, row));
                }
                parts.push([mesh, material]);
            }
            tables.parts.push(parts);
        }
        tables
    }
}

/// Hash of a mesh's content.
pub fn mesh_hash(mesh: &Mesh) -> blake3::Hash {
    let mut h = blake3::Hasher::new();
    let mut add = |bytes: &[u8]| {
        h.update(&(bytes.len() as u64).to_le_bytes());
        h.update(bytes);
    };
    add(bytemuck::cast_slice(&mesh.positions));
    add(bytemuck::cast_slice(&mesh.normals));
    add(bytemuck::cast_slice(&mesh.tangents));
    add(bytemuck::cast_slice(&mesh.uv[0]));
    add(bytemuck::cast_slice(&mesh.uv[1]));
    add(bytemuck::cast_slice(&mesh.colors));
    add(bytemuck::cast_slice(&mesh.triangles));
    h.finalize()
}

/// Hash of an image's name, size and texels.
pub fn image_hash(image: &Image) -> blake3::Hash {
    let mut h = blake3::Hasher::new();
    h.update(&(image.name.len() as u64).to_le_bytes());
    h.update(image.name.as_bytes());
    h.update(&image.width.to_le_bytes());
    h.update(&image.height.to_le_bytes());
    h.update(bytemuck::cast_slice(&image.texels));
    h.finalize()
}

impl MaterialRow {
    /// `material` with its images numbered by `number`.
    pub fn of<'a>(material: &'a Material, mut number: impl FnMut(&'a Arc<Image>) -> u32) -> Self {
        let mut row = |t: &'a Option<Texture>| t.as_ref().map(|t| TextureRow::of(t, number(&t.image)));
        Self {
            name: material.name.clone(),
            base_color: material.base_color,
            base_color_texture: row(&material.base_color_texture),
            metallic: material.metallic,
            roughness: material.roughness,
            metallic_roughness_texture: row(&material.metallic_roughness_texture),
            normal_scale: material.normal_scale,
            normal_texture: row(&material.normal_texture),
            emissive: material.emissive,
            emissive_texture: row(&material.emissive_texture),
            alpha: match material.alpha {
                Alpha::Opaque => AlphaRow::Opaque,
                Alpha::Mask { cutoff } => AlphaRow::Mask(cutoff),
                Alpha::Blend => AlphaRow::Blend,
            },
            double_sided: material.double_sided,
            unlit: material.unlit,
            occlusion: {
                let texture = row(&material.occlusion_texture);
                let strength = material.occlusion_strength;
                (texture.is_some() || strength != 1.0).then_some(OcclusionRow { strength, texture })
            },
        }
    }

    /// The material that this row describes; `None` where it names an image or a coordinate set that is not there.
    pub fn material(&self, images: &[Arc<Image>]) -> Option<Material> {
        let texture = |t: &Option<TextureRow>| match t {
            None => Some(None),
            Some(t) => t.texture(images).map(Some),
        };
        Some(Material {
            name: self.name.clone(),
            base_color: self.base_color,
            base_color_texture: texture(&self.base_color_texture)?,
            metallic: self.metallic,
            roughness: self.roughness,
            metallic_roughness_texture: texture(&self.metallic_roughness_texture)?,
            normal_scale: self.normal_scale,
            normal_texture: texture(&self.normal_texture)?,
            emissive: self.emissive,
            emissive_texture: texture(&self.emissive_texture)?,
            alpha: match self.alpha {
                AlphaRow::Opaque => Alpha::Opaque,
                AlphaRow::Mask(cutoff) => Alpha::Mask { cutoff },
                AlphaRow::Blend => Alpha::Blend,
            },
            double_sided: self.double_sided,
            unlit: self.unlit,
            occlusion_strength: self.occlusion.as_ref().map_or(1.0, |o| o.strength),
            occlusion_texture: match &self.occlusion {
                None => None,
                Some(o) => texture(&o.texture)?,
            },
        })
    }
}

impl TextureRow {
    fn of(texture: &Texture, image: u32) -> Self {
        let wrap = |w| match w {
            Wrap::Repeat => WrapRow::Repeat,
            Wrap::Mirror => WrapRow::Mirror,
            Wrap::Clamp => WrapRow::Clamp,
        };
        Self {
            image,
            uv_set: texture.uv_set,
            offset: texture.offset,
            rotation: texture.rotation,
            scale: texture.scale,
            wrap: texture.wrap.map(wrap),
            smooth: texture.smooth,
        }
    }

    fn texture(&self, images: &[Arc<Image>]) -> Option<Texture> {
        let wrap = |w| match w {
            WrapRow::Repeat => Wrap::Repeat,
            WrapRow::Mirror => Wrap::Mirror,
            WrapRow::Clamp => Wrap::Clamp,
        };
        (self.uv_set < 2).then_some(())?;
        Some(Texture {
            image: images.get(self.image as usize)?.clone(),
            uv_set: self.uv_set,
            offset: self.offset,
            rotation: self.rotation,
            scale: self.scale,
            wrap: self.wrap.map(wrap),
            smooth: self.smooth,
        })
    }
}
