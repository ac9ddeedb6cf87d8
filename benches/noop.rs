//! What a bake costs in which nothing, or one thing, changed: the engine alone, without the process and the pipeline
//! file. Run with `cargo bench --bench noop`; prints the median of several bakes in milliseconds.

#[path = "../tests/engine/support.rs"]
#[expect(dead_code, reason = "the tests use more kinds")]
mod support;

use farfield::{
    engine::{
        bake::{Options, bake},
        events::Silent,
        plan::Plan,
    },
    math::Stop,
};
use serde_json::json;
use std::time::Instant;
use support::*;

/// Layers of 100 nodes; every node adds two of the layer above. `changed`: another parameter at one node of the last
/// layer but four.
fn graph(nodes: usize, changed: i64) -> Plan {
    let mut b = Builder::default();
    let mut above: Vec<usize> = Vec::new();
    for layer in 0..nodes / 100 {
        let mut this = Vec::new();
        for i in 0..100 {
            let name = format!("n{layer}-{i}");
            this.push(match above.get(i) {
                None => b.node::<Constant>(&name, json!({ "value": i }), &[]),
                Some(from) => {
                    let plus = if layer + 5 == nodes / 100 && i == 0 { changed * 100_000 } else { 0 };
                    b.node::<Add>(&name, json!({ "plus": plus }), &[From::Node(*from), From::Absent])
                }
            });
        }
        above = this;
    }
    let print = b.node::<Print>("print", json!({}), &[From::Node(above[0])]);
    b.file("out.txt", print);
    b.plan()
}

/// A map of `n` elements and a sum.
fn map(n: usize, changed: i64) -> Plan {
    let mut b = Builder::default();
    let list = b.node::<MakeMany>("list", json!({ "count": n, "changed": changed }), &[]);
    let square = b.node::<Square>("square", json!({}), &[From::Node(list)]);
    let sum = b.node::<Sum>("sum", json!({}), &[From::Node(square)]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
    b.file("out.txt", print);
    b.plan()
}

fn measure(name: &str, plan: impl Fn(i64) -> Plan) {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let options = Options::new(dir.path().join("cache"), dir.path().join("out"));
    let once = |plan: &Plan| {
        let (began, cpu) = (Instant::now(), cpu());
        let report = bake(plan, &options, &Stop::default(), &Silent).expect("a bake");
        assert!(report.errors.is_empty(), "{:?}", report.errors);
        ([began.elapsed().as_secs_f64() * 1e3, self::cpu() - cpu], report.runs())
    };
    let median = |times: &[[f64; 2]], column: usize| {
        let mut times: Vec<f64> = times.iter().map(|t| t[column]).collect();
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    let same = plan(0);
    let (first, runs) = once(&same);
    let mut noop = Vec::new();
    for _ in 0..7 {
        let (ms, runs) = once(&same);
        assert_eq!(runs, 0);
        noop.push(ms);
    }
    let (mut change, mut ran) = (Vec::new(), 0);
    for i in 1..8 {
        let (ms, runs) = once(&plan(i));
        change.push(ms);
        ran = runs;
    }
    println!("{name:<14} first {:8.1} ms ({runs} runs)", first[0]);
    for (what, times, runs) in [("no-op", noop, 0), ("one change", change, ran)] {
        let (wall, cpu) = (median(&times, 0), median(&times, 1));
        println!("{name:<14} {what:<10} {wall:6.1} ms, of which its thread computed {cpu:6.1} ms ({runs} runs)");
    }
}

/// Milliseconds that this thread has computed; 0 where the system does not tell. On a busy machine it is the figure
/// that can be compared.
fn cpu() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).unwrap_or(0.0) / 1e6
}

fn main() {
    if let Some(n) = std::env::args().nth(1).and_then(|a| a.parse().ok()) {
        return measure(&format!("{n} nodes"), |changed| graph(n, changed));
    }
    for n in [1_000, 10_000] {
        measure(&format!("{n} nodes"), |changed| graph(n, changed));
    }
    for n in [1_000, 10_000, 100_000] {
        measure(&format!("map of {n}"), |changed| map(n, changed));
    }
}
