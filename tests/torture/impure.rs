//! Kinds that do not give the same bytes for the same inputs: an audit finds and names them.

use super::{Bench, ok, support::*};
use farfield::engine::{
    bake::Outcome,
    node::{Ctx, Node, NodeError},
    plan::Plan,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::sync::{
    Arc,
    atomic::{AtomicI64, Ordering},
};

/// Gives what it takes, except 13: that grows from run to run.
struct Drifting;

#[derive(Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct Params {}

impl Node for Drifting {
    const KIND: &'static str = "drifting";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = One;
    type Out = One;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        sizes.iter().sum()
    }

    fn run(_: &Params, inputs: One, _: &Ctx) -> Result<One, NodeError> {
        static COUNT: AtomicI64 = AtomicI64::new(0);
        let n = inputs.value.0;
        let more = if n == 13 { COUNT.fetch_add(1, Ordering::Relaxed) } else { 0 };
        Ok(One { value: Arc::new(Num(n + more, 20_000)) })
    }
}

fn plan() -> Plan {
    let mut b = Builder::default();
    let names: Vec<String> = (0..20).map(|i| format!("n{i}")).collect();
    let values: Vec<i64> = (0..20).collect();
    let list = b.node::<MakeList>("list", json!({ "names": names, "values": values }), &[]);
    let drift = b.node::<Drifting>("drift", json!({}), &[From::Node(list)]);
    let sum = b.node::<Sum>("sum", json!({}), &[From::Node(drift)]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
    b.file("sum.txt", print);
    b.plan()
}

#[test]
fn an_audit_names_the_element_that_drifts() {
    let t = Bench::new();
    ok(&t.bake(&plan()));
    let before = t.file("sum.txt");
    let report = t.bake_with(&plan(), |o| o.audit = 1.0);
    assert_eq!(report.outcome, Outcome::Failed);
    let named: Vec<_> = report.errors.iter().map(|e| (e.node.as_str(), e.element.as_deref())).collect();
    assert_eq!(named, [("drift", Some("n13"))], "{:?}", report.errors);
    assert!(report.errors[0].message.contains("not deterministic"), "{:?}", report.errors);
    let audit = report.audit.unwrap();
    // What failed ends the bake: others may not have been audited.
    assert!(audit.different_runs == 1 && audit.runs >= 2, "{audit:?}");
    assert!((1..=audit.bytes).contains(&audit.different_bytes), "{audit:?}");
    assert_eq!(t.file("sum.txt"), before, "nothing is published of a bake that failed");
    // The audit stores nothing of it: what the cache holds is what it held.
    assert_eq!(ok(&t.bake(&plan())).runs(), 0);
    assert!(t.verify().is_clean());
}

#[test]
fn audits_of_a_share_find_it_in_time() {
    let t = Bench::new();
    ok(&t.bake(&plan()));
    let began = std::time::Instant::now();
    // Which share is drawn follows from the second: a half misses one result for 40 seconds once in 10¹² times.
    let found = std::iter::repeat_with(|| t.bake_with(&plan(), |o| o.audit = 0.5)).find(|report| {
        let failed = report.outcome == Outcome::Failed;
        if !failed {
            assert!(began.elapsed().as_secs() < 40, "not found");
            std::thread::sleep(std::time::Duration::from_millis(200));
        }
        failed
    });
    let report = found.unwrap();
    assert_eq!(report.errors[0].element.as_deref(), Some("n13"), "{:?}", report.errors);
}
