//! The kind and the method that each node says, and the keys that they have.

use super::{
    draft::{Draft, DraftNode},
    item::{Item, what},
    problem::Problem,
};
use crate::engine::{
    node::{Kind, PortSpec},
    registry::{About, Registry, Unknown},
    suggest,
    types::{self, Ty},
};
use serde_json::Value;
use std::{collections::BTreeMap, rc::Rc, sync::Arc};

/// Keys of a node that no kind may use as the name of a port or parameter.
pub const OWN_KEYS: [&str; 7] = ["kind", "method", "pipeline", "join", "cross", "per", "transient"];

/// A kind with its ports and parameters by name.
pub struct KindInfo {
    pub kind: Arc<dyn Kind>,
    pub ports: BTreeMap<&'static str, usize>,
    pub params: BTreeMap<String, Ty>,
    pub required: Vec<String>,
}

impl KindInfo {
    pub fn new(kind: &Arc<dyn Kind>) -> Self {
        let (params, required) = types::parameters(&kind.spec().params);
        let ports = kind.spec().inputs.iter().enumerate().map(|(i, p)| (p.name, i)).collect();
        Self { kind: Arc::clone(kind), ports, params, required }
    }

    pub fn inputs(&self) -> &[PortSpec] {
        &self.kind.spec().inputs
    }

    pub fn outputs(&self) -> &[PortSpec] {
        &self.kind.spec().outputs
    }

    /// Whether another method of the kind has a port or a parameter of this name.
    pub fn another_has(&self, key: &str, registry: &Registry) -> bool {
        let has = |kind: &Arc<dyn Kind>| {
            let spec = kind.spec();
            let params = spec.params.get("properties").and_then(Value::as_object);
            spec.inputs.iter().any(|port| port.name == key) || params.is_some_and(|params| params.contains_key(key))
        };
        registry.methods(self.kind.spec().name).any(has)
    }

    /// The problem of a key that is neither port nor parameter nor the engine's own.
    pub fn unknown_key(&self, key: &str, item: Item, registry: &Registry) -> Problem {
        let spec = self.kind.spec();
        if let Some(now) = registry.renamed(spec.name, key) {
            return old_parameter(spec.name, key, now, item);
        }
        let names = || self.ports.keys().copied().chain(self.params.keys().map(String::as_str));
        let mut parts = Vec::new();
        if !self.ports.is_empty() {
            parts.push(format!("the ports {}", suggest::list(self.ports.keys().copied())));
        }
        if !self.params.is_empty() {
            parts.push(format!("the parameters {}", suggest::list(self.params.keys().map(String::as_str))));
        }
        if parts.is_empty() {
            parts.push("neither ports nor parameters".to_owned());
        }
        let near = suggest::did_you_mean(key, names().chain(OWN_KEYS));
        let help = format!("{near}`{}` has {}", spec.title(), parts.join(" and "));
        Problem::at(item.key, format!("{} has no `{key}`", spec.phrase()), "no such port or parameter").help(help)
    }
}

fn old_parameter(kind: &str, key: &str, now: &str, item: Item) -> Problem {
    Problem::at(item.key, format!("kind `{kind}` has no `{key}` any more"), "an old parameter")
        .help(format!("write {now}"))
}

/// The kinds and methods that the nodes of one pipeline use.
pub struct Kinds<'s> {
    registry: &'s Registry,
    known: BTreeMap<(&'s str, Option<&'s str>), Rc<KindInfo>>,
}

impl<'s> Kinds<'s> {
    pub fn new(registry: &'s Registry) -> Self {
        Self { registry, known: BTreeMap::new() }
    }

    /// The kind that node `name` says, with its method.
    pub fn of(
        &mut self,
        name: &str,
        node: &DraftNode<'s>,
        draft: &Draft,
        problems: &mut Vec<Problem>,
    ) -> Option<Rc<KindInfo>> {
        let Some(item) = node.kind else {
            let others = draft.nodes.keys().copied().filter(|n| *n != name);
            let hint =
                if suggest::worthwhile(problems.len()) { suggest::did_you_mean(name, others) } else { String::new() };
            let help = format!("{hint}every node says its kind: kind = \"…\"; `farfield nodes` lists them");
            problems.push(Problem::at(node.place, format!("node `{name}` has no `kind`"), "no kind").help(help));
            return None;
        };
        let kind = text("kind", item, problems)?;
        let given = node.get("method");
        let method = match given {
            Some(item) => Some(text("method", item, problems)?),
            None => None,
        };
        if let Some(info) = self.known.get(&(kind, method)) {
            return Some(Rc::clone(info));
        }
        match self.registry.find(kind, method) {
            Ok(found) => {
                let info = Rc::new(KindInfo::new(found));
                self.known.insert((kind, method), Rc::clone(&info));
                Some(info)
            }
            Err(unknown) => {
                problems.push(self.unknown(kind, unknown, item, given, node));
                None
            }
        }
    }

    /// What a registry does not know, at the key that says it.
    fn unknown(&self, kind: &str, unknown: Unknown, item: Item, given: Option<Item>, node: &DraftNode) -> Problem {
        let Unknown { about, message, label, help } = unknown;
        let place = match (about, given) {
            (About::Method, Some(method)) => method.place,
            _ => item.place,
        };
        if about == About::NoMethod {
            // An older file chose the method by a parameter.
            for (key, item) in &node.keys {
                if let Some(now) = self.registry.renamed(kind, key) {
                    return old_parameter(kind, key, now, *item);
                }
            }
        }
        Problem::at(place, message, label).help(help)
    }
}

/// The text that the node's own key `key` must be.
fn text<'s>(key: &str, item: Item<'s>, problems: &mut Vec<Problem>) -> Option<&'s str> {
    let text = item.value.as_str();
    if text.is_none() {
        let message = format!("`{key}` is {}, expected text", what(item.value));
        problems.push(Problem::at(item.place, message, "not text").help(format!("{key} = \"…\"")));
    }
    text
}
