//! Hashes of outside files, remembered by what the system says of the file. An entry made within two seconds of the
//! file's last change is not trusted: the file may have changed again without a new time (git's racy-clean rule).

use crate::engine::wire::Writer;
use std::{fs, time::SystemTime};

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

    pub fn to_bytes(self) -> Vec<u8> {
        let mut w = Writer::default();
        w.u64(self.size);
        w.i64(self.mtime as i64);
        w.i64(self.ctime as i64);
        w.u64(self.inode);
        w.u64(self.device);
        w.finish()
    }

    /// Whether a hash taken at `at` (nanoseconds since 1970) belongs to this stamp for certain.
    pub fn settled(&self, at: i128) -> bool {
        self.mtime.max(self.ctime) + RACY < at
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
