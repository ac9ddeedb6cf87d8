//! The command line. Exit codes: 0 done, 1 a node (or the cache) failed, 2 the pipeline file or an argument is wrong,
//! 3 the certificate was not met, 130 interrupted.

mod backend;
mod bake;
mod batch;
mod cache;
mod check;
mod compare;
mod completions;
mod devices;
mod events;
mod folders;
mod graph;
mod init;
mod interrupt;
mod man;
mod nodes;
mod pipeline;
mod quantity;
mod report;
mod scene;
mod schema;
pub mod stock;
mod summary;
mod terminal;
mod verdict;
#[cfg(feature = "watch")]
mod watch;
mod why;

use crate::engine::registry::Registry;
use clap::{
    Parser, Subcommand,
    error::{ContextKind, ContextValue, ErrorKind},
};
use std::{
    ffi::{OsStr, OsString},
    process::ExitCode,
};

/// Bakes heavy 3D scenes into image-based stand-ins, certified against the original.
///
/// A TOML file describes a graph of nodes; what did not change since the last bake is taken from the cache.
#[derive(Parser)]
#[command(
    name = "farfield",
    version,
    arg_required_else_help = true,
    max_term_width = 100,
    after_help = "Exit codes: 0 done, 1 a node failed, 2 the pipeline file or an argument is wrong, 3 the certificate was not \
                  met, 130 interrupted."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Bake(bake::Args),
    #[cfg(feature = "watch")]
    Watch(watch::Args),
    Init(init::Args),
    Check(check::Args),
    Compare(compare::Args),
    Devices(devices::Args),
    Graph(graph::Args),
    Nodes(nodes::Args),
    Why(why::Args),
    Cache(cache::Args),
    Completions(completions::Args),
    Man(man::Args),
}

/// How a command ended, when it did not end well. What there is to say has been said.
struct Exit(u8);

type Done = Result<(), Exit>;

impl Exit {
    /// The error on standard error, in the form that clap's have.
    fn say(code: u8, error: impl std::fmt::Display) -> Self {
        use std::io::IsTerminal;
        let colour = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty());
        if colour {
            terminal::say(format_args!("\x1b[1;31merror:\x1b[0m {error}"));
        } else {
            terminal::say(format_args!("error: {error}"));
        }
        Self(code)
    }
}

impl From<crate::engine::error::EngineError> for Exit {
    fn from(error: crate::engine::error::EngineError) -> Self {
        Self::say(error.exit_code(), error)
    }
}

/// Writes a command's result to standard output; a reader that has left is no failure.
fn print(text: &str) -> Done {
    use std::io::Write;
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Exit::say(1, format!("cannot write: {e}"))),
        _ => Ok(()),
    }
}

/// After `bake --resolution 512`: how a knob is set.
fn knob_hint(arguments: &[OsString], e: &clap::Error) -> Option<String> {
    let takes = ["bake", "watch", "check", "graph", "why"].map(OsStr::new);
    if !takes.contains(&arguments.get(1)?.as_os_str()) {
        return None;
    }
    let Some(ContextValue::String(wrong)) = e.get(ContextKind::InvalidArg) else { return None };
    let name = wrong.strip_prefix("--")?.split(['=', ' ']).next()?;
    let is_it = |a: &&OsString| a.to_str().and_then(|a| a.strip_prefix("--")?.split('=').next()) == Some(name);
    let given = arguments.iter().position(|a| is_it(&a))?;
    let inline = arguments[given].to_str()?.split_once('=').map(|(_, value)| value.to_owned());
    let next = || arguments.get(given + 1)?.to_str().filter(|v| !v.starts_with('-')).map(str::to_owned);
    let value = inline.or_else(next).unwrap_or_else(|| "…".to_owned());
    let name = name.replace('-', "_");
    Some(format!("\nA pipeline's knobs and its nodes' parameters are set with --set: --set {name}={value}"))
}

/// Runs the command that the program's arguments name.
pub fn main() -> ExitCode {
    quiet_drivers();
    run(std::env::args_os(), &crate::nodes::registry())
}

/// Mesa's choice of a device asks the window system, whose client prints an error where `XDG_RUNTIME_DIR` is not set, as on build
/// machines. It finds no window system in a folder of temporary files either, but says nothing.
#[cfg(target_os = "linux")]
#[expect(unsafe_code, reason = "the environment is changed before the first thread starts")]
fn quiet_drivers() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: the program's only thread reads no environment at this time.
        unsafe { std::env::set_var("XDG_RUNTIME_DIR", std::env::temp_dir()) };
    }
}

#[cfg(not(target_os = "linux"))]
fn quiet_drivers() {}

/// Runs a command with the kinds of `registry`; the first argument is the program's name. Benchmarks bring trivial kinds.
pub fn run(arguments: impl Iterator<Item = OsString>, registry: &Registry) -> ExitCode {
    let arguments: Vec<OsString> = arguments.collect();
    let cli = Cli::try_parse_from(&arguments).unwrap_or_else(|e| {
        if e.kind() == ErrorKind::UnknownArgument
            && let Some(hint) = knob_hint(&arguments, &e)
        {
            // Where standard error is closed there is nobody to tell.
            let _ = e.print();
            terminal::say(hint);
            std::process::exit(2);
        }
        e.exit()
    });
    let done = match cli.command {
        Command::Bake(args) => batch::bake(&args, registry),
        #[cfg(feature = "watch")]
        Command::Watch(args) => watch::run(&args, registry),
        Command::Init(args) => init::run(&args, registry),
        Command::Check(args) => check::run(&args, registry),
        Command::Compare(args) => compare::run(&args),
        Command::Devices(args) => devices::run(&args),
        Command::Graph(args) => graph::run(&args, registry),
        Command::Nodes(args) => nodes::run(&args, registry),
        Command::Why(args) => why::run(&args, registry),
        Command::Cache(args) => cache::run(&args),
        Command::Completions(args) => completions::run(&args),
        Command::Man(args) => man::run(&args),
    };
    done.map_or_else(|Exit(code)| ExitCode::from(code), |()| ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn arguments_are_sound() {
        super::Cli::command().debug_assert();
    }
}
