//! Reading needs no writing: what is in the cache serves although nothing can be written.

#![cfg(unix)]

use super::{Bench, ok, squares, tree};
use farfield::{
    engine::{
        bake::{Forecast, Options, Outcome, bake},
        cache,
        events::Silent,
        plan::Plan,
        why::why,
    },
    math::Stop,
};
use std::{fs, process::Command};

const CHILD: &str = "FARFIELD_TEST_READ_ONLY_CHILD";

fn plan() -> Plan {
    squares(&[1, 2, 3], 50_000)
}

fn options(folder: &str) -> Options {
    Options { jobs: 2, memory: 1 << 30, ..Options::new(format!("{folder}/cache"), format!("{folder}/out")) }
}

/// Not a test of its own: what the tests below run where nothing can be written.
#[test]
fn child() {
    let Ok(folder) = std::env::var(CHILD) else { return };
    let probe = std::path::Path::new(&folder).join("probe");
    assert!(fs::write(&probe, [0; 100_000]).is_err(), "this process can write");
    reads(&folder);
    let e = bake(&squares(&[1, 2, 4], 50_000), &options(&folder), &Stop::default(), &Silent);
    let text = e.map(|r| format!("{:?}", r.errors)).unwrap_or_else(|e| e.to_string());
    assert!(text.contains("cannot be written") || text.contains("disk is full"), "{text}");
}

/// All that must work without writing.
fn reads(folder: &str) {
    let (options, stop) = (options(folder), Stop::default());
    let r = bake(&plan(), &options, &stop, &Silent).unwrap();
    assert_eq!((r.outcome, r.runs()), (Outcome::Baked, 0), "{:?}", r.errors);
    let dry = Options { dry_run: true, ..options.clone() };
    let r = bake(&plan(), &dry, &stop, &Silent).unwrap();
    assert!(r.nodes.iter().all(|n| n.forecast == Some(Forecast::Hit)), "{r:?}");
    assert!(why(&plan(), &options, "sum").unwrap().starts_with("sum ran"));
    assert!(cache::stats(&options.cache).unwrap().unwrap().runs >= 6);
    assert!(cache::verify(&options.cache, &stop).unwrap().unwrap().is_clean());
}

/// Runs the child with a limit of 0 bytes for every file that it writes, which is as a full disk.
fn with_no_space(t: &Bench) -> std::process::Output {
    let run = "trap '' XFSZ; ulimit -f 0; exec \"$0\" --exact readonly::child";
    Command::new("sh").args(["-c", run]).arg(std::env::current_exe().unwrap()).env(CHILD, t.path("")).output().unwrap()
}

#[test]
fn a_full_disk_does_not_keep_hits_from_being_used() {
    let t = Bench::new();
    ok(&t.bake(&plan()));
    let before = tree(&t.path("out"));
    let child = with_no_space(&t);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(child.status.success(), "{} {}", text(&child.stdout), text(&child.stderr));
    assert!(text(&child.stdout).contains("1 passed"), "{}", text(&child.stdout));
    assert_eq!(tree(&t.path("out")), before);
    // With space again, nothing is lost and nothing is repeated.
    assert_eq!(ok(&t.bake(&plan())).runs(), 0);
    assert!(t.verify().is_clean());
}

/// What no process may do, root included: make a file where a file is in the way.
#[test]
fn a_cache_without_its_folders_for_writing_serves_what_it_has() {
    let t = Bench::new();
    ok(&t.bake(&plan()));
    // `claims` and `tmp` cannot take a file: their places in the folder are taken by folders.
    for n in 0..4 {
        let _ = fs::remove_file(t.path(&format!("cache/claims/{n}")));
        fs::create_dir_all(t.path(&format!("cache/claims/{n}"))).unwrap();
    }
    reads(&t.path("").to_string_lossy());
    let e = bake(&squares(&[1, 2, 4], 50_000), &t.options(), &Stop::default(), &Silent).unwrap_err();
    assert!(e.to_string().contains("cannot be written") && e.to_string().contains("--cache"), "{e}");
}
