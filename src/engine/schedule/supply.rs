//! What reaches a node: rows of the lists above it, relations, single values; loaded when someone asks.

use super::{Cause, Output, Schedule, State, Waiter, task};
use crate::engine::{
    elements::{self, Binding, Feed, Rows, Taken, Via},
    error::EngineError,
    hash::Digest,
    node::PortSpec,
    plan::{OutputRef, Relation},
    record::MapRecord,
    value::{PortOut, Row, ValueRef, join, list_hash},
};
use std::{collections::BTreeMap, sync::Arc};

impl Schedule<'_> {
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
            let outer = match self.outer(n, i) {
                Some(outer) => Some(self.rows(outer)?),
                None => None,
            };
            feeds.push(Some(Feed { rows, hash: self.output(from).hash, via, outer }));
        }
        self.nodes[n].binding = Some(Binding::new(node, feeds));
        Ok(true)
    }

    /// The list that made the axes below which port `i` of node `n` gathers.
    pub(super) fn outer(&self, n: usize, i: usize) -> Option<OutputRef> {
        let node = &self.plan.nodes[n];
        let kept = elements::kept(node, i);
        let last = *kept.last()?;
        if elements::gathered(node, i).is_empty() {
            return None;
        }
        let mut axes = self.plan.nodes[last.node.0 as usize].axes.clone();
        axes.push(last);
        (axes == kept).then_some(last)
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

    /// Reads one value on this thread: relations and files to publish, which are small or wanted at once.
    /// The inner error says how it is lost.
    pub fn fetch(
        &mut self,
        hash: Digest,
        spec: &PortSpec,
    ) -> Result<Result<crate::engine::node::Data, String>, EngineError> {
        if let Some(data) = self.held.get(&hash) {
            return Ok(Ok(data));
        }
        let Some(stored) = self.cache.value(&hash)? else {
            return Ok(Err("it is no longer in the cache".to_owned()));
        };
        let load = task::Load::new(hash, stored, self.cache.is_verified(&hash), false);
        match task::fetch(&load, spec, self.cache.blobs()) {
            Ok((data, _)) => {
                self.cache.mark_verified(hash);
                Ok(Ok(data))
            }
            Err(task::FetchError::Bad(what)) => Ok(Err(what)),
            Err(task::FetchError::Other(task::TaskError::Cache(e) | task::TaskError::Failed(e))) => {
                Err(EngineError::cache(self.cache.root(), e))
            }
            Err(task::FetchError::Other(_)) => Err(EngineError::Interrupted),
        }
    }

    /// The rows of an output of a settled node.
    pub fn rows(&mut self, from: OutputRef) -> Result<Rows, EngineError> {
        let (n, port) = (from.node.0 as usize, from.port as usize);
        if let Some(rows) = &self.nodes[n].outputs[port].rows {
            return Ok(rows.clone());
        }
        let output = &self.nodes[n].outputs[port];
        let rows: Rows = match output.size {
            Some(size) => Arc::new(vec![Row { name: "".into(), value: ValueRef { hash: output.hash, size } }]),
            None => {
                self.load_rows(n)?;
                self.nodes[n].outputs[port].rows.clone().unwrap_or_default()
            }
        };
        self.nodes[n].outputs[port].rows = Some(rows.clone());
        Ok(rows)
    }

    /// Loads the lists of a node that was believed as a whole.
    fn load_rows(&mut self, n: usize) -> Result<(), EngineError> {
        let key = self.nodes[n].key;
        let ports = self.nodes[n].outputs.len();
        let loaded = if self.plan.nodes[n].axes.is_empty() {
            let record = self.look_up(n, &key)?;
            record.map(|(_, record)| tables(ports, [("", &record.outputs[..])].into_iter()))
        } else {
            let record = self.cache.map(&key)?;
            record.map(|r| tables(ports, r.rows.iter().map(|r| (&*r.name, &r.outputs[..]))))
        };
        let gone = || EngineError::Again(format!("the cache no longer holds what it said of {}", self.name(n)));
        let loaded = loaded.ok_or_else(gone)?;
        let same = loaded.iter().zip(&self.nodes[n].outputs).all(|(a, b)| a.hash == b.hash);
        if !same {
            return Err(gone());
        }
        self.nodes[n].outputs = loaded;
        Ok(())
    }

    /// Gives a node that was believed as a whole its runs, all hits, so that one of them can be made again.
    pub(super) fn expand_known(&mut self, n: usize) -> Result<(), EngineError> {
        if !self.bind(n)? {
            return Err(EngineError::Again(format!("a relation above {} is lost too", self.name(n))));
        }
        if !self.nodes[n].runs.is_empty() {
            return Ok(());
        }
        let hits = self.nodes[n].hits;
        if self.plan.nodes[n].axes.is_empty() {
            let mut outputs = Vec::new();
            for (port, spec) in self.plan.nodes[n].kind.spec().outputs.iter().enumerate() {
                let rows = self.rows(OutputRef { node: crate::engine::plan::NodeId(n as u32), port: port as u32 })?;
                outputs.push(match spec.arity {
                    crate::engine::node::Arity::Many { .. } => {
                        PortOut::Many(rows.iter().map(|r| (r.name.to_string(), r.value)).collect())
                    }
                    _ => PortOut::One(rows[0].value),
                });
            }
            let key = self.nodes[n].key;
            let id = self.add_run(n, "".into(), key, State::Hit, Cause::Missing, None);
            self.run_mut(id).outputs = outputs;
        } else {
            let key = self.nodes[n].key;
            let name = self.name(n);
            let gone = || EngineError::Again(format!("the cache no longer holds the map of {name}"));
            let record: MapRecord = self.cache.map(&key)?.ok_or_else(gone)?;
            for row in record.rows {
                let id = self.add_run(n, row.name.into(), row.key, State::Hit, Cause::Missing, None);
                self.run_mut(id).outputs = row.outputs;
            }
        }
        self.nodes[n].hits = hits;
        Ok(())
    }
}

/// A mapped node's outputs from those of its runs, in the order of their names.
pub(super) fn tables<'a>(ports: usize, runs: impl Iterator<Item = (&'a str, &'a [PortOut])>) -> Vec<Output> {
    let mut rows: Vec<Vec<Row>> = vec![Vec::new(); ports];
    let mut single = None;
    for (name, outputs) in runs {
        for (port, out) in outputs.iter().enumerate().take(ports) {
            match out {
                PortOut::One(value) => {
                    rows[port].push(Row { name: name.into(), value: *value });
                    single = single.or(name.is_empty().then_some(()));
                }
                PortOut::Many(list) => {
                    rows[port].extend(list.iter().map(|(n, v)| Row { name: join(name, n).into(), value: *v }));
                }
            }
        }
    }
    let table = |rows: Vec<Row>| {
        if let (Some(()), [Row { name, value }]) = (single, &rows[..])
            && name.is_empty()
        {
            return Output { hash: value.hash, size: Some(value.size), rows: Some(Arc::new(rows)) };
        }
        let hash = list_hash(rows.iter().map(|r| (&*r.name, r.value.hash)));
        Output { hash, size: None, rows: Some(Arc::new(rows)) }
    };
    rows.into_iter().map(table).collect()
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
