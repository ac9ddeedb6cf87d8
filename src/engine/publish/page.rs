//! `report.html`: a page about the files beside it. It is no part of the publication, because it tells times; the manifest does not name it.
//! Its beginning says that it is ours and of which publication it tells.

use super::{Folder, FolderLock, delete, in_the_way, no_links, not_ours};
use crate::engine::{error::EngineError, hash::Digest};
use std::{
    fs,
    io::{self, Read as _},
    path::Path,
};

pub const REPORT: &str = "report.html";

/// How a report of ours begins; the digest of what it tells of follows.
const HEAD: &str = "<!doctype html>\n<!-- farfield report ";

/// What lies at a report's place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    Nothing,
    /// A report of ours, and of what.
    Ours(Digest),
    /// Something else.
    Other,
}

/// What lies at the report's place in `folder`; its beginning alone is read.
pub fn find(folder: &Path) -> Found {
    let path = folder.join(REPORT);
    match fs::symlink_metadata(&path) {
        Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => return Found::Nothing,
        Ok(meta) if meta.is_file() => {}
        _ => return Found::Other,
    }
    let mut head = [0; HEAD.len() + 64];
    let read = fs::File::open(path).and_then(|mut file| file.read_exact(&mut head));
    let text = read.ok().and_then(|()| std::str::from_utf8(&head).ok());
    text.and_then(|t| Digest::from_hex(t.strip_prefix(HEAD)?)).map_or(Found::Other, Found::Ours)
}

/// Writes a report about `of`, unsynced. What is not ours is not replaced, unless `folder` says so; what the bake reads never is.
pub fn write(folder: Folder, lock: Option<&FolderLock>, of: Digest, document: &str) -> Result<(), EngineError> {
    let path = folder.path.join(REPORT);
    no_links(folder.root, &path)?;
    folder.spare(&path)?;
    if fs::symlink_metadata(&path).is_ok_and(|meta| meta.is_dir()) {
        return Err(in_the_way(&path));
    }
    if find(folder.path) == Found::Other && !folder.overwrite {
        return Err(not_ours(&path));
    }
    let lock = lock.ok_or_else(|| EngineError::publish(&path, "the output folder cannot be written"))?;
    let fail = |e| EngineError::publish(&path, e);
    fs::create_dir_all(folder.path).map_err(fail)?;
    lock.replace(&path, format!("{HEAD}{} -->\n{document}", of.hex()).as_bytes()).map_err(fail)
}

/// Removes a report of ours that the bake does not read. The folder's lock is held.
pub fn remove(folder: Folder) -> Result<(), EngineError> {
    let path = folder.path.join(REPORT);
    if no_links(folder.root, &path).is_err() || folder.guard.holds(&path).is_some() {
        return Ok(());
    }
    match find(folder.path) {
        Found::Ours(_) => delete(&path).map_err(|e| EngineError::publish(&path, e)),
        Found::Nothing | Found::Other => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::publish::guard::Guard;

    #[test]
    fn reports_are_replaced_and_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let (root, path) = (dir.path().to_owned(), dir.path().join("a"));
        let guard = Guard::default();
        let folder = Folder { root: &root, path: &path, guard: &guard, overwrite: false };
        let lock = FolderLock::take(&root, "a").unwrap().unwrap();
        let (one, two) = (Digest::of(b"1"), Digest::of(b"2"));
        assert_eq!(find(&path), Found::Nothing);
        write(folder, Some(&lock), one, "<html>1").unwrap();
        assert_eq!(find(&path), Found::Ours(one));
        write(folder, Some(&lock), two, "<html>2").unwrap();
        let text = fs::read_to_string(path.join(REPORT)).unwrap();
        assert!(text.starts_with("<!doctype html>\n<!--") && text.ends_with("-->\n<html>2"), "{text}");
        assert!(write(folder, None, one, "").unwrap_err().to_string().contains("cannot be written"));
        // What somebody else wrote stays, unless the user wants it replaced.
        let others = "<!doctype html>\n<title>mine</title>".repeat(9);
        fs::write(path.join(REPORT), &others).unwrap();
        assert!(write(folder, Some(&lock), one, "").unwrap_err().to_string().contains("did not write"));
        remove(folder).unwrap();
        assert_eq!(fs::read_to_string(path.join(REPORT)).unwrap(), others);
        // What the bake reads stays even then.
        let reads = Guard::new([path.join(REPORT)]);
        let overwriting = Folder { overwrite: true, ..folder };
        assert!(write(Folder { guard: &reads, ..overwriting }, Some(&lock), one, "").is_err());
        write(overwriting, Some(&lock), one, "").unwrap();
        assert_eq!(find(&path), Found::Ours(one));
        remove(folder).unwrap();
        assert_eq!(find(&path), Found::Nothing);
        fs::create_dir(path.join(REPORT)).unwrap();
        assert!(write(overwriting, Some(&lock), one, "").unwrap_err().to_string().contains("folder"));
    }

    #[cfg(unix)]
    #[test]
    fn no_link_is_followed() {
        let dir = tempfile::tempdir().unwrap();
        let (root, path) = (dir.path().join("out"), dir.path().join("out/a"));
        let lock = FolderLock::take(&root, "a").unwrap().unwrap();
        let guard = Guard::default();
        let folder = Folder { root: &root, path: &path, guard: &guard, overwrite: true };
        fs::create_dir(&path).unwrap();
        let kept = dir.path().join("kept.html");
        fs::write(&kept, "kept").unwrap();
        std::os::unix::fs::symlink(&kept, path.join(REPORT)).unwrap();
        assert_eq!(find(&path), Found::Other);
        assert!(write(Folder { overwrite: false, ..folder }, Some(&lock), Digest::of(b""), "x").is_err());
        // The link itself is replaced, not what it leads to.
        write(folder, Some(&lock), Digest::of(b""), "x").unwrap();
        assert_eq!(fs::read_to_string(&kept).unwrap(), "kept");
        fs::remove_dir_all(&path).unwrap();
        fs::create_dir(dir.path().join("elsewhere")).unwrap();
        std::os::unix::fs::symlink(dir.path().join("elsewhere"), &path).unwrap();
        assert!(write(folder, Some(&lock), Digest::of(b""), "x").unwrap_err().to_string().contains("symbolic link"));
    }
}
