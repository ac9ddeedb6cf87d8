//! Every byte that a cache stores is flipped: no output differs, nothing panics, `verify` names the damage, `rebuild` keeps what is sound.

use super::{Bench, cases, copy, ok, spread, support::*, tree};
use farfield::{
    engine::{cache, plan::Plan},
    math::Stop,
};
use serde_json::json;
use std::{fs, path::Path};

/// Values in the index, a value file of bytes as they are, one of compressed bytes, a bundle, a transient node.
fn plan() -> Plan {
    let mut b = Builder::default();
    let list = b.node::<MakeList>("list", json!({ "names": ["a", "b"], "values": [3, 4] }), &[]);
    let near = b.node::<Named>("near", json!({}), &[From::Node(list)]);
    b.transient(near);
    let square = b.node::<Square>("square", json!({ "pad": 17_000 }), &[From::Node(near)]);
    let sum = b.node::<Sum>("sum", json!({}), &[From::Node(square)]);
    let long = b.node::<Print>("long", json!({}), &[From::Node(square)]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
    b.file("long/{name}.txt", long);
    b.file("sum.txt", print);
    b.plan()
}

/// A cache with small pages, which makes a small file.
fn template() -> Bench {
    let t = Bench::new();
    ok(&t.bake(&plan()));
    let db = rusqlite::Connection::open(t.path("cache/index-4.sqlite")).unwrap();
    db.execute_batch("PRAGMA journal_mode = DELETE; PRAGMA page_size = 512; VACUUM; PRAGMA journal_mode = WAL;")
        .unwrap();
    t
}

/// Whether a stored value is compressed; one that is not differs wherever its file does.
fn is_packed(path: &Path) -> bool {
    fs::read(path).unwrap().starts_with(b"\0farLZ4\x01")
}

fn flip(path: &Path, at: usize, bit: usize) {
    let mut bytes = fs::read(path).unwrap();
    bytes[at] ^= 1 << (bit % 8);
    fs::remove_file(path).unwrap();
    fs::write(path, bytes).unwrap();
}

/// What `verify` finds; nothing where it has set the index aside before.
fn verify(t: &Bench) -> cache::Verified {
    cache::verify(&t.path("cache"), &Stop::default()).unwrap().unwrap_or_default()
}

/// Bakes so that everything is read: the outputs are gone, and what needs the large values runs again.
fn bakes_the_same(t: &Bench, expect: &std::collections::BTreeMap<String, Vec<u8>>, what: &str) {
    fs::remove_dir_all(t.path("out")).unwrap();
    ok(&t.bake_with(&plan(), |o| o.force = vec!["sum".into()]));
    assert!(tree(&t.path("out")) == *expect, "{what}: other outputs");
}

#[test]
fn every_stored_byte_may_flip() {
    let template = template();
    let expect = tree(&template.path("out"));
    let files: Vec<(String, usize)> =
        tree(&template.path("cache")).into_iter().map(|(name, b)| (name, b.len())).collect();
    let (mut flips, mut named, mut harmless, mut kept) = (0, 0, 0, 0);
    for (turn, (name, size)) in files.iter().enumerate() {
        // Locks and marks say only who holds them.
        if *size == 0 || name.starts_with("locks/") || name.starts_with("claims/") || name == "index.lock" {
            continue;
        }
        let is_index = name.starts_with("index-");
        for at in spread(*size, cases(if is_index { 30 } else { 5 }, *size), turn) {
            let what = format!("bit {} of byte {at} of {name}", at % 8);
            let damaged = || {
                let t = Bench::new();
                copy(&template.path(""), &t.path(""));
                flip(&t.path("cache").join(name), at, at);
                t
            };
            flips += 1;
            if name == "CACHEDIR.TAG" {
                // A cache without its marker is known by its index, or refused: nothing of it is deleted.
                let t = damaged();
                let marked = cache::verify(&t.path("cache"), &Stop::default());
                assert!(marked.is_ok() || marked.is_err_and(|e| e.exit_code() == 2), "{what}");
                continue;
            }
            let t = damaged();
            bakes_the_same(&t, &expect, &what);
            bakes_the_same(&t, &expect, &format!("{what}, the second time"));
            // Damage that nothing met so far is met by a check, and does not last.
            verify(&t);
            assert!(verify(&t).is_clean(), "{what}: damage lasts");

            let t = damaged();
            let found = verify(&t);
            // LZ4 may say one thing in two ways: a match that begins elsewhere in a run of equal bytes gives the same value.
            let same_value = !is_index && found.is_clean() && is_packed(&t.path("cache").join(name));
            if is_index {
                named += usize::from(!found.is_clean());
            } else if same_value {
                harmless += 1;
            } else {
                let hash = name.rsplit('/').next().unwrap();
                assert!(found.bad.iter().any(|bad| bad.contains(hash)), "{what} is not named: {found:?}");
                named += 1;
            }
            assert!(verify(&t).is_clean(), "{what}: verify leaves damage");
            bakes_the_same(&t, &expect, &what);

            let t = damaged();
            let rebuilt = cache::rebuild(&t.path("cache"), &Stop::default()).unwrap().unwrap();
            assert!(t.verify().is_clean(), "{what}: rebuild leaves damage");
            if is_index {
                assert!(rebuilt.bad.is_empty(), "{what}: {rebuilt:?}");
            } else if same_value {
                assert!(rebuilt.bad.is_empty(), "{what}: {rebuilt:?}, and `verify` found nothing");
            } else {
                assert_eq!(rebuilt.bad.len(), 1, "{what}: {rebuilt:?}");
            }
            let report = t.bake(&plan());
            // Of eight results a flipped byte costs few: those whose rows lie on its page, or that its value belongs to.
            assert!(ok(&report).runs() <= 6, "{what}: {} runs after {rebuilt:?}", report.runs());
            kept += report.hits();
            bakes_the_same(&t, &expect, &what);
        }
    }
    println!("{flips} flips, {named} named by verify, {harmless} that change no value, {kept} results kept by rebuild");
    assert!(flips >= 50 && named * 2 > flips && kept > 0, "{flips} flips, {named} named, {kept} kept");
    assert!(harmless * 20 < flips, "{harmless} of {flips} flips change no value");
}
