//! What a cache holds, and whether every value is what its hash says.

use super::{
    blob::{BlobError, Blobs},
    gc::values_of,
    index,
};
use crate::{
    engine::{
        error::EngineError,
        hash::Digest,
        record::{MapRecord, RunRecord},
    },
    math::Stop,
};
use rayon::prelude::*;
use rusqlite::Connection;
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
}

impl Verified {
    pub fn is_clean(&self) -> bool {
        self.bad.is_empty() && self.dropped_records == 0
    }
}

pub fn stats(cache: &Path) -> Result<Stats, EngineError> {
    let Some(db) = index::open_existing(cache)? else { return Ok(Stats::default()) };
    let read = || -> rusqlite::Result<Stats> {
        let count = |query: &str| db.query_row(query, [], |r| r.get::<_, i64>(0)).map(|n| n as u64);
        Ok(Stats {
            runs: count("SELECT count(*) FROM run")?,
            maps: count("SELECT count(*) FROM map")?,
            values: count("SELECT count(*) FROM value")?,
            bytes: count("SELECT ifnull(sum(size), 0) FROM value")?,
            inline_values: count("SELECT count(*) FROM value WHERE data IS NOT NULL")?,
            inline_bytes: count("SELECT ifnull(sum(size), 0) FROM value WHERE data IS NOT NULL")?,
            index_bytes: fs::metadata(index::path(cache)).map_or(0, |m| m.len()),
            bakes: count("SELECT count(*) FROM bake")?,
        })
    };
    read().map_err(|e| index::error(cache, &e))
}

/// Reads every value and record. What is bad is set aside, so that its producer runs again.
pub fn verify(cache: &Path, stop: &Stop) -> Result<Verified, EngineError> {
    let result = verify_index(cache, stop);
    if let Err(EngineError::Damaged { what, .. }) = &result {
        index::set_aside(cache)?;
        let bad = vec![format!("the index was damaged ({what}) and set aside; everything will be baked anew")];
        return Ok(Verified { bad, ..Verified::default() });
    }
    result
}

fn verify_index(cache: &Path, stop: &Stop) -> Result<Verified, EngineError> {
    let Some(mut db) = index::open_existing(cache)? else { return Ok(Verified::default()) };
    let sql = |e: rusqlite::Error| index::error(cache, &e);
    let sound: String = db.query_row("PRAGMA quick_check(1)", [], |r| r.get(0)).map_err(sql)?;
    if sound != "ok" {
        return Err(EngineError::Damaged { path: cache.to_owned(), what: sound });
    }
    let mut found = Verified::default();
    let (good, bad) = values(&db, &Blobs::new(cache), stop, &mut found).map_err(|e| match e {
        Fail::Sql(e) => sql(e),
        Fail::Stopped => EngineError::Interrupted,
        Fail::Io(e) => EngineError::cache(cache, e),
    })?;
    let blobs = Blobs::new(cache);
    for (hash, what) in &bad {
        blobs.set_aside(hash).map_err(|e| EngineError::cache(cache, e))?;
        found.bad.push(format!("{}: {what}", hash.hex()));
    }
    let drop_bad = |db: &mut Connection| -> rusqlite::Result<u64> {
        let t = db.transaction_with_behavior(rusqlite::TransactionBehavior::Immediate)?;
        for (hash, _) in &bad {
            t.execute("DELETE FROM value WHERE hash = ?1", [&hash.0[..]])?;
        }
        let mut dropped = 0;
        // What another process stored since the values were read is sound by its own account.
        let known = |hash: Digest| -> bool {
            good.contains(&hash) || {
                let query = "SELECT 1 FROM value WHERE hash = ?1";
                t.prepare_cached(query).and_then(|mut s| s.exists([&hash.0[..]])).unwrap_or(false)
            }
        };
        let mut runs = Vec::new();
        let mut maps = Vec::new();
        {
            let mut s = t.prepare("SELECT key, variant, record FROM run")?;
            let mut rows = s.query([])?;
            while let Some(row) = rows.next()? {
                let record = RunRecord::from_bytes(row.get_ref(2)?.as_blob()?);
                if !record.is_some_and(|r| values_of(&r.outputs).all(known)) {
                    runs.push((row.get::<_, Vec<u8>>(0)?, row.get::<_, Vec<u8>>(1)?));
                }
            }
            let mut s = t.prepare("SELECT key, record FROM map")?;
            let mut rows = s.query([])?;
            while let Some(row) = rows.next()? {
                let record = MapRecord::from_bytes(row.get_ref(1)?.as_blob()?);
                if !record.is_some_and(|r| r.rows.iter().all(|row| values_of(&row.outputs).all(known))) {
                    maps.push(row.get::<_, Vec<u8>>(0)?);
                }
            }
        }
        for (key, variant) in &runs {
            dropped += t.execute("DELETE FROM run WHERE key = ?1 AND variant = ?2", [key, variant])?;
        }
        for key in &maps {
            dropped += t.execute("DELETE FROM map WHERE key = ?1", [key])?;
        }
        t.commit()?;
        Ok(dropped as u64)
    };
    found.dropped_records = drop_bad(&mut db).map_err(sql)?;
    Ok(found)
}

enum Fail {
    Sql(rusqlite::Error),
    Io(std::io::Error),
    Stopped,
}

type Values = (BTreeSet<Digest>, Vec<(Digest, String)>);

/// The good values and the bad ones.
fn values(db: &Connection, blobs: &Blobs, stop: &Stop, found: &mut Verified) -> Result<Values, Fail> {
    let (mut good, mut bad, mut large) = (BTreeSet::new(), Vec::new(), Vec::new());
    let mut s = db.prepare("SELECT hash, size, data FROM value").map_err(Fail::Sql)?;
    let mut rows = s.query([]).map_err(Fail::Sql)?;
    while let Some(row) = rows.next().map_err(Fail::Sql)? {
        let read = || -> rusqlite::Result<_> {
            let hash: Digest = row.get_ref(0)?.as_blob()?.try_into().map(Digest).unwrap_or_default();
            Ok((hash, row.get::<_, i64>(1)? as u64, row.get_ref(2)?))
        };
        let (hash, size, data) = read().map_err(Fail::Sql)?;
        found.values += 1;
        found.bytes += size;
        match data.as_blob() {
            Ok(data) if Digest::of(data) == hash => {
                good.insert(hash);
            }
            Ok(_) => bad.push((hash, "its bytes in the index are not what its hash says".to_owned())),
            Err(_) => large.push(hash),
        }
    }
    let checked: Vec<(Digest, Result<(), BlobError>)> = large
        .into_par_iter()
        .map(|hash| {
            stop.check().map_err(|_| Fail::Stopped)?;
            Ok((hash, blobs.get(&hash, false).map(drop)))
        })
        .collect::<Result<_, Fail>>()?;
    for (hash, result) in checked {
        match result {
            Ok(()) => {
                good.insert(hash);
            }
            Err(BlobError::Bad(what)) => bad.push((hash, what)),
            Err(BlobError::Io(e)) => return Err(Fail::Io(e)),
        }
    }
    Ok((good, bad))
}
