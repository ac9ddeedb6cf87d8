//! `[require]` and `--require`: bounds on the numbers in certificates, all judged before anything runs.

use super::{
    draft::{Draft, no_node},
    item::{Item, what},
    link::{Links, Output},
    problem::Problem,
    source::{Sources, TextSpan},
    value::Values,
};
use crate::engine::node::Measure;
use crate::engine::{suggest, types::Ty};
use toml::de::DeValue;

const FORM: &str = "a bound is { min = … }, { max = … }, both, or a number that must be met exactly";

/// How a requirement is given on the command line. `=MIN..MAX` needs no quotes in a shell.
const ARGUMENT: &str = "expected --require NODE.MEASURE=off, or a bound: =..MAX, =MIN.., =MIN..MAX, =NUMBER, or in \
                        quotes '<=MAX' or '>=MIN'";

/// A bound on a number in a certificate.
pub struct Bound {
    pub from: Output,
    pub path: String,
    pub min: Option<f64>,
    pub max: Option<f64>,
}

/// `[require]`, by node, then by path; then what `--require` says over it. `arguments` are texts of [`Sources`].
pub fn require<'s>(
    draft: &'s Draft<'s>,
    links: &Links,
    values: &Values<'s>,
    arguments: &[u32],
    problems: &mut Vec<Problem>,
) -> Vec<Bound> {
    let mut bounds = Vec::new();
    for (name, (place, items)) in &draft.require {
        let Some(node) = links.node(name) else {
            problems.push(no_node(name, *place, "[require]: ", links.names(), problems.len()));
            continue;
        };
        let port = certificate(links, node, *place, "[require]", problems);
        for (path, item) in items {
            let bound = bound(path, *item, values, problems);
            let known = port.is_none() || bound.is_none() || measured(links, node, path, item.key, problems);
            if let (Some((min, max)), Some(port), true) = (bound, port, known) {
                bounds.push(Bound { from: (node, port), path: (*path).to_owned(), min, max });
            }
        }
    }
    for source in arguments {
        argument(*source, links, values.sources, &mut bounds, problems);
    }
    bounds
}

/// The output of a node that is judged.
fn certificate(links: &Links, node: usize, place: TextSpan, who: &str, problems: &mut Vec<Problem>) -> Option<u32> {
    let info = links.nodes[node].info.as_ref()?;
    let judged = |o: &crate::engine::node::PortSpec| o.name == "certificate" && o.ty.name == "File";
    if let Some(port) = info.outputs().iter().position(judged) {
        return Some(port as u32);
    }
    let able = links.nodes.iter().filter(|n| n.info.as_ref().is_some_and(|i| i.outputs().iter().any(judged)));
    let able: Vec<&str> = able.map(|n| n.name).collect();
    let message = format!("{who}: node `{}` writes no certificate", links.nodes[node].name);
    let help = if able.is_empty() {
        "no node of this pipeline does; kind `evaluate` measures a stand-in".to_owned()
    } else {
        format!("nodes that do: {}", suggest::list(able))
    };
    problems.push(Problem::at(place, message, "nothing to judge").help(help));
    None
}

/// Whether the node's certificate has a number at `path`; reported if not.
fn measured(links: &Links, node: usize, path: &str, place: TextSpan, problems: &mut Vec<Problem>) -> bool {
    let Some(info) = &links.nodes[node].info else { return false };
    let spec = info.kind.spec();
    if spec.measures.is_empty() || spec.measures.iter().any(|m| m.path == path) {
        return true;
    }
    let message = format!("{} measures no `{path}`", spec.phrase());
    problems.push(Problem::at(place, message, "no such measure").help(near_measure(path, &spec.measures)));
    false
}

/// The measure that is meant, or those that are parts of what is named, or where to look.
fn near_measure(path: &str, measures: &[Measure]) -> String {
    let paths = || measures.iter().map(|m| m.path.as_str());
    let parts: Vec<&str> = paths().filter(|p| p.strip_prefix(path).is_some_and(|rest| rest.starts_with('.'))).collect();
    if !parts.is_empty() {
        return format!("it has the parts {}", suggest::list(parts));
    }
    // The part before the last dot may be right, and the last one not.
    let above = path.rsplit_once('.').map_or("", |(above, _)| above);
    let beside: Vec<&str> = paths().filter(|p| p.rsplit_once('.').is_some_and(|(a, _)| a == above)).collect();
    match suggest::nearest(path, paths()) {
        Some(near) => format!("did you mean `{near}`? `{near}`: {}", about(near, measures)),
        None if !beside.is_empty() => format!("there are {}", suggest::list(beside)),
        None => {
            let mut groups: Vec<&str> = paths().filter_map(|p| p.split('.').next()).collect();
            groups.dedup();
            format!("the measures begin with {}", suggest::list(groups))
        }
    }
}

fn about<'m>(path: &str, measures: &'m [Measure]) -> &'m str {
    measures.iter().find(|m| m.path == path).map_or("", |m| m.about.as_str())
}

/// The range that one requirement allows.
fn bound<'s>(
    path: &'s str,
    item: Item<'s>,
    values: &Values<'s>,
    problems: &mut Vec<Problem>,
) -> Option<(Option<f64>, Option<f64>)> {
    let number = Ty::Number { min: None, max: None, unit: String::new() };
    let DeValue::Table(table) = item.value else {
        if !matches!(item.value, DeValue::Integer(_) | DeValue::Float(_) | DeValue::String(_)) {
            let message = format!("`{path}` is {}, expected a bound", what(item.value));
            problems.push(Problem::at(item.place, message, "not a bound").help(FORM));
            return None;
        }
        let value = values.convert(path, item, &number, problems)?.as_f64();
        return Some((value, value));
    };
    let (mut min, mut max) = (None, None);
    let mut sound = true;
    for (key, value) in table {
        let key_place = TextSpan::new(item.place.source, key.span());
        let name = &**key.get_ref();
        let inner =
            Item { key: key_place, value: value.get_ref(), place: TextSpan::new(item.place.source, value.span()) };
        if !matches!(name, "min" | "max") && !dotted(values.sources, key_place) && !value.get_ref().is_table() {
            let message = format!("[require]: a bound has no `{name}`");
            problems.push(Problem::at(key_place, message, "not min or max").help(format!("{}{FORM}", meant(name))));
            sound = false;
            continue;
        }
        // A path without quotes is a table in a table, and TOML cannot say whether its last word is a bound.
        if !matches!(name, "min" | "max") || dotted(values.sources, key_place) {
            let message = format!("[require]: the path `{path}.{name}…` needs quotes");
            let help = format!("write \"{path}.{name}\" = {{ max = … }}; {FORM}");
            problems.push(Problem::at(key_place, message, "not min or max").help(help));
            sound = false;
            continue;
        }
        let value = values.convert(name, inner, &number, problems).and_then(|v| v.as_f64());
        sound &= value.is_some();
        *(if name == "min" { &mut min } else { &mut max }) = value;
    }
    if !sound {
        return None;
    }
    let wrong = match (min, max) {
        (None, None) => Some("bounds nothing"),
        (Some(min), Some(max)) if min > max => Some("cannot be met: min is above max"),
        _ => None,
    };
    if let Some(why) = wrong {
        problems.push(Problem::at(item.place, format!("`{path}` {why}"), "no range").help(FORM));
        return None;
    }
    Some((min, max))
}

/// The key that a word for a limit means.
fn meant(word: &str) -> &'static str {
    match word.to_lowercase().as_str() {
        "maximum" | "most" | "at_most" | "at-most" | "upper" | "below" | "limit" | "le" | "lt" | "mx" | "maxi" => {
            "did you mean `max`? "
        }
        "minimum" | "least" | "at_least" | "at-least" | "lower" | "above" | "ge" | "gt" | "mini" => {
            "did you mean `min`? "
        }
        _ => "",
    }
}

/// Whether a dot stands before the key at `place`.
fn dotted(sources: &Sources, place: TextSpan) -> bool {
    sources
        .get(place)
        .text
        .get(..place.start as usize)
        .is_some_and(|before| before.trim_end_matches([' ', '\t']).ends_with('.'))
}

/// Applies `NODE.MEASURE=…` to the bounds.
fn argument(source: u32, links: &Links, sources: &Sources, bounds: &mut Vec<Bound>, problems: &mut Vec<Problem>) {
    let text = &*sources.by_number(source).text;
    let place = |start: usize, part: &str| TextSpan::new(source, start..start + part.len());
    let fail = |at: TextSpan, message: String, label: &str| Problem::at(at, message, label).help(ARGUMENT);
    let Some((at, operator)) = operator(text) else {
        problems.push(fail(place(0, text), format!("--require {text}: there is no bound"), "no bound"));
        return;
    };
    let (name, value) = (text[..at].trim(), text[at + operator.len()..].trim());
    let Some((node_name, path)) = name.split_once('.').filter(|(node, path)| !node.is_empty() && !path.is_empty())
    else {
        let message = format!("--require {text}: `{name}` is no NODE.MEASURE");
        problems.push(fail(place(0, name), message, "a node, a dot and a measure"));
        return;
    };
    let Some(node) = links.node(node_name) else {
        problems.push(no_node(node_name, place(0, node_name), "--require: ", links.names(), problems.len()));
        return;
    };
    let Some(port) = certificate(links, node, place(0, node_name), "--require", problems) else { return };
    if !measured(links, node, path, place(node_name.len() + 1, path), problems) {
        return;
    }
    let from = (node, port);
    let old = bounds.iter().position(|b| b.from == from && b.path == path);
    if operator == "=" && value == "off" {
        bounds.retain(|b| b.from != from || b.path != path);
        return;
    }
    let kept = old.map_or((None, None), |at| (bounds[at].min, bounds[at].max));
    let Some((min, max)) = range(operator, value, kept) else {
        let at = text.len() - value.len();
        problems.push(fail(place(at, value), format!("--require {text}: `{value}` is no bound"), "not a bound"));
        return;
    };
    if min.zip(max).is_some_and(|(min, max)| min > max) {
        problems.push(fail(place(0, text), format!("--require {text}: min is above max"), "cannot be met"));
        return;
    }
    let bound = Bound { from, path: path.to_owned(), min, max };
    match old {
        Some(at) => bounds[at] = bound,
        None => bounds.push(bound),
    }
}

/// The first operator of an argument, and where it is.
fn operator(text: &str) -> Option<(usize, &'static str)> {
    let found = |op: &'static str| Some((text.find(op)?, op));
    ["<=", ">=", "="].into_iter().filter_map(found).min_by_key(|(at, op)| (*at, op.len() == 1))
}

/// The range that an argument's value gives; one side alone keeps the other of `kept`.
fn range(operator: &str, value: &str, kept: (Option<f64>, Option<f64>)) -> Option<(Option<f64>, Option<f64>)> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    match operator {
        "<=" => Some((kept.0, Some(number(value)?))),
        ">=" => Some((Some(number(value)?), kept.1)),
        _ => match value.split_once("..") {
            Some(("", max)) => Some((None, Some(number(max)?))),
            Some((min, "")) => Some((Some(number(min)?), None)),
            Some((min, max)) => Some((Some(number(min)?), Some(number(max)?))),
            None => Some((Some(number(value)?), Some(number(value)?))),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_ranges() {
        for (text, expect) in [
            ("a.b<=5", Some((None, Some(5.0)))),
            ("a.b >= -2.5", Some((Some(-2.5), Some(9.0)))),
            ("a.b=..5e-5", Some((None, Some(5e-5)))),
            ("a.b=30..", Some((Some(30.0), None))),
            ("a.b=1..2", Some((Some(1.0), Some(2.0)))),
            ("a.b=3", Some((Some(3.0), Some(3.0)))),
            ("a.b=..", None),
            ("a.b=high", None),
            ("a.b<=nan", None),
        ] {
            let (at, operator) = operator(text).unwrap();
            let kept = if operator == ">=" { (Some(0.0), Some(9.0)) } else { (None, None) };
            assert_eq!(range(operator, text[at + operator.len()..].trim(), kept), expect, "{text}");
        }
        assert_eq!(operator("a.b"), None);
        assert_eq!(operator("a.b<=c=d"), Some((3, "<=")));
    }
}
