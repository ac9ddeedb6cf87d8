//! Advisory locks between processes. Correctness never depends on them: they only keep two processes from doing the
//! same work, and a sweep from removing what a living bake has just used. A killed process's locks are free at once,
//! because the system drops them. A lock file names the process that took it last, for messages.

use crate::{engine::hash::Digest, math::Stop};
use std::{
    collections::BTreeMap,
    fs::{self, File, TryLockError},
    io::{self, Read as _, Seek as _, Write as _},
    path::Path,
    sync::{Arc, OnceLock, Weak},
    time::{Duration, Instant, SystemTime},
};

/// Keys share this many lock files: making and removing a file per key costs more than most runs. Two keys that share
/// one wait for each other across processes, and for nothing within one.
const SHARDS: u32 = 1024;
/// How often a lock that another process holds is tried.
const POLL: Duration = Duration::from_millis(20);
/// Who waits longer than this says so.
pub const PATIENCE: Duration = Duration::from_secs(1);
/// Bytes that a lock file says its holder in, at most.
const HOLDER: usize = 96;

/// A held lock; free when dropped. Its file stays.
#[derive(Debug)]
pub struct Lock(File);

impl Lock {
    /// Takes the lock at `path`; `None` while another holds it.
    pub fn take(path: &Path) -> io::Result<Option<Self>> {
        // The holder's name is written into the file: never into one that a link leads to.
        if fs::symlink_metadata(path).is_ok_and(|meta| !meta.is_file()) {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, format!("{} is no plain file", path.display())));
        }
        let open = File::options().create(true).truncate(false).read(true).write(true).open(path);
        let mut file = match open {
            // A file that can only be read can be locked all the same.
            Err(e) if matches!(e.kind(), io::ErrorKind::ReadOnlyFilesystem | io::ErrorKind::PermissionDenied) => {
                File::open(path).map_err(|_| e)?
            }
            other => other?,
        };
        match file.try_lock() {
            Ok(()) => {
                // Only for messages: a full disk must not keep anyone from working.
                let _ = file.write_all(own_name());
                Ok(Some(Self(file)))
            }
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(e)) => Err(e),
        }
    }
}

/// What `take` gives, however long another process holds the lock at `path`; `None` if `stop` is set first. After a second of
/// waiting, `waiting` is called once with the holder's name.
pub fn wait<T>(
    path: &Path,
    stop: &Stop,
    mut take: impl FnMut() -> io::Result<Option<T>>,
    mut waiting: impl FnMut(&str),
) -> io::Result<Option<T>> {
    let began = Instant::now();
    let mut told = false;
    loop {
        if let Some(lock) = take()? {
            return Ok(Some(lock));
        }
        if stop.is_set() {
            return Ok(None);
        }
        if !told && began.elapsed() >= PATIENCE {
            told = true;
            waiting(&holder(path));
        }
        std::thread::sleep(POLL);
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Closing frees it in any case.
        let _ = self.0.unlock();
    }
}

/// This process as its locks name it: one line, padded to a fixed length so that it replaces a longer one.
pub fn own_name() -> &'static [u8] {
    static NAME: OnceLock<Vec<u8>> = OnceLock::new();
    NAME.get_or_init(|| {
        let kernel = fs::read_to_string("/proc/sys/kernel/hostname").ok();
        let host = kernel.or_else(|| std::env::var("HOSTNAME").ok()).or_else(|| std::env::var("COMPUTERNAME").ok());
        let mut name = format!("process {}", std::process::id());
        if let Some(host) = host.as_deref().map(str::trim).filter(|host| !host.is_empty()) {
            name += &format!(" on {host}");
        }
        let mut line = name.into_bytes();
        line.resize(HOLDER - 1, b' ');
        line.push(b'\n');
        line
    })
}

/// Who took the lock at `path` last, as `process 123 on host`; `another process` where its file does not say.
pub fn holder(path: &Path) -> String {
    let read = || -> io::Result<Vec<u8>> {
        let mut file = File::open(path)?;
        file.rewind()?;
        let mut bytes = Vec::new();
        file.take(HOLDER as u64).read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    // On some systems a locked file cannot be read.
    let bytes = read().unwrap_or_default();
    let text = String::from_utf8_lossy(&bytes);
    let name = text.lines().next().unwrap_or_default().trim();
    if name.starts_with("process ") && !name.chars().any(char::is_control) {
        name.to_owned()
    } else {
        "another process".to_owned()
    }
}

/// A key's lock, shared by all runs of this process whose keys have the same file.
pub type KeyLock = Arc<Lock>;

/// The key locks that this process holds.
#[derive(Default)]
pub struct KeyLocks(BTreeMap<u32, Weak<Lock>>);

fn shard(key: &Digest) -> u32 {
    let [a, b, c, d, ..] = key.0;
    u32::from_le_bytes([a, b, c, d]) % SHARDS
}

fn path_of(cache: &Path, shard: u32) -> std::path::PathBuf {
    cache.join("locks").join(format!("{shard:03x}"))
}

/// Who holds the lock of a key.
pub fn holder_of_key(cache: &Path, key: &Digest) -> String {
    holder(&path_of(cache, shard(key)))
}

impl KeyLocks {
    /// Takes the lock of a key; `None` while another process holds it.
    pub fn take(&mut self, cache: &Path, key: &Digest) -> io::Result<Option<KeyLock>> {
        let shard = shard(key);
        if let Some(held) = self.0.get(&shard).and_then(Weak::upgrade) {
            return Ok(Some(held));
        }
        let Some(lock) = Lock::take(&path_of(cache, shard))? else { return Ok(None) };
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
        let ours = entry.file_name().to_str().is_some_and(|name| name.bytes().all(|b| b.is_ascii_digit()));
        if !ours || !entry.file_type()?.is_file() {
            continue;
        }
        let file = File::options().write(true).open(entry.path())?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let began = entry.metadata()?.modified()?;
                oldest = Some(oldest.map_or(began, |o: SystemTime| o.min(began)));
            }
            Err(TryLockError::Error(e)) => return Err(e),
        }
    }
    Ok(oldest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_waits_is_told_the_holder_once() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("lock");
        let held = Lock::take(&path).unwrap().unwrap();
        assert!(Lock::take(&path).unwrap().is_none());
        let mut told = Vec::new();
        let lock = std::thread::scope(|s| {
            s.spawn(move || {
                std::thread::sleep(PATIENCE * 2);
                drop(held);
            });
            wait(&path, &Stop::default(), || Lock::take(&path), |holder| told.push(holder.to_owned())).unwrap()
        });
        assert!(lock.is_some());
        assert_eq!(told.len(), 1);
        assert!(told[0].starts_with(&format!("process {}", std::process::id())), "{told:?}");
        let stopped = Stop::default();
        stopped.set();
        assert!(wait(&path, &stopped, || Lock::take(&path), |_| {}).unwrap().is_none(), "a stop ends the waiting");
    }

    #[test]
    fn a_lock_file_with_other_text_names_nobody() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("lock");
        for text in ["", "process \u{1b}[31m", "rubbish"] {
            fs::write(&path, text).unwrap();
            assert_eq!(holder(&path), "another process");
        }
    }
}
