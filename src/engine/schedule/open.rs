//! Closing a node: all that it reads is settled, so its key is known, and so are its elements. Either the cache has it as
//! a whole, or it is split into runs, of which only those that the index does not have remain to be done. Some may have
//! been admitted before, as their inputs arrived (see [`super::flow`]).

use super::{
    Run, RunId, Schedule, Trust,
    flow::is_lost,
    read::tables,
    state::{Broken, Cause, NodeState, Output, State, size_of},
};
use crate::engine::{
    elements::{self, Taken},
    error::EngineError,
    events::Event,
    hash::Digest,
    inputs, key,
    record::{NodeTrace, RunRecord},
    report::{Failure, Forecast},
    source,
};
use std::sync::Arc;

impl Schedule<'_> {
    /// Keys node `n` and settles it, or readies its runs.
    pub(super) fn open(&mut self, n: usize) -> Result<(), EngineError> {
        let node = &self.plan.nodes[n];
        if self.nodes[n].closed {
            return Ok(());
        }
        if self.options.dry_run && self.producers(n).any(|p| self.nodes[p].forecast != Some(Forecast::Hit)) {
            self.nodes[n].forecast = Some(Forecast::MayRun);
            return self.close(n);
        }
        let broken = self.broken_above(n);
        if broken.iter().any(Broken::is_empty) {
            self.nodes[n].skipped += 1;
            self.nodes[n].broken = vec![Broken::new()];
            return self.close(n);
        }
        if !self.prepare(n)? {
            return Ok(());
        }
        let inputs = inputs::of_key(self.plan, n).iter().map(|i| Some(self.output(i.from?).hash)).collect::<Vec<_>>();
        let mapped = !node.axes.is_empty();
        let state = &mut self.nodes[n];
        let fixed = state.fixed;
        state.key =
            if mapped { key::map(fixed, &inputs, &elements::shape(node)) } else { key::run(fixed, &inputs, None) };
        state.inputs = inputs;
        debug_assert!(
            mapped || (0..node.inputs.len()).all(|i| elements::takes_all(node, i)),
            "a node without axes takes whole lists"
        );
        let forced = self.forced.contains(&n);
        let whole = self.nodes[n].runs.is_empty() && broken.is_empty();
        if whole && !forced && self.options.audit == 0.0 && self.trust == Trust::Nodes {
            if let Some(trace) = self.previous_trace(n).filter(|t| believable(t, &self.nodes[n], mapped)) {
                let outputs = trace.outputs.iter().map(|o| Output { hash: o.hash, size: o.size, rows: None }).collect();
                let (warnings, elements) = (trace.warnings.clone(), trace.elements);
                let state = &mut self.nodes[n];
                (state.outputs, state.warnings, state.hits) = (outputs, warnings, elements);
                return self.close(n);
            }
            if mapped {
                let key = self.nodes[n].key;
                if let Some(record) = self.cache.map(&key)? {
                    self.cache.touch_map(key);
                    let ports = node.kind.spec().outputs.len();
                    let state = &mut self.nodes[n];
                    state.hits = record.rows.len() as u64;
                    state.warnings = record.warnings.clone();
                    state.outputs = tables(ports, record.rows.iter().map(|r| (r.name.as_str().into(), &r.outputs[..])));
                    return self.close(n);
                }
            }
        }
        if mapped { self.open_elements(n, broken) } else { self.open_single(n) }
    }

    /// A node that runs once.
    fn open_single(&mut self, n: usize) -> Result<(), EngineError> {
        let key = self.nodes[n].key;
        let found = self.look_up(n, &key)?;
        let (state, cause) = self.judge(n, &key, found.is_some());
        if found.is_none()
            && let Some(old) = self.previous_trace(n).filter(|t| !t.mapped).map(|t| t.key)
        {
            // What it is about to make is mostly what it made last time.
            for (_, record) in self.cache.runs(&old)? {
                self.cache.note_indexed(&record)?;
            }
        }
        if let (Some((variant, record)), State::Hit) = (&found, state) {
            if self.previous_trace(n).is_none_or(|t| t.key != key || t.variant != *variant) {
                self.cache.touch_run(key);
            }
            let node = &mut self.nodes[n];
            node.variant = *variant;
            node.reads = !record.reads.is_empty();
        }
        let id = self.add_found(n, Run::new("".into(), key, state, cause), found.as_ref().map(|(_, record)| &**record));
        if state == State::Ready && !self.options.dry_run {
            self.bind(n)?;
            self.nodes[n].pending += 1;
            self.make_ready(id);
        }
        self.opened(n)
    }

    /// A mapped node that is no hit as a whole.
    fn open_elements(&mut self, n: usize, broken: Vec<Broken>) -> Result<(), EngineError> {
        self.bind(n)?;
        self.load_before(n)?;
        let node = &self.plan.nodes[n];
        let Some(binding) = &self.nodes[n].binding else { return Ok(()) };
        let names = match binding.domain(node, !broken.is_empty()) {
            Ok(names) => names,
            Err(e) => return self.fail_node(n, e.to_string()),
        };
        let mut unmet = broken.clone();
        for (at, name) in names.into_iter().enumerate() {
            if broken.iter().any(|b| is_lost(node, b, &name)) {
                unmet.retain(|b| !is_lost(node, b, &name));
                if self.nodes[n].run_of(&name).is_none() {
                    self.add_run(n, Run::new(name, Digest::default(), State::Skipped, Cause::Missing));
                }
            } else if self.nodes[n].run_of(&name).is_none() && !self.admit(n, name, at)? {
                return Ok(());
            }
        }
        let state = &mut self.nodes[n];
        // What failed above has no rows, and so no elements here; it may reach some further down.
        state.skipped += unmet.len() as u64;
        state.broken.extend(unmet);
        self.opened(n)
    }

    /// The record of `key` that holds for the files as they are.
    pub(super) fn look_up(&mut self, n: usize, key: &Digest) -> Result<Option<(Digest, Arc<RunRecord>)>, EngineError> {
        let ports = self.plan.nodes[n].kind.spec().outputs.len();
        let roots = self.nodes[n].roots.clone();
        for (variant, record) in self.cache.runs(key)? {
            if record.outputs.len() == ports && source::still_true(&record.reads, &roots, self.cache) {
                self.files_read.extend(source::files(&record.reads, &roots));
                self.looked_at.extend(source::paths(&record.reads, &roots));
                return Ok(Some((variant, record)));
            }
        }
        Ok(None)
    }

    /// What is to be done with a run whose result is `known`, or not.
    pub(super) fn judge(&self, n: usize, key: &Digest, known: bool) -> (State, Cause) {
        if self.forced.contains(&n) {
            (State::Ready, Cause::Forced)
        } else if !known {
            (State::Ready, Cause::Missing)
        } else if self.options.audit > 0.0 && self.is_audited(key) {
            (State::Ready, Cause::Audit)
        } else {
            (State::Hit, Cause::Missing)
        }
    }

    /// Chooses by the key and the second, so that audits of one cache meet every result in time.
    fn is_audited(&self, key: &Digest) -> bool {
        let mut h = blake3::Hasher::new();
        h.update(&key.0);
        h.update(&self.profile.began_at().to_le_bytes());
        let word = u64::from_le_bytes(h.finalize().as_bytes()[..8].try_into().unwrap_or_default());
        (word as f64 / u64::MAX as f64) < self.options.audit
    }

    /// Adds a run with its record, if one was found.
    pub(super) fn add_found(&mut self, n: usize, mut run: Run, record: Option<&RunRecord>) -> RunId {
        if let Some(record) = record {
            run.outputs = (&*record.outputs).into();
            if !record.warnings.is_empty() {
                self.nodes[n].warned.insert(run.name.clone(), record.warnings.clone());
            }
        }
        self.add_run(n, run)
    }

    pub(super) fn add_run(&mut self, n: usize, run: Run) -> RunId {
        let node = &mut self.nodes[n];
        match run.state {
            State::Hit => node.hits += 1,
            State::Skipped => node.skipped += 1,
            State::Failed => node.failed += 1,
            _ => {}
        }
        node.largest = node.largest.max(size_of(&run.outputs));
        if node.flows {
            node.by_name.insert(run.name.clone(), node.runs.len() as u32);
        }
        node.runs.push(run);
        let id = RunId { node: n, run: node.runs.len() - 1 };
        if self.nodes[n].runs[id.run].state.is_good() {
            self.expect_takers(id);
        }
        id
    }

    /// The runs are known: finishes the node, or leaves that to the last of them.
    fn opened(&mut self, n: usize) -> Result<(), EngineError> {
        let node = &mut self.nodes[n];
        if self.options.dry_run {
            node.ran = node.runs.iter().filter(|r| r.state == State::Ready).count() as u64;
            node.forecast = (node.ran > 0).then_some(Forecast::Runs);
        } else if node.pending > 0 && !node.flows {
            node.state = State::Ready;
            let (elements, hits) = (node.runs.len() as u64, node.hits);
            self.events.event(&Event::NodeStarted { node: self.name(n), elements, hits });
            self.stir_consumers(n);
        }
        self.close(n)
    }

    /// Nothing is added to the node any more.
    pub(super) fn close(&mut self, n: usize) -> Result<(), EngineError> {
        let node = &mut self.nodes[n];
        (node.closed, node.before, node.keys) = (true, None, None);
        if node.pending == 0 { self.finish(n) } else { Ok(()) }
    }

    fn producers(&self, n: usize) -> impl Iterator<Item = usize> {
        let inputs = self.plan.nodes[n].inputs.iter();
        inputs.flat_map(|input| [input.from, input.via]).flatten().map(|from| from.node.0 as usize)
    }

    /// What failed above, as far as the node's own axes tell it apart. An empty entry: all of the node is lost.
    pub(super) fn broken_above(&self, n: usize) -> Vec<Broken> {
        let axes = &self.plan.nodes[n].axes;
        let all = self.producers(n).flat_map(|p| &self.nodes[p].broken);
        let mut out: Vec<Broken> = Vec::new();
        for broken in all {
            let own: Broken = broken.iter().filter(|(a, _)| axes.contains(a)).map(|(a, n)| (*a, n.clone())).collect();
            if !out.contains(&own) {
                out.push(own);
            }
        }
        out
    }

    pub(super) fn fail_node(&mut self, n: usize, message: String) -> Result<(), EngineError> {
        self.nodes[n].failed += 1;
        self.nodes[n].broken = vec![Broken::new()];
        self.events.event(&Event::Failed { node: self.name(n), element: None, error: &message });
        self.errors.push(Failure { node: self.name(n).to_owned(), element: None, message });
        self.close(n)
    }

    pub(super) fn previous_trace(&self, n: usize) -> Option<&NodeTrace> {
        let name = &self.plan.nodes[n].name;
        if let Some(near) = self.previous.nodes.get(n).filter(|t| t.name == *name) {
            return Some(near);
        }
        let by_name = || self.previous.nodes.iter().enumerate().map(|(i, t)| (t.name.as_str(), i)).collect();
        let at = self.previous_by_name.get_or_init(by_name).get(name.as_str())?;
        self.previous.nodes.get(*at)
    }
}

/// Whether the last bake's word on a node can stand for the index.
fn believable(trace: &NodeTrace, state: &NodeState, mapped: bool) -> bool {
    trace.key == state.key && trace.mapped == mapped && trace.variant == Digest::default()
}

/// Stored bytes that reach a task through each port.
pub(super) fn sizes(taken: &[Taken]) -> Vec<u64> {
    let size = |t: &Taken| match t {
        Taken::Absent => 0,
        Taken::One(v) => v.size,
        Taken::Many(list) => list.iter().map(|(_, v)| v.size).sum(),
    };
    taken.iter().map(size).collect()
}
