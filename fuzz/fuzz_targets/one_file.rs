//! A world of one file, under limits that make a large allocation a finding.

use farfield::{
    array::Bytes,
    formats::{Files, FormatError, Limits, load},
};
use std::{path::Path, sync::Arc};

struct One<'a>(&'a Path, &'a [u8]);

impl Files for One<'_> {
    fn read(&self, path: &Path) -> Result<Option<Bytes>, FormatError> {
        Ok((path == self.0).then(|| Arc::new(self.1.to_vec()) as Bytes))
    }

    fn real(&self, _: &Path) -> Option<std::path::PathBuf> {
        None
    }
}

pub fn try_load(name: &str, bytes: &[u8]) {
    let path = Path::new(name);
    let limits =
        Limits { texels: 1 << 16, vertices: 1 << 16, triangles: 1 << 16, objects: 1 << 10, implied: 1 << 8, ..Limits::default() };
    let _ = load(path, &One(path, bytes), &limits);
}
