//! The cache of results: an index in SQLite, large values as files beside it.
//!
//! What always holds: a record is in the index only after the values it names were stored; whatever is read is checked
//! against its hash or checksum, so that damage is a miss and never another result; several processes may use one
//! cache, and any of them may be killed at any moment. Deleting the whole folder between runs is fine.

pub mod blob;
pub mod files;
mod gc;
pub(super) mod index;
pub mod lock;
mod verify;

pub use gc::{Collected, Limits, gc};
pub use index::set_aside as set_index_aside;
pub use verify::{Stats, Verified, stats, verify};

use super::{
    error::EngineError,
    hash::Digest,
    record::{BakeRecord, MapRecord, RunRecord},
    wire::{Reader, Writer},
};
use crate::regular;
use blob::Blobs;
use files::{Stamp, nanoseconds};
use lock::{KeyLock, KeyLocks, Lock};
use rusqlite::{Connection, OptionalExtension as _, params};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs, io,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Instant, SystemTime},
};

/// Bake records kept, over all pipelines.
const BAKES: i64 = 20;
/// A hit younger than this many seconds is not noted anew.
const FRESH: i64 = 24 * 3600;
/// Results gathered before they are written in one transaction: a number, and milliseconds.
const BATCH: (usize, u128) = (256, 30);

/// Where a stored value lies.
#[derive(Clone, Debug)]
pub enum Stored {
    Inline(Arc<Vec<u8>>),
    File,
}

/// A value made by a run, its file already written.
#[derive(Debug)]
pub struct NewValue {
    pub hash: Digest,
    pub size: u64,
    /// The bytes of a small value; a large one lies in its file.
    pub inline: Option<Vec<u8>>,
}

/// Fields of a key's fixed part, as text.
pub type Fields = Vec<(String, String)>;

/// The bytes of a value that lies in the index.
type Inline = Option<Arc<Vec<u8>>>;

#[derive(Default)]
struct Pending {
    /// Size, and bytes where they are few.
    values: BTreeMap<Digest, (u64, Inline)>,
    runs: BTreeMap<Digest, Vec<(Digest, Arc<RunRecord>)>>,
    maps: Vec<(Digest, Vec<u8>)>,
    fixed: BTreeMap<Digest, Fields>,
    files: Vec<(String, Stamp, Digest, i64)>,
    used_runs: Vec<Digest>,
    used_maps: Vec<Digest>,
    /// Freed once the rows that they protect are written.
    locks: Vec<KeyLock>,
    count: usize,
}

/// An open cache, owned by the scheduler's thread.
pub struct Cache {
    root: PathBuf,
    db: Connection,
    blobs: Blobs,
    pending: Pending,
    flushed: Instant,
    /// Values whose bytes this process has checked.
    verified: BTreeSet<Digest>,
    /// Values that the index is known to hold.
    indexed: BTreeSet<Digest>,
    explained: BTreeSet<Digest>,
    /// When this bake began, in seconds since 1970.
    began: i64,
    writable: bool,
    locks: KeyLocks,
    _claim: Option<Lock>,
    /// Damage met, to be told once.
    pub warnings: Vec<String>,
}

fn seconds() -> i64 {
    (nanoseconds(SystemTime::now()) / 1_000_000_000) as i64
}

impl Cache {
    /// Opens the cache at `root`, making it where it is missing. One that is not `writable` takes no results and needs
    /// no folder.
    pub fn open(root: &Path, writable: bool) -> Result<Self, EngineError> {
        let (db, claim) = if writable {
            let db = index::open(root)?;
            (db, Some(lock::claim(root).map_err(|e| EngineError::cache(root, e))?))
        } else {
            match index::open_existing(root)? {
                Some(db) => (db, None),
                None => (index::empty(root)?, None),
            }
        };
        Ok(Self {
            root: root.to_owned(),
            db,
            blobs: Blobs::new(root),
            pending: Pending::default(),
            flushed: Instant::now(),
            verified: BTreeSet::new(),
            indexed: BTreeSet::new(),
            explained: BTreeSet::new(),
            began: seconds(),
            writable,
            locks: KeyLocks::default(),
            _claim: claim,
            warnings: Vec::new(),
        })
    }

    pub fn root(&self) -> &Path {
        &self.root
    }

    pub fn blobs(&self) -> &Blobs {
        &self.blobs
    }

    /// Takes the lock of a key; `None` while another process holds it.
    pub fn lock(&mut self, key: &Digest) -> Result<Option<KeyLock>, EngineError> {
        self.locks.take(&self.root, key).map_err(|e| EngineError::cache(&self.root, e))
    }

    fn sql(&self, e: &rusqlite::Error) -> EngineError {
        index::error(&self.root, e)
    }

    /// Begins a read transaction: what follows sees one state and costs no lock each.
    pub fn begin(&self) -> Result<(), EngineError> {
        if self.db.is_autocommit() {
            self.db.execute_batch("BEGIN").map_err(|e| self.sql(&e))?;
        }
        Ok(())
    }

    /// Ends a read transaction.
    pub fn end(&self) -> Result<(), EngineError> {
        if !self.db.is_autocommit() {
            self.db.execute_batch("COMMIT").map_err(|e| self.sql(&e))?;
        }
        Ok(())
    }

    /// The records under `key`: one, or several that differ in what they read.
    pub fn runs(&mut self, key: &Digest) -> Result<Vec<(Digest, Arc<RunRecord>)>, EngineError> {
        if let Some(found) = self.pending.runs.get(key) {
            return Ok(found.clone());
        }
        let rows = || -> rusqlite::Result<Vec<(Digest, Option<RunRecord>, i64)>> {
            let mut s = self.db.prepare_cached("SELECT variant, record, used FROM run WHERE key = ?1")?;
            let mut rows = s.query([&key.0[..]])?;
            let mut out = Vec::new();
            while let Some(row) = rows.next()? {
                let variant = row.get_ref(0)?.as_blob()?.try_into().map(Digest).unwrap_or_default();
                out.push((variant, RunRecord::from_bytes(row.get_ref(1)?.as_blob()?), row.get(2)?));
            }
            Ok(out)
        };
        let rows = rows().map_err(|e| self.sql(&e))?;
        let mut out = Vec::with_capacity(rows.len());
        for (variant, record, used) in rows {
            match record {
                Some(record) => {
                    if self.began - used > FRESH {
                        self.pending.used_runs.push(*key);
                    }
                    out.push((variant, Arc::new(record)));
                }
                None => self.warnings.push(format!("the index held a damaged record ({key:?}); its run is repeated")),
            }
        }
        Ok(out)
    }

    /// Notes a hit on a result that no bake record holds yet, so that a sweep spares it.
    pub fn touch_run(&mut self, key: Digest) {
        self.pending.used_runs.push(key);
    }

    pub fn touch_map(&mut self, key: Digest) {
        self.pending.used_maps.push(key);
    }

    pub fn map(&mut self, key: &Digest) -> Result<Option<MapRecord>, EngineError> {
        let row = || -> rusqlite::Result<Option<(Option<MapRecord>, i64)>> {
            let mut s = self.db.prepare_cached("SELECT record, used FROM map WHERE key = ?1")?;
            s.query_row([&key.0[..]], |r| Ok((MapRecord::from_bytes(r.get_ref(0)?.as_blob()?), r.get(1)?))).optional()
        };
        let Some((record, used)) = row().map_err(|e| self.sql(&e))? else { return Ok(None) };
        if record.is_none() {
            self.warnings.push(format!("the index held a damaged record ({key:?}); its map is made anew"));
        } else if self.began - used > FRESH {
            self.pending.used_maps.push(*key);
        }
        Ok(record)
    }

    /// Where a value lies; `None` where the cache has lost it.
    pub fn value(&self, hash: &Digest) -> Result<Option<Stored>, EngineError> {
        if let Some((_, inline)) = self.pending.values.get(hash) {
            return Ok(Some(inline.clone().map_or(Stored::File, Stored::Inline)));
        }
        let row = || -> rusqlite::Result<Option<Option<Vec<u8>>>> {
            let mut s = self.db.prepare_cached("SELECT data FROM value WHERE hash = ?1")?;
            s.query_row([&hash.0[..]], |r| r.get(0)).optional()
        };
        let row = row().map_err(|e| self.sql(&e))?;
        Ok(row.map(|data| data.map_or(Stored::File, |d| Stored::Inline(Arc::new(d)))))
    }

    /// [`Self::value`] for many: those that the cache has. One query for a hundred costs half of a hundred queries.
    pub fn values(&self, hashes: impl Iterator<Item = Digest>) -> Result<BTreeMap<Digest, Stored>, EngineError> {
        const AT_ONCE: usize = 100;
        let mut out = BTreeMap::new();
        let mut asked = Vec::new();
        for hash in hashes {
            match self.pending.values.get(&hash) {
                Some((_, inline)) => drop(out.insert(hash, inline.clone().map_or(Stored::File, Stored::Inline))),
                None => asked.push(hash),
            }
        }
        let query = format!("SELECT hash, data FROM value WHERE hash IN (?{})", ",?".repeat(AT_ONCE - 1));
        let mut read = || -> rusqlite::Result<()> {
            let mut s = self.db.prepare_cached(&query)?;
            for chunk in asked.chunks(AT_ONCE) {
                // What is left unbound is NULL, which no hash equals.
                let padded = (0..AT_ONCE).map(|i| chunk.get(i).map(|hash| &hash.0[..]));
                let mut rows = s.query(rusqlite::params_from_iter(padded))?;
                while let Some(row) = rows.next()? {
                    let hash = row.get_ref(0)?.as_blob()?.try_into().map(Digest).unwrap_or_default();
                    let data: Option<Vec<u8>> = row.get(1)?;
                    out.insert(hash, data.map_or(Stored::File, |d| Stored::Inline(Arc::new(d))));
                }
            }
            Ok(())
        };
        read().map_err(|e| self.sql(&e))?;
        Ok(out)
    }

    /// Notes the values of a stored result: the index holds them, and they are not written again.
    pub fn note_indexed(&mut self, record: &RunRecord) {
        self.indexed.extend(gc::values_of(&record.outputs));
    }

    pub fn is_verified(&self, hash: &Digest) -> bool {
        self.verified.contains(hash)
    }

    pub fn mark_verified(&mut self, hash: Digest) {
        self.verified.insert(hash);
    }

    /// Forgets a value that proved bad or missing; its file, if any, is kept aside.
    pub fn set_aside(&mut self, hash: &Digest) -> Result<(), EngineError> {
        self.flush()?;
        self.verified.remove(hash);
        self.indexed.remove(hash);
        self.blobs.set_aside(hash).map_err(|e| EngineError::cache(&self.root, e))?;
        let delete = "DELETE FROM value WHERE hash = ?1";
        self.db.execute(delete, [&hash.0[..]]).map_err(|e| self.sql(&e))?;
        Ok(())
    }

    /// Stores a run's result. `lock` is freed when the record can be seen by others.
    pub fn put_run(
        &mut self,
        key: Digest,
        record: Arc<RunRecord>,
        values: Vec<NewValue>,
        lock: Option<KeyLock>,
    ) -> Result<(), EngineError> {
        for v in values {
            self.verified.insert(v.hash);
            if self.indexed.contains(&v.hash) {
                continue;
            }
            self.pending.values.insert(v.hash, (v.size, v.inline.map(Arc::new)));
        }
        self.pending.runs.entry(key).or_default().push((record.variant(), record));
        self.pending.locks.extend(lock);
        self.wrote()
    }

    pub fn put_map(&mut self, key: Digest, record: &MapRecord) -> Result<(), EngineError> {
        self.pending.maps.push((key, record.to_bytes()));
        self.wrote()
    }

    /// Stores what a fixed part means, for `why`; called when one of its runs is stored.
    pub fn put_fixed(&mut self, fixed: Digest, fields: impl FnOnce() -> Fields) {
        if self.explained.insert(fixed) {
            self.pending.fixed.insert(fixed, fields());
        }
    }

    fn wrote(&mut self) -> Result<(), EngineError> {
        self.pending.count += 1;
        if self.pending.count >= BATCH.0 || self.flushed.elapsed().as_millis() > BATCH.1 {
            self.flush()
        } else {
            Ok(())
        }
    }

    /// True while results wait to be written.
    pub fn has_pending(&self) -> bool {
        self.pending.count > 0
    }

    /// Writes what waits, in one transaction.
    pub fn flush(&mut self) -> Result<(), EngineError> {
        self.flushed = Instant::now();
        let pending = std::mem::take(&mut self.pending);
        let nothing = pending.count == 0
            && pending.files.is_empty()
            && pending.used_runs.is_empty()
            && pending.used_maps.is_empty()
            && pending.fixed.is_empty();
        if nothing || !self.writable {
            return Ok(());
        }
        self.end()?;
        let write = || -> rusqlite::Result<()> {
            self.db.execute_batch("BEGIN IMMEDIATE")?;
            let now = seconds();
            let db = &self.db;
            let mut s = db.prepare_cached("INSERT OR IGNORE INTO value VALUES(?1, ?2, ?3)")?;
            for (hash, (size, data)) in &pending.values {
                s.execute(params![&hash.0[..], *size as i64, data.as_ref().map(|d| &d[..])])?;
            }
            let mut s = db.prepare_cached("INSERT OR REPLACE INTO run VALUES(?1, ?2, ?3, ?4)")?;
            for (key, variants) in &pending.runs {
                for (variant, record) in variants {
                    s.execute(params![&key.0[..], &variant.0[..], record.to_bytes(), now])?;
                }
            }
            let mut s = db.prepare_cached("INSERT OR REPLACE INTO map VALUES(?1, ?2, ?3)")?;
            for (key, record) in &pending.maps {
                s.execute(params![&key.0[..], record, now])?;
            }
            let mut s = db.prepare_cached("INSERT OR IGNORE INTO fixed VALUES(?1, ?2)")?;
            for (hash, fields) in &pending.fixed {
                s.execute(params![&hash.0[..], fields_to_bytes(fields)])?;
            }
            let mut s = db.prepare_cached("INSERT OR REPLACE INTO file VALUES(?1, ?2, ?3, ?4)")?;
            for (path, stamp, hash, at) in &pending.files {
                s.execute(params![path, stamp.to_bytes(), &hash.0[..], at])?;
            }
            for (update, keys) in [
                ("UPDATE run SET used = ?2 WHERE key = ?1", &pending.used_runs),
                ("UPDATE map SET used = ?2 WHERE key = ?1", &pending.used_maps),
            ] {
                let mut s = db.prepare_cached(update)?;
                for key in keys {
                    s.execute(params![&key.0[..], now])?;
                }
            }
            db.execute_batch("COMMIT")
        };
        write().map_err(|e| {
            // A statement that failed may have ended the transaction itself: the second answer tells nothing.
            let _ = self.db.execute_batch("ROLLBACK");
            self.sql(&e)
        })
    }

    /// What a key's fixed part was made of.
    pub fn fixed(&self, hash: &Digest) -> Result<Option<Fields>, EngineError> {
        let row = || -> rusqlite::Result<Option<Vec<u8>>> {
            let mut s = self.db.prepare_cached("SELECT fields FROM fixed WHERE hash = ?1")?;
            s.query_row([&hash.0[..]], |r| r.get(0)).optional()
        };
        Ok(row().map_err(|e| self.sql(&e))?.and_then(|b| fields_from_bytes(&b)))
    }

    /// The newest bake records of `pipeline` into `folder`, newest first.
    pub fn bakes(&self, pipeline: &str, folder: &str, count: i64) -> Result<Vec<BakeRecord>, EngineError> {
        let read = || -> rusqlite::Result<Vec<BakeRecord>> {
            let query = "SELECT record FROM bake WHERE pipeline = ?1 AND folder = ?2 ORDER BY id DESC LIMIT ?3";
            let mut s = self.db.prepare_cached(query)?;
            let mut rows = s.query(params![pipeline, folder, count])?;
            let mut out = Vec::new();
            while let Some(row) = rows.next()? {
                out.extend(BakeRecord::from_bytes(row.get_ref(0)?.as_blob()?));
            }
            Ok(out)
        };
        read().map_err(|e| self.sql(&e))
    }

    pub fn put_bake(&mut self, pipeline: &str, folder: &str, record: &BakeRecord) -> Result<(), EngineError> {
        self.flush()?;
        if !self.writable {
            return Ok(());
        }
        let write = || -> rusqlite::Result<()> {
            self.db.execute_batch("BEGIN IMMEDIATE")?;
            let insert = "INSERT INTO bake(pipeline, folder, record) VALUES(?1, ?2, ?3)";
            self.db.execute(insert, params![pipeline, folder, record.to_bytes()])?;
            self.db
                .execute("DELETE FROM bake WHERE id NOT IN (SELECT id FROM bake ORDER BY id DESC LIMIT ?1)", [BAKES])?;
            self.db.execute_batch("COMMIT")
        };
        write().map_err(|e| {
            let _ = self.db.execute_batch("ROLLBACK");
            self.sql(&e)
        })
    }

    /// Content hash and size of an outside file; `None` where there is none.
    pub fn hash_file(&mut self, path: &Path) -> Result<Option<(Digest, u64)>, io::Error> {
        let meta = match fs::metadata(path) {
            Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => return Ok(None),
            other => other?,
        };
        regular::check(&meta)?;
        let (stamp, name) = (Stamp::of(&meta), path.to_string_lossy().into_owned());
        let remembered = || -> rusqlite::Result<Option<(Vec<u8>, Vec<u8>)>> {
            let mut s = self.db.prepare_cached("SELECT stamp, hash FROM file WHERE path = ?1")?;
            s.query_row([&name], |r| Ok((r.get(0)?, r.get(1)?))).optional()
        };
        if let Ok(Some((old, hash))) = remembered()
            && old == stamp.to_bytes()
            && let Ok(hash) = hash.try_into()
        {
            return Ok(Some((Digest(hash), stamp.size)));
        }
        let at = nanoseconds(SystemTime::now());
        let bytes = regular::read(path)?;
        let hash = Digest::of(&bytes);
        // Remembered only if it did not change while it was read and cannot change unseen afterwards.
        if stamp.settled(at) && Stamp::of(&fs::metadata(path)?) == stamp {
            self.pending.files.push((name, stamp, hash, (at / 1_000_000_000) as i64));
        }
        Ok(Some((hash, bytes.len() as u64)))
    }
}

impl Drop for Cache {
    fn drop(&mut self) {
        // A bake that ends early still keeps its finished elements; it has its own error to tell.
        let _ = self.flush();
    }
}

fn fields_to_bytes(fields: &Fields) -> Vec<u8> {
    let mut w = Writer::default();
    w.list(fields, |w, (a, b)| {
        w.str(a);
        w.str(b);
    });
    w.finish()
}

fn fields_from_bytes(bytes: &[u8]) -> Option<Fields> {
    Reader::open(bytes)?.list(|r| Some((r.str()?.to_owned(), r.str()?.to_owned())))
}
