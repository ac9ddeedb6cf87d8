//! The table of a batch: `summary.html` and `summary.csv` in the folder that holds the results of its bakes. Neither tells times, so a batch in which nothing changed
//! leaves both as they are. How each begins says that it is ours.

use super::{FolderLock, in_the_way, not_ours};
use crate::engine::error::EngineError;
use std::{
    fs,
    io::{self, Read as _},
    path::Path,
};

/// Their names, and how those of ours begin.
pub const PAGE: (&str, &str) = ("summary.html", "<!doctype html>\n<!-- farfield summary -->\n");
pub const TABLE: (&str, &str) = ("summary.csv", "bake,outcome,");

/// Writes both, unsynced, where they differ from what is there. What is not ours is not replaced, unless `overwrite` says so.
///
/// # Errors
/// Where a file is not ours, or cannot be written.
pub fn write(out: &Path, page: &str, table: &[u8], overwrite: bool) -> Result<(), EngineError> {
    let page = format!("{}{page}", PAGE.1);
    debug_assert!(table.starts_with(TABLE.1.as_bytes()));
    let files = [(PAGE, page.as_bytes()), (TABLE, table)];
    for ((name, head), _) in files {
        let path = out.join(name);
        match fs::symlink_metadata(&path) {
            Ok(meta) if meta.is_dir() => return Err(in_the_way(&path)),
            Ok(_) if !overwrite && !begins(&path, head) => return Err(not_ours(&path)),
            _ => {}
        }
    }
    let fail = |path: &Path, e: io::Error| EngineError::publish(path, e);
    let lock = FolderLock::take(out, "summary").map_err(|e| fail(out, e))?;
    let lock = lock.ok_or_else(|| EngineError::publish(out, "another bake writes its summary"))?;
    for ((name, _), bytes) in files {
        let path = out.join(name);
        let same = fs::symlink_metadata(&path).is_ok_and(|meta| meta.is_file() && meta.len() == bytes.len() as u64)
            && fs::read(&path).is_ok_and(|old| old == bytes);
        if !same {
            lock.replace(&path, bytes).map_err(|e| fail(&path, e))?;
        }
    }
    Ok(())
}

fn begins(path: &Path, head: &str) -> bool {
    let mut found = vec![0; head.len()];
    let regular = fs::symlink_metadata(path).is_ok_and(|meta| meta.is_file());
    regular && fs::File::open(path).and_then(|mut file| file.read_exact(&mut found)).is_ok() && found == head.as_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_replaced_and_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let out = dir.path().join("out");
        write(&out, "<html>1", b"bake,outcome,\n1", false).unwrap();
        let page = || fs::read_to_string(out.join("summary.html")).unwrap();
        assert!(page().starts_with("<!doctype html>") && page().ends_with("<html>1"));
        let before = fs::metadata(out.join("summary.csv")).unwrap().modified().unwrap();
        write(&out, "<html>2", b"bake,outcome,\n1", false).unwrap();
        assert!(page().ends_with("<html>2"));
        assert_eq!(fs::metadata(out.join("summary.csv")).unwrap().modified().unwrap(), before, "it was the same");
        fs::write(out.join("summary.csv"), "mine").unwrap();
        assert!(write(&out, "<html>3", b"bake,outcome,\n1", false).unwrap_err().to_string().contains("did not write"));
        assert!(page().ends_with("<html>2"), "neither is written");
        write(&out, "<html>3", b"bake,outcome,\n2", true).unwrap();
        assert_eq!(fs::read(out.join("summary.csv")).unwrap(), b"bake,outcome,\n2");
        fs::remove_file(out.join("summary.html")).unwrap();
        fs::create_dir(out.join("summary.html")).unwrap();
        assert!(write(&out, "", b"bake,outcome,\n2", true).unwrap_err().to_string().contains("folder"));
    }
}
