//! Pipeline files: from TOML to a checked [`Plan`].
//!
//! `read` finds the texts, `draft` lays a file over its bases, `part` puts pipelines in the place of nodes, `link` tells the nodes' keys apart and wires their ports,
//! `order` sorts them, `axes` follows lists, `publish` checks what leaves. Every step goes on after what is wrong and
//! says nothing of what follows from it, so that one report names all mistakes and no others. Nothing runs, and nothing
//! is read but pipeline files; sources are only looked for.

mod axes;
mod batch;
mod draft;
mod item;
mod judge;
mod kind;
mod link;
mod order;
mod part;
mod problem;
mod publish;
mod read;
mod reference;
mod require;
mod scope;
mod several;
mod source;
mod transient;
mod value;

pub use super::{
    suggest::{did_you_mean, elide, list as name_list, nearest},
    types::{Ty, parameters},
};
pub use item::valid_name;
pub use kind::OWN_KEYS;
pub use problem::{Problem, Problems};
pub use read::Stock;
pub use source::{Source, Sources, TextSpan};

use super::{
    plan::{NodeId, OutputRef, Plan, PlanInput, PlanNode, Publish, Requirement},
    registry::Registry,
    suggest,
};
use axes::NodeAxes;
use draft::Draft;
use item::Setting;
use link::Links;
use part::Texts;
use read::Layer;
use std::{
    borrow::Cow,
    path::{Path, PathBuf},
    sync::Arc,
};
use value::Values;

/// What to load.
pub struct Request<'a> {
    /// A path, or the name of a stock pipeline.
    pub file: &'a str,
    /// The working folder, absolute: where `file` and the paths in `set` start from.
    pub folder: &'a Path,
    /// `name=value` and `node.param=value`, the value in TOML's syntax or as plain text.
    pub set: &'a [String],
    /// `node.measure=…`: bounds over those of `[require]`.
    pub require: &'a [String],
    /// The pipeline's name, over what the file says.
    pub name: Option<&'a str>,
    /// The pipelines that the program carries.
    pub stock: &'a [Stock],
    /// Which row of `[batch]` is wanted; none: what the file says without it.
    pub row: Option<usize>,
    /// Parameters that every node gets whose kind has them, over what the file says.
    pub everywhere: &'a [(&'a str, serde_json::Value)],
}

impl<'a> Request<'a> {
    /// The pipeline `file` as it says itself.
    pub fn new(file: &'a str, folder: &'a Path, stock: &'a [Stock]) -> Self {
        Self { file, folder, set: &[], require: &[], name: None, stock, row: None, everywhere: &[] }
    }
}

/// Reads and checks a pipeline. The error holds everything that is wrong with it.
pub fn load(request: &Request, registry: &Registry) -> Result<Plan, Problems> {
    match read::open(request.file, request.folder, request.stock) {
        Ok((source, path)) => check(source, &path, request, registry),
        Err(problem) => Err(Problems::new(Sources::default(), vec![problem])),
    }
}

/// Checks the pipeline `text` as [`load`] does a file; `name` stands for the file, in `request.folder`.
pub fn load_text(name: &str, text: &str, request: &Request, registry: &Registry) -> Result<Plan, Problems> {
    let source = Source {
        name: name.to_owned(),
        text: text.into(),
        folder: request.folder.to_owned(),
        argument: false,
        file: None,
        part: 0,
    };
    check(source, &request.folder.join(name), request, registry)
}

fn check(top: Source, path: &Path, request: &Request, registry: &Registry) -> Result<Plan, Problems> {
    let mut problems = Vec::new();
    let mut sources = Sources::default();
    let text = Arc::clone(&top.text);
    let number = sources.add(top);
    let Some(table) = read::parse(number, &text, &mut problems) else { return Err(Problems::new(sources, problems)) };
    let mut texts = read::bases(number, &table, path, request.stock, &mut sources, &mut problems);
    texts.reverse();
    texts.push((number, text.clone()));
    let mut parts = vec![Texts::top(texts, request.file, path)];
    part::find(&mut parts, request.stock, &mut sources, &mut problems);
    let set: Vec<Cow<str>> = request.set.iter().map(|text| quoted(text)).collect();
    let mut arguments = Vec::new();
    for text in &set {
        let name = "--set".to_owned();
        let folder = request.folder.to_owned();
        let source = sources.add(Source { name, text: (&**text).into(), folder, argument: true, file: None, part: 0 });
        match read::argument(source, text) {
            Ok(argument) => arguments.push(argument),
            Err(problem) => problems.push(problem),
        }
    }
    let add = |text: &String| {
        let (name, folder) = ("--require".to_owned(), request.folder.to_owned());
        sources.add(Source { name, text: text.as_str().into(), folder, argument: true, file: None, part: 0 })
    };
    let require: Vec<u32> = request.require.iter().map(add).collect();
    if let Some(name) = request.name.filter(|name| !valid_name(name)) {
        let help = "at most 128 letters, digits, `-` and `_`: it names the folder that the bake writes";
        problems.push(Problem::nowhere(format!("--name: `{name}` is no name for a pipeline")).help(help));
    }
    if !problems.is_empty() {
        // A missing base or a broken text: what else is wrong cannot be told yet.
        return Err(Problems::new(sources, problems));
    }
    let layers: Vec<Vec<Layer>> = parts.iter().map(|part| part.layers(&mut problems)).collect();
    let drafts = layers.iter().map(|layers| draft::merge(layers, &mut problems)).collect();
    let mut draft = part::join(drafts, &parts, &mut problems);
    let owners = |draft: &Draft, param: &str| owners(draft, param, registry);
    let rows = draft.batch.map_or_else(Vec::new, |item| batch::rows(item, &mut problems));
    let row = request.row.and_then(|row| rows.get(row));
    if let Some(row) = row {
        draft::apply(&mut draft, &row.settings, owners, &mut problems);
    }
    let given: Vec<Setting> = arguments.iter().map(read::Argument::setting).collect();
    draft::apply(&mut draft, &given, owners, &mut problems);
    part::plug(&mut draft, &mut problems);
    let plan = resolve(&draft, &sources, path, &require, request.everywhere, registry, &mut problems);
    let named = |plan: Plan| {
        let own = request.name.map_or(plan.name, str::to_owned);
        let name = row.map_or_else(|| own.clone(), |row| format!("{own}-{}", row.name));
        let given = |s: &Setting| {
            let path: Vec<&str> = s.path.iter().map(|(name, _)| *name).collect();
            (path.join("."), value::json(s.value))
        };
        let given = row.map_or_else(Vec::new, |row| row.settings.iter().map(given).collect());
        Plan { name, given, rows: rows.iter().map(|row| row.name.clone()).collect(), ..plan }
    };
    match plan.map(named) {
        Some(plan) if problems.is_empty() => Ok(plan),
        _ => Err(Problems::new(sources, problems)),
    }
}

/// An argument whose first name is that of a node in a part, as TOML writes it: `"far/mesh".factor=2`.
fn quoted(text: &str) -> Cow<'_, str> {
    match text.split_once('.') {
        Some((name, rest)) if name.contains('/') && !name.contains(['"', '=']) => format!("\"{name}\".{rest}").into(),
        _ => text.into(),
    }
}

/// The nodes whose kind has parameter `param`.
fn owners(draft: &Draft, param: &str, registry: &Registry) -> Vec<String> {
    let has = |node: &draft::DraftNode| {
        let method = node.get("method").and_then(|item| item.value.as_str());
        let kind = node.kind.and_then(|k| registry.find(k.value.as_str()?, method).ok());
        kind.is_some_and(|k| parameters(&k.spec().params).0.contains_key(param))
    };
    draft.nodes.iter().filter(|(_, node)| has(node)).map(|(name, _)| (*name).to_owned()).collect()
}

fn resolve<'s>(
    draft: &'s Draft<'s>,
    sources: &'s Sources,
    path: &Path,
    require: &[u32],
    everywhere: &[(&str, serde_json::Value)],
    registry: &'s Registry,
    problems: &mut Vec<Problem>,
) -> Option<Plan> {
    let stem = path.file_stem().and_then(|s| s.to_str()).unwrap_or("pipeline");
    let name = name(draft, stem, problems);
    let values = Values { sources, draft, used: Default::default(), missed: Default::default() };
    if draft.nodes.is_empty() && draft.hosts.is_empty() {
        let help =
            "a node is a table such as [nodes.load] with kind = \"load-scene\"; `farfield nodes` lists the kinds";
        problems.push(Problem::at(TextSpan::default(), "the pipeline has no nodes", "nothing to bake").help(help));
    }
    let links = link::link(draft, registry, &values, everywhere, problems);
    let order = order::order(&links, problems);
    let known = axes::infer(&links, &order, problems);
    part::types(draft, &links, problems);
    publish::outputs(draft, &links, problems);
    let files = publish::files(draft, &links, &known, problems);
    let bounds = require::require(draft, &links, &values, require, problems);
    transient::transient(&links, &files, &bounds, problems);
    knobs(draft, &links, &values, problems);
    if !problems.is_empty() {
        return None;
    }
    let doubts = links.doubts.iter().map(|(place, text)| format!("{}: {text}", sources.line(*place))).collect();
    let knobs = draft.knobs.iter().map(|(name, item)| ((*name).to_owned(), value::json(item.value))).collect();
    let plan = plan(links, &order, known, files, bounds)?;
    let given = given(&plan.nodes);
    let about = draft.about.and_then(|item| item.value.as_str()).unwrap_or_default().to_owned();
    Some(Plan { name, about, file: PathBuf::from(path), texts: sources.files(), knobs, sources: given, doubts, ..plan })
}

/// The pipeline's name, which names its folder below `out/`.
fn name(draft: &Draft, stem: &str, problems: &mut Vec<Problem>) -> String {
    let given = draft.name.and_then(|item| Some((item.value.as_str()?, item.place)));
    if let Some((name, place)) = given
        && !valid_name(name)
    {
        let help = "at most 128 letters, digits, `-` and `_`: it names the folder that the bake writes";
        problems.push(Problem::at(place, format!("`{name}` is no name for a pipeline"), "not a name").help(help));
    }
    let name = given.map_or(stem, |(name, _)| name);
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_".contains(c) { c } else { '-' }).collect()
}

/// Knobs hold plain values, and a knob that the file itself gives is used.
fn knobs(draft: &Draft, links: &Links, values: &Values, problems: &mut Vec<Problem>) {
    let (used, missed) = (values.used.borrow(), values.missed.borrow());
    let known = || draft.knobs.keys().copied();
    for (name, item) in &draft.knobs {
        if !valid_name(name) {
            let message = format!("`{name}` is no name for a knob");
            problems.push(Problem::at(item.key, message, "not a name").help("letters, digits, `-` and `_`"));
        } else if let Some(text) = item.value.as_str()
            && text.starts_with('{')
            && text.ends_with('}')
        {
            let message = format!("knob `{name}` refers to another knob");
            let help = "a knob holds a plain value; nodes refer to knobs";
            problems.push(Problem::at(item.place, message, "a reference").help(help));
        } else if !used.contains(name) && !draft.overruled.contains(name) && item.key.source == 0 {
            // What would use it may be wrong itself, and reported already.
            let unknown = links.nodes.iter().any(|node| node.info.is_none());
            if unknown || missed.iter().any(|m| nearest(m, known()) == Some(name)) {
                continue;
            }
            let others = draft.knobs.keys().copied().filter(|k| used.contains(k));
            let help = format!(
                "{}a node uses a knob by writing \"{{{name}}}\" in place of a value",
                suggest::did_you_mean(name, others)
            );
            problems.push(Problem::at(item.key, format!("no node uses the knob `{name}`"), "not used").help(help));
        }
    }
}

/// The files of the outside world that nodes are given, each with its folder's name: what tells the scenes apart, and
/// nothing of where they lie on this machine.
fn given(nodes: &[PlanNode]) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for node in nodes {
        let params = super::key::source_params(node.kind.spec());
        for text in params.iter().filter_map(|p| node.params.get(p)?.as_str()).filter(|text| !text.is_empty()) {
            let short = if text.starts_with("builtin:") { text.to_owned() } else { with_folder(Path::new(text)) };
            if !out.contains(&short) {
                out.push(short);
            }
        }
    }
    out
}

/// `folder/file` of a path.
fn with_folder(path: &Path) -> String {
    let path = super::source::lexical(path);
    let names = path.components().filter(|c| matches!(c, std::path::Component::Normal(_)));
    let mut parts: Vec<_> = names.rev().take(2).map(|c| c.as_os_str().to_string_lossy()).collect();
    parts.reverse();
    parts.join("/")
}

fn plan(
    links: Links,
    order: &[usize],
    known: Vec<Option<NodeAxes>>,
    files: Vec<publish::FileEntry>,
    bounds: Vec<require::Bound>,
) -> Option<Plan> {
    let mut number = vec![NodeId(0); order.len()];
    for (id, at) in order.iter().enumerate() {
        number[*at] = NodeId(id as u32);
    }
    let output = |(node, port): link::Output| OutputRef { node: number[node], port };
    let outputs = |list: Vec<link::Output>| list.into_iter().map(output).collect::<Vec<_>>();
    let mut links: Vec<Option<link::Link>> = links.nodes.into_iter().map(Some).collect();
    let mut known = known;
    let mut nodes = Vec::with_capacity(order.len());
    for at in order {
        let (link, axes) = (links[*at].take()?, known[*at].take()?);
        let inputs = link.inputs.iter().zip(axes.inputs).zip(axes.gathered);
        nodes.push(PlanNode {
            name: link.of_port.map_or_else(|| link.name.to_owned(), |port| format!("{}.{port}", link.name)),
            kind: Arc::clone(&link.info?.kind),
            params: link.params?,
            inputs: inputs
                .map(|((input, axes), gathered)| PlanInput {
                    from: input.from.map(output),
                    axes: outputs(axes),
                    via: input.via.map(output),
                    gathered: outputs(gathered),
                })
                .collect(),
            axes: outputs(axes.mapped),
            join_inner: link.join_inner,
            transient: link.transient.is_some(),
        });
    }
    let files = files.into_iter().map(|(path, from)| Publish { path, from: output(from) }).collect();
    let require = bounds
        .into_iter()
        .map(|b| Requirement { from: output(b.from), path: b.path, min: b.min, max: b.max })
        .collect();
    Some(Plan { nodes, files, require, ..Plan::default() })
}
