//! The JSON schema of whole pipeline files, for editors: completion, documentation and checks while one types.

use super::nodes::about;
use crate::engine::node::{Arity, KindSpec, PortSpec, Registry};
use serde_json::{Map, Value, json};

/// The schema of a pipeline file that uses the kinds of `registry`.
pub fn of(registry: &Registry) -> Value {
    let mut definitions = Map::new();
    let names: Vec<&str> = registry.iter().map(|k| k.spec().name).collect();
    let kinds: Vec<Value> = registry
        .iter()
        .map(|kind| {
            let spec = kind.spec();
            definitions.insert(spec.name.to_owned(), node(spec, &mut Map::new()));
            let local = spec.params.get("$defs").and_then(Value::as_object);
            for (name, schema) in local.into_iter().flatten() {
                definitions.insert(format!("{}.{name}", spec.name), localise(schema, spec.name));
            }
            json!({
                "if": { "required": ["kind"], "properties": { "kind": { "const": spec.name } } },
                "then": { "$ref": format!("#/$defs/{}", spec.name) }
            })
        })
        .collect();
    let text = |about: &str| json!({ "type": "string", "description": about });
    let reference = json!({ "type": "string", "description": "`node` or `node.output`" });
    let or_removed =
        |schema: Value| json!({ "anyOf": [schema, { "const": false, "description": "Removes the base's." }] });
    let number = json!({ "anyOf": [{ "type": "number" }, knob()] });
    let bound = json!({ "anyOf": [number, {
        "type": "object", "additionalProperties": false, "properties": { "min": number, "max": number }
    }] });
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "farfield pipeline",
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "pipeline": { "type": "object", "additionalProperties": false, "properties": {
                "name": text("Names the folder below `out/`; the file's name where it is left out."),
                "about": text("What comes out, in a sentence."),
                "base": text("A stock pipeline, or a file, that this one changes.")
            } },
            "params": { "type": "object", "description": "Knobs: nodes refer to them as \"{name}\", `--set name=value` changes them." },
            "nodes": { "type": "object", "additionalProperties": or_removed(json!({
                "type": "object",
                "properties": { "kind": { "type": "string", "enum": names } },
                "allOf": kinds
            })) },
            "outputs": { "type": "object", "description": "Values that a parent pipeline can use.",
                "additionalProperties": or_removed(reference.clone()) },
            "files": { "type": "object", "description": "Path below `out/NAME/` to an output of type File; {name} stands for an element's name.",
                "additionalProperties": or_removed(reference) },
            "require": { "type": "object", "description": "Bounds on the certificate of a node.", "additionalProperties":
                or_removed(json!({ "type": "object", "additionalProperties": or_removed(bound) })) }
        },
        "$defs": definitions
    })
}

/// A reference to a knob.
fn knob() -> Value {
    json!({ "type": "string", "pattern": "^\\{[A-Za-z0-9_-]+\\}$", "description": "A knob of [params]." })
}

/// The table of a node of this kind.
fn node(spec: &KindSpec, properties: &mut Map<String, Value>) -> Value {
    properties.insert("kind".into(), json!({ "const": spec.name, "description": about(spec) }));
    properties.insert(
        "join".into(),
        json!({ "enum": ["exact", "inner"], "description": "What happens to elements that one side of a join lacks." }),
    );
    properties.insert(
        "cross".into(),
        json!({ "type": "boolean", "description": "Run for every pair of elements of lists that share none." }),
    );
    properties.insert("per".into(), json!({ "type": "array", "items": { "type": "string" }, "description": "Lists that list ports do not gather." }));
    for port in &spec.inputs {
        properties.insert(port.name.to_owned(), port_schema(port));
    }
    let params = spec.params.get("properties").and_then(Value::as_object);
    for (name, schema) in params.into_iter().flatten() {
        let mut outer = json!({ "anyOf": [localise(schema, spec.name), knob()] });
        for key in ["description", "default"] {
            if let Some(value) = schema.get(key) {
                outer[key] = value.clone();
            }
        }
        properties.insert(name.clone(), outer);
    }
    json!({ "type": "object", "description": about(spec), "additionalProperties": false, "properties": properties })
}

fn port_schema(port: &PortSpec) -> Value {
    let many = if matches!(port.arity, Arity::Many { .. }) { "list of " } else { "" };
    let reference = json!({ "type": "string", "pattern": "^[A-Za-z0-9_/-]+(\\.[A-Za-z0-9_]+)?$" });
    json!({
        "description": format!("{} ({many}{})", port.doc, port.ty.name),
        "anyOf": [reference, { "type": "object", "additionalProperties": false, "required": ["from"],
            "properties": { "from": reference, "via": reference } }]
    })
}

/// `schema` with its references to the kind's definitions turned into ours.
fn localise(schema: &Value, kind: &str) -> Value {
    match schema {
        Value::Object(map) => Value::Object(
            map.iter()
                .map(|(key, value)| {
                    let target = value.as_str().filter(|_| key == "$ref").and_then(|r| r.strip_prefix("#/$defs/"));
                    let value =
                        target.map_or_else(|| localise(value, kind), |name| json!(format!("#/$defs/{kind}.{name}")));
                    (key.clone(), value)
                })
                .collect(),
        ),
        Value::Array(items) => Value::Array(items.iter().map(|item| localise(item, kind)).collect()),
        other => other.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn references<'a>(value: &'a Value, found: &mut Vec<&'a str>) {
        match value {
            Value::Object(map) => map.iter().for_each(|(key, value)| match value.as_str() {
                Some(target) if key == "$ref" => found.push(target),
                _ => references(value, found),
            }),
            Value::Array(items) => items.iter().for_each(|item| references(item, found)),
            _ => {}
        }
    }

    #[test]
    fn every_reference_leads_somewhere() {
        let schema = of(&crate::nodes::registry());
        let mut found = Vec::new();
        references(&schema, &mut found);
        for target in found {
            // Names of definitions hold no `/` or `~`, so a pointer needs no escapes.
            assert!(schema.pointer(&target[1..]).is_some(), "{target}");
        }
    }
}
