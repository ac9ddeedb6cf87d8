//! One attempt at a bake: schedule, judge, publish, record. It is repeated where the cache proves to be worth less
//! than was believed.

use super::{
    bake::{Failure, NodeReport, Options, Outcome, Report, Unmet, peak_memory},
    cache::{Cache, lock::Lock},
    error::EngineError,
    events::{Event, Events},
    hash::Digest,
    node::PortSpec,
    plan::{File, OutputRef, Plan},
    profile::Profile,
    publish::{self, Publication, Wanted, names},
    record::{BakeRecord, Measured, PublishedFile},
    require,
    schedule::{Pool, Schedule, Setting, Trust},
    value::shown,
};
use crate::math::Stop;
use serde_json::json;
use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write as _,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, SystemTime},
};

pub struct Attempt<'a> {
    pub plan: &'a Plan,
    pub options: &'a Options,
    pub stop: &'a Stop,
    pub events: &'a dyn Events,
    pub wanted: Vec<bool>,
    pub forced: BTreeSet<usize>,
    pub pool: Pool,
    pub jobs: usize,
    pub memory: u64,
    pub trust: Trust,
    pub profile: Profile,
    pub warnings: usize,
}

/// What the nodes came to, before anything was published.
struct Baked {
    record: BakeRecord,
    unmet: Vec<Unmet>,
    published: Vec<String>,
    folder: PathBuf,
}

impl Attempt<'_> {
    pub fn warn(&mut self, text: &str) {
        self.warnings += 1;
        self.events.event(&Event::Warning { node: None, element: None, text });
    }

    pub fn run(&mut self) -> Result<Report, EngineError> {
        let (plan, options) = (self.plan, self.options);
        let mut cache = Cache::open(&options.cache, !options.dry_run)?;
        let folder = options.out.join(&plan.name);
        let folder_key = folder_key(&folder);
        let previous = cache.bakes(&plan.name, &folder_key, 1)?.pop().unwrap_or_default();
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
                wanted: &self.wanted,
                forced: self.forced.clone(),
                jobs: self.jobs,
                memory: self.memory,
            },
        );
        let result = schedule.work();
        let mut baked = Baked { record: BakeRecord::default(), unmet: Vec::new(), published: Vec::new(), folder };
        let mut outcome = Outcome::Baked;
        let finished = result.is_ok() && schedule.errors.is_empty() && !self.stop.is_set();
        let mut result = result;
        if finished && !options.dry_run && options.only.is_empty() {
            result = publish_all(&mut schedule, options, self.stop, &previous, &mut baked);
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
        let (errors, warnings): (Vec<Failure>, _) = (std::mem::take(&mut schedule.errors), schedule.warnings);
        drop(schedule);
        if !options.dry_run {
            if news {
                baked.record.at = seconds();
                cache.put_bake(&plan.name, &folder_key, &baked.record)?;
            }
            cache.flush()?;
        }
        let report = Report {
            outcome,
            nodes,
            errors,
            unmet: baked.unmet,
            warnings: warnings + self.warnings,
            published: baked.published,
            folder: baked.folder,
            seconds: self.profile.seconds(),
            peak_memory: peak_memory(),
        };
        if matches!(outcome, Outcome::Baked | Outcome::NotMet) && !options.dry_run && options.only.is_empty() {
            let main = options.out.join(&plan.name);
            // Whoever publishes removes what half-written files it finds beside its own.
            let _lock = folder_lock(&cache, &main, self.stop)?;
            let path = main.join("run.json");
            publish::write_note(&options.out, &path, &run_json(&report))?;
        }
        Ok(report)
    }
}

fn seconds() -> i64 {
    SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |d| d.as_secs() as i64)
}

/// How records know an output folder: by its full path.
pub fn folder_key(folder: &Path) -> String {
    std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned()).to_string_lossy().into_owned()
}

fn node(schedule: &Schedule, n: usize) -> NodeReport {
    let (hits, runs, failed, skipped, seconds, forecast) = schedule.counts(n);
    let node = &schedule.plan.nodes[n];
    let kind = node.kind.spec().name;
    NodeReport { name: node.name.clone(), kind, hits, runs, failed, skipped, seconds, forecast }
}

/// Judges the certificates and publishes to the output folder, or to `rejected/`.
fn publish_all(
    schedule: &mut Schedule,
    options: &Options,
    stop: &Stop,
    previous: &BakeRecord,
    baked: &mut Baked,
) -> Result<(), EngineError> {
    let plan = schedule.plan;
    judge(schedule, previous, baked)?;
    let main = baked.folder.clone();
    let rejected = main.join("rejected");
    if !baked.unmet.is_empty() {
        baked.folder = rejected.clone();
    }
    let mut files = Vec::new();
    for publish in &plan.files {
        for row in schedule.rows(publish.from)?.iter() {
            let fail = |what: String| EngineError::publish(&baked.folder.join(&publish.path), what);
            let path = names::expand(&publish.path, &row.name).map_err(fail)?;
            if let Some(what) = names::bad_path(&path) {
                return Err(fail(what));
            }
            files.push((path, publish.from, row.clone()));
        }
    }
    if let Some((a, b)) = names::collision(files.iter().map(|(path, ..)| path.as_str())) {
        return Err(EngineError::publish(Path::new(b), format!("it collides with `{a}`")));
    }
    // A file's own hash is known from the last bake, or its value is read.
    let known: BTreeMap<Digest, &PublishedFile> = previous.files.iter().map(|f| (f.value, f)).collect();
    let mut wanted = Vec::new();
    let mut loaded: BTreeMap<usize, Arc<File>> = BTreeMap::new();
    for (at, (path, from, row)) in files.iter().enumerate() {
        let (file, size) = match known.get(&row.value.hash) {
            Some(known) => (known.file, known.size),
            None => {
                let file = load(schedule, *from, &row.name, row.value.hash)?;
                let known = (Digest::of(&file.bytes), file.bytes.len() as u64);
                loaded.insert(at, file);
                known
            }
        };
        baked.record.files.push(PublishedFile { path: path.clone(), value: row.value.hash, file, size });
        wanted.push(Wanted { path: path.clone(), file, size });
    }
    let _lock = folder_lock(schedule.cache, &main, stop)?;
    let mut publication = Publication::new(&options.out, &baked.folder, &plan.name, &wanted, schedule.cache)?;
    for at in publication.missing.clone() {
        let file = match loaded.remove(&at) {
            Some(file) => file,
            None => load(schedule, files[at].1, &files[at].2.name, files[at].2.value.hash)?,
        };
        publication.stage(at, &file.bytes)?;
    }
    let written = publication.missing.clone();
    publication.finish(schedule.cache)?;
    for at in written {
        let Wanted { path, size, .. } = &wanted[at];
        schedule.events.event(&Event::Published { path, bytes: *size });
        baked.published.push(path.clone());
    }
    if baked.unmet.is_empty() {
        publish::retire(&options.out, &rejected, schedule.cache)?;
    }
    Ok(())
}

fn judge(schedule: &mut Schedule, previous: &BakeRecord, baked: &mut Baked) -> Result<(), EngineError> {
    let plan = schedule.plan;
    for requirement in &plan.require {
        let name = &plan.nodes[requirement.from.node.0 as usize].name;
        for row in schedule.rows(requirement.from)?.iter() {
            let certificate = row.value.hash;
            let known = previous.measured.iter().find(|m| m.certificate == certificate && m.path == requirement.path);
            let number = match known {
                Some(known) => known.number,
                None => require::number(&*load(schedule, requirement.from, &row.name, certificate)?, &requirement.path),
            };
            baked.record.measured.push(Measured { certificate, path: requirement.path.clone(), number });
            let node = if row.name.is_empty() { name.clone() } else { format!("{name}/{}", shown(&row.name)) };
            if let Some(unmet) = require::missed(&node, requirement, number) {
                schedule.events.event(&Event::NotMet { node: &node, text: &require::explain(&unmet) });
                baked.unmet.push(unmet);
            }
        }
    }
    Ok(())
}

/// A `File` value; made again where the cache has lost it.
fn load(schedule: &mut Schedule, from: OutputRef, row: &str, hash: Digest) -> Result<Arc<File>, EngineError> {
    let plan = schedule.plan;
    let spec: &PortSpec = &plan.nodes[from.node.0 as usize].kind.spec().outputs[from.port as usize];
    loop {
        match schedule.fetch(hash, spec)? {
            Ok(data) => {
                // The plan has checked the type.
                return data.downcast().map_err(|_| EngineError::Again("a published value is no file".to_owned()));
            }
            Err(what) => schedule.remake(from, row, hash, &what)?,
        }
        if let Some(failure) = schedule.errors.first() {
            let what = format!("its value was lost and could not be made again: {}", failure.message);
            return Err(EngineError::cache(schedule.cache.root(), what));
        }
    }
}

/// Keeps two bakes from publishing to one folder at a time.
fn folder_lock(cache: &Cache, folder: &Path, stop: &Stop) -> Result<Lock, EngineError> {
    let name = format!("out-{}", Digest::of(folder_key(folder).as_bytes()).hex());
    loop {
        let lock = Lock::take(&cache.root().join("locks").join(&name));
        if let Some(lock) = lock.map_err(|e| EngineError::cache(cache.root(), e))? {
            return Ok(lock);
        }
        stop.check().map_err(|_| EngineError::Interrupted)?;
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// What differs between equal bakes: times, memory, hits. A line per node.
fn run_json(report: &Report) -> Vec<u8> {
    let outcome = if report.outcome == Outcome::Baked { "baked" } else { "not met" };
    let (seconds, hits, runs) = (json!(report.seconds), report.hits(), report.runs());
    let peak = json!(report.peak_memory);
    let mut out = format!(
        "{{\n  \"outcome\": \"{outcome}\",\n  \"seconds\": {seconds},\n  \"peak_memory_bytes\": {peak},\n  \
         \"hits\": {hits},\n  \"runs\": {runs},\n  \"nodes\": {{"
    );
    for (i, NodeReport { name, hits, runs, seconds, .. }) in report.nodes.iter().enumerate() {
        out += if i == 0 { "\n    " } else { ",\n    " };
        // Names of nodes hold no character that JSON escapes; seconds are finite. Writing to a String cannot fail.
        let _ = write!(out, "\"{name}\": {{ \"hits\": {hits}, \"runs\": {runs}, \"seconds\": {seconds:?} }}");
    }
    out += "\n  }\n}\n";
    out.into_bytes()
}
