//! One pipeline out of its layers: what a file says stands over what its base says.
//!
//! A derived file's key replaces the base's key of the same name; a node whose `kind` changes loses the base's other
//! keys, one whose `method` changes those that the new method has not; `false` in place of a node, a published file or a
//! requirement removes the base's.

use super::{
    item::{Item, Items, Setting, references, valid_name, what},
    problem::Problem,
    read::Layer,
    scope::Part,
    source::TextSpan,
};
use crate::engine::suggest;
use std::collections::BTreeMap;
use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

/// A node as the layers together write it.
pub struct DraftNode<'s> {
    /// Its name where a layer last wrote about it.
    pub place: TextSpan,
    /// Orders nodes: the layer of the base first, then the place in the text.
    pub order: (u32, u32),
    pub kind: Option<Item<'s>>,
    /// In the order of the keys' names.
    pub keys: Vec<(&'s str, Item<'s>)>,
    /// Keys that were given before the node's method changed. The method that it has now may not know them.
    pub inherited: Vec<&'s str>,
}

/// A node that stands for a part.
pub struct Host<'s> {
    pub node: DraftNode<'s>,
    /// The part's number; `None` where it was not found, which is reported.
    pub part: Option<usize>,
}

/// The merged layers, sections checked, contents not.
#[derive(Default)]
pub struct Draft<'s> {
    pub name: Option<Item<'s>>,
    pub about: Option<Item<'s>>,
    pub knobs: Items<'s>,
    pub nodes: BTreeMap<&'s str, DraftNode<'s>>,
    /// `[batch]`, of the last layer that has one.
    pub batch: Option<Item<'s>>,
    /// `[inputs]`, until the draft is joined with those of its parts.
    pub inputs: Items<'s>,
    pub outputs: Items<'s>,
    pub files: Items<'s>,
    /// The pipeline itself, whose knobs and outputs are those above, and its parts.
    pub parts: Vec<Part<'s>>,
    /// Nodes that stand for parts.
    pub hosts: BTreeMap<&'s str, Host<'s>>,
    /// Knobs that only overruled values refer to.
    pub overruled: Vec<&'s str>,
    /// Per node, its requirements by path.
    pub require: BTreeMap<&'s str, (TextSpan, Items<'s>)>,
}

const SECTIONS: [&str; 8] = ["pipeline", "params", "inputs", "nodes", "outputs", "files", "require", "batch"];

/// Merges `layers`, the base-most first.
pub fn merge<'s>(layers: &'s [Layer<'s>], problems: &mut Vec<Problem>) -> Draft<'s> {
    let mut draft = Draft::default();
    for (rank, layer) in layers.iter().enumerate() {
        for (key, value) in &layer.table {
            let item = item(layer.source, key, value);
            match &**key.get_ref() {
                "pipeline" => header(&mut draft, item, rank + 1 == layers.len(), problems),
                "params" => draft.knobs.extend(entries(item, "params", "name = value", problems)),
                "nodes" => nodes(&mut draft, item, rank, problems),
                "outputs" => overlay(&mut draft.outputs, item, "outputs", "name = \"node.output\"", rank, problems),
                "files" => overlay(&mut draft.files, item, "files", "\"path\" = \"node.output\"", rank, problems),
                "batch" => draft.batch = Some(item),
                "require" => require(&mut draft, item, rank, problems),
                "inputs" => overlay(&mut draft.inputs, item, "inputs", "name = { type = \"Scene\" }", rank, problems),
                other => problems.push(
                    Problem::at(item.key, format!("unknown section `{other}`"), "no such section").help(format!(
                        "{}a pipeline file has the sections {}",
                        suggest::did_you_mean(other, SECTIONS),
                        suggest::list(SECTIONS)
                    )),
                ),
            }
        }
    }
    draft
}

fn item<'s>(source: u32, key: &Spanned<std::borrow::Cow<'s, str>>, value: &'s Spanned<DeValue<'s>>) -> Item<'s> {
    Item { key: TextSpan::new(source, key.span()), value: value.get_ref(), place: TextSpan::new(source, value.span()) }
}

/// The table that `item` must be.
fn table<'s>(item: Item<'s>, name: &str, problems: &mut Vec<Problem>) -> Option<&'s DeTable<'s>> {
    let table = item.value.as_table();
    if table.is_none() {
        let message = format!("`{name}` is {}, expected a table", what(item.value));
        problems.push(Problem::at(item.place, message, "not a table").help(format!("write it as [{name}]")));
    }
    table
}

/// The entries of the section `item`; a section written as something else is a problem.
fn entries<'s>(
    item: Item<'s>,
    section: &str,
    form: &str,
    problems: &mut Vec<Problem>,
) -> impl Iterator<Item = (&'s str, Item<'s>)> + use<'s> {
    let table = item.value.as_table();
    if table.is_none() {
        let message = format!("`{section}` is {}, expected a table", what(item.value));
        let help = format!("write the header [{section}], and below it lines of {form}");
        problems.push(Problem::at(item.place, message, "not a table").help(help));
    }
    let source = item.place.source;
    table.into_iter().flatten().map(move |(k, v)| (&**k.get_ref(), self::item(source, k, v)))
}

fn header<'s>(draft: &mut Draft<'s>, section: Item<'s>, top: bool, problems: &mut Vec<Problem>) {
    const KEYS: [&str; 3] = ["name", "about", "base"];
    for (name, item) in entries(section, "pipeline", "name = \"…\"", problems) {
        if !KEYS.contains(&name) {
            let help = format!("{}[pipeline] has {}", suggest::did_you_mean(name, KEYS), suggest::list(KEYS));
            problems
                .push(Problem::at(item.key, format!("unknown key `{name}` in [pipeline]"), "no such key").help(help));
        } else if item.value.as_str().is_none() {
            let message = format!("`{name}` is {}, expected text", what(item.value));
            problems.push(Problem::at(item.place, message, "not text").help(format!("{name} = \"…\"")));
        } else if name == "name" && top {
            // A derived pipeline has its own name, or two of one base would share an output folder.
            draft.name = Some(item);
        } else if name == "about" {
            draft.about = Some(item);
        }
    }
}

/// Entries over those of the layers below; `false` removes one of theirs.
fn overlay<'s>(
    into: &mut Items<'s>,
    section: Item<'s>,
    name: &str,
    form: &str,
    rank: usize,
    problems: &mut Vec<Problem>,
) {
    for (key, item) in entries(section, name, form, problems) {
        if rank > 0 && item.value.as_bool() == Some(false) {
            if into.remove(key).is_none() {
                problems.push(nothing_to_remove(key, item, into.keys().copied()));
            }
        } else {
            into.insert(key, item);
        }
    }
}

fn nothing_to_remove<'a>(key: &str, item: Item, known: impl IntoIterator<Item = &'a str>) -> Problem {
    Problem::at(item.key, format!("nothing to remove: the base has no `{key}`"), "not in the base")
        .help(suggest::did_you_mean(key, known))
}

fn nodes<'s>(draft: &mut Draft<'s>, section: Item<'s>, rank: usize, problems: &mut Vec<Problem>) {
    for (name, item) in entries(section, "nodes.NAME", "kind = \"…\" and the node's ports and parameters", problems) {
        if rank > 0 && item.value.as_bool() == Some(false) {
            if draft.nodes.remove(name).is_none() {
                problems.push(nothing_to_remove(name, item, draft.nodes.keys().copied()));
            }
            continue;
        }
        let Some(table) = table(item, &format!("nodes.{name}"), problems) else { continue };
        if !valid_name(name) {
            let help = "at most 128 letters, digits, `-` and `_`: references write `node.output`";
            problems.push(Problem::at(item.key, format!("`{name}` is no name for a node"), "not a name").help(help));
            continue;
        }
        let node = draft.nodes.entry(name).or_insert_with(|| DraftNode {
            place: item.key,
            order: (rank as u32, item.key.start),
            kind: None,
            keys: Vec::with_capacity(table.len()),
            inherited: Vec::new(),
        });
        node.place = item.key;
        let source = item.place.source;
        if let Some((k, v)) = table.iter().find(|(k, _)| k.get_ref() == "kind") {
            let kind = self::item(source, k, v);
            if node.kind.is_some_and(|old| old.value.as_str() != kind.value.as_str()) {
                node.keys.clear();
            }
            node.kind = Some(kind);
        }
        if let Some((_, v)) = table.iter().find(|(k, _)| k.get_ref() == "method") {
            node.inherit(v.get_ref(), |_| true);
        }
        let fresh = node.keys.is_empty();
        for (k, v) in table.iter().filter(|(k, _)| k.get_ref() != "kind") {
            let (key, item) = (&**k.get_ref(), self::item(source, k, v));
            if fresh {
                node.keys.push((key, item));
            } else {
                node.set(key, item);
            }
        }
    }
}

impl<'s> DraftNode<'s> {
    /// Where `method` is another one than before, the keys that `which` picks were given for that.
    fn inherit(&mut self, method: &DeValue, which: impl Fn(&Item) -> bool) {
        if self.get("method").and_then(|old| old.value.as_str()) != method.as_str() {
            self.inherited = self.keys.iter().filter(|(_, item)| which(item)).map(|(key, _)| *key).collect();
        }
    }

    /// Sets a key; returns what it held.
    fn set(&mut self, key: &'s str, item: Item<'s>) -> Option<Item<'s>> {
        self.inherited.retain(|k| *k != key);
        match self.keys.binary_search_by_key(&key, |(k, _)| k) {
            Ok(at) => Some(std::mem::replace(&mut self.keys[at].1, item)),
            Err(at) => {
                self.keys.insert(at, (key, item));
                None
            }
        }
    }

    pub fn get(&self, key: &str) -> Option<Item<'s>> {
        self.keys.binary_search_by(|(k, _)| (*k).cmp(key)).ok().map(|at| self.keys[at].1)
    }
}

fn require<'s>(draft: &mut Draft<'s>, section: Item<'s>, rank: usize, problems: &mut Vec<Problem>) {
    for (node, item) in entries(section, "require.NODE", "\"path\" = { max = 0 }", problems) {
        if rank > 0 && item.value.as_bool() == Some(false) {
            if draft.require.remove(node).is_none() {
                problems.push(nothing_to_remove(node, item, draft.require.keys().copied()));
            }
            continue;
        }
        if !item.value.is_table() {
            let message = format!("`require.{node}` is {}, expected a table", what(item.value));
            let help = format!("write the header [require.{node}], and below it lines of \"path\" = {{ max = 0 }}");
            problems.push(Problem::at(item.place, message, "not a table").help(help));
            continue;
        }
        let entry = draft.require.entry(node).or_insert_with(|| (item.key, Items::new()));
        entry.0 = item.key;
        overlay(&mut entry.1, item, &format!("require.{node}"), "\"path\" = { max = 0 }", rank, problems);
    }
}

/// Applies settings, those of a batch's row or the `--set` arguments. `owners` names the nodes whose kind has a given parameter.
pub fn apply<'s>(
    draft: &mut Draft<'s>,
    settings: &[Setting<'s>],
    owners: impl Fn(&Draft, &str) -> Vec<String>,
    problems: &mut Vec<Problem>,
) {
    for Setting { path, value, place, from } in settings {
        let (value, at) = (*value, *place);
        let item = |key: TextSpan| Item { key, value, place: at };
        match path[..] {
            [(name, place)] => match draft.knobs.get_mut(name) {
                Some(knob) => *knob = item(place),
                None => {
                    let mut help = suggest::did_you_mean(name, draft.knobs.keys().copied());
                    if let Some(owner) = owners(draft, name).first() {
                        help = match *from {
                            "--set" => format!("did you mean `--set {owner}.{name}=…`? "),
                            _ => format!("did you mean \"{owner}.{name}\" = …? "),
                        };
                    }
                    help += &format!("the knobs of this pipeline are {}", suggest::list(draft.knobs.keys().copied()));
                    problems.push(Problem::at(place, format!("{from}: no knob `{name}`"), "no such knob").help(help));
                }
            },
            [(_, place), ("pipeline", _)] => {
                let help = "write it into the file, or bake that pipeline itself";
                let message = format!("{from}: the pipeline of a node cannot be given by {from}");
                problems.push(Problem::at(place, message, "not to be set").help(help));
            }
            [(node, place), (key, key_place)] => {
                match (draft.nodes.get_mut(node)).or_else(|| Some(&mut draft.hosts.get_mut(node)?.node)) {
                    Some(node) if key == "kind" => {
                        node.kind = Some(item(key_place));
                        let old = std::mem::take(&mut node.keys);
                        old.iter().for_each(|(_, item)| references(item.value, &mut draft.overruled));
                    }
                    Some(node) => {
                        if key == "method" {
                            // What arguments say is said for the method that arguments say, in any order.
                            node.inherit(value, |old| !settings.iter().any(|s| s.place == old.place));
                        }
                        if let Some(old) = node.set(key, item(key_place)) {
                            references(old.value, &mut draft.overruled);
                        }
                    }
                    None => {
                        let names = draft.nodes.keys().chain(draft.hosts.keys()).copied();
                        problems.push(no_node(node, place, &format!("{from}: "), names, problems.len()));
                    }
                }
            }
            _ => {}
        }
    }
}

impl<'s> Draft<'s> {
    /// The knobs that a text of part `part` refers to.
    pub fn knobs_of(&self, part: usize) -> &Items<'s> {
        if part == 0 { &self.knobs } else { &self.parts[part].knobs }
    }
}

/// The problem of naming a node that is not there, one of `others` problems.
pub fn no_node<'a>(
    name: &str,
    place: TextSpan,
    who: &str,
    known: impl Iterator<Item = &'a str> + Clone,
    others: usize,
) -> Problem {
    let problem = Problem::at(place, format!("{who}no node `{name}`"), "no such node");
    if !suggest::worthwhile(others) {
        return problem;
    }
    let help = format!("{}the nodes are {}", suggest::did_you_mean(name, known.clone()), suggest::list(known));
    problem.help(help)
}
