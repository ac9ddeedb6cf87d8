//! `[require]`: bounds on numbers in a certificate.

use super::{
    plan::{File, NodeId, Plan, Requirement},
    publish::names,
    report::{Judged, Unmet},
    value::{join, shown},
};
use serde_json::Value;
use std::{fmt::Write as _, path::Path};

/// The number at `path` (members separated by `.`, list items by their number) in a certificate.
pub fn number(certificate: &File, path: &str) -> Option<f64> {
    let root: Value = serde_json::from_slice(&certificate.bytes).ok()?;
    at(&root, path)?.as_f64()
}

/// The value at `path` (members separated by `.`, list items by their number).
pub fn at<'v>(value: &'v Value, path: &str) -> Option<&'v Value> {
    let step = |name: &str| match value {
        Value::Object(members) => members.get(name),
        Value::Array(items) => items.get(name.parse::<usize>().ok()?),
        _ => None,
    };
    // A member's own name may hold a dot.
    let mut dots = path.match_indices('.').map(|(at, _)| at);
    let deeper = dots.find_map(|dot| at(step(&path[..dot])?, &path[dot + 1..]));
    deeper.or_else(|| step(path))
}

/// What `measured` says of a bound. What is not there misses every bound. `row` is the certificate's element.
pub fn judged(plan: &Plan, requirement: &Requirement, row: &str, measured: Option<f64>) -> Judged {
    let Requirement { from, path, min, max } = requirement;
    let node = &plan.nodes[from.node.0 as usize];
    let measure = node.kind.spec().measures.iter().find(|m| m.path == *path).cloned().unwrap_or_default();
    Judged {
        node: if row.is_empty() { node.name.clone() } else { format!("{}/{}", node.name, shown(row)) },
        path: path.clone(),
        measured,
        min: *min,
        max: *max,
        about: measure.about,
        unit: measure.unit,
        met: measured.is_some_and(|v| min.is_none_or(|m| v >= m) && max.is_none_or(|m| v <= m)),
    }
}

/// The bound as unmet, if it is missed. `row` is the certificate's element, `folder` where the results will lie.
pub fn missed(plan: &Plan, requirement: &Requirement, row: &str, judged: &Judged, folder: &Path) -> Option<Unmet> {
    if judged.met {
        return None;
    }
    let Judged { node, path, measured, min, max, about, unit, .. } = judged.clone();
    let from = &plan.nodes[requirement.from.node.0 as usize];
    let measure = from.kind.spec().measures.iter().find(|m| m.path == path);
    let picture = measure.and_then(|m| published(plan, requirement.from.node, row, m.picture.as_ref()?));
    let accept = format!("--require {}.{path}=off", from.name);
    Some(Unmet { node, path, measured, min, max, about, unit, picture: picture.map(|p| folder.join(p)), accept })
}

/// The path below the output folder of a picture that node `node` makes beside its certificate.
fn published(plan: &Plan, node: NodeId, row: &str, picture: &str) -> Option<String> {
    let ours = plan.files.iter().filter(|f| f.from.node == node && f.path.contains("{name}"));
    let mut lists = ours.filter(|f| {
        let port = &plan.nodes[node.0 as usize].kind.spec().outputs[f.from.port as usize];
        matches!(port.arity, super::node::Arity::Many { .. })
    });
    names::expand(&lists.next()?.path, &join(row, picture)).ok()
}

/// For people: what was demanded, what was found, what it means, where to see it, and how to take it as it is.
pub fn explain(unmet: &Unmet) -> String {
    let bound = match (unmet.min, unmet.max) {
        (Some(a), Some(b)) if a == b => format!("exactly {a}"),
        (Some(a), Some(b)) => format!("from {a} to {b}"),
        (Some(a), None) => format!("at least {a}"),
        (None, Some(b)) => format!("at most {b}"),
        (None, None) => "a number".to_owned(),
    };
    let unit = if unmet.unit.is_empty() { String::new() } else { format!(" {}", unmet.unit) };
    let mut out = match unmet.measured {
        Some(v) => format!("{} is {v}{unit}, required is {bound}", unmet.path),
        None => format!("{} is not a number in the certificate, required is {bound}", unmet.path),
    };
    if !unmet.about.is_empty() {
        let _ = write!(out, " ({})", unmet.about);
    }
    if let Some(picture) = &unmet.picture {
        let _ = write!(out, "; see {}", picture.display());
    }
    let _ = write!(out, "; to accept it: {}", unmet.accept);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_from_paths() {
        let text = br#"{"a":{"b":[1,{"c":2.5}]},"near_0.75":3,"d.e":{"f":4}}"#;
        let file = File { media_type: String::new(), bytes: text.to_vec() };
        assert_eq!(number(&file, "a.b.1.c"), Some(2.5));
        assert_eq!((number(&file, "a.b"), number(&file, "a.x"), number(&file, "a.b.9")), (None, None, None));
        assert_eq!((number(&file, "near_0.75"), number(&file, "d.e.f")), (Some(3.0), Some(4.0)));
    }

    #[test]
    fn an_explanation_says_all() {
        let unmet = Unmet {
            node: "evaluate".into(),
            path: "crack_px.total".into(),
            measured: Some(1.0),
            min: None,
            max: Some(0.0),
            about: "cracks".into(),
            unit: "px".into(),
            picture: Some("out/town/rejected/worst-crack.png".into()),
            accept: "--require evaluate.crack_px.total=off".into(),
        };
        let expect = "crack_px.total is 1 px, required is at most 0 (cracks); see out/town/rejected/worst-crack.png; \
                      to accept it: --require evaluate.crack_px.total=off";
        assert_eq!(explain(&unmet), expect);
    }
}
