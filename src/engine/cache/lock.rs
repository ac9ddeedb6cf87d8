//! Advisory locks between processes. Correctness never depends on them: they only keep two processes from doing the
//! same work, and a sweep from removing what a living bake has just used. A killed process's locks are free at once,
//! because the system drops them.

use crate::engine::hash::Digest;
use std::{
    fs::{self, File, TryLockError},
    io,
    path::{Path, PathBuf},
    time::SystemTime,
};

/// A held lock; free when dropped.
#[derive(Debug)]
pub struct Lock {
    file: File,
    path: PathBuf,
}

impl Lock {
    /// Takes the lock of a key; `None` while another process holds it.
    pub fn key(cache: &Path, key: &Digest) -> io::Result<Option<Self>> {
        Self::take(cache.join("locks").join(key.hex()))
    }

    /// Takes the lock at `path`; `None` while another holds it.
    pub fn take(path: PathBuf) -> io::Result<Option<Self>> {
        let file = File::options().create(true).truncate(false).write(true).open(&path)?;
        match file.try_lock() {
            Ok(()) => Ok(Some(Self { file, path })),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(e)) => Err(e),
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Removed before it is freed. Who opened it in between holds a lock that nobody sees: it then does work that
        // another may do too, and nothing worse.
        let _ = fs::remove_file(&self.path);
        let _ = self.file.unlock();
    }
}

/// Marks this process's bake as alive until dropped.
pub fn claim(cache: &Path) -> io::Result<Lock> {
    loop {
        let name = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |d| d.as_nanos());
        let path = cache.join("claims").join(format!("{}-{name}", std::process::id()));
        // A sweep may hold the new file for the moment in which it looks whether its process lives.
        if let Some(lock) = Lock::take(path)? {
            return Ok(lock);
        }
    }
}

/// When the oldest living bake began; `None` where none lives. Removes the marks of the dead.
pub fn oldest_claim(cache: &Path) -> io::Result<Option<SystemTime>> {
    let mut oldest = None;
    for entry in fs::read_dir(cache.join("claims"))? {
        let entry = entry?;
        let began = match entry.metadata() {
            Ok(meta) => meta.modified()?,
            Err(e) if e.kind() == io::ErrorKind::NotFound => continue,
            Err(e) => return Err(e),
        };
        if Lock::take(entry.path())?.is_none() {
            oldest = Some(oldest.map_or(began, |o: SystemTime| o.min(began)));
        }
    }
    Ok(oldest)
}
