//! Elements: which runs a mapped node has, and what each of them takes from the lists above it.
//!
//! Inputs join on shared axes by name. What an input has in more axes than the node is gathered; what it has in fewer
//! is repeated. Rows need not be known as a whole: where they still arrive, a port asks for the row of an element by its
//! name.

mod arrive;
mod join;

use super::{
    hash::Digest,
    plan::{Axis, OutputRef, Plan, PlanNode, Relation},
    value::{JOIN, Row, ValueRef, list_hash, shown},
};
use join::{OwnedSide, natural_join};
use std::{
    borrow::Cow,
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

/// Rows of one output, sorted by name.
pub type Rows = Arc<Vec<Row>>;

/// Outputs whose rows still arrive.
pub trait Live {
    /// A row by its name; `None` where it is not there yet.
    fn row(&self, from: OutputRef, name: &str) -> Option<ValueRef>;
    /// Whether all rows below `prefix` are there.
    fn is_whole(&self, from: OutputRef, prefix: &str) -> bool;
    /// The rows below `prefix` that are there, sorted by name.
    fn below(&self, from: OutputRef, prefix: &str) -> Vec<(Arc<str>, ValueRef)>;
}

/// What reaches a node through one input port, before it is split by element.
pub struct Feed {
    pub from: OutputRef,
    /// `None`: they still arrive.
    pub rows: Option<Rows>,
    /// What the rows' hash is: the value's, or the list's.
    pub hash: Digest,
    pub via: Option<Via>,
    /// For a port that gathers below the node's axes: all names of those axes, from the list that made them. An
    /// element whose own list is empty is seen only there.
    pub outer: Option<Rows>,
}

/// A relation that chooses what is gathered.
pub struct Via {
    pub from: OutputRef,
    /// `None`: they still arrive.
    pub rows: Option<Rows>,
    /// Axes of `rows`, all of them the node's.
    pub axes: Vec<Axis>,
    /// Contents by hash, decoded.
    pub relations: BTreeMap<Digest, Arc<Relation>>,
    /// The component of the gathered names, and of the element's names, that the relation speaks of.
    pub gathered_at: usize,
    pub element_at: Option<usize>,
    /// Whether the gathered names have no other component.
    pub alone: bool,
    /// Components of the element's name that make the name of its row.
    pub columns: Vec<usize>,
}

impl Via {
    /// The relation that `element` asks.
    pub fn row(&self, element: &str, live: &dyn Live) -> Option<ValueRef> {
        row(self.from, self.rows.as_ref(), &pick(element, &self.columns), 0, live)
    }
}

/// What one element takes through one port.
#[derive(Clone, Debug, PartialEq)]
pub enum Taken {
    Absent,
    One(ValueRef),
    /// By raw name (see [`JOIN`]), sorted.
    Many(Vec<(Arc<str>, ValueRef)>),
}

impl Taken {
    pub fn values(&self) -> impl Iterator<Item = ValueRef> {
        let (one, many) = match self {
            Self::Absent => (None, &[][..]),
            Self::One(value) => (Some(*value), &[][..]),
            Self::Many(list) => (None, &list[..]),
        };
        one.into_iter().chain(many.iter().map(|(_, value)| *value))
    }

    pub fn holds(&self, hash: &Digest) -> bool {
        self.values().any(|value| value.hash == *hash)
    }
}

/// Why an element or a node cannot take what it needs: a message for the user.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ElementError(pub String);

/// How each port of a node meets the node's axes.
pub struct Binding {
    ports: Vec<Port>,
    /// Names of the ports, for messages.
    names: Vec<&'static str>,
    inner: bool,
}

enum Port {
    Absent,
    /// Components of the element's name that make a row's name; `whole` where that is the element's name itself.
    One {
        feed: Feed,
        columns: Vec<usize>,
        whole: bool,
    },
    Many {
        feed: Feed,
        columns: Vec<usize>,
        groups: Groups,
        many_all: bool,
        may_be_empty: bool,
    },
}

/// Rows by the part of their name that is not gathered: ranges of `order`, which is sorted by group, then name.
struct Groups {
    by_key: BTreeMap<String, Vec<(Arc<str>, usize)>>,
}

impl Groups {
    /// The groups that port `port` takes of `rows`.
    fn new(node: &PlanNode, port: usize, rows: &[Row]) -> Self {
        let source = &node.inputs[port].axes;
        let (key, name) = (positions(&kept(node, port), source), positions(&gathered(node, port), source));
        let mut by_key: BTreeMap<String, Vec<(Arc<str>, usize)>> = BTreeMap::new();
        let whole = key.is_empty() && name.iter().copied().eq(0..source.len());
        for (at, row) in rows.iter().enumerate() {
            let short = if whole { row.name.clone() } else { pick(&row.name, &name).into() };
            by_key.entry(pick(&row.name, &key)).or_default().push((short, at));
        }
        for group in by_key.values_mut() {
            group.sort();
        }
        Self { by_key }
    }
}

/// A row of `rows`, or of those that still arrive.
fn row(from: OutputRef, rows: Option<&Rows>, wanted: &str, hint: usize, live: &dyn Live) -> Option<ValueRef> {
    let Some(rows) = rows else { return live.row(from, wanted) };
    if let Some(row) = rows.get(hint).filter(|row| *row.name == *wanted) {
        return Some(row.value);
    }
    rows.binary_search_by(|row| (*row.name).cmp(wanted)).ok().map(|at| rows[at].value)
}

/// All rows; none of those that still arrive.
fn known(rows: &Option<Rows>) -> &[Row] {
    rows.as_deref().map_or(&[], Vec::as_slice)
}

fn empty(port: &str) -> ElementError {
    ElementError(format!("input `{port}` is an empty list, which this kind cannot take"))
}

fn component(name: &str, at: usize) -> &str {
    name.split(JOIN).nth(at).unwrap_or("")
}

/// The components `columns` of an element's name, as a name.
pub fn pick(name: &str, columns: &[usize]) -> String {
    let parts: Vec<&str> = name.split(JOIN).collect();
    let mut out = String::new();
    for (i, c) in columns.iter().enumerate() {
        if i > 0 {
            out.push(JOIN);
        }
        out.push_str(parts.get(*c).copied().unwrap_or(""));
    }
    out
}

/// The part of an element's name that names its row in a list over `columns`.
fn projection<'a>(element: &'a str, columns: &[usize], whole: bool) -> Cow<'a, str> {
    if whole { Cow::Borrowed(element) } else { Cow::Owned(pick(element, columns)) }
}

/// The places of the axes `of` among those of `within`.
pub fn positions(of: &[Axis], within: &[Axis]) -> Vec<usize> {
    of.iter().filter_map(|a| within.iter().position(|b| a == b)).collect()
}

/// Whether a port gathers all of a list, so that the list's own hash is what enters the key.
pub fn takes_all(node: &PlanNode, port: usize) -> bool {
    let input = &node.inputs[port];
    input.via.is_none() && kept(node, port).is_empty()
}

/// The axes of a port's source that it shares with the node's element.
pub fn kept(node: &PlanNode, port: usize) -> Vec<Axis> {
    let input = &node.inputs[port];
    let gathered = gathered(node, port);
    input.axes.iter().filter(|a| node.axes.contains(a) && !gathered.contains(a)).copied().collect()
}

/// The axes of a port's source that it gathers.
pub fn gathered(node: &PlanNode, port: usize) -> Vec<Axis> {
    let input = &node.inputs[port];
    if !matches!(node.kind.spec().inputs[port].arity, super::node::Arity::Many { .. }) {
        return Vec::new();
    }
    if input.via.is_some() && input.gathered.is_empty() { input.axes.clone() } else { input.gathered.clone() }
}

/// How many of the node's axes, from the first on, name the rows of a port that takes them one by one; `None` where it
/// needs its list as a whole.
pub fn arrives(node: &PlanNode, port: usize) -> Option<usize> {
    let input = &node.inputs[port];
    let one = input.from.is_some() && !matches!(node.kind.spec().inputs[port].arity, super::node::Arity::Many { .. });
    (one && !input.axes.is_empty() && node.axes.starts_with(&input.axes)).then_some(input.axes.len())
}

/// The same for a port that gathers, without a relation, below axes of the node.
pub fn gathers_below(node: &PlanNode, port: usize) -> Option<usize> {
    let (input, kept) = (&node.inputs[port], kept(node, port));
    let many = input.from.is_some() && input.via.is_none() && !gathered(node, port).is_empty();
    let leads = node.axes.starts_with(&kept) && input.axes.starts_with(&kept);
    (many && leads && !kept.is_empty()).then_some(kept.len())
}

/// Whether each row that reaches the port is taken by one run of the node, and once.
pub fn taken_once(node: &PlanNode, port: usize) -> bool {
    let input = &node.inputs[port];
    let many = !gathered(node, port).is_empty();
    input.via.is_none() && if many { kept(node, port).len() == node.axes.len() } else { input.axes == node.axes }
}

/// [`arrives`] for the relation by which a port gathers; `axes` are the relation's.
pub fn relation_arrives(node: &PlanNode, axes: &[Axis]) -> Option<usize> {
    (!axes.is_empty() && node.axes.starts_with(axes)).then_some(axes.len())
}

/// The list that made the axes below which port `port` of node `n` gathers.
pub fn outer(plan: &Plan, n: usize, port: usize) -> Option<OutputRef> {
    let node = &plan.nodes[n];
    let kept = kept(node, port);
    let last = *kept.last()?;
    if gathered(node, port).is_empty() {
        return None;
    }
    let mut axes = plan.nodes[last.node.0 as usize].axes.clone();
    axes.push(last);
    (axes == kept).then_some(last)
}

/// How the inputs' axes meet the node's: part of a whole map's key.
pub fn shape(node: &PlanNode) -> String {
    let mut out = format!("{} axes{}", node.axes.len(), if node.join_inner { " inner" } else { "" });
    for (i, input) in node.inputs.iter().enumerate() {
        let gathered = gathered(node, i);
        out.push_str(" |");
        for axis in &input.axes {
            match node.axes.iter().position(|a| a == axis) {
                _ if gathered.contains(axis) => out.push_str(" *"),
                Some(p) => out.push_str(&format!(" {p}")),
                None => out.push_str(" ?"),
            }
        }
        if input.via.is_some() {
            out.push_str(" via");
        }
    }
    out
}

impl Binding {
    /// `feeds` has one entry per port; `None` where it is absent.
    pub fn new(node: &PlanNode, feeds: Vec<Option<Feed>>) -> Self {
        let spec = node.kind.spec();
        let port = |(i, feed): (usize, Option<Feed>)| {
            let Some(feed) = feed else { return Port::Absent };
            let kept = kept(node, i);
            let columns = positions(&kept, &node.axes);
            let source = &node.inputs[i].axes;
            match spec.inputs[i].arity {
                super::node::Arity::Many { may_be_empty, .. } => {
                    let groups = Groups::new(node, i, known(&feed.rows));
                    let many_all = kept.is_empty() && feed.via.is_none();
                    Port::Many { feed, columns, groups, many_all, may_be_empty }
                }
                _ => {
                    let whole = columns.iter().copied().eq(0..node.axes.len()) && kept.len() == source.len();
                    Port::One { feed, columns, whole }
                }
            }
        };
        Self {
            ports: feeds.into_iter().enumerate().map(port).collect(),
            names: spec.inputs.iter().map(|p| p.name).collect(),
            inner: node.join_inner,
        }
    }

    /// The node's elements, sorted. `lenient`: names missing on one side are dropped without a word, as with an inner
    /// join (something above failed, and that is the error to tell).
    pub fn domain(&self, node: &PlanNode, lenient: bool) -> Result<Vec<Arc<str>>, ElementError> {
        if node.axes.is_empty() {
            return Ok(vec!["".into()]);
        }
        let lenient = lenient || self.inner;
        // One-axis sides that are the same list need no join: that is nearly every node.
        let mut sides: Vec<OwnedSide> = Vec::new();
        for (port, name) in self.ports.iter().zip(&self.names) {
            let (columns, names) = match port {
                Port::One { feed, columns, .. } if !columns.is_empty() => {
                    (columns, known(&feed.rows).iter().map(|r| r.name.clone()).collect())
                }
                _ => continue,
            };
            sides.push((columns.clone(), names, name));
        }
        // A list gathered below an axis may be empty there: it names elements only where nothing else does.
        for (port, name) in self.ports.iter().zip(&self.names) {
            if let Port::Many { columns, groups, feed, .. } = port {
                let covered = |c: &usize| sides.iter().any(|(have, ..)| have.contains(c));
                if !columns.iter().all(covered) {
                    let names = match &feed.outer {
                        Some(rows) => rows.iter().map(|r| r.name.clone()).collect(),
                        None => groups.by_key.keys().map(|k| k.as_str().into()).collect(),
                    };
                    sides.push((columns.clone(), names, name));
                }
            }
        }
        // Axes that only relations have.
        for (port, name) in self.ports.iter().zip(&self.names) {
            if let Port::Many { feed: Feed { via: Some(via), .. }, .. } = port {
                let columns = positions(&via.axes, &node.axes);
                if !columns.iter().all(|c| sides.iter().any(|(have, ..)| have.contains(c))) {
                    sides.push((columns, known(&via.rows).iter().map(|r| r.name.clone()).collect(), name));
                }
            }
        }
        // The side with the most axes first: the others mostly only confirm it.
        sides.sort_by_key(|(columns, ..)| std::cmp::Reverse(columns.len()));
        let mut sides = sides.into_iter();
        let Some((mut axes, mut names, mut first)) = sides.next() else {
            return Err(ElementError("no input has the axes over which the node is mapped".to_owned()));
        };
        for (columns, other, port) in sides {
            if columns == axes && names == other {
                continue;
            }
            (axes, names) = natural_join((&axes, &names, first), (&columns, &other, port), lenient)?;
            first = port;
        }
        if axes.len() != node.axes.len() {
            return Err(ElementError("no input has one of the axes over which the node is mapped".to_owned()));
        }
        let order: Vec<usize> =
            (0..axes.len()).map(|a| axes.iter().position(|b| *b == a).unwrap_or_default()).collect();
        if !order.iter().copied().eq(0..axes.len()) {
            names = names.iter().map(|n| pick(n, &order).into()).collect();
        }
        names.sort();
        names.dedup();
        Ok(names)
    }

    /// What `element` takes through each port. `hint`: the element's number, where a row may lie at once.
    pub fn take(&self, element: &str, hint: usize, live: &dyn Live) -> Result<Vec<Taken>, ElementError> {
        let ports = self.ports.iter().zip(&self.names);
        ports.map(|(port, name)| self.take_port(port, name, element, hint, live)).collect()
    }

    fn take_port(
        &self,
        port: &Port,
        name: &str,
        element: &str,
        hint: usize,
        live: &dyn Live,
    ) -> Result<Taken, ElementError> {
        match port {
            Port::Absent => Ok(Taken::Absent),
            Port::One { feed, columns, whole } => {
                let wanted = projection(element, columns, *whole);
                let found = row(feed.from, feed.rows.as_ref(), &wanted, hint, live);
                let missing = || ElementError(format!("input `{name}` has no element `{}`", shown(&wanted)));
                found.map(Taken::One).ok_or_else(missing)
            }
            Port::Many { feed, columns, may_be_empty, .. } if feed.rows.is_none() => {
                let key = pick(element, columns);
                let short = |name: &str| name.get(key.len() + JOIN.len_utf8()..).unwrap_or_default().into();
                let list: Vec<_> = live.below(feed.from, &key).into_iter().map(|(n, v)| (short(&n), v)).collect();
                if list.is_empty() && !may_be_empty {
                    return Err(empty(name));
                }
                Ok(Taken::Many(list))
            }
            Port::Many { feed, columns, groups, may_be_empty, .. } => {
                let group = groups.by_key.get(&pick(element, columns)).map_or(&[][..], Vec::as_slice);
                let value = |(short, at): &(Arc<str>, usize)| (short.clone(), known(&feed.rows)[*at].value);
                let list: Vec<(Arc<str>, ValueRef)> = match &feed.via {
                    None => group.iter().map(value).collect(),
                    Some(via) => self.related(via, name, element, group, live)?.map(value).collect(),
                };
                if list.is_empty() && !may_be_empty {
                    return Err(empty(name));
                }
                Ok(Taken::Many(list))
            }
        }
    }

    /// The members of `group` that the relation gives for `element`, in their order.
    fn related<'g>(
        &self,
        via: &Via,
        port: &str,
        element: &str,
        group: &'g [(Arc<str>, usize)],
        live: &dyn Live,
    ) -> Result<impl Iterator<Item = &'g (Arc<str>, usize)>, ElementError> {
        let relation = via.row(element, live).and_then(|value| via.relations.get(&value.hash));
        let relation =
            relation.ok_or_else(|| ElementError(format!("input `{port}`: there is no relation for this element")))?;
        let name = match via.element_at {
            Some(at) => component(element, at).to_owned(),
            None => shown(element),
        };
        let mut found = BTreeSet::new();
        for wanted in relation.0.get(&name).into_iter().flatten() {
            let at: Vec<usize> = if via.alone {
                // The group is sorted by just this name.
                group.binary_search_by(|(s, _)| (**s).cmp(wanted)).ok().into_iter().collect()
            } else {
                (0..group.len()).filter(|at| component(&group[*at].0, via.gathered_at) == wanted).collect()
            };
            if at.is_empty() && !self.inner {
                return Err(ElementError(format!(
                    "input `{port}`: `{name}` is related to `{wanted}`, which the list does not have"
                )));
            }
            found.extend(at);
        }
        Ok(found.into_iter().map(|at| &group[at]))
    }

    /// Whether the port's values are the same, or may be, for several elements.
    pub fn is_shared(&self, port: usize, axes: usize) -> bool {
        match &self.ports[port] {
            Port::Absent => false,
            Port::One { columns, .. } => columns.len() < axes,
            Port::Many { columns, feed, .. } => feed.via.is_some() || columns.len() < axes,
        }
    }

    /// The full name of the row that holds `hash` among what `element` takes through the port, if any does.
    pub fn row_of(&self, port: usize, element: &str, hash: &Digest) -> Option<Arc<str>> {
        match &self.ports[port] {
            Port::Absent => None,
            Port::One { columns, whole, .. } => Some(projection(element, columns, *whole).into()),
            Port::Many { feed, columns, groups, .. } => {
                let group = groups.by_key.get(&pick(element, columns))?;
                let rows = group.iter().map(|(_, at)| &known(&feed.rows)[*at]);
                rows.into_iter().find(|r| r.value.hash == *hash).map(|r| r.name.clone())
            }
        }
    }

    /// What enters the key for each port of `taken`.
    pub fn hashes(&self, taken: &[Taken]) -> Vec<Option<Digest>> {
        let hash = |(port, taken): (&Port, &Taken)| match (port, taken) {
            (_, Taken::Absent) => None,
            (_, Taken::One(v)) => Some(v.hash),
            (Port::Many { feed, many_all: true, .. }, Taken::Many(_)) => Some(feed.hash),
            (_, Taken::Many(list)) => Some(list_hash(list.iter().map(|(n, v)| (&**n, v.hash)))),
        };
        self.ports.iter().zip(taken).map(hash).collect()
    }
}
