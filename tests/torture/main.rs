//! What no user does on purpose and every disk does once: kills, failing writes, full disks, flipped bytes, stopped processes, edits within one tick of
//! the clock, kinds that break their promise, files made of rubbish.
//!
//! `cargo test --test torture` runs the short form. `FARFIELD_TORTURE=10` runs ten times as many cases, `FARFIELD_TORTURE=long` all of them.

#[path = "../engine/bench.rs"]
#[expect(dead_code, reason = "the tests of the engine use more")]
mod bench;
mod child;
mod edits;
mod faults;
mod flips;
mod fuzz;
mod impure;
mod kills;
mod rebuild;
#[path = "../engine/support.rs"]
#[expect(dead_code, reason = "the tests of the engine use more kinds")]
mod support;
mod writers;

use bench::*;
use farfield::engine::plan::Plan;
use serde_json::json;
use support::*;

/// How many of `all` cases are run, where the short form runs `short`.
fn cases(short: usize, all: usize) -> usize {
    match std::env::var("FARFIELD_TORTURE").as_deref() {
        Err(_) | Ok("") => short.min(all),
        Ok("long") => all,
        Ok(n) => {
            let times: usize = n.parse().expect("FARFIELD_TORTURE: expected a number or `long`");
            short.saturating_mul(times).min(all)
        }
    }
}

/// `count` of the numbers below `all`, spread evenly; another choice for another `turn`.
fn spread(all: usize, count: usize, turn: usize) -> impl Iterator<Item = usize> {
    let count = count.clamp(1, all.max(1));
    (0..count).map(move |i| (i * all + turn * 7 % all.max(1)) / count).filter(move |n| *n < all)
}

/// Small and large values, lists, a published file per element. Each `variant` has work of its own.
fn plan(variant: i64, elements: i64) -> Plan {
    let mut b = Builder::default();
    let names: Vec<String> = (0..elements).map(|i| format!("n{i}")).collect();
    let values: Vec<i64> = (0..elements).map(|i| i + elements * variant).collect();
    let list = b.node::<MakeList>("list", json!({ "names": names, "values": values }), &[]);
    let slow = b.node::<Slow>("slow", json!({ "ms": 2 }), &[From::Node(list)]);
    if variant % 2 != 0 {
        b.transient(slow);
    }
    let square = b.node::<Square>("square", json!({ "pad": 20_000 }), &[From::Node(slow)]);
    let sum = b.node::<Sum>("sum", json!({}), &[From::Node(square)]);
    let each = b.node::<Print>("each", json!({}), &[From::Node(square)]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
    b.file(&format!("each-{}/{{name}}.txt", variant % 3), each);
    b.file("sum.txt", print);
    b.plan()
}

/// Copies a folder with all that is in it.
fn copy(from: &std::path::Path, to: &std::path::Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let (from, to) = (entry.path(), to.join(entry.file_name()));
        if entry.file_type().unwrap().is_dir() {
            copy(&from, &to);
        } else {
            std::fs::copy(&from, &to).unwrap();
        }
    }
}
