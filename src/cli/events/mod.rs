//! What a bake tells while it works, for people at a terminal, for logs and for programs. All of it goes to standard
//! error, except JSON, which is a command's result and goes to standard output.

mod bars;
mod json;
mod plain;

use crate::engine::events::Events;
use std::io::IsTerminal;

/// How progress is reported.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum Style {
    /// A line per node
    Plain,
    /// A JSON object per line, on standard output
    Json,
    /// A bar per node, with elements done, cached and left
    Bars,
}

impl Style {
    pub fn of_terminal() -> Self {
        if std::io::stderr().is_terminal() { Self::Bars } else { Self::Plain }
    }
}

pub fn receiver(style: Style) -> Box<dyn Events> {
    match style {
        Style::Plain => Box::new(plain::Plain::new()),
        Style::Json => Box::new(json::Json),
        Style::Bars => Box::new(bars::Bars::default()),
    }
}
