//! `cache rebuild`: an index anew from the values and from what a damaged one still says.

use super::{Bench, child::nothing_kept, ok, plan, tree};
use farfield::{
    engine::{
        cache::{self, Rebuilt},
        why::why,
    },
    math::Stop,
};
use std::fs;

fn rebuild(t: &Bench) -> Rebuilt {
    cache::rebuild(&t.path("cache"), &Stop::default()).unwrap().unwrap()
}

#[test]
fn a_sound_index_loses_nothing() {
    let t = Bench::new();
    for variant in 0..3 {
        ok(&t.bake(&plan(variant, 5)));
    }
    let before = cache::stats(&t.path("cache")).unwrap().unwrap();
    let rebuilt = rebuild(&t);
    let after = cache::stats(&t.path("cache")).unwrap().unwrap();
    assert_eq!(cache::Stats { index_bytes: 0, ..after }, cache::Stats { index_bytes: 0, ..before });
    assert_eq!((rebuilt.runs, rebuilt.maps, rebuilt.bakes), (after.runs, after.maps, after.bakes));
    assert_eq!((rebuilt.values, rebuilt.bad.len()), (after.values, 0));
    assert!(t.verify().is_clean());
    assert_eq!(ok(&t.bake(&plan(2, 5))).runs(), 0);
    assert!(why(&plan(2, 5), &t.options(), "sum").unwrap().starts_with("sum ran"));
    assert_eq!(rebuild(&t), rebuilt, "the second time it is the same");
}

#[test]
fn results_come_back_from_an_index_that_was_set_aside() {
    let t = Bench::new();
    for variant in 0..3 {
        ok(&t.bake(&plan(variant, 5)));
    }
    let before = cache::stats(&t.path("cache")).unwrap().unwrap();
    let index = t.path("cache/index-4.sqlite");
    let mut bytes = fs::read(&index).unwrap();
    // The head with the tables' names, and so every way to a row.
    bytes[..4096].fill(0x5a);
    fs::write(&index, bytes).unwrap();
    assert!(!t.verify().is_clean());
    assert_eq!(cache::stats(&t.path("cache")).unwrap().map_or(0, |s| s.runs), 0, "all is forgotten");
    // What is baked meanwhile is kept too.
    ok(&t.bake(&plan(4, 2)));
    let rebuilt = rebuild(&t);
    assert!(rebuilt.runs >= before.runs && rebuilt.values >= before.values, "{before:?} {rebuilt:?}");
    for (variant, elements) in [(0, 5), (1, 5), (2, 5), (4, 2)] {
        assert_eq!(ok(&t.bake(&plan(variant, elements))).runs(), 0, "variant {variant}");
    }
    assert!(!tree(&t.path("cache")).keys().any(|name| name.contains("damaged")), "what was read is not kept");
    assert!(t.verify().is_clean());
}

#[test]
fn what_leads_nowhere_is_dropped() {
    let t = Bench::new();
    ok(&t.bake(&plan(0, 5)));
    let before = tree(&t.path("out"));
    let values: Vec<String> = tree(&t.path("cache/values")).into_keys().collect();
    fs::remove_file(t.path("cache/values").join(&values[0])).unwrap();
    let path = t.path("cache/values").join(&values[1]);
    fs::remove_file(&path).unwrap();
    fs::write(&path, "spoilt").unwrap();
    let rebuilt = rebuild(&t);
    assert!(rebuilt.bad.len() == 1 && rebuilt.dropped_records >= 2, "{rebuilt:?}");
    assert!(rebuilt.bad[0].contains(values[1].rsplit('/').next().unwrap()), "{rebuilt:?}");
    assert!(t.verify().is_clean());
    fs::remove_dir_all(t.path("out")).unwrap();
    let report = t.bake(&plan(0, 5));
    assert!(ok(&report).runs() > 0 && report.hits() > 0);
    assert_eq!(tree(&t.path("out")), before);
}

#[test]
fn an_index_that_is_gone_leaves_the_values() {
    let t = Bench::new();
    ok(&t.bake(&plan(0, 5)));
    for suffix in ["", "-wal", "-shm"] {
        let _ = fs::remove_file(t.path(&format!("cache/index-4.sqlite{suffix}")));
    }
    let files = tree(&t.path("cache/values")).len() as u64;
    let rebuilt = rebuild(&t);
    assert_eq!((rebuilt.runs, rebuilt.values), (0, files));
    assert!(t.verify().is_clean());
    ok(&t.bake(&plan(0, 5)));
    // Values that no result leads to go with the next sweep.
    t.gc(&nothing_kept());
    assert!(tree(&t.path("cache/values")).is_empty());
}

#[test]
fn no_cache_and_a_cache_at_work_are_left_alone() {
    let t = Bench::new();
    assert_eq!(cache::rebuild(&t.path("cache"), &Stop::default()).unwrap(), None);
    assert!(!t.path("cache").exists());
    ok(&t.bake(&plan(0, 2)));
    let open = cache::Cache::open(&t.path("cache"), true).unwrap();
    let e = cache::rebuild(&t.path("cache"), &Stop::default()).unwrap_err().to_string();
    assert!(e.contains("a bake is at work"), "{e}");
    drop(open);
    let stop = Stop::default();
    stop.set();
    assert_eq!(cache::rebuild(&t.path("cache"), &stop).unwrap_err().exit_code(), 130);
    assert_eq!(ok(&t.bake(&plan(0, 2))).runs(), 0, "an interrupted rebuild changes nothing");
}
