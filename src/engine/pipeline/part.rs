//! Pipelines in the place of nodes: `pipeline = "tdm"`. The nodes of such a part are put among the others as `part/node`.
//!
//! Which part a name belongs to is told by the text that it stands in, for every use of a pipeline has its texts to itself. So values and references
//! are never rewritten: a knob or an input that the parent gives is looked up where the parent writes it.

use super::{
    draft::{self, Draft, Host},
    item::{Item, Items, references, what},
    link::Links,
    problem::Problem,
    read::{self, Layer, Stock},
    scope::{Input, Part},
    source::{Sources, TextSpan},
};
use crate::engine::suggest;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};
use toml::de::DeValue;

/// Parts of one pipeline, at most: parts of parts may grow faster than anybody means.
const MOST: usize = 256;

/// The texts of a pipeline as one part uses it.
pub struct Texts {
    /// Numbers and texts, the base-most first.
    pub texts: Vec<(u32, Arc<str>)>,
    /// The node that it stands for; empty for the pipeline that is baked.
    pub node: String,
    /// What its own text calls a node, and what the node is called among all.
    full: BTreeMap<String, String>,
    /// The pipelines that it is a part of, and itself: what messages call them, and what tells them apart.
    above: Vec<(String, PathBuf)>,
}

impl Texts {
    /// Of the pipeline that is baked, from `path`.
    pub fn top(texts: Vec<(u32, Arc<str>)>, name: &str, path: &Path) -> Self {
        let above = vec![(name.to_owned(), read::identity(path))];
        Self { texts, node: String::new(), full: BTreeMap::new(), above }
    }

    /// Their layers, the base-most first.
    pub fn layers(&self, problems: &mut Vec<Problem>) -> Vec<Layer<'_>> {
        let mut layers = Vec::with_capacity(self.texts.len());
        for (source, text) in &self.texts {
            layers.extend(read::parse(*source, text, problems).map(|table| Layer { source: *source, table }));
        }
        layers
    }
}

/// Adds the texts of all parts of `parts[0]`, and of their parts.
pub fn find(parts: &mut Vec<Texts>, stock: &[Stock], sources: &mut Sources, problems: &mut Vec<Problem>) {
    let mut at = 0;
    while at < parts.len() {
        // What is wrong with the text itself is told when all parts are merged.
        let mut later = Vec::new();
        let (mut full, mut found) = (BTreeMap::new(), Vec::new());
        let layers = parts[at].layers(&mut later);
        let prefix = if at == 0 { String::new() } else { format!("{}/", parts[at].node) };
        for (name, node) in &draft::merge(&layers, &mut later).nodes {
            full.insert((*name).to_owned(), format!("{prefix}{name}"));
            if let Some(item) = node.get("pipeline")
                && let Some(file) = item.value.as_str()
            {
                found.push((format!("{prefix}{name}"), file.to_owned(), item.place));
            }
        }
        drop(layers);
        parts[at].full = full;
        for (node, file, place) in found {
            if parts.len() > MOST {
                let help = "a part that holds parts that hold parts is often simpler as one file";
                problems.push(
                    Problem::at(place, format!("the pipeline has more than {MOST} parts"), "one too many").help(help),
                );
                return;
            }
            match part(parts, at, node, &file, place, stock, sources, problems) {
                Ok(part) => parts.push(part),
                Err(problem) => problems.push(problem),
            }
        }
        at += 1;
    }
}

/// The texts of one part, whose number is that of the next.
fn part(
    parts: &[Texts],
    parent: usize,
    node: String,
    file: &str,
    place: TextSpan,
    stock: &[Stock],
    sources: &mut Sources,
    problems: &mut Vec<Problem>,
) -> Result<Texts, Problem> {
    let folder = sources.get(place).folder.clone();
    let (mut source, path) = read::open(file, &folder, stock).map_err(|p| Problem {
        place: Some(place),
        label: "not found".to_owned(),
        ..p
    })?;
    let identity = read::identity(&path);
    let above = &parts[parent].above;
    let names = || above.iter().map(|a| a.0.as_str()).chain([file]).collect::<Vec<_>>().join(" → ");
    if above.iter().any(|(_, other)| *other == identity) {
        let message = format!("a pipeline is a part of itself: {}", names());
        return Err(Problem::at(place, message, "leads back").help("remove one `pipeline` of the circle"));
    }
    source.part = parts.len();
    let text = Arc::clone(&source.text);
    let number = sources.add(source);
    let mut texts = Vec::new();
    if let Some(table) = read::parse(number, &text, problems) {
        texts = read::bases(number, &table, &path, stock, sources, problems);
        texts.reverse();
    }
    texts.push((number, text));
    let above = above.iter().cloned().chain([(file.to_owned(), identity)]).collect();
    Ok(Texts { texts, node, full: BTreeMap::new(), above })
}

/// One draft of all: the pipeline's own and those of its parts, in the order of `texts`.
pub fn join<'s>(drafts: Vec<Draft<'s>>, texts: &'s [Texts], problems: &mut Vec<Problem>) -> Draft<'s> {
    let mut all = Draft::default();
    for (number, (mut draft, texts)) in drafts.into_iter().zip(texts).enumerate() {
        let mut inputs = inputs(std::mem::take(&mut draft.inputs), problems);
        for name in draft.nodes.keys() {
            if let Some(input) = inputs.remove(name) {
                let message = format!("an input and a node are both called `{name}`");
                problems.push(Problem::at(input.key, message, "also a node").help("give one of them another name"));
            }
        }
        let top = number == 0;
        let mut part = Part { node: &texts.node, inputs, names: (!top).then_some(&texts.full), ..Part::default() };
        let nodes = std::mem::take(&mut draft.nodes);
        if top {
            // Arguments change the knobs of the pipeline that is baked.
            all = draft;
        } else {
            (part.knobs, part.outputs) = (draft.knobs, draft.outputs);
        }
        for (name, mut node) in nodes {
            node.order.0 += (number as u32) << 16;
            let full = texts.full.get(name).map_or(name, String::as_str);
            if node.get("pipeline").is_some() {
                all.hosts.insert(full, Host { node, part: None });
            } else {
                all.nodes.insert(full, node);
            }
        }
        all.parts.push(part);
    }
    for (number, texts) in texts.iter().enumerate().skip(1) {
        if let Some(host) = all.hosts.get_mut(&*texts.node) {
            host.part = Some(number);
        }
    }
    all
}

/// `[inputs]`.
fn inputs<'s>(items: Items<'s>, problems: &mut Vec<Problem>) -> BTreeMap<&'s str, Input<'s>> {
    const FORM: &str = "an input is { type = \"Scene\", default = \"node.output\" }, and its default may be left out";
    let mut inputs = BTreeMap::new();
    for (name, item) in items {
        let mut wrong = |place, message, label: &str| problems.push(Problem::at(place, message, label).help(FORM));
        if !super::item::valid_name(name) {
            wrong(item.key, format!("`{name}` is no name for an input"), "not a name");
            continue;
        }
        let Some(table) = item.value.as_table() else {
            wrong(item.place, format!("input `{name}` is {}, expected a table", what(item.value)), "not a table");
            continue;
        };
        let (mut ty, mut default, mut sound) = (None, None, true);
        for (key, value) in table {
            let place = |span| TextSpan::new(item.place.source, span);
            let inner = Item { key: place(key.span()), value: value.get_ref(), place: place(value.span()) };
            match (&**key.get_ref(), inner.value.as_str()) {
                ("type", Some(text)) => ty = Some(text),
                ("default", Some(_)) => default = Some(inner),
                ("type" | "default", None) => {
                    let message = format!("`{}` is {}, expected text", key.get_ref(), what(inner.value));
                    wrong(inner.place, message, "not text");
                    sound = false;
                }
                (other, _) => {
                    wrong(inner.key, format!("an input has no `{other}`"), "no such key");
                    sound = false;
                }
            }
        }
        match ty {
            Some(ty) if sound => drop(inputs.insert(name, Input { key: item.key, ty, default, given: None })),
            None if sound => wrong(item.key, format!("input `{name}` does not say its `type`"), "no type"),
            _ => {}
        }
    }
    inputs
}

/// Gives the parts what their nodes say: inputs, knobs and `per`.
pub fn plug<'s>(draft: &mut Draft<'s>, problems: &mut Vec<Problem>) {
    let mut pers: Vec<Vec<(&str, TextSpan)>> = vec![Vec::new(); draft.parts.len()];
    for (name, host) in &draft.hosts {
        let Some(number) = host.part else { continue };
        let part = &mut draft.parts[number];
        if let Some(kind) = host.node.kind {
            let message = format!("node `{name}` has both `kind` and `pipeline`");
            problems.push(
                Problem::at(kind.key, message, "one too many").help("a node is of a kind, or stands for a pipeline"),
            );
        }
        for (key, item) in &host.node.keys {
            match *key {
                "pipeline" => {}
                "per" => match per(*item) {
                    Some(lists) => pers[number].extend(lists),
                    None => problems.push(
                        Problem::at(item.place, "`per` is no list of names", "not such a list")
                            .help("a list such as [\"objects\"]"),
                    ),
                },
                key if part.inputs.contains_key(key) => match (item.value, part.inputs.get_mut(key)) {
                    (DeValue::String(_), Some(input)) => input.given = Some(*item),
                    (other, _) => {
                        let message = format!("input `{key}` is {}, expected \"node.output\"", what(other));
                        problems.push(Problem::at(item.place, message, "not a reference"));
                    }
                },
                key if part.knobs.contains_key(key) => {
                    // An argument may overrule what the part does with it.
                    references(item.value, &mut draft.overruled);
                    part.knobs.insert(key, *item);
                }
                key => problems.push(unknown_key(name, key, *item, part)),
            }
        }
    }
    // Parts come after those that hold them.
    for number in 1..draft.parts.len() {
        let node = draft.parts[number].node;
        let above =
            (0..number).filter(|n| node.strip_prefix(draft.parts[*n].node).is_some_and(|rest| rest.starts_with('/')));
        let mut lists: Vec<_> = above.max().map(|n| draft.parts[n].per.clone()).unwrap_or_default();
        lists.append(&mut pers[number]);
        draft.parts[number].per = lists;
    }
}

fn unknown_key(name: &str, key: &str, item: Item, part: &Part) -> Problem {
    let known = || part.inputs.keys().chain(part.knobs.keys()).copied();
    let list = |what: &str, names: Vec<&str>| match names.is_empty() {
        true => format!("no {what}"),
        false => format!("the {what} {}", suggest::list(names)),
    };
    let (inputs, knobs) = (part.inputs.keys().copied().collect(), part.knobs.keys().copied().collect());
    let help = format!(
        "{}it has {} and {}",
        suggest::did_you_mean(key, known()),
        list("inputs", inputs),
        list("knobs", knobs)
    );
    Problem::at(item.key, format!("the pipeline of node `{name}` has no `{key}`"), "no such input or knob").help(help)
}

/// The names that a node's `per` lists.
fn per<'s>(item: Item<'s>) -> Option<Vec<(&'s str, TextSpan)>> {
    let entry = |entry: &'s toml::Spanned<DeValue<'s>>| {
        Some((entry.get_ref().as_str()?, TextSpan::new(item.place.source, entry.span())))
    };
    item.value.as_array()?.iter().map(entry).collect()
}

/// Every input of a part has what its type says.
pub fn types(draft: &Draft, links: &Links, problems: &mut Vec<Problem>) {
    for (number, part) in draft.parts.iter().enumerate() {
        for (name, input) in &part.inputs {
            let Some(item) = input.given.or(input.default) else {
                // Whoever reads it says so.
                continue;
            };
            let who = format!("input `{name}`");
            let Some(text) = item.value.as_str() else { continue };
            // What nothing of use reads is not there, and of what is read the reader tells.
            let from = match links.sources.get(item.place).part {
                0 => links.find(text, item.place, &who, problems),
                _ => links.known(text, item.place),
            };
            let Some(from) = from else { continue };
            let Some(spec) = links.output(from.0, from.1).filter(|spec| spec.ty.name != input.ty) else { continue };
            let whose = if number == 0 { String::new() } else { format!(" of `{}`", part.node) };
            let message = format!(
                "input `{name}`{whose} takes a {}, `{}` is a {}",
                input.ty,
                links.output_name(from),
                spec.ty.name
            );
            problems
                .push(Problem::at(item.place, message, format!("a {}", spec.ty.name)).also(input.key, "declared here"));
        }
    }
}
