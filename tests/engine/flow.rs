//! Elements flow: what starts when is the schedule's matter, what comes out is not. Every result, record and count is the
//! same as if each node had waited for all of the nodes above it.

use super::{Bench, counts, ok, support::*, tree};
use farfield::{
    engine::{
        bake::{Options, Outcome, Report, bake},
        events::{Event, Events, Silent},
        plan::Plan,
    },
    math::Stop,
};
use proptest::prelude::*;
use serde_json::json;
use std::{cell::RefCell, collections::BTreeMap, fs};

/// What the index holds, but for times.
fn records(t: &Bench) -> BTreeMap<String, Vec<Vec<u8>>> {
    let files: Vec<_> = fs::read_dir(t.path("cache")).unwrap().map(|e| e.unwrap().path()).collect();
    let index = files.iter().find(|p| p.extension().is_some_and(|e| e == "sqlite")).unwrap();
    let db = rusqlite::Connection::open(index).unwrap();
    let read = |query: &str| -> Vec<Vec<u8>> {
        let mut s = db.prepare(query).unwrap();
        let rows = s.query_map([], |r| r.get(0)).unwrap();
        rows.map(Result::unwrap).collect()
    };
    let queries = ["SELECT CAST(key || variant AS BLOB) FROM run", "SELECT record FROM map", "SELECT hash FROM value"];
    let sorted = |query: &&str| {
        let mut rows = read(query);
        rows.sort();
        ((*query).to_owned(), rows)
    };
    queries.iter().map(sorted).collect()
}

/// Bakes node by node: every node finds all above it done.
fn bake_by_nodes(t: &Bench, plan: &Plan, change: impl Fn(&mut Options)) -> Report {
    for node in &plan.nodes {
        t.bake_with(plan, |o| {
            change(o);
            o.only = vec![node.name.clone()];
        });
    }
    t.bake_with(plan, change)
}

/// Elements per node: those with results, failed, skipped.
fn ends(r: &Report) -> BTreeMap<&str, (u64, u64, u64)> {
    r.nodes.iter().map(|n| (n.name.as_str(), (n.hits + n.runs, n.failed, n.skipped))).collect()
}

/// A graph from numbers: a list and a relation, then nodes of several kinds over what is there.
fn graph(seed: &[(u8, u8, u8)], values: &[i64; 3], picky: bool) -> Plan {
    let mut b = Builder::default();
    let names = ["a", "b", "c"];
    let list = b.node::<MakeList>("list", json!({ "names": names, "values": values }), &[]);
    let relation = b.node::<Neighbours>(
        "relation",
        json!({ "names": { "a": ["b", "c"], "b": ["a"], "c": ["a", "b", "c"] } }),
        &[],
    );
    // Nodes over the first list alone, and over lists made below it.
    let (mut flat, mut deep) = (vec![list], Vec::new());
    for (i, (kind, x, y)) in seed.iter().enumerate() {
        let name = format!("n{i:02}");
        let pick = |of: &Vec<usize>, k: u8| of[usize::from(k) % of.len()];
        let (f, g) = (pick(&flat, *x), pick(&flat, *y));
        match kind % 8 {
            0 => flat.push(b.node::<Square>(&name, json!({}), &[From::Node(f)])),
            1 => flat.push(b.node::<Add>(&name, json!({ "plus": x }), &[From::Node(f), From::Node(g)])),
            2 => deep.push(b.node::<Split>(&name, json!({}), &[From::Node(list)])),
            3 if picky => flat.push(b.node::<Picky>(&name, json!({}), &[From::Node(f)])),
            3 => flat.push(b.node::<Named>(&name, json!({}), &[From::Node(f)])),
            4 => flat.push(b.node::<Around>(&name, json!({}), &[From::Node(f), From::Via(g, relation)])),
            5 if !deep.is_empty() => {
                let d = pick(&deep, *y);
                deep.push(b.node::<Add>(&name, json!({ "plus": y }), &[From::Node(d), From::Node(f)]));
            }
            6 if !deep.is_empty() => {
                let d = pick(&deep, *x);
                flat.push(b.node_inner::<Sum>(&name, json!({}), &[From::Node(d)], &[list]));
            }
            7 if !deep.is_empty() => {
                let d = pick(&deep, *x);
                deep.push(b.node::<Square>(&name, json!({}), &[From::Node(d)]));
            }
            _ => drop(b.node::<Sum>(&name, json!({}), &[From::Node(g)])),
        }
    }
    for (i, node) in flat.into_iter().enumerate().skip(1) {
        let print = b.node::<Print>(&format!("print{i:02}"), json!({}), &[From::Node(node)]);
        b.file(&format!("{i}-{{name}}.txt"), print);
    }
    b.plan()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn results_and_records_are_those_of_whole_nodes(
        seed in proptest::collection::vec(any::<(u8, u8, u8)>(), 1..9),
        values in any::<[u8; 3]>(),
        jobs in 1usize..4,
    ) {
        let (a, b) = (Bench::new(), Bench::new());
        let values = values.map(|v| i64::from(v % 4));
        let plan = graph(&seed, &values, false);
        let flowing = a.bake_with(&plan, |o| o.jobs = jobs);
        let whole = bake_by_nodes(&b, &plan, |_| {});
        prop_assert_eq!(ends(ok(&flowing)), ends(ok(&whole)));
        prop_assert_eq!(tree(&a.path("out")), tree(&b.path("out")));
        prop_assert_eq!(records(&a), records(&b));
        prop_assert_eq!(ok(&a.bake(&plan)).runs(), 0);
        // One element changes: the same runs, and no others.
        let plan = graph(&seed, &[values[0], values[1] + 1, values[2]], false);
        let flowing = a.bake_with(&plan, |o| o.jobs = jobs);
        let mut runs = 0;
        for node in &plan.nodes {
            runs += ok(&b.bake_with(&plan, |o| o.only = vec![node.name.clone()])).runs();
        }
        ok(&b.bake(&plan));
        prop_assert_eq!(ok(&flowing).runs(), runs);
        prop_assert_eq!(tree(&a.path("out")), tree(&b.path("out")));
        prop_assert_eq!(records(&a), records(&b));
        prop_assert!(a.verify().is_clean());
    }

    #[test]
    fn failures_reach_as_far_as_with_whole_nodes(
        seed in proptest::collection::vec(any::<(u8, u8, u8)>(), 1..9),
        values in any::<[u8; 3]>(),
        jobs in 1usize..4,
    ) {
        let (a, b) = (Bench::new(), Bench::new());
        let plan = graph(&seed, &values.map(|v| i64::from(v % 4)), true);
        let flowing = a.bake_with(&plan, |o| (o.jobs, o.keep_going) = (jobs, true));
        let whole = bake_by_nodes(&b, &plan, |o| o.keep_going = true);
        prop_assert_eq!(ends(&flowing), ends(&whole));
        let errors = |r: &Report| {
            let mut all: Vec<_> = r.errors.iter().map(|e| (e.node.clone(), e.element.clone(), e.message.clone())).collect();
            all.sort();
            all
        };
        prop_assert_eq!(errors(&flowing), errors(&whole));
        prop_assert_eq!(flowing.outcome, whole.outcome);
        prop_assert_eq!(records(&a), records(&b));
        // What failed fails again, and nothing else runs.
        let again = a.bake_with(&plan, |o| o.keep_going = true);
        prop_assert_eq!((again.runs(), ends(&again)), (0, ends(&whole)));
    }
}

/// Progress and ends of nodes, in their order.
#[derive(Default)]
struct Log(RefCell<Vec<String>>);

impl Events for Log {
    fn event(&self, event: &Event) {
        let line = match event {
            Event::NodeStarted { node, .. } => format!("start {node}"),
            Event::Progress { node, .. } => format!("run {node}"),
            Event::NodeFinished { node, .. } => format!("end {node}"),
            _ => return,
        };
        self.0.borrow_mut().push(line);
    }
}

fn log(t: &Bench, plan: &Plan, jobs: usize) -> Vec<String> {
    let log = Log::default();
    let options = Options { jobs, ..t.options() };
    let report = bake(plan, &options, &Stop::default(), &log).unwrap();
    assert_eq!(report.outcome, Outcome::Baked);
    log.0.into_inner()
}

fn place(log: &[String], line: &str) -> usize {
    log.iter().position(|l| l == line).unwrap_or_else(|| panic!("no `{line}` in {log:?}"))
}

#[test]
fn an_element_goes_on_while_its_producer_still_runs() {
    let t = Bench::new();
    let mut b = Builder::default();
    let list = b.node::<MakeMany>("list", json!({ "count": 20, "changed": -1 }), &[]);
    let first = b.node::<Slow>("first", json!({ "ms": 1 }), &[From::Node(list)]);
    let second = b.node::<Add>("second", json!({}), &[From::Node(first), From::Node(list)]);
    let third = b.node::<Square>("third", json!({}), &[From::Node(second)]);
    b.node::<Sum>("sum", json!({}), &[From::Node(third)]);
    let log = log(&t, &b.plan(), 1);
    assert!(place(&log, "run third") < place(&log, "end first"), "{log:?}");
    // With one job an element goes all the way before the next one starts.
    let runs: Vec<&String> = log.iter().filter(|l| l.starts_with("run ")).collect();
    let most = (1..runs.len()).filter(|end| runs[..*end].iter().filter(|l| **l == "run first").count() >= 4);
    assert!(most.take(1).all(|end| runs[..end].iter().any(|l| *l == "run third")), "{runs:?}");
    for node in ["first", "second", "third", "sum"] {
        assert!(place(&log, &format!("start {node}")) < place(&log, &format!("end {node}")));
        assert!(!log[place(&log, &format!("end {node}"))..].contains(&format!("run {node}")), "{log:?}");
    }
}

#[test]
fn lists_that_a_mapped_node_makes_go_on_row_by_row() {
    let t = Bench::new();
    let mut b = Builder::default();
    let names: Vec<String> = (0..8).map(|i| format!("n{i}")).collect();
    let list = b.node::<MakeList>("list", json!({ "names": names, "values": vec![3; 8] }), &[]);
    let slow = b.node::<Named>("slow", json!({}), &[From::Node(list)]);
    let split = b.node::<Split>("split", json!({}), &[From::Node(slow)]);
    let add = b.node::<Add>("add", json!({}), &[From::Node(split), From::Node(slow)]);
    let square = b.node::<Square>("square", json!({}), &[From::Node(add)]);
    let per = b.node_inner::<Sum>("per", json!({}), &[From::Node(square)], &[list]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(per)]);
    b.file("{name}.txt", print);
    let log = log(&t, &b.plan(), 1);
    assert!(place(&log, "run square") < place(&log, "end split"), "{log:?}");
    assert!(place(&log, "run square") < place(&log, "end slow"), "{log:?}");
    // What is gathered below an element starts when all below it is there.
    assert!(place(&log, "run per") < place(&log, "end slow") && place(&log, "run print") < place(&log, "end slow"));
    // 3 + 2 is the value of every element: five parts of 0 … 4, each with 5 added.
    assert_eq!(t.file("n3.txt"), "255\n");
}

#[test]
fn a_change_runs_the_changed_elements_alone() {
    let t = Bench::new();
    let plan = |seventh: i64, plus: i64| {
        let mut b = Builder::default();
        let names: Vec<String> = (0..50).map(|i| format!("e{i:02}")).collect();
        let values: Vec<i64> = (0..50).map(|i| if i == 7 { seventh } else { i }).collect();
        let list = b.node::<MakeList>("list", json!({ "names": names, "values": values }), &[]);
        let square = b.node::<Square>("square", json!({}), &[From::Node(list)]);
        let add = b.node::<Add>("add", json!({ "plus": plus }), &[From::Node(square), From::Absent]);
        let last = b.node::<Square>("last", json!({}), &[From::Node(add)]);
        let sum = b.node::<Sum>("sum", json!({}), &[From::Node(last)]);
        let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
        b.file("sum.txt", print);
        b.plan()
    };
    ok(&t.bake(&plan(7, 0)));
    let r = t.bake(&plan(500, 0));
    let c = counts(ok(&r));
    assert_eq!((c["square"], c["add"], c["last"], c["sum"]), ((49, 1), (49, 1), (49, 1), (0, 1)));
    // The square of −500 is the same, and nothing below runs.
    let r = t.bake(&plan(-500, 0));
    let c = counts(ok(&r));
    assert_eq!((c["square"], c["add"], c["last"], c["sum"]), ((49, 1), (50, 0), (50, 0), (1, 0)));
    let dry = t.bake_with(&plan(-500, 5), |o| o.dry_run = true);
    let forecast: Vec<String> = dry.nodes.iter().map(|n| format!("{:?}", n.forecast.unwrap())).collect();
    assert_eq!(forecast, ["Hit", "Hit", "Runs", "MayRun", "MayRun", "MayRun"]);
    assert_eq!(dry.nodes[2].runs, 50);
    let text = farfield::engine::why::why(&plan(-500, 0), &t.options(), "add/e07").unwrap();
    assert!(text.contains("add/e07 ran: input `a` changed"), "{text}");
}

#[test]
fn lists_that_do_not_match_are_an_error_as_before() {
    let t = Bench::new();
    let mut b = Builder::default();
    let list = b.node::<MakeList>("list", json!({ "names": ["a", "b"], "values": [2, 2] }), &[]);
    let one = b.node::<Split>("one", json!({}), &[From::Node(list)]);
    let slow = b.node::<Slow>("slow", json!({ "ms": 5 }), &[From::Node(one)]);
    let sum = b.node_inner::<SumSome>("sum", json!({}), &[From::Node(slow)], &[list]);
    b.node::<Add>("add", json!({}), &[From::Node(sum), From::Node(list)]);
    ok(&t.bake(&b.plan()));
    // An element whose list is empty fails; the others go on.
    let mut b = Builder::default();
    let list = b.node::<MakeList>("list", json!({ "names": ["a", "b"], "values": [2, 0] }), &[]);
    let one = b.node::<Split>("one", json!({}), &[From::Node(list)]);
    let slow = b.node::<Slow>("slow", json!({ "ms": 5 }), &[From::Node(one)]);
    let sum = b.node_inner::<SumSome>("sum", json!({}), &[From::Node(slow)], &[list]);
    b.node::<Add>("add", json!({}), &[From::Node(sum), From::Node(list)]);
    let r = t.bake_with(&b.plan(), |o| o.keep_going = true);
    assert_eq!((r.outcome, r.errors.len()), (Outcome::Failed, 1));
    assert!(r.errors[0].message.contains("empty") && r.errors[0].element.as_deref() == Some("b"), "{:?}", r.errors);
    assert_eq!(ends(&r)["add"], (1, 0, 1));
}

#[test]
fn a_stop_in_the_middle_is_taken_up_where_it_was() {
    let t = Bench::new();
    let mut b = Builder::default();
    let list = b.node::<MakeMany>("list", json!({ "count": 40, "changed": -1 }), &[]);
    let slow = b.node::<Slow>("slow", json!({ "ms": 10 }), &[From::Node(list)]);
    let square = b.node::<Square>("square", json!({}), &[From::Node(slow)]);
    b.node::<Sum>("sum", json!({}), &[From::Node(square)]);
    let plan = b.plan();
    let stop = Stop::default();
    let first = std::thread::scope(|s| {
        s.spawn(|| {
            std::thread::sleep(std::time::Duration::from_millis(100));
            stop.set();
        });
        bake(&plan, &t.options(), &stop, &Silent).unwrap()
    });
    assert_eq!(first.outcome, Outcome::Interrupted);
    let done = counts(&first)["square"].1;
    assert!(done > 0, "elements went through while others had not begun: {:?}", counts(&first));
    let second = t.bake(&plan);
    assert_eq!(ok(&second).runs() + first.runs(), 82);
}

#[test]
fn lost_values_of_elements_are_made_again_in_the_middle() {
    let t = Bench::new();
    let plan = |plus: i64| {
        let mut b = Builder::default();
        let list = b.node::<Padded>("list", json!({ "count": 6, "pad": 20_000 }), &[]);
        let square = b.node::<Square>("square", json!({ "pad": 21_000 }), &[From::Node(list)]);
        let add = b.node::<Add>("add", json!({ "plus": plus }), &[From::Node(square), From::Node(list)]);
        let sum = b.node::<Sum>("sum", json!({}), &[From::Node(add)]);
        let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
        b.file("sum.txt", print);
        b.plan()
    };
    ok(&t.bake(&plan(0)));
    fs::remove_dir_all(t.path("cache/values")).unwrap();
    let r = t.bake(&plan(1));
    let c = counts(ok(&r));
    assert_eq!((c["list"], c["square"], c["add"]), ((0, 1), (0, 6), (0, 6)), "{c:?}");
    assert!(r.warnings > 0);
    let expect: i64 = (0..6).map(|i| i * i + i + 1).sum();
    assert_eq!(t.file("sum.txt"), format!("{expect}\n"));
    assert!(t.verify().is_clean());
}
