//! One line per node that ran, warning, failure and file.

use crate::{
    cli::{
        quantity::{show_bytes, show_seconds},
        terminal::{fill, say},
    },
    engine::{
        events::{Event, Events},
        report::Audit,
    },
};
use std::{
    cell::Cell,
    time::{Duration, Instant},
};

/// Between two lines that tell how far a run is.
const STEP_EVERY: Duration = Duration::from_secs(5);

pub struct Plain {
    /// When something was said last.
    said: Cell<Instant>,
}

impl Plain {
    pub fn new() -> Self {
        Self { said: Cell::new(Instant::now()) }
    }
}

impl Events for Plain {
    fn event(&self, event: &Event) {
        let step = match *event {
            Event::Step { node, element, done, total } if self.said.get().elapsed() >= STEP_EVERY => {
                Some(format!("{}{done} of {total}", place(Some(node), element)))
            }
            _ => None,
        };
        if let Some(line) = step.or_else(|| line(event)) {
            self.said.set(Instant::now());
            say(fill(&line));
        }
    }
}

/// Where something happened: `node`, `node/element`, or the bake itself.
fn place(node: Option<&str>, element: Option<&str>) -> String {
    match (node, element) {
        (Some(node), Some(element)) => format!("{node}/{element}: "),
        (Some(node), None) => format!("{node}: "),
        _ => String::new(),
    }
}

/// The result of an audit.
fn audited(audit: &Audit) -> String {
    let Audit { runs, different_runs, bytes, different_bytes } = *audit;
    match (runs, different_runs) {
        (0, _) => "audit: no hit was computed again".to_owned(),
        (_, 0) => format!("audit: {runs} hits computed again, all {} are the same", show_bytes(bytes)),
        _ => format!(
            "audit: {runs} hits computed again, {different_runs} of them gave other bytes; {different_bytes} of {bytes} bytes differ"
        ),
    }
}

/// The event as a line; hits and steps on the way are not worth one.
pub fn line(event: &Event) -> Option<String> {
    match *event {
        Event::NodeFinished { node, hits, runs, failed, skipped, seconds } if runs + failed + skipped > 0 => {
            let mut line = format!("{node}: {runs} ran");
            for (count, word) in [(hits, "hits"), (failed, "failed"), (skipped, "skipped")] {
                if count > 0 {
                    line += &format!(", {count} {word}");
                }
            }
            Some(format!("{line}, {}", show_seconds(seconds)))
        }
        Event::Warning { node, element, text } => Some(format!("warning: {}{text}", place(node, element))),
        Event::Waiting { what, holder } => Some(format!("waiting for {what}, which {holder} holds")),
        Event::Failed { node, element, error } => Some(format!("error: {}{error}", place(Some(node), element))),
        Event::Audited { audit } => Some(audited(audit)),
        Event::Published { path, bytes } => Some(format!("wrote {path}, {}", show_bytes(bytes))),
        _ => None,
    }
}
