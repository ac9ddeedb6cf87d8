//! The kinds as data: names, documentation, defaults.

use farfield::{
    engine::{
        node::KindSpec,
        pipeline::{OWN_KEYS, parameters},
        registry::Registry,
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
        assert!(about.len() > 20, "{}: its Params have no doc comment that says what it does", spec.title());
        for port in spec.inputs.iter().chain(&spec.outputs) {
            assert!(port.doc.len() > 3, "{}: port {} has no doc comment", spec.title(), port.name);
        }
        for (name, schema) in spec.params.get("properties").and_then(Value::as_object).into_iter().flatten() {
            let doc = schema.get("description").and_then(Value::as_str).unwrap_or_default();
            // A parameter with a documented type of its own may leave the words to it.
            assert!(doc.len() > 3 || schema.get("$ref").is_some(), "{}: {name} has no doc comment", spec.title());
        }
    });
}

#[test]
fn names_are_plain_and_told_apart() {
    each(|spec| {
        let plain =
            |s: &str, dash: char| s.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b as char == dash);
        assert!(plain(spec.name, '-') && plain(spec.method, '-'), "{}", spec.title());
        let mut seen: BTreeSet<String> = OWN_KEYS.iter().map(|k| (*k).to_owned()).collect();
        for name in spec.inputs.iter().map(|p| p.name.to_owned()).chain(parameter_names(spec)) {
            assert!(plain(&name, '_'), "{}: {name}", spec.title());
            assert!(
                seen.insert(name.clone()),
                "{}: `{name}` is a port, a parameter or the engine's own word twice",
                spec.title()
            );
        }
        let mut seen = BTreeSet::new();
        assert!(spec.outputs.iter().all(|p| seen.insert(p.name)), "{}: two outputs of one name", spec.title());
        assert!(!spec.outputs.is_empty(), "{}: nothing comes out", spec.title());
    });
}

#[test]
fn defaults_parse_and_are_stable() {
    let registry = nodes::registry();
    for kind in registry.iter() {
        let (name, (_, required)) = (kind.spec().title(), parameters(&kind.spec().params));
        assert!(required.is_empty(), "{name}: {required:?} have no default");
        // The file to read, the way to go and the box to cut out are what no default can name.
        let given = match &*name {
            "load-scene" => json!({ "path": "builtin:car" }),
            "view-region path" => json!({ "points": [[0, 0, 0]] }),
            "clip-scene" => json!({ "region": [[0, 0, 0], [1, 1, 1]] }),
            _ => json!({}),
        };
        let accept = |params: Value| kind.accept(params).map(|p| p.json().clone());
        let normal = accept(given).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(accept(normal.clone()).unwrap(), normal, "{name}");
        let names: BTreeSet<String> = normal.as_object().unwrap().keys().cloned().collect();
        assert_eq!(names, parameter_names(kind.spec()).into_iter().collect(), "{name}: schema and values differ");
        assert!(accept(json!({ "no such parameter": 1 })).is_err(), "{name}: deny_unknown_fields is missing");
    }
}

#[test]
fn old_names_and_planned_methods_are_told() {
    let registry = nodes::registry();
    let refused = |kind: &str, method: Option<&str>| registry.find(kind, method).err().map(|u| (u.message, u.help));
    for kind in registry.names() {
        let built: Vec<&str> = registry.methods(kind).map(|k| k.spec().method).collect();
        for method in registry.planned(kind) {
            assert!(!built.contains(method), "{kind} {method} is built: it is no longer planned");
            let (message, help) = refused(kind, Some(method)).unwrap();
            assert_eq!(message, format!("method `{method}` of `{kind}` is not built yet"));
            assert!(help.starts_with("built: `"), "{help}");
        }
    }
    let (message, help) = refused("select-direction", None).unwrap();
    assert_eq!(message, "kind `select-direction` has another name now");
    assert_eq!(help, "write kind = \"select-views\" and method = \"min-depth-complexity\"");
    assert!(registry.renamed("collapse", "policy").unwrap().contains("method = \"voxel-cover\""));
    let (message, help) = refused("collapse", None).unwrap();
    assert_eq!(message, "kind `collapse` needs a `method`");
    for kind in registry.methods("collapse") {
        let spec = kind.spec();
        assert!(help.contains(&format!("\n`{}`: {}", spec.method, &spec.summary()[..40])), "{help}");
    }
    assert_eq!(refused("load-scene", Some("x")).unwrap().0, "kind `load-scene` has no methods, `x` is named");
    assert!(refused("peel", Some("solids")).unwrap().1.starts_with("did you mean `solid`? "));
    assert!(refused("quadric", None).is_some());
}
