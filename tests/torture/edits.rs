//! A source that is edited within one tick of the clock, with the same size and the same time of change, is read again all the same.

use super::{Bench, cases, ok, support::*};
use farfield::engine::plan::Plan;
use serde_json::json;
use std::{
    fs,
    io::Write as _,
    path::Path,
    sync::atomic::{AtomicBool, Ordering},
    time::{Duration, Instant, SystemTime},
};

fn plan(root: &Path) -> Plan {
    let mut b = Builder::default();
    let source = b.node::<Source>("source", json!({ "path": root.to_str().unwrap() }), &[]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(source)]);
    b.file("n.txt", print);
    b.plan()
}

/// Writes into the file that is there, so that only its bytes tell, and gives it the time of change that it had.
fn edit(path: &Path, text: &str, time: Option<SystemTime>) {
    let mut file = fs::File::options().write(true).open(path).unwrap();
    file.write_all(text.as_bytes()).unwrap();
    if let Some(time) = time {
        file.set_modified(time).unwrap();
    }
}

#[test]
fn edits_within_a_tick_are_noticed() {
    let edits = cases(60, 20_000);
    let t = Bench::new();
    let (root, extra) = (t.path("root.obj"), t.path("extra.txt"));
    fs::write(&root, "10000").unwrap();
    fs::write(&extra, "10000").unwrap();
    let time = fs::metadata(&root).unwrap().modified().unwrap();
    for i in 0..edits {
        let (a, b) = (10_000 + i, 10_000 + i * 7 % 50_000);
        // A bake as soon as the file is written, an edit as soon as it was read.
        edit(&root, &a.to_string(), Some(time));
        ok(&t.bake(&plan(&root)));
        edit(&extra, &b.to_string(), Some(time));
        ok(&t.bake(&plan(&root)));
        assert_eq!(t.file("n.txt").trim(), (a + b).to_string(), "edit {i}");
    }
}

#[test]
fn edits_on_both_sides_of_the_moment_of_trust_are_noticed() {
    // Two seconds after a file's last change its hash is believed. The edits come at moments around that.
    let count = cases(24, 400) as u64;
    std::thread::scope(|s| {
        for i in 0..count {
            s.spawn(move || {
                let t = Bench::new();
                let root = t.path("root.obj");
                fs::write(&root, "1").unwrap();
                let (began, moment) = (Instant::now(), Duration::from_millis(1_900 + i * 200 / count));
                let mut value = 1;
                while began.elapsed() < moment {
                    ok(&t.bake(&plan(&root)));
                    std::thread::sleep(Duration::from_millis(100).min(moment.saturating_sub(began.elapsed())));
                }
                for _ in 0..4 {
                    ok(&t.bake(&plan(&root)));
                    value = value % 9 + 1;
                    edit(&root, &value.to_string(), None);
                    ok(&t.bake(&plan(&root)));
                    assert_eq!(t.file("n.txt").trim(), value.to_string(), "after {moment:?}");
                }
            });
        }
    });
}

#[test]
fn a_file_that_changes_while_it_is_read_gives_one_of_its_states() {
    let bakes = cases(40, 5_000);
    let t = Bench::new();
    let root = t.path("root.obj");
    fs::write(&root, "11111").unwrap();
    let done = AtomicBool::new(false);
    std::thread::scope(|s| {
        s.spawn(|| {
            let mut turn = 0;
            while !done.load(Ordering::Relaxed) {
                turn += 1;
                edit(&root, if turn % 2 == 0 { "11111" } else { "22222" }, None);
                std::thread::sleep(Duration::from_micros(turn % 7 * 300));
            }
        });
        for i in 0..bakes {
            ok(&t.bake(&plan(&root)));
            let text = t.file("n.txt");
            assert!(["11111", "22222"].contains(&text.trim()), "bake {i}: {text}");
        }
        done.store(true, Ordering::Relaxed);
    });
    edit(&root, "33333", None);
    ok(&t.bake(&plan(&root)));
    assert_eq!(t.file("n.txt").trim(), "33333");
    assert!(t.verify().is_clean());
}
