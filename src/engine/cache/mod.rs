//! The cache of results: an index in SQLite, large values as files beside it.
//!
//! What always holds: a record is in the index only after the values it names were stored; whatever is read is checked
//! against its hash or checksum, so that damage is a miss and never another result; several processes may use one
//! cache, and any of them may be killed at any moment. Deleting the whole folder between runs is fine.

mod bakes;
pub mod blob;
mod carve;
pub mod files;
mod folder;
mod gc;
pub(super) mod index;
mod layout;
pub mod lock;
pub mod pack;
mod rebuild;
#[cfg(test)]
mod tests;
mod verify;
mod write;

pub use bakes::{BakesOnRecord, PROTECTED};
pub use folder::check as check_folder;
pub use gc::{Collected, Limits, gc, values_of};
pub use index::set_aside as set_index_aside;
pub use rebuild::{Rebuilt, rebuild};
pub use verify::{Stats, Verified, stats, verify};
pub use write::{NewValue, Place};

use super::{
    error::EngineError,
    hash::Digest,
    lookup::{DigestMap, DigestSet},
    record::{MapRecord, RunRecord},
    wire::{Reader, RecordPlace, Writer},
};
use blob::Blobs;
use files::nanoseconds;
use index::Index;
use lock::{KeyLock, KeyLocks, Lock};
use rusqlite::{OptionalExtension as _, types::ValueRef};
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Instant, SystemTime},
};
use write::Pending;

/// A hit younger than this many seconds is not noted anew.
const FRESH: i64 = 24 * 3600;

/// Where a stored value lies.
#[derive(Clone, Debug)]
pub enum Stored {
    Inline(Arc<Vec<u8>>),
    File,
    /// Nowhere: only its hash is known.
    NotKept,
}

/// Stands in the place of a value's bytes where they are not kept.
const NOT_KEPT: i64 = 0;

/// Fields of a key's fixed part, as text.
pub type Fields = Vec<(String, String)>;

/// An open cache, owned by the scheduler's thread.
pub struct Cache {
    root: PathBuf,
    db: Index,
    blobs: Blobs,
    pending: Pending,
    flushed: Instant,
    /// Values whose bytes this process has checked.
    verified: DigestSet,
    /// Values that the index is known to hold.
    indexed: DigestSet,
    explained: BTreeSet<Digest>,
    /// When this bake began, in seconds since 1970.
    began: i64,
    writable: bool,
    locks: KeyLocks,
    _claim: Option<Lock>,
    /// Damage met, to be told once.
    pub warnings: Vec<String>,
    /// Numbers of bake records that are damaged.
    bad_bakes: BTreeSet<i64>,
}

fn seconds() -> i64 {
    (nanoseconds(SystemTime::now()) / 1_000_000_000) as i64
}

impl Cache {
    /// Opens the cache at `root`, making it where it is missing. One that is not `writable`, or that the system does not
    /// let be written, takes no results; it needs no folder if that is asked for.
    pub fn open(root: &Path, writable: bool) -> Result<Self, EngineError> {
        let mut db = if writable {
            index::open(root)?
        } else {
            match index::open_existing(root)? {
                Some(db) => db,
                None => index::empty(root)?,
            }
        };
        let mut claim = None;
        if writable && db.read_only.is_none() {
            match lock::claim(root) {
                Ok(lock) => claim = Some(lock),
                Err(e) => db.read_only = Some(e.to_string()),
            }
        }
        Ok(Self::new(root, db, writable, claim))
    }

    /// A cache that holds nothing and takes nothing, in the place of one whose index is damaged.
    pub fn blank(root: &Path) -> Result<Self, EngineError> {
        Ok(Self::new(root, index::empty(root)?, false, None))
    }

    fn new(root: &Path, db: Index, writable: bool, claim: Option<Lock>) -> Self {
        let writable = writable && db.read_only.is_none();
        Self {
            root: root.to_owned(),
            db,
            blobs: Blobs::new(root),
            pending: Pending::default(),
            flushed: Instant::now(),
            verified: DigestSet::default(),
            indexed: DigestSet::default(),
            explained: BTreeSet::new(),
            began: seconds(),
            writable,
            locks: KeyLocks::default(),
            _claim: claim,
            warnings: Vec::new(),
            bad_bakes: BTreeSet::new(),
        }
    }

    pub fn root(&self) -> &Path {
        &self.root
    }

    pub fn blobs(&self) -> &Blobs {
        &self.blobs
    }

    /// Takes the lock of a key; `None` while another process holds it.
    pub fn lock(&mut self, key: &Digest) -> Result<Option<KeyLock>, EngineError> {
        if let Some(why) = &self.db.read_only {
            let text = format!("cannot be written ({why}), but something has to run; name another folder with --cache");
            return Err(EngineError::cache(&self.root, text));
        }
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
        let rows = || -> rusqlite::Result<Vec<(Digest, Option<RunRecord>, i64, i64)>> {
            let mut s = self.db.prepare_cached("SELECT variant, record, used, rowid FROM run WHERE key = ?1")?;
            let mut rows = s.query([&key.0[..]])?;
            let mut out = Vec::new();
            while let Some(row) = rows.next()? {
                let variant = digest(row.get_ref(0)?);
                let record = RunRecord::from_bytes(blob_of(row.get_ref(1)?), key, &variant);
                out.push((variant, record, number(row.get_ref(2)?), number(row.get_ref(3)?)));
            }
            Ok(out)
        };
        let rows = rows().map_err(|e| self.sql(&e))?;
        let mut out = Vec::with_capacity(rows.len());
        for (variant, record, used, row) in rows {
            match record {
                Some(record) => {
                    if self.began - used > FRESH {
                        self.pending.used_runs.push(*key);
                    }
                    out.push((variant, Arc::new(record)));
                }
                None => {
                    self.warnings.push(format!("the index held a damaged record ({key:?}); its run is repeated"));
                    self.pending.bad_runs.push(row);
                }
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
            let read =
                |r: &rusqlite::Row| Ok((MapRecord::from_bytes(blob_of(r.get_ref(0)?), key), number(r.get_ref(1)?)));
            s.query_row([&key.0[..]], read).optional()
        };
        let Some((record, used)) = row().map_err(|e| self.sql(&e))? else { return Ok(None) };
        if record.is_none() {
            self.warnings.push(format!("the index held a damaged record ({key:?}); its map is made anew"));
            self.pending.bad_maps.push(*key);
        } else if self.began - used > FRESH {
            self.pending.used_maps.push(*key);
        }
        Ok(record)
    }

    /// Where a value lies; `None` where the cache has lost it.
    pub fn value(&self, hash: &Digest) -> Result<Option<Stored>, EngineError> {
        if let Some(stored) = self.pending.stored(hash) {
            return Ok(Some(stored));
        }
        let row = || -> rusqlite::Result<Option<Stored>> {
            let mut s = self.db.prepare_cached("SELECT data FROM value WHERE hash = ?1")?;
            s.query_row([&hash.0[..]], |r| Ok(stored(r.get_ref(0)?))).optional()
        };
        row().map_err(|e| self.sql(&e))
    }

    /// [`Self::value`] for many: those that the cache has. One query for a hundred costs half of a hundred queries.
    pub fn values(&self, hashes: impl Iterator<Item = Digest>) -> Result<DigestMap<Stored>, EngineError> {
        const AT_ONCE: usize = 100;
        let mut out = DigestMap::default();
        let mut asked = Vec::new();
        for hash in hashes {
            match self.pending.stored(&hash) {
                Some(stored) => drop(out.insert(hash, stored)),
                None => asked.push(hash),
            }
        }
        // In the order of the index, neighbours lie on one page of it.
        asked.sort_unstable();
        asked.dedup();
        let query = format!("SELECT hash, data FROM value WHERE hash IN (?{})", ",?".repeat(AT_ONCE - 1));
        let mut read = || -> rusqlite::Result<()> {
            let mut s = self.db.prepare_cached(&query)?;
            for chunk in asked.chunks(AT_ONCE) {
                // What is left unbound is NULL, which no hash equals.
                let padded = (0..AT_ONCE).map(|i| chunk.get(i).map(|hash| &hash.0[..]));
                let mut rows = s.query(rusqlite::params_from_iter(padded))?;
                while let Some(row) = rows.next()? {
                    out.insert(digest(row.get_ref(0)?), stored(row.get_ref(1)?));
                }
            }
            Ok(())
        };
        read().map_err(|e| self.sql(&e))?;
        Ok(out)
    }

    /// Notes the values of a stored result: the index holds them, and they are not written again. Those of which it knows
    /// only the hash are.
    pub fn note_indexed(&mut self, record: &RunRecord) -> Result<(), EngineError> {
        let there = self.values(gc::values_of(&record.outputs))?;
        let is_known = |hash: &Digest| matches!(there.get(hash), Some(Stored::NotKept));
        self.indexed.extend(gc::values_of(&record.outputs).filter(|hash| !is_known(hash)));
        Ok(())
    }

    pub fn is_verified(&self, hash: &Digest) -> bool {
        self.verified.contains(hash)
    }

    pub fn mark_verified(&mut self, hash: Digest) {
        self.verified.insert(hash);
    }

    /// What a key's fixed part was made of.
    pub fn fixed(&self, hash: &Digest) -> Result<Option<Fields>, EngineError> {
        let row = || -> rusqlite::Result<Option<Fields>> {
            let mut s = self.db.prepare_cached("SELECT fields FROM fixed WHERE hash = ?1")?;
            let read = |r: &rusqlite::Row| Ok(fields_from_bytes(blob_of(r.get_ref(0)?), hash));
            s.query_row([&hash.0[..]], read).optional().map(Option::flatten)
        };
        row().map_err(|e| self.sql(&e))
    }
}

impl Drop for Cache {
    fn drop(&mut self) {
        // A bake that ends early still keeps its finished elements; it has its own error to tell.
        let _ = self.flush();
    }
}

/// A hash as it lies in a column; one that nothing has where the column is damaged. That is not zero, which is the
/// variant of a run that read no files.
fn digest(column: ValueRef) -> Digest {
    blob_of(column).try_into().map_or(Digest([0xff; 32]), Digest)
}

/// The bytes in a column. What is of another type is damaged and counts as no bytes: no checksum and no hash fits those.
fn blob_of(column: ValueRef<'_>) -> &[u8] {
    column.as_blob().unwrap_or_default()
}

/// The number in a column, which only says when something was used; 0 where it is damaged.
fn number(column: ValueRef) -> i64 {
    column.as_i64().unwrap_or(0)
}

/// What the column `data` says of a value. Whoever takes the bytes compares them with their hash.
fn stored(data: ValueRef) -> Stored {
    match data {
        ValueRef::Null => Stored::File,
        ValueRef::Integer(_) => Stored::NotKept,
        data => Stored::Inline(Arc::new(blob_of(data).to_vec())),
    }
}

fn fields_to_bytes(fields: &Fields, hash: &Digest) -> Vec<u8> {
    let mut w = Writer::default();
    w.list(fields, |w, (a, b)| {
        w.str(a);
        w.str(b);
    });
    w.seal(&RecordPlace::Fixed { hash })
}

fn fields_from_bytes(bytes: &[u8], hash: &Digest) -> Option<Fields> {
    Reader::open(bytes, &RecordPlace::Fixed { hash })?.list(|r| Some((r.str()?.to_owned(), r.str()?.to_owned())))
}
