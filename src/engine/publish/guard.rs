//! What a bake reads: files that it must neither replace nor delete, however their paths are spelled.

use std::{
    collections::BTreeMap,
    fs, io,
    path::{Path, PathBuf},
};

/// Links that are followed from one path before it counts as a circle.
const LINKS: usize = 40;

/// The files that a bake reads. A path leads to one of them if it is the same file of the same device (another
/// spelling, a symbolic link to it, a hard link) or has the same canonical path.
#[derive(Debug, Default)]
pub struct Guard {
    by_identity: BTreeMap<(u64, u64), PathBuf>,
    by_path: BTreeMap<PathBuf, PathBuf>,
}

impl Guard {
    pub fn new(files: impl IntoIterator<Item = PathBuf>) -> Self {
        let mut out = Self::default();
        files.into_iter().for_each(|file| out.add(file));
        out
    }

    fn add(&mut self, file: PathBuf) {
        if let Ok(path) = fs::canonicalize(&file)
            && self.by_path.insert(path, file.clone()).is_some()
        {
            return;
        }
        // The links on the way are needed too.
        let mut at = file.clone();
        for _ in 0..LINKS {
            let Ok(meta) = fs::symlink_metadata(&at) else { return };
            self.by_identity.extend(identity(&meta).map(|id| (id, file.clone())));
            match fs::read_link(&at) {
                Ok(next) if meta.is_symlink() => at = at.parent().unwrap_or(Path::new("")).join(next),
                _ => return,
            }
        }
    }

    /// The file that the bake reads and that lies at `path`, as the bake names it.
    pub fn holds(&self, path: &Path) -> Option<&Path> {
        if self.by_path.is_empty() && self.by_identity.is_empty() {
            return None;
        }
        let by_meta = |meta: io::Result<fs::Metadata>| self.by_identity.get(&identity(&meta.ok()?)?);
        let found = by_meta(fs::symlink_metadata(path)).or_else(|| by_meta(fs::metadata(path)));
        let found = found.or_else(|| if cfg!(unix) { None } else { self.by_path.get(&fs::canonicalize(path).ok()?) });
        found.map(PathBuf::as_path)
    }
}

/// Device and number of a file, where the system tells them.
#[cfg(unix)]
pub fn identity(meta: &fs::Metadata) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt as _;
    Some((meta.dev(), meta.ino()))
}

#[cfg(not(unix))]
pub fn identity(_: &fs::Metadata) -> Option<(u64, u64)> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn a_file_is_known_by_any_of_its_names() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        fs::create_dir(at("sub")).unwrap();
        for name in ["read.obj", "other.obj"] {
            fs::write(at(name), name).unwrap();
        }
        fs::hard_link(at("read.obj"), at("hard.obj")).unwrap();
        symlink(at("read.obj"), at("link.obj")).unwrap();
        symlink("link.obj", at("chain.obj")).unwrap();
        symlink("nowhere", at("dangling.obj")).unwrap();
        let guard = Guard::new([at("chain.obj"), at("dangling.obj"), at("gone.obj")]);
        for name in ["read.obj", "hard.obj", "link.obj", "chain.obj", "sub/../read.obj", "dangling.obj"] {
            assert!(guard.holds(&at(name)).is_some(), "{name}");
        }
        for name in ["other.obj", "gone.obj", "sub"] {
            assert_eq!(guard.holds(&at(name)), None, "{name}");
        }
    }
}
