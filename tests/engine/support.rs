//! Trivial kinds and a builder of plans, for tests and benchmarks of the engine alone.

use farfield::{
    engine::{
        artifact::{Artifact, DecodeError, Decoder, Encoder},
        node::{Arity, Ctx, List, Node, NodeError, SourcePath, kind},
        plan::{Axis, Bundle, File, NodeId, OutputRef, Plan, PlanInput, PlanNode, Publish, Relation, Requirement},
    },
    ports,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::{collections::BTreeMap, sync::Arc};

/// Bytes that no compression makes fewer.
fn noise(seed: i64, count: usize) -> Vec<u8> {
    let mut state = seed as u64 ^ 0x9e37_79b9_7f4a_7c15;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 56) as u8
    };
    (0..count).map(|_| next()).collect()
}

/// A number, padded to any size.
#[derive(Debug, Clone, PartialEq)]
pub struct Num(pub i64, pub usize);

impl Artifact for Num {
    const TYPE: &'static str = "Num";
    const FORMAT: u32 = 1;
    fn encode(&self, out: &mut Encoder) {
        out.json("n", &self.0);
        out.bytes("pad", noise(self.0, self.1));
    }
    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        Ok(Self(data.json("n")?, data.bytes("pad")?.len()))
    }
}

macro_rules! kinds {
    ($($ty:ident $name:literal ($($param:ident : $pty:ty),*) in $input:ident out $output:ident $(uses $uses:literal)? => $run:expr;)*) => { $(
        pub struct $ty;
        const _: () = {
            #[derive(Default, Serialize, Deserialize, JsonSchema)]
            #[serde(default, deny_unknown_fields)]
            pub struct Params { $($param: $pty),* }
            impl Node for $ty {
                const KIND: &'static str = $name;
                const VERSION: u32 = 1;
                $(const USES_NAME: bool = $uses;)?
                type Params = Params;
                type In = $input;
                type Out = $output;
                fn memory(_: &Params, sizes: &[u64]) -> u64 { sizes.iter().sum() }
                fn run(_p: &Params, i: $input, ctx: &Ctx) -> Result<$output, NodeError> {
                    ($run as fn(($(&$pty,)*), $input, &Ctx) -> Result<$output, NodeError>)(($(&_p.$param,)*), i, ctx)
                }
            }
        };
    )* };
}

ports! { pub struct Nothing {} }
ports! { pub struct One {
    /// A number.
    value: Arc<Num>,
} }
ports! { pub struct Two {
    /// First.
    a: Arc<Num>,
    /// Second.
    b: Option<Arc<Num>>,
} }
ports! { pub struct Items {
    /// Numbers.
    items: List<Num, true>,
} }
ports! { pub struct Some_ {
    /// At least one number.
    items: List<Num>,
} }
ports! { pub struct Related {
    /// The element itself.
    me: Arc<Num>,
    /// Its neighbours.
    items: List<Num, true>,
} }
ports! { pub struct Names {
    /// Who neighbours whom.
    names: Arc<Relation>,
} }
ports! { pub struct Packed {
    /// Files.
    bundle: Arc<Bundle>,
} }
ports! { pub struct Out {
    /// A file.
    file: Arc<File>,
} }

fn num(n: i64) -> One {
    One { value: Arc::new(Num(n, 0)) }
}

/// The sum, which wraps: graphs that are drawn at random square squares.
fn total<const EMPTY: bool>(items: &List<Num, EMPTY>) -> i64 {
    items.0.iter().fold(0, |sum, (_, n)| sum.wrapping_add(n.0))
}

fn file(text: String) -> Out {
    Out { file: Arc::new(File { media_type: "text/plain".into(), bytes: text.into_bytes() }) }
}

fn list(names: &[String], values: &[i64]) -> Items {
    let item = |(n, v): (&String, &i64)| (n.clone(), Arc::new(Num(*v, 0)));
    Items { items: List(names.iter().zip(values).map(item).collect()) }
}

kinds! {
    Constant "constant" (value: i64, pad: u32) in Nothing out One =>
        |(v, pad), _, _| Ok(One { value: Arc::new(Num(*v, *pad as usize)) });
    Add "add" (plus: i64) in Two out One => |(plus,), i, _| Ok(num(i.a.0.wrapping_add(i.b.map_or(0, |b| b.0)).wrapping_add(*plus)));
    MakeList "list" (names: Vec<String>, values: Vec<i64>) in Nothing out Items => |(n, v), _, _| Ok(list(n, v));
    MakeMany "many" (count: i64, changed: i64) in Nothing out Items =>
        |(n, c), _, _| {
            let names: Vec<String> = (0..*n).map(|i| format!("e{i:06}")).collect();
            let values: Vec<i64> = (0..*n).map(|i| if i == *c { -1 } else { i }).collect();
            Ok(list(&names, &values))
        };
    Padded "padded" (count: i64, pad: u32) in Nothing out Items =>
        |(n, pad), _, _| {
            let item = |i: i64| (format!("e{i}"), Arc::new(Num(i, *pad as usize)));
            Ok(Items { items: List((0..*n).map(item).collect()) })
        };
    Split "split" () in One out Items =>
        |_, i, _| {
            let names: Vec<String> = (0..i.value.0).map(|k| format!("part{k}")).collect();
            let values: Vec<i64> = (0..i.value.0).collect();
            Ok(list(&names, &values))
        };
    Parts "parts" (count: i64) in One out Items =>
        |(count,), i, _| {
            let names: Vec<String> = (0..*count).map(|k| format!("part{k}")).collect();
            let values: Vec<i64> = (0..*count).map(|k| i.value.0 * 100 + k).collect();
            Ok(list(&names, &values))
        };
    Square "square" (pad: u32) in One out One =>
        |(pad,), i, _| Ok(One { value: Arc::new(Num(i.value.0.wrapping_mul(i.value.0), *pad as usize)) });
    Sum "sum" () in Items out One => |_, i, _| Ok(num(total(&i.items)));
    SumSome "sum-some" () in Some_ out One => |_, i, _| Ok(num(total(&i.items)));
    Around "around" () in Related out One => |_, i, _| Ok(num(i.me.0.wrapping_mul(1000).wrapping_add(total(&i.items))));
    Neighbours "neighbours" (names: BTreeMap<String, Vec<String>>) in Nothing out Names =>
        |(n,), _, _| Ok(Names { names: Arc::new(Relation(n.clone())) });
    Picky "picky" () in One out One =>
        |_, i, _| match i.value.0 {
            13 => panic!("thirteen"),
            n if n % 2 != 0 => Err(NodeError::Failed(format!("{n} is odd"))),
            n => Ok(num(n)),
        };
    Named "named" () in One out One uses true =>
        |_, i, ctx| Ok(num(i.value.0.wrapping_add(ctx.element.map_or(0, |n| n.len() as i64))));
    Warner "warner" () in One out One =>
        |_, i, ctx| { (ctx.warn)(format!("saw {}", i.value.0)); Ok(num(i.value.0)) };
    Restless "restless" () in Nothing out One =>
        |_, _, _| {
            static COUNT: std::sync::atomic::AtomicI64 = std::sync::atomic::AtomicI64::new(0);
            Ok(num(COUNT.fetch_add(1, std::sync::atomic::Ordering::Relaxed)))
        };
    Greedy "greedy" () in One out One => |_, i, _| Ok(num(i.value.0));
    Slow "slow" (ms: u64) in One out One =>
        |(ms,), i, ctx| {
            let end = std::time::Instant::now() + std::time::Duration::from_millis(*ms);
            while std::time::Instant::now() < end {
                ctx.stop.check()?;
                std::thread::sleep(std::time::Duration::from_millis(1));
            }
            Ok(num(i.value.0))
        };
    Source "source" (path: SourcePath) in Nothing out One =>
        |(path,), _, ctx| {
            let read = |p: &std::path::Path| -> Result<Option<String>, NodeError> {
                Ok(ctx.door.read(p)?.map(|b| String::from_utf8_lossy((*b).as_ref()).into_owned()))
            };
            if let Some(n) = path.0.strip_prefix("builtin:") {
                return Ok(num(n.parse().expect("a number")));
            }
            let main = read(path.0.as_ref())?.expect("the root file");
            let extra = read("extra.txt".as_ref())?.unwrap_or_default();
            Ok(num(main.trim().parse::<i64>().expect("a number") + extra.trim().parse::<i64>().unwrap_or(0)))
        };
    Print "print" () in One out Out => |_, i, _| Ok(file(format!("{}\n{}", i.value.0, "x".repeat(i.value.1))));
    Pack "pack" (extra: bool) in One out Packed =>
        |(extra,), i, _| {
            let text = |text: String| File { media_type: "text/plain".into(), bytes: text.into_bytes() };
            let mut files = BTreeMap::from([
                ("main.json".to_owned(), text(format!("{}", i.value.0))),
                ("parts/even.txt".to_owned(), text(format!("{}", i.value.0 / 2 * 2))),
            ]);
            if *extra {
                files.insert("parts/extra.txt".into(), text("extra".into()));
            }
            Ok(Packed { bundle: Arc::new(Bundle::new("main.json", files).map_err(NodeError::Failed)?) })
        };
    Certify "certify" () in One out Out => |_, i, _| Ok(file(format!("{{\"error\":{{\"max\":{}}}}}", i.value.0)));
}

/// Builds plans; axes follow from ports as a pipeline's would.
#[derive(Default)]
pub struct Builder {
    nodes: Vec<PlanNode>,
    files: Vec<Publish>,
    require: Vec<Requirement>,
    /// Axes of every output.
    axes: BTreeMap<OutputRef, Vec<Axis>>,
}

/// Where a port takes its value from.
#[derive(Clone, Copy)]
pub enum From {
    Node(usize),
    Via(usize, usize),
    Absent,
}

pub fn at(node: usize) -> OutputRef {
    OutputRef { node: NodeId(node as u32), port: 0 }
}

impl Builder {
    pub fn node<N: Node>(&mut self, name: &str, params: Value, inputs: &[From]) -> usize {
        self.node_inner::<N>(name, params, inputs, &[])
    }

    /// A node whose list ports gather only below these axes.
    pub fn node_inner<N: Node>(&mut self, name: &str, params: Value, inputs: &[From], per: &[usize]) -> usize {
        let kind = kind::<N>();
        let per: Vec<Axis> = per.iter().map(|n| at(*n)).collect();
        let mut axes: Vec<Axis> = Vec::new();
        let mut plan_inputs = Vec::new();
        for (from, port) in inputs.iter().zip(&kind.spec().inputs) {
            let (from, via) = match from {
                From::Node(n) => (at(*n), None),
                From::Via(n, v) => (at(*n), Some(at(*v))),
                From::Absent => {
                    plan_inputs.push(PlanInput::default());
                    continue;
                }
            };
            let source = self.axes[&from].clone();
            let many = matches!(port.arity, Arity::Many { .. });
            let gathered: Vec<Axis> =
                source.iter().filter(|a| many && (via.is_some() || !per.contains(a))).copied().collect();
            for axis in source.iter().filter(|a| !gathered.contains(a)) {
                if !axes.contains(axis) {
                    axes.push(*axis);
                }
            }
            plan_inputs.push(PlanInput { from: Some(from), axes: source, via, gathered });
        }
        let id = self.nodes.len();
        for (port, spec) in kind.spec().outputs.iter().enumerate() {
            let out = OutputRef { node: NodeId(id as u32), port: port as u32 };
            let mut of = axes.clone();
            if matches!(spec.arity, Arity::Many { .. }) {
                of.push(out);
            }
            self.axes.insert(out, of);
        }
        let params = kind.accept(params).expect("parameters");
        self.nodes.push(PlanNode {
            name: name.into(),
            kind,
            params,
            inputs: plan_inputs,
            axes,
            join_inner: false,
            transient: false,
        });
        id
    }

    /// The bytes of the node's outputs are not kept.
    pub fn transient(&mut self, node: usize) {
        self.nodes[node].transient = true;
    }

    pub fn file(&mut self, path: &str, node: usize) {
        self.files.push(Publish { path: path.into(), from: at(node) });
    }

    pub fn require(&mut self, node: usize, path: &str, max: f64) {
        self.require.push(Requirement { from: at(node), path: path.into(), min: None, max: Some(max) });
    }

    pub fn plan(self) -> Plan {
        let Self { nodes, files, require, .. } = self;
        Plan { name: "test".into(), file: "test.toml".into(), nodes, files, require, ..Plan::default() }
    }
}
