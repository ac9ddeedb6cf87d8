//! `[require]`: bounds on numbers in a certificate.

use super::{
    bake::Unmet,
    plan::{File, Requirement},
};
use serde_json::Value;

/// The number at `path` (members separated by `.`, list items by their number) in a certificate.
pub fn number(certificate: &File, path: &str) -> Option<f64> {
    let root: Value = serde_json::from_slice(&certificate.bytes).ok()?;
    let step = |value: &Value, name: &str| match value {
        Value::Object(members) => members.get(name).cloned(),
        Value::Array(items) => items.get(name.parse::<usize>().ok()?).cloned(),
        _ => None,
    };
    path.split('.').try_fold(root, |value, name| step(&value, name))?.as_f64()
}

/// The bound as unmet, if `measured` misses it. What is not there misses every bound.
pub fn missed(node: &str, requirement: &Requirement, measured: Option<f64>) -> Option<Unmet> {
    let Requirement { path, min, max, .. } = requirement;
    let met = measured.is_some_and(|v| min.is_none_or(|m| v >= m) && max.is_none_or(|m| v <= m));
    (!met).then(|| Unmet { node: node.to_owned(), path: path.clone(), measured, min: *min, max: *max })
}

/// For people: what was demanded and what was found.
pub fn explain(unmet: &Unmet) -> String {
    let bound = match (unmet.min, unmet.max) {
        (Some(a), Some(b)) => format!("from {a} to {b}"),
        (Some(a), None) => format!("at least {a}"),
        (None, Some(b)) => format!("at most {b}"),
        (None, None) => "a number".to_owned(),
    };
    match unmet.measured {
        Some(v) => format!("{} is {v}, required is {bound}", unmet.path),
        None => format!("{} is not a number in the certificate, required is {bound}", unmet.path),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::plan::{NodeId, OutputRef};

    #[test]
    fn bounds_are_read_from_paths() {
        let file = File { media_type: String::new(), bytes: br#"{"a":{"b":[1,{"c":2.5}]}}"#.to_vec() };
        assert_eq!(number(&file, "a.b.1.c"), Some(2.5));
        assert_eq!((number(&file, "a.b"), number(&file, "a.x"), number(&file, "a.b.9")), (None, None, None));
        let from = OutputRef { node: NodeId(0), port: 0 };
        let r = |min, max| Requirement { from, path: "p".into(), min, max };
        assert!(missed("n", &r(None, Some(2.5)), Some(2.5)).is_none());
        assert!(missed("n", &r(None, Some(2.0)), Some(2.5)).is_some());
        assert!(missed("n", &r(Some(3.0), None), Some(2.5)).is_some());
        assert!(missed("n", &r(None, None), None).is_some());
        assert!(missed("n", &r(Some(0.0), None), Some(f64::NAN)).is_some());
    }
}
