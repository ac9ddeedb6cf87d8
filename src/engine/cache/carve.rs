//! Rows of an index that SQLite may refuse. SQLite stops at the first damaged page; here every page of the file and of its log is read by itself, and
//! every row that a page seems to hold is handed out. What is made of rubbish does no harm: records prove themselves by their checksums, values by their
//! hashes. The layout is that of <https://www.sqlite.org/fileformat2.html>, sections 1.5 to 2.1 and 4.

use crate::math::{Stop, Stopped};
use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, Read as _, Seek as _, SeekFrom},
    path::Path,
};

/// The size of pages, in bytes, where the header does not say it.
const PAGE: usize = 4096;
/// Columns of a row, at most.
const COLUMNS: usize = 4;
/// The kinds of pages whose cells have rows: tables' leaves, and both kinds of pages of an index or of a table without row numbers.
const TABLE_LEAF: u8 = 13;
const INDEX_LEAF: u8 = 10;
const INDEX_INNER: u8 = 2;

/// A value in a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Column<'a> {
    Null,
    Int(i64),
    Blob(&'a [u8]),
    Text(&'a str),
    /// Of a type that no table of ours has.
    Other,
}

/// A file of an index and the pages of its log that belong to it.
struct Pages {
    file: File,
    count: u64,
    log: Option<File>,
    /// Where in the log the newest version of a page lies.
    newer: BTreeMap<u64, u64>,
    size: usize,
    /// Bytes of rows beyond their first page that are still read: as many as there are twice, however often a damaged page leads to the same ones.
    budget: u64,
}

/// Why not all rows were read.
#[derive(Debug)]
pub enum Fail {
    Io(io::Error),
    Stopped,
}

impl From<io::Error> for Fail {
    fn from(e: io::Error) -> Self {
        Self::Io(e)
    }
}

impl From<Stopped> for Fail {
    fn from(_: Stopped) -> Self {
        Self::Stopped
    }
}

/// Hands out every row in the index file at `path`: its number, 0 where its table has none, and its columns. No file, no rows.
pub fn rows(path: &Path, stop: &Stop, mut f: impl FnMut(i64, &[Column])) -> Result<(), Fail> {
    let Some(mut pages) = Pages::open(path)? else { return Ok(()) };
    let last = pages.newer.keys().next_back().copied().unwrap_or(0).max(pages.count);
    for number in 1..=last {
        stop.check()?;
        if let Some(page) = pages.page(number)? {
            pages.cells(&page, if number == 1 { 100 } else { 0 }, &mut f)?;
        }
    }
    Ok(())
}

fn plain(path: &Path) -> io::Result<Option<File>> {
    match std::fs::symlink_metadata(path) {
        Ok(meta) if meta.is_file() => File::open(path).map(Some),
        Ok(_) => Ok(None),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(e),
    }
}

fn is_size(size: usize) -> bool {
    size.is_power_of_two() && (512..=65536).contains(&size)
}

/// The bytes at `at`, as many of them as there are.
fn read_at(mut file: &File, at: u64, size: usize) -> io::Result<Vec<u8>> {
    let mut out = Vec::new();
    file.seek(SeekFrom::Start(at))?;
    file.take(size as u64).read_to_end(&mut out)?;
    Ok(out)
}

fn u16_at(bytes: &[u8], at: usize) -> Option<usize> {
    Some(usize::from(u16::from_be_bytes(bytes.get(at..)?.get(..2)?.try_into().ok()?)))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_be_bytes(bytes.get(at..)?.get(..4)?.try_into().ok()?))
}

/// A number of one to nine bytes and what follows it.
fn varint(bytes: &[u8]) -> Option<(u64, &[u8])> {
    let mut n = 0;
    for (i, b) in bytes.iter().enumerate().take(9) {
        if i == 8 {
            return Some((n << 8 | u64::from(*b), &bytes[9..]));
        }
        n = n << 7 | u64::from(b & 0x7f);
        if b & 0x80 == 0 {
            return Some((n, &bytes[i + 1..]));
        }
    }
    None
}

impl Pages {
    fn open(path: &Path) -> io::Result<Option<Self>> {
        let Some(file) = plain(path)? else { return Ok(None) };
        let header = read_at(&file, 0, 100)?;
        let said = u16_at(&header, 16).map(|n| if n == 1 { 65536 } else { n }).filter(|n| is_size(*n));
        let size = said.unwrap_or(PAGE);
        let mut log_path = path.as_os_str().to_owned();
        log_path.push("-wal");
        let (log, bytes) = (plain(Path::new(&log_path))?, file.metadata()?.len());
        let mut out =
            Self { file, count: bytes.div_ceil(size as u64), log, newer: BTreeMap::new(), size, budget: 2 * bytes };
        out.read_log()?;
        Ok(Some(out))
    }

    /// Finds the pages in the log, up to its last finished transaction.
    fn read_log(&mut self) -> io::Result<()> {
        let Some(log) = &self.log else { return Ok(()) };
        let header = read_at(log, 0, 32)?;
        let salt = header.get(16..24);
        if u32_at(&header, 8) != Some(self.size as u32) || salt.is_none() {
            return Ok(());
        }
        let mut unfinished = BTreeMap::new();
        let mut at = 32;
        loop {
            let frame = read_at(log, at, 24)?;
            let (Some(number), Some(pages)) = (u32_at(&frame, 0), u32_at(&frame, 4)) else { break };
            // Frames of an earlier use of the file have other numbers here.
            if frame.get(8..16) != salt {
                break;
            }
            unfinished.insert(u64::from(number), at + 24);
            if pages != 0 {
                self.newer.append(&mut unfinished);
            }
            at += 24 + self.size as u64;
        }
        self.budget += 2 * at;
        Ok(())
    }

    /// A whole page; `None` where the file has none of this number.
    fn page(&self, number: u64) -> io::Result<Option<Vec<u8>>> {
        let page = match (&self.log, self.newer.get(&number)) {
            (Some(log), Some(at)) => read_at(log, *at, self.size)?,
            _ if (1..=self.count).contains(&number) => read_at(&self.file, (number - 1) * self.size as u64, self.size)?,
            _ => return Ok(None),
        };
        Ok((page.len() == self.size).then_some(page))
    }

    /// Hands out the rows of a page whose head is at `head`.
    fn cells(&mut self, page: &[u8], head: usize, f: &mut impl FnMut(i64, &[Column])) -> io::Result<()> {
        let kind = page[head];
        let (before, numbered, pointers) = match kind {
            TABLE_LEAF => (0, true, 8),
            INDEX_LEAF => (0, false, 8),
            INDEX_INNER => (4, false, 12),
            _ => return Ok(()),
        };
        for i in 0..u16_at(page, head + 3).unwrap_or(0) {
            let Some(at) = u16_at(page, head + pointers + 2 * i) else { break };
            let cell = || {
                let (length, rest) = varint(page.get(at + before..)?)?;
                let (row, rest) = if numbered { varint(rest)? } else { (0, rest) };
                Some((length, row as i64, rest))
            };
            let Some((length, row, rest)) = cell() else { continue };
            if let Some(payload) = self.payload(length, rest, numbered)? {
                columns(&payload, |columns| f(row, columns));
            }
        }
        Ok(())
    }

    /// The bytes of a row of `length`, of which `rest` begins with those on its page.
    fn payload(&mut self, length: u64, rest: &[u8], numbered: bool) -> io::Result<Option<Vec<u8>>> {
        let usable = self.size as u64;
        let most = if numbered { usable - 35 } else { (usable - 12) * 64 / 255 - 23 };
        if length <= most {
            return Ok(rest.get(..length as usize).map(<[u8]>::to_vec));
        }
        if length > self.budget {
            return Ok(None);
        }
        let least = (usable - 12) * 32 / 255 - 23;
        let fitting = least + (length - least) % (usable - 4);
        let here = if fitting <= most { fitting } else { least } as usize;
        let Some((start, after)) = rest.split_at_checked(here) else { return Ok(None) };
        let (mut out, mut next) = (start.to_vec(), u32_at(after, 0));
        while (out.len() as u64) < length {
            let Some(page) = next.map(|n| self.page(n.into())).transpose()?.flatten() else { return Ok(None) };
            self.budget = self.budget.saturating_sub(usable);
            next = u32_at(&page, 0);
            let wanted = (length - out.len() as u64).min(usable - 4) as usize;
            out.extend(&page[4..4 + wanted]);
        }
        Ok(Some(out))
    }
}

/// Hands out the columns of a row, where it is a row and they are not too many.
fn columns(payload: &[u8], f: impl FnOnce(&[Column])) {
    let read = || {
        let (head, rest) = varint(payload)?;
        let before = payload.len() - rest.len();
        let mut types = payload.get(before..usize::try_from(head).ok()?)?;
        let mut body = payload.get(head as usize..)?;
        let mut out = [Column::Null; COLUMNS];
        let mut count = 0;
        while !types.is_empty() {
            let (ty, rest) = varint(types)?;
            types = rest;
            let length = match ty {
                0 | 8 | 9 => 0,
                1..=4 => ty,
                5 => 6,
                6 | 7 => 8,
                10 | 11 => return None,
                _ => (ty - 12) / 2,
            };
            let (bytes, rest) = body.split_at_checked(usize::try_from(length).ok()?)?;
            body = rest;
            *out.get_mut(count)? = match ty {
                0 => Column::Null,
                1..=6 => Column::Int(int(bytes)),
                8 | 9 => Column::Int(ty as i64 - 8),
                7 => Column::Other,
                _ if ty % 2 == 0 => Column::Blob(bytes),
                _ => std::str::from_utf8(bytes).map_or(Column::Other, Column::Text),
            };
            count += 1;
        }
        Some((out, count))
    };
    if let Some((out, count)) = read() {
        f(&out[..count]);
    }
}

/// A signed number, its highest byte first.
fn int(bytes: &[u8]) -> i64 {
    let sign = if bytes.first().is_some_and(|b| b & 0x80 != 0) { -1 } else { 0 };
    bytes.iter().fold(sign, |n, b| n << 8 | i64::from(*b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusqlite::Connection;

    fn all(path: &Path) -> Vec<(i64, Vec<String>)> {
        let mut out = Vec::new();
        rows(path, &Stop::default(), |row, columns| {
            out.push((row, columns.iter().map(|c| format!("{c:?}")).collect()))
        })
        .unwrap();
        out
    }

    #[test]
    fn rows_are_those_that_sqlite_stored() {
        for (page, journal) in [(512, "DELETE"), (4096, "WAL"), (65536, "WAL")] {
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join("a.sqlite");
            let db = Connection::open(&path).unwrap();
            db.execute_batch(&format!("PRAGMA page_size = {page}; PRAGMA journal_mode = {journal}")).unwrap();
            db.execute_batch("CREATE TABLE t(a BLOB, b INTEGER, c TEXT)").unwrap();
            db.execute_batch("CREATE TABLE w(a TEXT PRIMARY KEY, b BLOB) WITHOUT ROWID").unwrap();
            let numbers = [0, 1, -1, 127, -128, 40_000, -3_000_000, 1 << 33, 1 << 45, i64::MIN];
            let mut expect = Vec::new();
            for (i, n) in numbers.into_iter().enumerate() {
                // Some fit a page, some go on over several.
                let bytes: Vec<u8> = (0..i * i * 400).map(|k| (k * 7 + i) as u8).collect();
                let text = format!("text {i}");
                db.execute("INSERT INTO t VALUES(?1, ?2, ?3)", (&bytes, n, &text)).unwrap();
                db.execute("INSERT INTO w VALUES(?1, ?2)", (&text, &bytes)).unwrap();
                let columns = [Column::Blob(&bytes), Column::Int(n), Column::Text(&text)];
                expect.push((i as i64 + 1, columns.iter().map(|c| format!("{c:?}")).collect::<Vec<_>>()));
                let columns = [Column::Text(&text), Column::Blob(&bytes)];
                expect.push((0, columns.iter().map(|c| format!("{c:?}")).collect()));
            }
            // While the log has not been written back, too.
            for closed in [false, true] {
                let found = all(&path);
                for row in &expect {
                    assert_eq!(found.iter().filter(|f| *f == row).count(), 1, "{page} {closed}: {row:?}");
                }
                if !closed {
                    db.execute_batch("PRAGMA wal_checkpoint(TRUNCATE)").unwrap();
                }
            }
        }
    }

    #[test]
    fn a_page_that_leads_in_a_circle_ends() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.sqlite");
        let db = Connection::open(&path).unwrap();
        db.execute_batch("PRAGMA page_size = 512; CREATE TABLE t(a BLOB); INSERT INTO t VALUES(randomblob(60000))")
            .unwrap();
        drop(db);
        let mut bytes = std::fs::read(&path).unwrap();
        // Every page goes on at page 3.
        for page in bytes.chunks_mut(512).skip(2) {
            page[..4].copy_from_slice(&3u32.to_be_bytes());
        }
        std::fs::write(&path, bytes).unwrap();
        assert!(all(&path).len() <= 3);
    }
}
