//! What a cache holds, and whether every value is what its hash says.

use super::{
    NOT_KEPT,
    blob::{Bad, Blobs},
    blob_of, digest, fields_from_bytes,
    files::Remembered,
    gc::values_of,
    index::{self, Index},
    layout, number,
};
use crate::{
    engine::{
        error::EngineError,
        hash::Digest,
        record::{BakeRecord, MapRecord, RunRecord},
    },
    math::Stop,
};
use rayon::prelude::*;
use rusqlite::types::ValueRef;
use std::{collections::BTreeSet, fs, path::Path};

/// What a cache holds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Results of single runs, and of whole maps.
    pub runs: u64,
    pub maps: u64,
    /// Distinct values, and their bytes.
    pub values: u64,
    pub bytes: u64,
    /// Of these, what lies in the index itself.
    pub inline_values: u64,
    pub inline_bytes: u64,
    /// Size of the index file in bytes.
    pub index_bytes: u64,
    /// Bake records kept.
    pub bakes: u64,
    /// Why the cache can only be read, where it can only be read.
    pub read_only: Option<String>,
}

/// What `verify` found. Clean if nothing is bad and nothing was dropped.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Verified {
    pub values: u64,
    pub bytes: u64,
    /// Values that are missing or not what their hash says. They were set aside.
    pub bad: Vec<String>,
    /// Records that were damaged or led to a bad value. They were removed; their runs will be repeated.
    pub dropped_records: u64,
    /// Why what is bad stays where it is: the cache cannot be written.
    pub read_only: Option<String>,
}

impl Verified {
    pub fn is_clean(&self) -> bool {
        self.bad.is_empty() && self.dropped_records == 0
    }
}

/// Counts; `None` where there is no cache.
pub fn stats(cache: &Path) -> Result<Option<Stats>, EngineError> {
    let Some(db) = index::open_existing(cache)? else { return Ok(None) };
    let read = || -> rusqlite::Result<Stats> {
        let count = |query: &str| db.query_row(query, [], |r| Ok(number(r.get_ref(0)?).max(0) as u64));
        Ok(Stats {
            runs: count("SELECT count(*) FROM run")?,
            maps: count("SELECT count(*) FROM map")?,
            values: count("SELECT count(*) FROM value WHERE typeof(data) <> 'integer'")?,
            bytes: count("SELECT ifnull(sum(size), 0) FROM value")?,
            inline_values: count("SELECT count(*) FROM value WHERE typeof(data) = 'blob'")?,
            inline_bytes: count("SELECT ifnull(sum(size), 0) FROM value WHERE typeof(data) = 'blob'")?,
            index_bytes: fs::metadata(layout::path(cache)).map_or(0, |m| m.len()),
            bakes: count("SELECT count(*) FROM bake")?,
            read_only: db.read_only.clone(),
        })
    };
    read().map(Some).map_err(|e| index::error(cache, &e))
}

/// Reads every value and record, and proves the structure of the index. What is bad is set aside, so that its producer
/// runs again. `None` where there is no cache.
pub fn verify(cache: &Path, stop: &Stop) -> Result<Option<Verified>, EngineError> {
    let result = verify_index(cache, stop);
    if let Err(EngineError::Damaged { what, .. }) = &result {
        index::set_aside(cache, true)?;
        let bad = vec![format!("the index was damaged ({what}) and set aside; everything will be baked anew")];
        return Ok(Some(Verified { bad, ..Verified::default() }));
    }
    result
}

fn verify_index(cache: &Path, stop: &Stop) -> Result<Option<Verified>, EngineError> {
    let Some(mut db) = index::open_existing(cache)? else { return Ok(None) };
    let sql = |e: rusqlite::Error| index::error(cache, &e);
    if let Some(what) = index::fault(&db).map_err(sql)? {
        return Err(EngineError::Damaged { path: cache.to_owned(), what });
    }
    let mut found = Verified { read_only: db.read_only.clone(), ..Verified::default() };
    let blobs = Blobs::new(cache);
    let (good, bad) = values(&db, &blobs, stop, &mut found).map_err(|e| match e {
        Fail::Sql(e) => sql(e),
        Fail::Stopped => EngineError::Interrupted,
    })?;
    for (hash, _, what) in &bad {
        if found.read_only.is_none() {
            blobs.set_aside(hash);
        }
        found.bad.push(format!("{}: {what}", hash.hex()));
    }
    let bad_values: BTreeSet<Digest> = bad.iter().map(|(hash, ..)| *hash).collect();
    let rows = bad_rows(&db, &good, &bad_values).map_err(sql)?;
    found.dropped_records = rows.len() as u64;
    if found.read_only.is_none() {
        let drop_bad = |db: &mut Index| -> rusqlite::Result<()> {
            let t = db.transaction_with_behavior(rusqlite::TransactionBehavior::Immediate)?;
            for (_, row, _) in &bad {
                t.execute("DELETE FROM value WHERE rowid = ?1", [row])?;
            }
            for row in &rows {
                match row {
                    Row::Numbered(table, row) => t.execute(&format!("DELETE FROM {table} WHERE rowid = ?1"), [row])?,
                    Row::Fixed(hash) => t.execute("DELETE FROM fixed WHERE hash = ?1", [hash])?,
                    Row::File(path) => t.execute("DELETE FROM file WHERE path = ?1", [path])?,
                };
            }
            t.commit()
        };
        drop_bad(&mut db).map_err(sql)?;
    }
    Ok(Some(found))
}

/// A row of the index that is damaged or leads to a bad value.
enum Row {
    Numbered(&'static str, i64),
    Fixed(Vec<u8>),
    File(String),
}

fn bad_rows(db: &Index, good: &BTreeSet<Digest>, bad_values: &BTreeSet<Digest>) -> rusqlite::Result<Vec<Row>> {
    // What another process stored since the values were read is sound by its own account.
    let known = |hash: Digest| -> bool {
        let is_new = || {
            let query = "SELECT 1 FROM value WHERE hash = ?1";
            db.prepare_cached(query).and_then(|mut s| s.exists([&hash.0[..]])).unwrap_or(false)
        };
        good.contains(&hash) || !bad_values.contains(&hash) && is_new()
    };
    let mut bad = Vec::new();
    let mut each = |query: &str, f: &mut dyn FnMut(&rusqlite::Row, &mut Vec<Row>) -> rusqlite::Result<()>| {
        let mut s = db.prepare(query)?;
        let mut rows = s.query([])?;
        while let Some(row) = rows.next()? {
            f(row, &mut bad)?;
        }
        Ok::<(), rusqlite::Error>(())
    };
    each("SELECT rowid, key, variant, record FROM run", &mut |row, bad| {
        let (key, variant) = (digest(row.get_ref(1)?), digest(row.get_ref(2)?));
        let record = RunRecord::from_bytes(blob_of(row.get_ref(3)?), &key, &variant);
        if !record.is_some_and(|r| values_of(&r.outputs).all(known)) {
            bad.push(Row::Numbered("run", row.get(0)?));
        }
        Ok(())
    })?;
    each("SELECT rowid, key, record FROM map", &mut |row, bad| {
        let record = MapRecord::from_bytes(blob_of(row.get_ref(2)?), &digest(row.get_ref(1)?));
        if !record.is_some_and(|r| r.rows.iter().all(|row| values_of(&row.outputs).all(known))) {
            bad.push(Row::Numbered("map", row.get(0)?));
        }
        Ok(())
    })?;
    each("SELECT id, pipeline, folder, record FROM bake", &mut |row, bad| {
        let text = |v: ValueRef<'_>| v.as_str().unwrap_or("").to_owned();
        let (id, pipeline, folder) = (row.get(0)?, text(row.get_ref(1)?), text(row.get_ref(2)?));
        if BakeRecord::from_bytes(blob_of(row.get_ref(3)?), id, &pipeline, &folder).is_none() {
            bad.push(Row::Numbered("bake", id));
        }
        Ok(())
    })?;
    each("SELECT hash, fields FROM fixed", &mut |row, bad| {
        if fields_from_bytes(blob_of(row.get_ref(1)?), &digest(row.get_ref(0)?)).is_none() {
            bad.push(Row::Fixed(blob_of(row.get_ref(0)?).to_vec()));
        }
        Ok(())
    })?;
    each("SELECT path, record FROM file", &mut |row, bad| {
        let path = row.get_ref(0)?.as_str().unwrap_or("");
        if Remembered::from_bytes(blob_of(row.get_ref(1)?), path).is_none() {
            bad.push(Row::File(path.to_owned()));
        }
        Ok(())
    })?;
    Ok(bad)
}

enum Fail {
    Sql(rusqlite::Error),
    Stopped,
}

type Values = (BTreeSet<Digest>, Vec<(Digest, i64, String)>);

/// The good values, and the bad ones with their rows.
fn values(db: &Index, blobs: &Blobs, stop: &Stop, found: &mut Verified) -> Result<Values, Fail> {
    let (mut good, mut bad, mut large) = (BTreeSet::new(), Vec::new(), Vec::new());
    let mut s = db.prepare("SELECT hash, size, data, rowid FROM value").map_err(Fail::Sql)?;
    let mut rows = s.query([]).map_err(Fail::Sql)?;
    while let Some(row) = rows.next().map_err(Fail::Sql)? {
        let (hash, data) = (digest(row.get_ref(0).map_err(Fail::Sql)?), row.get_ref(2).map_err(Fail::Sql)?);
        let at: i64 = row.get(3).map_err(Fail::Sql)?;
        found.values += u64::from(!matches!(data, ValueRef::Integer(NOT_KEPT)));
        found.bytes += number(row.get_ref(1).map_err(Fail::Sql)?).max(0) as u64;
        match data {
            ValueRef::Null => large.push((hash, at)),
            // There are no bytes that could be bad.
            ValueRef::Integer(NOT_KEPT) => drop(good.insert(hash)),
            data if data.as_blob().is_ok_and(|data| Digest::of(data) == hash) => {
                good.insert(hash);
            }
            _ => bad.push((hash, at, "its bytes in the index are not what its hash says".to_owned())),
        }
    }
    let checked: Vec<(Digest, i64, Result<(), Bad>)> = large
        .into_par_iter()
        .map(|(hash, at)| {
            stop.check().map_err(|_| Fail::Stopped)?;
            Ok((hash, at, blobs.get(&hash, false).map(drop)))
        })
        .collect::<Result<_, Fail>>()?;
    for (hash, at, result) in checked {
        match result {
            Ok(()) => {
                good.insert(hash);
            }
            Err(Bad(what)) => bad.push((hash, at, what)),
        }
    }
    Ok((good, bad))
}
