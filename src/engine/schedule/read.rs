//! Reading what is settled: values, the rows of lists, and the runs of nodes that were believed as a whole.

use super::{Run, Schedule, state::Output, task};
use crate::engine::cache::Stored;
use crate::engine::{
    elements::Rows,
    error::EngineError,
    hash::Digest,
    node::{Arity, Data, PortSpec},
    plan::{NodeId, OutputRef},
    record::MapRecord,
    value::{PortOut, Row, ValueRef, join, list_hash},
};
use std::{fmt, sync::Arc};

/// Why a value that a record names is not there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Gone {
    /// Its node is transient: it is made again where it is needed.
    NotKept,
    /// The cache lost it: what is wrong.
    Lost(String),
}

impl fmt::Display for Gone {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::NotKept => f.write_str("its node is transient"),
            Self::Lost(what) => f.write_str(what),
        }
    }
}

impl Gone {
    pub(super) fn missing() -> Self {
        Self::Lost("it is no longer in the cache".to_owned())
    }
}

impl Schedule<'_> {
    /// Reads one value on this thread: relations and files to publish, which are small or wanted at once.
    /// The inner error says why it is not there.
    pub fn fetch(&mut self, hash: Digest, spec: &PortSpec) -> Result<Result<Data, Gone>, EngineError> {
        if let Some(data) = self.held.get(&hash) {
            return Ok(Ok(data));
        }
        let stored = match self.cache.value(&hash)? {
            Some(Stored::NotKept) => return Ok(Err(Gone::NotKept)),
            Some(stored) => stored,
            None => return Ok(Err(Gone::missing())),
        };
        let load = task::Load::new(hash, stored, self.cache.is_verified(&hash), false);
        match task::fetch(&load, spec, self.cache.blobs()) {
            Ok((data, _)) => {
                self.cache.mark_verified(hash);
                Ok(Ok(data))
            }
            Err(task::FetchError::Bad(what)) => Ok(Err(Gone::Lost(what))),
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
            record.map(|(_, record)| tables(ports, [("".into(), &record.outputs[..])].into_iter()))
        } else {
            let record = self.cache.map(&key)?;
            record.map(|r| tables(ports, r.rows.iter().map(|r| (r.name.as_str().into(), &r.outputs[..]))))
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
        self.bind(n)?;
        if !self.nodes[n].runs.is_empty() {
            return Ok(());
        }
        // The map may be what waits to be written.
        self.cache.flush()?;
        let hits = self.nodes[n].hits;
        if self.plan.nodes[n].axes.is_empty() {
            let mut outputs = Vec::new();
            for (port, spec) in self.plan.nodes[n].kind.spec().outputs.iter().enumerate() {
                let rows = self.rows(OutputRef { node: NodeId(n as u32), port: port as u32 })?;
                outputs.push(match spec.arity {
                    Arity::Many { .. } => PortOut::Many(rows.iter().map(|r| (r.name.to_string(), r.value)).collect()),
                    _ => PortOut::One(rows[0].value),
                });
            }
            let key = self.nodes[n].key;
            self.add_run(n, Run::hit("".into(), key, &outputs));
        } else {
            let key = self.nodes[n].key;
            let name = self.name(n);
            let gone = || EngineError::Again(format!("the cache no longer holds the map of {name}"));
            let record: MapRecord = self.cache.map(&key)?.ok_or_else(gone)?;
            for row in record.rows {
                self.add_run(n, Run::hit(row.name.into(), row.key, &row.outputs));
            }
        }
        self.nodes[n].hits = hits;
        Ok(())
    }
}

/// A mapped node's outputs from those of its runs, in the order of their names.
pub(super) fn tables<'a>(ports: usize, runs: impl Iterator<Item = (Arc<str>, &'a [PortOut])>) -> Vec<Output> {
    let mut rows: Vec<Vec<Row>> = vec![Vec::new(); ports];
    let mut single = None;
    for (name, outputs) in runs {
        for (port, out) in outputs.iter().enumerate().take(ports) {
            match out {
                PortOut::One(value) => {
                    rows[port].push(Row { name: name.clone(), value: *value });
                    single = single.or(name.is_empty().then_some(()));
                }
                PortOut::Many(list) => {
                    rows[port].extend(list.iter().map(|(n, v)| Row { name: join(&name, n).into(), value: *v }));
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
