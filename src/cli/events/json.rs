//! One JSON object per line: `event` names it, the other members are its fields.

use crate::engine::{
    events::{Event, Events},
    remote::Traffic,
    report::Outcome,
};
use serde_json::{Value, json};
use std::io::Write;

pub struct Json;

impl Events for Json {
    fn event(&self, event: &Event) {
        let mut out = std::io::stdout().lock();
        // A reader that has left does not stop the bake.
        drop(writeln!(out, "{}", value(event)).and_then(|()| out.flush()));
    }
}

fn value(event: &Event) -> Value {
    match *event {
        Event::Started { nodes } => json!({ "event": "started", "nodes": nodes }),
        Event::NodeStarted { node, elements, hits } => {
            json!({ "event": "node-started", "node": node, "elements": elements, "hits": hits })
        }
        Event::Progress { node, done, hits, left } => {
            json!({ "event": "progress", "node": node, "done": done, "hits": hits, "left": left })
        }
        Event::Step { node, element, done, total } => {
            json!({ "event": "step", "node": node, "element": element, "done": done, "total": total })
        }
        Event::NodeFinished { node, hits, runs, failed, skipped, seconds } => json!({
            "event": "node-finished", "node": node, "hits": hits, "runs": runs, "failed": failed, "skipped": skipped,
            "seconds": seconds
        }),
        Event::Warning { node, element, text } => {
            json!({ "event": "warning", "node": node, "element": element, "text": text })
        }
        Event::Waiting { what, holder } => json!({ "event": "waiting", "what": what, "holder": holder }),
        Event::Failed { node, element, error } => {
            json!({ "event": "failed", "node": node, "element": element, "error": error })
        }
        Event::Published { path, bytes } => json!({ "event": "published", "path": path, "bytes": bytes }),
        Event::NotMet { node, text } => json!({ "event": "not-met", "node": node, "text": text }),
        Event::Remote { traffic: Traffic { fetched, fetched_bytes, stored, stored_bytes } } => json!({
            "event": "remote", "fetched": fetched, "fetched_bytes": fetched_bytes, "stored": stored,
            "stored_bytes": stored_bytes
        }),
        Event::Audited { audit } => json!({
            "event": "audited", "runs": audit.runs, "different_runs": audit.different_runs, "bytes": audit.bytes,
            "different_bytes": audit.different_bytes
        }),
        Event::Finished { outcome, hits, runs, seconds } => json!({
            "event": "finished", "outcome": outcome_name(outcome), "hits": hits, "runs": runs, "seconds": seconds
        }),
    }
}

fn outcome_name(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Baked => "baked",
        Outcome::Failed => "failed",
        Outcome::NotMet => "not-met",
        Outcome::Interrupted => "interrupted",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_event_has_a_name_and_its_fields() {
        let event = Event::Progress { node: "collapse", done: 3, hits: 1, left: 4 };
        let expect = r#"{"done":3,"event":"progress","hits":1,"left":4,"node":"collapse"}"#;
        assert_eq!(value(&event).to_string(), expect);
        let event = Event::Finished { outcome: Outcome::NotMet, hits: 0, runs: 2, seconds: 0.5 };
        assert_eq!(value(&event)["outcome"], "not-met");
    }
}
