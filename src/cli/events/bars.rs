//! A bar per node that works, with elements done, cached and left, and an estimate of the time left.

use super::plain;
use crate::{
    cli::terminal::{fill, say},
    engine::events::{Event, Events},
};
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use std::{cell::RefCell, collections::BTreeMap, time::Duration};

#[derive(Default)]
pub struct Bars {
    all: MultiProgress,
    nodes: RefCell<BTreeMap<String, ProgressBar>>,
}

/// What a node's bar counts; a long line would break where the terminal ends, so the bar takes what is left.
fn style(counted: bool) -> ProgressStyle {
    let template = if counted {
        "{prefix:>12!} {wide_bar} {pos}/{len} {msg}, {eta} left"
    } else {
        "{prefix:>12!} {spinner} {elapsed}"
    };
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

impl Events for Bars {
    fn event(&self, event: &Event) {
        let mut nodes = self.nodes.borrow_mut();
        match *event {
            Event::NodeStarted { node, elements, hits } => {
                let bar = self
                    .all
                    .add(ProgressBar::new(elements).with_style(style(elements > 1)).with_prefix(node.to_owned()));
                bar.set_position(hits);
                bar.set_message(format!("({hits} cached)"));
                bar.enable_steady_tick(Duration::from_millis(200));
                nodes.insert(node.to_owned(), bar);
            }
            Event::Progress { node, done, hits, left } => {
                if let Some(bar) = nodes.get(node) {
                    // Elements come to be known while the node works.
                    if done + left > bar.length().unwrap_or(0) {
                        bar.set_length(done + left);
                        bar.set_style(style(done + left > 1));
                    }
                    bar.set_position(done);
                    bar.set_message(format!("({hits} cached)"));
                }
            }
            Event::Step { node, element, done, total } => {
                let Some(bar) = nodes.get(node) else { return };
                match element {
                    // Of many elements the bar counts those that are finished.
                    Some(_) if bar.length().is_some_and(|elements| elements > 1) => {
                        bar.set_message(format!("({} % of one)", done * 100 / total.max(1)));
                    }
                    _ => {
                        bar.set_style(style(true));
                        bar.set_length(total);
                        bar.set_position(done);
                        bar.set_message("steps");
                    }
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
            self.all.suspend(|| say(fill(&line)));
        }
    }
}
