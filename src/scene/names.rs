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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Mesh, Part};

    fn object(name: &str, x: f32, shift: f32) -> Object {
        let mesh = Mesh { positions: vec![[shift; 3]; 3].into(), triangles: vec![[0, 1, 2]].into(), ..Mesh::default() };
        let part = Part { mesh: Arc::new(mesh), material: Arc::default() };
        Object { name: name.into(), transform: Mat4::from_translation(glam::vec3(x, 0.0, 0.0)), parts: vec![part] }
    }

    fn names(objects: Vec<Object>) -> Vec<String> {
        assemble(objects).objects.into_iter().map(|o| o.name).collect()
    }

    #[test]
    fn lone_names_stay_and_order_does_not_matter() {
        assert_eq!(names(vec![object("b", 0.0, 0.0), object("a", 0.0, 0.0)]), ["a", "b"]);
    }

    #[test]
    fn namesakes_are_told_apart_by_what_they_show_then_by_place() {
        let different = names(vec![object("a", 0.0, 1.0), object("a", 5.0, 2.0)]);
        assert!(different.iter().all(|n| n.starts_with("a#") && !n.contains('@')));
        // Moving one changes no name.
        assert_eq!(different, names(vec![object("a", 9.0, 1.0), object("a", 5.0, 2.0)]));
        let instances = names(vec![object("a", 0.0, 1.0), object("a", 5.0, 1.0)]);
        assert!(instances.iter().all(|n| n.contains('@')), "{instances:?}");
        let same = names(vec![object("a", 0.0, 1.0), object("a", 0.0, 1.0)]);
        assert!(same[0].ends_with("~1") && same[1].ends_with("~2"), "{same:?}");
    }

    #[test]
    fn a_suffixed_name_may_already_be_taken() {
        let two = vec![object("a", 0.0, 1.0), object("a", 5.0, 2.0)];
        let taken = names(two.clone());
        let mut three = two;
        three.push(object(&taken[0], 0.0, 0.0));
        let all = names(three);
        assert_eq!(all.len(), 3);
        assert!(all.is_sorted_by(|a, b| a < b), "{all:?}");
    }
}
