//! The schedule: brings every wanted node to its end.
//!
//! One thread owns the graph, the index and all states; tasks on the pool compute and answer by a message. At most
//! `jobs` tasks are out, and each has its memory reserved before it starts. Nothing on the pool waits: locks of other
//! processes are polled here, values are handed to a task with its start.

mod audit;
mod held;
mod open;
mod pool;
mod read;
mod settle;
mod start;
mod task;

pub use pool::Pool;
pub use task::panic_text;

use super::{
    cache::{Cache, lock::KeyLock},
    elements::{Binding, Rows},
    error::EngineError,
    events::{Event, Events},
    hash::Digest,
    key::SourceKey,
    node::Data,
    options::Options,
    plan::{Axis, OutputRef, Plan},
    profile::Profile,
    record::BakeRecord,
    report::{Audit, Failure, Forecast},
    source::Root,
    value::{PortOut, shown},
};
use crate::math::Stop;
use held::Held;
use std::{
    collections::{BTreeMap, BTreeSet, VecDeque},
    path::PathBuf,
    sync::{Arc, mpsc},
    time::{Duration, Instant},
};
use task::Done;

/// The states of a run, and of a node as the sum of its runs.
///
/// ```text
///              all inputs settled              a record is in the index
///   Waiting ────────────────────────▶ (keyed) ─────────────────────────▶ Hit ◀────────────┐
///    ▲  ▲ ▲                              │ none is                        │ a value of it │ the other
///    │  │ │                              ▼                                │ is lost       │ stored one
///    │  │ │                            Ready ◀────────────────────────────┤               │
///    │  │ │          slot, memory and  │   ▲ │  key held by another       │               │
///    │  │ │          key lock are had  │   │ └───────────────────────▶ Elsewhere ─────────┘
///    │  │ │                            │   └──── the other gave up ───────┘ │
///    │  │ │ an input's value is lost:  ▼                                  │
///    │  │ └── its producer runs ◀─ Running ──────▶ Ran ───────────────────┘ (a value of it is lost)
///    │  └──────── stopped ◀──────────┘ │
///    │                                 └─────────▶ Failed
///    └─ something above failed ──▶ Skipped
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// For what is above it, or for a lost input to be made again.
    Waiting,
    /// It has to run.
    Ready,
    /// Another process, or another node with an equal key, is making its result.
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
    fn is_settled(self) -> bool {
        matches!(self, Self::Hit | Self::Ran | Self::Failed | Self::Skipped)
    }
}

/// How much of what the cache says at the level of whole nodes is believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trust {
    /// The last bake record and whole maps.
    Nodes,
    /// Only results of single runs.
    Runs,
}

/// A run: element `run` of node `node`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct RunId {
    node: usize,
    run: usize,
}

/// What a task says to the schedule.
enum Answer {
    Done(RunId, Box<Done>),
    /// So many of so many steps are done.
    Step(RunId, u64, u64),
}

/// Who goes on when a lost value is there again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Waiter {
    Run(RunId),
    /// A node that could not be keyed without the value.
    Node(usize),
    /// Whoever publishes the results.
    Outside,
}

/// Why a run runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cause {
    Missing,
    Forced,
    Audit,
    Lost,
}

struct Run {
    name: Arc<str>,
    key: Digest,
    state: State,
    cause: Cause,
    outputs: Vec<PortOut>,
    warnings: Vec<String>,
    /// Lost inputs that are being made again.
    missing: usize,
    waiters: Vec<Waiter>,
    lock: Option<KeyLock>,
    /// Bytes reserved while it runs.
    memory: u64,
}

/// One output port of a settled node.
#[derive(Clone)]
struct Output {
    hash: Digest,
    /// Stored size, where it is one value.
    size: Option<u64>,
    /// Loaded when someone asks.
    rows: Option<Rows>,
}

/// Elements below which something failed: names on some axes.
type Broken = BTreeMap<Axis, String>;

struct NodeState {
    wanted: bool,
    state: State,
    /// Producers not yet settled.
    waits: usize,
    consumers: Vec<usize>,
    /// Consumers not yet settled.
    live: usize,
    fixed: Digest,
    source_keys: Vec<(String, SourceKey)>,
    roots: Arc<Vec<Root>>,
    /// What its lists are as wholes: the inputs of its key.
    inputs: Vec<Option<Digest>>,
    key: Digest,
    variant: Digest,
    /// Whether any run read files besides root files: such a node is never believed as a whole.
    reads: bool,
    outputs: Vec<Output>,
    warnings: Vec<(String, String)>,
    runs: Vec<Run>,
    binding: Option<Binding>,
    /// Runs not settled.
    pending: usize,
    hits: u64,
    ran: u64,
    failed: u64,
    skipped: u64,
    seconds: f64,
    broken: Vec<Broken>,
    note: &'static str,
    forecast: Option<Forecast>,
}

pub struct Schedule<'a> {
    pub plan: &'a Plan,
    options: &'a Options,
    stop: &'a Stop,
    pub events: &'a dyn Events,
    pub cache: &'a mut Cache,
    pub profile: &'a mut Profile,
    /// The last bake of this pipeline into this folder.
    previous: &'a BakeRecord,
    /// Made when a node does not stand where it stood.
    previous_by_name: std::cell::OnceCell<BTreeMap<&'a str, usize>>,
    /// Per kind and method: the hash of its share of keys, and its source parameters.
    kinds: BTreeMap<(&'static str, &'static str), (Digest, Vec<&'a str>)>,
    trust: Trust,
    forced: BTreeSet<usize>,
    jobs: usize,
    /// Of the budget, and in use.
    memory: u64,
    memory_used: u64,
    nodes: Vec<NodeState>,
    to_open: VecDeque<usize>,
    ready: VecDeque<RunId>,
    /// Runs whose keys other processes hold, and since when.
    elsewhere: Vec<(RunId, Instant)>,
    /// Holders whose names were told.
    told: BTreeSet<String>,
    /// Keys whose runs are out, and who waits for them.
    flying: BTreeMap<Digest, Vec<RunId>>,
    running: usize,
    held: Held,
    pool: &'a Pool,
    answers: (mpsc::Sender<Answer>, mpsc::Receiver<Answer>),
    /// Values set aside, and how often.
    lost: BTreeMap<Digest, u32>,
    /// Files that runs read through the door besides root files, this time or when their results were stored.
    files_read: BTreeSet<PathBuf>,
    /// Slots of the profile's rows in use.
    lanes: Vec<Option<RunId>>,
    /// When those who wait for other processes were last looked after.
    polled: Instant,
    pub errors: Vec<Failure>,
    pub warnings: usize,
    pub audit: Audit,
}

/// What a schedule works with besides the plan.
pub struct Setting<'a> {
    pub options: &'a Options,
    pub stop: &'a Stop,
    pub events: &'a dyn Events,
    pub cache: &'a mut Cache,
    pub profile: &'a mut Profile,
    pub previous: &'a BakeRecord,
    pub trust: Trust,
    pub pool: &'a Pool,
    pub wanted: &'a [bool],
    pub forced: BTreeSet<usize>,
    pub jobs: usize,
    pub memory: u64,
}

impl<'a> Schedule<'a> {
    pub fn new(plan: &'a Plan, s: Setting<'a>) -> Self {
        let count = plan.nodes.len();
        let mut nodes: Vec<NodeState> = s.wanted.iter().map(|wanted| NodeState::new(*wanted)).collect();
        let mut seen = Vec::new();
        for (i, node) in plan.nodes.iter().enumerate().filter(|(i, _)| s.wanted[*i]) {
            seen.clear();
            for from in node.inputs.iter().flat_map(|input| [input.from, input.via]).flatten() {
                let producer = from.node.0 as usize;
                if !seen.contains(&producer) {
                    seen.push(producer);
                    nodes[producer].consumers.push(i);
                    nodes[producer].live += 1;
                }
            }
            nodes[i].waits = seen.len();
        }
        let to_open = (0..count).filter(|i| nodes[*i].wanted && nodes[*i].waits == 0).collect();
        Self {
            plan,
            options: s.options,
            stop: s.stop,
            events: s.events,
            cache: s.cache,
            profile: s.profile,
            previous: s.previous,
            previous_by_name: std::cell::OnceCell::new(),
            kinds: BTreeMap::new(),
            trust: s.trust,
            forced: s.forced,
            jobs: s.jobs,
            memory: s.memory,
            memory_used: 0,
            nodes,
            to_open,
            ready: VecDeque::new(),
            elsewhere: Vec::new(),
            told: BTreeSet::new(),
            flying: BTreeMap::new(),
            running: 0,
            held: Held::new(s.memory / 4),
            pool: s.pool,
            answers: mpsc::channel(),
            lost: BTreeMap::new(),
            files_read: BTreeSet::new(),
            lanes: vec![None; s.jobs],
            polled: Instant::now(),
            errors: Vec::new(),
            warnings: 0,
            audit: Audit::default(),
        }
    }

    /// Works until nothing more can be done: everything is settled, something failed, or a stop was asked for.
    /// After an error, the tasks that are out have ended.
    pub fn work(&mut self) -> Result<(), EngineError> {
        let result = self.work_inner();
        while self.running > 0 {
            let Ok(answer) = self.answers.1.recv() else { break };
            // The first error is the one to tell; results are kept as far as the cache takes them.
            let _ = self.take(answer);
        }
        self.cache.end()?;
        result?;
        self.cache.flush()
    }

    fn work_inner(&mut self) -> Result<(), EngineError> {
        loop {
            self.cache.begin()?;
            while let Some(node) = self.to_open.pop_front() {
                if self.halted() {
                    break;
                }
                self.open(node)?;
            }
            self.cache.end()?;
            self.tell_damage();
            if !self.halted() {
                self.look_elsewhere()?;
                self.start_ready()?;
            }
            if !self.to_open.is_empty() && !self.halted() {
                continue;
            }
            if self.running == 0 && (self.halted() || self.ready.is_empty() && self.elsewhere.is_empty()) {
                return Ok(());
            }
            self.receive()?;
        }
    }

    /// Waits for an answer, or for a moment where something else may change.
    fn receive(&mut self) -> Result<(), EngineError> {
        let first = if self.elsewhere.is_empty() && !self.cache.has_pending() {
            self.answers.1.recv().ok()
        } else {
            match self.answers.1.recv_timeout(Duration::from_millis(20)) {
                Ok(answer) => Some(answer),
                Err(_) => {
                    self.cache.flush()?;
                    None
                }
            }
        };
        let mut answer = first;
        while let Some(given) = answer {
            self.take(given)?;
            answer = self.answers.1.try_recv().ok();
        }
        Ok(())
    }

    fn take(&mut self, answer: Answer) -> Result<(), EngineError> {
        match answer {
            Answer::Done(id, done) => self.settle(id, *done),
            Answer::Step(id, done, total) => {
                let element = shown(&self.nodes[id.node].runs[id.run].name);
                let element = Some(element.as_str()).filter(|e| !e.is_empty());
                self.events.event(&Event::Step { node: self.name(id.node), element, done, total });
                Ok(())
            }
        }
    }

    /// Nothing new is started any more.
    fn halted(&self) -> bool {
        self.stop.is_set() || !self.errors.is_empty() && !self.options.keep_going
    }

    fn name(&self, node: usize) -> &'a str {
        &self.plan.nodes[node].name
    }

    fn warn(&mut self, node: Option<usize>, element: Option<&str>, text: &str) {
        self.warnings += 1;
        let node = node.map(|n| self.name(n));
        self.events.event(&Event::Warning { node, element, text });
    }

    /// A warning about the cache or the output folder.
    pub fn tell(&mut self, text: &str) {
        self.warn(None, None, text);
    }

    /// All files of the outside world that the results come from.
    pub fn files_read(&self) -> Vec<PathBuf> {
        let roots = self.nodes.iter().flat_map(|n| n.roots.iter()).map(|root| root.path.clone());
        roots.chain(self.files_read.iter().cloned()).collect()
    }

    fn tell_damage(&mut self) {
        for text in std::mem::take(&mut self.cache.warnings) {
            self.warn(None, None, &text);
        }
    }

    fn output(&self, from: OutputRef) -> &Output {
        &self.nodes[from.node.0 as usize].outputs[from.port as usize]
    }

    fn run_mut(&mut self, id: RunId) -> &mut Run {
        &mut self.nodes[id.node].runs[id.run]
    }

    fn hold(&mut self, node: usize, hash: Digest, size: u64, data: Data) {
        if self.nodes[node].live > 0 {
            self.held.put(hash, size, data);
        }
    }
}

impl NodeState {
    fn new(wanted: bool) -> Self {
        Self {
            wanted,
            state: State::Waiting,
            waits: 0,
            consumers: Vec::new(),
            live: 0,
            fixed: Digest::default(),
            source_keys: Vec::new(),
            roots: Arc::default(),
            inputs: Vec::new(),
            key: Digest::default(),
            variant: Digest::default(),
            reads: false,
            outputs: Vec::new(),
            warnings: Vec::new(),
            runs: Vec::new(),
            binding: None,
            pending: 0,
            hits: 0,
            ran: 0,
            failed: 0,
            skipped: 0,
            seconds: 0.0,
            broken: Vec::new(),
            note: "",
            forecast: None,
        }
    }
}
