//! The arguments that name a pipeline, and the reports of what is wrong with it.

use super::{Exit, stock::STOCK};
use crate::engine::{
    pipeline::{self, Problems, Request},
    plan::Plan,
    registry::Registry,
};
use miette::GraphicalTheme;
use std::io::IsTerminal;

#[derive(Clone, clap::Args)]
pub struct PipelineArgs {
    /// A pipeline file, or the name of a stock pipeline such as `tdm`
    #[arg(value_name = "FILE|NAME")]
    pub file: String,
    /// Gives a knob or a node's parameter another value: `--set resolution=512 --set collapse.factor=1.5`. Paths start
    /// from the working folder; text needs no quotes
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// A bound over those of `[require]`, or `off`: `--require evaluate.crack_px.total=off`, `…=..5` (at most),
    /// `…=30..` (at least), `…=1..2`; in quotes also `'…<=5'` and `'…>=30'`. `farfield nodes evaluate` lists the measures
    #[arg(long, value_name = "NODE.MEASURE=BOUND")]
    pub require: Vec<String>,
    /// Another name for the pipeline: results go to OUT/<NAME>, so that those of two scenes lie side by side
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// Lets scenes name files outside their own folder
    #[arg(long)]
    pub allow_outside: bool,
}

impl PipelineArgs {
    /// The same with more values, which take precedence.
    #[cfg(feature = "watch")]
    pub fn with(&self, more: &[String]) -> Self {
        Self { set: self.set.iter().chain(more).cloned().collect(), ..self.clone() }
    }

    /// The checked plan; what is wrong goes to standard error.
    pub fn load(&self, registry: &Registry) -> Result<Plan, Exit> {
        self.read(registry)?.map_err(|problems| report(&problems))
    }

    /// The checked plan of a batch's row; what is wrong goes to standard error.
    pub fn load_row(&self, row: usize, registry: &Registry) -> Result<Plan, Exit> {
        self.read_row(row, registry)?.map_err(|problems| report(&problems))
    }

    /// The checked plan of a batch's row, or what is wrong with it.
    pub fn read_row(&self, row: usize, registry: &Registry) -> Result<Result<Plan, Problems>, Exit> {
        self.resolve(Some(row), registry)
    }

    /// The checked plan, or what is wrong with it.
    pub fn read(&self, registry: &Registry) -> Result<Result<Plan, Problems>, Exit> {
        self.resolve(None, registry)
    }

    fn resolve(&self, row: Option<usize>, registry: &Registry) -> Result<Result<Plan, Problems>, Exit> {
        let folder = std::env::current_dir().map_err(|e| Exit::say(2, format!("no working folder: {e}")))?;
        let everywhere = [("allow_outside", serde_json::Value::Bool(true))];
        let request = Request {
            set: &self.set,
            require: &self.require,
            name: self.name.as_deref(),
            row,
            everywhere: if self.allow_outside { &everywhere } else { &[] },
            ..Request::new(&self.file, &folder, STOCK)
        };
        Ok(pipeline::load(&request, registry))
    }
}

/// Shows what is wrong on standard error.
pub fn report(problems: &Problems) -> Exit {
    let terminal = std::io::stderr().is_terminal();
    let colour = terminal && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty());
    let theme = if colour { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
    super::terminal::say(problems.render(theme, 110).trim_end_matches('\n'));
    let count = problems.list.len();
    Exit::say(2, format!("{count} mistake{} in the pipeline; nothing was run", if count == 1 { "" } else { "s" }))
}
