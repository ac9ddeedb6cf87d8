//! A bake may be killed at any moment: the cache stays sound, and the next bake gives what an undisturbed one gives.

use super::{Bench, ok, support::*, tree};
use farfield::{
    engine::{bake::bake, cache, events::Silent, plan::Plan},
    math::Stop,
};
use serde_json::json;
use std::{
    process::{Command, Stdio},
    time::Duration,
};

const CHILD: &str = "FARFIELD_TEST_KILL_CHILD";

/// Small and large values, lists, a published file per element. Each `variant` has work of its own.
fn plan(variant: i64) -> Plan {
    let mut b = Builder::default();
    let names: Vec<String> = (0..12).map(|i| format!("n{i}")).collect();
    let values: Vec<i64> = (0..12).map(|i| i + 12 * variant).collect();
    let list = b.node::<MakeList>("list", json!({ "names": names, "values": values }), &[]);
    let slow = b.node::<Slow>("slow", json!({ "ms": 2 }), &[From::Node(list)]);
    if variant % 2 != 0 {
        b.transient(slow);
    }
    let square = b.node::<Square>("square", json!({ "pad": 60_000 }), &[From::Node(slow)]);
    let sum = b.node::<Sum>("sum", json!({}), &[From::Node(square)]);
    let each = b.node::<Print>("each", json!({}), &[From::Node(square)]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
    b.file("each/{name}.txt", each);
    b.file("sum.txt", print);
    b.plan()
}

/// Not a test of its own: what the test below runs and kills.
#[test]
fn child() {
    let Ok(spec) = std::env::var(CHILD) else { return };
    let (variant, folder) = spec.split_once(' ').unwrap();
    let options = farfield::engine::bake::Options {
        jobs: 2,
        ..farfield::engine::bake::Options::new(format!("{folder}/cache"), format!("{folder}/out"))
    };
    bake(&plan(variant.parse().unwrap()), &options, &Stop::default(), &Silent).unwrap();
}

/// `FARFIELD_KILLS` says how often; 8 by default.
#[test]
fn killed_bakes_leave_a_sound_cache() {
    let kills: i64 = std::env::var("FARFIELD_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(8);
    let (t, clean) = (Bench::new(), Bench::new());
    let mut interrupted = 0;
    for i in 0..kills {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "kills::child"])
            .env(CHILD, format!("{i} {}", t.path("").display()))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // Moments spread over start, runs and publication by a multiplicative sequence.
        std::thread::sleep(Duration::from_micros(3_000 + (i as u64 * 61_803) % 90_000));
        interrupted += i32::from(child.try_wait().unwrap().is_none());
        child.kill().unwrap();
        child.wait().unwrap();
        // None where the child was killed before it made a cache.
        let found = cache::verify(&t.path("cache"), &Stop::default()).unwrap();
        assert!(found.as_ref().is_none_or(cache::Verified::is_clean), "kill {i}: {found:?}");
        ok(&t.bake(&plan(i)));
        ok(&clean.bake(&plan(i)));
        assert_eq!(tree(&t.path("out")), tree(&clean.path("out")), "kill {i}");
    }
    assert!(interrupted > 0, "every child was done before it could be killed");
}
