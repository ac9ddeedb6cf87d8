//! What a bake writes to the index: gathered, and written in transactions of many.

use super::{Cache, Fields, NOT_KEPT, Stored, fields_to_bytes, files::Remembered, index, lock::KeyLock, seconds};
use crate::engine::{error::EngineError, hash::Digest, record::RunRecord};
use rusqlite::{
    params,
    types::{ToSqlOutput, ValueRef},
};
use std::{collections::BTreeMap, sync::Arc, time::Instant};

/// Results gathered before they are written in one transaction: a number, and milliseconds.
const BATCH: (usize, u128) = (256, 30);

/// A value made by a run, its file already written.
#[derive(Clone, Debug)]
pub struct NewValue {
    pub hash: Digest,
    pub place: Place,
}

/// Where a value's bytes are.
#[derive(Clone, Debug)]
pub enum Place {
    /// In the index.
    Inline(Vec<u8>),
    /// In their file, which takes so many bytes.
    File(u64),
    /// Nowhere: its node is transient.
    NotKept,
}

impl Place {
    pub fn stored(&self) -> Stored {
        match self {
            Self::Inline(bytes) => Stored::Inline(Arc::new(bytes.clone())),
            Self::File(_) => Stored::File,
            Self::NotKept => Stored::NotKept,
        }
    }
}

#[derive(Default)]
pub(super) struct Pending {
    /// Bytes that they take, and where they are.
    pub values: BTreeMap<Digest, (u64, Stored)>,
    pub runs: BTreeMap<Digest, Vec<(Digest, Arc<RunRecord>)>>,
    pub maps: Vec<(Digest, Vec<u8>)>,
    pub fixed: BTreeMap<Digest, Fields>,
    pub files: Vec<(String, Remembered)>,
    pub used_runs: Vec<Digest>,
    pub used_maps: Vec<Digest>,
    /// Damaged rows, to be removed: of runs by their place, since their columns may be damaged too.
    pub bad_runs: Vec<i64>,
    pub bad_maps: Vec<Digest>,
    pub bad_files: Vec<String>,
    /// Freed once the rows that they protect are written.
    pub locks: Vec<KeyLock>,
    /// Results among all that.
    pub count: usize,
}

impl Pending {
    /// Where a value lies that waits to be written.
    pub fn stored(&self, hash: &Digest) -> Option<Stored> {
        self.values.get(hash).map(|(_, stored)| stored.clone())
    }

    /// True where only what is nice to know would be lost.
    fn is_only_notes(&self) -> bool {
        self.count == 0 && self.fixed.is_empty()
    }

    fn is_empty(&self) -> bool {
        self.is_only_notes()
            && self.files.is_empty()
            && self.used_runs.is_empty()
            && self.used_maps.is_empty()
            && self.bad_runs.is_empty()
            && self.bad_maps.is_empty()
            && self.bad_files.is_empty()
    }
}

impl Cache {
    /// Forgets a value that proved bad or missing; its file, if any, is kept aside.
    pub fn set_aside(&mut self, hash: &Digest) -> Result<(), EngineError> {
        self.flush()?;
        self.verified.remove(hash);
        self.indexed.remove(hash);
        if !self.writable {
            return Ok(());
        }
        self.blobs.set_aside(hash);
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
        self.note_values(values);
        self.pending.runs.entry(key).or_default().push((record.variant(), record));
        self.pending.locks.extend(lock);
        self.wrote()
    }

    /// Stores values that were found elsewhere, and checked, after the record that names them.
    pub fn put_values(&mut self, values: Vec<NewValue>) -> Result<(), EngineError> {
        self.note_values(values);
        self.wrote()
    }

    /// Values whose files, where they have any, are written.
    fn note_values(&mut self, values: Vec<NewValue>) {
        for v in values {
            let (size, stored) = match v.place {
                Place::Inline(bytes) => (bytes.len() as u64, Stored::Inline(Arc::new(bytes))),
                Place::File(size) => (size, Stored::File),
                Place::NotKept => (0, Stored::NotKept),
            };
            let kept = !matches!(stored, Stored::NotKept);
            // Only files are checked when they are read.
            if matches!(stored, Stored::File) {
                self.verified.insert(v.hash);
            }
            if self.indexed.contains(&v.hash) || !kept && self.pending.values.contains_key(&v.hash) {
                continue;
            }
            self.pending.values.insert(v.hash, (size, stored));
        }
    }

    /// Stores what [`MapRecord::write`](crate::engine::record::MapRecord::write) gave.
    pub fn put_map(&mut self, key: Digest, record: Vec<u8>) -> Result<(), EngineError> {
        self.pending.maps.push((key, record));
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

    /// Whether it takes results.
    pub fn is_writable(&self) -> bool {
        self.writable
    }

    /// True while results wait to be written.
    pub fn has_pending(&self) -> bool {
        self.pending.count > 0
    }

    /// Writes what waits, in one transaction. Where nothing can be written and no result waits, that is no error.
    pub fn flush(&mut self) -> Result<(), EngineError> {
        self.flushed = Instant::now();
        let pending = std::mem::take(&mut self.pending);
        if pending.is_empty() || !self.writable {
            return Ok(());
        }
        self.end()?;
        match self.write(&pending) {
            Err(e) if pending.is_only_notes() && index::cannot_write(&e) => Ok(()),
            Err(e) => {
                // What comes later may lead to what is lost with this: nothing more is stored.
                self.writable = false;
                Err(self.sql(&e))
            }
            Ok(()) => Ok(()),
        }
    }

    /// Runs `f` in a transaction.
    pub(super) fn transaction(&self, f: impl FnOnce() -> rusqlite::Result<()>) -> rusqlite::Result<()> {
        let write = || {
            self.db.execute_batch("BEGIN IMMEDIATE")?;
            f()?;
            self.db.execute_batch("COMMIT")
        };
        write().inspect_err(|_| {
            // A statement that failed may have ended the transaction itself: the second answer tells nothing.
            let _ = self.db.execute_batch("ROLLBACK");
        })
    }

    fn write(&self, pending: &Pending) -> rusqlite::Result<()> {
        self.transaction(|| {
            let now = seconds();
            let db = &self.db;
            let mut s = db.prepare_cached("DELETE FROM run WHERE rowid = ?1")?;
            for row in &pending.bad_runs {
                s.execute([row])?;
            }
            let mut s = db.prepare_cached("DELETE FROM map WHERE key = ?1")?;
            for key in &pending.bad_maps {
                s.execute([&key.0[..]])?;
            }
            let mut s = db.prepare_cached("DELETE FROM file WHERE path = ?1")?;
            for path in &pending.bad_files {
                s.execute([path])?;
            }
            // Of a value that was not kept, and now is, the row is replaced; any other says the same already.
            let query = "INSERT INTO value VALUES(?1, ?2, ?3) ON CONFLICT(hash) DO UPDATE \
                         SET size = excluded.size, data = excluded.data \
                         WHERE typeof(data) = 'integer' AND typeof(excluded.data) <> 'integer'";
            let mut s = db.prepare_cached(query)?;
            for (hash, (size, stored)) in &pending.values {
                let data = match stored {
                    Stored::Inline(bytes) => ValueRef::Blob(bytes),
                    Stored::File => ValueRef::Null,
                    Stored::NotKept => ValueRef::Integer(NOT_KEPT),
                };
                s.execute(params![&hash.0[..], *size as i64, ToSqlOutput::Borrowed(data)])?;
            }
            let mut s = db.prepare_cached("INSERT OR REPLACE INTO run VALUES(?1, ?2, ?3, ?4)")?;
            for (key, variants) in &pending.runs {
                for (variant, record) in variants {
                    s.execute(params![&key.0[..], &variant.0[..], record.to_bytes(key), now])?;
                }
            }
            let mut s = db.prepare_cached("INSERT OR REPLACE INTO map VALUES(?1, ?2, ?3)")?;
            for (key, record) in &pending.maps {
                s.execute(params![&key.0[..], record, now])?;
            }
            let mut s = db.prepare_cached("INSERT OR REPLACE INTO fixed VALUES(?1, ?2)")?;
            for (hash, fields) in &pending.fixed {
                s.execute(params![&hash.0[..], fields_to_bytes(fields, hash)])?;
            }
            let mut s = db.prepare_cached("INSERT OR REPLACE INTO file VALUES(?1, ?2, ?3)")?;
            for (path, known) in &pending.files {
                s.execute(params![path, known.to_bytes(path), known.at])?;
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
            Ok(())
        })
    }
}
