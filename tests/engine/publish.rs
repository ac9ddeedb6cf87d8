//! What lies below the output folder.

use super::{Bench, ok, support::*, tree};
use farfield::{
    engine::{
        bake::{Outcome, bake},
        events::Silent,
        plan::Plan,
    },
    math::Stop,
};
use serde_json::json;
use std::fs;

/// Publishes two elements, `a` and `name`, as `file`.
fn two_files(name: &str, file: &str) -> Plan {
    let mut b = Builder::default();
    let list = b.node::<MakeList>("list", json!({ "names": ["a", name], "values": [1, 2] }), &[]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(list)]);
    b.file(file, print);
    b.plan()
}

#[test]
fn out_is_mended_and_only_our_files_go() {
    let t = Bench::new();
    let build = |name: &str| two_files(name, "deep/{name}.txt");
    ok(&t.bake(&build("b")));
    let before = tree(&t.path("out"));
    fs::write(t.path("out/test/deep/a.txt"), "edited").unwrap();
    fs::remove_file(t.path("out/test/deep/b.txt")).unwrap();
    fs::write(t.path("out/test/deep/mine.txt"), "mine").unwrap();
    let r = t.bake(&build("b"));
    assert_eq!((ok(&r).runs(), r.published.len()), (0, 2));
    fs::remove_file(t.path("out/test/deep/mine.txt")).unwrap();
    assert_eq!(tree(&t.path("out")), before);
    fs::write(t.path("out/test/deep/mine.txt"), "mine").unwrap();
    ok(&t.bake(&build("c")));
    let left: Vec<String> = tree(&t.path("out/test")).into_keys().collect();
    assert_eq!(left, ["deep/a.txt", "deep/c.txt", "deep/mine.txt", "manifest.json"]);
    // What was ours and was edited since is no longer ours to delete.
    fs::write(t.path("out/test/deep/c.txt"), "edited").unwrap();
    ok(&t.bake(&build("d")));
    assert_eq!(t.file("deep/c.txt"), "edited");
}

#[test]
fn names_cannot_leave_the_output_folder() {
    let t = Bench::new();
    let build = |name: &str| two_files(name, "{name}.txt");
    for bad in ["..", "../x", "x/y", "A", "con", "x:y"] {
        let e = bake(&build(bad), &t.options(), &Stop::default(), &Silent).unwrap_err();
        assert!(e.exit_code() == 1 && e.to_string().contains("cannot publish"), "{bad}: {e}");
    }
    assert!(tree(&t.path("out")).is_empty());
    #[cfg(unix)]
    {
        fs::create_dir_all(t.path("outside")).unwrap();
        fs::create_dir_all(t.path("out")).unwrap();
        std::os::unix::fs::symlink(t.path("outside"), t.path("out/test")).unwrap();
        let e = bake(&build("b"), &t.options(), &Stop::default(), &Silent).unwrap_err();
        assert!(e.to_string().contains("symbolic link"), "{e}");
        assert!(tree(&t.path("outside")).is_empty());
    }
}

#[test]
fn a_missed_bound_keeps_the_last_good_output() {
    let t = Bench::new();
    let build = |value: i64| {
        let mut b = Builder::default();
        let c = b.node::<Constant>("c", json!({ "value": value }), &[]);
        let cert = b.node::<Certify>("certify", json!({}), &[From::Node(c)]);
        b.file("certificate.json", cert);
        b.require(cert, "error.max", 10.0);
        b.plan()
    };
    ok(&t.bake(&build(5)));
    let good = t.file("certificate.json");
    for again in 0..2 {
        let r = t.bake(&build(50));
        assert_eq!((r.outcome, r.outcome.exit_code()), (Outcome::NotMet, 3));
        assert_eq!((r.unmet[0].measured, r.runs()), (Some(50.0), if again == 0 { 2 } else { 0 }));
        assert_eq!(t.file("certificate.json"), good);
        assert!(t.file("rejected/certificate.json").contains("50"));
    }
    ok(&t.bake(&build(5)));
    assert!(!t.path("out/test/rejected").exists());
}
