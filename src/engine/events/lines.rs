//! Events as plain lines, for outputs that are no terminal: what ran, warnings, failures, and a summary.

use super::{Event, Events, outcome_text};
use std::{
    cell::RefCell,
    io::{self, Write},
};

/// Writes to `W`. A node that is a hit as a whole is not mentioned.
pub struct Lines<W>(RefCell<W>);

impl<W: Write> Lines<W> {
    pub fn new(out: W) -> Self {
        Self(RefCell::new(out))
    }
}

impl<W: Write> Events for Lines<W> {
    fn event(&self, event: &Event) {
        // A closed pipe must not end the bake.
        let _ = write(&mut *self.0.borrow_mut(), event);
    }
}

/// `node` or `node/element`.
pub(super) fn place(node: &str, element: Option<&str>) -> String {
    element.map_or_else(|| node.to_owned(), |e| format!("{node}/{e}"))
}

pub(super) fn write(out: &mut impl Write, event: &Event) -> io::Result<()> {
    match event {
        Event::Started { .. } | Event::Progress { .. } => Ok(()),
        Event::NodeStarted { node, elements, hits } if *elements > 1 => {
            writeln!(out, "{node}: {elements} elements, {hits} cached, {} to bake", elements - hits)
        }
        Event::NodeStarted { node, .. } => writeln!(out, "{node}: baking"),
        Event::NodeFinished { node, runs, failed, skipped, seconds, .. } => {
            if runs + failed > 0 {
                writeln!(out, "{node}: {runs} baked, {failed} failed, {skipped} skipped in {seconds:.2} s")?;
            }
            Ok(())
        }
        Event::Warning { node, element, text } => match node {
            Some(node) => writeln!(out, "warning: {}: {text}", place(node, *element)),
            None => writeln!(out, "warning: {text}"),
        },
        Event::Failed { node, element, error } => writeln!(out, "error: {}: {error}", place(node, *element)),
        Event::Published { path, bytes } => writeln!(out, "wrote {path} ({bytes} bytes)"),
        Event::NotMet { node, text } => writeln!(out, "not met: {node}: {text}"),
        Event::Finished { outcome, hits, runs, seconds } => {
            let text = outcome_text(*outcome);
            writeln!(out, "{text}: {runs} baked, {hits} cached in {seconds:.3} s")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_name_places_and_units() {
        let check = |event: Event, expect: &str| {
            let mut out = Vec::new();
            write(&mut out, &event).unwrap();
            assert_eq!(String::from_utf8(out).unwrap(), expect);
        };
        check(Event::Failed { node: "a/b", element: Some("c"), error: "odd" }, "error: a/b/c: odd\n");
        check(Event::NodeStarted { node: "m", elements: 5, hits: 2 }, "m: 5 elements, 2 cached, 3 to bake\n");
        let hit = Event::NodeFinished { node: "m", hits: 9, runs: 0, failed: 0, skipped: 0, seconds: 0.0 };
        check(hit, "");
        check(Event::Warning { node: None, element: None, text: "t" }, "warning: t\n");
    }
}
