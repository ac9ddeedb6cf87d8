//! Damage to the index: whatever bit is flipped, nothing is read that was not stored under the same key, and no damage
//! lasts. `FARFIELD_FLIPS=8` flips every bit of the file; two bits of every byte by default.

use super::*;
use crate::engine::{
    record::{BakeRecord, MapRow, NodeTrace, Read, TraceOut},
    value::{PortOut, ValueRef as Value},
};
use std::fs;

/// What a cache was given, and must give back or lose.
struct Known {
    runs: Vec<(Digest, RunRecord)>,
    maps: Vec<(Digest, MapRecord)>,
    values: Vec<Digest>,
    fixed: Vec<(Digest, Fields)>,
    files: Vec<(PathBuf, Digest)>,
    bakes: Vec<BakeRecord>,
}

const PIPELINE: &str = "test";
const FOLDER: &str = "/out/test";

fn map_bytes(key: &Digest, map: &MapRecord) -> Vec<u8> {
    let rows = map.rows.iter().map(|r| (&*r.name, r.key, &r.outputs[..]));
    MapRecord::write(key, map.fixed, &map.inputs, rows, &map.warnings)
}

fn hash(n: u8) -> Digest {
    Digest::of(&[n])
}

/// A cache of few small rows, so that its file is small, and files of the outside world below `root`.
fn fill(root: &Path) -> Known {
    let mut known = Known {
        runs: Vec::new(),
        maps: Vec::new(),
        values: Vec::new(),
        fixed: Vec::new(),
        files: Vec::new(),
        bakes: Vec::new(),
    };
    for name in ["a", "b"] {
        let path = root.join(name);
        fs::write(&path, name).unwrap();
        known.files.push((path, Digest::of(name.as_bytes())));
    }
    // A file that has just changed is not remembered.
    std::thread::sleep(std::time::Duration::from_millis(2100));
    let mut cache = Cache::open(&root.join("cache"), true).unwrap();
    for i in 0..2u8 {
        let (key, value) = (hash(i), hash(100 + i));
        let out = || PortOut::One(Value { hash: value, size: 1 });
        let reads = vec![Read { path: "x".to_owned(), hash: Some(hash(i)) }];
        let run = RunRecord {
            fixed: hash(50),
            inputs: Vec::new(),
            outputs: vec![out()],
            warnings: Vec::new(),
            seconds: 1.0,
            reads: if i == 0 { Vec::new() } else { reads },
        };
        let new = NewValue { hash: value, place: Place::Inline(vec![100 + i]) };
        cache.put_run(key, Arc::new(run.clone()), vec![new], None).unwrap();
        let row = MapRow { name: "n".to_owned(), key, outputs: vec![out()] };
        let map = MapRecord { fixed: hash(50), inputs: Vec::new(), rows: vec![row], warnings: Vec::new() };
        cache.put_map(hash(20 + i), map_bytes(&hash(20 + i), &map)).unwrap();
        let fields = vec![("parameter a".to_owned(), i.to_string())];
        cache.put_fixed(hash(50 + i), || fields.clone());
        let trace = NodeTrace {
            name: "n".to_owned(),
            key,
            variant: Digest::default(),
            mapped: false,
            elements: 1,
            ran: 1,
            note: String::new(),
            outputs: vec![TraceOut { hash: value, size: Some(1) }],
            warnings: Vec::new(),
        };
        let bake = BakeRecord { at: i.into(), nodes: vec![trace], ..BakeRecord::default() };
        cache.put_bake(PIPELINE, FOLDER, &bake).unwrap();
        known.runs.push((key, run));
        known.maps.push((hash(20 + i), map));
        known.values.push(value);
        known.fixed.push((hash(50 + i), fields));
        known.bakes.insert(0, bake);
    }
    for (path, hash) in &known.files {
        assert_eq!(cache.hash_file(path).unwrap().unwrap().0, *hash);
    }
    drop(cache);
    // Small pages make a small file.
    let db = rusqlite::Connection::open(layout::path(&root.join("cache"))).unwrap();
    db.execute_batch("PRAGMA journal_mode = DELETE; PRAGMA page_size = 512; VACUUM; PRAGMA journal_mode = WAL;")
        .unwrap();
    known
}

/// Reads all that is known, then writes. Gives how much is missing. Nothing may differ.
fn read_and_write(root: &Path, known: &Known, place: &str) -> Result<usize, EngineError> {
    let mut cache = Cache::open(root, true)?;
    let mut missing = 0;
    let mut same = |found: Option<bool>, what: &str| match found {
        Some(same) => assert!(same, "{place}: another {what} than was stored"),
        None => missing += 1,
    };
    for (key, run) in &known.runs {
        let found = cache.runs(key)?;
        // A damaged index may not find a row, so that a second one like it is stored.
        let equal = found.iter().all(|(variant, record)| **record == *run && *variant == run.variant());
        same((!found.is_empty()).then_some(equal), "run");
    }
    for (key, map) in &known.maps {
        same(cache.map(key)?.map(|found| found == *map), "map");
    }
    let many = cache.values(known.values.iter().copied())?;
    for value in &known.values {
        for stored in [cache.value(value)?, many.get(value).cloned()] {
            // Bytes that do not fit their hash are refused where they are taken.
            let bytes = stored.and_then(|s| if let Stored::Inline(bytes) = s { Some(bytes) } else { None });
            same(bytes.filter(|bytes| Digest::of(bytes) == *value).map(|_| true), "value");
        }
    }
    for (hash, fields) in &known.fixed {
        same(cache.fixed(hash)?.map(|found| found == *fields), "fixed part");
    }
    for (path, hash) in &known.files {
        let found = cache.hash_file(path).unwrap();
        assert_eq!(found, Some((*hash, 1)), "{place}: the hash of a file");
    }
    let bakes = cache.bakes(PIPELINE, FOLDER, 10)?.records;
    same((bakes.len() == known.bakes.len()).then_some(true), "bake");
    assert!(bakes.iter().all(|bake| known.bakes.contains(bake)), "{place}: another bake than was stored");

    let (key, run) = &known.runs[0];
    cache.set_aside(&known.values[0])?;
    let new = NewValue { hash: known.values[0], place: Place::Inline(vec![100]) };
    cache.put_run(*key, Arc::new(run.clone()), vec![new], None)?;
    let (key, map) = &known.maps[0];
    cache.put_map(*key, map_bytes(key, map))?;
    cache.put_fixed(known.fixed[0].0, || known.fixed[0].1.clone());
    cache.put_bake(PIPELINE, FOLDER, &known.bakes[0])?;
    cache.flush()?;
    Ok(missing)
}

/// As a bake does it: damage is set aside, and what follows works.
fn survives(root: &Path, known: &Known, what: &str) -> usize {
    for attempt in 0..3 {
        match read_and_write(root, known, what) {
            Ok(missing) => return missing,
            Err(EngineError::Damaged { .. }) => index::set_aside(root, attempt > 0).unwrap(),
            Err(e) => panic!("{what}: {e}"),
        }
    }
    panic!("{what}: damage that lasts");
}

fn restore(root: &Path, bytes: &[u8]) {
    for suffix in ["", "-wal", "-shm"] {
        let _ = fs::remove_file(root.join(format!("index-4.sqlite{suffix}")));
    }
    fs::write(layout::path(root), bytes).unwrap();
}

#[test]
fn no_flipped_bit_gives_another_result_or_lasts() {
    let bits: usize = std::env::var("FARFIELD_FLIPS").ok().and_then(|n| n.parse().ok()).unwrap_or(2);
    let dir = tempfile::tempdir().unwrap();
    let known = fill(dir.path());
    let good = fs::read(layout::path(&dir.path().join("cache"))).unwrap();
    assert!(good.len() < 20_000, "{} bytes", good.len());
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|s| {
        for thread in 0..threads {
            let (known, good, root) = (&known, &good, dir.path().join(format!("cache-{thread}")));
            s.spawn(move || {
                drop(Cache::open(&root, true).unwrap());
                restore(&root, good);
                assert_eq!(survives(&root, known, "undamaged"), 0);
                for at in (thread..good.len()).step_by(threads) {
                    // Another choice of bits at each place.
                    for bit in (0..bits).map(|b| (b + at * 3) % 8) {
                        let mut bad = good.clone();
                        bad[at] ^= 1 << bit;
                        restore(&root, &bad);
                        let what = format!("bit {bit} of byte {at}");
                        survives(&root, known, &what);
                        // Damage where nothing was read or written at first is met and cured later.
                        survives(&root, known, &format!("{what}, later"));
                    }
                }
            });
        }
    });
}

#[test]
fn entries_swapped_between_rows_are_damage() {
    let dir = tempfile::tempdir().unwrap();
    let known = fill(dir.path());
    let root = dir.path().join("cache");
    let good = fs::read(layout::path(&root)).unwrap();
    for (table, key, column) in [
        ("run", "key", "record"),
        ("map", "key", "record"),
        ("value", "hash", "data"),
        ("fixed", "hash", "fields"),
        ("file", "path", "record"),
        ("bake", "id", "record"),
    ] {
        restore(&root, &good);
        let db = rusqlite::Connection::open(layout::path(&root)).unwrap();
        let other = format!("(SELECT b.{column} FROM {table} b WHERE b.{key} <> {table}.{key})");
        assert_eq!(db.execute(&format!("UPDATE {table} SET {column} = {other}"), []).unwrap(), 2);
        drop(db);
        let missing = survives(&root, &known, table);
        // The hash of a file is taken again, and so never missing.
        assert!(missing > 0 || table == "file", "{table}: nothing was noticed");
    }
}

#[test]
fn values_of_another_type_are_damage() {
    let dir = tempfile::tempdir().unwrap();
    let known = fill(dir.path());
    let root = dir.path().join("cache");
    let good = fs::read(layout::path(&root)).unwrap();
    for (table, columns) in [
        ("run", &["variant", "record", "used"][..]),
        ("map", &["record", "used"]),
        ("value", &["size", "data"]),
        ("fixed", &["fields"]),
        ("file", &["record", "at"]),
        ("bake", &["pipeline", "folder", "record"]),
    ] {
        for column in columns {
            for value in ["NULL", "7", "1.5", "'text'", "x''", "x'00'"] {
                restore(&root, &good);
                let db = rusqlite::Connection::open(layout::path(&root)).unwrap();
                db.execute(&format!("UPDATE {table} SET {column} = {value}"), []).unwrap();
                drop(db);
                let what = format!("{table}.{column} = {value}");
                let lost = survives(&root, &known, &what);
                let harmless = ["used", "size", "at"].contains(column) || table == "file";
                assert!(lost > 0 || harmless, "{what}: nothing was noticed");
                verify(&root, &crate::math::Stop::default()).unwrap();
                assert!(verify(&root, &crate::math::Stop::default()).unwrap().unwrap().is_clean(), "{what}");
            }
        }
    }
}

#[test]
fn after_a_write_that_failed_nothing_is_stored_that_leads_to_what_was_lost() {
    let dir = tempfile::tempdir().unwrap();
    let root = dir.path().join("cache");
    let mut cache = Cache::open(&root, true).unwrap();
    let pages: i64 = cache.db.query_row("PRAGMA page_count", [], |r| r.get(0)).unwrap();
    cache.db.pragma_update(None, "max_page_count", pages).unwrap();
    let value = vec![7; 16_000];
    let out = || PortOut::One(Value { hash: Digest::of(&value), size: value.len() as u64 });
    let run = RunRecord {
        fixed: hash(50),
        inputs: Vec::new(),
        outputs: vec![out()],
        warnings: Vec::new(),
        seconds: 1.0,
        reads: Vec::new(),
    };
    let new = NewValue { hash: Digest::of(&value), place: Place::Inline(value.clone()) };
    let stored = cache.put_run(hash(0), Arc::new(run), vec![new], None).and_then(|()| cache.flush());
    assert!(stored.unwrap_err().to_string().contains("the disk is full"));
    // There is space again, and the node's other results come in.
    cache.db.pragma_update(None, "max_page_count", pages + 1000).unwrap();
    let row = MapRow { name: "n".to_owned(), key: hash(0), outputs: vec![out()] };
    let map = MapRecord { fixed: hash(50), inputs: Vec::new(), rows: vec![row], warnings: Vec::new() };
    cache.put_map(hash(20), map_bytes(&hash(20), &map)).unwrap();
    drop(cache);
    let found = verify(&root, &crate::math::Stop::default()).unwrap().unwrap();
    assert!(found.is_clean(), "{found:?}");
}
