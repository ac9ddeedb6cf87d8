//! Records of whole bakes: the last one of a pipeline lets the next believe whole nodes, and all of them tell `why` what
//! changed.

use super::{Cache, blob_of, index};
use crate::engine::{error::EngineError, record::BakeRecord};
use rusqlite::{Connection, params};

/// Bake records, over all pipelines, whose results a sweep keeps unless it is told otherwise.
pub const PROTECTED: u64 = 20;
/// Bake records kept beyond those while they are so many at most and take so many bytes together at most.
const KEPT: (u64, u64) = (1000, 32 << 20);

/// How far back the bake records of one pipeline into one folder reach.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BakesOnRecord {
    /// Newest first.
    pub records: Vec<BakeRecord>,
    /// Whether records of bakes, of any pipeline, were dropped to keep the number of records small.
    pub forgotten: bool,
}

impl Cache {
    /// The newest `count` bake records of `pipeline` into `folder`.
    pub fn bakes(&mut self, pipeline: &str, folder: &str, count: usize) -> Result<BakesOnRecord, EngineError> {
        let (mut records, mut bad) = (Vec::new(), Vec::new());
        let mut read = || -> rusqlite::Result<bool> {
            let query = "SELECT id, record FROM bake WHERE pipeline = ?1 AND folder = ?2 ORDER BY id DESC";
            let mut s = self.db.prepare_cached(query)?;
            let mut rows = s.query(params![pipeline, folder])?;
            while records.len() < count
                && let Some(row) = rows.next()?
            {
                let id = row.get_ref(0)?.as_i64().unwrap_or(0);
                match BakeRecord::from_bytes(blob_of(row.get_ref(1)?), id, pipeline, folder) {
                    Some(record) => records.push(record),
                    None => bad.push(id),
                }
            }
            first(&self.db).map(|first| first > 1)
        };
        let forgotten = read().map_err(|e| self.sql(&e))?;
        for id in bad {
            if self.bad_bakes.insert(id) {
                self.warnings.push("the index held a damaged record of a bake; it is dropped".to_owned());
            }
        }
        Ok(BakesOnRecord { records, forgotten })
    }

    /// Stores the record of a bake, and drops the oldest ones. A record that cannot be written for want of space is a
    /// warning: the results themselves are stored.
    pub fn put_bake(&mut self, pipeline: &str, folder: &str, record: &BakeRecord) -> Result<(), EngineError> {
        self.flush()?;
        if !self.writable {
            return Ok(());
        }
        let written = self.transaction(|| {
            for id in &self.bad_bakes {
                self.db.execute("DELETE FROM bake WHERE id = ?1", [id])?;
            }
            // A number that was not given here is damage.
            self.db.execute("DELETE FROM bake WHERE id < 1 OR id > ?1", [LAST])?;
            let id: i64 = self.db.query_row("SELECT ifnull(max(id), 0) + 1 FROM bake", [], |r| r.get(0))?;
            let bytes = record.to_bytes(id, pipeline, folder);
            self.db
                .execute("INSERT OR REPLACE INTO bake VALUES(?1, ?2, ?3, ?4)", params![id, pipeline, folder, bytes])?;
            let old = "DELETE FROM bake WHERE id IN (SELECT id FROM (SELECT id, row_number() OVER w AS n, \
                       sum(length(record)) OVER w AS bytes FROM bake WINDOW w AS (ORDER BY id DESC)) \
                       WHERE n > ?1 AND (n > ?2 OR bytes > ?3))";
            self.db.execute(old, params![PROTECTED as i64, KEPT.0 as i64, KEPT.1 as i64]).map(drop)
        });
        match written {
            Err(e) if index::cannot_write(&e) => {
                self.warnings.push(format!("the record of this bake cannot be stored ({e}); `why` will not know it"));
                Ok(())
            }
            other => other.map_err(|e| self.sql(&e)),
        }
    }
}

/// Larger numbers of bakes are damage.
const LAST: i64 = 1 << 48;

/// The smallest number of a bake on record; 1 where nothing was dropped yet.
fn first(db: &Connection) -> rusqlite::Result<i64> {
    db.query_row("SELECT ifnull(min(id), 1) FROM bake WHERE id > 0", [], |r| Ok(r.get_ref(0)?.as_i64().unwrap_or(1)))
}
