//! Object names that stay the same while the rest of the scene changes.
//!
//! A name that occurs once stays as it is. Objects that share one get the hash of what they show as a suffix, and
//! where that is equal too (instances), of what they show and where; the number of an object never plays a part,
//! so that adding one renames no other, except its namesake.

use super::{
    Object, Scene,
    tables::{MaterialRow, image_hash, mesh_hash},
};
use glam::Mat4;
use std::{collections::BTreeMap, sync::Arc};

/// Hashes of shared values, remembered by address.
#[derive(Default)]
struct Memo(BTreeMap<usize, blake3::Hash>);

impl Memo {
    fn get<T>(&mut self, item: &Arc<T>, hash: impl FnOnce(&mut Self) -> blake3::Hash) -> blake3::Hash {
        let address = Arc::as_ptr(item).addr();
        if let Some(h) = self.0.get(&address) {
            return *h;
        }
        let h = hash(self);
        self.0.insert(address, h);
        h
    }

    /// What an object shows, and with `place` also where.
    fn object(&mut self, object: &Object, place: Option<&Mat4>) -> String {
        let mut h = blake3::Hasher::new();
        for part in &object.parts {
            h.update(self.get(&part.mesh, |_| mesh_hash(&part.mesh)).as_bytes());
            let material = self.get(&part.material, |memo| {
                let mut images = Vec::new();
                let row = MaterialRow::of(&part.material, |image| {
                    images.push(memo.get(image, |_| image_hash(image)));
                    images.len() as u32 - 1
                });
                let mut h = blake3::Hasher::new();
                h.update(&serde_json::to_vec(&row).expect("plain data serialises"));
                images.iter().for_each(|i| {
                    h.update(i.as_bytes());
                });
                h.finalize()
            });
            h.update(material.as_bytes());
        }
        if let Some(m) = place {
            h.update(bytemuck::cast_slice(&m.to_cols_array()));
        }
        h.finalize().to_hex()[..8].to_owned()
    }
}

/// The scene of these objects: names made unique, objects sorted by name.
pub fn assemble(mut objects: Vec<Object>) -> Scene {
    let mut memo = Memo::default();
    rename(&mut objects, |o| format!("{}#{}", o.name, memo.object(o, None)));
    let mut memo = Memo::default();
    rename(&mut objects, |o| format!("{}@{}", o.name, memo.object(o, Some(&o.transform))));
    // What is left is the same thing twice at the same place: any order of them is the same scene.
    let mut seen = BTreeMap::<String, u32>::new();
    rename(&mut objects, |o| {
        let n = seen.entry(o.name.clone()).and_modify(|n| *n += 1).or_insert(1);
        format!("{}~{n}", o.name)
    });
    // A suffixed name may still be another object's own.
    let mut taken = std::collections::BTreeSet::new();
    for o in &mut objects {
        while !taken.insert(o.name.clone()) {
            o.name.push('~');
        }
    }
    objects.sort_by(|a, b| a.name.cmp(&b.name));
    Scene { objects }
}

/// Renames the objects whose names occur more than once.
fn rename(objects: &mut [Object], mut name: impl FnMut(&Object) -> String) {
    let mut count = BTreeMap::<String, u32>::new();
    for o in objects.iter() {
        *count.entry(o.name.clone()).or_default() += 1;
    }
    for o in objects.iter_mut().filter(|o| count.get(&o.name).is_some_and(|n| *n > 1)) {
        o.name = name(o);
    }
}
