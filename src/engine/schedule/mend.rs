//! Values that a record names and that are not there: lost by the cache, or made by a transient node. Their producer runs
//! again for just those elements.

use super::{
    Gone, RunId, Schedule,
    state::{Cause, State, Waiter},
};
use crate::engine::{
    error::EngineError,
    hash::Digest,
    plan::OutputRef,
    value::{JOIN, shown},
};

/// A value lost more often than this within one bake is a broken disk, not an accident.
const LOSSES: u32 = 3;

impl Schedule<'_> {
    /// Has a value brought or made again that is not there; `waiter` goes on then. `row` is its name in the producer's list.
    pub(super) fn mend(
        &mut self,
        from: OutputRef,
        row: &str,
        hash: Digest,
        gone: &Gone,
        waiter: Waiter,
    ) -> Result<(), EngineError> {
        if self.asks_for(from, hash) {
            if let Gone::Lost(what) = gone {
                self.note_loss(from.node.0 as usize, row, hash, what)?;
            }
            self.bring(from, row, hash, gone, waiter);
            return Ok(());
        }
        self.make_again(from, row, hash, gone, waiter)
    }

    /// Has the producer of a value run again.
    pub(super) fn make_again(
        &mut self,
        from: OutputRef,
        row: &str,
        hash: Digest,
        gone: &Gone,
        waiter: Waiter,
    ) -> Result<(), EngineError> {
        let p = from.node.0 as usize;
        self.expand_known(p)?;
        let axes = self.plan.nodes[p].axes.len();
        let name = row.split(JOIN).take(axes).collect::<Vec<_>>().join(&JOIN.to_string());
        let lacks = || EngineError::Again(format!("{} no longer has the element {}", self.name(p), shown(&name)));
        let id = RunId { node: p, run: self.nodes[p].run_of(&name).ok_or_else(lacks)? };
        if let Waiter::Run(waiting, _) = waiter {
            self.run_mut(waiting).busy().missing += 1;
        }
        self.run_mut(id).busy().waiters.push(waiter);
        if !self.run_mut(id).state.is_settled() {
            return Ok(());
        }
        let cause = match gone {
            Gone::NotKept => Cause::Remade,
            Gone::Lost(what) => {
                self.note_loss(p, row, hash, what)?;
                Cause::Lost
            }
        };
        self.held.drop_value(&hash);
        let node = &mut self.nodes[p];
        // Runs that were read from the map of this bake count as what they were.
        match node.runs[id.run].state {
            State::Hit if node.hits > 0 => node.hits -= 1,
            State::Hit | State::Ran => node.ran -= 1,
            _ => {}
        }
        let run = &mut node.runs[id.run];
        (run.state, run.cause) = (State::Ready, cause);
        node.pending += 1;
        self.ready.push_urgent(id);
        Ok(())
    }

    /// Sets a lost value aside and warns of it once.
    fn note_loss(&mut self, p: usize, row: &str, hash: Digest, what: &str) -> Result<(), EngineError> {
        let losses = self.lost.entry(hash).or_default();
        *losses += 1;
        if *losses > LOSSES {
            // What was just stored is not found: the index leads elsewhere, though its structure may look sound.
            let what = format!("value {} is lost again and again: {what}", hash.short());
            return Err(EngineError::Damaged { path: self.cache.root().to_owned(), what });
        }
        if *losses == 1 {
            let text = format!("stored value {} is damaged ({what}); it is set aside and made again", hash.short());
            let element = shown(row);
            self.warn(Some(p), (!element.is_empty()).then_some(&element), &text);
        }
        self.cache.set_aside(&hash)
    }

    /// Has a lost value made again, and works until it is.
    pub fn remake(&mut self, from: OutputRef, row: &str, hash: Digest, gone: &Gone) -> Result<(), EngineError> {
        self.mend(from, row, hash, gone, Waiter::Outside)?;
        self.work()
    }
}
