//! Decoded values in memory, kept while anyone may still take them. A value that each of its takers takes once leaves
//! with the last of them; others stay until all nodes that read them are done. What had to go earlier, because memory
//! is short, is read again from the cache or made again.

use crate::engine::{hash::Digest, lookup::DigestMap, node::Data};
use std::collections::BTreeMap;

struct Entry {
    data: Data,
    size: u64,
    /// Runs that have still to take it.
    takers: u32,
    /// Nodes' lists that hold it as a whole.
    kept: bool,
    /// Runs that wait for just this value: it must not go before they have it.
    pins: u32,
    /// Its place in the order of age.
    age: u64,
}

#[derive(Default)]
pub struct Held {
    values: DigestMap<Entry>,
    /// By age, the oldest first.
    order: BTreeMap<u64, Digest>,
    next: u64,
    bytes: u64,
}

impl Held {
    pub fn get(&self, hash: &Digest) -> Option<Data> {
        self.values.get(hash).map(|entry| entry.data.clone())
    }

    pub fn contains(&self, hash: &Digest) -> bool {
        self.values.contains(hash)
    }

    /// Stored bytes of all values.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Holds a value. Nobody takes it yet: see [`Self::expect`], [`Self::keep`] and [`Self::pin`].
    pub fn put(&mut self, hash: Digest, size: u64, data: Data) {
        if self.values.contains(&hash) {
            return;
        }
        self.next += 1;
        self.bytes += size;
        self.order.insert(self.next, hash);
        self.values.insert(hash, Entry { data, size, takers: 0, kept: false, pins: 0, age: self.next });
    }

    /// So many runs will take the value.
    pub fn expect(&mut self, hash: &Digest, takers: u32) {
        if let Some(entry) = self.values.get_mut(hash) {
            entry.takers += takers;
        }
    }

    /// Whole nodes will take the value.
    pub fn keep(&mut self, hash: &Digest) {
        if let Some(entry) = self.values.get_mut(hash) {
            entry.kept = true;
        }
    }

    pub fn pin(&mut self, hash: &Digest) {
        if let Some(entry) = self.values.get_mut(hash) {
            entry.pins += 1;
        }
    }

    pub fn unpin(&mut self, hash: &Digest) {
        self.less(hash, |entry| entry.pins = entry.pins.saturating_sub(1));
    }

    /// A run has taken the value.
    pub fn taken(&mut self, hash: &Digest) {
        self.less(hash, |entry| entry.takers = entry.takers.saturating_sub(1));
    }

    /// The nodes that took it are done.
    pub fn unkeep(&mut self, hash: &Digest) {
        self.less(hash, |entry| (entry.kept, entry.takers) = (false, 0));
    }

    fn less(&mut self, hash: &Digest, change: impl FnOnce(&mut Entry)) {
        if let Some(entry) = self.values.get_mut(hash) {
            change(entry);
            if entry.takers == 0 && !entry.kept && entry.pins == 0 {
                self.drop_value(hash);
            }
        }
    }

    pub fn drop_value(&mut self, hash: &Digest) {
        if let Some(entry) = self.values.remove(hash) {
            self.bytes -= entry.size;
            self.order.remove(&entry.age);
        }
    }

    /// Lets the oldest values go until at most `most` bytes are held. Those that someone waits for, and those that
    /// `spared` names, stay.
    pub fn shrink(&mut self, most: u64, spared: impl Fn(&Digest) -> bool) {
        if self.bytes <= most {
            return;
        }
        let mut gone = Vec::new();
        let mut bytes = self.bytes;
        for hash in self.order.values() {
            if bytes <= most {
                break;
            }
            if let Some(entry) = self.values.get(hash).filter(|entry| entry.pins == 0 && !spared(hash)) {
                bytes -= entry.size;
                gone.push(*hash);
            }
        }
        gone.iter().for_each(|hash| self.drop_value(hash));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn held(sizes: &[u64]) -> (Held, Vec<Digest>) {
        let mut held = Held::default();
        let hashes: Vec<Digest> = (0..sizes.len()).map(|i| Digest::of(&[i as u8])).collect();
        for (hash, size) in hashes.iter().zip(sizes) {
            held.put(*hash, *size, Arc::new(*size));
        }
        (held, hashes)
    }

    #[test]
    fn a_value_leaves_with_its_last_taker() {
        let (mut held, h) = held(&[5, 7]);
        held.expect(&h[0], 2);
        held.taken(&h[0]);
        assert!(held.contains(&h[0]) && held.bytes() == 12);
        held.taken(&h[0]);
        assert!(!held.contains(&h[0]) && held.bytes() == 7);
        held.keep(&h[1]);
        held.expect(&h[1], 1);
        held.taken(&h[1]);
        assert!(held.contains(&h[1]), "whole nodes still take it");
        held.unkeep(&h[1]);
        assert!(held.is_empty() && held.bytes() == 0);
    }

    #[test]
    fn the_oldest_go_first_and_what_is_waited_for_stays() {
        let (mut held, h) = held(&[10, 20, 30, 40]);
        held.pin(&h[0]);
        held.shrink(75, |hash| *hash == h[1]);
        assert_eq!(h.iter().map(|hash| held.contains(hash)).collect::<Vec<_>>(), [true, true, false, true]);
        held.shrink(0, |_| false);
        assert_eq!((held.contains(&h[0]), held.bytes()), (true, 10));
        held.unpin(&h[0]);
        assert!(held.is_empty());
    }
}
