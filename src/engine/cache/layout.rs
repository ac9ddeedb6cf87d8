//! What the files of an index are called, and how an index is told from what is not ours.

use rusqlite::{Connection, OpenFlags};
use std::path::{Path, PathBuf};

/// The number is that of the tables' and records' layout: another layout is another file.
const LAYOUT: u32 = 4;
pub const FILE: &str = "index-4.sqlite";
/// An index that was set aside, its log, and what belongs to that.
pub const NAMES_ASIDE: [&str; 3] =
    ["index-4.sqlite.damaged", "index-4.sqlite.damaged-wal", "index-4.sqlite.damaged-shm"];
/// Stands in the file once its tables are made.
pub const MADE: i64 = 1;

const NAMES: &str = "bake,file,fixed,map,run,value";

pub fn path(cache: &Path) -> PathBuf {
    cache.join(FILE)
}

/// The layout number of a file of an index, this one's, an older one's, or one that was set aside.
fn layout_of(file_name: &str) -> Option<(u32, &str)> {
    let (number, rest) = file_name.strip_prefix("index-")?.split_once(".sqlite")?;
    let known = ["", "-wal", "-shm", "-journal", ".damaged", ".damaged-wal", ".damaged-shm"].contains(&rest);
    (known && number.len() < 4).then_some(())?;
    Some((number.parse().ok()?, rest))
}

/// Whether a cache's folder may hold a file of this name, the index and what belongs to it.
pub fn is_file_name(name: &str) -> bool {
    layout_of(name).is_some() || name == "index.lock"
}

/// Whether a file of this name is of no use any more: an index that was set aside, or one of an older layout.
pub fn is_leftover(name: &str) -> bool {
    layout_of(name).is_some_and(|(layout, rest)| layout < LAYOUT || rest.starts_with(".damaged"))
}

/// A path as SQLite takes it with options.
pub fn uri(path: &Path) -> String {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut out = "file://".to_owned();
    let bytes = path.as_os_str().as_encoded_bytes();
    if !bytes.starts_with(b"/") {
        out.push('/');
    }
    for b in bytes {
        match b {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'.' | b'_' | b'-' | b':' => out.push(char::from(*b)),
            b'\\' if cfg!(windows) => out.push('/'),
            _ => out += &format!("%{b:02X}"),
        }
    }
    out
}

/// Whether a folder without a marker holds an index of ours, of this layout or the one before.
pub fn is_known(cache: &Path) -> bool {
    let known = |layout: u32| -> rusqlite::Result<bool> {
        let path = cache.join(format!("index-{layout}.sqlite"));
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI;
        let db = Connection::open_with_flags(format!("{}?immutable=1", uri(&path)), flags)?;
        let version: i64 = db.query_row("PRAGMA user_version", [], |r| r.get(0))?;
        let query = "SELECT group_concat(name) FROM (SELECT name FROM sqlite_schema WHERE type = 'table' \
                     AND name NOT LIKE 'sqlite_%' ORDER BY name)";
        let names: String = db.query_row(query, [], |r| r.get(0))?;
        Ok(version == MADE && names == NAMES)
    };
    [LAYOUT, LAYOUT - 1].into_iter().any(|layout| matches!(known(layout), Ok(true)))
}
