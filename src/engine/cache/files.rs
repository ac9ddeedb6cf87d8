//! Hashes of outside files, remembered by what the system says of the file. An entry made within two seconds of the
//! file's last change is not trusted: the file may have changed again without a new time (git's racy-clean rule).

use super::{Cache, blob_of};
use crate::{
    engine::{
        hash::Digest,
        wire::{Reader, RecordPlace, Writer},
    },
    regular,
};
use rusqlite::OptionalExtension as _;
use std::{fs, io, path::Path, time::SystemTime};

/// Two seconds, in nanoseconds.
const RACY: i128 = 2_000_000_000;

/// What the system says of a file: size, times of change in nanoseconds, and which file it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    pub size: u64,
    pub mtime: i128,
    pub ctime: i128,
    pub inode: u64,
    pub device: u64,
}

impl Stamp {
    #[cfg(unix)]
    pub fn of(meta: &fs::Metadata) -> Self {
        use std::os::unix::fs::MetadataExt as _;
        let ns = |s: i64, n: i64| i128::from(s) * 1_000_000_000 + i128::from(n);
        Self {
            size: meta.size(),
            mtime: ns(meta.mtime(), meta.mtime_nsec()),
            ctime: ns(meta.ctime(), meta.ctime_nsec()),
            inode: meta.ino(),
            device: meta.dev(),
        }
    }

    #[cfg(not(unix))]
    pub fn of(meta: &fs::Metadata) -> Self {
        let mtime = meta.modified().map_or(0, nanoseconds);
        Self { size: meta.len(), mtime, ctime: mtime, inode: 0, device: 0 }
    }

    /// Whether a hash taken at `at` (nanoseconds since 1970) belongs to this stamp for certain.
    pub fn settled(&self, at: i128) -> bool {
        self.mtime.max(self.ctime) + RACY < at
    }
}

/// What is remembered of a file.
pub(super) struct Remembered {
    pub stamp: Stamp,
    pub hash: Digest,
    /// When the hash was taken, in seconds since 1970.
    pub at: i64,
}

impl Remembered {
    pub fn to_bytes(&self, path: &str) -> Vec<u8> {
        let mut w = Writer::default();
        let Stamp { size, mtime, ctime, inode, device } = self.stamp;
        w.u64(size);
        w.i64(mtime as i64);
        w.i64(ctime as i64);
        w.u64(inode);
        w.u64(device);
        w.digest(&self.hash);
        w.i64(self.at);
        w.seal(&RecordPlace::File { path })
    }

    /// `None` unless these are the bytes that belong to `path`.
    pub fn from_bytes(bytes: &[u8], path: &str) -> Option<Self> {
        let r = &mut Reader::open(bytes, &RecordPlace::File { path })?;
        let (size, mtime, ctime) = (r.u64()?, r.i64()?.into(), r.i64()?.into());
        let stamp = Stamp { size, mtime, ctime, inode: r.u64()?, device: r.u64()? };
        Some(Self { stamp, hash: r.digest()?, at: r.i64()? })
    }
}

impl Cache {
    /// Content hash and size of an outside file; `None` where there is none.
    pub fn hash_file(&mut self, path: &Path) -> Result<Option<(Digest, u64)>, io::Error> {
        let meta = match fs::metadata(path) {
            Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => return Ok(None),
            other => other?,
        };
        regular::check(&meta)?;
        let (stamp, name) = (Stamp::of(&meta), path.to_string_lossy().into_owned());
        let row = || -> rusqlite::Result<Option<Option<Remembered>>> {
            let mut s = self.db.prepare_cached("SELECT record FROM file WHERE path = ?1")?;
            s.query_row([&name], |r| Ok(Remembered::from_bytes(blob_of(r.get_ref(0)?), &name))).optional()
        };
        // An index that cannot be read shows elsewhere; the file itself can always be read.
        match row() {
            Ok(Some(Some(known))) if known.stamp == stamp => return Ok(Some((known.hash, stamp.size))),
            Ok(Some(None)) => {
                self.warnings.push(format!("the index held a damaged record of {name}; the file is read again"));
                self.pending.bad_files.push(name.clone());
            }
            _ => {}
        }
        let at = nanoseconds(SystemTime::now());
        let bytes = regular::read(path)?;
        let hash = Digest::of(&bytes);
        // Remembered only if it did not change while it was read and cannot change unseen afterwards.
        if stamp.settled(at) && Stamp::of(&fs::metadata(path)?) == stamp {
            self.pending.files.push((name, Remembered { stamp, hash, at: (at / 1_000_000_000) as i64 }));
        }
        Ok(Some((hash, bytes.len() as u64)))
    }
}

/// Nanoseconds since 1970.
pub fn nanoseconds(t: SystemTime) -> i128 {
    t.duration_since(SystemTime::UNIX_EPOCH).map_or(0, |d| d.as_nanos() as i128)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fresh_stamp_is_not_settled() {
        let s = Stamp { size: 1, mtime: 10_000_000_000, ctime: 11_000_000_000, inode: 1, device: 1 };
        assert!(!s.settled(12_000_000_000) && !s.settled(13_000_000_000) && s.settled(13_000_000_001));
    }
}
