//! What a kind itself says of a node's parameters: whether it takes them, what it doubts, and whether the files that they
//! name can be what it reads. Of a file only the beginning is read.

use super::{draft::DraftNode, kind::KindInfo, problem::Problem, source::TextSpan, value::Values};
use crate::engine::{
    key::source_params,
    node::{Head, ParamError, Parameters},
};
use serde_json::Value;
use std::{
    io::{self, Read as _},
    path::Path,
};

/// Bytes of a file that a kind judges it by.
const HEAD: u64 = 64 << 10;

/// Where a parameter is given: the knob that holds its value, or the node's own key; and where that knob is used.
fn place(node: &DraftNode, param: &str, values: &Values) -> (TextSpan, Option<TextSpan>) {
    let Some(item) = node.get(param) else { return (node.place, None) };
    match values.knob_of(item) {
        Some(knob) => (knob.place, Some(item.place)),
        None => (item.place, None),
    }
}

/// Parameters as the kind itself reads and judges them.
pub fn judge(
    name: &str,
    node: &DraftNode,
    info: &KindInfo,
    params: Value,
    values: &Values,
    doubts: &mut Vec<(TextSpan, String)>,
    problems: &mut Vec<Problem>,
) -> Option<Parameters> {
    let at = |param: &str, message: String, label: &str| match place(node, param, values) {
        (place, Some(used)) => Problem::at(place, message, label).also(used, "used here"),
        (place, None) => Problem::at(place, message, label),
    };
    let params = match info.kind.accept(params) {
        Ok(params) => params,
        Err(ParamError::Refused { param, message }) => {
            let label = if node.get(&param).is_some() { "refused" } else { "the default does not fit" };
            problems.push(at(&param, format!("node `{name}`, `{param}`: {message}"), label));
            return None;
        }
        Err(ParamError::Type(e)) => {
            let message = format!("node `{name}`: its parameters do not fit together: {e}");
            problems.push(Problem::at(node.place, message, "these parameters"));
            return None;
        }
    };
    for (param, text) in info.kind.doubts(&params) {
        doubts.push((place(node, param, values).0, format!("node `{name}`, `{param}`: {text}")));
    }
    for param in source_params(info.kind.spec()) {
        let Some(path) = params.get(param).and_then(Value::as_str) else { continue };
        if path.is_empty() || path.starts_with("builtin:") {
            continue;
        }
        let path = Path::new(path);
        let judged = head(path).map_err(|e| format!("cannot be read: {e}"));
        let judged =
            judged.and_then(|(bytes, whole)| info.kind.check_source(param, path, Head { bytes: &bytes, whole }));
        if let Err(what) = judged {
            let file = path.file_name().map(|n| n.to_string_lossy()).unwrap_or_default();
            let message = format!("node `{name}`, `{param}`: `{file}` {what}");
            problems.push(at(param, message, "not what the node reads").of_file(path));
        }
    }
    Some(params)
}

/// The beginning of a regular file, and whether that is all of it.
fn head(path: &Path) -> io::Result<(Vec<u8>, bool)> {
    let mut bytes = Vec::new();
    crate::regular::open(path)?.take(HEAD + 1).read_to_end(&mut bytes)?;
    let whole = bytes.len() as u64 <= HEAD;
    bytes.truncate(HEAD as usize);
    Ok((bytes, whole))
}
