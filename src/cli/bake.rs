//! `farfield bake`.

use super::{
    Done, Exit,
    backend::BackendArgs,
    events::{self, Style},
    folders::CacheArg,
    interrupt,
    pipeline::PipelineArgs,
    print,
    quantity::{bytes, share},
    summary::summary,
};
use crate::engine::{
    bake::{self, Forecast, Options, Outcome, Report},
    plan::Plan,
    registry::Registry,
};
use std::path::PathBuf;

/// Bakes a pipeline; takes from the cache what did not change
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    pipeline: PipelineArgs,
    /// Say what would run (`hit`, `runs`, `may run`); run nothing, write nothing
    #[arg(long)]
    dry_run: bool,
    /// Replace files in the output folder that farfield did not write. Files that the bake reads are never replaced
    #[arg(long)]
    overwrite: bool,
    /// Only this node and what it needs; nothing is published then. May be given several times
    #[arg(long, value_name = "NODE")]
    only: Vec<String>,
    /// Run this node although the cache holds its result. May be given several times
    #[arg(long, value_name = "NODE")]
    force: Vec<String>,
    /// Tasks and threads at a time [default: as many as the machine has]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    jobs: Option<u64>,
    /// Memory that running tasks may use together: 4GiB [default: three quarters of the machine's]
    #[arg(long, value_name = "SIZE", value_parser = bytes)]
    memory: Option<u64>,
    #[command(flatten)]
    backend: BackendArgs,
    #[command(flatten)]
    cache: CacheArg,
    /// The folder of the results; a pipeline writes to DIR/<its name>
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// After a failure, bake whatever does not depend on it
    #[arg(long)]
    keep_going: bool,
    /// Recompute this share of the hits and compare bytes: 5%
    #[arg(long, value_name = "SHARE", value_parser = share)]
    audit: Option<f64>,
    /// How progress is reported [default: bars on a terminal, else plain]
    #[arg(long, value_enum)]
    events: Option<Style>,
    /// Write a trace that chrome://tracing and Perfetto show
    #[arg(long, value_name = "FILE")]
    profile: Option<PathBuf>,
}

pub fn run(args: &Args, registry: &Registry) -> Done {
    let plan = args.pipeline.load(registry)?;
    let backend = args.backend.open()?;
    let options = Options {
        device: Some(backend.device()),
        jobs: args.jobs.map_or(0, |n| usize::try_from(n).unwrap_or(usize::MAX)),
        memory: args.memory.unwrap_or(0),
        only: known("--only", &args.only, &plan)?,
        force: known("--force", &args.force, &plan)?,
        keep_going: args.keep_going,
        dry_run: args.dry_run,
        overwrite: args.overwrite,
        audit: args.audit.unwrap_or(0.0),
        profile: args.profile.clone(),
        ..Options::new(args.cache.folder(), &args.out)
    };
    let style = args.events.unwrap_or_else(Style::of_terminal);
    let stop = interrupt::stop()?;
    let report = bake::bake(&plan, &options, &stop, &*events::receiver(style));
    backend.warn();
    let report = report?;
    if args.dry_run {
        print(&forecast(&report))?;
    } else if !matches!(style, Style::Json) {
        print(&summary(&plan, &report, args.only.is_empty()))?;
    }
    let outcome = report.outcome;
    // The process ends here: to free a large plan node by node would only take time.
    std::mem::forget((plan, report));
    match outcome {
        Outcome::Baked => Ok(()),
        outcome => Err(Exit(outcome.exit_code())),
    }
}

/// The names of nodes given to `option`; a wrong one is an error with the nearest.
fn known(option: &str, names: &[String], plan: &Plan) -> Result<Vec<String>, Exit> {
    let nodes = || plan.nodes.iter().map(|n| n.name.as_str());
    let part = |name: &str| nodes().any(|n| n.strip_prefix(name).is_some_and(|rest| rest.starts_with('/')));
    match names.iter().find(|name| !nodes().any(|n| n == **name) && !part(name)) {
        None => Ok(names.to_vec()),
        Some(wrong) => {
            let hint = crate::engine::pipeline::did_you_mean(wrong, nodes());
            let all = crate::engine::pipeline::name_list(nodes());
            Err(Exit::say(2, format!("{option} {wrong}: no such node; {hint}the nodes are {all}")))
        }
    }
}

/// A dry run, node by node.
fn forecast(report: &Report) -> String {
    let width = report.nodes.iter().map(|n| n.name.len()).max().unwrap_or(0);
    let word = |f: Option<Forecast>| match f {
        Some(Forecast::Hit) => "hit",
        Some(Forecast::Runs) => "runs",
        Some(Forecast::MayRun) => "may run",
        None => "unknown",
    };
    report.nodes.iter().map(|n| format!("{:width$}  {}\n", n.name, word(n.forecast))).collect()
}
