//! Where readers get their bytes from.

use super::FormatError;
use crate::array::Bytes;
use std::{
    path::{Component, Path, PathBuf},
    sync::Arc,
};

/// The outside world as readers see it.
pub trait Files {
    /// The file's bytes; `Ok(None)` where there is no such file.
    fn read(&self, path: &Path) -> Result<Option<Bytes>, FormatError>;
}

/// The file system itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct DiskFiles;

impl Files for DiskFiles {
    fn read(&self, path: &Path) -> Result<Option<Bytes>, FormatError> {
        match std::fs::read(path) {
            Ok(bytes) => Ok(Some(Arc::new(bytes))),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(e) => Err(FormatError::Unreadable { file: path.to_owned(), what: e.to_string() }),
        }
    }
}

/// No file at all: for readers of bytes in memory.
pub(super) struct NoFiles;

impl Files for NoFiles {
    fn read(&self, _: &Path) -> Result<Option<Bytes>, FormatError> {
        Ok(None)
    }
}

/// `path` without `.` and `..`; `None` where it climbs above its beginning.
pub(super) fn normal(path: &Path) -> Option<PathBuf> {
    let mut out = PathBuf::new();
    for c in path.components() {
        match c {
            Component::CurDir => {}
            Component::ParentDir => match out.components().next_back() {
                Some(Component::Normal(_)) => {
                    out.pop();
                }
                _ => return None,
            },
            c => out.push(c),
        }
    }
    Some(out)
}
