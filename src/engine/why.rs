//! Why a node ran: the last bake in which it did is compared with the one before, field by field of the key, and up
//! the graph to where the change began.

use super::{
    cache::{BakesOnRecord, Cache, Fields},
    error::EngineError,
    hash::Digest,
    inputs,
    key::source_params,
    node::Arity,
    options::Options,
    plan::{OutputRef, Plan},
    record::{BakeRecord, MapRecord, NodeTrace, RunRecord, folder_key},
    report::Reason,
    value::{JOIN, PortOut, shown},
};
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

/// Changed elements that are named before the rest is counted.
const NAMED: usize = 5;

const SWEPT: &str = "its key changed, but the cache no longer holds what it was made of (a sweep removed it)";

/// Why `what` (`NODE` or `NODE/ELEMENT`) ran when it last did, as a chain up to the cause.
pub fn why(plan: &Plan, options: &Options, what: &str) -> Result<String, EngineError> {
    let exact = plan.nodes.iter().position(|n| n.name == what);
    // The longest node name wins: parts and elements both stand behind a stroke.
    let inside = |n: &&usize| what.strip_prefix(&plan.nodes[**n].name).is_some_and(|rest| rest.starts_with('/'));
    let all: Vec<usize> = (0..plan.nodes.len()).collect();
    let found = exact.or_else(|| all.iter().filter(inside).max_by_key(|n| plan.nodes[**n].name.len()).copied());
    let n = found.ok_or_else(|| EngineError::unknown_node(what, plan.nodes.iter().map(|n| n.name.as_str())))?;
    let element = (exact.is_none()).then(|| &what[plan.nodes[n].name.len() + 1..]);
    let mut cache = Cache::open(&options.cache, false)?;
    let folder = folder_key(&options.out.join(&plan.name));
    let BakesOnRecord { records: bakes, forgotten } = cache.bakes(&plan.name, &folder, usize::MAX)?;
    Teller { plan, cache: &mut cache, bakes, forgotten }.tell(n, element)
}

/// Why the nodes of the last bake ran that did, in the plan's order, with those above them that passed a change on. `folder` is how records know
/// the output folder.
pub fn reasons(plan: &Plan, cache: &mut Cache, folder: &str) -> Result<Vec<Reason>, EngineError> {
    let BakesOnRecord { records: bakes, forgotten } = cache.bakes(&plan.name, folder, usize::MAX)?;
    let Some(last) = bakes.first() else { return Ok(Vec::new()) };
    let ran = |n: &usize| last.node(&plan.nodes[*n].name).is_some_and(|t| t.ran > 0);
    let mut wanted: BTreeSet<usize> = (0..plan.nodes.len()).filter(ran).collect();
    let mut teller = Teller { plan, cache, bakes, forgotten };
    let mut links = BTreeMap::new();
    // What a node takes stands before it in the plan.
    while let Some(n) = wanted.pop_last() {
        let link = teller.link(n, 0)?;
        wanted.extend(link.from);
        links.insert(n, link);
    }
    let name = |n: usize| plan.nodes[n].name.clone();
    let reason = |(n, l): (usize, Link)| Reason { node: name(n), did: l.did, cause: l.cause, from: l.from.map(name) };
    Ok(links.into_iter().map(reason).collect())
}

/// One step of an explanation.
struct Link {
    /// What the node did.
    did: String,
    /// Why; empty where nothing is known.
    cause: String,
    /// The node from which the change came.
    from: Option<usize>,
}

impl Link {
    fn new(did: impl Into<String>, cause: impl Into<String>) -> Self {
        Self { did: did.into(), cause: cause.into(), from: None }
    }

    fn text(&self) -> String {
        if self.cause.is_empty() { self.did.clone() } else { format!("{}: {}", self.did, self.cause) }
    }
}

struct Teller<'a> {
    plan: &'a Plan,
    cache: &'a mut Cache,
    /// Newest first.
    bakes: Vec<BakeRecord>,
    /// Whether older records were dropped.
    forgotten: bool,
}

/// What a run's key was made of.
struct Made {
    fixed: Digest,
    inputs: Vec<Digest>,
    run: Option<Arc<RunRecord>>,
}

impl Teller<'_> {
    fn tell(&mut self, n: usize, element: Option<&str>) -> Result<String, EngineError> {
        let name = &self.plan.nodes[n].name;
        let whole = element.map_or_else(|| name.clone(), |e| format!("{name}/{e}"));
        let Some(last) = self.bakes.first() else {
            let older = if self.forgotten { "; only the last bakes are kept" } else { "" };
            return Ok(format!("{whole}: no bake of this pipeline into this folder is on record{older}"));
        };
        if last.node(name).is_none() {
            return Ok(format!("{whole} has not come to its end in the last bake"));
        }
        let at = self.bakes.iter().position(|b| b.node(name).is_some_and(|t| t.ran > 0));
        let Some(at) = at else {
            return Ok(format!("{whole} was a hit in every bake on record{}", self.reach()));
        };
        let mut text = match element {
            Some(element) => self.link_of_element(n, element, at).and_then(|link| self.chain(link, at))?,
            None => self.link(n, at).and_then(|link| self.chain(link, at))?,
        };
        if at > 0 && element.is_none() {
            text = format!("{whole} was a hit in the last bake ({at} on record since it ran): {text}");
        }
        Ok(text)
    }

    /// How far the records reach, where there were older ones.
    fn reach(&self) -> String {
        match self.bakes.len() {
            n if self.forgotten => {
                format!(" (older records were dropped; these are the last {n} bakes that changed something)")
            }
            _ => String::new(),
        }
    }

    /// The trace of node `n` in bake `at`, and in the last one before that came to it.
    fn traces(&self, n: usize, at: usize) -> (Option<NodeTrace>, Option<NodeTrace>) {
        let name = &self.plan.nodes[n].name;
        let before = self.bakes.iter().skip(at + 1).find_map(|b| b.node(name));
        (self.bakes.get(at).and_then(|b| b.node(name)).cloned(), before.cloned())
    }

    /// `NODE ran: cause`, followed up the graph.
    fn chain(&mut self, mut link: Link, at: usize) -> Result<String, EngineError> {
        let mut text = link.text();
        while let Some(from) = link.from {
            link = self.link(from, at)?;
            text += &format!(" ← {}", link.text());
        }
        Ok(text)
    }

    fn link(&mut self, n: usize, at: usize) -> Result<Link, EngineError> {
        let name = self.plan.nodes[n].name.clone();
        let (Some(now), before) = self.traces(n, at) else {
            return Ok(Link::new(format!("{name} is not on record"), ""));
        };
        let verb = if now.ran > 0 { "ran" } else { "was a hit with another result" };
        let count = if now.mapped && now.ran > 0 {
            format!(" for {} of {} elements", now.ran, now.elements)
        } else {
            String::new()
        };
        let head = format!("{name} {verb}{count}");
        if !now.note.is_empty() && now.ran > 0 {
            return Ok(Link::new(head, now.note));
        }
        let Some(before) = before else {
            return Ok(Link::new(head, format!("no earlier bake of it is on record{}", self.reach())));
        };
        if now.key == before.key && now.variant == before.variant {
            return Ok(Link::new(head, "its result was no longer in the cache"));
        }
        let (made, old) = (self.made(&now)?, self.made(&before)?);
        let (Some(made), Some(old)) = (made, old) else {
            return Ok(Link::new(head, SWEPT));
        };
        self.compare(n, at, head, &made, &old)
    }

    fn link_of_element(&mut self, n: usize, element: &str, at: usize) -> Result<Link, EngineError> {
        let head = format!("{}/{element}", self.plan.nodes[n].name);
        let (Some(now), before) = self.traces(n, at) else {
            return Ok(Link::new(format!("{head} is not on record"), ""));
        };
        if !now.mapped {
            return Ok(Link::new(head, "the node has no elements"));
        }
        let row = |map: Option<MapRecord>| map.and_then(|m| m.rows.into_iter().find(|r| shown(&r.name) == element));
        let Some(row_now) = row(self.cache.map(&now.key)?) else {
            return Ok(Link::new(head, "there was no such element in that bake"));
        };
        let old = match &before {
            Some(before) => row(self.cache.map(&before.key)?),
            None => None,
        };
        let Some(old) = old else {
            let reach = self.reach();
            let cause = format!("the element is new, or no earlier bake of it is on record{reach}");
            return Ok(Link::new(format!("{head} ran"), cause));
        };
        if old.key == row_now.key {
            return Ok(match now.note.as_str() {
                "" => Link::new(format!("{head} was a hit"), "none of its inputs changed"),
                note => Link::new(head, note),
            });
        }
        let head = format!("{head} ran");
        let made = self.cache.runs(&row_now.key)?.pop().map(|(_, r)| of_run(r));
        let old = self.cache.runs(&old.key)?.pop().map(|(_, r)| of_run(r));
        let (Some(made), Some(old)) = (made, old) else {
            return Ok(Link::new(head, SWEPT));
        };
        self.compare(n, at, head, &made, &old)
    }

    /// Which field of the key differs, or which input.
    fn compare(&mut self, n: usize, at: usize, head: String, made: &Made, old: &Made) -> Result<Link, EngineError> {
        let mut causes = Vec::new();
        if made.fixed != old.fixed {
            let (a, b) = (self.cache.fixed(&old.fixed)?, self.cache.fixed(&made.fixed)?);
            causes.extend(self.fields(n, &a.unwrap_or_default(), &b.unwrap_or_default()));
        }
        if let (Some(made), Some(old)) = (&made.run, &old.run) {
            causes.extend(files(old, made));
        }
        if !causes.is_empty() {
            return Ok(Link::new(head, causes.join(", ")));
        }
        for (i, input) in inputs::of_key(self.plan, n).into_iter().enumerate() {
            let Some(from) = input.from.filter(|_| made.inputs.get(i) != old.inputs.get(i)) else { continue };
            let elements = self.elements(from, at)?;
            let cause = format!("{} changed{elements}", input.describe(self.plan, n));
            return Ok(Link { from: Some(from.node.0 as usize), ..Link::new(head, cause) });
        }
        Ok(Link::new(head, "which elements it takes changed"))
    }

    fn fields(&self, n: usize, old: &Fields, new: &Fields) -> Vec<String> {
        let (old, new): (BTreeMap<_, _>, BTreeMap<_, _>) =
            (old.iter().cloned().collect(), new.iter().cloned().collect());
        let spec = self.plan.nodes[n].kind.spec();
        let files = source_params(spec);
        let mut out = Vec::new();
        for (path, value) in &new {
            // Lengths are told by the items that came or went.
            if old.get(path) == Some(value) || value.ends_with(" items") {
                continue;
            }
            let is_file = files.iter().any(|f| *path == format!("parameter {f}"));
            let brief = |v: &str| if v.len() == 64 { v[..8].to_owned() } else { v.to_owned() };
            out.push(match old.get(path) {
                Some(was) if is_file => {
                    let name = path.trim_start_matches("parameter ");
                    let file = self.plan.nodes[n].params.get(name).and_then(|v| v.as_str()).unwrap_or(name);
                    format!("file {file} changed ({} → {})", brief(was), brief(value))
                }
                Some(was) => format!("{path} changed from {} to {}", brief(was), brief(value)),
                None => format!("{path} is new: {}", brief(value)),
            });
        }
        out.extend(old.keys().filter(|path| !new.contains_key(*path)).map(|path| format!("{path} is gone")));
        if out.is_empty() && old != new {
            out.push("parameters changed".to_owned());
        }
        out
    }

    /// Which elements of a list differ between bake `at` and the one before.
    fn elements(&mut self, from: OutputRef, at: usize) -> Result<String, EngineError> {
        let p = from.node.0 as usize;
        let many = matches!(self.plan.nodes[p].kind.spec().outputs[from.port as usize].arity, Arity::Many { .. });
        if !many && self.plan.nodes[p].axes.is_empty() {
            return Ok(String::new());
        }
        let (Some(now), Some(before)) = self.traces(p, at) else { return Ok(String::new()) };
        let (new, old) = (self.list(&now, from.port as usize)?, self.list(&before, from.port as usize)?);
        let mut changes = Vec::new();
        for (name, hash) in &new {
            match old.get(name) {
                None => changes.push(format!("`{}` is new", shown(name))),
                Some(was) if was != hash => changes.push(format!("`{}` changed", shown(name))),
                Some(_) => {}
            }
        }
        changes.extend(old.keys().filter(|n| !new.contains_key(*n)).map(|n| format!("`{}` is gone", shown(n))));
        let more = changes.len().saturating_sub(NAMED);
        changes.truncate(NAMED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        Ok(if changes.is_empty() { String::new() } else { format!(" (element {}{more})", changes.join(", ")) })
    }

    fn list(&mut self, trace: &NodeTrace, port: usize) -> Result<BTreeMap<String, Digest>, EngineError> {
        let mut out = BTreeMap::new();
        let mut add = |name: &str, outputs: &[PortOut]| match outputs.get(port) {
            Some(PortOut::One(v)) => {
                out.insert(name.to_owned(), v.hash);
            }
            Some(PortOut::Many(rows)) => {
                let full = |n: &str| if name.is_empty() { n.to_owned() } else { format!("{name}{JOIN}{n}") };
                out.extend(rows.iter().map(|(n, v)| (full(n), v.hash)));
            }
            None => {}
        };
        if trace.mapped {
            for row in self.cache.map(&trace.key)?.map(|m| m.rows).unwrap_or_default() {
                add(&row.name, &row.outputs);
            }
        } else if let Some(run) = self.run(trace)? {
            add("", &run.outputs);
        }
        Ok(out)
    }

    fn run(&mut self, trace: &NodeTrace) -> Result<Option<Arc<RunRecord>>, EngineError> {
        let found = self.cache.runs(&trace.key)?.into_iter().find(|(variant, _)| *variant == trace.variant);
        Ok(found.map(|(_, record)| record))
    }

    fn made(&mut self, trace: &NodeTrace) -> Result<Option<Made>, EngineError> {
        if trace.mapped {
            let map = self.cache.map(&trace.key)?;
            return Ok(map.map(|m| Made { fixed: m.fixed, inputs: m.inputs, run: None }));
        }
        Ok(self.run(trace)?.map(of_run))
    }
}

fn of_run(run: Arc<RunRecord>) -> Made {
    Made { fixed: run.fixed, inputs: run.inputs.clone(), run: Some(run) }
}

/// Which files read through the door differ.
fn files(old: &RunRecord, new: &RunRecord) -> Vec<String> {
    let map = |r: &RunRecord| -> BTreeMap<String, Option<Digest>> {
        r.reads.iter().map(|f| (f.path.clone(), f.hash)).collect()
    };
    let (old, new) = (map(old), map(new));
    let mut out = Vec::new();
    for (path, hash) in &new {
        match (old.get(path), hash) {
            (Some(was), now) if was == now => {}
            (Some(Some(was)), Some(now)) => {
                out.push(format!("file {path} changed ({} → {})", was.short(), now.short()))
            }
            (Some(Some(_)), None) => out.push(format!("file {path} is gone")),
            (Some(None), _) => out.push(format!("file {path} appeared")),
            (None, _) => out.push(format!("file {path} is read now")),
        }
    }
    out.extend(old.keys().filter(|p| !new.contains_key(*p)).map(|p| format!("file {p} is no longer read")));
    out
}
