//! What a cache survives: damage, sweeps, other processes.

use super::{Bench, counts, ok, ran, squares, support::*, tree};
use farfield::{
    engine::{
        bake::{Outcome, bake},
        cache,
        events::{Event, Events, Silent},
    },
    math::Stop,
};
use serde_json::json;
use std::{fs, time::Duration};

#[test]
fn a_bad_value_is_set_aside_and_made_again() {
    let t = Bench::new();
    let values: Vec<i64> = (1..6).collect();
    // Large values: files. A changed consumer must read them.
    ok(&t.bake(&squares(&values, 100_000)));
    let before = tree(&t.path("out"));
    let mut spoilt = 0;
    for (name, bytes) in tree(&t.path("cache/values")) {
        if bytes.len() > 90_000 && spoilt < 2 {
            let path = t.path("cache/values").join(name);
            fs::remove_file(&path).unwrap();
            if spoilt == 0 {
                fs::write(&path, &bytes[1..]).unwrap();
            }
            spoilt += 1;
        }
    }
    assert_eq!(spoilt, 2);
    assert_eq!(ok(&t.bake(&squares(&values, 100_000))).runs(), 0, "nobody reads them");
    let r = t.bake_with(&squares(&values, 100_000), |o| o.force = vec!["sum".into()]);
    assert_eq!((counts(ok(&r))["square"], counts(&r)["sum"], r.warnings), ((3, 2), (0, 1), 2));
    assert_eq!(tree(&t.path("out")), before);
    assert!(t.verify().is_clean());
}

#[test]
fn a_run_that_is_repeated_mends_all_its_values() {
    let t = Bench::new();
    let mut b = Builder::default();
    let list = b.node::<Padded>("list", json!({ "count": 3, "pad": 50_000 }), &[]);
    let sum = b.node::<Sum>("sum", json!({}), &[From::Node(list)]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
    b.file("sum.txt", print);
    let plan = b.plan();
    ok(&t.bake(&plan));
    // Of the same length, and not seen by who decodes it: only its hash tells.
    for (name, mut bytes) in tree(&t.path("cache/values")) {
        *bytes.last_mut().unwrap() ^= 1;
        let path = t.path("cache/values").join(name);
        fs::remove_file(&path).unwrap();
        fs::write(&path, bytes).unwrap();
    }
    let r = t.bake_with(&plan, |o| o.force = vec!["list".into()]);
    assert_eq!(counts(ok(&r))["list"], (0, 1));
    assert!(t.verify().is_clean());
}

#[test]
fn a_small_value_that_is_gone_is_made_again_when_it_is_wanted() {
    let t = Bench::new();
    let plan = |changed: i64, pad: u32| {
        let mut b = Builder::default();
        let list = b.node::<MakeMany>("list", json!({ "count": 50, "changed": changed }), &[]);
        let square = b.node::<Square>("square", json!({ "pad": pad }), &[From::Node(list)]);
        let sum = b.node::<Sum>("sum", json!({}), &[From::Node(square)]);
        let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
        b.file("sum.txt", print);
        b.plan()
    };
    let sum = |changed: i64| (0..50).map(|i| if i == changed { 1 } else { i * i }).sum::<i64>();
    ok(&t.bake(&plan(3, 0)));
    let db = rusqlite::Connection::open(t.path("cache/index-4.sqlite")).unwrap();
    assert!(db.execute("DELETE FROM value WHERE rowid % 3 = 0", []).unwrap() > 20);
    drop(db);
    // The list is made anew, and most of its values were there before.
    ok(&t.bake(&plan(4, 0)));
    assert_eq!(t.file("sum.txt"), format!("{}\n", sum(4)));
    // Every value is wanted.
    let r = t.bake(&plan(4, 1));
    assert!(ok(&r).warnings > 0, "{r:?}");
    assert_eq!(t.file("sum.txt"), format!("{}\n", sum(4)));
    assert_eq!(ok(&t.bake(&plan(4, 2))).warnings, 0);
}

#[test]
fn verify_finds_what_is_spoilt() {
    let t = Bench::new();
    let plan = squares(&[1, 2, 3], 100_000);
    t.bake(&plan);
    let clean = t.verify();
    assert!(clean.is_clean() && clean.values >= 8, "{clean:?}");
    let (name, _) = tree(&t.path("cache/values")).into_iter().next().unwrap();
    let path = t.path("cache/values").join(name);
    fs::remove_file(&path).unwrap();
    fs::write(&path, "spoilt").unwrap();
    let found = t.verify();
    assert_eq!(found.bad.len(), 1, "{found:?}");
    assert!(t.verify().is_clean());
    fs::remove_dir_all(t.path("out")).unwrap();
    ok(&t.bake(&plan));
}

#[test]
fn published_values_that_are_lost_are_made_again() {
    let t = Bench::new();
    let mut b = Builder::default();
    let c = b.node::<Constant>("c", json!({ "value": 3, "pad": 50_000 }), &[]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(c)]);
    b.file("out.txt", print);
    let plan = b.plan();
    t.bake(&plan);
    let before = tree(&t.path("out"));
    fs::remove_dir_all(t.path("cache/values")).unwrap();
    fs::remove_dir_all(t.path("out")).unwrap();
    let r = t.bake(&plan);
    assert_eq!(ok(&r).runs(), 2, "print's input is lost too");
    assert_eq!(tree(&t.path("out")), before);
}

#[test]
fn a_damaged_index_is_set_aside() {
    let t = Bench::new();
    let plan = squares(&(0..200).collect::<Vec<_>>(), 0);
    t.bake(&plan);
    let before = tree(&t.path("out"));
    let index = t.path("cache/index-4.sqlite");
    let good = fs::read(&index).unwrap();
    for (from, to) in [(0, 100), (100, 4096), (4096, good.len()), (good.len() / 2, good.len() / 2 + 3000)] {
        let mut bad = good.clone();
        bad[from..to].fill(0x5a);
        fs::write(&index, bad).unwrap();
        ok(&t.bake(&plan));
        assert_eq!(tree(&t.path("out")), before, "{from}..{to}");
    }
    fs::write(&index, &good[..good.len() / 2]).unwrap();
    ok(&t.bake(&squares(&(1..200).collect::<Vec<_>>(), 0)));
    ok(&t.bake(&plan));
    assert_eq!(tree(&t.path("out")), before);
}

#[test]
fn an_unusable_cache_is_a_clear_error() {
    let t = Bench::new();
    fs::write(t.path("cache"), "a file").unwrap();
    let e = bake(&squares(&[1], 0), &t.options(), &Stop::default(), &Silent).unwrap_err();
    assert!(e.exit_code() == 2 && e.to_string().contains("--cache"), "{e}");
    assert!(!t.path("out").exists());
}

#[test]
fn gc_keeps_what_records_lead_to() {
    let t = Bench::new();
    let (old, new) = (squares(&[1, 2, 3], 50_000), squares(&[1, 2, 4], 50_000));
    t.bake(&old);
    let all = cache::Limits { max_bytes: Some(0), ..Default::default() };
    assert_eq!(t.gc(&all).runs, 0);
    // Twenty further records push the first out.
    for i in 0..20 {
        t.bake(&squares(&[1, 2, 4, 100 + i], 50_000));
    }
    t.bake(&new);
    let removed = t.gc(&all);
    assert!(removed.runs > 0 && removed.values > 0 && removed.bytes > 40_000, "{removed:?}");
    assert_eq!(ok(&t.bake(&new)).runs(), 0);
    assert!(t.verify().is_clean());
    let r = t.bake(&old);
    assert!(ran(ok(&r)).contains(&"square"), "{:?}", counts(&r));
    let stats = cache::stats(&t.path("cache")).unwrap().unwrap();
    assert!(stats.bakes == 23 && stats.values > 10 && stats.runs > 10, "{stats:?}");
}

#[test]
fn two_bakes_of_one_cache_share_the_work() {
    let t = Bench::new();
    let mut b = Builder::default();
    let names: Vec<String> = (0..10).map(|i| format!("n{i}")).collect();
    let list = b.node::<MakeList>("list", json!({ "names": names, "values": (0..10).collect::<Vec<_>>() }), &[]);
    let slow = b.node::<Slow>("slow", json!({ "ms": 20 }), &[From::Node(list)]);
    let sum = b.node::<Sum>("sum", json!({}), &[From::Node(slow)]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
    b.file("sum.txt", print);
    let plan = b.plan();
    let (a, c) = std::thread::scope(|s| {
        let a = s.spawn(|| t.bake(&plan));
        let c = s.spawn(|| t.bake(&plan));
        (a.join().unwrap(), c.join().unwrap())
    });
    // Locks are advisory: nearly all of the work is shared.
    assert!(ok(&a).runs() + ok(&c).runs() <= 16, "{} + {}", a.runs(), c.runs());
    assert_eq!(t.file("sum.txt"), "45\n");
}

#[test]
fn gc_by_age_takes_what_was_not_used_for_so_long() {
    let t = Bench::new();
    let old = squares(&[1, 2, 3], 50_000);
    t.bake(&old);
    for i in 0..20 {
        t.bake(&squares(&[1, 2, 4, 100 + i], 50_000));
    }
    let older_than = |seconds| cache::Limits { max_age: Some(Duration::from_secs(seconds)), ..Default::default() };
    assert_eq!(t.gc(&older_than(3600)).runs, 0);
    std::thread::sleep(Duration::from_millis(2100));
    let removed = t.gc(&older_than(1));
    assert!(removed.runs > 0 && removed.bytes > 40_000, "{removed:?}");
    // What the records of the last bakes lead to stays, however old.
    assert_eq!(ok(&t.bake(&squares(&[1, 2, 4, 119], 50_000))).runs(), 0);
    assert!(counts(&t.bake(&old))["square"].1 > 0);
    assert!(t.verify().is_clean());
}

#[test]
fn gc_beside_a_living_bake_takes_nothing_from_it() {
    let t = Bench::new();
    let mut b = Builder::default();
    let names: Vec<String> = (0..10).map(|i| format!("n{i}")).collect();
    let list = b.node::<MakeList>("list", json!({ "names": names, "values": (0..10).collect::<Vec<_>>() }), &[]);
    let slow = b.node::<Slow>("slow", json!({ "ms": 40 }), &[From::Node(list)]);
    let large = b.node::<Square>("large", json!({ "pad": 50_000 }), &[From::Node(slow)]);
    let sum = b.node::<Sum>("sum", json!({}), &[From::Node(large)]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
    b.file("sum.txt", print);
    let plan = b.plan();
    let all = cache::Limits { max_bytes: Some(0), max_age: Some(Duration::ZERO), ..Default::default() };
    let sweeps = std::thread::scope(|s| {
        let bake = s.spawn(|| t.bake(&plan));
        let mut sweeps = 0;
        while !bake.is_finished() {
            if t.path("cache/claims").is_dir() {
                cache::gc(&t.path("cache"), &all).unwrap();
                sweeps += 1;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        let report = bake.join().unwrap();
        assert_eq!((ok(&report).runs(), report.warnings), (23, 0), "{:?}", counts(&report));
        sweeps
    });
    assert!(sweeps > 3, "{sweeps}");
    assert_eq!(t.file("sum.txt"), "285\n");
    assert_eq!(ok(&t.bake(&plan)).runs(), 0);
    assert!(t.verify().is_clean());
}

#[test]
fn bakes_that_begin_at_once_make_one_cache() {
    for _ in 0..10 {
        let t = Bench::new();
        let plan = squares(&[1, 2, 3], 0);
        std::thread::scope(|s| {
            let bakes: Vec<_> = (0..4).map(|_| s.spawn(|| t.bake(&plan))).collect();
            for bake in bakes {
                ok(&bake.join().unwrap());
            }
        });
    }
}

#[test]
fn a_value_that_cannot_be_read_is_made_again() {
    let t = Bench::new();
    ok(&t.bake(&squares(&[1, 2, 3], 100_000)));
    let before = tree(&t.path("out"));
    let large = || tree(&t.path("cache/values")).into_iter().filter(|(_, bytes)| bytes.len() > 90_000);
    let names: Vec<String> = large().map(|(name, _)| name).collect();
    let mut spoilt = 0;
    for name in names.iter().take(2) {
        let path = t.path("cache/values").join(name);
        fs::remove_file(&path).unwrap();
        // A folder with something in it cannot be read, nor replaced by a file.
        fs::create_dir_all(path.join("inner")).unwrap();
        spoilt += 1;
    }
    let r = t.bake_with(&squares(&[1, 2, 3], 100_000), |o| o.force = vec!["sum".into()]);
    assert_eq!((counts(ok(&r))["square"].1, r.warnings), (spoilt, spoilt as usize));
    assert_eq!(tree(&t.path("out")), before);
    assert!(t.verify().is_clean());
    assert_eq!(ok(&t.bake(&squares(&[1, 2, 3], 100_000))).warnings, 0);
}

#[cfg(unix)]
#[test]
fn a_value_that_is_a_pipe_or_a_link_is_made_again() {
    let t = Bench::new();
    let plan = squares(&[1, 2], 100_000);
    ok(&t.bake(&plan));
    let precious = t.path("precious");
    fs::write(&precious, "precious").unwrap();
    let names: Vec<String> =
        tree(&t.path("cache/values")).into_iter().filter(|(_, b)| b.len() > 90_000).map(|(name, _)| name).collect();
    assert!(names.len() >= 2);
    for (name, pipe) in names.iter().zip([true, false]) {
        let path = t.path("cache/values").join(name);
        fs::remove_file(&path).unwrap();
        if pipe {
            assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        } else {
            std::os::unix::fs::symlink(&precious, &path).unwrap();
        }
    }
    let r = t.bake_with(&plan, |o| o.force = vec!["sum".into()]);
    assert_eq!((counts(ok(&r))["square"].1, r.warnings), (2, 2));
    assert_eq!(fs::read(&precious).unwrap(), b"precious");
}

#[test]
fn what_a_sweep_left_behind_goes_with_the_next() {
    let t = Bench::new();
    ok(&t.bake(&squares(&[1, 2, 3], 50_000)));
    // As after a kill between the sweep's decision and its deletions: files that no row leads to.
    let db = rusqlite::Connection::open(t.path("cache/index-4.sqlite")).unwrap();
    db.execute_batch("DELETE FROM bake; DELETE FROM run; DELETE FROM map; DELETE FROM value;").unwrap();
    drop(db);
    assert!(!tree(&t.path("cache/values")).is_empty());
    let removed = t.gc(&cache::Limits::default());
    assert!(removed.bytes > 100_000, "{removed:?}");
    assert!(tree(&t.path("cache/values")).is_empty());
    ok(&t.bake(&squares(&[1, 2, 3], 50_000)));
}

#[test]
fn a_sweep_that_fails_deletes_no_file() {
    let t = Bench::new();
    ok(&t.bake(&squares(&[1, 2, 3], 50_000)));
    let before = tree(&t.path("cache/values"));
    // A sweep that cannot write to the index.
    let db = rusqlite::Connection::open(t.path("cache/index-4.sqlite")).unwrap();
    db.execute_batch("CREATE TRIGGER no BEFORE DELETE ON value BEGIN SELECT RAISE(FAIL, 'no'); END;").unwrap();
    drop(db);
    let limits = cache::Limits { max_bytes: Some(0), keep_bakes: Some(0), ..Default::default() };
    let swept = t.gc(&limits);
    // The index is none of ours any more: it is set aside, and only then files go.
    assert!(swept.damaged.is_some() && !before.is_empty(), "{swept:?}");
    ok(&t.bake(&squares(&[1, 2, 3], 50_000)));
    assert!(t.verify().is_clean());
}

#[test]
fn gc_says_what_bake_records_keep_and_may_drop_them() {
    let t = Bench::new();
    for i in 0..3 {
        t.bake(&squares(&[1, 2, 3 + i], 50_000));
    }
    let kept = t.gc(&cache::Limits { max_bytes: Some(1000), ..Default::default() });
    assert!(kept.runs == 0 && kept.left_bytes > 1000 && kept.kept_bytes == kept.left_bytes, "{kept:?}");
    assert_eq!((kept.kept_bakes, kept.living), (3, false));
    let one = t.gc(&cache::Limits { max_bytes: Some(1000), keep_bakes: Some(1), ..Default::default() });
    assert!(one.runs > 0 && one.bytes > 90_000 && one.kept_bakes == 1, "{one:?}");
    assert_eq!(ok(&t.bake(&squares(&[1, 2, 5], 50_000))).runs(), 0);
    let none = t.gc(&cache::Limits { max_bytes: Some(1000), keep_bakes: Some(0), ..Default::default() });
    assert!(none.left_bytes <= 1000 && none.kept_bytes == 0, "{none:?}");
    assert!(tree(&t.path("cache/values")).is_empty());
    assert!(ok(&t.bake(&squares(&[1, 2, 5], 50_000))).runs() > 0);
}

#[test]
fn why_remembers_many_bakes() {
    let t = Bench::new();
    let plan = |value: i64| {
        let mut b = Builder::default();
        let c = b.node::<Constant>("c", json!({ "value": 1 }), &[]);
        let d = b.node::<Add>("d", json!({ "plus": value }), &[From::Node(c), From::Absent]);
        let print = b.node::<Print>("print", json!({}), &[From::Node(d)]);
        b.file("d.txt", print);
        b.plan()
    };
    for i in 0..40 {
        ok(&t.bake(&plan(i)));
    }
    let say = |what: &str| farfield::engine::why::why(&plan(39), &t.options(), what).unwrap();
    assert!(say("d").contains("parameter plus changed from 38 to 39"), "{}", say("d"));
    assert!(say("c").contains("(39 on record since it ran)"), "{}", say("c"));
    t.gc(&cache::Limits { keep_bakes: Some(2), ..Default::default() });
    assert!(say("c").contains("older records were dropped") && say("c").contains("last 2"), "{}", say("c"));
}

#[test]
fn who_waits_for_another_bake_says_so() {
    #[derive(Default)]
    struct Waits(std::cell::RefCell<Vec<(String, String)>>);
    impl Events for Waits {
        fn event(&self, event: &Event) {
            if let Event::Waiting { what, holder } = event {
                self.0.borrow_mut().push(((*what).to_owned(), (*holder).to_owned()));
            }
        }
    }
    let t = Bench::new();
    let mut b = Builder::default();
    let names = ["a", "b", "c"];
    let list = b.node::<MakeList>("list", json!({ "names": names, "values": [1, 2, 3] }), &[]);
    b.node::<Slow>("slow", json!({ "ms": 2500 }), &[From::Node(list)]);
    let plan = b.plan();
    let waits = std::thread::scope(|s| {
        s.spawn(|| t.bake_with(&plan, |o| o.jobs = 3));
        std::thread::sleep(Duration::from_millis(500));
        let waits = Waits::default();
        ok(&bake(&plan, &t.options(), &Stop::default(), &waits).unwrap());
        waits.0.into_inner()
    });
    assert_eq!(waits.len(), 1, "{waits:?}");
    assert!(waits[0].0.starts_with("slow/"), "{waits:?}");
    assert!(waits[0].1.starts_with(&format!("process {}", std::process::id())), "{waits:?}");
}

#[test]
fn an_audit_tells_what_it_found() {
    let t = Bench::new();
    let plan = squares(&[1, 2, 3], 50_000);
    ok(&t.bake(&plan));
    let r = t.bake_with(&plan, |o| o.audit = 1.0);
    let audit = ok(&r).audit.unwrap();
    assert_eq!((audit.runs, audit.different_runs, audit.different_bytes), (6, 0, 0));
    assert!(audit.bytes > 150_000, "{audit:?}");
    assert_eq!(t.bake(&plan).audit, None);
    // A kind that gives something else each time.
    let mut b = Builder::default();
    b.node::<Restless>("restless", json!({}), &[]);
    let plan = b.plan();
    ok(&t.bake(&plan));
    let r = t.bake_with(&plan, |o| o.audit = 1.0);
    let audit = r.audit.unwrap();
    assert!(r.outcome == Outcome::Failed && audit.runs == 1 && audit.different_runs == 1, "{r:?}");
    assert!((1..20).contains(&audit.different_bytes) && audit.different_bytes < audit.bytes, "{audit:?}");
}
