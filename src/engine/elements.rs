//! Elements: which runs a mapped node has, and what each of them takes from the lists above it.
//!
//! Inputs join on shared axes by name. What an input has in more axes than the node is gathered; what it has in fewer
//! is repeated.

use super::{
    hash::Digest,
    plan::{Axis, OutputRef, Plan, PlanNode, Relation},
    value::{JOIN, Row, ValueRef, list_hash, shown},
};
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

/// Rows of one output, sorted by name.
pub type Rows = Arc<Vec<Row>>;

/// What reaches a node through one input port, before it is split by element.
pub struct Feed {
    pub rows: Rows,
    /// What the rows' hash is: the value's, or the list's.
    pub hash: Digest,
    pub via: Option<Via>,
    /// For a port that gathers below the node's axes: all names of those axes, from the list that made them. An
    /// element whose own list is empty is seen only there.
    pub outer: Option<Rows>,
}

/// A relation that chooses what is gathered.
pub struct Via {
    pub rows: Rows,
    /// Axes of `rows`.
    pub axes: Vec<Axis>,
    /// Contents by hash, decoded.
    pub relations: BTreeMap<Digest, Arc<Relation>>,
    /// The component of the gathered names, and of the element's names, that the relation speaks of.
    pub gathered_at: usize,
    pub element_at: Option<usize>,
}

/// What one element takes through one port.
#[derive(Clone, Debug, PartialEq)]
pub enum Taken {
    Absent,
    One(ValueRef),
    /// By raw name (see [`JOIN`]), sorted.
    Many(Vec<(Arc<str>, ValueRef)>),
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

fn component(name: &str, at: usize) -> &str {
    name.split(JOIN).nth(at).unwrap_or("")
}

fn pick(name: &str, columns: &[usize]) -> String {
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

fn positions(of: &[Axis], within: &[Axis]) -> Vec<usize> {
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
                super::node::Arity::Many { may_be_empty } => {
                    let (key, name) = (positions(&kept, source), positions(&gathered(node, i), source));
                    let mut by_key: BTreeMap<String, Vec<(Arc<str>, usize)>> = BTreeMap::new();
                    let whole = key.is_empty() && name.iter().copied().eq(0..source.len());
                    for (at, row) in feed.rows.iter().enumerate() {
                        let short = if whole { row.name.clone() } else { pick(&row.name, &name).into() };
                        by_key.entry(pick(&row.name, &key)).or_default().push((short, at));
                    }
                    for group in by_key.values_mut() {
                        group.sort();
                    }
                    let many_all = key.is_empty() && feed.via.is_none();
                    Port::Many { feed, columns, groups: Groups { by_key }, many_all, may_be_empty }
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
                    (columns, feed.rows.iter().map(|r| r.name.clone()).collect())
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
                    sides.push((columns, via.rows.iter().map(|r| r.name.clone()).collect(), name));
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
    pub fn take(&self, element: &str, hint: usize) -> Result<Vec<Taken>, ElementError> {
        self.ports.iter().zip(&self.names).map(|(port, name)| self.take_port(port, name, element, hint)).collect()
    }

    fn take_port(&self, port: &Port, name: &str, element: &str, hint: usize) -> Result<Taken, ElementError> {
        match port {
            Port::Absent => Ok(Taken::Absent),
            Port::One { feed, columns, whole } => {
                let picked;
                let wanted = if *whole {
                    element
                } else {
                    picked = pick(element, columns);
                    &picked
                };
                if let Some(row) = feed.rows.get(hint)
                    && *row.name == *wanted
                {
                    return Ok(Taken::One(row.value));
                }
                let found = feed.rows.binary_search_by(|row| (*row.name).cmp(wanted));
                let missing = |_| ElementError(format!("input `{name}` has no element `{}`", shown(wanted)));
                Ok(Taken::One(feed.rows[found.map_err(missing)?].value))
            }
            Port::Many { feed, columns, groups, may_be_empty, .. } => {
                let group = groups.by_key.get(&pick(element, columns)).map_or(&[][..], Vec::as_slice);
                let value = |(short, at): &(Arc<str>, usize)| (short.clone(), feed.rows[*at].value);
                let list: Vec<(Arc<str>, ValueRef)> = match &feed.via {
                    None => group.iter().map(value).collect(),
                    Some(via) => {
                        let related = self.related(via, name, element, group)?;
                        group
                            .iter()
                            .filter(|(s, _)| related.contains(component(s, via.gathered_at)))
                            .map(value)
                            .collect()
                    }
                };
                if list.is_empty() && !may_be_empty {
                    return Err(ElementError(format!("input `{name}` is an empty list, which this kind cannot take")));
                }
                Ok(Taken::Many(list))
            }
        }
    }

    /// The names that the relation gives for `element`.
    fn related(
        &self,
        via: &Via,
        port: &str,
        element: &str,
        group: &[(Arc<str>, usize)],
    ) -> Result<BTreeSet<String>, ElementError> {
        // A relation that is itself mapped is taken by the element's name, or is one for all.
        let row = if via.axes.is_empty() {
            via.rows.first()
        } else {
            via.rows.iter().find(|r| *r.name == *element || element.split(JOIN).any(|c| *c == *r.name))
        };
        let relation = row.and_then(|r| via.relations.get(&r.value.hash));
        let relation =
            relation.ok_or_else(|| ElementError(format!("input `{port}`: there is no relation for this element")))?;
        let name = match via.element_at {
            Some(at) => component(element, at).to_owned(),
            None => shown(element),
        };
        let names: BTreeSet<String> = relation.0.get(&name).into_iter().flatten().cloned().collect();
        if !self.inner {
            let known: BTreeSet<&str> = group.iter().map(|(s, _)| component(s, via.gathered_at)).collect();
            if let Some(missing) = names.iter().find(|n| !known.contains(n.as_str())) {
                return Err(ElementError(format!(
                    "input `{port}`: `{name}` is related to `{missing}`, which the list does not have"
                )));
            }
        }
        Ok(names)
    }

    /// Whether the port's values are the same, or may be, for several elements.
    pub fn is_shared(&self, port: usize, axes: usize) -> bool {
        match &self.ports[port] {
            Port::Absent => false,
            Port::One { columns, .. } => columns.len() < axes,
            Port::Many { columns, feed, .. } => feed.via.is_some() || columns.len() < axes,
        }
    }

    /// The full name of the row that holds `hash` in the port's source, if any does.
    pub fn row_of(&self, port: usize, hash: &Digest) -> Option<Arc<str>> {
        match &self.ports[port] {
            Port::Absent => None,
            Port::One { feed, .. } | Port::Many { feed, .. } => {
                feed.rows.iter().find(|r| r.value.hash == *hash).map(|r| r.name.clone())
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

/// Axes as the node numbers them, names on these axes, and the port that they come from.
type OwnedSide<'a> = (Vec<usize>, Vec<Arc<str>>, &'a str);
type Side<'a> = (&'a [usize], &'a [Arc<str>], &'a str);

/// Tuples that agree on the axes that both sides have. A name that one side lacks is an error unless `lenient`, or
/// unless that side has further axes: its list below that name may be empty.
fn natural_join(a: Side, b: Side, lenient: bool) -> Result<(Vec<usize>, Vec<Arc<str>>), ElementError> {
    let shared: Vec<usize> = a.0.iter().filter(|x| b.0.contains(x)).copied().collect();
    let at =
        |axes: &[usize]| -> Vec<usize> { shared.iter().filter_map(|s| axes.iter().position(|x| x == s)).collect() };
    let (in_a, in_b) = (at(a.0), at(b.0));
    let extra: Vec<usize> = (0..b.0.len()).filter(|i| !shared.contains(&b.0[*i])).collect();
    let mut by_key: BTreeMap<String, Vec<&Arc<str>>> = BTreeMap::new();
    for name in b.1 {
        by_key.entry(pick(name, &in_b)).or_default().push(name);
    }
    let mut met = BTreeSet::new();
    let mut out = Vec::new();
    let missing = |name: &str, side: &str, other: &str| {
        ElementError(format!(
            "input `{other}` has the element `{}`, input `{side}` has not; say `join = \"inner\"` to drop it",
            shown(name)
        ))
    };
    for name in a.1 {
        let key = pick(name, &in_a);
        match by_key.get(&key) {
            Some(others) => {
                for other in others {
                    let tail = pick(other, &extra);
                    out.push(if extra.is_empty() { name.clone() } else { format!("{name}{JOIN}{tail}").into() });
                }
                met.insert(key);
            }
            None if lenient || !extra.is_empty() => {}
            None => return Err(missing(&key, b.2, a.2)),
        }
    }
    if !lenient
        && shared.len() == a.0.len()
        && let Some(key) = by_key.keys().find(|k| !met.contains(*k))
    {
        return Err(missing(key, a.2, b.2));
    }
    let axes = a.0.iter().copied().chain(extra.iter().map(|i| b.0[*i])).collect();
    Ok((axes, out))
}
