//! Decoded values that more than one run takes, kept while anyone may still take them and within a share of the
//! memory budget. What is not held is read again from the cache.

use crate::engine::{hash::Digest, lookup::DigestMap, node::Data};

pub struct Held {
    values: DigestMap<(Data, u64)>,
    bytes: u64,
    most: u64,
}

impl Held {
    /// Holds values of at most `most` stored bytes together.
    pub fn new(most: u64) -> Self {
        Self { values: DigestMap::default(), bytes: 0, most }
    }

    pub fn get(&self, hash: &Digest) -> Option<Data> {
        self.values.get(hash).map(|(data, _)| data.clone())
    }

    pub fn put(&mut self, hash: Digest, size: u64, data: Data) {
        if self.bytes + size <= self.most && !self.values.contains(&hash) {
            self.bytes += size;
            self.values.insert(hash, (data, size));
        }
    }

    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    pub fn drop_value(&mut self, hash: &Digest) {
        if let Some((_, size)) = self.values.remove(hash) {
            self.bytes -= size;
        }
    }
}
