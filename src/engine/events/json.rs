//! Events as JSON, one object a line, for programs.

use super::{Event, Events, outcome_text};
use serde_json::{Value, json};
use std::{cell::RefCell, io::Write};

/// Writes to `W`.
pub struct JsonLines<W>(RefCell<W>);

impl<W: Write> JsonLines<W> {
    pub fn new(out: W) -> Self {
        Self(RefCell::new(out))
    }
}

impl<W: Write> Events for JsonLines<W> {
    fn event(&self, event: &Event) {
        // A closed pipe must not end the bake.
        let _ = writeln!(self.0.borrow_mut(), "{}", object(event));
    }
}

fn object(event: &Event) -> Value {
    match event {
        Event::Started { nodes } => json!({ "event": "started", "nodes": nodes }),
        Event::NodeStarted { node, elements, hits } => {
            json!({ "event": "node_started", "node": node, "elements": elements, "hits": hits })
        }
        Event::Progress { node, done, hits, left } => {
            json!({ "event": "progress", "node": node, "done": done, "hits": hits, "left": left })
        }
        Event::NodeFinished { node, hits, runs, failed, skipped, seconds } => json!({
            "event": "node_finished", "node": node, "hits": hits, "runs": runs, "failed": failed,
            "skipped": skipped, "seconds": seconds,
        }),
        Event::Warning { node, element, text } => {
            json!({ "event": "warning", "node": node, "element": element, "text": text })
        }
        Event::Failed { node, element, error } => {
            json!({ "event": "failed", "node": node, "element": element, "error": error })
        }
        Event::Published { path, bytes } => json!({ "event": "published", "path": path, "bytes": bytes }),
        Event::NotMet { node, text } => json!({ "event": "not_met", "node": node, "text": text }),
        Event::Finished { outcome, hits, runs, seconds } => json!({
            "event": "finished", "outcome": outcome_text(*outcome), "hits": hits, "runs": runs, "seconds": seconds,
        }),
    }
}
