//! Which folders are caches of ours. `--cache` may name any folder, and a sweep deletes files, so a folder is taken only
//! if it is new, empty, or bears our marker. A cache from before there were markers is known by its index.

use super::layout;
use crate::engine::{error::EngineError, temporary};
use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// The marker. The name and the first line are the convention by which backup programs know caches.
const MARKER: &str = "CACHEDIR.TAG";
const SIGNATURE: &str = "Signature: 8a477f597d28d172789f06886806bc55\n";
const OURS: &str = "# This folder is a cache of farfield.";
/// The folders inside a cache.
const INNER: [&str; 5] = ["values", "tmp", "locks", "claims", "bad"];
/// Entries of a strange folder that a message names.
const NAMED: usize = 3;

/// What lies at a cache's path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    Absent,
    Empty,
    Marked,
    /// A cache from before there were markers.
    Unmarked,
}

/// What lies at `root`; an error where that is not ours to use.
pub fn check(root: &Path) -> Result<Found, EngineError> {
    match fs::metadata(root) {
        Ok(meta) if meta.is_dir() => {}
        Ok(_) => return Err(refuse(root, "it is a file, not a folder")),
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Found::Absent),
        Err(e) => return Err(EngineError::cache(root, format!("cannot be read ({e}); name another with --cache"))),
    }
    if is_marked(root) {
        return no_links(root).map(|()| Found::Marked);
    }
    let read = || -> io::Result<Vec<String>> {
        fs::read_dir(root)?.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned())).collect()
    };
    let mut names =
        read().map_err(|e| EngineError::cache(root, format!("cannot be read ({e}); name another with --cache")))?;
    // Another process may be about to mark it.
    names.retain(|name| !temporary::is_name(name));
    names.sort();
    if names.is_empty() {
        return Ok(Found::Empty);
    }
    if is_marked(root) {
        return no_links(root).map(|()| Found::Marked);
    }
    let strange: Vec<&String> =
        names.iter().filter(|n| !INNER.contains(&n.as_str()) && !layout::is_file_name(n)).collect();
    if strange.is_empty() && layout::is_known(root) {
        return no_links(root).map(|()| Found::Unmarked);
    }
    let strange = if strange.is_empty() { names.iter().collect() } else { strange };
    let shown: Vec<String> = strange.iter().take(NAMED).map(|n| format!("`{n}`")).collect();
    let more = strange.len().saturating_sub(NAMED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    Err(refuse(root, &format!("it holds {}{more} and is not marked as a cache of farfield", shown.join(", "))))
}

/// Makes `root` a cache that can be written. `Some`: why it cannot be written, where it is one that can be read.
pub fn prepare(root: &Path) -> Result<Option<String>, EngineError> {
    let found = check(root)?;
    let make = || -> io::Result<()> {
        if found != Found::Marked {
            fs::create_dir_all(root)?;
            mark(root)?;
        }
        for name in INNER {
            let path = root.join(name);
            if !path.is_dir() {
                fs::create_dir_all(path)?;
            }
        }
        Ok(())
    };
    match make() {
        Ok(()) => Ok(None),
        Err(e) if matches!(found, Found::Marked | Found::Unmarked) => Ok(Some(e.to_string())),
        Err(e) => {
            Err(EngineError::cache(root, format!("cannot be made or written ({e}); name another folder with --cache")))
        }
    }
}

/// Whole or absent, because another process may look at any moment.
fn mark(root: &Path) -> io::Result<()> {
    let text = format!(
        "{SIGNATURE}{OURS}\n# It may be deleted: a bake computes again what it needs. `farfield cache gc` makes it smaller.\n"
    );
    let path = root.join(MARKER);
    let temporary = temporary::beside(&path);
    fs::write(&temporary, text).and_then(|()| fs::rename(&temporary, &path)).inspect_err(|_| {
        let _ = fs::remove_file(&temporary);
    })
}

fn is_marked(root: &Path) -> bool {
    let path = root.join(MARKER);
    let small = fs::symlink_metadata(&path).is_ok_and(|meta| meta.is_file() && meta.len() < 4096);
    small && fs::read_to_string(&path).is_ok_and(|text| text.starts_with(SIGNATURE) && text.lines().any(|l| l == OURS))
}

/// Refuses a cache whose own folders are symbolic links: what is stored and deleted would lie elsewhere.
fn no_links(root: &Path) -> Result<(), EngineError> {
    for name in INNER {
        let path: PathBuf = root.join(name);
        if let Ok(meta) = fs::symlink_metadata(&path)
            && !meta.is_dir()
        {
            let what = if meta.is_symlink() { "a symbolic link" } else { "a file" };
            let text = format!("`{name}` in it is {what} and should be a folder; remove it, or name another folder");
            return Err(EngineError::NotACache { path: root.to_owned(), what: text });
        }
    }
    Ok(())
}

fn refuse(root: &Path, what: &str) -> EngineError {
    let text = format!(
        "{what}; name a new or an empty folder with --cache (if it is an old or damaged cache, delete it: a bake makes it anew)"
    );
    EngineError::NotACache { path: root.to_owned(), what: text }
}
