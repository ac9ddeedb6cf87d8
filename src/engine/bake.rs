//! Baking a plan: from its checks to the report.

pub use super::{
    memory::peak as peak_memory,
    options::Options,
    report::{Failure, Forecast, NodeReport, Outcome, Report, Unmet},
};

use super::{
    attempt::Attempt,
    cache::{self, blob::Blobs},
    error::EngineError,
    events::{Event, Events},
    memory,
    plan::Plan,
    profile::Profile,
    publish::names,
    remote::{Remote, RemoteOptions, Traffic},
    schedule::{Pool, Trust},
};
use crate::math::Stop;
use std::path::Path;

/// Bakes `plan`. Failures of nodes stand in the report; an error means that the engine itself could not go on.
pub fn bake(plan: &Plan, options: &Options, stop: &Stop, events: &dyn Events) -> Result<Report, EngineError> {
    let wanted = select(plan, &options.only)?;
    let forced = named(plan, &options.force)?.into_iter().collect();
    check_files(plan, &options.out)?;
    let have = std::thread::available_parallelism().map_or(1, usize::from);
    let (threads, notice) = threads(options.jobs, have);
    let open = |remote: &RemoteOptions| Remote::open(remote, Blobs::new(&options.cache));
    // A dry run asks nobody, but a wrong address is told.
    let remote = options.remote.as_ref().map(open).transpose()?.filter(|_| !options.dry_run);
    let mut attempt = Attempt {
        plan,
        options,
        stop,
        events,
        wanted,
        forced,
        pool: Pool::new(threads),
        remote,
        fetched: 0,
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
    let mut report = loop {
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
    if let Some(remote) = attempt.remote.take() {
        let traffic = Traffic { fetched: attempt.fetched, ..remote.finish(stop) };
        let told = attempt.warnings;
        remote.warnings().iter().for_each(|text| attempt.warn(text));
        report.warnings += attempt.warnings - told;
        report.seconds = attempt.profile.seconds();
        report.remote = Some(traffic);
        events.event(&Event::Remote { traffic });
    }
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
            return Err(EngineError::unknown_node(name, plan.nodes.iter().map(|n| n.name.as_str())));
        }
    }
    Ok(out)
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
