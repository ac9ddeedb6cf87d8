//! The index made anew: from the value files, and from what a damaged index and one that was set aside still say. Which result belongs to which key is
//! said by the index alone, sealed by checksums; so every record that proves itself is kept, whatever became of the rest of the file.

use super::{
    NOT_KEPT,
    blob::{Bad, Blobs},
    carve::{self, Column},
    fields_from_bytes,
    files::Remembered,
    folder,
    gc::values_of,
    index,
    layout::{self, MADE},
    lock,
};
use crate::{
    engine::{
        error::EngineError,
        hash::Digest,
        record::{BakeRecord, MapRecord, RunRecord},
        temporary,
        value::PortOut,
    },
    math::Stop,
};
use rayon::prelude::*;
use rusqlite::{
    Connection, params,
    types::{ToSqlOutput, ValueRef},
};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

/// What an index that was made anew holds, and what was lost.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rebuilt {
    pub runs: u64,
    pub maps: u64,
    pub bakes: u64,
    /// Values whose bytes are there, and these bytes.
    pub values: u64,
    pub bytes: u64,
    /// Value files that are not what their names say. They were set aside.
    pub bad: Vec<String>,
    /// Records that were found damaged, or that lead to values that are not there. Their runs will be repeated.
    pub dropped_records: u64,
}

/// Makes the index anew. `None` where there is no cache. No bake may be at work.
///
/// # Errors
/// Where a bake is at work, where the cache cannot be read or written, and where `stop` was set: the index is then what it was.
pub fn rebuild(cache: &Path, stop: &Stop) -> Result<Option<Rebuilt>, EngineError> {
    if matches!(folder::check(cache)?, folder::Found::Absent | folder::Found::Empty) {
        return Ok(None);
    }
    let unwritable = |why: String| EngineError::cache(cache, format!("cannot be written ({why})"));
    if let Some(why) = folder::prepare(cache)? {
        return Err(unwritable(why));
    }
    let fail = |e: std::io::Error| unwritable(e.to_string());
    if lock::oldest_claim(cache).map_err(fail)?.is_some() {
        let text = "a bake is at work in it; let it end first, or what it stores from now on is not in the new index";
        return Err(EngineError::cache(cache, text));
    }
    let _lock = index::lock(cache).map_err(fail)?;
    let new = cache.join("tmp").join(temporary::name());
    let made = Rebuild { cache, stop, found: Rebuilt::default(), values: BTreeMap::new() }.make(&new);
    let replaced = made.and_then(|found| {
        // No log of another file may lie beside the new one.
        index::move_aside(cache).map_err(fail)?;
        fs::rename(&new, layout::path(cache)).map_err(fail)?;
        for name in layout::NAMES_ASIDE {
            let _ = fs::remove_file(cache.join(name));
        }
        Ok(found)
    });
    replaced.map(Some).inspect_err(|_| drop(fs::remove_file(&new)))
}

/// Where a value's bytes are that were found.
enum Place {
    /// In a file of so many bytes.
    File(u64),
    Inline,
    NotKept,
}

struct Rebuild<'a> {
    cache: &'a Path,
    stop: &'a Stop,
    found: Rebuilt,
    values: BTreeMap<Digest, Place>,
}

enum Fail {
    Sql(rusqlite::Error),
    Engine(EngineError),
}

impl From<rusqlite::Error> for Fail {
    fn from(e: rusqlite::Error) -> Self {
        Self::Sql(e)
    }
}

fn hash(column: &Column) -> Option<Digest> {
    if let Column::Blob(bytes) = column { (*bytes).try_into().ok().map(Digest) } else { None }
}

/// The number that says when something was used.
fn used(column: &Column) -> i64 {
    if let Column::Int(n) = column { *n } else { 0 }
}

impl Rebuild<'_> {
    fn make(mut self, path: &Path) -> Result<Rebuilt, EngineError> {
        self.value_files()?;
        match self.write(path) {
            Ok(()) => Ok(self.found),
            Err(Fail::Engine(e)) => Err(e),
            Err(Fail::Sql(e)) => Err(EngineError::cache(self.cache, format!("a new index cannot be written ({e})"))),
        }
    }

    fn write(&mut self, path: &Path) -> Result<(), Fail> {
        let db = Connection::open(path)?;
        // Not known to anyone until it is whole.
        db.execute_batch("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; BEGIN")?;
        db.execute_batch(&index::TABLES.join("; "))?;
        self.write_values(&db)?;
        self.write_records(&db)?;
        db.execute_batch(&format!("PRAGMA user_version = {MADE}; COMMIT"))?;
        let count = |table: &str| {
            let query = format!("SELECT count(*) FROM {table}");
            db.query_row(&query, [], |r| r.get::<_, i64>(0)).map(|n| n.max(0) as u64)
        };
        (self.found.runs, self.found.maps, self.found.bakes) = (count("run")?, count("map")?, count("bake")?);
        db.close().map_err(|(_, e)| e.into())
    }

    /// Reads every value file; bad ones are set aside.
    fn value_files(&mut self) -> Result<(), EngineError> {
        let blobs = Blobs::new(self.cache);
        let mut files = Vec::new();
        let listed = blobs.each(|hash, meta, _| {
            files.push((hash, meta.len()));
            Ok(())
        });
        listed.map_err(|e| EngineError::cache(self.cache, format!("its values cannot be read: {e}")))?;
        let check = |(hash, size): (Digest, u64)| {
            self.stop.check().map_err(|_| EngineError::Interrupted)?;
            Ok((hash, size, blobs.get(&hash, false).map(drop)))
        };
        let checked: Vec<_> = files.into_par_iter().map(check).collect::<Result<_, EngineError>>()?;
        for (hash, size, result) in checked {
            match result {
                Ok(()) => {
                    self.found.values += 1;
                    self.found.bytes += size;
                    self.values.insert(hash, Place::File(size));
                }
                Err(Bad(what)) => {
                    blobs.set_aside(&hash);
                    self.found.bad.push(format!("{}: {what}", hash.hex()));
                }
            }
        }
        self.found.bad.sort();
        Ok(())
    }

    /// The rows of the index, and of the one that was set aside before it.
    fn rows(&self, mut f: impl FnMut(i64, &[Column]) -> rusqlite::Result<()>) -> Result<(), Fail> {
        let mut failed = None;
        for name in [layout::FILE, layout::NAMES_ASIDE[0]] {
            let path: PathBuf = self.cache.join(name);
            let mut row = |number: i64, columns: &[Column]| {
                if failed.is_none() {
                    failed = f(number, columns).err();
                }
            };
            carve::rows(&path, self.stop, &mut row).map_err(|e| {
                Fail::Engine(match e {
                    carve::Fail::Stopped => EngineError::Interrupted,
                    carve::Fail::Io(e) => EngineError::File { path, what: format!("cannot be read: {e}") },
                })
            })?;
        }
        failed.map_or(Ok(()), |e| Err(Fail::Sql(e)))
    }

    fn write_values(&mut self, db: &Connection) -> Result<(), Fail> {
        let mut insert = db.prepare("INSERT INTO value VALUES(?1, ?2, ?3)")?;
        for (hash, place) in &self.values {
            if let Place::File(size) = place {
                insert.execute(params![&hash.0[..], *size as i64, rusqlite::types::Null])?;
            }
        }
        let (mut inline, mut not_kept) = (BTreeSet::new(), BTreeSet::new());
        let (mut count, mut bytes) = (0, 0);
        self.rows(|_, columns| {
            let [key, Column::Int(_), data] = columns else { return Ok(()) };
            let Some(hash) = hash(key).filter(|hash| !self.values.contains_key(hash)) else { return Ok(()) };
            match data {
                Column::Int(NOT_KEPT) => drop(not_kept.insert(hash)),
                Column::Blob(data) if Digest::of(data) == hash && inline.insert(hash) => {
                    (count, bytes) = (count + 1, bytes + data.len() as u64);
                    insert.execute(params![
                        &hash.0[..],
                        data.len() as i64,
                        ToSqlOutput::Borrowed(ValueRef::Blob(data))
                    ])?;
                }
                _ => {}
            }
            Ok(())
        })?;
        for hash in not_kept.difference(&inline) {
            insert.execute(params![&hash.0[..], 0, NOT_KEPT])?;
            self.values.insert(*hash, Place::NotKept);
        }
        self.values.extend(inline.into_iter().map(|hash| (hash, Place::Inline)));
        self.found.values += count;
        self.found.bytes += bytes;
        Ok(())
    }

    fn write_records(&mut self, db: &Connection) -> Result<(), Fail> {
        // Of two records under one key the one that was used last is kept.
        let newer = |table: &str, columns: &str, key: &str| {
            let query = format!(
                "INSERT INTO {table} VALUES({columns}) ON CONFLICT({key}) DO UPDATE SET record = excluded.record, \
                 used = excluded.used WHERE excluded.used > used"
            );
            db.prepare(&query)
        };
        let mut run = newer("run", "?1, ?2, ?3, ?4", "key, variant")?;
        let mut map = newer("map", "?1, ?2, ?3", "key")?;
        let mut fixed = db.prepare("INSERT OR IGNORE INTO fixed VALUES(?1, ?2)")?;
        let mut file = db.prepare("INSERT OR REPLACE INTO file VALUES(?1, ?2, ?3)")?;
        // What was baked later has the larger number.
        let mut bake = db.prepare("INSERT OR IGNORE INTO bake VALUES(?1, ?2, ?3, ?4)")?;
        let is_there = |outputs: &[PortOut]| values_of(outputs).all(|hash| self.values.contains_key(&hash));
        let mut dropped = 0;
        self.rows(|number, columns| {
            let sound = match *columns {
                [key, variant, Column::Blob(bytes), at] => match (hash(&key), hash(&variant)) {
                    (Some(key), Some(variant)) => {
                        let record = RunRecord::from_bytes(bytes, &key, &variant);
                        let sound = record.is_some_and(|record| is_there(&record.outputs));
                        if sound {
                            run.execute(params![&key.0[..], &variant.0[..], bytes, used(&at)])?;
                        }
                        sound
                    }
                    _ => false,
                },
                // The number of a bake is that of its row.
                [Column::Null, Column::Text(pipeline), Column::Text(folder), Column::Blob(bytes)] => {
                    let sound = BakeRecord::from_bytes(bytes, number, pipeline, folder).is_some();
                    if sound {
                        bake.execute(params![number, pipeline, folder, bytes])?;
                    }
                    sound
                }
                [Column::Text(path), Column::Blob(bytes), Column::Int(at)] => {
                    let sound = Remembered::from_bytes(bytes, path).is_some();
                    if sound {
                        file.execute(params![path, bytes, at])?;
                    }
                    sound
                }
                [key @ Column::Blob(_), Column::Blob(bytes), at] => {
                    // Two hashes and a row's number are a place in the index of the runs' keys.
                    let (Some(key), None) = (hash(&key), hash(&Column::Blob(bytes))) else { return Ok(()) };
                    let record = MapRecord::from_bytes(bytes, &key);
                    let sound = record.is_some_and(|r| r.rows.iter().all(|row| is_there(&row.outputs)));
                    if sound {
                        map.execute(params![&key.0[..], bytes, used(&at)])?;
                    }
                    sound
                }
                [key, Column::Blob(bytes)] => {
                    let Some(key) = hash(&key) else { return Ok(()) };
                    let sound = fields_from_bytes(bytes, &key).is_some();
                    if sound {
                        fixed.execute(params![&key.0[..], bytes])?;
                    }
                    sound
                }
                _ => true,
            };
            dropped += u64::from(!sound);
            Ok(())
        })?;
        self.found.dropped_records = dropped;
        Ok(())
    }
}
