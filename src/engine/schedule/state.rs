//! What the schedule knows of nodes and their runs.

use super::RunId;
use crate::engine::{
    cache::lock::KeyLock,
    elements::{Binding, Rows},
    hash::Digest,
    key::{self, SourceKey},
    plan::{Axis, OutputRef},
    record::MapRow,
    report::Forecast,
    source::Root,
    value::{PortOut, ValueRef},
};
use std::{collections::BTreeMap, ops::Bound, sync::Arc};

/// The states of a run, and of a node as the sum of its runs.
///
/// ```text
///              all its inputs settled          a record is in the index
///   Waiting ────────────────────────▶ (keyed) ─────────────────────────▶ Hit ◀────────────┐
///    ▲  ▲ ▲                              │ none is                        │ a value of it │ the other
///    │  │ │                              ▼                                │ is needed and │ stored one
///    │  │ │                            Ready ◀────────────────────────────┤ not there     │
///    │  │ │          slot, memory and  │   ▲ │  key held by another       │               │
///    │  │ │          key lock are had  │   │ └───────────────────────▶ Elsewhere ─────────┘
///    │  │ │                            │   └──── the other gave up ───────┘ │
///    │  │ │ an input's value is not    ▼                                  │
///    │  │ └── there: its producer ◀─ Running ─────▶ Ran ──────────────────┘ (a value of it is needed and not there)
///    │  │     runs again              │
///    │  └──────── stopped ◀──────────┘ │
///    │                                 └─────────▶ Failed
///    └─ something above failed ──▶ Skipped
/// ```
///
/// A node is open as soon as some of its runs may be keyed, closed when all of them are known, and settled when all of
/// them are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum State {
    /// For what is above it, or for an input to be made again.
    #[default]
    Waiting,
    /// It has to run.
    Ready,
    /// Another process, or another node with an equal key, is making its result; or the second level of the cache is
    /// asked for it.
    Elsewhere,
    Running,
    /// Its result came from the cache.
    Hit,
    Ran,
    Failed,
    /// Something that it needs failed.
    Skipped,
}

impl State {
    pub fn is_settled(self) -> bool {
        matches!(self, Self::Hit | Self::Ran | Self::Failed | Self::Skipped)
    }

    /// Whether there are outputs.
    pub fn is_good(self) -> bool {
        matches!(self, Self::Hit | Self::Ran)
    }
}

/// Who goes on when a value is there again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Waiter {
    /// A run, for this value.
    Run(RunId, Digest),
    /// A node that could not be keyed without the value.
    Node(usize),
    /// Whoever publishes the results, or is told when it has arrived.
    Outside,
}

/// Why a run runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    Missing,
    Forced,
    Audit,
    /// The cache has lost a value of it.
    Lost,
    /// A value of it that is not kept is needed.
    Remade,
}

/// What a node knows of each of its elements, of which there may be many: small.
pub(super) struct Run {
    pub name: Arc<str>,
    pub key: Digest,
    pub state: State,
    pub cause: Cause,
    pub outputs: Box<[PortOut]>,
    /// Only between its start, or the wish for it, and its end.
    busy: Option<Box<Busy>>,
}

/// What a run needs while it is no mere result.
#[derive(Default)]
pub(super) struct Busy {
    /// Inputs that are being made again.
    pub missing: usize,
    pub waiters: Vec<Waiter>,
    pub lock: Option<KeyLock>,
    /// Bytes reserved while it runs.
    pub memory: u64,
    /// Inputs that were made again for it.
    pub pinned: Vec<Digest>,
}

impl Run {
    pub fn new(name: Arc<str>, key: Digest, state: State, cause: Cause) -> Self {
        Self { name, key, state, cause, outputs: Box::default(), busy: None }
    }

    /// One whose result is known.
    pub fn hit(name: Arc<str>, key: Digest, outputs: &[PortOut]) -> Self {
        Self { outputs: outputs.into(), ..Self::new(name, key, State::Hit, Cause::Missing) }
    }

    pub fn busy(&mut self) -> &mut Busy {
        self.busy.get_or_insert_default()
    }

    pub fn take_busy(&mut self) -> Busy {
        self.busy.take().map_or_else(Busy::default, |busy| *busy)
    }

    /// Whether its result is made a second time, for others that need it.
    pub fn is_again(&self) -> bool {
        matches!(self.cause, Cause::Lost | Cause::Remade)
    }

    /// The names of the rows that it gives through output port `port`, and their values.
    pub fn rows(&self, port: u32) -> Vec<(Arc<str>, ValueRef)> {
        match self.outputs.get(port as usize) {
            Some(PortOut::One(value)) => vec![(self.name.clone(), *value)],
            Some(PortOut::Many(list)) => {
                let full = |name: &str| crate::engine::value::join(&self.name, name).into();
                list.iter().map(|(name, value)| (full(name), *value)).collect()
            }
            None => Vec::new(),
        }
    }
}

/// One output port of a settled node.
#[derive(Clone)]
pub(super) struct Output {
    pub hash: Digest,
    /// Stored size, where it is one value.
    pub size: Option<u64>,
    /// Loaded when someone asks.
    pub rows: Option<Rows>,
}

/// Elements below which something failed: names on some axes.
pub(super) type Broken = BTreeMap<Axis, String>;

/// Who takes the values of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Takers {
    /// So many runs take each value, each once.
    Runs(u32),
    /// Some of those who take them gather or repeat them: they are of use until those nodes are settled.
    Nodes,
}

#[derive(Default)]
pub(super) struct NodeState {
    pub wanted: bool,
    pub state: State,
    /// Producers not yet settled.
    pub waits: usize,
    /// Of these, producers without all of whose results no run can start.
    pub gates: usize,
    /// The output whose rows are the node's elements, where runs may start before all of them are known.
    pub driver: Option<OutputRef>,
    /// Whether runs are admitted as their inputs arrive.
    pub flows: bool,
    /// All runs are known.
    pub closed: bool,
    pub consumers: Vec<usize>,
    /// Of each output port.
    pub takers: Vec<Takers>,
    /// Consumers not yet settled.
    pub live: usize,
    pub fixed: Digest,
    /// Keys of its runs, while some may still be admitted.
    pub keys: Option<key::Runs>,
    /// The last bake's runs, by name.
    pub before: Option<Vec<MapRow>>,
    /// What failed above in producers that are settled.
    pub lost_above: Vec<Broken>,
    pub source_keys: Vec<(String, SourceKey)>,
    pub roots: Arc<Vec<Root>>,
    /// What its lists are as wholes: the inputs of its key.
    pub inputs: Vec<Option<Digest>>,
    pub key: Digest,
    pub variant: Digest,
    /// Whether any run read files besides root files: such a node is never believed as a whole.
    pub reads: bool,
    pub outputs: Vec<Output>,
    pub warnings: Vec<(String, String)>,
    /// Sorted by name where the node does not flow.
    pub runs: Vec<Run>,
    /// Numbers of runs by name, where they come in any order.
    pub by_name: BTreeMap<Arc<str>, u32>,
    /// What runs warned of, by name.
    pub warned: BTreeMap<Arc<str>, Vec<String>>,
    pub binding: Option<Binding>,
    /// Runs not settled.
    pub pending: usize,
    /// Bytes of outputs that a run gave at most.
    pub largest: u64,
    pub hits: u64,
    pub ran: u64,
    pub failed: u64,
    pub skipped: u64,
    pub seconds: f64,
    pub broken: Vec<Broken>,
    pub note: &'static str,
    pub forecast: Option<Forecast>,
}

impl NodeState {
    /// The number of the run of an element.
    pub fn run_of(&self, name: &str) -> Option<usize> {
        if self.flows {
            return self.by_name.get(name).map(|at| *at as usize);
        }
        self.runs.binary_search_by(|run| (*run.name).cmp(name)).ok()
    }

    /// Notes the result of a run, which is new or found.
    pub fn note_result(&mut self, run: usize, outputs: &[PortOut], warnings: &[String]) {
        let run = &mut self.runs[run];
        run.outputs = outputs.into();
        if warnings.is_empty() {
            self.warned.remove(&run.name);
        } else {
            self.warned.insert(run.name.clone(), warnings.to_vec());
        }
    }

    /// Puts the runs of a node that has come to its end into the order of their names.
    pub fn sort(&mut self) {
        if std::mem::take(&mut self.flows) {
            self.runs.sort_by(|a, b| a.name.cmp(&b.name));
            self.by_name.clear();
        }
    }

    /// Whether all runs whose names begin with the names of `prefix` have ended well. The last one is asked first: it
    /// is mostly the last to end.
    pub fn is_good_below(&self, prefix: &str) -> bool {
        self.below(prefix).rev().all(|at| self.runs[at].state.is_good())
    }

    /// Numbers of the runs whose names begin with the names of `prefix`.
    pub fn runs_below(&self, prefix: &str) -> Vec<usize> {
        self.below(prefix).collect()
    }

    fn below(&self, prefix: &str) -> Box<dyn DoubleEndedIterator<Item = usize> + '_> {
        // What comes after all names that are longer by a component.
        let end = format!("{prefix}{AFTER_JOIN}");
        let all = prefix.is_empty();
        if self.flows {
            let to = if all { Bound::Unbounded } else { Bound::Excluded(&*end) };
            return Box::new(self.by_name.range::<str, _>((Bound::Included(prefix), to)).map(|(_, at)| *at as usize));
        }
        let first = self.runs.partition_point(|run| &*run.name < prefix);
        let last = if all { self.runs.len() } else { self.runs.partition_point(|run| *run.name < *end) };
        Box::new(first..last)
    }
}

/// The character after [`JOIN`](crate::engine::value::JOIN).
const AFTER_JOIN: char = ' ';

/// Whether the names of `name` begin with those of `prefix`.
pub(super) fn is_below(name: &str, prefix: &str) -> bool {
    let rest = name.strip_prefix(prefix);
    prefix.is_empty() || rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(crate::engine::value::JOIN))
}

/// Bytes of all outputs of a run.
pub(super) fn size_of(outputs: &[PortOut]) -> u64 {
    let size = |out: &PortOut| match out {
        PortOut::One(value) => value.size,
        PortOut::Many(list) => list.iter().map(|(_, value)| value.size).sum(),
    };
    outputs.iter().map(size).sum()
}
