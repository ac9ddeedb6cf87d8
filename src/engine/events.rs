//! What a bake tells while it works. How it is shown is the command line's matter.

use super::{
    remote::Traffic,
    report::{Audit, Outcome},
};

/// Something that the user may want to see.
#[derive(Clone, Debug)]
pub enum Event<'a> {
    /// The bake begins with this many nodes.
    Started {
        nodes: usize,
    },
    /// A node begins to work: `elements` as far as they are known, `hits` of them already in the cache. More may come to
    /// be known while nodes above it still work.
    NodeStarted {
        node: &'a str,
        elements: u64,
        hits: u64,
    },
    /// `done` of the node's elements are finished (hits among them), `left` of those that are known are not.
    Progress {
        node: &'a str,
        done: u64,
        hits: u64,
        left: u64,
    },
    /// A run is on its way: `done` of its `total` steps. `element` is absent where the node is not mapped.
    Step {
        node: &'a str,
        element: Option<&'a str>,
        done: u64,
        total: u64,
    },
    /// All elements of the node are settled. A node that is a hit as a whole has only this event.
    NodeFinished {
        node: &'a str,
        hits: u64,
        runs: u64,
        failed: u64,
        skipped: u64,
        seconds: f64,
    },
    /// `node` is absent where the cache or the output folder is meant.
    Warning {
        node: Option<&'a str>,
        element: Option<&'a str>,
        text: &'a str,
    },
    /// The bake has waited for a second for what another process holds; told once for each holder.
    Waiting {
        what: &'a str,
        /// `process 123 on host`.
        holder: &'a str,
    },
    Failed {
        node: &'a str,
        element: Option<&'a str>,
        error: &'a str,
    },
    /// A file was written below the output folder.
    Published {
        path: &'a str,
        bytes: u64,
    },
    /// A bound of `[require]` was missed.
    NotMet {
        node: &'a str,
        text: &'a str,
    },
    /// What the second level of the cache gave and took; before the end of the bake.
    Remote {
        traffic: Traffic,
    },
    /// What an audit found; before the end of the bake.
    Audited {
        audit: &'a Audit,
    },
    /// The bake is over.
    Finished {
        outcome: Outcome,
        hits: u64,
        runs: u64,
        seconds: f64,
    },
}

/// Receives events. Calls come from the scheduler's thread only.
pub trait Events {
    fn event(&self, event: &Event);
}

/// Tells nobody.
pub struct Silent;

impl Events for Silent {
    fn event(&self, _: &Event) {}
}
