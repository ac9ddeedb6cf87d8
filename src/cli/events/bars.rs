//! A bar per node that works, with elements done, cached and left, and an estimate of the time left.

use super::plain;
use crate::engine::events::{Event, Events};
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use std::{cell::RefCell, collections::BTreeMap, time::Duration};

#[derive(Default)]
pub struct Bars {
    all: MultiProgress,
    nodes: RefCell<BTreeMap<String, ProgressBar>>,
}

fn style(elements: u64) -> ProgressStyle {
    let template = if elements > 1 {
        "{prefix:>16} {bar:30} {pos}/{len} {msg}, {eta} left"
    } else {
        "{prefix:>16} {spinner} {elapsed}"
    };
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

impl Events for Bars {
    fn event(&self, event: &Event) {
        let mut nodes = self.nodes.borrow_mut();
        match *event {
            Event::NodeStarted { node, elements, hits } => {
                let bar =
                    self.all.add(ProgressBar::new(elements).with_style(style(elements)).with_prefix(node.to_owned()));
                bar.set_position(hits);
                bar.set_message(format!("({hits} cached)"));
                bar.enable_steady_tick(Duration::from_millis(200));
                nodes.insert(node.to_owned(), bar);
            }
            Event::Progress { node, done, hits, .. } => {
                if let Some(bar) = nodes.get(node) {
                    bar.set_position(done);
                    bar.set_message(format!("({hits} cached)"));
                }
            }
            Event::NodeFinished { node, .. } => {
                if let Some(bar) = nodes.remove(node) {
                    bar.finish_and_clear();
                }
            }
            Event::Finished { .. } => {
                while let Some((_, bar)) = nodes.pop_first() {
                    bar.finish_and_clear();
                }
            }
            _ => {}
        }
        drop(nodes);
        if let Some(line) = plain::line(event) {
            // Above the bars; `println` would be silent where there is no terminal.
            self.all.suspend(|| eprintln!("{line}"));
        }
    }
}
