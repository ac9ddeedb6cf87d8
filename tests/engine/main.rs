//! The engine on trivial kinds.

mod bench;
mod damage;
mod flow;
mod folders;
mod publish;
mod readonly;
#[cfg(feature = "remote")]
mod remote;
mod support;
mod transient;

use bench::*;
use farfield::{
    engine::{
        bake::{Options, Outcome, Report, bake},
        events::Silent,
        plan::Plan,
        why::why,
    },
    math::Stop,
};
use serde_json::json;
use std::{fs, path::Path};
use support::*;

/// a list, its squares, their sum, printed.
fn squares(values: &[i64], pad: u32) -> Plan {
    let names: Vec<String> = (0..values.len()).map(|i| format!("n{i}")).collect();
    let mut b = Builder::default();
    let list = b.node::<MakeList>("list", json!({ "names": names, "values": values }), &[]);
    let square = b.node::<Square>("square", json!({ "pad": pad }), &[From::Node(list)]);
    let sum = b.node::<Sum>("sum", json!({}), &[From::Node(square)]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
    b.file("sum.txt", print);
    b.plan()
}

#[test]
fn a_second_bake_does_nothing() {
    let t = Bench::new();
    let plan = squares(&[1, 2, 3], 0);
    let first = t.bake(&plan);
    assert_eq!(ok(&first).runs(), 6);
    assert_eq!(t.file("sum.txt"), "14\n");
    let second = t.bake(&plan);
    assert_eq!((ok(&second).runs(), second.hits()), (0, 6));
    assert!(second.published.is_empty());
}

#[test]
fn only_changed_elements_run_and_equal_bytes_stop_the_wave() {
    let t = Bench::new();
    t.bake(&squares(&[1, 2, 3, 4], 0));
    let r = t.bake(&squares(&[1, -2, 3, 4], 0));
    let c = counts(ok(&r));
    assert_eq!((c["list"], c["square"], c["sum"], c["print"]), ((0, 1), (3, 1), (1, 0), (1, 0)), "(-2)² is 2²");
    let r = t.bake(&squares(&[1, 5, 3, 4, 6], 0));
    let c = counts(ok(&r));
    assert_eq!((c["square"], c["sum"]), ((3, 2), (0, 1)));
    // Back to the first: all of it is still known.
    assert_eq!(ok(&t.bake(&squares(&[1, 2, 3, 4], 0))).runs(), 0);
}

#[test]
fn an_absent_input_is_no_value() {
    let t = Bench::new();
    let mut b = Builder::default();
    let many = b.node::<MakeMany>("many", json!({ "count": 300, "changed": -1 }), &[]);
    let alone = b.node::<Add>("alone", json!({ "plus": 1 }), &[From::Node(many), From::Absent]);
    let both = b.node::<Add>("both", json!({ "plus": 1 }), &[From::Node(many), From::Node(many)]);
    for (name, node) in [("alone", alone), ("both", both)] {
        let sum = b.node::<Sum>(&format!("sum-{name}"), json!({}), &[From::Node(node)]);
        let print = b.node::<Print>(&format!("print-{name}"), json!({}), &[From::Node(sum)]);
        b.file(&format!("{name}.txt"), print);
    }
    ok(&t.bake(&b.plan()));
    assert_eq!((t.file("alone.txt"), t.file("both.txt")), ("45150\n".to_owned(), "90000\n".to_owned()));
}

#[test]
fn threads_and_caches_change_no_byte() {
    let (a, b) = (Bench::new(), Bench::new());
    let plan = squares(&(0..40).collect::<Vec<_>>(), 30_000);
    a.bake_with(&plan, |o| o.jobs = 1);
    b.bake_with(&plan, |o| o.jobs = 4);
    assert_eq!(tree(&a.path("out")), tree(&b.path("out")));
    assert!(tree(&a.path("out")).contains_key("test/manifest.json"));
}

#[test]
fn the_whole_cache_may_be_deleted() {
    let t = Bench::new();
    let plan = squares(&[1, 2], 0);
    t.bake(&plan);
    let before = tree(&t.path("out"));
    fs::remove_dir_all(t.path("cache")).unwrap();
    assert_eq!(ok(&t.bake(&plan)).runs(), 5);
    assert_eq!(tree(&t.path("out")), before);
}

#[test]
fn failures_name_their_element_and_keep_going_goes_on() {
    let t = Bench::new();
    let mut b = Builder::default();
    let names = ["a", "b", "c", "d"];
    let list = b.node::<MakeList>("list", json!({ "names": names, "values": [2, 3, 13, 4] }), &[]);
    let picky = b.node::<Picky>("picky", json!({}), &[From::Node(list)]);
    let square = b.node::<Square>("square", json!({}), &[From::Node(picky)]);
    let sum = b.node::<Sum>("sum", json!({}), &[From::Node(square)]);
    let other = b.node::<Constant>("other", json!({ "value": 1 }), &[]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
    b.node::<Slow>("after", json!({}), &[From::Node(other)]);
    b.file("sum.txt", print);
    let plan = b.plan();
    let r = t.bake_with(&plan, |o| o.keep_going = true);
    assert_eq!(r.outcome, Outcome::Failed);
    let mut errors: Vec<_> = r.errors.iter().map(|e| (e.element.as_deref().unwrap(), e.message.as_str())).collect();
    errors.sort();
    assert_eq!(errors[0], ("b", "3 is odd"));
    assert!(errors[1].0 == "c" && errors[1].1.contains("thirteen"), "{errors:?}");
    let node = |name: &str| r.nodes.iter().find(|n| n.name == name).unwrap();
    assert_eq!((node("square").runs, node("square").skipped), (2, 2));
    assert_eq!((node("sum").runs, node("sum").skipped, node("after").runs), (0, 1, 1));
    assert!(!t.path("out/test/manifest.json").exists());
    // Without it, the bake stops at the first failure, and what is finished is kept.
    let r = t.bake(&plan);
    assert_eq!(r.outcome, Outcome::Failed);
    assert_eq!(node("list").failed + r.nodes.iter().map(|n| n.runs).sum::<u64>(), 0);
}

#[test]
fn sources_are_known_by_content_and_by_all_they_read() {
    let t = Bench::new();
    let plan = |path: &Path| {
        let mut b = Builder::default();
        let s = b.node::<Source>("source", json!({ "path": path }), &[]);
        let p = b.node::<Print>("print", json!({}), &[From::Node(s)]);
        b.file("out.txt", p);
        b.plan()
    };
    let root = t.path("in/town.obj");
    fs::create_dir_all(t.path("in")).unwrap();
    fs::write(&root, "5").unwrap();
    let bake = |root: &Path| ok(&t.bake(&plan(root))).runs();
    assert_eq!(bake(&root), 2);
    assert_eq!(bake(&root), 0);
    // A file that was looked for appears, changes, and goes.
    fs::write(t.path("in/extra.txt"), "1").unwrap();
    assert_eq!((bake(&root), t.file("out.txt")), (2, "6\n".to_owned()));
    fs::write(t.path("in/extra.txt"), "2").unwrap();
    assert_eq!((bake(&root), t.file("out.txt")), (2, "7\n".to_owned()));
    fs::write(t.path("in/extra.txt"), "1").unwrap();
    assert_eq!(bake(&root), 0, "several records under one key");
    fs::remove_file(t.path("in/extra.txt")).unwrap();
    assert_eq!(bake(&root), 0);
    // Moved as a whole: no path is in the key.
    fs::create_dir_all(t.path("elsewhere")).unwrap();
    fs::rename(&root, t.path("elsewhere/other.obj")).unwrap();
    assert_eq!(bake(&t.path("elsewhere/other.obj")), 0);
    // Another extension may mean another reader.
    fs::rename(t.path("elsewhere/other.obj"), t.path("elsewhere/other.ply")).unwrap();
    assert_eq!(bake(&t.path("elsewhere/other.ply")), 1, "print is cut off");
    // The same size and time, other bytes: hashed anew because it is fresh.
    fs::write(t.path("elsewhere/other.ply"), "9").unwrap();
    assert_eq!(bake(&t.path("elsewhere/other.ply")), 2);
    let r = t.bake(&plan(&t.path("nowhere.obj")));
    assert!(r.outcome == Outcome::Failed && r.errors[0].message.contains("nowhere.obj"));
    assert_eq!(bake(Path::new("builtin:8")), 2);
}

#[test]
fn nested_lists_join_gather_and_may_be_empty() {
    let t = Bench::new();
    let build = |values: [i64; 3]| {
        let mut b = Builder::default();
        let list = b.node::<MakeList>("list", json!({ "names": ["x", "y", "z"], "values": values }), &[]);
        let split = b.node::<Split>("split", json!({}), &[From::Node(list)]);
        // Mapped over both axes, with an input that has only the first.
        let add = b.node::<Add>("add", json!({}), &[From::Node(split), From::Node(list)]);
        let per = b.node_inner::<Sum>("per", json!({}), &[From::Node(add)], &[list]);
        let print = b.node::<Print>("print", json!({}), &[From::Node(per)]);
        b.file("{name}.txt", print);
        let all = b.node::<Sum>("all", json!({}), &[From::Node(add)]);
        let print = b.node::<Print>("print-all", json!({}), &[From::Node(all)]);
        b.file("all.txt", print);
        b.plan()
    };
    let r = t.bake(&build([2, 0, 3]));
    assert_eq!(counts(ok(&r))["add"], (0, 5));
    assert_eq!(counts(&r)["per"], (0, 3), "an empty list below y is a list");
    assert_eq!((t.file("x.txt"), t.file("y.txt"), t.file("z.txt")), ("5\n".into(), "0\n".into(), "12\n".into()));
    assert_eq!(t.file("all.txt"), "17\n");
    let r = t.bake(&build([2, 0, 2]));
    let c = counts(ok(&r));
    assert_eq!((c["split"], c["add"], c["per"]), ((3, 0), (4, 0), (3, 0)), "all below z is what is below x");
    // z vanishes from nothing but its own list.
    assert_eq!(ok(&t.bake(&build([2, 0, 3]))).runs(), 0);
}

#[test]
fn empty_lists_map_to_no_runs_and_are_refused_where_not_allowed() {
    let t = Bench::new();
    let mut b = Builder::default();
    let list = b.node::<MakeList>("list", json!({}), &[]);
    let square = b.node::<Square>("square", json!({}), &[From::Node(list)]);
    b.node::<Sum>("sum", json!({}), &[From::Node(square)]);
    assert_eq!(ok(&t.bake(&b.plan())).runs(), 2);
    let mut b = Builder::default();
    let list = b.node::<MakeList>("list", json!({}), &[]);
    b.node::<SumSome>("sum", json!({}), &[From::Node(list)]);
    let r = t.bake(&b.plan());
    assert!(r.errors[0].message.contains("empty"), "{:?}", r.errors);
}

#[test]
fn relations_bring_only_neighbours_into_the_key() {
    let t = Bench::new();
    let build = |values: [i64; 3], names: serde_json::Value| {
        let mut b = Builder::default();
        let list = b.node::<MakeList>("list", json!({ "names": ["a", "b", "c"], "values": values }), &[]);
        let relation = b.node::<Neighbours>("relation", json!({ "names": names }), &[]);
        let around = b.node::<Around>("around", json!({}), &[From::Node(list), From::Via(list, relation)]);
        let print = b.node::<Print>("print", json!({}), &[From::Node(around)]);
        b.file("{name}.txt", print);
        b.plan()
    };
    let names = json!({ "a": ["b"], "b": ["a", "c"] });
    ok(&t.bake(&build([1, 2, 3], names.clone())));
    assert_eq!(
        (t.file("a.txt"), t.file("b.txt"), t.file("c.txt")),
        ("1002\n".into(), "2004\n".into(), "3000\n".into())
    );
    let r = t.bake(&build([1, 2, 4], names));
    assert_eq!(counts(ok(&r))["around"], (1, 2), "a does not neighbour c");
    let r = t.bake(&build([1, 2, 4], json!({ "a": ["q"] })));
    assert!(r.errors[0].message.contains("`q`"), "{:?}", r.errors);
}

#[test]
fn a_dry_run_runs_nothing_even_where_a_relation_is_lost() {
    let t = Bench::new();
    let mut b = Builder::default();
    let list = b.node::<MakeList>("list", json!({ "names": ["a", "b"], "values": [1, 2] }), &[]);
    let relation = b.node::<Neighbours>("relation", json!({ "names": { "a": ["b"] } }), &[]);
    let around = b.node::<Around>("around", json!({}), &[From::Node(list), From::Via(list, relation)]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(around)]);
    b.file("{name}.txt", print);
    let plan = b.plan();
    ok(&t.bake_with(&plan, |o| o.only = vec!["list".into(), "relation".into()]));
    let files: Vec<_> = fs::read_dir(t.path("cache")).unwrap().map(|e| e.unwrap().path()).collect();
    let index = files.iter().find(|p| p.extension().is_some_and(|e| e == "sqlite")).unwrap();
    let db = rusqlite::Connection::open(index).unwrap();
    assert!(db.execute("DELETE FROM value", []).unwrap() >= 3);
    drop(db);
    let r = t.bake_with(&plan, |o| o.dry_run = true);
    assert_eq!((r.runs(), r.errors.len(), t.path("out").exists()), (0, 0, false), "{r:?}");
    let forecast: Vec<String> = r.nodes.iter().map(|n| format!("{:?}", n.forecast.unwrap())).collect();
    assert_eq!(forecast, ["Hit", "Hit", "MayRun", "MayRun"]);
    ok(&t.bake(&plan));
}

#[test]
fn names_enter_keys_only_where_asked() {
    let t = Bench::new();
    let build = |name: &str| {
        let mut b = Builder::default();
        let list = b.node::<MakeList>("list", json!({ "names": [name], "values": [5] }), &[]);
        let square = b.node::<Square>("square", json!({}), &[From::Node(list)]);
        b.node::<Named>("named", json!({}), &[From::Node(square)]);
        b.plan()
    };
    t.bake(&build("a"));
    let r = t.bake(&build("bb"));
    assert_eq!((counts(ok(&r))["square"], counts(&r)["named"]), ((1, 0), (0, 1)));
}

#[test]
fn equal_keys_within_a_bake_run_once() {
    let t = Bench::new();
    let mut b = Builder::default();
    let c = b.node::<Constant>("c", json!({ "value": 3 }), &[]);
    let a = b.node::<Slow>("a", json!({ "ms": 30 }), &[From::Node(c)]);
    let d = b.node::<Slow>("d", json!({ "ms": 30 }), &[From::Node(c)]);
    b.node::<Add>("sum", json!({}), &[From::Node(a), From::Node(d)]);
    let r = t.bake(&b.plan());
    assert_eq!(ok(&r).runs(), 3);
}

#[test]
fn warnings_are_repeated_on_a_hit() {
    let t = Bench::new();
    let mut b = Builder::default();
    let list = b.node::<MakeList>("list", json!({ "names": ["a", "b"], "values": [1, 2] }), &[]);
    b.node::<Warner>("warner", json!({}), &[From::Node(list)]);
    let plan = b.plan();
    assert_eq!(ok(&t.bake(&plan)).warnings, 2);
    let r = t.bake(&plan);
    assert_eq!((r.runs(), r.warnings), (0, 2));
}

#[test]
fn a_task_beyond_the_budget_is_an_error_that_names_the_need() {
    let t = Bench::new();
    let mut b = Builder::default();
    let c = b.node::<Constant>("c", json!({ "value": 3, "pad": 5 << 20 }), &[]);
    b.node::<Greedy>("greedy", json!({}), &[From::Node(c)]);
    let r = t.bake_with(&b.plan(), |o| o.memory = 1 << 20);
    assert!(r.errors[0].message.contains("5.0 MiB"), "{:?}", r.errors);
}

#[test]
fn only_force_dry_run_and_audit() {
    let t = Bench::new();
    let plan = squares(&[1, 2, 3], 0);
    let r = t.bake_with(&plan, |o| o.dry_run = true);
    let forecast =
        |r: &Report| r.nodes.iter().map(|n| format!("{:?}", n.forecast.unwrap())).collect::<Vec<_>>().join(" ");
    assert_eq!(forecast(&r), "Runs MayRun MayRun MayRun");
    assert!(!t.path("cache").exists() && !t.path("out").exists());
    let r = t.bake_with(&plan, |o| o.only = vec!["square".into()]);
    assert_eq!((r.nodes.len(), r.runs(), t.path("out").exists()), (2, 4, false));
    assert_eq!(forecast(&t.bake_with(&plan, |o| o.dry_run = true)), "Hit Hit Runs MayRun");
    assert_eq!(t.bake(&plan).runs(), 2);
    let r = t.bake_with(&plan, |o| o.force = vec!["square".into()]);
    assert_eq!(ran(&r), ["square"]);
    let r = t.bake_with(&plan, |o| o.audit = 1.0);
    assert_eq!((ok(&r).runs(), r.hits()), (6, 0));
    let options = Options { only: vec!["sqare".into()], ..t.options() };
    let e = bake(&plan, &options, &Stop::default(), &Silent).unwrap_err();
    assert!(e.exit_code() == 2 && e.to_string().contains("did you mean `square`"), "{e}");
}

#[test]
fn a_stop_keeps_what_is_finished() {
    let t = Bench::new();
    let mut b = Builder::default();
    let list = b.node::<MakeList>("list", json!({ "names": ["a", "b", "c"], "values": [1, 2, 3] }), &[]);
    let square = b.node::<Square>("square", json!({}), &[From::Node(list)]);
    b.node::<Slow>("slow", json!({ "ms": 60_000 }), &[From::Node(square)]);
    let plan = b.plan();
    let stop = Stop::default();
    let r = std::thread::scope(|s| {
        s.spawn(|| {
            std::thread::sleep(std::time::Duration::from_millis(300));
            stop.set();
        });
        bake(&plan, &t.options(), &stop, &Silent).unwrap()
    });
    assert_eq!((r.outcome, r.outcome.exit_code()), (Outcome::Interrupted, 130));
    // Two elements have gone on to `slow`, and a third waits for a free thread at most.
    let finished = r.runs();
    assert!(finished >= 3, "the list and two squares: {:?}", counts(&r));
    let r = t.bake_with(&plan, |o| o.only = vec!["square".into()]);
    assert_eq!(r.runs(), 4 - finished);
}

#[test]
fn why_tells_the_chain_up_to_the_cause() {
    let t = Bench::new();
    let say = |plan: &Plan, what: &str| why(plan, &t.options(), what).unwrap();
    let plan = squares(&[1, 2, 3], 0);
    t.bake(&plan);
    assert!(say(&plan, "sum").contains("no earlier bake"), "{}", say(&plan, "sum"));
    let plan = squares(&[1, 5, 3], 0);
    t.bake(&plan);
    let text = say(&plan, "sum");
    assert!(
        text.contains("sum ran: input `items`") && text.contains("n1") && text.contains("parameter values"),
        "{text}"
    );
    let text = say(&plan, "square/n1");
    let expect = "square/n1 ran: input `value` changed (element `n1` changed) ← list ran: parameter values[1] changed from 2 to 5";
    assert_eq!(text, expect);
    assert!(say(&plan, "square/n0").contains("hit"));
    let plan = squares(&[1, 5, 3], 7);
    t.bake(&plan);
    assert!(say(&plan, "square").contains("parameter pad changed from 0 to 7"), "{}", say(&plan, "square"));
    assert!(why(&plan, &t.options(), "nothing").is_err());
}
