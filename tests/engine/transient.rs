//! Transient outputs: their hashes are recorded, their bytes are not kept, and what needs them later has them made again.

use super::{Bench, counts, ok, support::*};
use farfield::{
    engine::{
        artifact::{Artifact, DecodeError, Decoder, Encoder},
        bake::{Outcome, Report},
        cache::Limits,
        node::{Ctx, List, Node, NodeError},
        plan::Plan,
        why::why,
    },
    ports,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::{
    fs,
    sync::{
        Arc, Mutex,
        atomic::{AtomicI64, Ordering::SeqCst},
    },
};

/// A padded list, its transient squares, what is added to them, and the sum. `values` name what is added per element.
fn plan(values: &[i64], transient: &[&str]) -> Plan {
    let mut b = Builder::default();
    let names: Vec<String> = (0..values.len()).map(|i| format!("e{i}")).collect();
    let own: Vec<i64> = (0..values.len() as i64).collect();
    let list = b.node::<MakeList>("list", json!({ "names": names, "values": own }), &[]);
    let square = b.node::<Square>("square", json!({ "pad": 40_000 }), &[From::Node(list)]);
    let again = b.node::<Square>("again", json!({ "pad": 30_000 }), &[From::Node(square)]);
    let plus = b.node::<MakeList>("plus", json!({ "names": names, "values": values }), &[]);
    let named = b.node::<Named>("named", json!({}), &[From::Node(again)]);
    let rows = b.node::<Sum>("rows", json!({}), &[From::Node(plus)]);
    let add = b.node::<Add>("add", json!({}), &[From::Node(again), From::Node(rows)]);
    let sum = b.node::<Sum>("sum", json!({}), &[From::Node(add)]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
    b.file("sum.txt", print);
    for (name, node) in [("square", square), ("again", again), ("named", named)] {
        if transient.contains(&name) {
            b.transient(node);
        }
    }
    b.plan()
}

/// Bytes below the cache's folder of values.
fn kept(t: &Bench) -> u64 {
    farfield::engine::cache::stats(&t.path("cache")).unwrap().unwrap().bytes
}

fn runs(r: &Report, node: &str) -> u64 {
    counts(r)[node].1
}

#[test]
fn nothing_is_kept_and_nothing_is_missed() {
    let (t, whole) = (Bench::new(), Bench::new());
    let values = [1, 2, 3, 4, 5];
    ok(&whole.bake(&plan(&values, &[])));
    let r = t.bake(&plan(&values, &["square", "again"]));
    assert_eq!((ok(&r).warnings, r.runs()), (0, 5 * 4 + 5));
    assert_eq!(t.file("sum.txt"), whole.file("sum.txt"));
    assert!(kept(&t) < 20_000 && kept(&whole) > 5 * 70_000, "{} {}", kept(&t), kept(&whole));
    assert!(t.verify().is_clean());
    let r = t.bake(&plan(&values, &["square", "again"]));
    assert_eq!((ok(&r).runs(), r.warnings), (0, 0));
    // Whether it is kept is no part of the key.
    assert_eq!(ok(&t.bake(&plan(&values, &[]))).runs(), 0);
    assert_eq!(ok(&whole.bake(&plan(&values, &["again"]))).runs(), 0);
}

#[test]
fn what_is_needed_later_is_made_again_without_a_warning() {
    let (t, whole) = (Bench::new(), Bench::new());
    let both = ["square", "again"];
    ok(&t.bake(&plan(&[1, 2, 3], &both)));
    ok(&whole.bake(&plan(&[1, 2, 4], &[])));
    let changed = plan(&[1, 2, 4], &both);
    let dry = t.bake_with(&changed, |o| o.dry_run = true);
    assert_eq!((dry.warnings, runs(&dry, "square"), runs(&dry, "again")), (0, 0, 0));
    let r = t.bake(&changed);
    assert_eq!((ok(&r).warnings, runs(&r, "add"), runs(&r, "again"), runs(&r, "square")), (0, 3, 3, 3));
    assert_eq!(runs(&r, "named"), 0);
    assert_eq!(t.file("sum.txt"), whole.file("sum.txt"));
    let text = why(&changed, &t.options(), "again").unwrap();
    assert!(text.contains("transient"), "{text}");
    assert_eq!(ok(&t.bake(&changed)).runs(), 0);
    assert!(t.verify().is_clean());
    // Kept from now on: what is made again is stored.
    let kept_plan = plan(&[1, 2, 5], &[]);
    let r = t.bake(&kept_plan);
    assert_eq!((ok(&r).warnings, runs(&r, "again"), runs(&r, "square")), (0, 3, 3));
    let r = t.bake(&plan(&[1, 2, 6], &[]));
    assert_eq!((ok(&r).warnings, runs(&r, "again"), runs(&r, "square"), runs(&r, "add")), (0, 0, 0, 3));
}

#[test]
fn only_the_elements_that_are_needed_run_again() {
    let t = Bench::new();
    let plan = |values: [i64; 4]| {
        let mut b = Builder::default();
        let names = ["a", "b", "c", "d"];
        let list = b.node::<MakeList>("list", json!({ "names": names, "values": [1, 2, 3, 4] }), &[]);
        let beside = b.node::<MakeList>("beside", json!({ "names": names, "values": values }), &[]);
        let relation = json!({ "names": { "a": ["b"], "b": ["c", "d"], "c": ["a"], "d": ["c"] } });
        let relation = b.node::<Neighbours>("relation", relation, &[]);
        let first = b.node::<Square>("first", json!({ "pad": 20_000 }), &[From::Node(list)]);
        let second = b.node::<Square>("second", json!({ "pad": 20_000 }), &[From::Node(first)]);
        let around = b.node::<Around>("around", json!({}), &[From::Node(second), From::Via(beside, relation)]);
        let print = b.node::<Print>("print", json!({}), &[From::Node(around)]);
        b.file("{name}.txt", print);
        b.transient(first);
        b.transient(second);
        b.transient(relation);
        b.plan()
    };
    ok(&t.bake(&plan([10, 20, 30, 40])));
    assert_eq!(t.file("b.txt"), "16070\n");
    let r = t.bake(&plan([10, 20, 31, 40]));
    let c = counts(ok(&r));
    assert_eq!((c["around"], c["first"], c["second"]), ((2, 2), (2, 2), (2, 2)), "b and d have c as their neighbour");
    assert_eq!((c["relation"], r.warnings), ((0, 1), 0));
    assert_eq!((t.file("b.txt"), t.file("d.txt")), ("16071\n".to_owned(), "256031\n".to_owned()));
}

#[test]
fn an_audit_and_a_sweep_take_it_as_it_is() {
    let t = Bench::new();
    let both = ["square", "again"];
    ok(&t.bake(&plan(&[1, 2, 3], &both)));
    let r = t.bake_with(&plan(&[1, 2, 3], &both), |o| o.audit = 1.0);
    assert_eq!((ok(&r).warnings, r.audit.unwrap().different_runs, r.hits()), (0, 0, 0));
    let r = t.bake_with(&plan(&[1, 2, 3], &both), |o| o.force = vec!["again".into()]);
    assert_eq!((ok(&r).warnings, runs(&r, "again"), runs(&r, "square"), runs(&r, "add")), (0, 3, 3, 0));
    t.gc(&Limits { keep_bakes: Some(0), max_bytes: Some(0), ..Limits::default() });
    assert!(t.verify().is_clean());
    assert_eq!(ok(&t.bake(&plan(&[1, 2, 3], &both))).warnings, 0);
}

#[test]
fn a_loss_above_is_still_a_loss() {
    let t = Bench::new();
    ok(&t.bake(&plan(&[1, 2, 3], &["again"])));
    fs::remove_dir_all(t.path("cache/values")).unwrap();
    let r = t.bake(&plan(&[1, 2, 4], &["again"]));
    assert_eq!((ok(&r).warnings, runs(&r, "again"), runs(&r, "square")), (3, 3, 3));
    assert_eq!(ok(&t.bake(&plan(&[1, 2, 4], &["again"]))).runs(), 0);
}

#[test]
fn what_fails_when_it_is_made_again_is_told() {
    let t = Bench::new();
    let build = |plus: i64| {
        let mut b = Builder::default();
        let c = b.node::<Restless>("restless", json!({}), &[]);
        let add = b.node::<Add>("add", json!({ "plus": plus }), &[From::Node(c), From::Absent]);
        let print = b.node::<Print>("print", json!({}), &[From::Node(add)]);
        b.file("n.txt", print);
        b.transient(c);
        b.plan()
    };
    ok(&t.bake(&build(1000)));
    // Made again it gives other bytes, from which all below must be made anew.
    let r = t.bake(&build(2000));
    assert_eq!((r.outcome, r.warnings > 0), (Outcome::Baked, true));
    assert_eq!(ok(&t.bake(&build(2000))).runs(), 0);
}

/// A value that counts how many of its kind are in memory.
pub struct Counted(i64, Vec<u8>);

static ALIVE: AtomicI64 = AtomicI64::new(0);
static PEAK: AtomicI64 = AtomicI64::new(0);
/// The counters are one for the whole program.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

impl Counted {
    fn new(n: i64, pad: usize) -> Arc<Self> {
        PEAK.fetch_max(ALIVE.fetch_add(1, SeqCst) + 1, SeqCst);
        Arc::new(Self(n, vec![n as u8; pad]))
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        ALIVE.fetch_sub(1, SeqCst);
    }
}

impl Artifact for Counted {
    const TYPE: &'static str = "Counted";
    const FORMAT: u32 = 1;
    fn encode(&self, out: &mut Encoder) {
        out.json("n", &self.0);
        out.bytes("pad", self.1.clone());
    }
    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        PEAK.fetch_max(ALIVE.fetch_add(1, SeqCst) + 1, SeqCst);
        Ok(Self(data.json("n")?, data.bytes("pad")?.to_vec()))
    }
}

#[derive(Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Pad {
    pad: u32,
    plus: i64,
}

ports! { pub struct Number {
    /// A number.
    value: Arc<Num>,
} }
ports! { pub struct Heavy {
    /// A heavy value.
    heavy: Arc<Counted>,
} }

struct Weigh;
impl Node for Weigh {
    const KIND: &'static str = "weigh";
    const VERSION: u32 = 1;
    type Params = Pad;
    type In = Number;
    type Out = Heavy;
    fn memory(_: &Pad, _: &[u64]) -> u64 {
        0
    }
    fn run(p: &Pad, i: Number, _: &Ctx) -> Result<Heavy, NodeError> {
        Ok(Heavy { heavy: Counted::new(i.value.0, p.pad as usize) })
    }
}

struct Reweigh;
impl Node for Reweigh {
    const KIND: &'static str = "reweigh";
    const VERSION: u32 = 1;
    type Params = Pad;
    type In = Heavy;
    type Out = Heavy;
    fn memory(_: &Pad, _: &[u64]) -> u64 {
        0
    }
    fn run(p: &Pad, i: Heavy, _: &Ctx) -> Result<Heavy, NodeError> {
        Ok(Heavy { heavy: Counted::new(i.heavy.0 + p.plus, p.pad as usize) })
    }
}

struct Lighten;
impl Node for Lighten {
    const KIND: &'static str = "lighten";
    const VERSION: u32 = 1;
    type Params = Pad;
    type In = Heavy;
    type Out = One;
    fn memory(_: &Pad, _: &[u64]) -> u64 {
        0
    }
    fn run(p: &Pad, i: Heavy, _: &Ctx) -> Result<One, NodeError> {
        Ok(One { value: Arc::new(Num(i.heavy.0 + p.plus, 0)) })
    }
}

ports! { pub struct Heap {
    /// Heavy values.
    heap: List<Counted, true>,
} }

struct Total;
impl Node for Total {
    const KIND: &'static str = "total";
    const VERSION: u32 = 1;
    type Params = Pad;
    type In = Heap;
    type Out = One;
    fn memory(_: &Pad, _: &[u64]) -> u64 {
        0
    }
    fn run(p: &Pad, i: Heap, _: &Ctx) -> Result<One, NodeError> {
        Ok(One { value: Arc::new(Num(i.heap.0.iter().map(|(_, heavy)| heavy.0).sum::<i64>() + p.plus, 0)) })
    }
}

#[test]
fn what_is_gathered_below_an_element_leaves_with_it() {
    let _alone = ONE_AT_A_TIME.lock().unwrap_or_else(|e| e.into_inner());
    let plan = |plus: i64| {
        let mut b = Builder::default();
        let names: Vec<String> = (0..30).map(|i| format!("n{i:02}")).collect();
        let values: Vec<i64> = (0..30).collect();
        let list = b.node::<MakeList>("list", json!({ "names": names, "values": values }), &[]);
        let split = b.node::<Parts>("split", json!({ "count": 8 }), &[From::Node(list)]);
        let first = b.node::<Weigh>("first", json!({ "pad": 20_000 }), &[From::Node(split)]);
        let total = b.node_inner::<Total>("total", json!({ "plus": plus }), &[From::Node(first)], &[list]);
        let print = b.node::<Print>("print", json!({}), &[From::Node(total)]);
        b.file("{name}.txt", print);
        b.transient(first);
        b.plan()
    };
    let t = Bench::new();
    PEAK.store(ALIVE.load(SeqCst), SeqCst);
    ok(&t.bake(&plan(0)));
    assert_eq!(t.file("n07.txt"), "5628\n");
    // 240 values in all, eight for each element.
    assert!(PEAK.load(SeqCst) <= 40, "{} values at a time", PEAK.load(SeqCst));
    PEAK.store(ALIVE.load(SeqCst), SeqCst);
    let r = t.bake(&plan(1));
    assert_eq!((ok(&r).warnings, runs(&r, "total"), runs(&r, "first"), runs(&r, "split")), (0, 30, 240, 0));
    assert_eq!(t.file("n07.txt"), "5629\n");
    assert!(PEAK.load(SeqCst) <= 40, "{} values at a time", PEAK.load(SeqCst));
    assert_eq!(ALIVE.load(SeqCst), 0);
}

fn heavy(count: i64, pad: u32, plus: i64, transient: bool) -> Plan {
    let mut b = Builder::default();
    let list = b.node::<MakeMany>("list", json!({ "count": count, "changed": -1 }), &[]);
    let first = b.node::<Weigh>("first", json!({ "pad": pad }), &[From::Node(list)]);
    let second = b.node::<Reweigh>("second", json!({ "pad": pad, "plus": 1000 }), &[From::Node(first)]);
    let third = b.node::<Lighten>("third", json!({ "plus": plus }), &[From::Node(second)]);
    let sum = b.node::<Sum>("sum", json!({}), &[From::Node(third)]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
    b.file("sum.txt", print);
    if transient {
        b.transient(first);
        b.transient(second);
    }
    b.plan()
}

#[test]
fn few_values_are_in_memory_at_a_time() {
    let _alone = ONE_AT_A_TIME.lock().unwrap_or_else(|e| e.into_inner());
    for transient in [false, true] {
        let t = Bench::new();
        for plus in [0, 1] {
            PEAK.store(ALIVE.load(SeqCst), SeqCst);
            let r = t.bake_with(&heavy(300, 20_000, plus, transient), |o| o.jobs = 2);
            assert_eq!(ok(&r).warnings, 0);
            let expect: i64 = (0..300).map(|i| i + 1000 + plus).sum();
            assert_eq!(t.file("sum.txt"), format!("{expect}\n"));
            // Two of each of the two heavy nodes may be out, and two more may wait for their consumers.
            assert!(PEAK.load(SeqCst) <= 8, "{} values at a time", PEAK.load(SeqCst));
        }
        assert_eq!(ALIVE.load(SeqCst), 0);
    }
}

#[test]
fn a_small_budget_makes_it_slower_and_nothing_else() {
    let _alone = ONE_AT_A_TIME.lock().unwrap_or_else(|e| e.into_inner());
    let t = Bench::new();
    // Each run needs more than half of what there is.
    let r = t.bake_with(&heavy(40, 400_000, 0, true), |o| (o.jobs, o.memory) = (4, 1_300_000));
    assert_eq!(ok(&r).warnings, 0);
    PEAK.store(0, SeqCst);
    let r = t.bake_with(&heavy(40, 400_000, 1, true), |o| (o.jobs, o.memory) = (4, 1_300_000));
    assert_eq!((ok(&r).warnings, runs(&r, "third"), runs(&r, "second"), runs(&r, "first")), (0, 40, 40, 40));
    assert!(PEAK.load(SeqCst) <= 8, "{} values at a time", PEAK.load(SeqCst));
    let r = t.bake_with(&heavy(2, 2_000_000, 0, true), |o| o.memory = 1_300_000);
    assert!(r.errors.iter().any(|e| e.message.contains("1.9 MiB of it for its inputs")), "{:?}", r.errors);
}
