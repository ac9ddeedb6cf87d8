//! Large values as files named by the hash of their bytes, compressed where that saves a quarter. A file is written under a temporary name, made read-only, and renamed:
//! under its final name it is whole or absent. Nothing is synced, because every read verifies (once per process) and a
//! loss costs one recomputation.

use super::pack;
use crate::{
    array::Bytes,
    engine::{hash::Digest, temporary},
};
use std::{
    fs, io,
    io::Write,
    path::{Path, PathBuf},
};

/// Values up to this many bytes lie in the index.
pub const INLINE: usize = 16 << 10;
/// Files from this many bytes on are mapped; smaller ones are read, since maps are few per process.
const MAP: u64 = 1 << 20;

/// Why a stored value cannot be used: it is absent, cannot be read, or is not the bytes that its name says. All of these
/// are mended by making it again.
#[derive(Debug)]
pub struct Bad(pub String);

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
        self.root.join("tmp").join(temporary::name())
    }

    /// Stores `bytes`, whose hash is `hash`. Afterwards the file is sound: one that was there is read, since the
    /// cache counts as verified what a run has just stored. Gives the bytes that the file takes.
    pub fn put(&self, hash: &Digest, bytes: &[u8]) -> io::Result<u64> {
        let path = self.path(hash);
        if self.get(hash, false).is_ok() {
            // A sweep in another process spares what was touched after that process's bake began.
            if let Ok(file) = fs::File::open(&path) {
                let _ = file.set_modified(std::time::SystemTime::now());
                return Ok(file.metadata()?.len());
            }
        }
        if fs::symlink_metadata(&path).is_ok_and(|meta| !meta.is_file()) {
            self.set_aside(hash);
        }
        let packed = pack::pack(bytes);
        let bytes = packed.as_deref().unwrap_or(bytes);
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
        })?;
        Ok(bytes.len() as u64)
    }

    /// The value's bytes, from a map where they are many and lie there as they are.
    pub fn get(&self, hash: &Digest, verified: bool) -> Result<Bytes, Bad> {
        let read = || -> io::Result<Option<Bytes>> {
            let path = self.path(hash);
            // A pipe or a device would block or never end; a link may lead to one.
            if !fs::symlink_metadata(&path)?.is_file() {
                return Ok(None);
            }
            let file = fs::File::open(path)?;
            if file.metadata()?.len() >= MAP {
                return Ok(Some(std::sync::Arc::new(map(&file)?)));
            }
            let mut all = Vec::new();
            io::Read::read_to_end(&mut &file, &mut all)?;
            Ok(Some(std::sync::Arc::new(all)))
        };
        let bytes = match read() {
            Ok(Some(bytes)) => bytes,
            Ok(None) => return Err(Bad("it is no plain file".to_owned())),
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Err(Bad("its file is missing".to_owned())),
            Err(e) => return Err(Bad(format!("its file cannot be read: {e}"))),
        };
        let bytes = match pack::is_packed((*bytes).as_ref()) {
            true => std::sync::Arc::new(pack::unpack((*bytes).as_ref()).map_err(Bad)?),
            false => bytes,
        };
        if !verified && Digest::of((*bytes).as_ref()) != *hash {
            return Err(Bad("its bytes are not what its hash says".to_owned()));
        }
        Ok(bytes)
    }

    /// The value's file as it is, compressed or not; its bytes are checked.
    pub fn packed(&self, hash: &Digest) -> Result<Vec<u8>, Bad> {
        let path = self.path(hash);
        if !fs::symlink_metadata(&path).is_ok_and(|meta| meta.is_file()) {
            return Err(Bad("it is no plain file, or missing".to_owned()));
        }
        let all = fs::read(&path).map_err(|e| Bad(format!("its file cannot be read: {e}")))?;
        let found = match pack::is_packed(&all) {
            true => Digest::of(&pack::unpack(&all).map_err(Bad)?),
            false => Digest::of(&all),
        };
        if found == *hash { Ok(all) } else { Err(Bad("its bytes are not what its hash says".to_owned())) }
    }

    /// Moves a bad value out of the way, so that its producer can store a good one. Where that cannot be done it stays,
    /// and a good one replaces it.
    pub fn set_aside(&self, hash: &Digest) {
        let (from, aside) = (self.path(hash), self.root.join("bad"));
        let _ = fs::create_dir_all(&aside);
        let moved = fs::rename(&from, aside.join(hash.hex()));
        if moved.is_err_and(|e| e.kind() != io::ErrorKind::NotFound) {
            let _ = fs::rename(&from, aside.join(format!("{}.{}", hash.hex(), temporary::random())));
        }
    }

    /// Whether a file in `bad` has a name that [`Self::set_aside`] gives.
    pub fn is_aside(file_name: &str) -> bool {
        let (hash, rest) = file_name.split_at_checked(64).unwrap_or((file_name, ""));
        is_hash(hash) && (rest.is_empty() || rest.strip_prefix('.').is_some_and(temporary::is_random))
    }

    /// Every value file with its size and time of last use. What is no plain file, or has no name of a value, is passed
    /// over; no link is followed.
    pub fn each(&self, mut f: impl FnMut(Digest, &fs::Metadata, &Path) -> io::Result<()>) -> io::Result<()> {
        let root = self.root.join("values");
        if !fs::symlink_metadata(&root).is_ok_and(|meta| meta.is_dir()) {
            return Ok(());
        }
        for folder in fs::read_dir(root)? {
            let folder = folder?;
            if !folder.file_type()?.is_dir() {
                continue;
            }
            for entry in fs::read_dir(folder.path())? {
                let entry = entry?;
                let name = entry.file_name();
                let Some(name) = name.to_str().filter(|n| is_hash(n) && folder.file_name() == n[..2]) else { continue };
                let Some(hash) = Digest::from_hex(name) else { continue };
                match entry.metadata() {
                    Ok(meta) if meta.is_file() => f(hash, &meta, &entry.path())?,
                    Ok(_) => {}
                    Err(e) if e.kind() == io::ErrorKind::NotFound => {}
                    Err(e) => return Err(e),
                }
            }
        }
        Ok(())
    }
}

/// Whether `text` is a hash as files are named by it.
fn is_hash(text: &str) -> bool {
    text.len() == 64 && text.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'))
}

#[expect(unsafe_code, reason = "value files are read-only and replaced by rename, never written in place")]
fn map(file: &fs::File) -> io::Result<memmap2::Mmap> {
    // SAFETY: whoever truncates a file of the cache by hand while a bake maps it ends that bake; no program of ours does.
    unsafe { memmap2::Mmap::map(file) }
}
