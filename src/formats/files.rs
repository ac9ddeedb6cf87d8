//! Where readers get their bytes from.

use super::FormatError;
use crate::{array::Bytes, regular};
use std::{
    io::ErrorKind,
    path::{Component, Path, PathBuf},
    sync::Arc,
};

/// The outside world as readers see it.
pub trait Files {
    /// The file's bytes; `Ok(None)` where there is no such file.
    fn read(&self, path: &Path) -> Result<Option<Bytes>, FormatError>;

    /// The path without symbolic links; `None` where there is no such file.
    fn real(&self, path: &Path) -> Option<PathBuf>;
}

/// The file system itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct DiskFiles;

impl Files for DiskFiles {
    fn read(&self, path: &Path) -> Result<Option<Bytes>, FormatError> {
        match regular::read(path) {
            Ok(bytes) => Ok(Some(Arc::new(bytes))),
            Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(None),
            Err(e) => Err(FormatError::Unreadable { file: path.to_owned(), what: e.to_string() }),
        }
    }

    fn real(&self, path: &Path) -> Option<PathBuf> {
        real(path)
    }
}

/// No file at all: for readers of bytes in memory.
pub(super) struct NoFiles;

impl Files for NoFiles {
    fn read(&self, _: &Path) -> Result<Option<Bytes>, FormatError> {
        Ok(None)
    }

    fn real(&self, _: &Path) -> Option<PathBuf> {
        None
    }
}

/// `path` on disk without symbolic links; `None` where it leads to nothing.
pub fn real(path: &Path) -> Option<PathBuf> {
    std::fs::canonicalize(path).ok()
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
