//! The index: SQLite, shared between processes. It is never synced to the disk, because losing it costs recomputation
//! and every record in it carries a checksum. Where the cache cannot be written, the index is only read.

use super::{
    folder,
    layout::{FILE, MADE, NAMES_ASIDE, path, uri},
    lock::Lock,
};
use crate::engine::error::EngineError;
use rusqlite::{Connection, ErrorCode, MAIN_DB, OpenFlags, config::DbConfig, ffi};
use std::{
    fs, io,
    path::{Path, PathBuf},
    time::Duration,
};

/// Tables whose rows may be large have a rowid: without one a search compares whole rows, and a list of 100,000 outputs
/// on its path is read each time. Compared with what the file says, byte by byte.
pub(super) const TABLES: [&str; 6] = [
    "CREATE TABLE run(key BLOB, variant BLOB, record BLOB, used INTEGER, PRIMARY KEY(key, variant))",
    "CREATE TABLE map(key BLOB PRIMARY KEY, record BLOB, used INTEGER)",
    "CREATE TABLE value(hash BLOB PRIMARY KEY, size INTEGER, data BLOB)",
    "CREATE TABLE fixed(hash BLOB PRIMARY KEY, fields BLOB) WITHOUT ROWID",
    "CREATE TABLE file(path TEXT PRIMARY KEY, record BLOB, at INTEGER) WITHOUT ROWID",
    "CREATE TABLE bake(id INTEGER PRIMARY KEY, pipeline TEXT, folder TEXT, record BLOB)",
];
/// An open index.
pub struct Index {
    db: Connection,
    path: Option<(PathBuf, Identity)>,
    /// Why it can only be read.
    pub read_only: Option<String>,
}

impl std::ops::Deref for Index {
    type Target = Connection;
    fn deref(&self) -> &Connection {
        &self.db
    }
}

impl std::ops::DerefMut for Index {
    fn deref_mut(&mut self) -> &mut Connection {
        &mut self.db
    }
}

impl Drop for Index {
    fn drop(&mut self) {
        // SQLite removes the log by its name when the last connection closes. Where the file was set aside meanwhile,
        // the log of that name is another index's.
        if let Some((path, identity)) = &self.path
            && Identity::of(path) != *identity
        {
            let _ = self.db.set_db_config(DbConfig::SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, true);
        }
    }
}

/// Which file lies at a path.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Identity(Option<(u64, u64)>);

impl Identity {
    #[cfg(unix)]
    fn of(path: &Path) -> Self {
        use std::os::unix::fs::MetadataExt as _;
        Self(fs::metadata(path).ok().map(|meta| (meta.dev(), meta.ino())))
    }

    #[cfg(not(unix))]
    fn of(path: &Path) -> Self {
        let created = fs::metadata(path).and_then(|meta| meta.created()).ok();
        Self(created.map(|at| (super::nanoseconds(at) as u64, 0)))
    }
}

/// Whether an error says that something cannot be written, or opened, for a reason outside the file.
pub fn cannot_write(e: &rusqlite::Error) -> bool {
    let Some(error) = e.sqlite_error() else { return false };
    match error.code {
        ErrorCode::DiskFull | ErrorCode::ReadOnly | ErrorCode::CannotOpen | ErrorCode::PermissionDenied => true,
        ErrorCode::SystemIoFailure => !cannot_read(error),
        _ => false,
    }
}

fn cannot_read(error: &ffi::Error) -> bool {
    matches!(error.extended_code, ffi::SQLITE_IOERR_READ | ffi::SQLITE_IOERR_SHORT_READ | ffi::SQLITE_IOERR_CORRUPTFS)
}

/// An SQLite error as the engine's. The statements are always the same and right for a sound index, so that whatever
/// has no cause outside the file is damage, which the engine can help itself against.
pub fn error(cache: &Path, e: &rusqlite::Error) -> EngineError {
    let damaged = || EngineError::Damaged { path: cache.to_owned(), what: e.to_string() };
    let Some(error) = e.sqlite_error() else { return damaged() };
    match error.code {
        ErrorCode::DiskFull => EngineError::cache(cache, "the disk is full"),
        ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked | ErrorCode::FileLockingProtocolFailed => {
            EngineError::cache(
                cache,
                format!("another process kept the index locked for a minute ({e}); try again later"),
            )
        }
        ErrorCode::OutOfMemory
        | ErrorCode::OperationInterrupted
        | ErrorCode::NoLargeFileSupport
        | ErrorCode::AuthorizationForStatementDenied => EngineError::cache(cache, e),
        _ if cannot_write(e) => {
            EngineError::cache(cache, format!("cannot be written ({e}); name another folder with --cache"))
        }
        _ => damaged(),
    }
}

/// Opens the index of a cache, making folder and tables where they are missing. Where nothing can be written, it is
/// opened to be read.
pub fn open(cache: &Path) -> Result<Index, EngineError> {
    let why = match folder::prepare(cache)? {
        Some(why) => why,
        None => match to_write(cache) {
            Ok(index) => return Ok(index),
            Err(Fail::Engine(e)) => return Err(e),
            Err(Fail::Sql(e)) if cannot_write(&e) => e.to_string(),
            Err(Fail::Sql(e)) => return Err(error(cache, &e)),
            Err(Fail::Io(e)) => e.to_string(),
        },
    };
    let path = path(cache);
    if !path.is_file() {
        return Err(EngineError::cache(cache, format!("cannot be written ({why}); name another folder with --cache")));
    }
    to_read(&path, &why).map_err(|e| error(cache, &e))
}

enum Fail {
    Sql(rusqlite::Error),
    Io(io::Error),
    Engine(EngineError),
}

impl From<rusqlite::Error> for Fail {
    fn from(e: rusqlite::Error) -> Self {
        Self::Sql(e)
    }
}

fn to_write(cache: &Path) -> Result<Index, Fail> {
    let path = path(cache);
    let damaged = |what: &str| Fail::Engine(EngineError::Damaged { path: cache.to_owned(), what: what.to_owned() });
    if fs::symlink_metadata(&path).is_ok_and(|meta| !meta.is_file()) {
        return Err(damaged("it is no plain file"));
    }
    let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_CREATE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let db = Connection::open_with_flags(&path, flags)?;
    let index = Index { db, path: Some((path.clone(), Identity::of(&path))), read_only: None };
    set_up(&index)?;
    index.db.pragma_update(None, "synchronous", "OFF")?;
    let version: i64 = index.db.query_row("PRAGMA user_version", [], |r| r.get(0))?;
    if index.db.is_readonly(MAIN_DB)? {
        // A number in the header that this SQLite does not know makes a file read-only, too. Nothing else of this
        // process has the file open: to close it drops all locks on it.
        let header = fs::read(&path).unwrap_or_default();
        if header.get(18..20).is_some_and(|v| v.iter().any(|v| *v > 2)) {
            return Err(damaged("its header is of an unknown version"));
        }
        return Err(Fail::Io(io::Error::new(io::ErrorKind::PermissionDenied, "the index file is read-only")));
    }
    let journal: String = index.db.query_row("PRAGMA journal_mode", [], |r| r.get(0))?;
    if version != MADE || journal != "wal" {
        // Two processes that change the journal's mode at once fail: SQLite does not wait there.
        let _lock = lock(cache).map_err(Fail::Io)?;
        index.db.pragma_update(None, "journal_mode", "WAL")?;
        let tables = TABLES.map(|t| t.replacen("CREATE TABLE", "CREATE TABLE IF NOT EXISTS", 1)).join("; ");
        let make = format!("BEGIN IMMEDIATE; {tables}; PRAGMA user_version = {MADE}; COMMIT;");
        index.db.execute_batch(&make)?;
    }
    if !has_tables(&index.db)? {
        return Err(damaged("its tables are not those of an index"));
    }
    Ok(index)
}

/// Settings of every connection.
fn set_up(db: &Connection) -> rusqlite::Result<()> {
    db.busy_timeout(Duration::from_secs(60))?;
    db.set_db_config(DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true)?;
    db.set_prepared_statement_cache_capacity(64);
    db.pragma_update(None, "cell_size_check", true)?;
    db.pragma_update(None, "temp_store", "MEMORY")?;
    // What a process takes for an index of any size.
    db.pragma_update(None, "cache_size", -16_000)?;
    db.pragma_update(None, "mmap_size", 32 << 20)
}

/// Whether the file has our tables and no others.
fn has_tables(db: &Connection) -> rusqlite::Result<bool> {
    let mut statement = db.prepare("SELECT sql FROM sqlite_schema WHERE sql IS NOT NULL")?;
    let mut rows = statement.query([])?;
    let mut found = 0;
    while let Some(row) = rows.next()? {
        let known = row
            .get_ref(0)?
            .as_bytes_or_null()
            .ok()
            .flatten()
            .is_some_and(|sql| TABLES.iter().any(|t| t.as_bytes() == sql));
        if !known {
            return Ok(false);
        }
        found += 1;
    }
    Ok(found == TABLES.len())
}

/// Opens an index without writing anything: beside living processes if the system allows it, else as a file that
/// nobody changes. Should somebody change it, records fail their checksums.
fn to_read(path: &Path, why: &str) -> rusqlite::Result<Index> {
    let open = |query: &str| -> rusqlite::Result<Index> {
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let db = Connection::open_with_flags(format!("{}?{query}", uri(path)), flags)?;
        set_up(&db)?;
        if !has_tables(&db)? {
            return Err(rusqlite::Error::QueryReturnedNoRows);
        }
        Ok(Index { db, path: None, read_only: Some(why.to_owned()) })
    };
    open("mode=ro").or_else(|_| open("immutable=1"))
}

/// The lock under which an index is made or set aside.
pub(super) fn lock(cache: &Path) -> io::Result<Lock> {
    loop {
        if let Some(lock) = Lock::take(&cache.join("index.lock"))? {
            return Ok(lock);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Opens an index that exists.
pub fn open_existing(cache: &Path) -> Result<Option<Index>, EngineError> {
    folder::check(cache)?;
    if fs::symlink_metadata(path(cache)).is_ok() { open(cache).map(Some) } else { Ok(None) }
}

/// An index in memory, for a cache that does not exist and is not to be made.
pub fn empty(cache: &Path) -> Result<Index, EngineError> {
    let sql = |e: rusqlite::Error| error(cache, &e);
    let db = Connection::open_in_memory().map_err(sql)?;
    db.execute_batch(&TABLES.join("; ")).map_err(sql)?;
    Ok(Index { db, path: None, read_only: None })
}

/// What is wrong with the structure of an index, by SQLite's full check.
pub fn fault(db: &Connection) -> rusqlite::Result<Option<String>> {
    if !has_tables(db)? {
        return Ok(Some("its tables are not those of an index".to_owned()));
    }
    let answer: String = db.query_row("PRAGMA integrity_check(1)", [], |r| r.get(0))?;
    Ok((answer != "ok").then_some(answer))
}

/// Moves a damaged index out of the way. Several processes may notice the damage: only what is still damaged goes,
/// unless it is `certain` that this process has met damage that the check does not see.
pub fn set_aside(cache: &Path, certain: bool) -> Result<(), EngineError> {
    let fail = |e: io::Error| {
        EngineError::cache(
            cache,
            format!("the index is damaged and cannot be set aside: {e}; name another folder with --cache"),
        )
    };
    folder::check(cache)?;
    let lock = lock(cache).map_err(fail)?;
    let sound = || -> Result<bool, Fail> { Ok(fault(&to_write_unmade(cache)?)?.is_none()) };
    if certain || !matches!(sound(), Ok(true)) {
        move_aside(cache).map_err(fail)?;
    }
    drop(lock);
    Ok(())
}

/// Moves the index out of the way. The lock of [`lock`] is held.
pub(super) fn move_aside(cache: &Path) -> io::Result<()> {
    for (suffix, aside) in ["", "-wal", "-shm"].into_iter().zip(NAMES_ASIDE) {
        let to = cache.join(aside);
        // A folder in the index's place may meet one that was moved here before.
        let _ = fs::remove_dir(&to);
        match fs::rename(cache.join(format!("{FILE}{suffix}")), to) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
            _ => {}
        }
    }
    Ok(())
}

/// Opens the index to be checked, without taking the lock that [`to_write`] may take.
fn to_write_unmade(cache: &Path) -> rusqlite::Result<Connection> {
    let db = Connection::open(path(cache))?;
    db.busy_timeout(Duration::from_secs(60))?;
    Ok(db)
}
