//! Large values as files named by their hash. A file is written under a temporary name, made read-only, and renamed:
//! under its final name it is whole or absent. Nothing is synced, because every read verifies (once per process) and a
//! loss costs one recomputation.

use crate::{array::Bytes, engine::hash::Digest};
use std::{
    fs, io,
    io::Write,
    path::{Path, PathBuf},
    sync::atomic::{AtomicU64, Ordering},
};

/// Values up to this many bytes lie in the index.
pub const INLINE: usize = 16 << 10;
/// Files from this many bytes on are mapped; smaller ones are read, since maps are few per process.
const MAP: u64 = 1 << 20;

/// Why a stored value cannot be used.
#[derive(Debug)]
pub enum BlobError {
    /// Absent, or not the bytes that its name says.
    Bad(String),
    Io(io::Error),
}

/// The folder of value files. Cheap to share with tasks; holds no lock.
#[derive(Clone, Debug)]
pub struct Blobs {
    root: PathBuf,
}

impl Blobs {
    pub fn new(cache: &Path) -> Self {
        Self { root: cache.to_owned() }
    }

    pub fn path(&self, hash: &Digest) -> PathBuf {
        let hex = hash.hex();
        self.root.join("values").join(&hex[..2]).join(hex)
    }

    /// Where files grow before they are whole.
    pub fn temporary(&self) -> PathBuf {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        self.root.join("tmp").join(format!("{}-{n}", std::process::id()))
    }

    /// Stores `bytes`, whose hash is `hash`. Afterwards the file is sound: one that was there is read, since the
    /// cache counts as verified what a run has just stored.
    pub fn put(&self, hash: &Digest, bytes: &[u8]) -> io::Result<()> {
        let path = self.path(hash);
        if self.get(hash, false).is_ok() {
            // A sweep in another process spares what was touched after that process's bake began.
            if let Ok(file) = fs::File::open(&path) {
                let _ = file.set_modified(std::time::SystemTime::now());
            }
            return Ok(());
        }
        let temporary = self.temporary();
        let write = || {
            let mut file = fs::File::create_new(&temporary)?;
            file.write_all(bytes)?;
            let mut permissions = file.metadata()?.permissions();
            permissions.set_readonly(true);
            #[cfg(unix)]
            std::os::unix::fs::PermissionsExt::set_mode(&mut permissions, 0o444);
            file.set_permissions(permissions)?;
            match fs::rename(&temporary, &path) {
                Err(e) if e.kind() == io::ErrorKind::NotFound => {
                    fs::create_dir_all(path.parent().unwrap_or(&self.root))?;
                    fs::rename(&temporary, &path)
                }
                other => other,
            }
        };
        write().inspect_err(|_| {
            let _ = fs::remove_file(&temporary);
        })
    }

    /// The value's bytes, from a map where they are many.
    pub fn get(&self, hash: &Digest, verified: bool) -> Result<Bytes, BlobError> {
        let absent = |e: io::Error| match e.kind() {
            io::ErrorKind::NotFound => BlobError::Bad("its file is missing".to_owned()),
            _ => BlobError::Io(e),
        };
        let file = fs::File::open(self.path(hash)).map_err(absent)?;
        let bytes: Bytes = if file.metadata().map_err(BlobError::Io)?.len() >= MAP {
            std::sync::Arc::new(map(&file).map_err(BlobError::Io)?)
        } else {
            let mut all = Vec::new();
            io::Read::read_to_end(&mut &file, &mut all).map_err(BlobError::Io)?;
            std::sync::Arc::new(all)
        };
        if !verified && Digest::of((*bytes).as_ref()) != *hash {
            return Err(BlobError::Bad("its bytes are not what its hash says".to_owned()));
        }
        Ok(bytes)
    }

    /// Moves a bad value out of the way, so that its producer can store a good one.
    pub fn set_aside(&self, hash: &Digest) -> io::Result<()> {
        let aside = self.root.join("bad");
        fs::create_dir_all(&aside)?;
        match fs::rename(self.path(hash), aside.join(hash.hex())) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(()),
            other => other,
        }
    }

    /// Every value file with its size and time of last use; what is no value file is passed over.
    pub fn each(&self, mut f: impl FnMut(Digest, &fs::Metadata, &Path) -> io::Result<()>) -> io::Result<()> {
        let folders = match fs::read_dir(self.root.join("values")) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(()),
            other => other?,
        };
        for folder in folders {
            let folder = folder?.path();
            if !folder.is_dir() {
                continue;
            }
            for entry in fs::read_dir(folder)? {
                let entry = entry?;
                let name = entry.file_name();
                if let Some(hash) = name.to_str().and_then(Digest::from_hex) {
                    match entry.metadata() {
                        Ok(meta) => f(hash, &meta, &entry.path())?,
                        Err(e) if e.kind() == io::ErrorKind::NotFound => {}
                        Err(e) => return Err(e),
                    }
                }
            }
        }
        Ok(())
    }
}

#[expect(unsafe_code, reason = "value files are read-only and replaced by rename, never written in place")]
fn map(file: &fs::File) -> io::Result<memmap2::Mmap> {
    // SAFETY: whoever truncates a file of the cache by hand while a bake maps it ends that bake; no program of ours does.
    unsafe { memmap2::Mmap::map(file) }
}
