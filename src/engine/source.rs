//! The door: the one place through which runs read the outside world. Every file that passes is recorded by its path
//! relative to the root file's folder and by its content; a file that was looked for and not found is recorded too.
//! The bytes that are hashed are the bytes that are parsed, and within one run a file never changes.

use super::{
    cache::Cache,
    hash::Digest,
    key::SourceKey,
    node::{Door, KindSpec, NodeError},
    record::Read,
};
use crate::{array::Bytes, regular};
use serde_json::Value;
use std::{
    collections::BTreeMap,
    io,
    path::{Component, Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

/// A source path that names a file.
#[derive(Clone, Debug)]
pub struct Root {
    /// The parameter that gives it.
    pub param: String,
    pub path: PathBuf,
}

/// What source parameters add to a key, and the root files among them.
pub struct Sources {
    pub keys: Vec<(String, SourceKey)>,
    pub roots: Arc<Vec<Root>>,
}

/// Reads the source parameters of a node. The error is a message for the user.
pub fn sources(spec: &KindSpec, params: &Value, names: &[&str], cache: &mut Cache) -> Result<Sources, String> {
    let (mut keys, mut roots) = (Vec::new(), Vec::new());
    for name in names {
        let Some(text) = params.get(name).and_then(Value::as_str) else { continue };
        if text.is_empty() || text.starts_with("builtin:") {
            keys.push(((*name).to_owned(), SourceKey::Text(text.to_owned())));
            continue;
        }
        let path = PathBuf::from(text);
        let hash = match cache.hash_file(&path) {
            Ok(Some((hash, _))) => hash,
            Ok(None) => return Err(format!("{} {name}: there is no file {text}", spec.title())),
            Err(e) if e.kind() == io::ErrorKind::InvalidInput => {
                return Err(format!("{} {name}: {text} {e}", spec.title()));
            }
            Err(e) => return Err(format!("{} {name}: {text} cannot be read: {e}", spec.title())),
        };
        keys.push(((*name).to_owned(), SourceKey::File { hash, extension: extension(&path) }));
        roots.push(Root { param: (*name).to_owned(), path });
    }
    Ok(Sources { keys, roots: Arc::new(roots) })
}

/// The extension as it enters the key: it may decide how the bytes are read.
pub fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// A door for one run.
pub struct Recorder {
    roots: Arc<Vec<Root>>,
    /// Held only to look up and to store, never while a file is read.
    seen: Mutex<BTreeMap<PathBuf, Option<(Digest, Bytes)>>>,
}

impl Recorder {
    pub fn new(roots: Arc<Vec<Root>>) -> Self {
        Self { roots, seen: Mutex::default() }
    }

    /// What was read besides the root files, sorted by path; and the root files' own hashes, where they were read.
    pub fn finish(self) -> (Vec<Read>, Vec<(String, Digest)>) {
        let (mut reads, mut roots) = (Vec::new(), Vec::new());
        for (path, found) in self.seen.into_inner().unwrap_or_else(PoisonError::into_inner) {
            let hash = found.map(|(hash, _)| hash);
            match (self.roots.iter().find(|r| lexical(&r.path) == path), hash) {
                (Some(root), Some(hash)) => roots.push((root.param.clone(), hash)),
                _ => reads.push(Read { path: relative(&path, &self.roots), hash }),
            }
        }
        reads.sort();
        (reads, roots)
    }
}

impl Door for Recorder {
    fn read(&self, path: &Path) -> Result<Option<Bytes>, NodeError> {
        let path = absolute(path, &self.roots);
        let seen = || self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = seen().get(&path) {
            return Ok(found.as_ref().map(|(_, bytes)| bytes.clone()));
        }
        let found: Option<(Digest, Bytes)> = match regular::read(&path) {
            Ok(bytes) => Some((Digest::of(&bytes), Arc::new(bytes))),
            Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => None,
            Err(e) if e.kind() == io::ErrorKind::InvalidInput => {
                return Err(NodeError::Failed(format!("{} {e}", path.display())));
            }
            Err(e) => return Err(NodeError::Failed(format!("{} cannot be read: {e}", path.display()))),
        };
        // If another thread read it meanwhile, its bytes stand for both.
        let mut seen = seen();
        let kept = seen.entry(path).or_insert(found);
        Ok(kept.as_ref().map(|(_, bytes)| bytes.clone()))
    }
}

/// Whether the files of a record are what they were. I/O errors count as a change: the run will name them.
pub fn still_true(reads: &[Read], roots: &[Root], cache: &mut Cache) -> bool {
    reads.iter().all(|read| {
        let path = absolute(Path::new(&read.path), roots);
        cache.hash_file(&path).is_ok_and(|found| found.map(|(hash, _)| hash) == read.hash)
    })
}

/// The files of `reads` that were there, by full path.
pub fn files<'a>(reads: &'a [Read], roots: &'a [Root]) -> impl Iterator<Item = PathBuf> + 'a {
    reads.iter().filter(|read| read.hash.is_some()).map(|read| absolute(Path::new(&read.path), roots))
}

/// All files of `reads`, those that were not there too, by full path.
pub fn paths<'a>(reads: &'a [Read], roots: &'a [Root]) -> impl Iterator<Item = PathBuf> + 'a {
    reads.iter().map(|read| absolute(Path::new(&read.path), roots))
}

/// `path` without `.` and `..`, as far as its text tells.
pub fn lexical(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(out.components().next_back(), Some(Component::Normal(_))) => {
                out.pop();
            }
            other => out.push(other),
        }
    }
    out
}

fn folder(roots: &[Root]) -> &Path {
    roots.first().and_then(|r| r.path.parent()).unwrap_or(Path::new(""))
}

fn absolute(path: &Path, roots: &[Root]) -> PathBuf {
    lexical(&folder(roots).join(path))
}

/// The way from the first root's folder to `path`, with `/`; `path` itself where there is none.
fn relative(path: &Path, roots: &[Root]) -> String {
    let base = lexical(folder(roots));
    let (base, parts): (Vec<_>, Vec<_>) = (base.components().collect(), path.components().collect());
    let shared = base.iter().zip(&parts).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        return path.to_string_lossy().into_owned();
    }
    let up = base[shared..].iter().map(|_| "..".to_owned());
    let down = parts[shared..].iter().map(|c| c.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn roots(path: &str) -> Vec<Root> {
        vec![Root { param: "path".into(), path: path.into() }]
    }

    #[test]
    fn paths_are_told_from_the_root_files_folder() {
        let roots = roots("/a/b/town.obj");
        for (path, expect) in [("/a/b/town.mtl", "town.mtl"), ("/a/tex/x.png", "../tex/x.png"), ("/a/b/t/y", "t/y")] {
            let told = relative(&absolute(Path::new(path), &roots), &roots);
            assert_eq!(told, expect);
            assert_eq!(absolute(Path::new(&told), &roots), Path::new(path));
        }
        assert_eq!(absolute(Path::new("t/../town.mtl"), &roots), Path::new("/a/b/town.mtl"));
    }

    #[test]
    fn a_run_sees_one_state_of_a_file_and_records_absent_ones() {
        let dir = tempfile::tempdir().unwrap();
        let root = dir.path().join("s.obj");
        fs::write(&root, "one").unwrap();
        let door = Recorder::new(Arc::new(vec![Root { param: "path".into(), path: root.clone() }]));
        let first = door.read(&root).unwrap().unwrap();
        fs::write(&root, "two").unwrap();
        let again = door.read(&root).unwrap().unwrap();
        assert_eq!(((*first).as_ref(), (*again).as_ref()), (&b"one"[..], &b"one"[..]));
        assert!(door.read(Path::new("s.mtl")).unwrap().is_none());
        let (reads, roots) = door.finish();
        assert_eq!(reads, [Read { path: "s.mtl".into(), hash: None }]);
        assert_eq!(roots, [("path".to_owned(), Digest::of(b"one"))]);
    }
}
