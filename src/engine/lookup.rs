//! Sets and maps by content hash that are only asked, never walked: their order is nobody's to see. A digest is its own
//! hash value, so that an entry costs far less than in an ordered set.

use super::hash::Digest;
use std::hash::{BuildHasherDefault, Hasher};

#[derive(Default)]
struct Own(u64);

impl Hasher for Own {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        // The length that goes before the bytes comes through here too.
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.0 = self.0.rotate_left(5) ^ u64::from_le_bytes(word);
        }
    }
    fn write_usize(&mut self, _: usize) {}
}

#[expect(clippy::disallowed_types, reason = "it is private and gives no way to walk it")]
type Map<V> = std::collections::HashMap<Digest, V, BuildHasherDefault<Own>>;

/// Values by digest.
pub struct DigestMap<V>(Map<V>);

impl<V> Default for DigestMap<V> {
    fn default() -> Self {
        Self(Map::default())
    }
}

impl<V> DigestMap<V> {
    pub fn get(&self, key: &Digest) -> Option<&V> {
        self.0.get(key)
    }
    pub fn get_mut(&mut self, key: &Digest) -> Option<&mut V> {
        self.0.get_mut(key)
    }
    pub fn contains(&self, key: &Digest) -> bool {
        self.0.contains_key(key)
    }
    pub fn insert(&mut self, key: Digest, value: V) -> Option<V> {
        self.0.insert(key, value)
    }
    pub fn remove(&mut self, key: &Digest) -> Option<V> {
        self.0.remove(key)
    }
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// A set of digests.
#[derive(Default)]
pub struct DigestSet(DigestMap<()>);

impl DigestSet {
    pub fn contains(&self, key: &Digest) -> bool {
        self.0.contains(key)
    }
    pub fn insert(&mut self, key: Digest) {
        self.0.insert(key, ());
    }
    pub fn remove(&mut self, key: &Digest) {
        self.0.remove(key);
    }
    pub fn extend(&mut self, keys: impl IntoIterator<Item = Digest>) {
        keys.into_iter().for_each(|key| self.insert(key));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_put_in_is_found() {
        let mut map = DigestMap::default();
        let key = |i: u32| Digest::of(&i.to_le_bytes());
        for i in 0..1000 {
            map.insert(key(i), i);
        }
        assert!((0..1000).all(|i| map.get(&key(i)) == Some(&i)) && map.get(&key(1000)).is_none());
        assert_eq!((map.remove(&key(5)), map.contains(&key(5)), map.contains(&key(6))), (Some(5), false, true));
    }
}
