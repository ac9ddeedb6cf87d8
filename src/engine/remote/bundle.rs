//! The object of one key: the records of its run, with the values that are small enough to come along, so that a run of
//! small values is one request. Compressed as value files are where that saves a quarter.

use super::Found;
use crate::engine::{
    cache::{Fields, NewValue, Place, blob::INLINE, pack, values_of},
    hash::Digest,
    lookup::DigestSet,
    record::RunRecord,
    wire::{Reader, RecordPlace, Writer},
};

/// Bytes of small values that come along at most; what is beyond lies in objects of its own.
const TOGETHER: usize = 8 << 20;
/// Records under one key, which differ in the files that they read. The oldest goes first.
pub const VARIANTS: usize = 8;

/// One record with what came along, in bytes.
pub struct Entry {
    pub variant: Digest,
    bytes: Vec<u8>,
}

impl Entry {
    /// The entry of a record; `values`: hashes and bytes of values that may come along. Also says which do.
    pub fn new<'a>(
        key: &Digest,
        record: &RunRecord,
        fields: &Fields,
        values: impl Iterator<Item = (&'a Digest, &'a [u8])>,
    ) -> (Self, DigestSet) {
        let (mut along, mut list, mut total) = (DigestSet::default(), Vec::new(), 0);
        for (hash, bytes) in values {
            if bytes.len() <= INLINE && total + bytes.len() <= TOGETHER && !along.contains(hash) {
                total += bytes.len();
                along.insert(*hash);
                list.push((hash, bytes));
            }
        }
        let mut w = Writer::default();
        w.bytes(&record.to_bytes(key));
        w.list(fields, |w, (a, b)| {
            w.str(a);
            w.str(b);
        });
        w.list(&list, |w, (hash, bytes)| {
            w.digest(hash);
            w.bytes(bytes);
        });
        (Self { variant: record.variant(), bytes: w.into_bytes() }, along)
    }

    fn found(&self, key: &Digest) -> Option<Found> {
        let r = &mut Reader::plain(&self.bytes);
        let record = RunRecord::from_bytes(r.bytes()?, key, &self.variant)?;
        let fields = r.list(|r| Some((r.str()?.to_owned(), r.str()?.to_owned())))?;
        let along = r.list(|r| Some((r.digest()?, r.bytes()?)))?;
        let mut named = DigestSet::default();
        named.extend(values_of(&record.outputs));
        let mut values = Vec::new();
        for (hash, bytes) in along {
            if !named.contains(&hash) || bytes.len() > INLINE || Digest::of(bytes) != hash {
                return None;
            }
            named.remove(&hash);
            values.push(NewValue { hash, place: Place::Inline(bytes.to_vec()) });
        }
        for hash in values_of(&record.outputs) {
            if named.contains(&hash) {
                named.remove(&hash);
                values.push(NewValue { hash, place: Place::NotKept });
            }
        }
        Some(Found { record, values, fields })
    }
}

/// The object that holds `entries`.
pub fn write(key: &Digest, entries: &[Entry]) -> Vec<u8> {
    let mut w = Writer::default();
    w.list(entries, |w, e| {
        w.digest(&e.variant);
        w.bytes(&e.bytes);
    });
    let bytes = w.seal(&RecordPlace::Remote { key });
    pack::pack(&bytes).unwrap_or(bytes)
}

/// The entries of an object; `None` unless these are the bytes of the object of `key`.
pub fn read(bytes: &[u8], key: &Digest) -> Option<Vec<Entry>> {
    let unpacked = pack::is_packed(bytes).then(|| pack::unpack(bytes).ok());
    let bytes = match &unpacked {
        Some(unpacked) => unpacked.as_deref()?,
        None => bytes,
    };
    let r = &mut Reader::open(bytes, &RecordPlace::Remote { key })?;
    r.list(|r| Some(Entry { variant: r.digest()?, bytes: r.bytes()?.to_vec() }))
}

/// The results in an object of `key`, checked.
pub fn results(bytes: &[u8], key: &Digest) -> Option<Vec<Found>> {
    read(bytes, key)?.iter().map(|entry| entry.found(key)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::value::{PortOut, ValueRef};

    fn record(values: &[&[u8]]) -> RunRecord {
        let value = |v: &[u8]| ValueRef { hash: Digest::of(v), size: v.len() as u64 };
        RunRecord {
            fixed: Digest::of(b"fixed"),
            inputs: vec![Digest::of(b"input")],
            outputs: vec![PortOut::Many(values.iter().enumerate().map(|(i, v)| (format!("e{i}"), value(v))).collect())],
            warnings: vec!["a warning".to_owned()],
            seconds: 0.5,
            reads: Vec::new(),
        }
    }

    fn object(key: &Digest, small: &[u8], large: &[u8]) -> Vec<u8> {
        let record = record(&[small, large, small]);
        let hashes = [Digest::of(small), Digest::of(large)];
        let values = hashes.iter().zip([small, large]);
        let (entry, along) = Entry::new(key, &record, &vec![("kind".into(), "x".into())], values);
        assert!(along.contains(&hashes[0]) && !along.contains(&hashes[1]));
        write(key, &[entry])
    }

    #[test]
    fn what_was_written_is_read_and_large_values_stay_behind() {
        let (key, large) = (Digest::of(b"key"), vec![7; INLINE + 1]);
        let found = results(&object(&key, b"small", &large), &key).unwrap();
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].record, record(&[b"small", &large, b"small"]));
        assert_eq!(found[0].fields, [("kind".to_owned(), "x".to_owned())]);
        let places: Vec<_> = found[0].values.iter().map(|v| (v.hash, matches!(v.place, Place::NotKept))).collect();
        assert_eq!(places, [(Digest::of(b"small"), false), (Digest::of(&large), true)]);
        assert!(results(&object(&key, b"small", &large), &Digest::of(b"other")).is_none(), "another key's");
    }

    #[test]
    fn damage_anywhere_is_no_result() {
        let (key, large) = (Digest::of(b"key"), vec![7; INLINE + 1]);
        for small in [&b"small"[..], &[5; 5000]] {
            let good = object(&key, small, &large);
            for at in 0..good.len() {
                let mut bad = good.clone();
                bad[at] ^= 1;
                // A packed stream may hold bits that mean nothing: then it stands for the same bytes.
                let same = pack::is_packed(&bad) && pack::unpack(&bad).ok() == pack::unpack(&good).ok();
                assert!(same || results(&bad, &key).is_none(), "byte {at}");
                assert!(results(&good[..at], &key).is_none(), "cut at {at}");
            }
        }
    }
}
