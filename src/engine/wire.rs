//! The bytes of the engine's own records: little-endian, each record closed by a checksum, because SQLite has none and
//! a flipped bit must read as a miss, never as another result. The checksum covers where the record lies, too: a
//! damaged index may lead from one key to the row of another.

use super::hash::Digest;

/// Length of the checksum at a record's end.
const SUM: usize = 16;

/// Where a record lies: its table, and the columns that it is found by. The key of a run or of a map is itself a hash of
/// its node's kind and version.
#[derive(Clone, Copy, Debug)]
pub enum RecordPlace<'a> {
    /// `variant`: the hash of the files that the run read.
    Run {
        key: &'a Digest,
        variant: &'a Digest,
    },
    Map {
        key: &'a Digest,
    },
    /// The fixed part of keys.
    Fixed {
        hash: &'a Digest,
    },
    /// A file of the outside world.
    File {
        path: &'a str,
    },
    Bake {
        id: i64,
        pipeline: &'a str,
        folder: &'a str,
    },
    /// The object of a run's key in the second level.
    Remote {
        key: &'a Digest,
    },
}

impl RecordPlace<'_> {
    /// The checksum of a record with these bytes at this place.
    fn sum(&self, body: &[u8]) -> [u8; SUM] {
        let mut h = blake3::Hasher::new();
        let mut part = |bytes: &[u8]| {
            h.update(&(bytes.len() as u64).to_le_bytes());
            h.update(bytes);
        };
        match self {
            Self::Run { key, variant } => [b"run", &key.0[..], &variant.0].into_iter().for_each(&mut part),
            Self::Map { key } => [b"map", &key.0[..]].into_iter().for_each(&mut part),
            Self::Remote { key } => [b"remote", &key.0[..]].into_iter().for_each(&mut part),
            Self::Fixed { hash } => [b"fixed", &hash.0[..]].into_iter().for_each(&mut part),
            Self::File { path } => [b"file", path.as_bytes()].into_iter().for_each(&mut part),
            Self::Bake { id, pipeline, folder } => {
                let id = id.to_le_bytes();
                [b"bake", &id[..], pipeline.as_bytes(), folder.as_bytes()].into_iter().for_each(&mut part);
            }
        }
        part(body);
        let mut sum = [0; SUM];
        sum.copy_from_slice(&h.finalize().as_bytes()[..SUM]);
        sum
    }
}

#[derive(Default)]
pub struct Writer(Vec<u8>);

impl Writer {
    pub fn u8(&mut self, v: u8) {
        self.0.push(v);
    }
    pub fn u32(&mut self, v: u32) {
        self.0.extend(v.to_le_bytes());
    }
    pub fn u64(&mut self, v: u64) {
        self.0.extend(v.to_le_bytes());
    }
    pub fn i64(&mut self, v: i64) {
        self.0.extend(v.to_le_bytes());
    }
    pub fn f64(&mut self, v: f64) {
        self.u64(v.to_bits());
    }
    pub fn digest(&mut self, v: &Digest) {
        self.0.extend(v.0);
    }
    pub fn str(&mut self, v: &str) {
        self.u32(v.len() as u32);
        self.0.extend(v.as_bytes());
    }
    pub fn bytes(&mut self, v: &[u8]) {
        self.u32(v.len() as u32);
        self.0.extend(v);
    }
    /// A list: its length, then each item by `item`.
    pub fn list<T>(&mut self, items: &[T], mut item: impl FnMut(&mut Self, &T)) {
        self.u32(items.len() as u32);
        for i in items {
            item(self, i);
        }
    }
    pub fn option<T>(&mut self, v: &Option<T>, item: impl FnOnce(&mut Self, &T)) {
        self.u8(u8::from(v.is_some()));
        if let Some(v) = v {
            item(self, v);
        }
    }
    /// The record, closed by the checksum for its place.
    pub fn seal(mut self, place: &RecordPlace) -> Vec<u8> {
        let sum = place.sum(&self.0);
        self.0.extend(sum);
        self.0
    }
    /// What was written, without a checksum: a part of another record.
    pub fn into_bytes(self) -> Vec<u8> {
        self.0
    }
    /// The hash of what was written.
    pub fn digest_of(&self) -> Digest {
        Digest::of(&self.0)
    }
}

/// Reads what [`Writer`] wrote; `None` as soon as anything is not as it should be.
pub struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    /// Checks that these are the bytes that were sealed for this place.
    pub fn open(bytes: &'a [u8], place: &RecordPlace) -> Option<Self> {
        let (body, sum) = bytes.split_at_checked(bytes.len().checked_sub(SUM)?)?;
        (place.sum(body) == *sum).then_some(Self(body))
    }
    /// Bytes that were checked as a part of another record.
    pub fn plain(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (head, tail) = self.0.split_at_checked(n)?;
        self.0 = tail;
        Some(head)
    }
    pub fn u8(&mut self) -> Option<u8> {
        Some(self.take(1)?[0])
    }
    pub fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.take(4)?.try_into().ok()?))
    }
    pub fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.take(8)?.try_into().ok()?))
    }
    pub fn i64(&mut self) -> Option<i64> {
        Some(i64::from_le_bytes(self.take(8)?.try_into().ok()?))
    }
    pub fn f64(&mut self) -> Option<f64> {
        Some(f64::from_bits(self.u64()?))
    }
    pub fn digest(&mut self) -> Option<Digest> {
        Some(Digest(self.take(32)?.try_into().ok()?))
    }
    pub fn str(&mut self) -> Option<&'a str> {
        let n = self.u32()? as usize;
        std::str::from_utf8(self.take(n)?).ok()
    }
    pub fn bytes(&mut self) -> Option<&'a [u8]> {
        let n = self.u32()? as usize;
        self.take(n)
    }
    pub fn list<T>(&mut self, mut item: impl FnMut(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let n = self.u32()? as usize;
        // Every item takes at least one byte: a false length ends in `None`, not in an allocation.
        let mut out = Vec::with_capacity(n.min(self.0.len()));
        for _ in 0..n {
            out.push(item(self)?);
        }
        Some(out)
    }
    pub fn option<T>(&mut self, item: impl FnOnce(&mut Self) -> Option<T>) -> Option<Option<T>> {
        Some(match self.u8()? {
            0 => None,
            _ => Some(item(self)?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PLACE: RecordPlace = RecordPlace::File { path: "a" };

    #[test]
    fn a_record_is_sound_only_where_it_was_written() {
        let (a, b) = (Digest([1; 32]), Digest([2; 32]));
        let places = [
            RecordPlace::Run { key: &a, variant: &b },
            RecordPlace::Run { key: &b, variant: &b },
            RecordPlace::Run { key: &a, variant: &a },
            RecordPlace::Map { key: &a },
            RecordPlace::Map { key: &b },
            RecordPlace::Remote { key: &a },
            RecordPlace::Fixed { hash: &a },
            RecordPlace::File { path: "a" },
            RecordPlace::File { path: "ab" },
            RecordPlace::Bake { id: 1, pipeline: "a", folder: "bc" },
            RecordPlace::Bake { id: 1, pipeline: "ab", folder: "c" },
            RecordPlace::Bake { id: 2, pipeline: "a", folder: "bc" },
        ];
        for (i, place) in places.iter().enumerate() {
            let bytes = Writer::default().seal(place);
            for (j, other) in places.iter().enumerate() {
                assert_eq!(Reader::open(&bytes, other).is_some(), i == j, "{place:?} {other:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(a: u64, s in ".{0,40}", v in proptest::collection::vec(any::<u32>(), 0..20)) {
            let mut w = Writer::default();
            w.u64(a);
            w.str(&s);
            w.list(&v, |w, v| w.u32(*v));
            w.option(&Some(a), |w, v| w.u64(*v));
            let bytes = w.seal(&PLACE);
            let mut r = Reader::open(&bytes, &PLACE).unwrap();
            prop_assert_eq!((r.u64(), r.str()), (Some(a), Some(s.as_str())));
            prop_assert_eq!(r.list(Reader::u32), Some(v));
            prop_assert_eq!(r.option(Reader::u64), Some(Some(a)));
        }

        #[test]
        fn a_flipped_bit_is_noticed(v in proptest::collection::vec(any::<u32>(), 0..20), at: usize, bit in 0..8u32) {
            let mut w = Writer::default();
            w.list(&v, |w, v| w.u32(*v));
            let mut bytes = w.seal(&PLACE);
            let n = bytes.len();
            bytes[at % n] ^= 1u8 << bit;
            prop_assert!(Reader::open(&bytes, &PLACE).is_none());
        }
    }
}
