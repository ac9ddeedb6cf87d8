//! The last lines of a bake: what its certificates say, which requirements were missed and what to do, where the files are.

use super::{
    quantity::{show_bytes, show_seconds},
    terminal::fill_output,
    verdict,
};
use crate::engine::{
    bake::{self, Outcome, Report, Unmet},
    plan::{OutputRef, Plan},
    publish::page,
};
use serde_json::Value;
use std::{collections::BTreeMap, path::Path};

/// The lines. `published`: whether it was a bake that publishes.
pub fn summary(plan: &Plan, report: &Report, published: bool) -> String {
    let published = published && !report.nodes.is_empty() && matches!(report.outcome, Outcome::Baked | Outcome::NotMet);
    let files = if published { published_files(&report.folder) } else { Vec::new() };
    let certificates = certificates(plan, &report.folder, &files);
    let mut out = String::new();
    for (path, (_, certificate)) in &certificates {
        let text = verdict::text(certificate);
        if certificates.len() > 1 && !text.is_empty() {
            out += &format!("{path}\n");
        }
        out += &text;
        if verdict::is_heavier(certificate) {
            out += &help(&knobs(plan, None, Some("coarser")));
        }
    }
    for unmet in &report.unmet {
        out += &not_met(plan, unmet, &certificates);
    }
    if published && !plan.require.is_empty() {
        out += &format!("requirements: {} of {} met\n", plan.require.len() - missed(plan, report), plan.require.len());
    }
    out += &last_line(plan, report, published);
    if published && report.outcome == Outcome::NotMet {
        out += &(fill_output(&bake::kept(plan, report)) + "\n");
    }
    if published && matches!(page::find(&report.folder), page::Found::Ours(_)) {
        out += &format!("report: {}\n", report.folder.join(page::REPORT).display());
    }
    out
}

/// How many requirements were missed.
pub fn missed(plan: &Plan, report: &Report) -> usize {
    let missed = |r: &&crate::engine::plan::Requirement| {
        let node = &plan.nodes[r.from.node.0 as usize].name;
        report.unmet.iter().any(|u| u.path == r.path && (u.node == *node || u.node.starts_with(&format!("{node}/"))))
    };
    plan.require.iter().filter(missed).count()
}

/// What came of a bake, in a word or three.
pub fn outcome(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Baked => "baked",
        Outcome::Failed => "failed",
        Outcome::NotMet => "certificate not met",
        Outcome::Interrupted => "interrupted",
    }
}

fn last_line(plan: &Plan, report: &Report, published: bool) -> String {
    let word = outcome(report.outcome);
    let seconds = show_seconds(report.seconds);
    let remote = report.remote.unwrap_or_default();
    let mut out = format!("{word}: {}, {} hits", plan.name, report.hits());
    if remote.fetched > 0 || remote.fetched_bytes > 0 {
        out += &format!(" ({} from the remote cache, {})", remote.fetched, show_bytes(remote.fetched_bytes));
    }
    out += &format!(", {} ran", report.runs());
    if remote.stored > 0 || remote.stored_bytes > 0 {
        out += &format!(" ({} uploaded, {})", remote.stored, show_bytes(remote.stored_bytes));
    }
    out += &format!(", {seconds}");
    if let Some(peak) = report.peak_memory {
        out += &format!(", peak {}", show_bytes(peak));
    }
    if report.warnings > 0 {
        out += &format!(", {} warning{}", report.warnings, if report.warnings == 1 { "" } else { "s" });
    }
    if published {
        out += &format!(" → {}", report.folder.display());
    }
    out + "\n"
}

/// What the folder's manifest lists.
pub fn published_files(folder: &Path) -> Vec<String> {
    let manifest = std::fs::read(folder.join("manifest.json")).ok();
    let manifest: Option<Value> = manifest.and_then(|bytes| serde_json::from_slice(&bytes).ok());
    let files = manifest.as_ref().and_then(|m| m.get("files")).and_then(Value::as_object);
    files.into_iter().flat_map(|f| f.keys().cloned()).collect()
}

/// The certificates among the published files: by path, with the output that each is of.
pub type Certificates = BTreeMap<String, (OutputRef, Value)>;

pub fn certificates(plan: &Plan, folder: &Path, files: &[String]) -> Certificates {
    let mut all = BTreeMap::new();
    for publish in &plan.files {
        let outputs = &plan.nodes[publish.from.node.0 as usize].kind.spec().outputs;
        if outputs[publish.from.port as usize].name != "certificate" {
            continue;
        }
        // `{name}` stands for any element.
        let (before, after) = publish.path.split_once("{name}").unwrap_or((&publish.path, ""));
        let one = !publish.path.contains("{name}");
        let is_it = |f: &&String| if one { **f == publish.path } else { f.starts_with(before) && f.ends_with(after) };
        for path in files.iter().filter(is_it) {
            let read = std::fs::read(folder.join(path)).ok().and_then(|b| serde_json::from_slice(&b).ok());
            all.extend(read.map(|json| (path.clone(), (publish.from, json))));
        }
    }
    all
}

/// A missed requirement: what was found, what it means, what shows it, what helps, how to accept it.
fn not_met(plan: &Plan, unmet: &Unmet, certificates: &Certificates) -> String {
    let mut out = fill_output(&format!("not met: {}: {}", unmet.node, wanted(unmet))) + "\n";
    let node = plan.nodes.iter().position(|n| n.name == unmet.node || unmet.node.starts_with(&format!("{}/", n.name)));
    // Elements of a list share their measures.
    let of_node = |(_, (from, _)): &(&String, &(OutputRef, Value))| Some(from.node.0 as usize) == node;
    let helps = certificates.iter().find(of_node).and_then(|(_, (_, json))| verdict::helps(json, &unmet.path));
    if !unmet.about.is_empty() {
        out += &(fill_output(&format!("  means: {}", unmet.about)) + "\n");
    }
    if let Some(picture) = &unmet.picture {
        out += &(fill_output(&format!("  seen in: {}", picture.display())) + "\n");
    }
    out += &help(&knobs(plan, node, helps));
    out + &fill_output(&format!("  to accept it: {}", unmet.accept)) + "\n"
}

fn wanted(unmet: &Unmet) -> String {
    let path = &unmet.path;
    let measured = unmet.measured.map_or("no number".to_owned(), |v| format!("{v}"));
    let wanted = match (unmet.min, unmet.max) {
        (Some(min), Some(max)) if min == max => format!("{min}"),
        (Some(min), Some(max)) => format!("{min} … {max}"),
        (Some(min), None) => format!("at least {min}"),
        (None, Some(max)) => format!("at most {max}"),
        (None, None) => "a number".to_owned(),
    };
    format!("{path} is {measured}, required {wanted}")
}

fn help(knobs: &[String]) -> String {
    if knobs.is_empty() {
        return String::new();
    }
    fill_output(&format!("  may help: {}", knobs.join(" or "))) + "\n"
}

/// Settings that make the result finer or coarser than it is. `node`: the one that measured, whose resolution is taken.
fn knobs(plan: &Plan, node: Option<usize>, helps: Option<&str>) -> Vec<String> {
    let finer = match helps {
        Some("finer") => true,
        Some("coarser") => false,
        _ => return Vec::new(),
    };
    let mut all = Vec::new();
    let mut of = plan.nodes.iter().enumerate().filter(|(i, _)| node.is_none_or(|n| n == *i));
    if let Some(px) = of.find_map(|(_, n)| n.params.get("resolution")?.as_u64()).filter(|px| finer || *px >= 64) {
        all.push(format!("--set resolution={}", if finer { px * 2 } else { px / 2 }));
    }
    for simplify in plan.nodes.iter().filter(|n| n.kind.spec().name == "collapse") {
        let Some(factor) = simplify.params.get("factor").and_then(Value::as_f64) else { continue };
        let other = if finer { 0.5 * (factor + 1.0) } else { (factor + 1.0).min(8.0) };
        if other != factor {
            all.push(format!("--set {}.factor={other}", simplify.name));
        }
    }
    all
}
