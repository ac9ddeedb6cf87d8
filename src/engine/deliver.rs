//! What follows the schedule: certificates are judged, files published, and what the run took is noted.

use super::{
    error::EngineError,
    events::Event,
    hash::Digest,
    node::PortSpec,
    options::Options,
    plan::{Bundle, File, OutputRef, Plan, Publish},
    publish::{self, Folder, FolderLock, Manifest, NOTE, Publication, Wanted, guard::Guard, is_read_only, names},
    record::{BakeRecord, Measured, PublishedFile},
    report::{Judged, NodeReport, Outcome, Report, Unmet},
    require,
    schedule::Schedule,
};
use crate::{
    engine::cache::{Cache, lock},
    math::Stop,
};
use serde_json::json;
use std::{
    any::Any,
    collections::{BTreeMap, BTreeSet},
    fmt::Write as _,
    path::{Path, PathBuf},
    sync::Arc,
    time::SystemTime,
};

/// The folder of results that missed a bound, below the pipeline's.
const REJECTED: &str = "rejected";

/// Bytes of new files that are held between their hash and their place.
const HELD: usize = 32 << 20;

/// What the nodes came to.
pub struct Baked {
    pub record: BakeRecord,
    pub unmet: Vec<Unmet>,
    pub judged: Vec<Judged>,
    pub published: Vec<String>,
    pub folder: PathBuf,
    pub accepted: Option<SystemTime>,
    /// Held until `run.json` and `report.html` are written, so that they belong to the files beside them.
    pub lock: Option<FolderLock>,
    /// What the bake has read.
    pub guard: Guard,
}

/// Refuses, before anything runs, to publish over what the bake reads or over what is not farfield's.
pub fn check_targets(
    plan: &Plan,
    options: &Options,
    previous: &BakeRecord,
    cache: &mut Cache,
) -> Result<(), EngineError> {
    let path = options.out.join(&plan.name);
    let guard = Guard::new(plan.texts.iter().cloned().chain(plan.nodes.iter().flat_map(roots)));
    let folder = Folder { root: &options.out, path: &path, guard: &guard, overwrite: options.overwrite };
    let known: BTreeMap<&str, Digest> = previous.files.iter().map(|f| (f.path.as_str(), f.file)).collect();
    let single = plan.files.iter().filter(|f| f.folder().is_none() && !f.path.contains("{name}"));
    folder.check(single.map(|f| f.path.as_str()), |path| known.get(path).copied(), cache)
}

/// The files that a node's parameters name.
pub fn roots(node: &super::plan::PlanNode) -> Vec<PathBuf> {
    let names = super::key::source_params(node.kind.spec());
    let given = names.iter().filter_map(|name| node.params.get(name)?.as_str());
    given.filter(|text| !text.is_empty() && !text.starts_with("builtin:")).map(PathBuf::from).collect()
}

/// Judges the certificates and publishes to the output folder, or to `rejected/`.
pub fn publish_all(
    schedule: &mut Schedule,
    options: &Options,
    stop: &Stop,
    previous: &BakeRecord,
    baked: &mut Baked,
) -> Result<(), EngineError> {
    let plan = schedule.plan;
    bring(schedule, previous)?;
    judge(schedule, previous, baked)?;
    let main = baked.folder.clone();
    let rejected = main.join(REJECTED);
    if !baked.unmet.is_empty() {
        baked.folder = rejected.clone();
    }
    let mut noted: Noted = BTreeMap::new();
    for f in &previous.files {
        noted.entry(f.value).or_default().insert(&f.part, (f.file, f.size));
    }
    let mut files = Vec::new();
    for publish in &plan.files {
        for row in schedule.rows(publish.from)?.iter() {
            let (name, value) = (row.name.clone(), row.value.hash);
            let fail = |what: String| EngineError::publish(&baked.folder.join(&publish.path), what);
            let expanded = names::expand(publish.folder().unwrap_or(&publish.path), &name).map_err(fail)?;
            for (part, known) in parts(schedule, &noted, publish, &name, value)? {
                let path = format!("{expanded}{part}");
                if let Some(what) = names::bad_path(&path) {
                    return Err(fail(what));
                }
                files.push(Outgoing { path, from: publish.from, row: name.clone(), value, part, known });
            }
        }
    }
    if let Some((a, b)) = names::collision(files.iter().map(|f| f.path.as_str())) {
        let (a, b) = names::told_apart(a, b);
        return Err(EngineError::publish(Path::new(&*b), format!("it collides with `{a}`")));
    }
    let mut wanted = Vec::new();
    // Files pass one by one: all hashes must be known before the first is written, so what was read for its hash is read again, unless it is
    // small.
    let mut last = None;
    let (mut loaded, mut bytes_loaded): (BTreeMap<usize, Vec<u8>>, usize) = (BTreeMap::new(), 0);
    for (at, out) in files.iter().enumerate() {
        let (file, size) = match out.known {
            Some(known) => known,
            None => {
                let bytes = out.bytes(schedule, &mut last)?;
                let known = (Digest::of(&bytes), bytes.len() as u64);
                if bytes_loaded + bytes.len() <= HELD {
                    bytes_loaded += bytes.len();
                    loaded.insert(at, bytes);
                }
                known
            }
        };
        baked.record.files.push(PublishedFile {
            path: out.path.clone(),
            part: out.part.clone(),
            value: out.value,
            file,
            size,
        });
        wanted.push(Wanted { path: out.path.clone(), file, size });
    }
    baked.lock = folder_lock(schedule, &options.out, &plan.name, stop)?;
    let lock = baked.lock.as_ref();
    baked.guard = Guard::new(plan.texts.iter().cloned().chain(schedule.files_read()));
    let folder = Folder { root: &options.out, path: &baked.folder, guard: &baked.guard, overwrite: options.overwrite };
    let manifest = Manifest::new(plan, &wanted);
    let mut publication = Publication::new(folder, lock, &manifest, &wanted, schedule.cache)?;
    if baked.unmet.is_empty()
        && let Some(text) = publication.replaces().and_then(|old| replaced(old, &manifest, &main))
    {
        schedule.tell(&text);
    }
    for at in publication.missing.clone() {
        let bytes = match loaded.remove(&at) {
            Some(bytes) => bytes,
            None => files[at].bytes(schedule, &mut last)?,
        };
        publication.stage(at, &bytes)?;
    }
    let written = publication.missing.clone();
    publication.finish(schedule.cache)?;
    for at in written {
        let Wanted { path, size, .. } = &wanted[at];
        schedule.events.event(&Event::Published { path, bytes: *size });
        baked.published.push(path.clone());
    }
    if baked.unmet.is_empty() {
        publish::retire(Folder { path: &rejected, ..folder }, lock, schedule.cache)?;
    } else {
        baked.accepted = publish::published_at(&main);
    }
    Ok(())
}

/// Brings from the second level of the cache what will be read one by one.
fn bring(schedule: &mut Schedule, previous: &BakeRecord) -> Result<(), EngineError> {
    if !schedule.has_second_level() {
        return Ok(());
    }
    let plan = schedule.plan;
    let measured: BTreeSet<Digest> = previous.measured.iter().map(|m| m.certificate).collect();
    let published: BTreeSet<Digest> = previous.files.iter().map(|f| f.value).collect();
    let certificates = plan.require.iter().map(|r| (r.from, &measured));
    let mut wanted = Vec::new();
    for (from, known) in certificates.chain(plan.files.iter().map(|f| (f.from, &published))) {
        let rows = schedule.rows(from)?;
        let unknown = rows.iter().filter(|row| !known.contains(&row.value.hash));
        wanted.extend(unknown.map(|row| (from, row.name.clone(), row.value.hash)));
    }
    schedule.bring_all(wanted)
}

/// What to say where results of other scenes are replaced.
fn replaced(old: &Manifest, new: &Manifest, folder: &Path) -> Option<String> {
    if old.sources == new.sources || old.sources.is_empty() {
        return None;
    }
    let gone: Vec<&str> = old.sources.iter().filter(|s| !new.sources.contains(s)).map(String::as_str).collect();
    let gone = if gone.is_empty() { old.sources.iter().map(String::as_str).collect() } else { gone };
    let at = publish::published_at(folder).map(|at| format!(", baked {}", day(at))).unwrap_or_default();
    Some(format!(
        "replaces the results of {}{at}, in {}; to keep both, bake with --name NAME or --out DIR",
        super::pipeline::name_list(gone),
        folder.display()
    ))
}

/// Notes what the run took; a note that cannot be written is told, and no failure.
pub fn write_note(options: &Options, folder: &Path, lock: &FolderLock, report: &Report) -> Result<(), EngineError> {
    let guard = Guard::default();
    let folder = Folder { root: &options.out, path: folder, guard: &guard, overwrite: options.overwrite };
    publish::write_note(folder, lock, &run_json(report))
}

/// A moment as people write it, in UTC.
pub fn day(at: SystemTime) -> String {
    let seconds = at.duration_since(SystemTime::UNIX_EPOCH).map_or(0, |d| d.as_secs());
    // Civil date from days (Howard Hinnant, chrono-compatible low-level date algorithms).
    let z = seconds / 86_400 + 719_468;
    let (era, of_era) = (z / 146_097, z % 146_097);
    let year_of_era = (of_era - of_era / 1_460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted = (5 * of_year + 2) / 153;
    let day = of_year - (153 * shifted + 2) / 5 + 1;
    let month = if shifted < 10 { shifted + 3 } else { shifted - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    let (hour, minute) = (seconds / 3_600 % 24, seconds / 60 % 60);
    format!("{year:04}-{month:02}-{day:02} {hour:02}:{minute:02} UTC")
}

fn judge(schedule: &mut Schedule, previous: &BakeRecord, baked: &mut Baked) -> Result<(), EngineError> {
    let plan = schedule.plan;
    for requirement in &plan.require {
        for row in schedule.rows(requirement.from)?.iter() {
            let certificate = row.value.hash;
            let known = previous.measured.iter().find(|m| m.certificate == certificate && m.path == requirement.path);
            let number = match known {
                Some(known) => known.number,
                None => require::number(
                    &*load::<File>(schedule, requirement.from, &row.name, certificate)?,
                    &requirement.path,
                ),
            };
            baked.record.measured.push(Measured { certificate, path: requirement.path.clone(), number });
            let rejected = baked.folder.join(REJECTED);
            let judged = require::judged(plan, requirement, &row.name, number);
            if let Some(unmet) = require::missed(plan, requirement, &row.name, &judged, &rejected) {
                schedule.events.event(&Event::NotMet { node: &unmet.node, text: &require::explain(&unmet) });
                baked.unmet.push(unmet);
            }
            baked.judged.push(judged);
        }
    }
    Ok(())
}

/// A file on its way out: a `File` value, or a part of a `Bundle`.
struct Outgoing {
    /// Below the output folder.
    path: String,
    from: OutputRef,
    row: Arc<str>,
    value: Digest,
    /// Its path within its bundle; empty where the value is the file.
    part: String,
    /// Hash and size of its bytes, where the last bake noted them.
    known: Option<(Digest, u64)>,
}

impl Outgoing {
    /// `last`: the bundle that was read last, for its files follow each other.
    fn bytes(&self, schedule: &mut Schedule, last: &mut Option<(Digest, Arc<Bundle>)>) -> Result<Vec<u8>, EngineError> {
        if self.part.is_empty() {
            return Ok(load::<File>(schedule, self.from, &self.row, self.value)?.bytes.clone());
        }
        let bundle = match last {
            Some((value, bundle)) if *value == self.value => Arc::clone(bundle),
            _ => {
                let bundle = load::<Bundle>(schedule, self.from, &self.row, self.value)?;
                *last = Some((self.value, Arc::clone(&bundle)));
                bundle
            }
        };
        let file = bundle.files().get(&self.part);
        Ok(file.ok_or_else(|| EngineError::Again(format!("a bundle lost its file `{}`", self.part)))?.bytes.clone())
    }
}

/// What the last bake published, by value and by path within it: hashes and sizes.
type Noted<'a> = BTreeMap<Digest, BTreeMap<&'a str, (Digest, u64)>>;

/// The files that one value of an entry of `[files]` gives: paths within the value, and hash and size where they are known. A bundle's are
/// known from the last bake, or it is read.
fn parts(
    schedule: &mut Schedule,
    noted: &Noted,
    publish: &Publish,
    row: &str,
    value: Digest,
) -> Result<Vec<(String, Option<(Digest, u64)>)>, EngineError> {
    if let Some(noted) = noted.get(&value) {
        return Ok(noted.iter().map(|(part, known)| ((*part).to_owned(), Some(*known))).collect());
    }
    if publish.folder().is_none() {
        return Ok(vec![(String::new(), None)]);
    }
    let bundle = load::<Bundle>(schedule, publish.from, row, value)?;
    Ok(bundle.files().keys().map(|part| (part.clone(), None)).collect())
}

/// A published value; made again where the cache has lost it.
fn load<T: Any + Send + Sync>(
    schedule: &mut Schedule,
    from: OutputRef,
    row: &str,
    hash: Digest,
) -> Result<Arc<T>, EngineError> {
    let plan = schedule.plan;
    let spec: &PortSpec = &plan.nodes[from.node.0 as usize].kind.spec().outputs[from.port as usize];
    loop {
        match schedule.fetch(hash, spec)? {
            Ok(data) => {
                // The plan has checked the type.
                return data.downcast().map_err(|_| EngineError::Again("a published value is no file".to_owned()));
            }
            Err(gone) => schedule.remake(from, row, hash, &gone)?,
        }
        if let Some(failure) = schedule.errors.first() {
            let what = format!("its value was lost and could not be made again: {}", failure.message);
            return Err(EngineError::cache(schedule.cache.root(), what));
        }
    }
}

/// Keeps two bakes from publishing to one folder at a time. `None` where nothing can be written there.
fn folder_lock(
    schedule: &mut Schedule,
    out: &Path,
    name: &str,
    stop: &Stop,
) -> Result<Option<FolderLock>, EngineError> {
    let (path, events) = (FolderLock::path(out, name), schedule.events);
    let what = format!("the output folder {}", out.join(name).display());
    let waiting = |holder: &str| events.event(&Event::Waiting { what: &what, holder });
    match lock::wait(&path, stop, || FolderLock::take(out, name), waiting) {
        Ok(Some(lock)) => Ok(Some(lock)),
        Ok(None) => Err(EngineError::Interrupted),
        Err(e) if is_read_only(&e) => Ok(None),
        Err(e) => Err(EngineError::publish(&path, e)),
    }
}

/// What differs between equal bakes: times, memory, hits. A line per node.
fn run_json(report: &Report) -> Vec<u8> {
    let outcome = if report.outcome == Outcome::Baked { "baked" } else { "not met" };
    let (seconds, hits, runs) = (json!(report.seconds), report.hits(), report.runs());
    let peak = json!(report.peak_memory);
    let mut out = format!(
        "{NOTE}{outcome}\",\n  \"seconds\": {seconds},\n  \"peak_memory_bytes\": {peak},\n  \
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_those_of_the_calendar() {
        for (seconds, expect) in [
            (0, "1970-01-01 00:00 UTC"),
            (951_782_399, "2000-02-28 23:59 UTC"),
            (951_782_400, "2000-02-29 00:00 UTC"),
            (1_735_689_599, "2024-12-31 23:59 UTC"),
            (4_102_444_800, "2100-01-01 00:00 UTC"),
            (4_107_542_400, "2100-03-01 00:00 UTC"),
        ] {
            assert_eq!(day(SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(seconds)), expect);
        }
    }
}
