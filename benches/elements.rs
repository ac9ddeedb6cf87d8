//! What many elements cost: a chain of three mapped nodes over trivial elements, baked first, again, and with one element
//! changed, each size in a process of its own, so that the peak of its memory is its own too. Run with
//! `cargo bench --bench elements`.

#[path = "../tests/engine/support.rs"]
#[expect(dead_code, reason = "the tests use more kinds")]
mod support;

use farfield::{
    engine::{
        bake::{Options, bake, peak_memory},
        cache,
        events::Silent,
        plan::Plan,
    },
    math::Stop,
};
use serde_json::json;
use std::{
    process::{Command, ExitCode},
    time::Instant,
};
use support::{Add, Builder, From, MakeMany, Print, Square, Sum};

const SIZES: [i64; 3] = [33_000, 66_000, 133_000];
/// Measurements of which the median is told.
const TIMES: i64 = 5;

fn plan(count: i64, changed: i64, transient: bool) -> Plan {
    let mut b = Builder::default();
    let list = b.node::<MakeMany>("list", json!({ "count": count, "changed": changed }), &[]);
    let first = b.node::<Square>("first", json!({}), &[From::Node(list)]);
    let second = b.node::<Add>("second", json!({ "plus": 1 }), &[From::Node(first), From::Node(list)]);
    let third = b.node::<Square>("third", json!({}), &[From::Node(second)]);
    let sum = b.node::<Sum>("sum", json!({}), &[From::Node(third)]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
    b.file("sum.txt", print);
    if transient {
        b.transient(first);
        b.transient(second);
    }
    b.plan()
}

/// One size, measured by this process.
fn measure(count: i64, transient: bool) {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let options = Options::new(dir.path().join("cache"), dir.path().join("out"));
    let once = |changed: i64| {
        let plan = plan(count, changed, transient);
        let began = Instant::now();
        let report = bake(&plan, &options, &Stop::default(), &Silent).expect("a bake");
        assert!(report.errors.is_empty(), "{:?}", report.errors);
        (began.elapsed().as_secs_f64(), report.runs())
    };
    let before = peak_memory().unwrap_or(0);
    let (first, runs) = once(-1);
    let peak = peak_memory().unwrap_or(0);
    let repeat = |changes: bool| {
        let mut times: Vec<_> = (0..TIMES).map(|i| once(if changes { i * 2 + 3 } else { -1 })).collect();
        times.sort_by(|a, b| a.0.total_cmp(&b.0));
        times[times.len() / 2]
    };
    let (noop, none) = repeat(false);
    assert_eq!(none, 0, "a bake without a change runs nothing");
    let (change, changed) = repeat(true);
    let stats = cache::stats(&options.cache).expect("a cache").expect("a cache");
    println!(
        "{count} elements{}: first bake {first:.2} s ({runs} runs), no-op {:.1} ms, one change {:.1} ms ({changed} runs); \
         peak memory {:.0} MiB, {:.0} bytes for each element of each node; index {:.0} MiB",
        if transient { ", transient" } else { "" },
        noop * 1e3,
        change * 1e3,
        peak as f64 / f64::from(1 << 20),
        (peak - before) as f64 / (3 * count) as f64,
        stats.index_bytes as f64 / f64::from(1 << 20)
    );
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    if let Some(count) = words.first().and_then(|w| w.parse().ok()) {
        measure(count, words.get(1).is_some_and(|w| w == "transient"));
        return ExitCode::SUCCESS;
    }
    let this = std::env::current_exe().expect("a path of this program");
    for count in SIZES {
        for transient in ["kept", "transient"] {
            let ran =
                Command::new(&this).args([&count.to_string(), transient]).status().expect("a program that starts");
            assert!(ran.success());
        }
    }
    ExitCode::SUCCESS
}
