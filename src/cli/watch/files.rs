//! Which files are watched, and what it means that something happened in their folders.
//!
//! Events only say where to look: programs save by writing, by renaming over, or by deleting and writing anew, and reading
//! raises events too. A file was saved if what the system says of it is not what it said before.

use crate::engine::{cache::files::Stamp, source::lexical};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

/// The file system, as far as it matters here.
pub trait Disk {
    /// What the system says of the file; `None` where there is none.
    fn stamp(&self, path: &Path) -> Option<Stamp>;
    /// The path without symbolic links; `None` where it leads to nothing.
    fn real(&self, path: &Path) -> Option<PathBuf>;
}

/// The real one.
pub struct Here;

impl Disk for Here {
    fn stamp(&self, path: &Path) -> Option<Stamp> {
        std::fs::metadata(path).ok().map(|meta| Stamp::of(&meta))
    }
    fn real(&self, path: &Path) -> Option<PathBuf> {
        path.canonicalize().ok()
    }
}

/// What happened to watched files.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct News {
    pub changed: Vec<PathBuf>,
    /// Files that are no longer there; each is told once.
    pub gone: Vec<PathBuf>,
    /// Files that were missing and are there.
    pub back: Vec<PathBuf>,
    /// When the last of those that changed was saved, nanoseconds since 1970.
    pub saved: Option<i128>,
}

impl News {
    /// Whether a bake may give something else than the last one did. A missing file gives an error, and nothing new.
    pub fn call_for_a_bake(&self) -> bool {
        !self.changed.is_empty() || !self.back.is_empty()
    }
}

/// The watched files, with what was last known of them.
#[derive(Default)]
pub struct Watched {
    files: BTreeMap<PathBuf, Option<Stamp>>,
    /// By the paths at which events may name them: their own, and those without symbolic links.
    names: BTreeMap<PathBuf, PathBuf>,
}

impl Watched {
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// The folders in which something may happen to the files: to a link, and to what it leads to.
    pub fn folders(&self) -> BTreeSet<PathBuf> {
        self.names.keys().filter_map(|name| name.parent()).map(Path::to_owned).collect()
    }

    /// Looks at the watched files among `touched`.
    pub fn look(&mut self, touched: &[PathBuf], disk: &dyn Disk) -> News {
        let files: BTreeSet<PathBuf> = touched.iter().filter_map(|path| self.names.get(path).cloned()).collect();
        self.look_at(files, disk)
    }

    /// Looks at all watched files.
    pub fn look_at_all(&mut self, disk: &dyn Disk) -> News {
        self.look_at(self.files.keys().cloned().collect(), disk)
    }

    /// Whether any file is not what it was.
    pub fn differ(&self, disk: &dyn Disk) -> bool {
        self.files.iter().any(|(path, known)| disk.stamp(path) != *known)
    }

    fn look_at(&mut self, files: BTreeSet<PathBuf>, disk: &dyn Disk) -> News {
        let mut news = News::default();
        for path in files {
            let (now, Some(known)) = (disk.stamp(&path), self.files.get_mut(&path)) else { continue };
            let list = match (*known, now) {
                (Some(was), Some(is)) if was != is => &mut news.changed,
                (Some(_), None) => &mut news.gone,
                (None, Some(_)) => &mut news.back,
                _ => continue,
            };
            list.push(path);
            *known = now;
            news.saved = news.saved.max(now.map(saved));
        }
        news
    }

    /// Takes in the files that a bake which began at `since` (nanoseconds since 1970) has used: all that matter, or where
    /// it did not come to its end only some. What was saved since then may have been read before it was saved.
    pub fn learn(&mut self, used: &[PathBuf], all: bool, since: i128, disk: &dyn Disk) -> News {
        let used: BTreeSet<PathBuf> = used.iter().map(|path| lexical(path)).collect();
        if all {
            self.files.retain(|path, _| used.contains(path));
        }
        let mut news = News::default();
        for path in used {
            if self.files.contains_key(&path) {
                continue;
            }
            let stamp = disk.stamp(&path);
            if let Some(at) = stamp.map(saved).filter(|at| *at >= since) {
                news.changed.push(path.clone());
                news.saved = news.saved.max(Some(at));
            }
            self.files.insert(path, stamp);
        }
        self.names = self.files.keys().flat_map(|path| names(path, disk).map(|name| (name, path.clone()))).collect();
        news
    }
}

/// When a file with this stamp was saved: written, or renamed to its name.
fn saved(stamp: Stamp) -> i128 {
    stamp.mtime.max(stamp.ctime)
}

/// The paths at which events may name a file.
fn names(path: &Path, disk: &dyn Disk) -> impl Iterator<Item = PathBuf> {
    let beside = || Some(disk.real(path.parent()?)?.join(path.file_name()?));
    [Some(path.to_owned()), beside(), disk.real(path)].into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    /// Files by path: when they were saved. Links by path: where they lead.
    #[derive(Default)]
    struct Fake {
        files: RefCell<BTreeMap<PathBuf, i128>>,
        links: BTreeMap<PathBuf, PathBuf>,
    }

    impl Fake {
        fn of(files: &[(&str, i128)]) -> Self {
            let files = files.iter().map(|(path, at)| (PathBuf::from(path), *at)).collect();
            Self { files: RefCell::new(files), ..Self::default() }
        }
        fn save(&self, path: &str, at: i128) {
            self.files.borrow_mut().insert(path.into(), at);
        }
        fn remove(&self, path: &str) {
            self.files.borrow_mut().remove(Path::new(path));
        }
    }

    impl Disk for Fake {
        fn stamp(&self, path: &Path) -> Option<Stamp> {
            let path = self.links.get(path).map_or(path, PathBuf::as_path);
            let at = *self.files.borrow().get(path)?;
            Some(Stamp { size: 1, mtime: at, ctime: at, inode: 1, device: 1 })
        }
        fn real(&self, path: &Path) -> Option<PathBuf> {
            Some(self.links.get(path).cloned().unwrap_or_else(|| path.to_owned()))
        }
    }

    fn paths(all: &[&str]) -> Vec<PathBuf> {
        all.iter().map(PathBuf::from).collect()
    }

    fn watched(disk: &Fake, files: &[&str]) -> Watched {
        let mut watched = Watched::default();
        assert_eq!(watched.learn(&paths(files), true, 100, disk), News::default());
        watched
    }

    #[test]
    fn only_saved_files_that_are_watched_are_news() {
        let disk = Fake::of(&[("/a/p.toml", 1), ("/b/s.glb", 1), ("/a/other", 1)]);
        let mut watched = watched(&disk, &["/a/p.toml", "/a/../b/s.glb"]);
        assert_eq!(watched.folders(), BTreeSet::from(["/a".into(), "/b".into()]));
        let all = paths(&["/a/p.toml", "/b/s.glb", "/a/other", "/a/p.toml~"]);
        // It was only read.
        assert_eq!(watched.look(&all, &disk), News::default());
        disk.save("/a/other", 200);
        disk.save("/b/s.glb", 201);
        let news = watched.look(&all, &disk);
        assert_eq!((&news.changed, news.saved), (&paths(&["/b/s.glb"]), Some(201)));
        assert!(news.call_for_a_bake());
        // Told once.
        assert_eq!(watched.look_at_all(&disk), News::default());
    }

    #[test]
    fn a_file_that_is_gone_is_told_once_and_again_when_it_is_back() {
        let disk = Fake::of(&[("/a/p.toml", 1)]);
        let mut watched = watched(&disk, &["/a/p.toml"]);
        let event = paths(&["/a/p.toml"]);
        disk.remove("/a/p.toml");
        let news = watched.look(&event, &disk);
        assert_eq!((&news.gone, news.call_for_a_bake()), (&event, false));
        assert_eq!(watched.look(&event, &disk), News::default());
        assert!(!watched.differ(&disk));
        // Even as it was: the bake that went wrong without it must be made up for.
        disk.save("/a/p.toml", 1);
        assert!(watched.differ(&disk));
        let news = watched.look(&event, &disk);
        assert_eq!((&news.back, news.call_for_a_bake()), (&event, true));
    }

    #[test]
    fn a_bake_that_ended_says_what_matters_and_one_that_broke_off_only_adds() {
        let disk = Fake::of(&[("/a/p.toml", 1), ("/a/s.obj", 1), ("/a/t.png", 1)]);
        let mut watched = watched(&disk, &["/a/p.toml", "/a/s.obj"]);
        watched.learn(&paths(&["/a/p.toml", "/a/t.png"]), false, 100, &disk);
        assert_eq!(watched.len(), 3);
        watched.learn(&paths(&["/a/p.toml", "/a/missing.mtl"]), true, 100, &disk);
        assert_eq!(watched.len(), 2);
        disk.save("/a/t.png", 300);
        assert_eq!(watched.look_at_all(&disk), News::default());
        // What it looked for in vain is waited for.
        disk.save("/a/missing.mtl", 300);
        assert_eq!(watched.look_at_all(&disk).back, paths(&["/a/missing.mtl"]));
    }

    #[test]
    fn what_was_saved_while_a_bake_first_read_it_is_news() {
        let disk = Fake::of(&[("/a/p.toml", 1), ("/a/t.png", 150), ("/a/u.png", 99)]);
        let mut watched = watched(&disk, &["/a/p.toml"]);
        let used = paths(&["/a/p.toml", "/a/t.png", "/a/u.png"]);
        assert_eq!(watched.learn(&used, true, 100, &disk).changed, paths(&["/a/t.png"]));
        assert_eq!(watched.learn(&used, true, 100, &disk), News::default(), "once");
    }

    #[test]
    fn links_are_watched_where_they_lie_and_where_they_lead() {
        let mut disk = Fake::of(&[("/real/t.png", 1)]);
        disk.links.insert("/a/t.png".into(), "/real/t.png".into());
        let mut watched = watched(&disk, &["/a/t.png"]);
        assert_eq!(watched.folders(), BTreeSet::from(["/a".into(), "/real".into()]));
        disk.save("/real/t.png", 300);
        assert_eq!(watched.look(&paths(&["/real/t.png"]), &disk).changed, paths(&["/a/t.png"]));
    }
}
