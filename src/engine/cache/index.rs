//! The index: SQLite, shared between processes. It is never synced to the disk, because losing it costs recomputation
//! and every record in it carries a checksum.

use super::lock::Lock;
use crate::engine::error::EngineError;
use rusqlite::{Connection, ErrorCode, OpenFlags, config::DbConfig};
use std::{
    fs, io,
    path::{Path, PathBuf},
    time::Duration,
};

/// Its number is that of the tables' layout: another layout is another file.
const FILE: &str = "index-2.sqlite";

/// Tables whose rows may be large have a rowid: without one a search compares whole rows, and a list of 100,000 outputs
/// on its path is read each time.
const TABLES: &str = "
CREATE TABLE IF NOT EXISTS run(key BLOB, variant BLOB, record BLOB, used INTEGER, PRIMARY KEY(key, variant));
CREATE TABLE IF NOT EXISTS map(key BLOB PRIMARY KEY, record BLOB, used INTEGER);
CREATE TABLE IF NOT EXISTS value(hash BLOB PRIMARY KEY, size INTEGER, data BLOB);
CREATE TABLE IF NOT EXISTS fixed(hash BLOB PRIMARY KEY, fields BLOB) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS file(path TEXT PRIMARY KEY, stamp BLOB, hash BLOB, at INTEGER) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS bake(id INTEGER PRIMARY KEY AUTOINCREMENT, pipeline TEXT, folder TEXT, record BLOB);
PRAGMA user_version = 1;
";

pub fn path(cache: &Path) -> PathBuf {
    cache.join(FILE)
}

/// An SQLite error as the engine's: damage is told apart, because the engine can help itself.
pub fn error(cache: &Path, e: &rusqlite::Error) -> EngineError {
    match e.sqlite_error_code() {
        Some(ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase) => {
            EngineError::Damaged { path: cache.to_owned(), what: e.to_string() }
        }
        Some(ErrorCode::DiskFull) => EngineError::cache(cache, "the disk is full"),
        Some(ErrorCode::ReadOnly | ErrorCode::CannotOpen | ErrorCode::PermissionDenied) => {
            EngineError::cache(cache, format!("cannot be written ({e}); name another folder with --cache"))
        }
        _ => EngineError::cache(cache, e),
    }
}

/// Opens the index, making the cache's folders and tables where they are missing.
pub fn open(cache: &Path) -> Result<Connection, EngineError> {
    let folder = |e: io::Error| {
        EngineError::cache(cache, format!("cannot be made or written ({e}); name another folder with --cache"))
    };
    if !cache.join("claims").is_dir() {
        for name in ["values", "tmp", "locks", "claims"] {
            fs::create_dir_all(cache.join(name)).map_err(folder)?;
        }
    }
    let sql = |e: rusqlite::Error| error(cache, &e);
    let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_CREATE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let db = Connection::open_with_flags(path(cache), flags).map_err(sql)?;
    db.busy_timeout(Duration::from_secs(60)).map_err(sql)?;
    db.set_db_config(DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true).map_err(sql)?;
    db.set_prepared_statement_cache_capacity(64);
    let version: i64 = db.query_row("PRAGMA user_version", [], |r| r.get(0)).map_err(sql)?;
    // Two processes that change the journal's mode at once fail: SQLite does not wait there.
    let making = if version == 1 { None } else { Some(lock(cache)?) };
    if making.is_some() {
        db.pragma_update(None, "journal_mode", "WAL").map_err(sql)?;
    }
    db.pragma_update(None, "synchronous", "OFF").map_err(sql)?;
    db.pragma_update(None, "cache_size", -32_000).map_err(sql)?;
    db.pragma_update(None, "mmap_size", 256 << 20).map_err(sql)?;
    if making.is_some() {
        let make = format!("BEGIN IMMEDIATE; {TABLES} COMMIT;");
        db.execute_batch(&make).map_err(sql)?;
    }
    Ok(db)
}

/// The lock under which an index is made or set aside.
fn lock(cache: &Path) -> Result<Lock, EngineError> {
    loop {
        if let Some(lock) = Lock::take(&cache.join("index.lock")).map_err(|e| EngineError::cache(cache, e))? {
            return Ok(lock);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Opens an index that exists, to read.
pub fn open_existing(cache: &Path) -> Result<Option<Connection>, EngineError> {
    if path(cache).is_file() { open(cache).map(Some) } else { Ok(None) }
}

/// An index in memory, for a cache that does not exist and is not to be made.
pub fn empty(cache: &Path) -> Result<Connection, EngineError> {
    let sql = |e: rusqlite::Error| error(cache, &e);
    let db = Connection::open_in_memory().map_err(sql)?;
    db.execute_batch(TABLES).map_err(sql)?;
    Ok(db)
}

/// Moves a damaged index out of the way. Several processes may notice the damage: only what is still damaged goes.
pub fn set_aside(cache: &Path) -> Result<(), EngineError> {
    let fail = |e: io::Error| EngineError::cache(cache, e);
    let lock = lock(cache)?;
    let sound = || -> Result<bool, rusqlite::Error> {
        let db = Connection::open(path(cache))?;
        db.busy_timeout(Duration::from_secs(60))?;
        let answer: String = db.query_row("PRAGMA quick_check(1)", [], |r| r.get(0))?;
        Ok(answer == "ok")
    };
    if !matches!(sound(), Ok(true)) {
        for suffix in ["", "-wal", "-shm"] {
            let from = cache.join(format!("{FILE}{suffix}"));
            match fs::rename(&from, cache.join(format!("{FILE}.damaged{suffix}"))) {
                Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(fail(e)),
                _ => {}
            }
        }
    }
    drop(lock);
    Ok(())
}
