//! The JSON schema of whole pipeline files, for editors: completion, documentation and checks while one types.

use crate::engine::{
    node::{Arity, KindSpec, PortSpec},
    registry::Registry,
};
use serde_json::{Map, Value, json};

/// The schema of a pipeline file that uses the kinds of `registry`.
pub fn of(registry: &Registry) -> Value {
    let mut definitions = Map::new();
    let names = registry.names();
    let mut kinds: Vec<Value> = names.iter().filter_map(|name| method(registry, name)).collect();
    kinds.extend(registry.iter().map(|kind| {
        let spec = kind.spec();
        let own = definition(spec);
        let local = spec.params.get("$defs").and_then(Value::as_object);
        for (name, schema) in local.into_iter().flatten() {
            definitions.insert(format!("{own}.{name}"), localise(schema, &own));
        }
        let only = registry.methods(spec.name).count() == 1;
        let mut chosen = json!({ "required": ["kind"], "properties": { "kind": { "const": spec.name } } });
        if !spec.method.is_empty() {
            chosen["properties"]["method"] = json!({ "const": spec.method });
        }
        if !only {
            chosen["required"] = json!(["kind", "method"]);
        }
        let chosen = json!({ "if": chosen, "then": { "$ref": format!("#/$defs/{own}") } });
        definitions.insert(own, node(spec));
        chosen
    }));
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
                "properties": {
                    "kind": { "type": "string", "enum": names },
                    "pipeline": text("A stock pipeline, or a file, that stands in the node's place; the other keys are its inputs and knobs.")
                },
                "allOf": kinds
            })) },
            "inputs": { "type": "object", "description": "Values that a parent pipeline may plug in.",
                "additionalProperties": or_removed(json!({
                    "type": "object", "additionalProperties": false, "required": ["type"],
                    "properties": { "type": text("The type of the values, such as Scene."), "default": reference.clone() }
                })) },
            "outputs": { "type": "object", "description": "Values that a parent pipeline can use.",
                "additionalProperties": or_removed(reference.clone()) },
            "files": { "type": "object", "description": "Path below `out/NAME/` to an output of type File; {name} stands for an element's name.",
                "additionalProperties": or_removed(reference) },
            "batch": { "description": "Bakes the pipeline several times: lists of values give every combination, tables give the bakes one by one.", "anyOf": [
                { "type": "object", "additionalProperties": { "type": "array", "minItems": 1, "description": "Values of a knob, or of \"node.param\"." } },
                { "type": "array", "items": { "type": "object", "properties": { "name": text("Names the bake's folder.") } } }
            ] },
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

/// The definition's name: the kind's, and the method's behind a dot.
fn definition(spec: &KindSpec) -> String {
    spec.title().replace(' ', ".")
}

/// Which methods the kind has and, where they are several, that one must be chosen.
fn method(registry: &Registry, kind: &str) -> Option<Value> {
    let specs: Vec<&KindSpec> = registry.methods(kind).map(|k| k.spec()).filter(|s| !s.method.is_empty()).collect();
    let about: Vec<String> = specs.iter().map(|s| format!("{}: {}", s.method, s.summary())).collect();
    let required: &[&str] = if specs.len() > 1 { &["method"] } else { &[] };
    let methods: Vec<&str> = specs.iter().map(|s| s.method).collect();
    (!specs.is_empty()).then(|| {
        json!({
            "if": { "required": ["kind"], "properties": { "kind": { "const": kind } } },
            "then": {
                "properties": { "method": { "enum": methods, "description": about.join("\n\n") } },
                "required": required
            }
        })
    })
}

/// The table of a node of this kind and method.
fn node(spec: &KindSpec) -> Value {
    let mut properties = Map::new();
    properties.insert("kind".into(), json!({ "const": spec.name, "description": spec.about() }));
    if !spec.method.is_empty() {
        properties.insert("method".into(), json!({ "const": spec.method, "description": spec.about() }));
    }
    properties.insert(
        "join".into(),
        json!({ "enum": ["exact", "inner"], "description": "What happens to elements that one side of a join lacks." }),
    );
    properties.insert(
        "cross".into(),
        json!({ "type": "boolean", "description": "Run for every pair of elements of lists that share none." }),
    );
    let about = "Do not keep the outputs: other nodes take them from memory, and what is needed later is made again.";
    properties.insert("transient".into(), json!({ "type": "boolean", "description": about }));
    properties.insert("per".into(), json!({ "type": "array", "items": { "type": "string" }, "description": "Lists that list ports do not gather." }));
    for port in &spec.inputs {
        properties.insert(port.name.to_owned(), port_schema(port));
    }
    let params = spec.params.get("properties").and_then(Value::as_object);
    for (name, schema) in params.into_iter().flatten() {
        let mut outer = json!({ "anyOf": [localise(schema, &definition(spec)), knob()] });
        for key in ["description", "default"] {
            if let Some(value) = schema.get(key) {
                outer[key] = value.clone();
            }
        }
        properties.insert(name.clone(), outer);
    }
    json!({ "type": "object", "description": spec.about(), "additionalProperties": false, "properties": properties })
}

fn port_schema(port: &PortSpec) -> Value {
    let many = if matches!(port.arity, Arity::Many { .. }) { "list of " } else { "" };
    let reference = json!({ "type": "string", "pattern": "^[A-Za-z0-9_/-]+(\\.[A-Za-z0-9_]+)?$" });
    let mut ways = vec![
        reference.clone(),
        json!({ "type": "object", "additionalProperties": false, "required": ["from"],
            "properties": { "from": reference, "via": reference } }),
    ];
    if !many.is_empty() {
        // Several outputs under names of their own.
        ways.push(json!({ "type": "object", "minProperties": 1, "additionalProperties": reference,
            "not": { "anyOf": [{ "required": ["from"] }, { "required": ["via"] }] } }));
    }
    json!({ "description": format!("{} ({many}{})", port.doc, port.ty.name), "anyOf": ways })
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

    #[test]
    fn every_key_of_every_node_is_documented() {
        let schema = of(&crate::nodes::registry());
        let mut count = 0;
        for (node, definition) in schema["$defs"].as_object().unwrap() {
            for (key, value) in definition.get("properties").and_then(Value::as_object).into_iter().flatten() {
                // A parameter of a documented type of its own may leave the words to it.
                let told = value.get("description").and_then(Value::as_str).is_some_and(|d| d.len() > 3);
                let of_type = value["anyOf"].as_array().is_some_and(|any| any.iter().any(|s| s.get("$ref").is_some()));
                assert!(told || of_type, "{node}: {key}");
                count += 1;
            }
        }
        assert!(count > 500, "{count}");
    }

    /// What `then` of the schema's conditions for nodes holds for a node of these keys.
    fn chosen<'s>(schema: &'s Value, node: &Value) -> Vec<&'s Value> {
        let all =
            schema.pointer("/properties/nodes/additionalProperties/anyOf/0/allOf").and_then(Value::as_array).unwrap();
        let holds = |condition: &Value| {
            let required =
                condition["required"].as_array().unwrap().iter().all(|key| node.get(key.as_str().unwrap()).is_some());
            let same = |(key, schema): (&String, &Value)| node.get(key).is_none_or(|v| *v == schema["const"]);
            required && condition["properties"].as_object().unwrap().iter().all(same)
        };
        all.iter().filter(|c| holds(&c["if"])).map(|c| &c["then"]).collect()
    }

    #[test]
    fn a_method_decides_what_a_node_may_say() {
        let registry = crate::nodes::registry();
        let schema = of(&registry);
        for kind in registry.names() {
            let methods: Vec<&str> = registry.methods(kind).map(|k| k.spec().method).collect();
            for method in &methods {
                let node =
                    if method.is_empty() { json!({ "kind": kind }) } else { json!({ "kind": kind, "method": method }) };
                let then = chosen(&schema, &node);
                let pages: Vec<&str> = then.iter().filter_map(|t| t["$ref"].as_str()).collect();
                let name = format!("{kind} {method}").trim().replace(' ', ".");
                assert_eq!(pages, [format!("#/$defs/{name}")]);
                if !method.is_empty() {
                    let offered = then.iter().find_map(|t| t.pointer("/properties/method/enum")).unwrap();
                    assert_eq!(offered, &json!(methods));
                }
            }
            // Without a method: the only one, or a demand for one.
            let then = chosen(&schema, &json!({ "kind": kind }));
            let demanded = then.iter().any(|t| t["required"] == json!(["method"]));
            assert_eq!(
                (then.iter().filter(|t| t["$ref"].is_string()).count(), demanded),
                if methods.len() == 1 { (1, false) } else { (0, true) }
            );
        }
    }
}
