//! Elements flow: a run of a mapped node starts as soon as its own inputs exist, while its producers still run.
//!
//! A node flows where one of its ports takes, one by one, rows that name the node's elements (the driver). What else it
//! reads must be settled first, or arrive element by element too. When all producers are settled the node is closed
//! like any other ([`super::open`]): only then is it certain which elements there are, and its key as a whole is known.

use super::{
    Run, RunId, Schedule,
    state::{Broken, Cause, State, Waiter, is_below},
};
use crate::engine::{
    elements::{self, Binding, Feed, Live, Via},
    error::EngineError,
    events::Event,
    hash::Digest,
    key,
    node::Arity,
    plan::{OutputRef, Plan, PlanNode, Relation},
    report::Forecast,
    source,
    value::{JOIN, PortOut, ValueRef, shown},
};
use std::{collections::BTreeMap, sync::Arc};

/// Whether node `n` needs all that `producer` makes before any run of it can start.
pub(super) fn is_gate(plan: &Plan, n: usize, producer: usize) -> bool {
    let node = &plan.nodes[n];
    let is = |from: Option<OutputRef>| from.is_some_and(|from| from.node.0 as usize == producer);
    node.inputs.iter().enumerate().any(|(port, input)| {
        let one_by_one = elements::arrives(node, port).or(elements::gathers_below(node, port));
        is(input.from) && one_by_one.is_none()
            || is(input.via) && elements::relation_arrives(node, &plan.nodes[producer].axes).is_none()
    })
}

/// The output whose rows are the elements of node `n`, if its runs may start before all of them are known.
pub(super) fn driver(plan: &Plan, n: usize) -> Option<OutputRef> {
    let node = &plan.nodes[n];
    let all = Some(node.axes.len()).filter(|n| *n > 0)?;
    let ports = 0..node.inputs.len();
    if let Some(port) = ports.clone().find(|port| elements::arrives(node, *port) == Some(all)) {
        return node.inputs[port].from;
    }
    // A list that is gathered below an axis may be empty: the elements are those of the list that made the axis.
    let port = ports.clone().find(|port| elements::gathers_below(node, *port) == Some(all))?;
    elements::outer(plan, n, port)
}

/// The first `count` names of an element.
fn first_names(name: &str, count: usize) -> &str {
    let end = name.match_indices(JOIN).nth(count.saturating_sub(1)).map_or(name.len(), |(at, _)| at);
    &name[..end]
}

/// Whether `element` is one of those below which something failed.
pub(super) fn is_lost(node: &PlanNode, broken: &Broken, element: &str) -> bool {
    let mut parts = node.axes.iter().zip(element.split(JOIN));
    parts.all(|(axis, part)| broken.get(axis).is_none_or(|name| name == part))
}

impl Live for Schedule<'_> {
    fn row(&self, from: OutputRef, name: &str) -> Option<ValueRef> {
        let (p, port) = (from.node.0 as usize, from.port as usize);
        let state = &self.nodes[p];
        if let Some(rows) = state.outputs.get(port).and_then(|output| output.rows.as_ref()) {
            return rows.binary_search_by(|row| (*row.name).cmp(name)).ok().map(|at| rows[at].value);
        }
        let many = matches!(self.plan.nodes[p].kind.spec().outputs[port].arity, Arity::Many { .. });
        let (outer, inner) = if many { name.rsplit_once(JOIN).unwrap_or(("", name)) } else { (name, "") };
        let run = &state.runs[state.run_of(outer)?];
        match run.outputs.get(port).filter(|_| run.state.is_good())? {
            PortOut::One(value) => Some(*value),
            PortOut::Many(list) => list.binary_search_by(|(name, _)| (**name).cmp(inner)).ok().map(|at| list[at].1),
        }
    }

    fn is_whole(&self, from: OutputRef, prefix: &str) -> bool {
        self.is_whole_below(from.node.0 as usize, prefix)
    }

    fn below(&self, from: OutputRef, prefix: &str) -> Vec<(Arc<str>, ValueRef)> {
        let state = &self.nodes[from.node.0 as usize];
        if let Some(rows) = state.outputs.get(from.port as usize).and_then(|output| output.rows.as_ref()) {
            let first = rows.partition_point(|row| &*row.name < prefix);
            let found = rows[first..].iter().take_while(|row| is_below(&row.name, prefix));
            return found.map(|row| (row.name.clone(), row.value)).collect();
        }
        let runs = state.runs_below(prefix).into_iter().map(|at| &state.runs[at]);
        runs.filter(|run| run.state.is_good()).flat_map(|run| run.rows(from.port)).collect()
    }
}

impl Schedule<'_> {
    /// Looks whether runs of `n` may be admitted now; they are later.
    pub(super) fn stir(&mut self, n: usize) {
        let begun = |from: OutputRef| self.nodes[from.node.0 as usize].state != State::Waiting;
        let node = &self.nodes[n];
        let can = node.driver.is_some() && node.gates == 0 && node.waits > 0 && !node.flows && !self.options.dry_run;
        let inputs = self.plan.nodes[n].inputs.iter();
        if can && inputs.flat_map(|input| [input.from, input.via]).flatten().any(begun) {
            self.to_flow.push_back(n);
        }
    }

    pub(super) fn stir_consumers(&mut self, n: usize) {
        for at in 0..self.nodes[n].consumers.len() {
            self.stir(self.nodes[n].consumers[at]);
        }
    }

    /// Admits the runs of `n` whose inputs are there; from now on others follow as theirs arrive.
    pub(super) fn flow(&mut self, n: usize) -> Result<(), EngineError> {
        let state = &self.nodes[n];
        let Some(driver) = state.driver.filter(|_| !state.closed && state.waits > 0) else { return Ok(()) };
        let begins = !state.flows;
        if begins {
            let broken = self.broken_above(n);
            // What is lost as a whole is told when the node is closed.
            if broken.iter().any(Broken::is_empty) || !self.prepare(n)? {
                return Ok(());
            }
            self.load_before(n)?;
            let state = &mut self.nodes[n];
            (state.flows, state.lost_above, state.state) = (true, broken, State::Ready);
        }
        self.bind(n)?;
        for name in self.rows_below(driver, "") {
            self.admit_if_whole(n, name)?;
        }
        if begins {
            let state = &self.nodes[n];
            let (elements, hits) = (state.runs.len() as u64, state.hits);
            self.events.event(&Event::NodeStarted { node: self.name(n), elements, hits });
            self.stir_consumers(n);
        }
        Ok(())
    }

    /// The outputs of `id` are there: admits the runs below that waited for nothing else.
    pub(super) fn arrived(&mut self, id: RunId) -> Result<(), EngineError> {
        let plan = self.plan;
        for at in 0..self.nodes[id.node].consumers.len() {
            let c = self.nodes[id.node].consumers[at];
            let Some(driver) = self.nodes[c].driver.filter(|_| self.nodes[c].flows && !self.nodes[c].closed) else {
                continue;
            };
            let arriving = self.nodes[c].binding.as_ref().map(Binding::arriving).unwrap_or_default();
            let mut seen: Vec<(OutputRef, usize)> = Vec::new();
            for (from, count) in arriving.into_iter().filter(|(from, _)| from.node.0 as usize == id.node) {
                if seen.contains(&(from, count)) {
                    continue;
                }
                seen.push((from, count));
                let run = &self.nodes[id.node].runs[id.run];
                let many =
                    matches!(plan.nodes[id.node].kind.spec().outputs[from.port as usize].arity, Arity::Many { .. });
                let gathers = plan.nodes[id.node].axes.len() + usize::from(many) > count;
                let names: Vec<Arc<str>> = match gathers {
                    true => vec![first_names(&run.name, count).into()],
                    false => run.rows(from.port).into_iter().map(|(name, _)| name).collect(),
                };
                for name in names {
                    if count == plan.nodes[c].axes.len() {
                        self.admit_if_whole(c, name)?;
                    } else {
                        for name in self.rows_below(driver, &name) {
                            self.admit_if_whole(c, name)?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    fn admit_if_whole(&mut self, n: usize, name: Arc<str>) -> Result<(), EngineError> {
        let state = &self.nodes[n];
        let lost = || state.lost_above.iter().any(|broken| is_lost(&self.plan.nodes[n], broken, &name));
        if state.run_of(&name).is_some() || lost() {
            return Ok(());
        }
        let whole = |binding: &Binding| binding.has_all(&name, self);
        if state.binding.as_ref().is_some_and(whole) {
            self.admit(n, name, usize::MAX)?;
        }
        Ok(())
    }

    /// Keys the run of an element of `n`, all of whose inputs exist: it is a hit, or has to run. False if a relation must
    /// be made again first. `hint`: where its row may lie in a list.
    pub(super) fn admit(&mut self, n: usize, name: Arc<str>, hint: usize) -> Result<bool, EngineError> {
        if let Some((from, value, gone)) = self.decode_relations(n, &name)? {
            let state = &mut self.nodes[n];
            if self.options.dry_run {
                // Its producer would run, and what comes out may be the same.
                state.forecast = Some(Forecast::MayRun);
                self.close(n)?;
                return Ok(false);
            }
            // A relation that arrives admits the elements that ask it.
            let waiter = if state.waits == 0 { Waiter::Node(n) } else { Waiter::Outside };
            let row = self.relation_row(n, from, &name);
            self.mend(from, &row, value.hash, &gone, waiter)?;
            return Ok(false);
        }
        let Some(taken) = self.take_inputs(n, &name, hint) else { return Ok(false) };
        let taken = match taken {
            Ok(taken) => taken,
            Err(e) => {
                let id = self.add_run(n, Run::new(name, Digest::default(), State::Failed, Cause::Missing));
                self.let_go(id);
                self.tell_failure(id, e.to_string());
                return Ok(true);
            }
        };
        let element = self.plan.nodes[n].kind.spec().uses_name.then(|| shown(&name));
        let state = &mut self.nodes[n];
        let Some(binding) = &state.binding else { return Ok(false) };
        let keys = state.keys.get_or_insert_with(|| key::Runs::new(state.fixed));
        let key = keys.key(&binding.hashes(&taken), element.as_deref());
        // The previous map in memory first: an unchanged element costs no look-up.
        let before = state.before.as_deref().unwrap_or_default();
        let near = before.get(hint).filter(|r| *r.name == *name);
        let old = near.or_else(|| before.binary_search_by(|r| (*r.name).cmp(&*name)).ok().map(|i| &before[i]));
        if let Some(row) = old.filter(|r| r.key == key) {
            let run = Run::hit(name, key, &row.outputs);
            let id = self.add_run(n, run);
            self.let_go(id);
            self.arrived(id)?;
            return Ok(true);
        }
        let found = self.look_up(n, &key)?;
        if found.is_some() {
            self.cache.touch_run(key);
        }
        let (state, cause) = self.judge(n, &key, found.is_some());
        let record = found.as_ref().map(|(_, record)| &**record);
        self.nodes[n].reads |= record.is_some_and(|r| !r.reads.is_empty());
        let id = self.add_found(n, Run::new(name, key, state, cause), record);
        match state {
            State::Hit => {
                self.let_go(id);
                self.arrived(id)?;
            }
            State::Ready if !self.options.dry_run => {
                self.nodes[n].pending += 1;
                self.make_ready(id);
            }
            _ => {}
        }
        Ok(true)
    }

    /// What an element takes through the node's ports; `None` where the node is not bound.
    pub(super) fn take_inputs(
        &self,
        n: usize,
        name: &str,
        hint: usize,
    ) -> Option<Result<Vec<elements::Taken>, elements::ElementError>> {
        let binding = self.nodes[n].binding.as_ref()?;
        Some(binding.take(name, hint, self))
    }

    /// The names of the rows of an output that are there, below `prefix`.
    fn rows_below(&self, from: OutputRef, prefix: &str) -> Vec<Arc<str>> {
        self.below(from, prefix).into_iter().map(|(name, _)| name).collect()
    }

    /// Whether all runs of node `p` below `prefix` are known, and have ended well.
    fn is_whole_below(&self, p: usize, prefix: &str) -> bool {
        let state = &self.nodes[p];
        if state.state.is_settled() {
            return state.state.is_good();
        }
        // Where something is lost above, only the whole tells what is lost here.
        if !state.closed && !state.flows || !state.lost_above.is_empty() || !state.broken.is_empty() {
            return false;
        }
        let arriving = state.binding.as_ref().filter(|_| !state.closed).map(Binding::arriving).unwrap_or_default();
        let above =
            |(from, count): &(OutputRef, usize)| self.is_whole_below(from.node.0 as usize, first_names(prefix, *count));
        // Its runs are admitted one after the other: those that are known may not be all.
        let known = |driver| self.rows_below(driver, prefix).iter().all(|name| state.run_of(name).is_some());
        state.is_good_below(prefix) && arriving.iter().all(above) && (state.closed || state.driver.is_some_and(known))
    }

    /// Finds sources, and hashes what all keys of `n` share. False if it failed.
    pub(super) fn prepare(&mut self, n: usize) -> Result<bool, EngineError> {
        if self.nodes[n].keys.is_some() {
            return Ok(true);
        }
        let node = &self.plan.nodes[n];
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
                Err(message) => {
                    self.fail_node(n, message)?;
                    return Ok(false);
                }
            }
        }
        let state = &mut self.nodes[n];
        state.fixed = key::fixed(share, node.params.json(), &state.source_keys);
        state.keys = Some(key::Runs::new(state.fixed));
        Ok(true)
    }

    /// Loads what the last bake's runs of `n` were.
    pub(super) fn load_before(&mut self, n: usize) -> Result<(), EngineError> {
        if self.nodes[n].before.is_some() {
            return Ok(());
        }
        let forced = self.forced.contains(&n) || self.options.audit > 0.0;
        let trusted = !forced && self.trust == super::Trust::Nodes;
        let key = self.previous_trace(n).filter(|t| t.mapped && trusted).map(|t| t.key);
        let map = match key {
            Some(key) => self.cache.map(&key)?,
            None => None,
        };
        self.nodes[n].before = Some(map.map(|map| map.rows).unwrap_or_default());
        Ok(())
    }

    /// Gathers what reaches `n` through its ports; rows of producers that are not settled arrive later.
    pub(super) fn bind(&mut self, n: usize) -> Result<(), EngineError> {
        let plan = self.plan;
        if let Some(binding) = &self.nodes[n].binding {
            for (from, _) in binding.arriving() {
                let Some(rows) = self.known_rows(from)? else { continue };
                let mut outer = Vec::new();
                for port in 0..plan.nodes[n].inputs.len() {
                    let list = elements::outer(plan, n, port);
                    outer.push(list.map(|list| self.known_rows(list)).transpose()?.flatten());
                }
                let hash = self.output(from).hash;
                if let Some(binding) = &mut self.nodes[n].binding {
                    binding.complete(&plan.nodes[n], from, &rows, hash, |port| outer[port].clone());
                }
            }
            return Ok(());
        }
        let node = &plan.nodes[n];
        let mut feeds = Vec::with_capacity(node.inputs.len());
        for (i, input) in node.inputs.iter().enumerate() {
            let Some(from) = input.from else {
                feeds.push(None);
                continue;
            };
            let rows = self.known_rows(from)?;
            let hash = rows.as_ref().map_or(Digest::default(), |_| self.output(from).hash);
            let via = match input.via {
                Some(via) => Some(self.via(n, i, via)?),
                None => None,
            };
            let outer = match elements::outer(plan, n, i) {
                Some(outer) => self.known_rows(outer)?,
                None => None,
            };
            feeds.push(Some(Feed { from, rows, hash, via, outer }));
        }
        self.nodes[n].binding = Some(Binding::new(node, feeds));
        Ok(())
    }

    fn known_rows(&mut self, from: OutputRef) -> Result<Option<elements::Rows>, EngineError> {
        if self.nodes[from.node.0 as usize].outputs.is_empty() { Ok(None) } else { self.rows(from).map(Some) }
    }

    fn via(&mut self, n: usize, port: usize, from: OutputRef) -> Result<Via, EngineError> {
        let rows = self.known_rows(from)?;
        let node = &self.plan.nodes[n];
        let axes = self.plan.nodes[from.node.0 as usize].axes.clone();
        let gathered = elements::gathered(node, port);
        let position = |of: &[OutputRef]| of.iter().position(|a| a.node == from.node);
        Ok(Via {
            from,
            rows,
            columns: elements::positions(&axes, &node.axes),
            axes,
            relations: BTreeMap::new(),
            gathered_at: position(&gathered).unwrap_or(0),
            alone: gathered.len() == 1,
            element_at: position(&node.axes).or((node.axes.len() == 1).then_some(0)),
        })
    }

    /// Decodes the relations that an element of `n` asks. Gives the first that is not there.
    pub(super) fn decode_relations(
        &mut self,
        n: usize,
        name: &str,
    ) -> Result<Option<(OutputRef, ValueRef, super::Gone)>, EngineError> {
        let missing = |binding: &Binding| binding.undecoded(name, self);
        let missing = self.nodes[n].binding.as_ref().map(missing).unwrap_or_default();
        for (port, from, value) in missing {
            let spec = &self.plan.nodes[from.node.0 as usize].kind.spec().outputs[from.port as usize];
            let data = match self.fetch(value.hash, spec)? {
                Ok(data) => data,
                Err(gone) => return Ok(Some((from, value, gone))),
            };
            // The plan has checked that the output is a relation.
            let relation = data.downcast::<Relation>();
            let relation = relation.map_err(|_| EngineError::Again("a relation is of another type".to_owned()))?;
            if let Some(binding) = &mut self.nodes[n].binding {
                binding.decoded(port, value.hash, relation);
            }
        }
        Ok(None)
    }

    /// The name of the relation that an element of `n` asks, among those of `from`.
    pub(super) fn relation_row(&self, n: usize, from: OutputRef, element: &str) -> String {
        let axes = &self.plan.nodes[from.node.0 as usize].axes;
        let columns = elements::positions(axes, &self.plan.nodes[n].axes);
        elements::pick(element, &columns)
    }
}
