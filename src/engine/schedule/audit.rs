//! What an audit found: hits that were computed again, and whether they gave the bytes that the cache holds.

use crate::engine::{
    cache::{Cache, NewValue, Stored},
    error::EngineError,
    hash::Digest,
    report::Audit,
    value::{PortOut, ValueRef},
};
use std::collections::BTreeMap;

impl Audit {
    /// Compares the outputs that the cache holds with those of the run, whose values are `made`.
    pub(super) fn compare(
        &mut self,
        held: &[PortOut],
        run: &[PortOut],
        made: &[NewValue],
        cache: &Cache,
    ) -> Result<(), EngineError> {
        self.runs += 1;
        self.different_runs += u64::from(held != run);
        let (mut old, new) = (by_name(held), by_name(run));
        let made: BTreeMap<Digest, &NewValue> = made.iter().map(|v| (v.hash, v)).collect();
        for (name, value) in &new {
            self.bytes += value.size;
            self.different_bytes += match old.remove(name) {
                None => value.size,
                Some(was) if was.hash == value.hash => 0,
                Some(was) => {
                    let stored = cache.value(&was.hash)?;
                    let was_bytes = stored.and_then(|stored| bytes(cache, &was.hash, stored));
                    let stored = made.get(&value.hash).map_or(Stored::File, |v| v.place.stored());
                    match (was_bytes, bytes(cache, &value.hash, stored)) {
                        (Some(a), Some(b)) => differing((*a).as_ref(), (*b).as_ref()),
                        // The bytes that the cache held are lost: none of them can be compared.
                        _ => value.size,
                    }
                }
            };
        }
        self.different_bytes += old.values().map(|v| v.size).sum::<u64>();
        Ok(())
    }
}

/// Values by port and element.
fn by_name(outputs: &[PortOut]) -> BTreeMap<(usize, &str), ValueRef> {
    let mut out = BTreeMap::new();
    for (port, output) in outputs.iter().enumerate() {
        match output {
            PortOut::One(value) => drop(out.insert((port, ""), *value)),
            PortOut::Many(rows) => out.extend(rows.iter().map(|(name, value)| ((port, name.as_str()), *value))),
        }
    }
    out
}

fn bytes(cache: &Cache, hash: &Digest, stored: Stored) -> Option<crate::array::Bytes> {
    match stored {
        Stored::Inline(bytes) => Some(bytes),
        Stored::File => cache.blobs().get(hash, false).ok(),
        Stored::NotKept => None,
    }
}

/// How many bytes differ, place by place; those beyond the shorter one's end all do.
fn differing(a: &[u8], b: &[u8]) -> u64 {
    let within = a.iter().zip(b).filter(|(a, b)| a != b).count();
    (within + a.len().abs_diff(b.len())) as u64
}

#[cfg(test)]
mod tests {
    #[test]
    fn bytes_differ_by_place_and_by_length() {
        assert_eq!(super::differing(b"abc", b"abc"), 0);
        assert_eq!(super::differing(b"abc", b"axc"), 1);
        assert_eq!(super::differing(b"abc", b"abcdd"), 2);
    }
}
