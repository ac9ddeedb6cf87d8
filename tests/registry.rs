//! The kinds as data: names, documentation, defaults.

use farfield::{
    engine::{
        node::{KindSpec, Registry},
        pipeline::{OWN_KEYS, parameters},
    },
    nodes,
};
use serde_json::{Value, json};
use std::collections::BTreeSet;

fn each(check: impl Fn(&KindSpec)) {
    let registry: Registry = nodes::registry();
    assert!(registry.iter().count() >= 3);
    registry.iter().for_each(|kind| check(kind.spec()));
}

fn parameter_names(spec: &KindSpec) -> Vec<String> {
    parameters(&spec.params).0.into_keys().collect()
}

#[test]
fn everything_is_documented() {
    each(|spec| {
        let about = spec.params.get("description").and_then(Value::as_str).unwrap_or_default();
        assert!(about.len() > 20, "{}: its Params have no doc comment that says what it does", spec.name);
        for port in spec.inputs.iter().chain(&spec.outputs) {
            assert!(port.doc.len() > 3, "{}: port {} has no doc comment", spec.name, port.name);
        }
        for (name, schema) in spec.params.get("properties").and_then(Value::as_object).into_iter().flatten() {
            let doc = schema.get("description").and_then(Value::as_str).unwrap_or_default();
            // A parameter with a documented type of its own may leave the words to it.
            assert!(doc.len() > 3 || schema.get("$ref").is_some(), "{}: {name} has no doc comment", spec.name);
        }
    });
}

#[test]
fn names_are_plain_and_told_apart() {
    each(|spec| {
        let plain =
            |s: &str, dash: char| s.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b as char == dash);
        assert!(plain(spec.name, '-'), "{}", spec.name);
        let mut seen: BTreeSet<String> = OWN_KEYS.iter().map(|k| (*k).to_owned()).collect();
        for name in spec.inputs.iter().map(|p| p.name.to_owned()).chain(parameter_names(spec)) {
            assert!(plain(&name, '_'), "{}: {name}", spec.name);
            assert!(
                seen.insert(name.clone()),
                "{}: `{name}` is a port, a parameter or the engine's own word twice",
                spec.name
            );
        }
        let mut seen = BTreeSet::new();
        assert!(spec.outputs.iter().all(|p| seen.insert(p.name)), "{}: two outputs of one name", spec.name);
        assert!(!spec.outputs.is_empty(), "{}: nothing comes out", spec.name);
    });
}

#[test]
fn defaults_parse_and_are_stable() {
    let registry = nodes::registry();
    for kind in registry.iter() {
        let (name, (_, required)) = (kind.spec().name, parameters(&kind.spec().params));
        assert!(required.is_empty(), "{name}: {required:?} have no default");
        // The file to read is the one thing that no default can name.
        let given = if name == "load-scene" { json!({ "path": "builtin:car" }) } else { json!({}) };
        let normal = kind.normalise(given).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(kind.normalise(normal.clone()).unwrap(), normal, "{name}");
        let names: BTreeSet<String> = normal.as_object().unwrap().keys().cloned().collect();
        assert_eq!(names, parameter_names(kind.spec()).into_iter().collect(), "{name}: schema and values differ");
        assert!(kind.normalise(json!({ "no such parameter": 1 })).is_err(), "{name}: deny_unknown_fields is missing");
    }
}
