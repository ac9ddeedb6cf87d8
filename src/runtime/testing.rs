//! What tests of bundles share.

use super::BundleFile;
use crate::{
    array::Bytes,
    formats::{Files, FormatError},
};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

/// Files in memory, below `b/`.
#[derive(Clone, Default)]
pub struct Memory(pub BTreeMap<PathBuf, Vec<u8>>);

impl Memory {
    pub fn of(files: &[BundleFile]) -> Self {
        Self(files.iter().map(|f| (Path::new("b").join(&f.path), f.bytes.clone())).collect())
    }
}

impl Files for Memory {
    fn read(&self, path: &Path) -> Result<Option<Bytes>, FormatError> {
        Ok(self.0.get(path).map(|b| Arc::new(b.clone()) as Bytes))
    }

    fn real(&self, path: &Path) -> Option<PathBuf> {
        self.0.contains_key(path).then(|| path.to_owned())
    }
}
