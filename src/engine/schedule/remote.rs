//! The second level of the cache as the schedule sees it: it is asked for results that the index does not have before
//! they are made, and for values that a result names before somebody takes them; what ran is handed to it.
//!
//! Nothing here waits. A run that is asked for is [`State::Elsewhere`], a run whose inputs are on their way waits as for
//! inputs that are made again. Large values come when they are needed and not before: of a pipeline whose results are
//! all there, only what is published crosses the wire. Until then the index holds their hashes, as those of transient
//! nodes.

use super::{
    Answer, Gone, RunId, Schedule, Trust,
    state::{Cause, State, Waiter},
};
use crate::engine::{
    cache::{Fields, NewValue, Stored},
    error::EngineError,
    hash::Digest,
    key,
    plan::OutputRef,
    record::RunRecord,
    remote::{Found, Outgoing, Remote, Reply},
    source,
};
use std::{collections::BTreeMap, sync::Arc};

/// Who waits for a value, and how it is made where the second level has none: output, row, what is wrong.
type Wait = (OutputRef, String, Gone, Waiter);

/// What is asked of the second level.
#[derive(Default)]
pub(super) struct Second<'a> {
    remote: Option<&'a Remote>,
    /// Answers that are out.
    asking: usize,
    /// Values that were asked for, and who waits for them; nobody where the answer came.
    values: BTreeMap<Digest, Option<Vec<Wait>>>,
    /// What fixed parts mean.
    fields: BTreeMap<Digest, Arc<Fields>>,
    fetched: u64,
}

impl<'a> Second<'a> {
    pub fn new(remote: Option<&'a Remote>) -> Self {
        Self { remote, ..Self::default() }
    }

    pub fn asks(&self) -> bool {
        self.asking > 0
    }

    pub fn warnings(&self) -> Vec<String> {
        self.remote.map(Remote::warnings).unwrap_or_default()
    }

    fn readable(&self) -> Option<&'a Remote> {
        self.remote.filter(|remote| remote.reads())
    }
}

impl Schedule<'_> {
    /// Runs whose results came from the second level.
    pub fn fetched(&self) -> u64 {
        self.second.fetched
    }

    /// Readies a run that is not settled, unless the second level may have its result.
    pub(super) fn make_ready(&mut self, id: RunId) {
        let run = &self.nodes[id.node].runs[id.run];
        // A bake that begins again believes what it made itself.
        let may = run.cause == Cause::Missing && self.trust == Trust::Nodes;
        let Some(remote) = self.second.readable().filter(|_| may) else {
            self.ready.push(id);
            return;
        };
        let (key, answer) = (run.key, self.answers.0.clone());
        self.run_mut(id).state = State::Elsewhere;
        self.second.asking += 1;
        // Nobody listens only if the schedule has ended.
        remote.ask(key, Reply::new(move |found| drop(answer.send(Answer::Found(id, key, found)))));
    }

    /// Takes what the second level holds under a key.
    pub(super) fn take_found(&mut self, id: RunId, key: Digest, found: Option<Vec<Found>>) -> Result<(), EngineError> {
        self.second.asking -= 1;
        let n = id.node;
        let ports = self.plan.nodes[n].kind.spec().outputs.len();
        let roots = self.nodes[n].roots.clone();
        let fixed = self.nodes[n].fixed;
        let cache = &mut *self.cache;
        let mut holds = |found: &Found| {
            let Found { record, .. } = found;
            record.fixed == fixed && record.outputs.len() == ports && source::still_true(&record.reads, &roots, cache)
        };
        let Some(found) = found.unwrap_or_default().into_iter().find(|found| holds(found)) else {
            self.run_mut(id).state = State::Ready;
            self.ready.push(id);
            return Ok(());
        };
        let Found { record, values, fields } = found;
        self.files_read.extend(source::files(&record.reads, &roots));
        self.looked_at.extend(source::paths(&record.reads, &roots));
        let (variant, reads) = (record.variant(), !record.reads.is_empty());
        // What the cache has is not forgotten for what is only known.
        let here = self.cache.values(values.iter().map(|v| v.hash))?;
        let is_new = |v: &NewValue| match here.get(&v.hash) {
            None => true,
            Some(stored) => matches!((stored, v.place.stored()), (Stored::NotKept, Stored::Inline(_))),
        };
        let values = values.into_iter().filter(is_new).collect();
        self.cache.put_fixed(fixed, || fields);
        self.note_reads(id, variant, reads);
        self.nodes[n].note_result(id.run, &record.outputs, &record.warnings);
        self.cache.put_run(key, Arc::new(record), values, None)?;
        self.second.fetched += 1;
        match self.judge(n, &key, true) {
            (State::Ready, cause) => {
                let run = self.run_mut(id);
                (run.state, run.cause) = (State::Ready, cause);
                self.ready.push(id);
                Ok(())
            }
            _ => self.settled(id, State::Hit),
        }
    }

    /// Whether a value that is not there may come from the second level.
    pub(super) fn asks_for(&self, from: OutputRef, hash: Digest) -> bool {
        let answered = matches!(self.second.values.get(&hash), Some(None));
        self.second.readable().is_some() && !answered && !self.plan.nodes[from.node.0 as usize].transient
    }

    /// Asks for a value; `waiter` goes on when it is there, or when it was made.
    pub(super) fn bring(&mut self, from: OutputRef, row: &str, hash: Digest, gone: &Gone, waiter: Waiter) {
        let Some(remote) = self.second.readable() else { return };
        if let Waiter::Run(waiting, _) = waiter {
            self.run_mut(waiting).busy().missing += 1;
        }
        let wait = (from, row.to_owned(), gone.clone(), waiter);
        if let Some(Some(waits)) = self.second.values.get_mut(&hash) {
            waits.push(wait);
            return;
        }
        self.held.drop_value(&hash);
        self.second.values.insert(hash, Some(vec![wait]));
        self.second.asking += 1;
        let answer = self.answers.0.clone();
        remote.fetch(hash, Reply::new(move |value| drop(answer.send(Answer::Value(hash, value)))));
    }

    /// Takes a value from the second level; where it has none, the producer runs.
    pub(super) fn take_value(&mut self, hash: Digest, value: Option<NewValue>) -> Result<(), EngineError> {
        self.second.asking -= 1;
        let waits = self.second.values.insert(hash, None).flatten().unwrap_or_default();
        let came = value.is_some();
        if let Some(value) = value {
            self.cache.put_values(vec![value])?;
        }
        for (from, row, gone, waiter) in waits {
            if let Waiter::Run(id, _) = waiter {
                self.run_mut(id).busy().missing -= 1;
            }
            match waiter {
                _ if !came => self.make_again(from, &row, hash, &gone, waiter)?,
                Waiter::Run(id, _) => {
                    let run = self.run_mut(id);
                    if run.busy().missing == 0 && run.state == State::Waiting {
                        run.state = State::Ready;
                        self.ready.push_urgent(id);
                    }
                }
                Waiter::Node(n) => self.to_open.push_back(n),
                Waiter::Outside => {}
            }
        }
        Ok(())
    }

    /// Brings values that are about to be read one by one, all at once. A value is told by its output and row.
    pub fn bring_all(&mut self, wanted: Vec<(OutputRef, Arc<str>, Digest)>) -> Result<(), EngineError> {
        for (from, row, hash) in wanted {
            let here = self.held.contains(&hash)
                || self.cache.value(&hash)?.is_some_and(|stored| !matches!(stored, Stored::NotKept));
            if !here && self.asks_for(from, hash) {
                self.bring(from, &row, hash, &Gone::NotKept, Waiter::Outside);
            }
        }
        if self.second.asks() { self.work() } else { Ok(()) }
    }

    /// Whether values may come from the second level.
    pub fn has_second_level(&self) -> bool {
        self.second.readable().is_some()
    }

    /// Hands a result to the second level, if that takes any.
    pub(super) fn hand_over(&mut self, n: usize, key: Digest, record: &Arc<RunRecord>, values: &[NewValue]) {
        let Some(remote) = self.second.remote.filter(|remote| remote.writes()) else { return };
        let (node, sources) = (&self.plan.nodes[n], &self.nodes[n].source_keys);
        let explain = || Arc::new(key::explain(node.kind.spec(), node.params.json(), sources));
        let fields = self.second.fields.entry(self.nodes[n].fixed).or_insert_with(explain).clone();
        remote.store(Outgoing { key, record: record.clone(), values: values.to_vec(), fields });
    }
}
