//! Opening a node: all that it reads is settled, so its key is known. Either the cache has it as a whole, or it is
//! split into runs, of which only those that the index does not have remain to be done.

use super::{Broken, Cause, Forecast, NodeState, Output, Run, RunId, Schedule, State, Trust, Waiter, read::tables};
use crate::engine::{
    elements::{self, Binding, Feed, Taken, Via},
    error::EngineError,
    events::Event,
    hash::Digest,
    inputs, key,
    plan::{OutputRef, Relation},
    record::{NodeTrace, RunRecord},
    report::Failure,
    source,
    value::shown,
};
use std::{collections::BTreeMap, sync::Arc};

impl Schedule<'_> {
    /// Keys node `n` and settles it, or readies its runs.
    pub(super) fn open(&mut self, n: usize) -> Result<(), EngineError> {
        let node = &self.plan.nodes[n];
        if self.options.dry_run && self.producers(n).any(|p| self.nodes[p].forecast != Some(Forecast::Hit)) {
            self.nodes[n].forecast = Some(Forecast::MayRun);
            return self.finish(n);
        }
        let broken = self.broken_above(n);
        if broken.iter().any(Broken::is_empty) {
            self.nodes[n].skipped = 1;
            self.nodes[n].broken = vec![Broken::new()];
            return self.finish(n);
        }
        let spec = node.kind.spec();
        let (share, names) =
            self.kinds.entry((spec.name, spec.method)).or_insert_with(|| (key::kind(spec), key::source_params(spec)));
        let share = *share;
        if !names.is_empty() {
            match source::sources(spec, node.params.json(), names, self.cache) {
                Ok(found) => {
                    self.nodes[n].source_keys = found.keys;
                    self.nodes[n].roots = found.roots;
                }
                Err(message) => return self.fail_node(n, message),
            }
        }
        let state = &self.nodes[n];
        let fixed = key::fixed(share, node.params.json(), &state.source_keys);
        let inputs = inputs::of_key(self.plan, n).iter().map(|i| Some(self.output(i.from?).hash)).collect::<Vec<_>>();
        let mapped = !node.axes.is_empty();
        let state = &mut self.nodes[n];
        state.fixed = fixed;
        state.key =
            if mapped { key::map(fixed, &inputs, &elements::shape(node)) } else { key::run(fixed, &inputs, None) };
        state.inputs = inputs;
        debug_assert!(
            mapped || (0..node.inputs.len()).all(|i| elements::takes_all(node, i)),
            "a node without axes takes whole lists"
        );
        let forced = self.forced.contains(&n);
        if broken.is_empty() && !forced && self.options.audit == 0.0 && self.trust == Trust::Nodes {
            if let Some(trace) = self.previous_trace(n).filter(|t| believable(t, &self.nodes[n], mapped)) {
                let outputs = trace.outputs.iter().map(|o| Output { hash: o.hash, size: o.size, rows: None }).collect();
                let (warnings, elements) = (trace.warnings.clone(), trace.elements);
                let state = &mut self.nodes[n];
                (state.outputs, state.warnings, state.hits) = (outputs, warnings, elements);
                return self.finish(n);
            }
            if mapped {
                let key = self.nodes[n].key;
                if let Some(record) = self.cache.map(&key)? {
                    self.cache.touch_map(key);
                    let state = &mut self.nodes[n];
                    state.hits = record.rows.len() as u64;
                    state.warnings = record.warnings.clone();
                    state.outputs = tables(spec.outputs.len(), record.rows.iter().map(|r| (&*r.name, &r.outputs[..])));
                    return self.finish(n);
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
        self.nodes[n].runs.clear();
        if found.is_none()
            && let Some(old) = self.previous_trace(n).filter(|t| !t.mapped).map(|t| t.key)
        {
            // What it is about to make is mostly what it made last time.
            for (_, record) in self.cache.runs(&old)? {
                self.cache.note_indexed(&record);
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
        self.add_run(n, "".into(), key, state, cause, found.map(|(_, record)| record));
        self.opened(n)
    }

    /// A mapped node that is no hit as a whole.
    fn open_elements(&mut self, n: usize, broken: Vec<Broken>) -> Result<(), EngineError> {
        if !self.bind(n)? {
            return Ok(());
        }
        let node = &self.plan.nodes[n];
        let uses_name = node.kind.spec().uses_name;
        let Some(binding) = self.nodes[n].binding.take() else { return Ok(()) };
        let names = match binding.domain(node, !broken.is_empty()) {
            Ok(names) => names,
            Err(e) => return self.fail_node(n, e.to_string()),
        };
        let forced = self.forced.contains(&n) || self.options.audit > 0.0;
        let before = match self.previous_trace(n).filter(|t| t.mapped && !forced && self.trust == Trust::Nodes) {
            Some(trace) => {
                let key = trace.key;
                self.cache.map(&key)?.map(|r| r.rows).unwrap_or_default()
            }
            None => Vec::new(),
        };
        let mut unmet = broken.clone();
        let mut keys = key::Runs::new(self.nodes[n].fixed);
        for (at, name) in names.into_iter().enumerate() {
            let hit = |b: &Broken| {
                let mut parts = node.axes.iter().zip(name.split(crate::engine::value::JOIN));
                parts.all(|(axis, part)| b.get(axis).is_none_or(|x| x == part))
            };
            if broken.iter().any(hit) {
                unmet.retain(|b| !hit(b));
                self.add_run(n, name, Digest::default(), State::Skipped, Cause::Missing, None);
                continue;
            }
            let taken = match binding.take(&name, at) {
                Ok(taken) => taken,
                Err(e) => {
                    let run = self.add_run(n, name, Digest::default(), State::Failed, Cause::Missing, None);
                    self.tell_failure(run, e.to_string());
                    continue;
                }
            };
            let element = uses_name.then(|| shown(&name));
            let key = keys.key(&binding.hashes(&taken), element.as_deref());
            // The previous map in memory first: an unchanged element costs no look-up.
            let near = before.get(at).filter(|r| *r.name == *name);
            let old = near.or_else(|| before.binary_search_by(|r| (*r.name).cmp(&*name)).ok().map(|i| &before[i]));
            if let Some(row) = old.filter(|r| r.key == key) {
                let id = self.add_run(n, name, key, State::Hit, Cause::Missing, None);
                self.run_mut(id).outputs = row.outputs.clone();
                continue;
            }
            let found = self.look_up(n, &key)?;
            if found.is_some() {
                self.cache.touch_run(key);
            }
            let (state, cause) = self.judge(n, &key, found.is_some());
            self.nodes[n].reads |= found.as_ref().is_some_and(|(_, r)| !r.reads.is_empty());
            self.add_run(n, name, key, state, cause, found.map(|(_, record)| record));
        }
        let state = &mut self.nodes[n];
        state.binding = Some(binding);
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
                return Ok(Some((variant, record)));
            }
        }
        Ok(None)
    }

    /// What is to be done with a run whose result is `known`, or not.
    fn judge(&self, n: usize, key: &Digest, known: bool) -> (State, Cause) {
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

    pub(super) fn add_run(
        &mut self,
        n: usize,
        name: Arc<str>,
        key: Digest,
        state: State,
        cause: Cause,
        record: Option<Arc<RunRecord>>,
    ) -> RunId {
        let (outputs, warnings) = record.map_or_else(Default::default, |r| (r.outputs.clone(), r.warnings.clone()));
        let node = &mut self.nodes[n];
        match state {
            State::Hit => node.hits += 1,
            State::Skipped => node.skipped += 1,
            State::Failed => node.failed += 1,
            _ => {}
        }
        let run =
            Run { name, key, state, cause, outputs, warnings, missing: 0, waiters: Vec::new(), lock: None, memory: 0 };
        node.runs.push(run);
        RunId { node: n, run: node.runs.len() - 1 }
    }

    /// The runs are known: starts those that must run, or finishes the node.
    fn opened(&mut self, n: usize) -> Result<(), EngineError> {
        let node = &mut self.nodes[n];
        let ready = node.runs.iter().enumerate().filter(|(_, r)| r.state == State::Ready);
        let ready: Vec<RunId> = ready.map(|(run, _)| RunId { node: n, run }).collect();
        if self.options.dry_run {
            node.ran = ready.len() as u64;
            node.forecast = (!ready.is_empty()).then_some(Forecast::Runs);
            return self.finish(n);
        }
        node.pending = ready.len();
        if ready.is_empty() {
            return self.finish(n);
        }
        node.state = State::Ready;
        let (elements, hits) = (node.runs.len() as u64, node.hits);
        if !self.plan.nodes[n].axes.is_empty() || self.bind(n)? {
            self.ready.extend(ready);
        }
        self.events.event(&Event::NodeStarted { node: self.name(n), elements, hits });
        Ok(())
    }

    /// Gathers what reaches `n` through its ports. False if a relation's value is lost: the node opens again when it
    /// is there.
    pub(super) fn bind(&mut self, n: usize) -> Result<bool, EngineError> {
        if self.nodes[n].binding.is_some() {
            return Ok(true);
        }
        let node = &self.plan.nodes[n];
        let mut feeds = Vec::with_capacity(node.inputs.len());
        for (i, input) in node.inputs.iter().enumerate() {
            let Some(from) = input.from else {
                feeds.push(None);
                continue;
            };
            let rows = self.rows(from)?;
            let via = match input.via {
                Some(via) => match self.via(n, i, via)? {
                    Some(via) => Some(via),
                    None => return Ok(false),
                },
                None => None,
            };
            let outer = match elements::outer(self.plan, n, i) {
                Some(outer) => Some(self.rows(outer)?),
                None => None,
            };
            feeds.push(Some(Feed { rows, hash: self.output(from).hash, via, outer }));
        }
        self.nodes[n].binding = Some(Binding::new(node, feeds));
        Ok(true)
    }

    fn via(&mut self, n: usize, port: usize, from: OutputRef) -> Result<Option<Via>, EngineError> {
        let node = &self.plan.nodes[n];
        let maker = &self.plan.nodes[from.node.0 as usize];
        let rows = self.rows(from)?;
        let mut relations = BTreeMap::new();
        for row in rows.iter() {
            let hash = row.value.hash;
            let spec = &maker.kind.spec().outputs[from.port as usize];
            match self.fetch(hash, spec)? {
                Ok(data) => {
                    // The plan has checked that the output is a relation.
                    let wrong = || EngineError::Again("a relation is of another type".to_owned());
                    relations.insert(hash, data.downcast::<Relation>().map_err(|_| wrong())?);
                }
                Err(_) if self.options.dry_run => {
                    // Its producer would run, and what comes out may be the same.
                    self.nodes[n].forecast = Some(Forecast::MayRun);
                    self.finish(n)?;
                    return Ok(None);
                }
                Err(what) => {
                    self.mend(from, &row.name, hash, &what, Waiter::Node(n))?;
                    return Ok(None);
                }
            }
        }
        let gathered = elements::gathered(node, port);
        let made_there = |a: &&OutputRef| a.node == from.node;
        let position = |of: &[OutputRef]| of.iter().position(|a| made_there(&a));
        Ok(Some(Via {
            rows,
            axes: maker.axes.clone(),
            relations,
            gathered_at: position(&gathered).unwrap_or(0),
            element_at: position(&node.axes).or((node.axes.len() == 1).then_some(0)),
        }))
    }

    fn producers(&self, n: usize) -> impl Iterator<Item = usize> {
        let inputs = self.plan.nodes[n].inputs.iter();
        inputs.flat_map(|input| [input.from, input.via]).flatten().map(|from| from.node.0 as usize)
    }

    /// What failed above, as far as the node's own axes tell it apart. An empty entry: all of the node is lost.
    fn broken_above(&self, n: usize) -> Vec<Broken> {
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

    fn fail_node(&mut self, n: usize, message: String) -> Result<(), EngineError> {
        self.nodes[n].failed += 1;
        self.nodes[n].broken = vec![Broken::new()];
        self.events.event(&Event::Failed { node: self.name(n), element: None, error: &message });
        self.errors.push(Failure { node: self.name(n).to_owned(), element: None, message });
        self.finish(n)
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
