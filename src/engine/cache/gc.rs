//! The sweep: removes results that were not used for long, or the oldest until the cache is small enough. It keeps
//! whatever the last bake records lead to and whatever a living bake has stored or used, and decides in one write
//! transaction. Files go after that: a sweep that is killed in between leaves unreferenced files, and the next
//! one removes them. It deletes plain files with names of ours only, and follows no link.

use super::{
    PROTECTED, blob_of, digest,
    index::{self, Index},
    layout, lock, nanoseconds, number,
};
use crate::engine::{
    cache::blob::Blobs,
    error::EngineError,
    hash::Digest,
    record::{BakeRecord, MapRecord, RunRecord},
    temporary,
    value::PortOut,
};
use rusqlite::params;
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
    /// Keep the records of so many bakes, over all pipelines, and what they lead to; without a number all records stay,
    /// and what the last [`PROTECTED`] of them lead to.
    pub keep_bakes: Option<u64>,
}

/// What a sweep removed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Collected {
    /// Results of runs and of whole maps.
    pub runs: u64,
    pub values: u64,
    /// Bytes of the values and other files removed.
    pub bytes: u64,
    /// Bytes of the values that remain.
    pub left_bytes: u64,
    /// Of these, what bake records keep whatever the limits say; and how many records do.
    pub kept_bytes: u64,
    pub kept_bakes: u64,
    /// Whether a bake is at work: what it uses is kept as well.
    pub living: bool,
    /// The index was damaged and set aside: all results are gone.
    pub damaged: Option<String>,
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
    kept_bakes: u64,
    /// Values that kept records lead to.
    kept_values: BTreeSet<Digest>,
}

pub fn values_of(outputs: &[PortOut]) -> impl Iterator<Item = Digest> {
    outputs.iter().flat_map(|out| {
        let (one, many) = match out {
            PortOut::One(v) => (Some(v.hash), &[][..]),
            PortOut::Many(rows) => (None, &rows[..]),
        };
        one.into_iter().chain(many.iter().map(|(_, v)| v.hash))
    })
}

/// Removes what `limits` do not let the cache keep, and unreferenced values. `None` where there is no cache.
pub fn gc(cache: &Path, limits: &Limits) -> Result<Option<Collected>, EngineError> {
    let damaged = match sweep(cache, limits) {
        Err(EngineError::Damaged { what, .. }) => what,
        other => return other,
    };
    index::set_aside(cache, true)?;
    index::open(cache)?;
    let found = sweep(cache, limits)?;
    Ok(found.map(|collected| Collected { damaged: Some(damaged), ..collected }))
}

fn sweep(cache: &Path, limits: &Limits) -> Result<Option<Collected>, EngineError> {
    let Some(db) = index::open_existing(cache)? else { return Ok(None) };
    if let Some(why) = &db.read_only {
        return Err(EngineError::cache(cache, format!("cannot be written ({why})")));
    }
    let fail = |e: io::Error| EngineError::cache(cache, e);
    let sql = |e: rusqlite::Error| index::error(cache, &e);
    let began = SystemTime::now();
    db.execute_batch("BEGIN IMMEDIATE").map_err(sql)?;
    let decide = || -> Result<_, EngineError> {
        // The marks of living bakes are read inside the transaction: a bake that begins later has stored nothing yet,
        // and what it looks up from now on it may lose, which its scheduler mends.
        let claim = lock::oldest_claim(cache).map_err(fail)?;
        let spared = claim.map_or(i64::MAX, |t| (nanoseconds(t) / 1_000_000_000) as i64);
        if let Some(keep) = limits.keep_bakes {
            let drop = "DELETE FROM bake WHERE id NOT IN (SELECT id FROM bake ORDER BY id DESC LIMIT ?1)";
            db.execute(drop, [keep.min(i64::MAX as u64) as i64]).map_err(sql)?;
        }
        let mut sweep = read(&db, spared, limits.keep_bakes.unwrap_or(PROTECTED)).map_err(sql)?;
        let removed = choose(&mut sweep, limits);
        let inline = delete(&db, &sweep, &removed).map_err(sql)?;
        Ok((claim, sweep, removed, inline))
    };
    let (claim, sweep, removed, inline) = match decide() {
        Ok(decided) => {
            db.execute_batch("COMMIT").map_err(sql)?;
            decided
        }
        Err(e) => {
            let _ = db.execute_batch("ROLLBACK");
            return Err(e);
        }
    };
    let kept = |hash: &Digest| sweep.references.get(hash).is_some_and(|n| *n > 0);
    let size = |hash: &Digest| sweep.sizes.get(hash).copied().unwrap_or(0);
    let mut out = Collected {
        runs: removed.len() as u64,
        values: sweep.sizes.keys().filter(|hash| !kept(hash)).count() as u64,
        bytes: inline,
        left_bytes: sweep.sizes.keys().filter(|hash| kept(hash)).map(size).sum(),
        kept_bytes: sweep.kept_values.iter().map(size).sum(),
        kept_bakes: sweep.kept_bakes,
        living: claim.is_some(),
        damaged: None,
    };
    // What a living bake has written or touched is its own, and so is what anyone has touched since this sweep began.
    let spared_from = claim.map_or(began, |claim| claim.min(began));
    out.bytes += files(cache, spared_from, kept).map_err(fail)?;
    if claim.is_none() {
        let pages = |name: &str| db.query_row(name, [], |r| r.get::<_, i64>(0)).map_err(sql);
        if pages("PRAGMA freelist_count")? * 2 > pages("PRAGMA page_count")? {
            db.execute_batch("VACUUM").map_err(sql)?;
        }
    }
    Ok(Some(out))
}

/// Reads the index. What the newest `protected` bake records lead to is no candidate.
fn read(db: &Index, spared: i64, protected: u64) -> rusqlite::Result<Sweep> {
    let mut sweep = Sweep::default();
    each(db, "SELECT hash, size FROM value", |row| {
        sweep.sizes.insert(digest(row.get_ref(0)?), number(row.get_ref(1)?).max(0) as u64);
        Ok(())
    })?;
    each(db, "SELECT id, pipeline, folder, record FROM bake ORDER BY id DESC", |row| {
        let id = number(row.get_ref(0)?);
        let (pipeline, folder) = (row.get_ref(1)?.as_str().unwrap_or(""), row.get_ref(2)?.as_str().unwrap_or(""));
        let record = BakeRecord::from_bytes(blob_of(row.get_ref(3)?), id, pipeline, folder);
        if let Some(record) = record.filter(|_| sweep.kept_bakes < protected) {
            sweep.kept_bakes += 1;
            for node in record.nodes {
                (if node.mapped { &mut sweep.kept_maps } else { &mut sweep.kept_runs }).insert(node.key);
            }
        }
        Ok(())
    })?;
    each(db, "SELECT key, record, used FROM map", |row| {
        let (key, used) = (digest(row.get_ref(0)?), number(row.get_ref(2)?));
        // A damaged record counts as one that leads nowhere and was never used.
        let record = MapRecord::from_bytes(blob_of(row.get_ref(1)?), &key);
        let used = if record.is_some() { used } else { 0 };
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
        let (key, variant, used) = (digest(row.get_ref(0)?), digest(row.get_ref(1)?), number(row.get_ref(3)?));
        let record = RunRecord::from_bytes(blob_of(row.get_ref(2)?), &key, &variant);
        let used = if record.is_some() { used } else { 0 };
        let values = record.iter().flat_map(|r| values_of(&r.outputs).collect::<Vec<_>>()).collect();
        let fixed = record.as_ref().map_or(Digest::default(), |r| r.fixed);
        if used >= spared {
            sweep.kept_runs.insert(key);
        }
        sweep.add(Candidate { used, map: false, key, variant, fixed, values });
        Ok(())
    })?;
    let Sweep { kept_runs, kept_maps, kept_values, candidates, .. } = &mut sweep;
    candidates.retain(|c| {
        let kept = (if c.map { &*kept_maps } else { &*kept_runs }).contains(&c.key);
        if kept {
            kept_values.extend(&c.values);
        }
        !kept
    });
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

fn each(db: &Index, query: &str, mut f: impl FnMut(&rusqlite::Row) -> rusqlite::Result<()>) -> rusqlite::Result<()> {
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

/// Removes the records and values of `removed` from the index. Gives the bytes of the values that lay in it.
fn delete(db: &Index, sweep: &Sweep, removed: &[Candidate]) -> rusqlite::Result<u64> {
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
    let mut inline = 0;
    let mut length = db.prepare("SELECT ifnull(sum(length(data)), 0) FROM value WHERE hash = ?1")?;
    let mut value = db.prepare("DELETE FROM value WHERE hash = ?1")?;
    for hash in sweep.sizes.keys() {
        if sweep.references.get(hash).is_none_or(|n| *n == 0) {
            inline += length.query_row([&hash.0[..]], |r| Ok(number(r.get_ref(0)?).max(0) as u64))?;
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
    Ok(inline)
}

/// Removes the files of unreferenced values, and what killed processes and damage left, unless it was
/// changed since `spared_from`. Gives their bytes.
fn files(cache: &Path, spared_from: SystemTime, kept: impl Fn(&Digest) -> bool) -> io::Result<u64> {
    let mut bytes = 0;
    let mut remove = |path: &Path, meta: &fs::Metadata| -> io::Result<()> {
        if meta.modified().is_ok_and(|m| m >= spared_from) {
            return Ok(());
        }
        match fs::remove_file(path) {
            Ok(()) => bytes += meta.len(),
            Err(e) if e.kind() == io::ErrorKind::NotFound => {}
            Err(e) => return Err(e),
        }
        Ok(())
    };
    Blobs::new(cache).each(|hash, meta, path| if kept(&hash) { Ok(()) } else { remove(path, meta) })?;
    let folders: [(&str, fn(&str) -> bool); 3] = [
        ("tmp", temporary::is_name),
        ("bad", Blobs::is_aside),
        (".", |name| layout::is_leftover(name) || temporary::is_name(name)),
    ];
    for (folder, is_ours) in folders {
        let folder = cache.join(folder);
        // A link in the place of one of our folders leads out of the cache.
        if !fs::symlink_metadata(&folder).is_ok_and(|meta| meta.is_dir()) {
            continue;
        }
        for entry in fs::read_dir(folder)? {
            let entry = entry?;
            let ours = entry.file_name().to_str().is_some_and(is_ours);
            match entry.metadata() {
                Ok(meta) if ours && meta.is_file() => remove(&entry.path(), &meta)?,
                _ => {}
            }
        }
    }
    Ok(bytes)
}
