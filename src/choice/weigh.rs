//! What the objects of scenes cost, and what they share.

use super::cost::{Cost, plus};
use crate::{
    runtime::size::{bytes, used},
    scene::{Image, Mesh, Object},
};
use std::{collections::BTreeMap, marker::PhantomData, sync::Arc};

/// Textures and meshes of several scenes, each once: textures by their texels, meshes by where they lie.
#[derive(Default)]
pub struct Shared<'a> {
    pub costs: Vec<Cost>,
    meshes: BTreeMap<*const Mesh, usize>,
    images: BTreeMap<*const Image, usize>,
    texels: BTreeMap<[u8; 32], usize>,
    /// Places mean something as long as the objects live.
    objects: PhantomData<&'a Object>,
}

impl<'a> Shared<'a> {
    /// What `object` of a scene costs itself, and the numbers of what it may share.
    pub fn weigh(&mut self, object: &'a Object) -> (Cost, Vec<usize>) {
        let mut own = [0.0; 4];
        let mut uses = Vec::new();
        for part in &object.parts {
            own = plus(own, [part.mesh.triangles.len() as f64, 0.0, 0.0, 1.0]);
            let next = self.costs.len();
            let mesh = *self.meshes.entry(Arc::as_ptr(&part.mesh)).or_insert(next);
            if mesh == next {
                self.costs.push([0.0, 0.0, bytes(&part.mesh) as f64, 0.0]);
            }
            uses.push(mesh);
            uses.extend(used(&part.material).map(|image| self.image(image)));
        }
        uses.sort_unstable();
        uses.dedup();
        (own, uses)
    }

    fn image(&mut self, image: &Arc<Image>) -> usize {
        if let Some(known) = self.images.get(&Arc::as_ptr(image)) {
            return *known;
        }
        let mut hasher = blake3::Hasher::new();
        hasher.update(&image.width.to_le_bytes()).update(&image.height.to_le_bytes());
        hasher.update(bytemuck::cast_slice(&image.texels));
        let next = self.costs.len();
        let number = *self.texels.entry(*hasher.finalize().as_bytes()).or_insert(next);
        if number == next {
            let texels = image.texels.len() as f64;
            self.costs.push([0.0, texels, 4.0 * texels, 0.0]);
        }
        self.images.insert(Arc::as_ptr(image), number);
        number
    }
}
