//! Every call that changes a file fails once, in a bake, a sweep, a check and a rebuild; the disk fills up at every moment; the process dies at every call.
//! A library that is loaded before the system's counts the calls of a child and lets one of them fail, so SQLite's own writes fail too and the
//! program needs no hooks.

#![cfg(target_os = "linux")]

use super::{
    Bench, cases,
    child::{ELEMENTS, Job, TOLD, undisturbed},
    copy, spread, tree,
};
use farfield::{engine::cache, math::Stop};
use std::{
    fs,
    os::unix::process::ExitStatusExt as _,
    path::PathBuf,
    process::Command,
    sync::{
        LazyLock,
        atomic::{AtomicUsize, Ordering},
    },
};

/// The library, built once.
static LIBRARY: LazyLock<(tempfile::TempDir, PathBuf)> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let (source, library) = (folder.path().join("fault.c"), folder.path().join("fault.so"));
    fs::write(&source, include_str!("fault.c")).unwrap();
    let build = |compiler: &str| {
        let mut command = Command::new(compiler);
        command.args(["-shared", "-fPIC", "-O1", "-o"]).args([&library, &source]).arg("-ldl").output()
    };
    let built = build("cc").or_else(|_| build("gcc")).expect("a C compiler, as the program itself needs");
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    (folder, library)
});

/// What happens to the child's n-th call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Eio,
    Enospc,
    Full,
    Kill,
    Read,
}

/// What was there before, and what the child does.
#[derive(Clone, Copy, Debug)]
struct Case {
    /// Variants that were baked.
    before: &'static [i64],
    /// Whether a value and the index were damaged then.
    damaged: bool,
    job: Job,
    /// The variant that is baked afterwards.
    after: i64,
}

const CASES: [Case; 6] = [
    Case { before: &[], damaged: false, job: Job::Bake(0, ELEMENTS), after: 0 },
    // Another bake into the same folder replaces and removes files.
    Case { before: &[1], damaged: false, job: Job::Bake(1, ELEMENTS + 1), after: 1 },
    Case { before: &[0, 1], damaged: false, job: Job::Sweep, after: 1 },
    Case { before: &[0], damaged: true, job: Job::Verify, after: 0 },
    Case { before: &[0], damaged: false, job: Job::Rebuild, after: 0 },
    Case { before: &[0], damaged: true, job: Job::Bake(0, ELEMENTS), after: 0 },
];

impl Case {
    fn elements(self) -> i64 {
        if let Job::Bake(_, elements) = self.job { elements } else { ELEMENTS }
    }

    /// The folder as the child finds it.
    fn prepare(self) -> Bench {
        let t = Bench::new();
        for variant in self.before {
            undisturbed(&t, *variant, ELEMENTS);
        }
        if self.damaged {
            let (name, _) = tree(&t.path("cache/values")).into_iter().next().unwrap();
            let path = t.path("cache/values").join(name);
            fs::remove_file(&path).unwrap();
            fs::write(&path, "spoilt").unwrap();
            let index = t.path("cache/index-4.sqlite");
            let mut bytes = fs::read(&index).unwrap();
            bytes[4096..4100].fill(0x5a);
            fs::write(&index, bytes).unwrap();
        }
        t
    }
}

/// What the library said, and how the child ended.
struct Ended {
    fault: Option<String>,
    counted: usize,
    code: Option<i32>,
    signal: Option<i32>,
    said: String,
}

fn run(t: &Bench, job: Job, mode: Mode, n: usize) -> Ended {
    let log = t.path("log");
    let mode = format!("{mode:?}").to_lowercase();
    let mut command = job.command(&t.path(""));
    let fault = format!("{mode} {n} {} {}", t.path("cache").parent().unwrap().display(), log.display());
    let output = command.env("LD_PRELOAD", &LIBRARY.1).env("FARFIELD_FAULT", fault).output().unwrap();
    let text = fs::read_to_string(&log).unwrap_or_default();
    let _ = fs::remove_file(&log);
    let line = |counted: bool| text.lines().find(|l| l.starts_with("counted ") == counted);
    Ended {
        fault: line(false).map(str::to_owned),
        counted: line(true).map_or(0, |l| l[8..].parse().unwrap()),
        code: output.status.code(),
        signal: output.status.signal(),
        said: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// One fault, and what must hold after it. Gives whether there was one.
fn suffers(case: Case, template: &Bench, clean: &Bench, mode: Mode, n: usize) -> bool {
    let t = Bench::new();
    copy(&template.path(""), &t.path(""));
    let ended = run(&t, case.job, mode, n);
    let Ended { fault, code, signal, said, .. } = &ended;
    let Some(fault) = fault else { return false };
    let what = format!("{case:?}, {mode:?} at call {n}: {fault}\n{said}");
    let told = said.lines().find_map(|l| l.strip_prefix("told: "));
    match (mode, code, signal) {
        (Mode::Kill, None, Some(9)) => {}
        (Mode::Kill, ..) => panic!("not killed: {what}"),
        (_, Some(0), _) => {}
        (_, Some(code), _) if *code == TOLD => {
            // What could not be read or written is named.
            let folder = t.path("").to_string_lossy().trim_end_matches('/').to_owned();
            assert!(told.is_some_and(|told| told.contains(&folder)), "no file is named: {what}");
        }
        _ => panic!("{code:?} {signal:?}: {what}"),
    }
    let found = cache::verify(&t.path("cache"), &Stop::default()).unwrap_or_else(|e| panic!("{e}: {what}"));
    assert!(case.damaged || found.as_ref().is_none_or(cache::Verified::is_clean), "{found:?} after {what}");
    undisturbed(&t, case.after, case.elements());
    let out = format!("out-{}", case.after);
    let (is, should) = (tree(&t.path(&out)), tree(&clean.path(&out)));
    assert!(is == should, "{what}\n{:?}\n{:?}", is.keys().collect::<Vec<_>>(), should.keys().collect::<Vec<_>>());
    let found = t.verify();
    assert!(found.is_clean(), "{found:?} after {what}");
    // Nothing is left of what was under way.
    assert!(
        !is.keys().any(|name| name.contains("farfield-tmp") || name.contains("pending")),
        "{what}: {:?}",
        is.keys()
    );
    true
}

fn all(mode: Mode, short: usize) {
    let (faults, calls) = (AtomicUsize::new(0), AtomicUsize::new(0));
    for (turn, case) in CASES.into_iter().enumerate() {
        let template = case.prepare();
        let clean = Bench::new();
        for variant in case.before {
            undisturbed(&clean, *variant, ELEMENTS);
        }
        undisturbed(&clean, case.after, case.elements());
        let count = Bench::new();
        copy(&template.path(""), &count.path(""));
        let ended = run(&count, case.job, mode, usize::MAX >> 1);
        assert_eq!(ended.code, Some(0), "{case:?}: {}", ended.said);
        assert!(ended.counted > 5, "{case:?}: {} calls were counted", ended.counted);
        calls.fetch_add(ended.counted, Ordering::Relaxed);
        // How many calls there are varies a little with the order of threads.
        let last = ended.counted + 8;
        let numbers: Vec<usize> = spread(last, cases(short, last), turn).map(|n| n + 1).collect();
        let next = AtomicUsize::new(0);
        std::thread::scope(|s| {
            for _ in 0..2 {
                s.spawn(|| {
                    while let Some(n) = numbers.get(next.fetch_add(1, Ordering::Relaxed)) {
                        let hit = suffers(case, &template, &clean, mode, *n);
                        faults.fetch_add(usize::from(hit), Ordering::Relaxed);
                    }
                });
            }
        });
    }
    let (faults, calls) = (faults.into_inner(), calls.into_inner());
    println!("{mode:?}: {faults} faults at {calls} calls");
    assert!(faults >= short * CASES.len() / 2, "{faults} faults");
}

#[test]
fn a_call_that_fails_is_told_and_mended() {
    all(Mode::Eio, 8);
}

#[test]
fn a_call_without_space_is_told_and_mended() {
    all(Mode::Enospc, 5);
}

#[test]
fn a_full_disk_is_told_and_loses_nothing() {
    all(Mode::Full, 8);
}

#[test]
fn a_process_that_ends_at_any_call_leaves_a_sound_cache() {
    all(Mode::Kill, 8);
}

#[test]
fn a_read_that_fails_is_told_and_mended() {
    all(Mode::Read, 4);
}
