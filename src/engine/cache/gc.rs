//! The sweep: removes results that were not used for long, or the oldest until the cache is small enough. It keeps
//! whatever a bake record leads to and whatever a living bake has stored or used, and decides in one write transaction.

use super::{index, lock, nanoseconds};
use crate::engine::{
    cache::blob::Blobs,
    error::EngineError,
    hash::Digest,
    record::{BakeRecord, MapRecord, RunRecord},
    value::PortOut,
};
use rusqlite::{Connection, params};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs, io,
    path::Path,
    time::{Duration, SystemTime},
};

/// What a sweep may keep.
#[derive(Clone, Debug, Default)]
pub struct Limits {
    /// Remove the results not used for longest until the values take at most so many bytes.
    pub max_bytes: Option<u64>,
    /// Remove results not used for so long.
    pub max_age: Option<Duration>,
}

/// What a sweep removed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Collected {
    /// Results of runs and of whole maps.
    pub runs: u64,
    pub values: u64,
    pub bytes: u64,
    /// Bytes of the values that remain.
    pub left_bytes: u64,
}

/// A record that may go.
struct Candidate {
    used: i64,
    map: bool,
    key: Digest,
    variant: Digest,
    fixed: Digest,
    values: Vec<Digest>,
}

/// What the index holds, as far as a sweep cares.
#[derive(Default)]
struct Sweep {
    sizes: BTreeMap<Digest, u64>,
    /// How many kept records lead to a value.
    references: BTreeMap<Digest, u64>,
    fixed: BTreeMap<Digest, u64>,
    candidates: Vec<Candidate>,
    kept_runs: BTreeSet<Digest>,
    kept_maps: BTreeSet<Digest>,
}

pub(super) fn values_of(outputs: &[PortOut]) -> impl Iterator<Item = Digest> {
    outputs.iter().flat_map(|out| {
        let (one, many) = match out {
            PortOut::One(v) => (Some(v.hash), &[][..]),
            PortOut::Many(rows) => (None, &rows[..]),
        };
        one.into_iter().chain(many.iter().map(|(_, v)| v.hash))
    })
}

fn digest(row: &rusqlite::Row, column: usize) -> rusqlite::Result<Digest> {
    Ok(row.get_ref(column)?.as_blob()?.try_into().map(Digest).unwrap_or_default())
}

/// Removes what `limits` do not let the cache keep, and whatever nothing leads to.
pub fn gc(cache: &Path, limits: &Limits) -> Result<Collected, EngineError> {
    let Some(db) = index::open_existing(cache)? else { return Ok(Collected::default()) };
    let fail = |e: io::Error| EngineError::cache(cache, e);
    let sql = |e: rusqlite::Error| index::error(cache, &e);
    db.execute_batch("BEGIN IMMEDIATE").map_err(sql)?;
    let claim = lock::oldest_claim(cache).map_err(fail)?;
    // The marks of living bakes are read inside the transaction: a bake that begins later has stored nothing yet, and
    // what it looks up from now on it may lose, which its scheduler mends.
    let spared = claim.map_or(i64::MAX, |t| (nanoseconds(t) / 1_000_000_000) as i64);
    let result = (|| {
        let mut sweep = read(&db, spared).map_err(sql)?;
        let removed = choose(&mut sweep, limits);
        delete(&db, &sweep, &removed).map_err(sql)?;
        let mut out = Collected { runs: removed.len() as u64, ..Collected::default() };
        let kept = |hash: &Digest| sweep.references.get(hash).is_some_and(|n| *n > 0);
        for (hash, size) in &sweep.sizes {
            if kept(hash) {
                out.left_bytes += size;
            } else {
                out.values += 1;
                out.bytes += size;
            }
        }
        files(cache, claim, kept).map_err(fail)?;
        Ok(out)
    })();
    let end = if result.is_ok() { "COMMIT" } else { "ROLLBACK" };
    db.execute_batch(end).map_err(sql)?;
    if result.is_ok() && claim.is_none() {
        let pages = |name: &str| db.query_row(name, [], |r| r.get::<_, i64>(0)).map_err(sql);
        if pages("PRAGMA freelist_count")? * 2 > pages("PRAGMA page_count")? {
            db.execute_batch("VACUUM").map_err(sql)?;
        }
    }
    result
}

fn read(db: &Connection, spared: i64) -> rusqlite::Result<Sweep> {
    let mut sweep = Sweep::default();
    each(db, "SELECT hash, size FROM value", |row| {
        sweep.sizes.insert(digest(row, 0)?, row.get::<_, i64>(1)? as u64);
        Ok(())
    })?;
    each(db, "SELECT record FROM bake", |row| {
        let record = BakeRecord::from_bytes(row.get_ref(0)?.as_blob()?).unwrap_or_default();
        for node in record.nodes {
            (if node.mapped { &mut sweep.kept_maps } else { &mut sweep.kept_runs }).insert(node.key);
        }
        Ok(())
    })?;
    each(db, "SELECT key, record, used FROM map", |row| {
        let (key, used) = (digest(row, 0)?, row.get(2)?);
        // A damaged record counts as one that leads nowhere and was never used.
        let (used, record) = MapRecord::from_bytes(row.get_ref(1)?.as_blob()?).map_or((0, None), |r| (used, Some(r)));
        let values: Vec<Digest> =
            record.iter().flat_map(|r| &r.rows).flat_map(|row| values_of(&row.outputs).collect::<Vec<_>>()).collect();
        let fixed = record.as_ref().map_or(Digest::default(), |r| r.fixed);
        if sweep.kept_maps.contains(&key) || used >= spared {
            sweep.kept_maps.insert(key);
            sweep.kept_runs.extend(record.iter().flat_map(|r| &r.rows).map(|row| row.key));
        }
        sweep.add(Candidate { used, map: true, key, variant: Digest::default(), fixed, values });
        Ok(())
    })?;
    each(db, "SELECT key, variant, record, used FROM run", |row| {
        let (key, variant, used) = (digest(row, 0)?, digest(row, 1)?, row.get(3)?);
        let (used, record) = RunRecord::from_bytes(row.get_ref(2)?.as_blob()?).map_or((0, None), |r| (used, Some(r)));
        let values = record.iter().flat_map(|r| values_of(&r.outputs).collect::<Vec<_>>()).collect();
        let fixed = record.as_ref().map_or(Digest::default(), |r| r.fixed);
        if used >= spared {
            sweep.kept_runs.insert(key);
        }
        sweep.add(Candidate { used, map: false, key, variant, fixed, values });
        Ok(())
    })?;
    let Sweep { kept_runs, kept_maps, candidates, .. } = &mut sweep;
    candidates.retain(|c| !(if c.map { &*kept_maps } else { &*kept_runs }).contains(&c.key));
    Ok(sweep)
}

impl Sweep {
    fn add(&mut self, c: Candidate) {
        for v in &c.values {
            *self.references.entry(*v).or_default() += 1;
        }
        *self.fixed.entry(c.fixed).or_default() += 1;
        self.candidates.push(c);
    }
}

fn each(
    db: &Connection,
    query: &str,
    mut f: impl FnMut(&rusqlite::Row) -> rusqlite::Result<()>,
) -> rusqlite::Result<()> {
    let mut statement = db.prepare(query)?;
    let mut rows = statement.query([])?;
    while let Some(row) = rows.next()? {
        f(row)?;
    }
    Ok(())
}

/// Takes candidates, oldest first, until the limits hold.
fn choose(sweep: &mut Sweep, limits: &Limits) -> Vec<Candidate> {
    let now = (nanoseconds(SystemTime::now()) / 1_000_000_000) as i64;
    let cutoff = limits.max_age.map_or(i64::MIN, |age| now.saturating_sub_unsigned(age.as_secs()));
    let size = |hash: &Digest| sweep.sizes.get(hash).copied().unwrap_or(0);
    let mut bytes: u64 = sweep.references.keys().map(size).sum();
    let mut candidates = std::mem::take(&mut sweep.candidates);
    // Among equals the order is that of keys: arbitrary, but the same everywhere. Maps go before the runs they list.
    candidates.sort_by_key(|c| (c.used, !c.map, c.key, c.variant));
    let mut removed = Vec::new();
    for c in candidates {
        if c.used >= cutoff && limits.max_bytes.is_none_or(|max| bytes <= max) {
            break;
        }
        for v in &c.values {
            let n = sweep.references.entry(*v).or_default();
            *n -= 1;
            if *n == 0 {
                bytes -= sweep.sizes.get(v).copied().unwrap_or(0);
            }
        }
        if let Some(n) = sweep.fixed.get_mut(&c.fixed) {
            *n -= 1;
        }
        removed.push(c);
    }
    removed
}

fn delete(db: &Connection, sweep: &Sweep, removed: &[Candidate]) -> rusqlite::Result<()> {
    let now = (nanoseconds(SystemTime::now()) / 1_000_000_000) as i64;
    let mut run = db.prepare("DELETE FROM run WHERE key = ?1 AND variant = ?2")?;
    let mut map = db.prepare("DELETE FROM map WHERE key = ?1")?;
    for c in removed {
        if c.map {
            map.execute([&c.key.0[..]])?;
        } else {
            run.execute([&c.key.0[..], &c.variant.0[..]])?;
        }
    }
    let mut value = db.prepare("DELETE FROM value WHERE hash = ?1")?;
    for hash in sweep.sizes.keys() {
        if sweep.references.get(hash).is_none_or(|n| *n == 0) {
            value.execute([&hash.0[..]])?;
        }
    }
    let mut fixed = db.prepare("DELETE FROM fixed WHERE hash = ?1")?;
    for (hash, n) in &sweep.fixed {
        if *n == 0 {
            fixed.execute([&hash.0[..]])?;
        }
    }
    // A record's roots count as used now: their age begins when the last record that leads to them is dropped.
    let mut used = db.prepare("UPDATE run SET used = ?2 WHERE key = ?1 AND used < ?2 - 3600")?;
    for key in &sweep.kept_runs {
        used.execute(params![&key.0[..], now])?;
    }
    let mut used = db.prepare("UPDATE map SET used = ?2 WHERE key = ?1 AND used < ?2 - 3600")?;
    for key in &sweep.kept_maps {
        used.execute(params![&key.0[..], now])?;
    }
    db.execute("DELETE FROM file WHERE at < ?1", [now - 90 * 24 * 3600])?;
    Ok(())
}

/// Removes the files of values that nothing leads to, and what killed processes left.
fn files(cache: &Path, claim: Option<SystemTime>, kept: impl Fn(&Digest) -> bool) -> io::Result<()> {
    let gone = |r: io::Result<()>| match r {
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(()),
        other => other,
    };
    // What a living bake has written or touched is its own.
    let spared = |meta: &fs::Metadata| -> io::Result<bool> {
        Ok(claim.is_some() && claim.is_some_and(|c| meta.modified().is_ok_and(|m| m >= c)))
    };
    Blobs::new(cache).each(
        |hash, meta, path| {
            if kept(&hash) || spared(meta)? { Ok(()) } else { gone(fs::remove_file(path)) }
        },
    )?;
    for folder in ["tmp", "bad"] {
        let Ok(entries) = fs::read_dir(cache.join(folder)) else { continue };
        for entry in entries {
            let entry = entry?;
            let Ok(meta) = entry.metadata() else { continue };
            if meta.is_file() && !spared(&meta)? {
                gone(fs::remove_file(entry.path()))?;
            }
        }
    }
    Ok(())
}
