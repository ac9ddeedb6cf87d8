//! Nodes against their kinds: every key is a port, a parameter or one of the engine's own words, every reference names
//! an output of the right type.

use super::{
    draft::{Draft, DraftNode},
    item::{Item, what},
    judge,
    kind::{KindInfo, Kinds, OWN_KEYS},
    problem::Problem,
    source::{Sources, TextSpan},
    value::Values,
};
use crate::engine::{node::Parameters, registry::Registry, types::Ty};
use serde_json::{Map, Value};
use std::rc::Rc;
use toml::de::DeValue;

/// An output as the draft numbers nodes: those of `Links::nodes`.
pub type Output = (usize, u32);

/// A wired input port.
#[derive(Clone, Default)]
pub struct Input {
    /// What feeds it. `None`: absent, or wrong and reported.
    pub from: Option<Output>,
    pub via: Option<Output>,
    pub place: TextSpan,
}

/// A node whose keys have been told apart.
pub struct Link<'s> {
    pub name: &'s str,
    /// The list port of the node called `name` for which it collects several outputs; no reference can name such a node.
    pub of_port: Option<&'static str>,
    pub order: (u32, u32),
    /// The part that it belongs to.
    pub part: usize,
    /// `None` where the kind or its method is missing or unknown, which is reported.
    pub info: Option<Rc<KindInfo>>,
    /// `None` where they are wrong, which is reported.
    pub params: Option<Parameters>,
    pub inputs: Vec<Input>,
    /// Some input is wrong, so that nothing can be said of the node's axes.
    pub broken: bool,
    pub join_inner: bool,
    pub cross: Option<TextSpan>,
    /// Where it says so.
    pub transient: Option<TextSpan>,
    pub per: Vec<(&'s str, TextSpan)>,
}

/// All nodes.
pub struct Links<'s> {
    /// Those of the file sorted by name, then those that collect for a port.
    pub nodes: Vec<Link<'s>>,
    /// How many are of the file.
    pub named: usize,
    pub draft: &'s Draft<'s>,
    pub sources: &'s Sources,
    pub registry: &'s Registry,
    /// What is allowed but can hardly be meant.
    pub doubts: Vec<(TextSpan, String)>,
}

/// Tells the keys of all nodes apart.
pub fn link<'s>(
    draft: &'s Draft<'s>,
    registry: &'s Registry,
    values: &Values<'s>,
    everywhere: &[(&str, Value)],
    problems: &mut Vec<Problem>,
) -> Links<'s> {
    let mut kinds = Kinds::new(registry);
    let mut nodes: Vec<Link> = Vec::with_capacity(draft.nodes.len());
    for (name, node) in &draft.nodes {
        let info = kinds.of(name, node, draft, problems);
        nodes.push(Link {
            name,
            of_port: None,
            order: node.order,
            part: values.sources.get(node.place).part,
            params: None,
            inputs: info.as_ref().map_or_else(Vec::new, |i| vec![Input::default(); i.inputs().len()]),
            broken: info.is_none(),
            info,
            join_inner: false,
            cross: None,
            transient: None,
            per: Vec::new(),
        });
    }
    let named = nodes.len();
    let mut links = Links { nodes, named, draft, sources: values.sources, registry, doubts: Vec::new() };
    let needed = links.needed();
    for (at, node) in draft.nodes.values().enumerate() {
        if let Some(info) = links.nodes[at].info.clone().filter(|_| needed[at]) {
            links.keys(at, node, &info, values, everywhere, problems);
        }
    }
    links.keep(&needed);
    links
}

impl<'s> Links<'s> {
    /// The nodes' names.
    pub fn names(&self) -> impl Iterator<Item = &'s str> + Clone {
        self.nodes[..self.named].iter().map(|node| node.name)
    }

    /// Lists that node `at` does not gather, because its part stands for a node that does not.
    pub fn per_above(&self, at: usize) -> impl Iterator<Item = (&'s str, TextSpan)> + use<'s> {
        let draft = self.draft;
        draft.parts[self.nodes[at].part].per.iter().copied()
    }

    /// Which nodes have a use: all of the pipeline itself, and of its parts those that something of use reads.
    fn needed(&self) -> Vec<bool> {
        let mut needed = vec![self.draft.parts.len() == 1; self.nodes.len()];
        if self.draft.parts.len() == 1 {
            return needed;
        }
        let leaving = self.draft.files.values().chain(self.draft.outputs.values()).copied();
        let mut asked: Vec<Item> = leaving.collect();
        let own = (0..self.nodes.len()).filter(|at| self.nodes[*at].part == 0);
        let mut open: Vec<usize> = own.collect();
        let nodes: Vec<&DraftNode> = self.draft.nodes.values().collect();
        loop {
            while let Some(item) = asked.pop() {
                let named = item.value.as_str().and_then(|text| self.known(text, item.place));
                open.extend(named.map(|(node, _)| node));
            }
            let Some(at) = open.pop() else { return needed };
            if std::mem::replace(&mut needed[at], true) {
                continue;
            }
            let Some(info) = &self.nodes[at].info else { continue };
            for (_, item) in nodes[at].keys.iter().filter(|(key, _)| info.ports.contains_key(key)) {
                let inner = |value: &'s toml::Spanned<DeValue<'s>>| {
                    let place = TextSpan::new(item.place.source, value.span());
                    Item { key: place, value: value.get_ref(), place }
                };
                match item.value {
                    DeValue::Table(table) => asked.extend(table.values().map(inner)),
                    _ => asked.push(*item),
                }
            }
        }
    }

    /// Leaves out nodes without use.
    fn keep(&mut self, needed: &[bool]) {
        // Those that collect were only added to nodes of use.
        let collecting = std::iter::repeat_n(&true, self.nodes.len() - self.named);
        let kept: Vec<bool> = needed.iter().chain(collecting).copied().collect();
        let number: Vec<usize> =
            kept.iter().scan(0, |n, kept| Some(std::mem::replace(n, *n + usize::from(*kept)))).collect();
        self.named = needed.iter().filter(|kept| **kept).count();
        let mut at = 0..;
        self.nodes.retain(|_| at.next().is_some_and(|at| kept[at]));
        for input in self.nodes.iter_mut().flat_map(|node| &mut node.inputs) {
            for (node, _) in [&mut input.from, &mut input.via].into_iter().flatten() {
                *node = number[*node];
            }
        }
    }

    fn keys(
        &mut self,
        at: usize,
        node: &DraftNode<'s>,
        info: &KindInfo,
        values: &Values<'s>,
        everywhere: &[(&str, Value)],
        problems: &mut Vec<Problem>,
    ) {
        let (before, collecting) = (problems.len(), self.nodes.len());
        let mut params = Map::new();
        let mut given: Vec<(usize, Item)> = Vec::new();
        for (key, item) in &node.keys {
            if let Some(port) = info.ports.get(key) {
                given.push((*port, *item));
                let spec = &info.inputs()[*port];
                let input = match self.collected(spec, *item) {
                    Some(table) => self.collect(at, spec, *item, table, problems),
                    None => self.input(at, spec, *item, problems),
                };
                self.nodes[at].broken |= input.from.is_none();
                self.nodes[at].inputs[*port] = input;
            } else if let Some(ty) = info.params.get(*key) {
                if let Some(value) = values.convert(key, *item, ty, problems) {
                    params.insert((*key).to_owned(), value);
                }
            } else if OWN_KEYS.contains(key) {
                self.own_key(at, key, *item, problems);
            } else if node.inherited.contains(key) && info.another_has(key, self.registry) {
                // It was given for another method.
                values.pass_over(item.value);
            } else {
                problems.push(info.unknown_key(key, *item, self.registry));
            }
        }
        // What a list port does not gather, what collects for it does not either.
        let per = self.nodes[at].per.clone();
        for collecting in self.nodes.iter_mut().skip(collecting) {
            collecting.per.clone_from(&per);
        }
        let name = self.nodes[at].name;
        for (port, spec) in info.inputs().iter().enumerate() {
            if !spec.arity.may_be_absent() && !given.iter().any(|g| g.0 == port) {
                self.nodes[at].broken = true;
                let message = format!("node `{name}` has no `{}`", spec.name);
                let label = format!("{} needs the port `{}`", info.kind.spec().phrase(), spec.name);
                let help = format!("{} = \"…\", {}", spec.name, self.sources_of(at, spec));
                problems.push(Problem::at(node.place, message, label).help(help));
            }
        }
        for param in &info.required {
            if !node.keys.iter().any(|(key, _)| key == param) {
                let message = format!("node `{name}` has no `{param}`");
                let label = format!("{} needs the parameter `{param}`", info.kind.spec().phrase());
                let wanted = info.params.get(param).map(Ty::describe).unwrap_or_default();
                problems.push(Problem::at(node.place, message, label).help(format!("{param} = …, {wanted}")));
            }
        }
        for (key, value) in everywhere.iter().filter(|(key, _)| info.params.contains_key(*key)) {
            params.insert((*key).to_owned(), value.clone());
        }
        if problems.len() == before {
            let judged = judge::judge(name, node, info, Value::Object(params), values, &mut self.doubts, problems);
            self.nodes[at].params = judged;
        }
    }

    fn own_key(&mut self, at: usize, key: &str, item: Item<'s>, problems: &mut Vec<Problem>) {
        let mut wrong = |place: TextSpan, wanted: &str, found: &DeValue| {
            let message = format!("`{key}` is {}, expected {wanted}", what(found));
            problems.push(Problem::at(place, message, format!("found {}", what(found))));
        };
        let node = &mut self.nodes[at];
        match (key, item.value) {
            ("cross", DeValue::Boolean(on)) => node.cross = on.then_some(item.place),
            ("transient", DeValue::Boolean(on)) => node.transient = on.then_some(item.place),
            ("cross" | "transient", other) => wrong(item.place, "true or false", other),
            ("join", DeValue::String(s)) if s == "inner" || s == "exact" => node.join_inner = s == "inner",
            ("join", DeValue::String(s)) => problems.push(
                Problem::at(item.place, format!("`join` cannot be \"{s}\""), "no such join").help(
                    "\"exact\" (the default): a name missing on one side is an error; \"inner\": such elements are dropped",
                ),
            ),
            ("join", other) => wrong(item.place, "\"exact\" or \"inner\"", other),
            ("per", DeValue::Array(names)) => {
                for entry in names {
                    let place = TextSpan::new(item.place.source, entry.span());
                    match entry.get_ref() {
                        DeValue::String(s) => node.per.push((s, place)),
                        other => wrong(place, "the name of a list output, in quotes", other),
                    }
                }
            }
            ("per", other) => wrong(item.place, "a list such as [\"cells\"]", other),
            _ => {}
        }
    }
}
