//! A bake, a sweep and a rebuild may be killed at any moment: the cache stays sound, and the next bake gives what an undisturbed one gives.

use super::{
    Bench, cases,
    child::{Job, undisturbed},
    tree,
};
use farfield::{engine::cache, math::Stop};
use std::{process::Stdio, time::Instant};

const ELEMENTS: i64 = 12;

#[test]
fn killed_processes_leave_a_sound_cache() {
    let kills = cases(40, 4000);
    let (t, clean) = (Bench::new(), Bench::new());
    let mut interrupted = 0;
    // How long each job takes, from the start of the process.
    let took = |job: Job| {
        let began = Instant::now();
        assert!(job.command(&t.path("")).stderr(Stdio::null()).status().unwrap().success());
        began.elapsed()
    };
    let (bake, others) = (took(Job::Bake(0, ELEMENTS)), took(Job::Rebuild));
    for i in 0..kills {
        let variant = i as i64 % 7;
        let job = match i % 8 {
            3 => Job::Sweep,
            5 => Job::Rebuild,
            7 => Job::Verify,
            _ => Job::Bake(variant, ELEMENTS),
        };
        if matches!(job, Job::Bake(..)) && i % 4 != 2 {
            // What is there already is not made again: most bakes have work from the start.
            std::fs::remove_dir_all(t.path("cache")).unwrap();
            std::fs::remove_dir_all(t.path(&format!("out-{variant}"))).ok();
        }
        let began = Instant::now();
        let mut child = job.command(&t.path("")).stderr(Stdio::null()).spawn().unwrap();
        // Moments spread over start, runs and publication by a multiplicative sequence.
        let whole = if matches!(job, Job::Bake(..)) { bake } else { others };
        let moment = whole.mul_f64((i as f64 * 0.618_034).fract() * 1.1);
        std::thread::sleep(moment.saturating_sub(began.elapsed()));
        interrupted += usize::from(child.try_wait().unwrap().is_none());
        child.kill().unwrap();
        child.wait().unwrap();
        // None where the child was killed before it made a cache.
        let found = cache::verify(&t.path("cache"), &Stop::default()).unwrap();
        assert!(found.as_ref().is_none_or(cache::Verified::is_clean), "kill {i}, {job:?}: {found:?}");
        undisturbed(&t, variant, ELEMENTS);
        undisturbed(&clean, variant, ELEMENTS);
        let out = format!("out-{variant}");
        assert_eq!(tree(&t.path(&out)), tree(&clean.path(&out)), "kill {i}, {job:?}");
    }
    println!("{kills} kills, {interrupted} of them before the end");
    assert!(interrupted > 0, "every child was done before it could be killed");
}
