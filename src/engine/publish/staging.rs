//! The lock of an output folder, and the files written beside their places under it.
//!
//! The lock lies beside the folder, so that bakes with different caches and different spellings of the folder's path
//! meet at it. A temporary file bears the mark of the lock under which it was written: who holds that lock knows that
//! its writer is gone.

use super::guard::identity;
use crate::engine::{cache::lock::own_name, hash::Digest, temporary};
use std::{
    fs::{self, File, TryLockError},
    io::{self, Write as _},
    path::{Path, PathBuf},
    time::{Duration, SystemTime},
};

const END: &str = ".farfield-tmp";

/// Temporary files of other marks, of a folder that was copied or whose lock was deleted, go when they are this old.
const OLD: Duration = Duration::from_secs(24 * 3600);

/// A held lock of the output folder `<out>/<name>`; free when dropped. Its file stays.
#[derive(Debug)]
pub struct FolderLock {
    file: File,
    mark: String,
}

impl FolderLock {
    pub fn path(out: &Path, name: &str) -> PathBuf {
        out.join(format!(".{name}.farfield-lock"))
    }

    /// Takes the lock; `None` while another process holds it.
    pub fn take(out: &Path, name: &str) -> io::Result<Option<Self>> {
        fs::create_dir_all(out)?;
        let path = Self::path(out, name);
        loop {
            let file = match File::options().create(true).truncate(false).read(true).write(true).open(&path) {
                // Who may only read can lock too.
                Err(e) if is_read_only(&e) => File::open(&path).map_err(|_| e)?,
                other => other?,
            };
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Ok(None),
                Err(TryLockError::Error(e)) => return Err(e),
            }
            // A file that was deleted meanwhile is no longer where the next one looks.
            let held = identity(&file.metadata()?);
            match fs::metadata(&path) {
                Ok(meta) if identity(&meta) == held => {}
                Ok(_) => continue,
                Err(e) if e.kind() == io::ErrorKind::NotFound => continue,
                Err(e) => return Err(e),
            }
            let mark = match held {
                Some((device, number)) => format!("{device:x}-{number:x}"),
                None => Digest::of(fs::canonicalize(&path)?.to_string_lossy().as_bytes()).hex()[..16].to_owned(),
            };
            let mut lock = Self { file, mark };
            // For people who wait; where it cannot be written, they are told less.
            let _ = lock.file.write_all(own_name());
            return Ok(Some(lock));
        }
    }

    /// Writes and syncs `data` beside `path`.
    pub fn stage(&self, path: &Path, data: &[u8]) -> io::Result<PathBuf> {
        let (temporary, mut file) = self.create(path)?;
        let written = file.write_all(data).and_then(|()| file.sync_all());
        written.map(|()| temporary.clone()).inspect_err(|_| drop(fs::remove_file(&temporary)))
    }

    /// Replaces `path`, unsynced.
    pub fn replace(&self, path: &Path, data: &[u8]) -> io::Result<()> {
        let (temporary, mut file) = self.create(path)?;
        let moved = file.write_all(data).and_then(|()| fs::rename(&temporary, path));
        moved.inspect_err(|_| drop(fs::remove_file(&temporary)))
    }

    fn create(&self, path: &Path) -> io::Result<(PathBuf, File)> {
        loop {
            let temporary = path.with_file_name(format!(".{}.{}{END}", self.mark, temporary::random()));
            match File::create_new(&temporary) {
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                other => return Ok((temporary, other?)),
            }
        }
    }

    /// Removes what killed bakes left in `folder`: temporary files of this lock, whose holder is this process.
    pub fn sweep(&self, folder: &Path) -> io::Result<()> {
        let entries = match fs::read_dir(folder) {
            Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => return Ok(()),
            other => other?,
        };
        let own = format!(".{}.", self.mark);
        for entry in entries {
            let entry = entry?;
            let name = entry.file_name();
            let Some(name) = name.to_str().filter(|n| n.starts_with('.') && n.ends_with(END)) else { continue };
            if (name.starts_with(&own) || is_old(&entry)) && entry.file_type()?.is_file() {
                fs::remove_file(entry.path())?;
            }
        }
        Ok(())
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // What it says of its holder goes with it. Closing frees it in any case.
        let _ = self.file.set_len(0);
        let _ = self.file.unlock();
    }
}

fn is_old(entry: &fs::DirEntry) -> bool {
    let changed = entry.metadata().and_then(|meta| meta.modified()).ok();
    changed.and_then(|at| SystemTime::now().duration_since(at).ok()).is_some_and(|age| age > OLD)
}

/// Whether an error says that nothing can be written here.
pub fn is_read_only(e: &io::Error) -> bool {
    use io::ErrorKind::{PermissionDenied, QuotaExceeded, ReadOnlyFilesystem, StorageFull};
    matches!(e.kind(), PermissionDenied | ReadOnlyFilesystem | StorageFull | QuotaExceeded)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_its_own_temporary_files_are_swept() {
        let dir = tempfile::tempdir().unwrap();
        let lock = FolderLock::take(dir.path(), "a").unwrap().unwrap();
        let other = FolderLock::take(dir.path(), "b").unwrap().unwrap();
        let folder = dir.path().join("a");
        fs::create_dir(&folder).unwrap();
        let mine = lock.stage(&folder.join("x"), b"x").unwrap();
        let theirs = other.stage(&folder.join("x"), b"x").unwrap();
        fs::write(folder.join(".x.farfield-tmp.txt"), "").unwrap();
        lock.sweep(&folder).unwrap();
        assert!(!mine.exists() && theirs.exists() && folder.join(".x.farfield-tmp.txt").exists());
        // What nobody's lock marks goes when it is old.
        let old = SystemTime::now() - 2 * OLD;
        File::options().write(true).open(&theirs).unwrap().set_modified(old).unwrap();
        lock.sweep(&folder).unwrap();
        assert!(!theirs.exists());
    }

    #[test]
    fn one_holder_at_a_time_who_says_who_it_is() {
        let dir = tempfile::tempdir().unwrap();
        let lock = FolderLock::take(dir.path(), "a").unwrap().unwrap();
        assert!(
            FolderLock::take(&dir.path().join("../").join(dir.path().file_name().unwrap()), "a").unwrap().is_none()
        );
        assert!(
            crate::engine::cache::lock::holder(&FolderLock::path(dir.path(), "a"))
                .starts_with(&format!("process {}", std::process::id()))
        );
        drop(lock);
        assert_eq!(fs::read(FolderLock::path(dir.path(), "a")).unwrap(), b"");
        // A lock whose file was deleted is not taken for the new one.
        let lock = FolderLock::take(dir.path(), "a").unwrap().unwrap();
        fs::remove_file(FolderLock::path(dir.path(), "a")).unwrap();
        assert!(FolderLock::take(dir.path(), "a").unwrap().is_some());
        drop(lock);
    }
}
