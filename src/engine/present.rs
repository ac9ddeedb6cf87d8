//! The report beside what was published. A bake in which nothing changed leaves it as it is.

use super::{
    cache::Cache,
    deliver::{Baked, day},
    error::EngineError,
    facts::Facts,
    hash::Digest,
    options::Options,
    plan::Plan,
    publish::{Folder, page},
    record::BakeRecord,
    report::Report,
    why,
};
use std::{fmt::Write as _, time::SystemTime};

/// Writes the report where it is asked for, unless the one that lies there tells the same. Where none is asked for, an older one that no longer
/// belongs to the files beside it goes. `news`: whether the bake changed anything; `folder_key`: how records know the output folder.
pub fn present(
    plan: &Plan,
    options: &Options,
    baked: &Baked,
    news: bool,
    report: &Report,
    cache: &mut Cache,
    folder_key: &str,
) -> Result<(), EngineError> {
    let found = page::find(&baked.folder);
    if options.report.is_none() && found == page::Found::Nothing {
        return Ok(());
    }
    let of = told_of(plan, &baked.record, report);
    if found == page::Found::Ours(of) && !news {
        return Ok(());
    }
    let folder = Folder { root: &options.out, path: &baked.folder, guard: &baked.guard, overwrite: options.overwrite };
    let Some(make) = options.report else {
        return if baked.lock.is_some() { page::remove(folder) } else { Ok(()) };
    };
    let reasons = if report.runs() > 0 { why::reasons(plan, cache, folder_key)? } else { Vec::new() };
    let document = make(&Facts {
        plan,
        report,
        files: &baked.record.files,
        reasons: &reasons,
        at: day(SystemTime::now()),
        accepted: report.accepted.map(day),
    });
    page::write(folder, baked.lock.as_ref(), of, &document)
}

/// A digest of what a report tells that does not differ between equal bakes.
fn told_of(plan: &Plan, record: &BakeRecord, report: &Report) -> Digest {
    let Plan { name, about, knobs, sources, .. } = plan;
    let mut text = format!("{} {name:?} {about:?} {knobs:?} {sources:?}\n", env!("CARGO_PKG_VERSION"));
    // Writing to a String cannot fail.
    for node in &plan.nodes {
        let _ = writeln!(text, "{:?} {:?} {:?}", node.name, node.kind.spec().title(), node.inputs);
    }
    for judged in &report.judged {
        let _ = writeln!(text, "{judged:?}");
    }
    for file in &record.files {
        let _ = writeln!(text, "{:?} {}", file.path, file.file.hex());
    }
    Digest::of(text.as_bytes())
}
