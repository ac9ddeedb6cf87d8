//! Events on a terminal: one bar per node that has work, with elements done, cached and left, and an estimate.

use super::{Event, Events, lines};
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use std::{cell::RefCell, collections::BTreeMap};

/// Draws on standard error.
#[derive(Default)]
pub struct Bars {
    all: MultiProgress,
    nodes: RefCell<BTreeMap<String, ProgressBar>>,
}

impl Bars {
    pub fn new() -> Self {
        Self::default()
    }

    fn line(&self, event: &Event) {
        let mut text = Vec::new();
        if lines::write(&mut text, event).is_ok() {
            // A terminal that has gone must not end the bake.
            let _ = self.all.println(String::from_utf8_lossy(&text).trim_end());
        }
    }
}

impl Events for Bars {
    fn event(&self, event: &Event) {
        match event {
            Event::NodeStarted { node, elements, hits } => {
                let bar = self.all.add(ProgressBar::new(*elements));
                let style = ProgressStyle::with_template("{prefix:24!} {bar:30} {pos}/{len} {msg} {elapsed} (left {eta})");
                if let Ok(style) = style {
                    bar.set_style(style);
                }
                bar.set_prefix((*node).to_owned());
                bar.set_message(format!("{hits} cached"));
                bar.set_position(*hits);
                // Elements that were cached say nothing of the speed.
                bar.reset_eta();
                bar.enable_steady_tick(std::time::Duration::from_millis(200));
                self.nodes.borrow_mut().insert((*node).to_owned(), bar);
            }
            Event::Progress { node, done, hits, .. } => {
                if let Some(bar) = self.nodes.borrow().get(*node) {
                    bar.set_position(*done);
                    bar.set_message(format!("{hits} cached"));
                }
            }
            Event::NodeFinished { node, .. } => {
                if let Some(bar) = self.nodes.borrow_mut().remove(*node) {
                    bar.finish_and_clear();
                    self.line(event);
                }
            }
            Event::Started { .. } => {}
            _ => self.line(event),
        }
    }
}
