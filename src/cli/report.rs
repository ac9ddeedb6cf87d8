//! What a bake tells, as the page that lies beside its files.

use super::{graph::edges, summary::certificates};
use crate::{
    certify,
    engine::{
        facts::Facts,
        node::Arity,
        plan::{OutputRef, Plan},
        require,
    },
    report::{
        self, Bound, Certificate, Edge, Figure, File, Node, Page, Reason, View,
        certificate::{pictures, read},
        pictures::{MOST_BYTES, MOST_VIEWS, shown},
    },
};
use serde_json::Value;

/// The page as an HTML document without its doctype.
pub fn html(facts: &Facts) -> String {
    report::html(&page(facts))
}

fn page(facts: &Facts) -> Page {
    let Facts { plan, report, files, reasons, at, accepted } = facts;
    let node = |n: &crate::engine::report::NodeReport| {
        let place = plan.nodes.iter().find(|p| p.name == n.name);
        Node {
            name: n.name.clone(),
            kind: place.map_or_else(String::new, |p| p.kind.spec().title()),
            mapped: place.is_some_and(|p| !p.axes.is_empty()),
            hits: n.hits,
            runs: n.runs,
            seconds: n.seconds,
        }
    };
    let edge = |(from, to, label, list): (OutputRef, usize, String, bool)| Edge {
        from: from.node.0 as usize,
        to,
        label,
        list,
    };
    let bound = |j: &crate::engine::report::Judged| Bound {
        node: j.node.clone(),
        path: j.path.clone(),
        about: j.about.clone(),
        unit: j.unit.clone(),
        measured: j.measured,
        min: j.min,
        max: j.max,
        met: j.met,
    };
    let reason = |r: &crate::engine::report::Reason| Reason {
        node: r.node.clone(),
        did: r.did.clone(),
        cause: r.cause.clone(),
        from: r.from.clone(),
    };
    Page {
        name: plan.name.clone(),
        about: plan.about.clone(),
        file: plan.file.display().to_string(),
        sources: plan.sources.clone(),
        knobs: plan.knobs.iter().map(|(name, value)| (name.clone(), value.to_string())).collect(),
        at: at.clone(),
        seconds: report.seconds,
        peak_memory: report.peak_memory,
        warnings: report.warnings,
        rejected: (!report.unmet.is_empty()).then(|| match accepted {
            Some(at) => format!("The folder above still holds the results of the last accepted bake, of {at}."),
            None => "No bake was accepted yet.".to_owned(),
        }),
        bounds: report.judged.iter().map(bound).collect(),
        certificates: judged(facts),
        nodes: report.nodes.iter().map(node).collect(),
        edges: edges(plan).map(edge).collect(),
        reasons: reasons.iter().map(reason).collect(),
        files: files.iter().map(|f| File { path: f.path.clone(), bytes: f.size }).collect(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
    }
}

/// The published certificates with their pictures, of which all together stay within the page's limits.
fn judged(facts: &Facts) -> Vec<Certificate> {
    let (plan, folder) = (facts.plan, &facts.report.folder);
    let files: Vec<String> = facts.files.iter().map(|f| f.path.clone()).collect();
    let (mut views, mut bytes) = (MOST_VIEWS, MOST_BYTES);
    let mut all = Vec::new();
    for (path, (from, json)) in certificates(plan, folder, &files) {
        let mut certificate = read(&path, &json);
        certificate.figures = figures(plan, from, &json);
        certificate.legend = legend(plan.nodes[from.node.0 as usize].kind.spec().method);
        let published = pictures_of(plan, from, &path, &files);
        let names: Vec<&str> = published.iter().map(|(name, _)| &**name).collect();
        let node = &plan.nodes[from.node.0 as usize].name;
        let missed = facts.report.unmet.iter().filter(|u| u.node == *node || u.node.starts_with(&format!("{node}/")));
        let missed: Vec<String> =
            missed.filter_map(|u| Some(u.picture.as_ref()?.file_stem()?.to_str()?.to_owned())).collect();
        for picture in pictures(&json, &names, &missed) {
            let Some((_, path)) = published.iter().find(|(name, _)| *name == picture.name) else { continue };
            let file = std::fs::read(folder.join(path)).ok();
            let found = file.and_then(|file| shown(&file, picture.panels.as_ref()));
            let known = found.as_ref().and_then(|found| certificate.views.iter_mut().find(|v| v.is_of(found)));
            if let Some(view) = known {
                // The same view is the worst by another measure too.
                view.titles.push(picture.title);
                if view.place.is_empty() {
                    view.place = picture.place;
                }
                continue;
            }
            match found.filter(|f| views > 0 && f.bytes() <= bytes) {
                Some(shown) => {
                    (views, bytes) = (views - 1, bytes - shown.bytes());
                    certificate.views.push(View { titles: vec![picture.title], place: picture.place, shown });
                }
                None => certificate.other_pictures.push(path.clone()),
            }
        }
        all.push(certificate);
    }
    all
}

/// The numbers that the kind explains.
fn figures(plan: &Plan, from: OutputRef, json: &Value) -> Vec<Figure> {
    let measures = &plan.nodes[from.node.0 as usize].kind.spec().measures;
    let figure = |m: &crate::engine::node::Measure| {
        let value = require::at(json, &m.path)?.as_f64()?;
        Some(Figure { about: m.about.clone(), path: m.path.clone(), value, unit: m.unit.clone() })
    };
    measures.iter().filter_map(figure).collect()
}

/// The colours of the differences that a method of `evaluate` draws.
fn legend(method: &str) -> Vec<([u8; 3], String)> {
    let words = |all: &[([u8; 3], &str)]| all.iter().map(|(colour, text)| (*colour, (*text).to_owned())).collect();
    match method {
        "views" => words(&certify::legend()),
        "directions" | "walk" => words(&certify::directions::LEGEND),
        _ => Vec::new(),
    }
}

/// The pictures that the node of a certificate publishes beside it: names and paths. `path` is the certificate's.
fn pictures_of(plan: &Plan, from: OutputRef, path: &str, files: &[String]) -> Vec<(String, String)> {
    let node = &plan.nodes[from.node.0 as usize];
    // The certificate of an element has that element's pictures.
    let own = plan.files.iter().find(|f| f.from == from).and_then(|f| between(&f.path, path));
    let prefix = own.filter(|_| !node.axes.is_empty()).map_or(String::new(), |element| format!("{element},"));
    let mut all = Vec::new();
    for publish in plan.files.iter().filter(|f| f.from.node == from.node && f.path.ends_with(".png")) {
        let port = &node.kind.spec().outputs[publish.from.port as usize];
        if matches!(port.arity, Arity::Many { .. }) {
            let name = |file: &String| {
                let name = between(&publish.path, file)?.strip_prefix(&prefix)?;
                Some((name.to_owned(), file.clone()))
            };
            all.extend(files.iter().filter_map(name));
        }
    }
    all
}

/// What stands for `{name}` where `path` was made from `template`.
fn between<'p>(template: &str, path: &'p str) -> Option<&'p str> {
    let (before, after) = template.split_once("{name}")?;
    path.strip_prefix(before)?.strip_suffix(after)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_in_paths() {
        assert_eq!(between("pictures/{name}.png", "pictures/worst-psnr.png"), Some("worst-psnr"));
        assert_eq!(between("pictures/{name}.png", "other/worst-psnr.png"), None);
        assert_eq!(between("certificate.json", "certificate.json"), None);
    }
}
