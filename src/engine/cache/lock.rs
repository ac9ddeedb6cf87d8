//! Advisory locks between processes. Correctness never depends on them: they only keep two processes from doing the
//! same work, and a sweep from removing what a living bake has just used. A killed process's locks are free at once,
//! because the system drops them.

use crate::engine::hash::Digest;
use std::{
    collections::BTreeMap,
    fs::{self, File, TryLockError},
    io,
    path::Path,
    sync::{Arc, Weak},
    time::SystemTime,
};

/// Keys share this many lock files: making and removing a file per key costs more than most runs. Two keys that share
/// one wait for each other across processes, and for nothing within one.
const SHARDS: u32 = 1024;

/// A held lock; free when dropped. Its file stays.
#[derive(Debug)]
pub struct Lock(File);

impl Lock {
    /// Takes the lock at `path`; `None` while another holds it.
    pub fn take(path: &Path) -> io::Result<Option<Self>> {
        let file = File::options().create(true).truncate(false).write(true).open(path)?;
        match file.try_lock() {
            Ok(()) => Ok(Some(Self(file))),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(e)) => Err(e),
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Closing frees it in any case.
        let _ = self.0.unlock();
    }
}

/// A key's lock, shared by all runs of this process whose keys have the same file.
pub type KeyLock = Arc<Lock>;

/// The key locks that this process holds.
#[derive(Default)]
pub struct KeyLocks(BTreeMap<u32, Weak<Lock>>);

impl KeyLocks {
    /// Takes the lock of a key; `None` while another process holds it.
    pub fn take(&mut self, cache: &Path, key: &Digest) -> io::Result<Option<KeyLock>> {
        let [a, b, c, d, ..] = key.0;
        let shard = u32::from_le_bytes([a, b, c, d]) % SHARDS;
        if let Some(held) = self.0.get(&shard).and_then(Weak::upgrade) {
            return Ok(Some(held));
        }
        let Some(lock) = Lock::take(&cache.join("locks").join(format!("{shard:03x}")))? else { return Ok(None) };
        let lock = Arc::new(lock);
        self.0.insert(shard, Arc::downgrade(&lock));
        Ok(Some(lock))
    }
}

/// Marks this process's bake as alive until dropped: the lock of the first free mark, stamped with this moment.
pub fn claim(cache: &Path) -> io::Result<Lock> {
    let mut n = 0;
    loop {
        if let Some(lock) = Lock::take(&cache.join("claims").join(n.to_string()))? {
            lock.0.set_modified(SystemTime::now())?;
            return Ok(lock);
        }
        n += 1;
    }
}

/// When the oldest living bake began; `None` where none lives.
pub fn oldest_claim(cache: &Path) -> io::Result<Option<SystemTime>> {
    let mut oldest = None;
    for entry in fs::read_dir(cache.join("claims"))? {
        let entry = entry?;
        if Lock::take(&entry.path())?.is_none() {
            let began = entry.metadata()?.modified()?;
            oldest = Some(oldest.map_or(began, |o: SystemTime| o.min(began)));
        }
    }
    Ok(oldest)
}
