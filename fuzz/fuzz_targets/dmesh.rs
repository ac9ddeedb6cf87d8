#![no_main]

use farfield::{
    array::Bytes,
    formats::{Files, FormatError, Limits},
    runtime::dmesh::{Model, read},
};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// The bytes, cut at the first 0xff into `dmesh.json` and what every other file holds.
struct Two<'a>(&'a [u8], &'a [u8]);

impl Files for Two<'_> {
    fn read(&self, path: &Path) -> Result<Option<Bytes>, FormatError> {
        let bytes = if path.ends_with("dmesh.json") { self.0 } else { self.1 };
        Ok(Some(Arc::new(bytes.to_vec())))
    }

    fn real(&self, _: &Path) -> Option<PathBuf> {
        None
    }
}

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let cut = data.iter().position(|b| *b == 0xff).unwrap_or(data.len());
    let (json, rest) = data.split_at(cut);
    let limits = Limits { texels: 1 << 16, vertices: 1 << 16, triangles: 1 << 16, implied: 1 << 8, ..Limits::default() };
    if let Ok(bundle) = read(Path::new("b"), &Two(json, rest.get(1..).unwrap_or_default()), &limits) {
        let _ = Model::new(bundle.dmesh);
    }
});
