//! Starting runs: a slot, memory, the key's lock, one more look at the index, the inputs' bytes, and off.

use super::{
    Answer, Gone, RunId, Schedule, Trust,
    open::sizes,
    state::{Cause, Run, State, Waiter},
    task,
};
use crate::engine::{
    cache::{Stored, lock},
    elements::Taken,
    error::EngineError,
    events::Event,
    hash::Digest,
    plan::OutputRef,
    value::{ValueRef, shown},
};
use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::Arc,
    time::{Duration, Instant},
};
use task::{From, Load, Task, TaskSlot};

/// How often a lock that another process holds is tried.
const POLL: Duration = Duration::from_millis(20);

impl Schedule<'_> {
    /// Starts ready runs in their order while slots and memory last.
    pub(super) fn start_ready(&mut self) -> Result<(), EngineError> {
        debug_assert!(!self.options.dry_run || self.ready.is_empty(), "a dry run runs nothing");
        while self.running < self.jobs
            && !self.options.dry_run
            && !self.halted()
            && let Some(id) = self.ready.front()
        {
            self.bind(id.node)?;
            let node = &self.plan.nodes[id.node];
            let name = self.run_mut(id).name.clone();
            if let Some((from, value, gone)) = self.decode_relations(id.node, &name)? {
                self.ready.pop();
                let run = self.run_mut(id);
                (run.state, run.busy().lock) = (State::Waiting, None);
                let row = self.relation_row(id.node, from, &name);
                self.mend(from, &row, value.hash, &gone, Waiter::Run(id, value.hash))?;
                continue;
            }
            let Some(taken) = self.take_inputs(id.node, &name, id.run) else { break };
            let taken = match taken {
                Ok(taken) => taken,
                Err(e) => {
                    self.ready.pop();
                    self.fail(id, e.to_string())?;
                    continue;
                }
            };
            // The estimate is the kind's code too: it may panic.
            let sizes = sizes(&taken);
            let estimate = catch_unwind(AssertUnwindSafe(|| node.kind.memory(&node.params, &sizes)));
            let need = match estimate {
                Ok(working) => self.need(id, &taken, working),
                Err(payload) => Err(super::panic_text(&*payload)),
            };
            let need = match need {
                Ok(need) => need,
                Err(message) => {
                    self.ready.pop();
                    self.fail(id, message)?;
                    continue;
                }
            };
            // In order, so that a large task is not overtaken for ever. Values in memory give way to it.
            let free = self.memory.saturating_sub(self.memory_used + need);
            let spared = |hash: &Digest| taken.iter().any(|t| t.holds(hash));
            self.held.shrink(free, spared);
            if self.running > 0 && self.memory_used + need + self.held.bytes() > self.memory {
                break;
            }
            self.ready.pop();
            if self.claim(id)? {
                self.start(id, taken, need)?;
            }
        }
        Ok(())
    }

    /// What a run takes of the memory besides values that are in it already: inputs, `working` memory, and as much for
    /// its outputs as a run of its node has given so far. The error is for the user: it is more than there is.
    fn need(&self, id: RunId, taken: &[Taken], working: u64) -> Result<u64, String> {
        let (mut inputs, mut held) = (0u64, 0u64);
        for value in taken.iter().flat_map(Taken::values) {
            inputs = inputs.saturating_add(value.size);
            held += if self.held.contains(&value.hash) { value.size } else { 0 };
        }
        let all = inputs.saturating_add(working);
        if all > self.memory {
            let (need, inputs, have) = (bytes(all), bytes(inputs), bytes(self.memory));
            return Err(format!(
                "it needs about {need} of memory, {inputs} of it for its inputs, but --memory allows {have} in all"
            ));
        }
        Ok(all.saturating_add(self.nodes[id.node].largest).min(self.memory).saturating_sub(held))
    }

    /// Makes the run's key this process's own. False if another has it, or has just finished it.
    fn claim(&mut self, id: RunId) -> Result<bool, EngineError> {
        let key = self.run_mut(id).key;
        if let Some(followers) = self.flying.get_mut(&key) {
            followers.push(id);
            self.run_mut(id).state = State::Elsewhere;
            return Ok(false);
        }
        if self.run_mut(id).busy().lock.is_none() {
            let Some(lock) = self.cache.lock(&key)? else {
                self.run_mut(id).state = State::Elsewhere;
                self.elsewhere.push((id, Instant::now()));
                return Ok(false);
            };
            self.run_mut(id).busy().lock = Some(lock);
        }
        if self.run_mut(id).cause == Cause::Missing
            && let Some((variant, record)) = self.look_up(id.node, &key)?
        {
            self.cache.touch_run(key);
            self.note_reads(id, variant, !record.reads.is_empty());
            self.nodes[id.node].note_result(id.run, &record.outputs, &record.warnings);
            self.settled(id, State::Hit)?;
            return Ok(false);
        }
        Ok(true)
    }

    /// Tries the locks that other processes hold.
    pub(super) fn look_elsewhere(&mut self) -> Result<(), EngineError> {
        if self.elsewhere.is_empty() || self.polled.elapsed() < POLL {
            return Ok(());
        }
        self.polled = Instant::now();
        for (id, since) in std::mem::take(&mut self.elsewhere) {
            let key = self.run_mut(id).key;
            match self.cache.lock(&key)? {
                None => {
                    self.elsewhere.push((id, since));
                    if since.elapsed() >= lock::PATIENCE {
                        self.tell_waiting(id, &key);
                    }
                }
                Some(lock) => {
                    // The index is asked again when it starts. Until then the lock is not needed: at most `jobs` are
                    // held at a time, and whoever takes it in between does the same work.
                    drop(lock);
                    self.run_mut(id).state = State::Ready;
                    self.ready.push_urgent(id);
                }
            }
        }
        Ok(())
    }

    /// Says once for each other process that its result is waited for.
    fn tell_waiting(&mut self, id: RunId, key: &Digest) {
        let holder = lock::holder_of_key(self.cache.root(), key);
        if self.told.contains(&holder) {
            return;
        }
        let (node, element) = (self.name(id.node), shown(&self.run_mut(id).name));
        let what = if element.is_empty() { node.to_owned() } else { format!("{node}/{element}") };
        self.events.event(&Event::Waiting { what: &what, holder: &holder });
        self.told.insert(holder);
    }

    fn start(&mut self, id: RunId, taken: Vec<Taken>, need: u64) -> Result<(), EngineError> {
        let node = &self.plan.nodes[id.node];
        let mut lost = Vec::new();
        let mut inputs = Vec::with_capacity(taken.len());
        for (port, taken) in taken.into_iter().enumerate() {
            let shared = self.nodes[id.node].binding.as_ref().is_some_and(|b| b.is_shared(port, node.axes.len()));
            let mut load = |hash: Digest, stored: Option<Stored>| {
                if let Some(data) = self.held.get(&hash) {
                    return Some(Load { hash, from: From::Data(data), verified: true, share: false });
                }
                let gone = match &stored {
                    None => Some(Gone::missing()),
                    Some(Stored::NotKept) => Some(Gone::NotKept),
                    Some(_) => None,
                };
                lost.extend(gone.map(|gone| (port, hash, gone)));
                let stored = stored.filter(|stored| !matches!(stored, Stored::NotKept))?;
                Some(Load::new(hash, stored, self.cache.is_verified(&hash), shared))
            };
            inputs.push(match taken {
                Taken::Absent => TaskSlot::Absent,
                Taken::One(v) => {
                    let held = self.held.get(&v.hash).is_some();
                    let stored = if held { None } else { self.cache.value(&v.hash)? };
                    load(v.hash, stored).map_or(TaskSlot::Absent, TaskSlot::One)
                }
                Taken::Many(list) => {
                    let wanted = list.iter().map(|(_, v)| v.hash).filter(|hash| self.held.get(hash).is_none());
                    let stored = self.cache.values(wanted)?;
                    let row = |(name, v): (Arc<str>, ValueRef)| {
                        Some((shown(&name), load(v.hash, stored.get(&v.hash).cloned())?))
                    };
                    let mut many: Vec<_> = list.into_iter().filter_map(row).collect();
                    // Names of several axes sort otherwise once they are joined for display.
                    many.sort_by(|a, b| a.0.cmp(&b.0));
                    TaskSlot::Many(many)
                }
            });
        }
        if !lost.is_empty() {
            return self.wait_for(id, lost);
        }
        let pool = self.pool.get().map_err(|e| EngineError::cache(self.cache.root(), format!("no threads: {e}")))?;
        let element = self.run_mut(id).name.clone();
        let spec = node.kind.spec();
        let state = &self.nodes[id.node];
        let task = Task {
            kind: node.kind.clone(),
            params: node.params.clone(),
            inputs,
            element: (spec.uses_name && !node.axes.is_empty()).then(|| shown(&element)),
            roots: state.roots.clone(),
            stop: self.stop.clone(),
            blobs: self.cache.blobs().clone(),
            device: self.options.device.clone(),
            progress: {
                let answer = self.answers.0.clone();
                Box::new(move |done, total| drop(answer.send(Answer::Step(id, done, total))))
            },
            memory: self.memory,
            // A bake that begins again may have met a kind that gives other bytes each time: kept, they are the same for all.
            keep: !node.transient || self.trust == Trust::Runs,
        };
        let state = &mut self.nodes[id.node];
        if !state.state.is_settled() {
            state.state = State::Running;
        }
        let run: &mut Run = &mut state.runs[id.run];
        (run.state, run.busy().memory) = (State::Running, need);
        self.flying.entry(run.key).or_default();
        self.running += 1;
        self.memory_used += need;
        if let Some(lane) = self.lanes.iter_mut().find(|lane| lane.is_none()) {
            *lane = Some(id);
        }
        let answer = self.answers.0.clone();
        pool.spawn(move || {
            // Nobody listens only if the schedule itself has ended by a panic.
            let _ = answer.send(Answer::Done(id, Box::new(task::perform(task))));
        });
        Ok(())
    }

    /// Sets `id` aside until its inputs are there again.
    pub(super) fn wait_for(&mut self, id: RunId, lost: Vec<(usize, Digest, Gone)>) -> Result<(), EngineError> {
        let run = self.run_mut(id);
        (run.state, run.busy().lock) = (State::Waiting, None);
        let name = run.name.clone();
        for (port, hash, gone) in lost {
            let from: Option<OutputRef> = self.plan.nodes[id.node].inputs[port].from;
            let row = self.nodes[id.node].binding.as_ref().and_then(|b| b.row_of(port, &name, &hash));
            let (Some(from), Some(row)) = (from, row) else {
                return Err(EngineError::Again(format!("a lost input of {} has no producer", self.name(id.node))));
            };
            self.mend(from, &row, hash, &gone, Waiter::Run(id, hash))?;
        }
        Ok(())
    }
}

/// A number of bytes for people.
pub fn bytes(n: u64) -> String {
    let n = n as f64;
    let (divisor, unit) = match n {
        n if n >= (1u64 << 30) as f64 => ((1u64 << 30) as f64, "GiB"),
        n if n >= (1u64 << 20) as f64 => ((1u64 << 20) as f64, "MiB"),
        n if n >= 1024.0 => (1024.0, "KiB"),
        _ => (1.0, "B"),
    };
    format!("{:.1} {unit}", n / divisor)
}
