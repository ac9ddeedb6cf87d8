//! Settling: what an answer means for its run, its node, and those who wait.

use super::{
    Gone, RunId, Schedule, flow,
    read::tables,
    state::{Broken, Cause, NodeState, State, Waiter, size_of},
    task,
};
use crate::engine::{
    error::EngineError,
    events::Event,
    hash::Digest,
    key::{self, SourceKey},
    node::Data,
    plan::{NodeId, OutputRef},
    record::{MapRecord, NodeTrace, Read, RunRecord, TraceOut},
    report::{Failure, Forecast},
    source,
    value::{JOIN, ValueRef, shown},
};
use std::sync::Arc;
use task::{Done, Made, TaskError};

impl Schedule<'_> {
    /// Takes a task's answer.
    pub(super) fn settle(&mut self, id: RunId, done: Done) -> Result<(), EngineError> {
        self.running -= 1;
        self.memory_used -= std::mem::take(&mut self.run_mut(id).busy().memory);
        let lane = self.lanes.iter().position(|l| *l == Some(id));
        if let Some(lane) = lane {
            self.lanes[lane] = None;
            let (node, element) = (self.name(id.node), self.run_mut(id).name.clone());
            let name = || if element.is_empty() { node.to_owned() } else { format!("{node}/{}", shown(&element)) };
            self.profile.span(lane + 1, "run", name, done.began, done.ended);
        }
        let seconds = done.ended.saturating_duration_since(done.began).as_secs_f64();
        for hash in done.verified {
            self.cache.mark_verified(hash);
        }
        for (hash, size, data) in done.shared {
            self.put(hash, size, data, false);
            self.held.keep(&hash);
        }
        self.looked_at.extend(source::paths(&done.reads, &self.nodes[id.node].roots));
        let key = self.run_mut(id).key;
        let followers = self.flying.remove(&key).unwrap_or_default();
        match done.result {
            Ok(made) => {
                self.nodes[id.node].seconds += seconds;
                // When the last run of a node is stored, its runs leave the memory.
                let result = (!followers.is_empty()).then(|| (made.outputs.clone(), made.warnings.clone()));
                self.store(id, made, done.reads, seconds)?;
                let (outputs, warnings) = result.unwrap_or_default();
                for follower in followers {
                    let run = self.run_mut(follower);
                    let same = run.cause == Cause::Missing && run.key == key;
                    if same && !self.nodes[id.node].reads {
                        self.nodes[follower.node].note_result(follower.run, &outputs, &warnings);
                        self.settled(follower, State::Hit)?;
                    } else {
                        self.again(follower);
                    }
                }
                return Ok(());
            }
            Err(TaskError::Lost(lost)) => {
                let lost = lost.into_iter().map(|(port, hash, what)| (port, hash, Gone::Lost(what)));
                self.wait_for(id, lost.collect())?;
            }
            Err(TaskError::Failed(message)) => self.fail(id, message)?,
            Err(TaskError::Stopped) => {
                let run = self.run_mut(id);
                (run.state, run.busy().lock) = (State::Waiting, None);
            }
            Err(TaskError::Cache(what)) => return Err(EngineError::cache(self.cache.root(), what)),
        }
        for follower in followers {
            self.again(follower);
        }
        Ok(())
    }

    fn again(&mut self, id: RunId) {
        self.run_mut(id).state = State::Ready;
        self.ready.push(id);
    }

    /// Stores what a run made.
    fn store(&mut self, id: RunId, made: Made, reads: Vec<Read>, seconds: f64) -> Result<(), EngineError> {
        let n = id.node;
        let node = &self.plan.nodes[n];
        // A root file that changed between the key and the run: the result belongs to what was read.
        if made.roots.iter().any(|(p, h)| self.nodes[n].source_keys.iter().any(|(q, k)| p == q && differs(k, h))) {
            for (param, key) in &mut self.nodes[n].source_keys {
                if let (SourceKey::File { hash, .. }, Some((_, read))) =
                    (key, made.roots.iter().find(|(p, _)| p == param))
                {
                    *hash = *read;
                }
            }
            self.nodes[n].fixed =
                key::fixed(key::kind(node.kind.spec()), node.params.json(), &self.nodes[n].source_keys);
            if !node.axes.is_empty() {
                return Err(EngineError::Again(format!("a file of {} changed while it ran", self.name(n))));
            }
            self.nodes[n].key = key::run(self.nodes[n].fixed, &self.nodes[n].inputs, None);
            self.run_mut(id).key = self.nodes[n].key;
        }
        let name = self.nodes[n].runs[id.run].name.clone();
        let inputs = match (self.take_inputs(n, &name, id.run), &self.nodes[n].binding) {
            (Some(Ok(taken)), Some(binding)) => {
                binding.hashes(&taken).into_iter().map(Option::unwrap_or_default).collect()
            }
            (Some(Err(e)), _) => return self.fail(id, e.to_string()),
            _ => Vec::new(),
        };
        let run = &mut self.nodes[n].runs[id.run];
        let (cause, key, lock) = (run.cause, run.key, run.busy().lock.take());
        let expected = std::mem::take(&mut run.outputs);
        self.nodes[n].note_result(id.run, &made.outputs, &made.warnings);
        self.nodes[n].largest = self.nodes[n].largest.max(size_of(&made.outputs));
        let record = RunRecord {
            fixed: self.nodes[n].fixed,
            inputs,
            outputs: made.outputs,
            warnings: made.warnings,
            seconds,
            reads,
        };
        let (variant, reads) = (record.variant(), !record.reads.is_empty());
        self.files_read.extend(source::files(&record.reads, &self.nodes[n].roots));
        let changed = *expected != *record.outputs;
        if cause == Cause::Audit {
            self.audit.compare(&expected, &record.outputs, &made.values, self.cache)?;
        }
        if cause == Cause::Audit && changed {
            let message = "audit: it gave other bytes than the cache holds for the same inputs; \
                           the kind is not deterministic, or changed without a new version";
            return self.fail(id, message.to_owned());
        }
        let (fixed, keys) = (self.nodes[n].fixed, &self.nodes[n].source_keys);
        self.cache.put_fixed(fixed, || key::explain(node.kind.spec(), node.params.json(), keys));
        let record = Arc::new(record);
        if cause != Cause::Audit {
            self.hand_over(n, key, &record, &made.values);
        }
        self.cache.put_run(key, record, made.values, lock)?;
        self.note_reads(id, variant, reads);
        if changed && self.run_mut(id).is_again() {
            // Its consumers were keyed by bytes that nobody can make again.
            let text = format!("{} made other bytes than before from the same inputs", self.name(n));
            return Err(EngineError::Again(text));
        }
        if cause == Cause::Lost {
            // Before the others read it, the index must know it again.
            self.cache.flush()?;
        }
        self.hold_all(id, made.data);
        match cause {
            Cause::Forced => self.nodes[n].note = "forced",
            Cause::Lost => self.nodes[n].note = "its stored result was lost",
            Cause::Remade if node.transient => {
                self.nodes[n].note = "it is transient, and its values were needed again";
            }
            Cause::Remade => self.nodes[n].note = "its values were not here, and were needed",
            Cause::Audit => self.nodes[n].note = "audited",
            Cause::Missing => {}
        }
        self.settled(id, State::Ran)
    }

    /// Holds what a run gave for those who take it.
    fn hold_all(&mut self, id: RunId, data: Vec<(u32, ValueRef, Data)>) {
        let waiters = self.run_mut(id).busy().waiters.clone();
        let again = self.run_mut(id).is_again();
        for (port, value, data) in data {
            let from = OutputRef { node: NodeId(id.node as u32), port };
            let waits = |w: &&Waiter| matches!(w, Waiter::Run(_, hash) if *hash == value.hash);
            let waiting: Vec<Waiter> = waiters.iter().filter(waits).copied().collect();
            let needed = !waiting.is_empty() || waiters.iter().any(|w| !matches!(w, Waiter::Run(..)));
            if again && !needed {
                continue;
            }
            self.hold(from, value.hash, value.size, data, needed);
            for waiter in waiting {
                if let Waiter::Run(other, hash) = waiter {
                    self.held.pin(&hash);
                    self.run_mut(other).busy().pinned.push(hash);
                }
            }
        }
        if !again {
            self.expect_takers(id);
        }
    }

    pub(super) fn note_reads(&mut self, id: RunId, variant: Digest, reads: bool) {
        let node = &mut self.nodes[id.node];
        node.reads |= reads;
        if self.plan.nodes[id.node].axes.is_empty() {
            node.variant = variant;
        }
    }

    pub(super) fn fail(&mut self, id: RunId, message: String) -> Result<(), EngineError> {
        self.run_mut(id).busy().lock = None;
        self.tell_failure(id, message);
        self.settled(id, State::Failed)
    }

    pub(super) fn tell_failure(&mut self, id: RunId, message: String) {
        let element = shown(&self.run_mut(id).name);
        let element = (!element.is_empty()).then_some(element);
        let node = self.name(id.node);
        self.events.event(&Event::Failed { node, element: element.as_deref(), error: &message });
        self.errors.push(Failure { node: node.to_owned(), element, message });
    }

    /// A run has come to its end.
    pub(super) fn settled(&mut self, id: RunId, state: State) -> Result<(), EngineError> {
        let node = &mut self.nodes[id.node];
        let run = &mut node.runs[id.run];
        let mended = run.is_again();
        run.state = state;
        let busy = run.take_busy();
        match state {
            State::Hit => node.hits += 1,
            State::Ran => node.ran += 1,
            State::Failed => node.failed += 1,
            _ => node.skipped += 1,
        }
        node.pending -= 1;
        let (left, done) = (node.pending as u64, node.hits + node.ran + node.failed + node.skipped);
        let hits = node.hits;
        if mended && matches!(state, State::Failed | State::Skipped) {
            node.state = State::Failed;
        }
        self.events.event(&Event::Progress { node: self.name(id.node), done, hits, left });
        busy.pinned.iter().for_each(|hash| self.held.unpin(hash));
        if !mended {
            if state == State::Hit {
                self.expect_takers(id);
            }
            self.let_go(id);
        }
        for waiter in busy.waiters {
            match (waiter, state) {
                (Waiter::Run(id, _), State::Ran | State::Hit) => {
                    let run = self.run_mut(id);
                    run.busy().missing -= 1;
                    if run.busy().missing == 0 {
                        run.state = State::Ready;
                        self.ready.push_urgent(id);
                    }
                }
                (Waiter::Node(n), State::Ran | State::Hit) => self.to_open.push_back(n),
                (Waiter::Outside, _) => {}
                (Waiter::Run(id, _), _) => {
                    if !self.run_mut(id).state.is_settled() {
                        self.settled(id, State::Skipped)?;
                    }
                }
                (Waiter::Node(n), _) => {
                    self.nodes[n].skipped += 1;
                    self.nodes[n].broken = vec![Broken::new()];
                    self.close(n)?;
                }
            }
        }
        if state.is_good() {
            self.arrived(id)?;
        }
        let node = &self.nodes[id.node];
        if node.closed && node.pending == 0 { self.finish(id.node) } else { Ok(()) }
    }

    /// The node has no more to do: makes its outputs known and opens those who waited for them.
    pub(super) fn finish(&mut self, n: usize) -> Result<(), EngineError> {
        if self.nodes[n].state.is_settled() {
            return Ok(());
        }
        let plan = &self.plan.nodes[n];
        let dry = self.options.dry_run;
        let known = self.previous_trace(n).is_some_and(|t| t.mapped && t.key == self.nodes[n].key);
        let node = &mut self.nodes[n];
        node.sort();
        node.forecast = dry.then(|| node.forecast.unwrap_or(Forecast::Hit));
        node.state = match () {
            () if node.failed > 0 => State::Failed,
            () if node.skipped > 0 => State::Skipped,
            () if node.ran > 0 => State::Ran,
            () => State::Hit,
        };
        let foretold = node.forecast.is_some_and(|f| f != Forecast::Hit);
        if node.outputs.is_empty() && !foretold && !node.broken.iter().any(Broken::is_empty) {
            node.collect(plan, plan.kind.spec().outputs.len());
            let sound = node.failed + node.skipped == 0 && !node.reads && !dry;
            if sound && !plan.axes.is_empty() {
                self.store_map(n, known)?;
            }
        }
        for (element, text) in self.nodes[n].warnings.clone() {
            self.warn(Some(n), (!element.is_empty()).then_some(element.as_str()), &text);
        }
        let node = &mut self.nodes[n];
        let NodeState { hits, ran: runs, failed, skipped, seconds, .. } = *node;
        node.binding = None;
        let name = self.name(n);
        // The counts of a dry run are those of a bake that would run.
        if !dry {
            self.events.event(&Event::NodeFinished { node: name, hits, runs, failed, skipped, seconds });
        }
        for c in self.nodes[n].consumers.clone() {
            self.nodes[c].waits -= 1;
            self.nodes[c].gates -= usize::from(flow::is_gate(self.plan, c, n));
            if self.nodes[c].waits == 0 {
                self.to_open.push_back(c);
            } else if self.nodes[c].flows {
                self.to_flow.push_back(c);
            } else {
                self.stir(c);
            }
        }
        self.release(n);
        Ok(())
    }

    /// Stores the map as a whole, unless the last bake's is the same. What it tells of single runs need not stay in memory.
    fn store_map(&mut self, n: usize, known: bool) -> Result<(), EngineError> {
        let plan = &self.plan.nodes[n];
        let node = &self.nodes[n];
        let (key, fixed) = (node.key, node.fixed);
        if known && node.ran == 0 {
            self.cache.touch_map(key);
        } else {
            let inputs: Vec<Digest> = node.inputs.iter().map(|h| h.unwrap_or_default()).collect();
            // From the runs as they are: a copy of many would cost as much as they.
            let rows = node.runs.iter().map(|r| (&*r.name, r.key, &*r.outputs));
            let record = MapRecord::write(&key, fixed, &inputs, rows, &node.warnings);
            let keys = &self.nodes[n].source_keys;
            self.cache.put_fixed(fixed, || key::explain(plan.kind.spec(), plan.params.json(), keys));
            self.cache.put_map(key, record)?;
        }
        if self.cache.is_writable() {
            self.nodes[n].runs = Vec::new();
        }
        Ok(())
    }

    /// Drops decoded values that nobody can still take.
    fn release(&mut self, n: usize) {
        let mut seen: Vec<usize> = Vec::new();
        let plan = self.plan;
        for from in plan.nodes[n].inputs.iter().flat_map(|i| [i.from, i.via]).flatten() {
            let p = from.node.0 as usize;
            if seen.contains(&p) {
                continue;
            }
            seen.push(p);
            self.nodes[p].live -= 1;
            if self.nodes[p].live == 0 && !self.held.is_empty() {
                for rows in self.nodes[p].outputs.iter().filter_map(|o| o.rows.clone()) {
                    rows.iter().for_each(|row| self.held.unkeep(&row.value.hash));
                }
            }
        }
    }

    /// What the bake record says of node `n`; `None` unless all of it is there.
    pub fn trace(&self, n: usize) -> Option<NodeTrace> {
        let node = &self.nodes[n];
        if !matches!(node.state, State::Hit | State::Ran) {
            return None;
        }
        let mapped = !self.plan.nodes[n].axes.is_empty();
        // A map whose runs read files is never believed as a whole: no record has this variant.
        let variant = if mapped && node.reads { Digest([1; 32]) } else { node.variant };
        Some(NodeTrace {
            name: self.name(n).to_owned(),
            key: node.key,
            variant,
            mapped,
            elements: node.hits + node.ran,
            ran: node.ran,
            note: node.note.to_owned(),
            outputs: node.outputs.iter().map(|o| TraceOut { hash: o.hash, size: o.size }).collect(),
            warnings: node.warnings.clone(),
        })
    }

    /// Whether the last bake's record, at the same place, already says all there is to say of node `n`.
    pub fn is_unchanged(&self, n: usize) -> bool {
        let node = &self.nodes[n];
        let same = |t: &NodeTrace| {
            t.name == self.name(n)
                && (!node.wanted
                    || node.state == State::Hit && t.key == node.key && (t.variant == node.variant || node.reads))
        };
        self.previous.nodes.get(n).is_some_and(same)
    }

    /// What the last bake's record said of node `n`, for a bake that did not come to it.
    pub fn carried(&self, n: usize) -> Option<NodeTrace> {
        let trace = self.previous_trace(n)?.clone();
        Some(NodeTrace { ran: 0, note: "not part of that bake".to_owned(), ..trace })
    }

    /// Hits, runs, failed, skipped, seconds and forecast of node `n`.
    pub fn counts(&self, n: usize) -> (u64, u64, u64, u64, f64, Option<Forecast>) {
        let node = &self.nodes[n];
        (node.hits, node.ran, node.failed, node.skipped, node.seconds, node.forecast)
    }

    pub fn output_of(&self, from: OutputRef) -> Option<(Digest, Option<u64>)> {
        let node = &self.nodes[from.node.0 as usize];
        node.outputs.get(from.port as usize).map(|o| (o.hash, o.size))
    }
}

impl NodeState {
    /// Outputs, warnings and what is broken, from the runs.
    fn collect(&mut self, plan: &crate::engine::plan::PlanNode, ports: usize) {
        let good = self.runs.iter().filter(|r| matches!(r.state, State::Hit | State::Ran));
        self.outputs = tables(ports, good.map(|r| (r.name.clone(), &r.outputs[..])));
        for (name, texts) in &self.warned {
            self.warnings.extend(texts.iter().map(|text| (shown(name), text.clone())));
        }
        for run in &self.runs {
            if matches!(run.state, State::Failed | State::Skipped) {
                let parts = run.name.split(JOIN).map(str::to_owned);
                self.broken.push(plan.axes.iter().copied().zip(parts).collect());
            }
        }
    }
}

fn differs(key: &SourceKey, read: &Digest) -> bool {
    matches!(key, SourceKey::File { hash, .. } if hash != read)
}
