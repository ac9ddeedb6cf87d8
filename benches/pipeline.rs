//! Pipeline files of trivial nodes: reading and checking them, and the bake that finds nothing to do.

use criterion::{Criterion, criterion_group, criterion_main};
use farfield::{
    engine::{
        artifact::{Artifact, DecodeError, Decoder, Encoder},
        bake::{Options, bake},
        events::Silent,
        node::{Ctx, Node, NodeError},
        pipeline::{Request, load_text},
        plan::Plan,
        registry::Registry,
    },
    math::Stop,
    ports,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{fmt::Write, hint::black_box, path::Path, sync::Arc};

/// A number.
struct Number(i64);

impl Artifact for Number {
    const TYPE: &'static str = "Number";
    const FORMAT: u32 = 1;
    fn encode(&self, out: &mut Encoder) {
        out.json("number", &self.0);
    }
    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        Ok(Self(data.json("number")?))
    }
}

/// Adds a number.
#[derive(Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct Params {
    /// What is added.
    add: i64,
}

ports! {
    struct In {
        /// What it is added to.
        value: Option<Arc<Number>>,
    }
}

ports! {
    struct Out {
        /// The sum.
        sum: Arc<Number>,
    }
}

struct Add;

impl Node for Add {
    const KIND: &'static str = "add";
    const VERSION: u32 = 1;
    type Params = Params;
    type In = In;
    type Out = Out;
    fn memory(_: &Params, _: &[u64]) -> u64 {
        0
    }
    fn run(params: &Params, inputs: In, _: &Ctx) -> Result<Out, NodeError> {
        Ok(Out { sum: Arc::new(Number(params.add.wrapping_add(inputs.value.map_or(0, |v| v.0)))) })
    }
}

/// A binary tree of `count` nodes that each add their own number.
fn tree(count: usize) -> String {
    let mut text = String::from("[params]\nfirst = 1\n");
    for i in 0..count {
        write!(text, "\n[nodes.n{i}]\nkind = \"add\"\n").expect("a String takes all");
        match i {
            0 => text += "add = \"{first}\"\n",
            _ => write!(text, "value = \"n{}\"\nadd = {i}\n", i / 2).expect("a String takes all"),
        }
    }
    text
}

fn check(text: &str) -> Plan {
    let mut registry = Registry::default();
    registry.add::<Add>();
    let request = Request::new("tree.toml", Path::new("."), &[]);
    load_text("tree.toml", text, &request, &registry).unwrap_or_else(|problems| panic!("{problems}"))
}

fn benches(c: &mut Criterion) {
    for count in [1_000, 10_000] {
        let text = tree(count);
        c.bench_function(&format!("check {count} nodes"), |b| b.iter(|| black_box(check(&text)).nodes.len()));
        let folder = tempfile::tempdir().expect("a temporary folder");
        let options = Options::new(folder.path().join("cache"), folder.path().join("out"));
        let first = bake(&check(&text), &options, &Stop::default(), &Silent).expect("a sound bake");
        assert_eq!(first.runs(), count as u64);
        c.bench_function(&format!("check and no-op bake of {count} nodes"), |b| {
            b.iter(|| {
                let report = bake(&check(&text), &options, &Stop::default(), &Silent).expect("a sound bake");
                assert_eq!(report.runs(), 0);
            });
        });
    }
}

criterion_group! { name = group; config = Criterion::default().sample_size(20); targets = benches }
criterion_main!(group);
