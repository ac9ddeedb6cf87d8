//! Bundles as their readers see them.

use crate::{
    array::Bytes,
    engine::plan::Bundle,
    formats::{Files, FormatError},
};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// A bundle as its readers see it.
pub struct Contents<'a>(pub &'a Bundle);

impl Files for Contents<'_> {
    fn read(&self, path: &Path) -> Result<Option<Bytes>, FormatError> {
        let name = path.to_str().map(|p| p.replace('\\', "/"));
        let file = name.and_then(|name| self.0.files().get(&name));
        Ok(file.map(|f| Arc::new(f.bytes.clone()) as Bytes))
    }

    fn real(&self, path: &Path) -> Option<PathBuf> {
        Some(path.to_owned())
    }
}
