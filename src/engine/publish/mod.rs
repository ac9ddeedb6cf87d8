//! Publishing: files below `out/<pipeline>/`.
//!
//! What always holds: a file is replaced whole or not at all; the manifest with all hashes comes last; nothing is
//! replaced that a bake reads or that no list of ours names (unless the user says so); only files that an earlier
//! list of ours names, and that still are what it says, are ever deleted; no symbolic link below the output folder is
//! followed. What is refused is refused before the first file is touched.

pub mod guard;
mod manifest;
pub mod names;
pub mod page;
mod staging;
pub mod table;

pub use manifest::{MANIFEST, Manifest};
pub use staging::{FolderLock, is_read_only};

use super::{cache::Cache, error::EngineError, hash::Digest};
use guard::Guard;
use manifest::{Entry, Found, Ours, PENDING};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    io::{self, Read as _},
    path::{Path, PathBuf},
    time::SystemTime,
};

/// What only one run tells: times, memory, hits.
pub const RUN: &str = "run.json";

/// A file to publish.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// Below the folder, with `/`; checked.
    pub path: String,
    pub file: Digest,
    pub size: u64,
}

/// An output folder and the rules for what may be replaced in it.
#[derive(Clone, Copy)]
pub struct Folder<'a> {
    /// The folder that the user named; no link below it is followed.
    pub root: &'a Path,
    pub path: &'a Path,
    /// What the bake reads.
    pub guard: &'a Guard,
    /// Files that are not ours may be replaced, unless the bake reads them.
    pub overwrite: bool,
}

/// What is to lie in a folder, and how far that has come. Dropped before its end, it leaves the folder as it was.
pub struct Publication<'a> {
    folder: Folder<'a>,
    /// `None` where nothing can be written.
    lock: Option<&'a FolderLock>,
    wanted: &'a [Wanted],
    manifest: Vec<u8>,
    same_manifest: bool,
    ours: Ours,
    /// New files on the disk, and where they are to go.
    staged: Vec<(PathBuf, PathBuf)>,
    /// Places in `wanted` of the files that the folder does not have, or has with other bytes.
    pub missing: Vec<usize>,
}

impl<'a> Publication<'a> {
    /// Compares the folder with `wanted`; refuses if something may not be replaced. Without the folder's lock, only a
    /// folder in which nothing is to be done is no error.
    pub fn new(
        folder: Folder<'a>,
        lock: Option<&'a FolderLock>,
        manifest: &Manifest,
        wanted: &'a [Wanted],
        cache: &mut Cache,
    ) -> Result<Self, EngineError> {
        let manifest = manifest.to_bytes();
        let manifest_path = folder.path.join(MANIFEST);
        no_links(folder.root, &manifest_path)?;
        let same_manifest = is(cache, &manifest_path, Digest::of(&manifest));
        let ours = Ours::read(folder.path);
        let mut missing = Vec::new();
        for (at, want) in wanted.iter().enumerate() {
            let path = folder.path.join(&want.path);
            no_links(folder.root, &path)?;
            folder.spare(&path)?;
            if !is(cache, &path, want.file) {
                folder.replaceable(&want.path, &ours)?;
                missing.push(at);
            }
        }
        folder.spare(&manifest_path)?;
        match &ours.manifest {
            Found::Foreign if !folder.overwrite => return Err(not_ours(&manifest_path)),
            // What it names is not known: the file that is refused for that is the one to tell.
            Found::Foreign | Found::Nothing | Found::Ours(_) | Found::Unreadable(_) => {}
        }
        if manifest_path.is_dir() {
            return Err(in_the_way(&manifest_path));
        }
        Ok(Self { folder, lock, wanted, manifest, same_manifest, ours, staged: Vec::new(), missing })
    }

    /// The manifest that the publication replaces, if it does.
    pub fn replaces(&self) -> Option<&Manifest> {
        match &self.ours.manifest {
            Found::Ours(manifest) if !self.same_manifest => Some(manifest),
            _ => None,
        }
    }

    /// Writes a missing file beside its place.
    pub fn stage(&mut self, at: usize, bytes: &[u8]) -> Result<(), EngineError> {
        if self.staged.is_empty() {
            self.announce()?;
        }
        let path = self.folder.path.join(&self.wanted[at].path);
        self.stage_at(path, bytes)
    }

    fn stage_at(&mut self, path: PathBuf, bytes: &[u8]) -> Result<(), EngineError> {
        let parent = path.parent().unwrap_or(self.folder.path);
        fs::create_dir_all(parent).map_err(|e| EngineError::publish(parent, e))?;
        let temporary = self.locked(&path)?.stage(&path, bytes).map_err(|e| EngineError::publish(&path, e))?;
        self.staged.push((temporary, path));
        Ok(())
    }

    fn locked(&self, path: &Path) -> Result<&'a FolderLock, EngineError> {
        self.lock.ok_or_else(|| EngineError::publish(path, "the output folder cannot be written"))
    }

    /// Names the files that will be new, so that a bake after a kill knows them as ours.
    fn announce(&self) -> Result<(), EngineError> {
        let known = |w: &Wanted| self.ours.lists().any(|m| m.files.contains_key(&w.path));
        if self.wanted.iter().all(known) {
            return Ok(());
        }
        let mut files: BTreeMap<String, Entry> = BTreeMap::new();
        if let Some(pending) = &self.ours.pending {
            files.extend(pending.files.clone());
        }
        files.extend(self.wanted.iter().map(|w| (w.path.clone(), Entry { blake3: w.file.hex(), bytes: w.size })));
        let list = Manifest { files, ..Manifest::default() };
        let path = self.folder.path.join(PENDING);
        fs::create_dir_all(self.folder.path).map_err(|e| EngineError::publish(self.folder.path, e))?;
        self.locked(&path)?.replace(&path, &list.to_bytes()).map_err(|e| EngineError::publish(&path, e))
    }

    /// Moves all staged files to their places, then the manifest, then removes what the old manifest has beyond it.
    pub fn finish(mut self, cache: &mut Cache) -> Result<(), EngineError> {
        let nothing = self.staged.is_empty() && self.same_manifest && self.ours.pending.is_none();
        let Some(lock) = self.lock else {
            return if nothing { Ok(()) } else { self.locked(self.folder.path).map(drop) };
        };
        let folders = self.folders();
        if !nothing {
            if !self.same_manifest {
                let manifest = std::mem::take(&mut self.manifest);
                self.stage_at(self.folder.path.join(MANIFEST), &manifest)?;
            }
            for (from, to) in &self.staged {
                fs::rename(from, to).map_err(|e| EngineError::publish(to, e))?;
            }
            for folder in self.staged.iter().filter_map(|(_, to)| to.parent()).collect::<BTreeSet<_>>() {
                sync_folder(folder).map_err(|e| EngineError::publish(folder, e))?;
            }
            let keep: BTreeSet<String> = self.wanted.iter().map(|w| w.path.to_lowercase()).collect();
            let stale = self.ours.lists().flat_map(|m| &m.files);
            remove(self.folder, stale.filter(|(path, _)| !keep.contains(&path.to_lowercase())), cache)?;
            let pending = self.folder.path.join(PENDING);
            delete(&pending).map_err(|e| EngineError::publish(&pending, e))?;
        }
        folders.iter().try_for_each(|folder| lock.sweep(folder).map_err(|e| EngineError::publish(folder, e)))
    }

    /// The folders in which a publication of ours may have left temporary files.
    fn folders(&self) -> BTreeSet<PathBuf> {
        let wanted = self.wanted.iter().map(|w| w.path.as_str());
        let listed = self.ours.lists().flat_map(|m| m.files.keys()).map(String::as_str);
        folders(self.folder, wanted.chain(listed))
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

impl Folder<'_> {
    /// Refuses before anything runs what can be known then: `paths` (below the folder) that lead to a file that the
    /// bake reads, or to one that is neither in a list of ours nor `known` by its content.
    pub fn check<'p>(
        self,
        paths: impl Iterator<Item = &'p str>,
        known: impl Fn(&str) -> Option<Digest>,
        cache: &mut Cache,
    ) -> Result<(), EngineError> {
        let ours = Ours::read(self.path);
        for path in paths.chain([RUN, MANIFEST]) {
            let full = self.path.join(path);
            no_links(self.root, &full)?;
            self.spare(&full)?;
            if ![RUN, MANIFEST].contains(&path) && known(path).is_none_or(|hash| !is(cache, &full, hash)) {
                // Another bake may have published it since the lists were read; no lock is held here.
                self.replaceable(path, &ours).or_else(|_| self.replaceable(path, &Ours::read(self.path)))?;
            }
        }
        if matches!(ours.manifest, Found::Foreign) && !self.overwrite {
            return Err(not_ours(&self.path.join(MANIFEST)));
        }
        let run = self.path.join(RUN);
        if !self.overwrite && fs::symlink_metadata(&run).is_ok() && !is_note(&run) {
            return Err(not_ours(&run));
        }
        Ok(())
    }

    /// Refuses a path at which there is a file that the bake reads.
    fn spare(self, path: &Path) -> Result<(), EngineError> {
        let Some(read) = self.guard.holds(path) else { return Ok(()) };
        let same = if read == path { String::new() } else { format!(" (as {})", read.display()) };
        let what = format!(
            "this bake reads that file{same}, and would destroy it; give the file another path in [files], or the \
             results another folder with --out or --name"
        );
        Err(EngineError::publish(path, what))
    }

    /// Refuses a path at which there is something that is not ours to replace.
    fn replaceable(self, path: &str, ours: &Ours) -> Result<(), EngineError> {
        let full = self.path.join(path);
        match fs::symlink_metadata(&full) {
            Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => Ok(()),
            Err(e) => Err(EngineError::publish(&full, e)),
            Ok(meta) if meta.is_dir() => Err(in_the_way(&full)),
            Ok(_) if self.overwrite || ours.names(self.path, path) => Ok(()),
            Ok(_) => Err(match &ours.manifest {
                Found::Unreadable(e) => {
                    let manifest = self.path.join(MANIFEST);
                    let what = format!(
                        "it cannot be read ({e}), so that nothing tells whether {path} is farfield's to replace; make \
                         it readable, or say --overwrite"
                    );
                    EngineError::publish(&manifest, what)
                }
                _ => not_ours(&full),
            }),
        }
    }
}

fn not_ours(path: &Path) -> EngineError {
    let what = "there is a file that farfield did not write; move it away, or give the results another folder with \
                --out or --name, or replace it with --overwrite";
    EngineError::publish(path, what)
}

fn in_the_way(path: &Path) -> EngineError {
    EngineError::publish(path, "there is a folder, where a file is to lie; move it away")
}

/// When the results that lie in `folder` were published; `None` where none do.
pub fn published_at(folder: &Path) -> Option<SystemTime> {
    let path = folder.join(MANIFEST);
    Found::read(&path).ours()?;
    fs::metadata(path).ok()?.modified().ok()
}

/// Removes all that our lists in the folder name, and the lists.
pub fn retire(folder: Folder, lock: Option<&FolderLock>, cache: &mut Cache) -> Result<(), EngineError> {
    let ours = Ours::read(folder.path);
    if ours.lists().next().is_none() {
        return Ok(());
    }
    let path = folder.path.join(MANIFEST);
    no_links(folder.root, &path)?;
    let lock = lock.ok_or_else(|| EngineError::publish(folder.path, "the folder cannot be written"))?;
    let fail = |path: &Path, e: io::Error| EngineError::publish(path, e);
    for at in folders(folder, ours.lists().flat_map(|m| m.files.keys()).map(String::as_str)) {
        lock.sweep(&at).map_err(|e| fail(&at, e))?;
    }
    remove(folder, ours.lists().flat_map(|m| &m.files), cache)?;
    for name in [MANIFEST, PENDING] {
        let path = folder.path.join(name);
        if Found::read(&path).ours().is_some() && folder.guard.holds(&path).is_none() {
            delete(&path).map_err(|e| fail(&path, e))?;
        }
    }
    page::remove(folder)?;
    // Fails where something that is not ours lies in it: that is how it should be.
    let _ = fs::remove_dir(folder.path);
    Ok(())
}

/// Replaces `run.json`, which is no part of the publication, unsynced.
pub fn write_note(folder: Folder, lock: &FolderLock, data: &[u8]) -> Result<(), EngineError> {
    let path = folder.path.join(RUN);
    no_links(folder.root, &path)?;
    folder.spare(&path)?;
    let fail = |e| EngineError::publish(&path, e);
    fs::create_dir_all(folder.path).map_err(fail)?;
    lock.sweep(folder.path).and_then(|()| lock.replace(&path, data)).map_err(fail)
}

/// How such a note begins.
pub const NOTE: &str = "{\n  \"outcome\": \"";

/// Whether a file is such a note, by its beginning: it has a line for every node.
fn is_note(path: &Path) -> bool {
    let plain = fs::symlink_metadata(path).is_ok_and(|meta| meta.is_file());
    let mut head = [0; NOTE.len()];
    let mut read = || fs::File::open(path)?.read_exact(&mut head);
    plain && read().is_ok() && head == NOTE.as_bytes()
}

/// Whether `path` is a plain file with this content. One that cannot be read is not.
fn is(cache: &mut Cache, path: &Path, hash: Digest) -> bool {
    let plain = fs::symlink_metadata(path).is_ok_and(|meta| meta.is_file());
    plain && cache.hash_file(path).is_ok_and(|found| found.is_some_and(|(found, _)| found == hash))
}

/// The folder itself and those of `paths` in it; no link is followed.
fn folders<'p>(folder: Folder, paths: impl Iterator<Item = &'p str>) -> BTreeSet<PathBuf> {
    // A list is a file that anyone may have edited.
    let parents = paths.filter_map(|p| p.rsplit_once('/')).map(|(parent, _)| parent).collect::<BTreeSet<&str>>();
    let parents = parents.into_iter().filter(|p| names::bad_path(p).is_none()).map(|p| folder.path.join(p));
    let mut out: BTreeSet<PathBuf> = parents.filter(|p| no_links(folder.root, &p.join(MANIFEST)).is_ok()).collect();
    out.insert(folder.path.to_owned());
    out
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

/// Deletes a file, if there is one.
fn delete(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
        _ => Ok(()),
    }
}

#[cfg(unix)]
fn sync_folder(folder: &Path) -> io::Result<()> {
    fs::File::open(folder)?.sync_all()
}

#[cfg(not(unix))]
fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

/// Deletes files of an earlier publication that still are what its list says, and that the bake does not read.
fn remove<'m>(
    folder: Folder,
    stale: impl Iterator<Item = (&'m String, &'m Entry)>,
    cache: &mut Cache,
) -> Result<(), EngineError> {
    for (name, entry) in stale {
        // A manifest is a file that anyone may have edited.
        if names::bad_path(name).is_some() {
            continue;
        }
        let path = folder.path.join(name);
        if no_links(folder.root, &path).is_err() {
            continue;
        }
        let same = Digest::from_hex(&entry.blake3).is_some_and(|hash| is(cache, &path, hash));
        if same && folder.guard.holds(&path).is_none() {
            delete(&path).map_err(|e| EngineError::publish(&path, e))?;
            let mut parent = path.parent();
            while let Some(p) = parent.filter(|p| *p != folder.path && fs::remove_dir(p).is_ok()) {
                parent = p.parent();
            }
        }
    }
    Ok(())
}
