//! Baking a plan: what to bake with, what came of it.

use super::{
    attempt::Attempt,
    cache,
    error::EngineError,
    events::{Event, Events},
    memory,
    node::Device,
    pipeline::{elide, nearest},
    plan::Plan,
    profile::Profile,
    publish::names,
    schedule::{Audit, Pool, Trust},
};
use crate::math::Stop;
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// How to bake. None of these may change the bytes that come out.
#[derive(Clone, Debug)]
pub struct Options {
    /// The cache folder; made where it is missing.
    pub cache: PathBuf,
    /// The folder above `<pipeline>/`.
    pub out: PathBuf,
    /// Tasks and threads at a time; 0: as many as the machine has.
    pub jobs: usize,
    /// Bytes that running tasks may use together, as estimated by their kinds; 0: three quarters of the machine's memory.
    pub memory: u64,
    /// Only these nodes and what they need; empty: all. Nothing is published then. A prefix `part` names all of `part/…`.
    pub only: Vec<String>,
    /// These nodes run although the cache holds their results.
    pub force: Vec<String>,
    /// After a failure, bake whatever does not depend on it.
    pub keep_going: bool,
    /// Say what would run; run nothing, write nothing.
    pub dry_run: bool,
    /// Replace files below the output folder that no bake has published, unless this bake reads them.
    pub overwrite: bool,
    /// Share of the hits, 0 to 1, that are recomputed and compared.
    pub audit: f64,
    /// Where to write a Chrome trace.
    pub profile: Option<PathBuf>,
    /// What kinds are given to compute on ([`super::node::Ctx::device`]).
    pub device: Option<Arc<Device>>,
}

impl Options {
    pub fn new(cache: impl Into<PathBuf>, out: impl Into<PathBuf>) -> Self {
        Self {
            // `create_dir_all` cannot make `new/.`; the components of it are those of `new`.
            cache: cache.into().components().collect(),
            out: out.into().components().collect(),
            jobs: 0,
            memory: 0,
            only: Vec::new(),
            force: Vec::new(),
            keep_going: false,
            dry_run: false,
            overwrite: false,
            audit: 0.0,
            profile: None,
            device: None,
        }
    }
}

/// How a bake ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    Baked,
    /// A node failed; nothing was published.
    Failed,
    /// A bound of `[require]` was missed; the result lies in `rejected/`.
    NotMet,
    Interrupted,
}

impl Outcome {
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Baked => 0,
            Self::Failed => 1,
            Self::NotMet => 3,
            Self::Interrupted => 130,
        }
    }
}

/// What a dry run says of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Forecast {
    Hit,
    /// At least one element has to run.
    Runs,
    /// Something above it runs; whether it runs too depends on what comes out there.
    MayRun,
}

/// What became of one node.
#[derive(Clone, Debug)]
pub struct NodeReport {
    pub name: String,
    pub kind: &'static str,
    /// Empty where the kind has no methods.
    pub method: &'static str,
    /// Elements taken from the cache. A node that is not mapped counts as one element.
    pub hits: u64,
    /// Elements that ran to the end.
    pub runs: u64,
    pub failed: u64,
    /// Elements that could not run because something that they need failed.
    pub skipped: u64,
    /// Summed over the runs.
    pub seconds: f64,
    /// Only in a dry run.
    pub forecast: Option<Forecast>,
}

/// A failed element and its cause.
#[derive(Clone, Debug)]
pub struct Failure {
    pub node: String,
    pub element: Option<String>,
    pub message: String,
}

/// A missed bound of `[require]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Unmet {
    pub node: String,
    /// Path into the certificate.
    pub path: String,
    /// What stands there; absent where the path leads to no number.
    pub measured: Option<f64>,
    pub min: Option<f64>,
    pub max: Option<f64>,
    /// What the measure means and its unit, as its kind says; empty where it does not.
    pub about: String,
    pub unit: String,
    /// The published picture that shows it.
    pub picture: Option<PathBuf>,
    /// The argument with which the bake takes it as it is.
    pub accept: String,
}

/// What came of a bake.
#[derive(Clone, Debug)]
pub struct Report {
    pub outcome: Outcome,
    /// In the order of the plan; only the nodes that were asked for.
    pub nodes: Vec<NodeReport>,
    pub errors: Vec<Failure>,
    pub unmet: Vec<Unmet>,
    pub warnings: usize,
    /// Files written in this bake, below `folder`.
    pub published: Vec<String>,
    /// What came of [`Options::audit`]; `None` where none was asked for.
    pub audit: Option<Audit>,
    /// `out/<pipeline>`, or its `rejected/` where a bound was missed.
    pub folder: PathBuf,
    /// Where a bound was missed: when the results were published that `out/<pipeline>` still holds.
    pub accepted: Option<std::time::SystemTime>,
    /// Wall clock.
    pub seconds: f64,
    /// Highest resident memory of the process in bytes, where the system tells.
    pub peak_memory: Option<u64>,
}

impl Report {
    pub fn hits(&self) -> u64 {
        self.nodes.iter().map(|n| n.hits).sum()
    }
    pub fn runs(&self) -> u64 {
        self.nodes.iter().map(|n| n.runs).sum()
    }
}

/// Bakes `plan`. Failures of nodes stand in the report; an error means that the engine itself could not go on.
pub fn bake(plan: &Plan, options: &Options, stop: &Stop, events: &dyn Events) -> Result<Report, EngineError> {
    let wanted = select(plan, &options.only)?;
    let forced = named(plan, &options.force)?.into_iter().collect();
    check_files(plan, &options.out)?;
    let have = std::thread::available_parallelism().map_or(1, usize::from);
    let (threads, notice) = threads(options.jobs, have);
    let mut attempt = Attempt {
        plan,
        options,
        stop,
        events,
        wanted,
        forced,
        pool: Pool::new(threads),
        jobs: threads,
        memory: if options.memory == 0 { memory::available() / 4 * 3 } else { options.memory },
        trust: Trust::Nodes,
        blank: false,
        profile: Profile::new(options.profile.is_some()),
        warnings: 0,
    };
    events.event(&Event::Started { nodes: attempt.wanted.iter().filter(|w| **w).count() });
    notice.iter().chain(&plan.doubts).for_each(|text| attempt.warn(text));
    let (mut again, mut damaged) = (0, 0);
    let report = loop {
        match attempt.run() {
            Err(EngineError::Damaged { what, .. }) if options.dry_run && !attempt.blank => {
                let text = format!("the cache's index is damaged ({what}); the next bake sets it aside");
                attempt.warn(&text);
                attempt.blank = true;
            }
            Err(EngineError::Damaged { what, .. }) if damaged < ATTEMPTS => {
                damaged += 1;
                // Another process may have set it aside. What is met again is there, though the check does not see it.
                cache::set_index_aside(&options.cache, damaged > 1)?;
                let text = format!("the cache's index is damaged ({what}); it is set aside and the bake begins again");
                attempt.warn(&text);
            }
            Err(EngineError::Again(what)) if again < ATTEMPTS => {
                again += 1;
                attempt.warn(&format!("{what}; the bake begins again, with what is finished"));
                attempt.trust = Trust::Runs;
            }
            other => break other?,
        }
    };
    if let Some(path) = &options.profile {
        let fail = |e| EngineError::File { path: path.clone(), what: format!("the profile cannot be written: {e}") };
        attempt.profile.write(path).map_err(fail)?;
    }
    if let Some(audit) = &report.audit {
        events.event(&Event::Audited { audit });
    }
    let (hits, runs) = (report.hits(), report.runs());
    events.event(&Event::Finished { outcome: report.outcome, hits, runs, seconds: report.seconds });
    Ok(report)
}

/// How often a bake begins anew, for each of two reasons, before it gives up.
const ATTEMPTS: u32 = 3;

/// The nodes that `names` name: each a node, or a part whose nodes are `name/…`.
fn named(plan: &Plan, names: &[String]) -> Result<Vec<usize>, EngineError> {
    let mut out = Vec::new();
    for name in names {
        let inside =
            |node: &str| node.strip_prefix(name.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'));
        let found = (0..plan.nodes.len()).filter(|i| inside(&plan.nodes[*i].name));
        let before = out.len();
        out.extend(found);
        if out.len() == before {
            return Err(unknown(plan, name));
        }
    }
    Ok(out)
}

/// The error for a node that is not there, with the nearest name that is.
pub(super) fn unknown(plan: &Plan, name: &str) -> EngineError {
    let near = nearest(name, plan.nodes.iter().map(|n| n.name.as_str())).map(str::to_owned);
    EngineError::UnknownNode { name: elide(name, 80), near }
}

/// Which nodes `only` asks for: those named and what they need.
fn select(plan: &Plan, only: &[String]) -> Result<Vec<bool>, EngineError> {
    let mut wanted = vec![only.is_empty(); plan.nodes.len()];
    for n in named(plan, only)? {
        wanted[n] = true;
    }
    // Every node follows what it reads.
    for n in (0..plan.nodes.len()).rev().filter(|_| !only.is_empty()) {
        if wanted[n] {
            for from in plan.nodes[n].inputs.iter().flat_map(|i| [i.from, i.via]).flatten() {
                wanted[from.node.0 as usize] = true;
            }
        }
    }
    Ok(wanted)
}

/// Names that can be refused before anything runs.
fn check_files(plan: &Plan, out: &Path) -> Result<(), EngineError> {
    if let Some(what) = names::bad_component(&plan.name) {
        return Err(EngineError::publish(&out.join(&plan.name), format!("the pipeline's name {what}")));
    }
    for file in &plan.files {
        let path = file.path.replace("{name}", "name");
        let path = if file.folder().is_some() { path.trim_end_matches('/') } else { &path };
        if let Some(what) = names::bad_path(path).filter(|_| file.folder() != Some("")) {
            return Err(EngineError::publish(Path::new(&file.path), what));
        }
    }
    // What a bundle holds is known when it is there.
    let paths = plan.files.iter().filter(|f| f.folder().is_none()).map(|f| f.path.as_str());
    match names::collision(paths) {
        Some((a, b)) => {
            let (a, b) = names::told_apart(a, b);
            Err(EngineError::publish(Path::new(&*b), format!("it collides with `{a}`")))
        }
        None => Ok(()),
    }
}

/// Threads for so many jobs on a machine that has `have`; beyond what can help, fewer than asked and a notice.
fn threads(jobs: usize, have: usize) -> (usize, Option<String>) {
    let most = MOST_JOBS.max(have * 4);
    match jobs {
        0 => (have, None),
        n if n > most => (most, Some(format!("--jobs {n} is more than can help: {most} are used"))),
        n => (n, None),
    }
}

/// Jobs that are always allowed; beyond, four for each that the machine runs at a time.
const MOST_JOBS: usize = 256;

/// After a missed bound: what the output folder holds, and where the rejected results are.
pub fn kept(plan: &Plan, report: &Report) -> String {
    let main = report.folder.parent().unwrap_or(&report.folder).display();
    let rejected = report.folder.display();
    match report.accepted {
        Some(at) => format!(
            "{main} still holds the results of the last accepted bake of {}, of {}; the rejected ones are in {rejected}",
            plan.name,
            super::deliver::day(at)
        ),
        None => {
            format!("no bake of {} into {main} was accepted yet; the rejected results are in {rejected}", plan.name)
        }
    }
}

/// Highest resident memory of this process so far, in bytes.
pub fn peak_memory() -> Option<u64> {
    memory::proc_kib("/proc/self/status", "VmHWM:")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jobs_are_bounded() {
        assert_eq!(threads(0, 2), (2, None));
        assert_eq!(threads(256, 2), (256, None));
        let (n, notice) = threads(60_000, 2);
        assert!(n == 256 && notice.unwrap().contains("--jobs 60000"));
        assert_eq!(threads(400, 128), (400, None));
    }
}
