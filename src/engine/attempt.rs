//! One attempt at a bake: schedule, judge, publish, record. It is repeated where the cache proves to be worth less
//! than was believed.

use super::{
    cache::Cache,
    deliver::{self, Baked},
    error::EngineError,
    events::{Event, Events},
    memory,
    options::Options,
    plan::Plan,
    present,
    profile::Profile,
    publish::guard::Guard,
    record::{BakeRecord, folder_key},
    remote::Remote,
    report::{Failure, NodeReport, Outcome, Report},
    schedule::{Pool, Schedule, Setting, Trust},
    source::lexical,
};
use crate::math::Stop;
use std::{collections::BTreeSet, time::SystemTime};

pub struct Attempt<'a> {
    pub plan: &'a Plan,
    pub options: &'a Options,
    pub stop: &'a Stop,
    pub events: &'a dyn Events,
    pub wanted: Vec<bool>,
    pub forced: BTreeSet<usize>,
    pub pool: Pool,
    pub remote: Option<Remote>,
    /// Runs of all attempts whose results came from the second level.
    pub fetched: u64,
    pub jobs: usize,
    pub memory: u64,
    pub trust: Trust,
    /// Whether the index is damaged and cannot be set aside in this bake: it counts as empty.
    pub blank: bool,
    pub profile: Profile,
    pub warnings: usize,
}

impl Attempt<'_> {
    pub fn warn(&mut self, text: &str) {
        self.warnings += 1;
        self.events.event(&Event::Warning { node: None, element: None, text });
    }

    pub fn run(&mut self) -> Result<Report, EngineError> {
        let (plan, options) = (self.plan, self.options);
        let mut cache =
            if self.blank { Cache::blank(&options.cache)? } else { Cache::open(&options.cache, !options.dry_run)? };
        let folder = options.out.join(&plan.name);
        let folder_key = folder_key(&folder);
        let previous = cache.bakes(&plan.name, &folder_key, 1)?.records.pop().unwrap_or_default();
        let publishes = !options.dry_run && options.only.is_empty();
        if publishes {
            deliver::check_targets(plan, options, &previous, &mut cache)?;
        }
        // What comes from the second level has to be stored here.
        let remote = self.remote.as_ref().filter(|_| cache.is_writable() && !options.dry_run);
        let mut schedule = Schedule::new(
            plan,
            Setting {
                options,
                stop: self.stop,
                events: self.events,
                cache: &mut cache,
                profile: &mut self.profile,
                previous: &previous,
                trust: self.trust,
                pool: &self.pool,
                remote,
                wanted: &self.wanted,
                forced: self.forced.clone(),
                jobs: self.jobs,
                memory: self.memory,
            },
        );
        let result = schedule.work();
        let main = folder.clone();
        let mut baked = Baked {
            record: BakeRecord::default(),
            unmet: Vec::new(),
            judged: Vec::new(),
            published: Vec::new(),
            folder,
            accepted: None,
            lock: None,
            guard: Guard::default(),
        };
        let mut outcome = Outcome::Baked;
        let finished = result.is_ok() && schedule.errors.is_empty() && !self.stop.is_set();
        let mut result = result;
        if finished && publishes {
            result = deliver::publish_all(&mut schedule, options, self.stop, &previous, &mut baked);
            if !baked.unmet.is_empty() {
                outcome = Outcome::NotMet;
            }
        } else {
            baked.record.files = previous.files.clone();
            baked.record.measured = previous.measured.clone();
        }
        if !schedule.errors.is_empty() {
            outcome = Outcome::Failed;
        }
        if self.stop.is_set() {
            outcome = Outcome::Interrupted;
        }
        self.fetched += schedule.fetched();
        if let Err(error) = result {
            // What is finished is kept for the next time; the first error is the one to tell.
            if !matches!(error, EngineError::Interrupted) {
                return Err(error);
            }
            outcome = Outcome::Interrupted;
        }
        let nodes: Vec<NodeReport> =
            (0..plan.nodes.len()).filter(|n| self.wanted[*n]).map(|n| node(&schedule, n)).collect();
        // A bake in which nothing changed has no record of its own.
        let news = !(0..plan.nodes.len()).all(|n| schedule.is_unchanged(n))
            || previous.nodes.len() != plan.nodes.len()
            || baked.record.files != previous.files
            || baked.record.measured != previous.measured;
        if news && !options.dry_run {
            let trace = |n| schedule.trace(n).or_else(|| schedule.carried(n));
            baked.record.nodes = (0..plan.nodes.len()).filter_map(trace).collect();
        }
        let audit = (options.audit > 0.0 && !options.dry_run).then_some(schedule.audit);
        let (errors, warnings): (Vec<Failure>, _) = (std::mem::take(&mut schedule.errors), schedule.warnings);
        let wanted = plan.nodes.iter().zip(&self.wanted).filter(|(_, wanted)| **wanted);
        let mut files: BTreeSet<_> = wanted.flat_map(|(node, _)| deliver::roots(node)).map(|p| lexical(&p)).collect();
        files.append(&mut schedule.looked_at);
        drop(schedule);
        if !options.dry_run {
            if news {
                baked.record.at = seconds();
                cache.put_bake(&plan.name, &folder_key, &baked.record)?;
            }
            cache.flush()?;
        }
        for text in std::mem::take(&mut cache.warnings) {
            self.warn(&text);
        }
        let mut report = Report {
            outcome,
            nodes,
            errors,
            unmet: std::mem::take(&mut baked.unmet),
            judged: std::mem::take(&mut baked.judged),
            warnings: warnings + self.warnings,
            published: std::mem::take(&mut baked.published),
            files: files.into_iter().collect(),
            remote: None,
            audit,
            folder: baked.folder.clone(),
            accepted: baked.accepted,
            seconds: self.profile.seconds(),
            peak_memory: memory::peak(),
        };
        if let (Outcome::Baked | Outcome::NotMet, Some(lock)) = (outcome, &baked.lock)
            && let Err(e) = deliver::write_note(options, &main, lock, &report)
        {
            self.warn(&e.to_string());
            report.warnings += 1;
        }
        if matches!(outcome, Outcome::Baked | Outcome::NotMet)
            && publishes
            && let Err(e) = present::present(plan, options, &baked, news, &report, &mut cache, &folder_key)
        {
            self.warn(&e.to_string());
            report.warnings += 1;
        }
        Ok(report)
    }
}

fn seconds() -> i64 {
    SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |d| d.as_secs() as i64)
}

fn node(schedule: &Schedule, n: usize) -> NodeReport {
    let (hits, runs, failed, skipped, seconds, forecast) = schedule.counts(n);
    let node = &schedule.plan.nodes[n];
    let spec = node.kind.spec();
    let (kind, method) = (spec.name, spec.method);
    NodeReport { name: node.name.clone(), kind, method, hits, runs, failed, skipped, seconds, forecast }
}
