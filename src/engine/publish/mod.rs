//! Publishing: files below `out/<pipeline>/`.
//!
//! What always holds: a file is replaced whole or not at all; the manifest with all hashes comes last; only files that
//! an earlier manifest of ours lists, and that still are what it says, are ever deleted; no symbolic link below the
//! output folder is followed.

pub mod names;

use super::{cache::Cache, error::EngineError, hash::Digest};
use serde::{Deserialize, Serialize};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs, io,
    io::Write as _,
    path::{Path, PathBuf},
};

pub const MANIFEST: &str = "manifest.json";

/// A file to publish.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Below the folder, with `/`; checked.
    pub path: String,
    pub file: Digest,
    pub size: u64,
}

/// What is to lie in a folder, and how far that has come. Dropped before its end, it leaves the folder as it was.
pub struct Publication<'a> {
    root: &'a Path,
    folder: &'a Path,
    wanted: &'a [Wanted],
    manifest: Vec<u8>,
    same_manifest: bool,
    /// New files on the disk, and where they are to go.
    staged: Vec<(PathBuf, PathBuf)>,
    /// Places in `wanted` of the files that the folder does not have, or has with other bytes.
    pub missing: Vec<usize>,
}

#[derive(Serialize, Deserialize)]
struct Manifest {
    pipeline: String,
    /// By path.
    files: BTreeMap<String, Entry>,
}

#[derive(Serialize, Deserialize)]
struct Entry {
    blake3: String,
    bytes: u64,
}

impl<'a> Publication<'a> {
    /// Compares `folder`, below `root`, with `wanted`.
    pub fn new(
        root: &'a Path,
        folder: &'a Path,
        pipeline: &str,
        wanted: &'a [Wanted],
        cache: &mut Cache,
    ) -> Result<Self, EngineError> {
        let manifest = manifest(pipeline, wanted);
        let manifest_path = folder.join(MANIFEST);
        no_links(root, &manifest_path)?;
        let same_manifest = is(cache, &manifest_path, Digest::of(&manifest))?;
        let mut missing = Vec::new();
        for (at, want) in wanted.iter().enumerate() {
            let path = folder.join(&want.path);
            no_links(root, &path)?;
            if !is(cache, &path, want.file)? {
                missing.push(at);
            }
        }
        Ok(Self { root, folder, wanted, manifest, same_manifest, staged: Vec::new(), missing })
    }

    /// Writes a missing file beside its place.
    pub fn stage(&mut self, at: usize, bytes: &[u8]) -> Result<(), EngineError> {
        let path = self.folder.join(&self.wanted[at].path);
        let parent = path.parent().unwrap_or(self.folder);
        fs::create_dir_all(parent).map_err(|e| EngineError::publish(parent, e))?;
        if path.is_dir() {
            return Err(EngineError::publish(&path, "a folder is in the way"));
        }
        self.staged.push((temporary(&path, bytes)?, path));
        Ok(())
    }

    /// Moves all staged files to their places, then the manifest, then removes what the old manifest has beyond it.
    pub fn finish(mut self, cache: &mut Cache) -> Result<(), EngineError> {
        if self.staged.is_empty() && self.same_manifest {
            return Ok(());
        }
        let path = self.folder.join(MANIFEST);
        fs::create_dir_all(self.folder).map_err(|e| EngineError::publish(self.folder, e))?;
        let old = if self.same_manifest { None } else { read_manifest(&path) };
        self.staged.push((temporary(&path, &self.manifest)?, path));
        let mut folders: Vec<PathBuf> = Vec::new();
        for (from, to) in &self.staged {
            fs::rename(from, to).map_err(|e| EngineError::publish(to, e))?;
            folders.extend(to.parent().map(Path::to_owned));
        }
        folders.sort();
        folders.dedup();
        for folder in &folders {
            remove_leftovers(folder).and_then(|()| sync_folder(folder)).map_err(|e| EngineError::publish(folder, e))?;
        }
        if let Some(old) = old {
            let keep: BTreeSet<String> = self.wanted.iter().map(|w| w.path.to_lowercase()).collect();
            let stale = old.files.into_iter().filter(|(path, _)| !keep.contains(&path.to_lowercase()));
            remove(self.root, self.folder, stale, cache)?;
        }
        Ok(())
    }
}

impl Drop for Publication<'_> {
    fn drop(&mut self) {
        for (from, _) in &self.staged {
            // Not there where it was renamed.
            let _ = fs::remove_file(from);
        }
    }
}

/// Removes all that our manifest in `folder` lists, and the manifest.
pub fn retire(root: &Path, folder: &Path, cache: &mut Cache) -> Result<(), EngineError> {
    let path = folder.join(MANIFEST);
    if fs::symlink_metadata(&path).is_err() {
        return Ok(());
    }
    no_links(root, &path)?;
    let Some(manifest) = read_manifest(&path) else { return Ok(()) };
    remove(root, folder, manifest.files.into_iter(), cache)?;
    fs::remove_file(&path).map_err(|e| EngineError::publish(&path, e))?;
    // Fails where something that is not ours lies in it: that is how it should be.
    let _ = fs::remove_dir(folder);
    Ok(())
}

/// Replaces a file that is no part of the publication, unsynced: what only this run tells.
pub fn write_note(root: &Path, path: &Path, data: &[u8]) -> Result<(), EngineError> {
    no_links(root, path)?;
    let fail = |e| EngineError::publish(path, e);
    if let Some(parent) = path.parent() {
        fs::create_dir_all(parent).map_err(fail)?;
    }
    let temporary = temporary_name(path);
    fs::write(&temporary, data).and_then(|()| fs::rename(&temporary, path)).map_err(|e| {
        let _ = fs::remove_file(&temporary);
        fail(e)
    })
}

fn manifest(pipeline: &str, wanted: &[Wanted]) -> Vec<u8> {
    let entry = |w: &Wanted| (w.path.clone(), Entry { blake3: w.file.hex(), bytes: w.size });
    let manifest = Manifest { pipeline: pipeline.to_owned(), files: wanted.iter().map(entry).collect() };
    let mut out = serde_json::to_vec_pretty(&manifest).unwrap_or_default();
    out.push(b'\n');
    out
}

fn read_manifest(path: &Path) -> Option<Manifest> {
    serde_json::from_slice(&fs::read(path).ok()?).ok()
}

/// Whether `path` is a plain file with this content.
fn is(cache: &mut Cache, path: &Path, hash: Digest) -> Result<bool, EngineError> {
    match fs::symlink_metadata(path) {
        Ok(meta) if meta.is_file() => {
            let found = cache.hash_file(path).map_err(|e| EngineError::publish(path, e))?;
            Ok(found.is_some_and(|(found, _)| found == hash))
        }
        _ => Ok(false),
    }
}

/// Refuses a path that passes through a symbolic link below `root`.
fn no_links(root: &Path, path: &Path) -> Result<(), EngineError> {
    let Ok(below) = path.strip_prefix(root) else {
        return Err(EngineError::publish(path, "it lies outside the output folder"));
    };
    let mut at = root.to_owned();
    let Some(parents) = below.parent() else { return Ok(()) };
    for part in parents.components() {
        at.push(part);
        match fs::symlink_metadata(&at) {
            Ok(meta) if meta.is_symlink() => {
                return Err(EngineError::publish(
                    &at,
                    "it is a symbolic link; farfield follows none below its output folder",
                ));
            }
            Ok(meta) if !meta.is_dir() => return Err(EngineError::publish(&at, "a file is where a folder should be")),
            Ok(_) => {}
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(()),
            Err(e) => return Err(EngineError::publish(&at, e)),
        }
    }
    Ok(())
}

fn temporary_name(path: &Path) -> PathBuf {
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    path.with_file_name(format!(".{name}.{}.farfield-tmp", std::process::id()))
}

/// Removes what a killed bake left beside its files. The caller holds the folder's lock.
fn remove_leftovers(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_name().to_str().is_some_and(|n| n.starts_with('.') && n.ends_with(".farfield-tmp")) {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

/// Writes and syncs `data` beside `path`.
fn temporary(path: &Path, data: &[u8]) -> Result<PathBuf, EngineError> {
    let temporary = temporary_name(path);
    let write = || {
        // What a killed process of the same number left is ours to remove.
        match fs::remove_file(&temporary) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
            _ => {}
        }
        let mut file = fs::File::create_new(&temporary)?;
        file.write_all(data)?;
        file.sync_all()
    };
    write().map_err(|e| {
        let _ = fs::remove_file(&temporary);
        EngineError::publish(path, e)
    })?;
    Ok(temporary)
}

#[cfg(unix)]
fn sync_folder(folder: &Path) -> io::Result<()> {
    fs::File::open(folder)?.sync_all()
}

#[cfg(not(unix))]
fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

/// Deletes files of an earlier publication that still are what its manifest says.
fn remove(
    root: &Path,
    folder: &Path,
    stale: impl Iterator<Item = (String, Entry)>,
    cache: &mut Cache,
) -> Result<(), EngineError> {
    for (name, entry) in stale {
        // A manifest is a file that anyone may have edited.
        if names::bad_path(&name).is_some() {
            continue;
        }
        let path = folder.join(&name);
        no_links(root, &path)?;
        let ours = Digest::from_hex(&entry.blake3).map(|hash| is(cache, &path, hash)).transpose()?;
        if ours == Some(true) {
            fs::remove_file(&path).map_err(|e| EngineError::publish(&path, e))?;
            let mut parent = path.parent();
            while let Some(p) = parent.filter(|p| *p != folder && fs::remove_dir(p).is_ok()) {
                parent = p.parent();
            }
        }
    }
    Ok(())
}
