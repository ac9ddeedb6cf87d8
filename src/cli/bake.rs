//! `farfield bake`.

use super::{
    Done, Exit,
    backend::{BackendArgs, Chosen},
    events::{self, Style},
    folders::{CacheArg, RemoteArgs},
    interrupt,
    pipeline::PipelineArgs,
    print,
    quantity::{bytes, share},
    report,
    summary::summary,
};
use crate::{
    engine::{
        bake::{self, Forecast, Options, Outcome, Report},
        plan::Plan,
    },
    math::Stop,
};
use std::path::{Path, PathBuf};

/// Bakes a pipeline; takes from the cache what did not change
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub pipeline: PipelineArgs,
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
    pub backend: BackendArgs,
    #[command(flatten)]
    cache: CacheArg,
    #[command(flatten)]
    remote: RemoteArgs,
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
    /// Write no report.html beside the results
    #[arg(long)]
    no_report: bool,
    /// Of a pipeline with [batch] only this row. May be given several times
    #[arg(long, value_name = "NAME")]
    row: Vec<String>,
    /// Write a trace that chrome://tracing and Perfetto show
    #[arg(long, value_name = "FILE")]
    profile: Option<PathBuf>,
}

/// Bakes one plan.
pub fn run(args: &Args, plan: Plan, backend: &Chosen) -> Done {
    if let Some(row) = args.row.first() {
        return Err(Exit::say(2, format!("--row {row}: the pipeline has no [batch]")));
    }
    let options = args.options(&plan, backend)?;
    let stop = interrupt::stop()?;
    let report = args.bake(&plan, &options, backend, &stop)?;
    args.tell(&plan, &report)?;
    let outcome = report.outcome;
    // The process ends here: to free a large plan node by node would only take time.
    std::mem::forget((plan, report));
    match outcome {
        Outcome::Baked => Ok(()),
        outcome => Err(Exit(outcome.exit_code())),
    }
}

impl Args {
    /// How to bake `plan`.
    pub fn options(&self, plan: &Plan, backend: &Chosen) -> Result<Options, Exit> {
        Ok(Options {
            device: Some(backend.device()),
            remote: self.remote.options()?,
            jobs: self.jobs.map_or(0, |n| usize::try_from(n).unwrap_or(usize::MAX)),
            memory: self.memory.unwrap_or(0),
            only: known("--only", &self.only, plan)?,
            force: known("--force", &self.force, plan)?,
            keep_going: self.keep_going,
            dry_run: self.dry_run,
            overwrite: self.overwrite,
            audit: self.audit.unwrap_or(0.0),
            profile: self.profile.clone(),
            report: (!self.no_report).then_some(report::html as _),
            ..Options::new(self.cache.folder(), &self.out)
        })
    }

    /// The rows of a batch that are asked for; none: all.
    pub fn rows(&self) -> &[String] {
        &self.row
    }

    /// The folder of the results.
    pub fn out(&self) -> &Path {
        &self.out
    }

    pub fn overwrites(&self) -> bool {
        self.overwrite
    }

    pub fn traces(&self) -> bool {
        self.profile.is_some()
    }

    /// Whether results leave the cache.
    pub fn publishes(&self) -> bool {
        !self.dry_run && self.only.is_empty()
    }

    /// Whether people are told what happens.
    pub fn speaks(&self) -> bool {
        !matches!(self.style(), Style::Json)
    }

    fn style(&self) -> Style {
        self.events.unwrap_or_else(Style::of_terminal)
    }

    /// Bakes, and shows what happens meanwhile.
    pub fn bake(&self, plan: &Plan, options: &Options, backend: &Chosen, stop: &Stop) -> Result<Report, Exit> {
        let report = bake::bake(plan, options, stop, &*events::receiver(self.style()));
        backend.warn();
        Ok(report?)
    }

    /// Prints what came of it.
    pub fn tell(&self, plan: &Plan, report: &Report) -> Done {
        if self.dry_run {
            print(&forecast(report))
        } else if self.speaks() {
            print(&summary(plan, report, self.only.is_empty()))
        } else {
            Ok(())
        }
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
