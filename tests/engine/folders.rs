//! Which folders may be caches, and what is never deleted in them.

use super::{Bench, ok, squares, tree};
use farfield::{
    engine::{bake::bake, cache, error::EngineError, events::Silent, why::why},
    math::Stop,
};
use std::{collections::BTreeMap, fs, path::Path};

/// All of it: no limit holds.
fn all() -> cache::Limits {
    cache::Limits { max_bytes: Some(0), max_age: Some(std::time::Duration::ZERO), keep_bakes: Some(0) }
}

/// What every command that takes `--cache` says of a folder.
fn refusals(t: &Bench) -> Vec<String> {
    let (plan, cache) = (squares(&[1], 0), t.path("cache"));
    let refused = |e: EngineError| {
        assert!(matches!(e, EngineError::NotACache { .. }) && e.exit_code() == 2, "{e}");
        e.to_string()
    };
    let dry = farfield::engine::bake::Options { dry_run: true, ..t.options() };
    vec![
        refused(bake(&plan, &t.options(), &Stop::default(), &Silent).unwrap_err()),
        refused(bake(&plan, &dry, &Stop::default(), &Silent).unwrap_err()),
        refused(why(&plan, &t.options(), "sum").unwrap_err()),
        refused(cache::stats(&cache).unwrap_err()),
        refused(cache::verify(&cache, &Stop::default()).unwrap_err()),
        refused(cache::gc(&cache, &all()).unwrap_err()),
    ]
}

fn project(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    for (name, text) in [("tmp/notes.txt", "a"), ("bad/photo.png", "b"), ("values/list.csv", "c"), ("scene.toml", "d")]
    {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    tree(folder)
}

#[test]
fn a_folder_with_other_things_is_refused() {
    let t = Bench::new();
    let before = project(&t.path("cache"));
    for text in refusals(&t) {
        assert!(text.contains("scene.toml") && text.contains("--cache"), "{text}");
    }
    assert_eq!(tree(&t.path("cache")), before);
    assert!(!t.path("out").exists());
    // A file of our name that is no index makes it no cache.
    fs::write(t.path("cache/index-4.sqlite"), "SQLite format 3").unwrap();
    let before = tree(&t.path("cache"));
    assert_eq!(refusals(&t).len(), 6);
    assert_eq!(tree(&t.path("cache")), before);
}

#[test]
fn an_empty_folder_becomes_a_cache_and_an_old_cache_is_taken_over() {
    let t = Bench::new();
    fs::create_dir_all(t.path("cache")).unwrap();
    let plan = squares(&[1, 2], 0);
    ok(&t.bake(&plan));
    let marker = fs::read_to_string(t.path("cache/CACHEDIR.TAG")).unwrap();
    assert!(marker.starts_with("Signature: 8a477f597d28d172789f06886806bc55"), "{marker}");
    // From before there were markers.
    fs::remove_file(t.path("cache/CACHEDIR.TAG")).unwrap();
    assert_eq!(ok(&t.bake(&plan)).runs(), 0);
    assert!(t.path("cache/CACHEDIR.TAG").is_file());
    // The same with something beside it, or with another index: not ours for certain.
    fs::remove_file(t.path("cache/CACHEDIR.TAG")).unwrap();
    fs::write(t.path("cache/thesis.txt"), "precious").unwrap();
    assert!(refusals(&t)[0].contains("thesis.txt"));
    fs::remove_file(t.path("cache/thesis.txt")).unwrap();
    let db = rusqlite::Connection::open(t.path("cache/index-4.sqlite")).unwrap();
    db.execute_batch("CREATE TABLE other(x)").unwrap();
    drop(db);
    refusals(&t);
    // Another program's marker of a cache is not ours.
    fs::write(t.path("cache/CACHEDIR.TAG"), "Signature: 8a477f597d28d172789f06886806bc55\n# cargo\n").unwrap();
    refusals(&t);
}

#[test]
fn a_cache_of_the_layout_before_is_taken_over() {
    let t = Bench::new();
    for inner in ["values", "tmp", "locks", "claims"] {
        fs::create_dir_all(t.path("cache").join(inner)).unwrap();
    }
    let db = rusqlite::Connection::open(t.path("cache/index-3.sqlite")).unwrap();
    let tables = "CREATE TABLE run(key BLOB, variant BLOB, record BLOB, used INTEGER, PRIMARY KEY(key, variant));
        CREATE TABLE map(key BLOB PRIMARY KEY, record BLOB, used INTEGER);
        CREATE TABLE value(hash BLOB PRIMARY KEY, size INTEGER, data BLOB);
        CREATE TABLE fixed(hash BLOB PRIMARY KEY, fields BLOB) WITHOUT ROWID;
        CREATE TABLE file(path TEXT PRIMARY KEY, stamp BLOB, hash BLOB, at INTEGER) WITHOUT ROWID;
        CREATE TABLE bake(id INTEGER PRIMARY KEY AUTOINCREMENT, pipeline TEXT, folder TEXT, record BLOB);";
    db.execute_batch(tables).unwrap();
    // Nobody else has tables of these names, but without its number the file is not for certain ours.
    drop(db);
    assert_eq!(refusals(&t).len(), 6);
    let db = rusqlite::Connection::open(t.path("cache/index-3.sqlite")).unwrap();
    db.execute_batch("PRAGMA user_version = 1").unwrap();
    drop(db);
    let plan = squares(&[1, 2], 0);
    ok(&t.bake(&plan));
    std::thread::sleep(std::time::Duration::from_millis(20));
    t.gc(&cache::Limits::default());
    assert!(!t.path("cache/index-3.sqlite").exists());
    assert_eq!(ok(&t.bake(&plan)).runs(), 0);
}

#[test]
fn gc_deletes_only_files_with_names_of_ours() {
    let t = Bench::new();
    ok(&t.bake(&squares(&[1, 2, 3], 50_000)));
    let random = farfield::engine::temporary::name();
    let hash = "ab".repeat(32);
    for name in ["tmp/notes.txt", "tmp/1234-5", "bad/photo.png", "values/list.csv", "values/ab/x", "values/cd/y.txt"] {
        fs::create_dir_all(t.path("cache").join(name).parent().unwrap()).unwrap();
        fs::write(t.path("cache").join(name), "precious").unwrap();
    }
    let precious = tree(&t.path("cache")).into_iter().filter(|(_, bytes)| bytes == b"precious").count();
    assert_eq!(precious, 6);
    for ours in [format!("tmp/{random}"), format!("bad/{hash}"), format!("values/ab/{hash}")] {
        fs::write(t.path("cache").join(ours), "ours").unwrap();
    }
    for old in ["index-3.sqlite", "index-4.sqlite.damaged"] {
        fs::write(t.path("cache").join(old), "ours").unwrap();
    }
    // What was touched after the sweep began stays.
    std::thread::sleep(std::time::Duration::from_millis(20));
    t.gc(&all());
    let left = tree(&t.path("cache"));
    assert_eq!(left.values().filter(|bytes| *bytes == b"precious").count(), 6, "{:?}", left.keys());
    assert_eq!(left.values().filter(|bytes| *bytes == b"ours").count(), 0, "{:?}", left.keys());
}

#[cfg(unix)]
#[test]
fn gc_follows_no_link() {
    use std::os::unix::fs::symlink;
    let t = Bench::new();
    ok(&t.bake(&squares(&[1, 2, 3], 50_000)));
    // Names that would be deleted in a cache.
    let (hash, random) = ("ab".repeat(32), farfield::engine::temporary::name());
    let precious = t.path("precious");
    for name in [hash.clone(), random.clone(), format!("ab/{hash}"), "0".to_owned(), "000".to_owned()] {
        fs::create_dir_all(precious.join(&name).parent().unwrap()).unwrap();
        fs::write(precious.join(name), "precious").unwrap();
    }
    let before = tree(&precious);
    for inner in ["tmp", "bad", "values", "claims", "locks"] {
        let path = t.path("cache").join(inner);
        let away = t.path("away");
        if path.exists() {
            fs::rename(&path, &away).unwrap();
        }
        symlink(&precious, &path).unwrap();
        for text in refusals(&t) {
            assert!(text.contains(&format!("`{inner}`")) && text.contains("symbolic link"), "{text}");
        }
        assert_eq!(tree(&precious), before, "{inner}");
        fs::remove_file(&path).unwrap();
        if away.exists() {
            fs::rename(&away, &path).unwrap();
        }
    }
    // Links deeper inside, where names of ours are looked for.
    fs::create_dir_all(t.path("cache/bad")).unwrap();
    symlink(precious.join(&hash), t.path("cache/bad").join(&hash)).unwrap();
    symlink(precious.join(&random), t.path("cache/tmp").join(&random)).unwrap();
    let _ = fs::remove_dir_all(t.path("cache/values/ab"));
    symlink(precious.join("ab"), t.path("cache/values/ab")).unwrap();
    t.gc(&all());
    assert_eq!(tree(&precious), before);
    // The cache itself may be reached through a link.
    fs::remove_file(t.path("cache/values/ab")).unwrap();
    fs::rename(t.path("cache"), t.path("moved")).unwrap();
    symlink(t.path("moved"), t.path("cache")).unwrap();
    ok(&t.bake(&squares(&[1, 2, 3], 50_000)));
}

#[test]
fn a_missing_cache_is_none() {
    let t = Bench::new();
    let cache = t.path("cache");
    assert_eq!(cache::stats(&cache).unwrap(), None);
    assert_eq!(cache::verify(&cache, &Stop::default()).unwrap(), None);
    assert_eq!(cache::gc(&cache, &all()).unwrap(), None);
    fs::create_dir_all(&cache).unwrap();
    assert_eq!(cache::stats(&cache).unwrap(), None);
    assert!(tree(&cache).is_empty());
}
