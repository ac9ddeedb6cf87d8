//! The schedule: brings every wanted node to its end.
//!
//! One thread owns the graph, the index and all states; tasks on the pool compute and answer by a message. At most
//! `jobs` tasks are out, and each has its memory reserved before it starts. Nothing on the pool waits: locks of other
//! processes are polled here, values are handed to a task with its start.

mod audit;
mod flow;
mod held;
mod mend;
mod open;
mod pool;
mod read;
mod ready;
mod remote;
mod settle;
mod start;
mod state;
mod task;

pub use pool::Pool;
pub use read::Gone;
pub use state::State;
pub use task::panic_text;

use super::{
    cache::{Cache, NewValue},
    elements::{self, Taken},
    error::EngineError,
    events::{Event, Events},
    hash::Digest,
    node::Data,
    options::Options,
    plan::{OutputRef, Plan},
    profile::Profile,
    record::BakeRecord,
    remote::{Found, Remote},
    report::{Audit, Failure},
    value::shown,
};
use crate::math::Stop;
use held::Held;
use ready::Ready;
use remote::Second;
use state::{NodeState, Output, Run, Takers};
use std::{
    collections::{BTreeMap, BTreeSet, VecDeque},
    path::PathBuf,
    sync::mpsc,
    time::{Duration, Instant},
};
use task::Done;

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
    /// What the second level holds under the key of a run.
    Found(RunId, Digest, Option<Vec<Found>>),
    /// A value from there.
    Value(Digest, Option<NewValue>),
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
    /// Nodes of which some runs may be admitted.
    to_flow: VecDeque<usize>,
    ready: Ready,
    /// Runs whose keys other processes hold, and since when.
    elsewhere: Vec<(RunId, Instant)>,
    /// Holders whose names were told.
    told: BTreeSet<String>,
    /// Keys whose runs are out, and who waits for them.
    flying: BTreeMap<Digest, Vec<RunId>>,
    running: usize,
    held: Held,
    second: Second<'a>,
    pool: &'a Pool,
    answers: (mpsc::Sender<Answer>, mpsc::Receiver<Answer>),
    /// Values set aside, and how often.
    lost: BTreeMap<Digest, u32>,
    /// Files that runs read through the door besides root files, this time or when their results were stored.
    files_read: BTreeSet<PathBuf>,
    /// The same, with those that were looked for in vain and those of runs that failed.
    pub looked_at: BTreeSet<PathBuf>,
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
    pub remote: Option<&'a Remote>,
    pub wanted: &'a [bool],
    pub forced: BTreeSet<usize>,
    pub jobs: usize,
    pub memory: u64,
}

impl<'a> Schedule<'a> {
    pub fn new(plan: &'a Plan, s: Setting<'a>) -> Self {
        let count = plan.nodes.len();
        let state = |wanted: &bool| NodeState { wanted: *wanted, ..NodeState::default() };
        let mut nodes: Vec<NodeState> = s.wanted.iter().map(state).collect();
        let mut depths = vec![0; count];
        let mut seen = Vec::new();
        for (i, node) in plan.nodes.iter().enumerate() {
            nodes[i].takers = vec![Takers::Runs(0); node.kind.spec().outputs.len()];
            if !s.wanted[i] {
                continue;
            }
            seen.clear();
            for from in node.inputs.iter().flat_map(|input| [input.from, input.via]).flatten() {
                let producer = from.node.0 as usize;
                if !seen.contains(&producer) {
                    seen.push(producer);
                    nodes[producer].consumers.push(i);
                    nodes[producer].live += 1;
                    depths[i] = depths[i].max(depths[producer] + 1);
                }
            }
            nodes[i].waits = seen.len();
            nodes[i].gates = seen.iter().filter(|p| flow::is_gate(plan, i, **p)).count();
            nodes[i].driver = flow::driver(plan, i);
            for (port, input) in node.inputs.iter().enumerate() {
                for from in [input.from, input.via].into_iter().flatten() {
                    let once = elements::taken_once(node, port);
                    let takers = &mut nodes[from.node.0 as usize].takers[from.port as usize];
                    *takers = match *takers {
                        Takers::Runs(n) if once => Takers::Runs(n + 1),
                        _ => Takers::Nodes,
                    };
                }
            }
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
            to_flow: VecDeque::new(),
            ready: Ready::new(depths),
            elsewhere: Vec::new(),
            told: BTreeSet::new(),
            flying: BTreeMap::new(),
            running: 0,
            held: Held::default(),
            second: Second::new(s.remote),
            pool: s.pool,
            answers: mpsc::channel(),
            lost: BTreeMap::new(),
            files_read: BTreeSet::new(),
            looked_at: BTreeSet::new(),
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
                if self.nodes[node].waits == 0 { self.open(node)? } else { self.flow(node)? }
            }
            self.cache.end()?;
            self.tell_damage();
            if !self.halted() {
                self.look_elsewhere()?;
                self.start_ready()?;
                // What can start has started: time to look further down.
                if let Some(node) = self.to_flow.pop_front() {
                    self.cache.begin()?;
                    self.flow(node)?;
                    self.cache.end()?;
                    continue;
                }
                if !self.to_open.is_empty() {
                    continue;
                }
            }
            let waits = !self.ready.is_empty() || !self.elsewhere.is_empty() || self.second.asks();
            if self.running == 0 && (self.halted() || !waits) {
                return Ok(());
            }
            self.receive()?;
        }
    }

    /// Waits for an answer, or for a moment where something else may change.
    fn receive(&mut self) -> Result<(), EngineError> {
        let first = if self.elsewhere.is_empty() && !self.second.asks() && !self.cache.has_pending() {
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
            Answer::Found(id, key, found) => self.take_found(id, key, found),
            Answer::Value(hash, value) => self.take_value(hash, value),
            Answer::Step(id, done, total) => {
                let Some(run) = self.nodes[id.node].runs.get(id.run) else { return Ok(()) };
                let element = shown(&run.name);
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
        let texts = std::mem::take(&mut self.cache.warnings);
        for text in texts.into_iter().chain(self.second.warnings()) {
            self.warn(None, None, &text);
        }
    }

    fn output(&self, from: OutputRef) -> &Output {
        &self.nodes[from.node.0 as usize].outputs[from.port as usize]
    }

    fn run_mut(&mut self, id: RunId) -> &mut Run {
        &mut self.nodes[id.node].runs[id.run]
    }

    /// Holds a value that output `from` has just given, if anybody takes it. `needed`: someone waits for just this value.
    fn hold(&mut self, from: OutputRef, hash: Digest, size: u64, data: Data, needed: bool) {
        let node = &self.nodes[from.node.0 as usize];
        let takers = node.takers[from.port as usize];
        if takers == Takers::Runs(0) || node.live == 0 && !needed {
            return;
        }
        self.put(hash, size, data, needed || self.plan.nodes[from.node.0 as usize].transient);
    }

    /// Holds a value within a share of the memory; beyond it only one that is `needed`.
    fn put(&mut self, hash: Digest, size: u64, data: Data, needed: bool) {
        let most = self.memory / 2;
        self.held.shrink(most.saturating_sub(size), |_| false);
        if needed || self.held.bytes() + size <= most {
            self.held.put(hash, size, data);
        }
    }

    /// Notes who will take the outputs of a run, as far as they are in memory.
    fn expect_takers(&mut self, id: RunId) {
        let Self { nodes, held, .. } = self;
        let node = &nodes[id.node];
        if held.is_empty() || node.live == 0 {
            return;
        }
        for (out, takers) in node.runs[id.run].outputs.iter().zip(&node.takers) {
            for hash in super::cache::values_of(std::slice::from_ref(out)) {
                match takers {
                    Takers::Runs(n) => held.expect(&hash, *n),
                    Takers::Nodes => held.keep(&hash),
                }
            }
        }
    }

    /// A run has come to its end: what it took leaves the memory, unless others take it too.
    fn let_go(&mut self, id: RunId) {
        if self.held.is_empty() {
            return;
        }
        let node = &self.plan.nodes[id.node];
        let Some(binding) = &self.nodes[id.node].binding else { return };
        let name = &self.nodes[id.node].runs[id.run].name;
        let ports = (0..node.inputs.len()).filter(|port| elements::taken_once(node, *port));
        let taken: Vec<Taken> = ports.filter_map(|port| binding.taken(port, name, self)).collect();
        for value in taken.iter().flat_map(Taken::values) {
            self.held.taken(&value.hash);
        }
    }
}
