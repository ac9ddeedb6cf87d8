//! Lists: over which axes each node is mapped, and what each list port gathers.
//!
//! A list output makes an axis, named by that output. A one-value port fed by a list maps its node over the list's axes,
//! and the node's outputs carry them on; a list port gathers all axes of what feeds it except those in `per`. Inputs
//! with axes are joined on those that they share; where nothing connects them the file must say `cross = true`.

use super::{
    link::{Links, Output},
    problem::Problem,
    source::TextSpan,
};
use crate::engine::node::Arity;
use crate::engine::suggest;

/// What is known of a node's axes.
#[derive(Clone, Default)]
pub struct NodeAxes {
    /// The axes over which it is mapped.
    pub mapped: Vec<Output>,
    /// Per input port: the axes of what feeds it.
    pub inputs: Vec<Vec<Output>>,
    /// Per input port: those of its axes that are gathered.
    pub gathered: Vec<Vec<Output>>,
}

/// The axes of every node; `None` where something wrong, and reported, hides them. `order` puts sources first.
pub fn infer(links: &Links, order: &[usize], problems: &mut Vec<Problem>) -> Vec<Option<NodeAxes>> {
    let mut known: Vec<Option<NodeAxes>> = vec![None; links.nodes.len()];
    for &at in order {
        known[at] = node(links, at, &known, problems);
    }
    known
}

/// The axes of an output: those of its node, then its own.
pub fn of_output(links: &Links, known: &[Option<NodeAxes>], output: Output) -> Option<Vec<Output>> {
    let mut axes = known[output.0].as_ref()?.mapped.clone();
    if matches!(links.output(output.0, output.1)?.arity, Arity::Many { .. }) {
        axes.push(output);
    }
    Some(axes)
}

fn node(links: &Links, at: usize, known: &[Option<NodeAxes>], problems: &mut Vec<Problem>) -> Option<NodeAxes> {
    let node = &links.nodes[at];
    let info = node.info.as_ref().filter(|_| !node.broken)?;
    let specs = &info.kind.spec().inputs;
    let before = problems.len();
    let inputs: Vec<Vec<Output>> = node
        .inputs
        .iter()
        .map(|input| input.from.map_or(Some(Vec::new()), |from| of_output(links, known, from)))
        .collect::<Option<_>>()?;
    if inputs.iter().all(Vec::is_empty) && node.per.is_empty() && node.cross.is_none() {
        // The common node: nothing is a list.
        for (spec, input) in specs.iter().zip(&node.inputs) {
            // One that may be left out is fed by nothing.
            if let Some(from) =
                input.from.filter(|_| matches!(spec.arity, Arity::Many { .. }) && node.of_port.is_none())
            {
                problems.push(no_list(links, spec.name, from, input.place));
            }
        }
        let gathered = vec![Vec::new(); inputs.len()];
        return (problems.len() == before).then(|| NodeAxes { mapped: Vec::new(), inputs, gathered });
    }
    let per = per(links, at, specs, &inputs, problems);
    let mut mapped: Vec<Output> = Vec::new();
    let mut gathered = vec![Vec::new(); inputs.len()];
    // Groups of inputs that shared axes connect: their axes, and the place of the first.
    let mut groups: Vec<(Vec<Output>, TextSpan)> = Vec::new();
    for (port, (spec, input)) in specs.iter().zip(&node.inputs).enumerate() {
        let Some(from) = input.from else { continue };
        let own: Vec<Output> = if matches!(spec.arity, Arity::Many { .. }) {
            if inputs[port].is_empty() && node.of_port.is_none() {
                problems.push(no_list(links, spec.name, from, input.place));
            }
            let (kept, rest): (Vec<Output>, Vec<Output>) = inputs[port].iter().partition(|a| per.contains(a));
            if rest.is_empty() && !inputs[port].is_empty() && node.of_port.is_none() {
                let message = format!("`per` leaves port `{}` nothing to gather", spec.name);
                problems.push(Problem::at(input.place, message, "all of its axes are in `per`"));
            }
            let related = |via: Output| rest.iter().any(|axis| axis.0 == via.0);
            if rest.len() > 1 && input.via.is_some_and(|via| !related(via)) {
                let message = format!("`via` picks along one axis, port `{}` gathers {}", spec.name, rest.len());
                let names: Vec<String> = rest.iter().map(|a| links.output_name(*a)).collect();
                let help = format!("name all but one of {} in `per`", suggest::list(names.iter().map(String::as_str)));
                problems.push(Problem::at(input.place, message, "several axes").help(help));
            }
            gathered[port] = rest;
            kept
        } else {
            inputs[port].clone()
        };
        mapped.extend(own.iter().filter(|a| !mapped.contains(a)).copied().collect::<Vec<_>>());
        if !own.is_empty() {
            let (touching, apart): (Vec<_>, Vec<_>) =
                groups.drain(..).partition(|(axes, _)| axes.iter().any(|a| own.contains(a)));
            let mut group = (own, input.place);
            if let Some(first) = touching.first() {
                group.1 = first.1;
            }
            group.0.extend(touching.into_iter().flat_map(|g| g.0));
            groups = apart;
            groups.push(group);
        }
    }
    groups.sort_by_key(|g| g.1);
    let sound = problems.len() == before;
    // What is wrong with the way the inputs meet leaves the axes as they are.
    crossing(links, at, &groups, problems);
    relations(links, at, &mapped, known, problems);
    sound.then_some(NodeAxes { mapped, inputs, gathered })
}

fn no_list(links: &Links, port: &str, from: Output, place: TextSpan) -> Problem {
    let output = links.output_name(from);
    let message = format!("port `{port}` gathers a list, `{output}` is a single value");
    let help = "feed it an output that is a list, or one of a node that is mapped over a list";
    Problem::at(place, message, "not a list").help(help)
}

/// The axes that `per` names.
fn per(
    links: &Links,
    at: usize,
    specs: &[crate::engine::node::PortSpec],
    inputs: &[Vec<Output>],
    problems: &mut Vec<Problem>,
) -> Vec<Output> {
    let lists = || specs.iter().zip(inputs).filter(|(s, _)| matches!(s.arity, Arity::Many { .. }));
    let mut axes = Vec::new();
    for (text, place) in &links.nodes[at].per {
        let Some(axis) = links.find(text, *place, "`per`", problems) else { continue };
        if lists().any(|(_, of_port)| of_port.contains(&axis)) {
            axes.push(axis);
            continue;
        }
        if links.nodes[at].of_port.is_some() {
            // The node that it collects for says so.
            continue;
        }
        let mut names: Vec<String> = lists().flat_map(|(_, axes)| axes).map(|a| links.output_name(*a)).collect();
        names.sort();
        names.dedup();
        let message = format!("`per`: no list port of this node has the axis `{}`", links.output_name(axis));
        let help = format!("the axes of its list ports are {}", suggest::list(names.iter().map(String::as_str)));
        problems.push(Problem::at(*place, message, "not one of its axes").help(help));
    }
    // What a part's parent says holds for those of its nodes that have such lists.
    for (text, place) in links.per_above(at) {
        let axis = links.known(text, place);
        axes.extend(axis.filter(|axis| lists().any(|(_, of_port)| of_port.contains(axis)) && !axes.contains(axis)));
    }
    axes
}

/// `cross = true` stands where groups of inputs share no axis, and nowhere else.
fn crossing(links: &Links, at: usize, groups: &[(Vec<Output>, TextSpan)], problems: &mut Vec<Problem>) {
    let node = &links.nodes[at];
    let axes = |group: &(Vec<Output>, TextSpan)| {
        let mut names: Vec<String> = group.0.iter().map(|a| links.output_name(*a)).collect();
        names.sort();
        names.dedup();
        names.join(", ")
    };
    match (groups, node.cross) {
        ([first, second, ..], None) => problems.push(
            Problem::at(
                second.1,
                format!("the inputs of `{}` share no list", node.name),
                format!("over {}", axes(second)),
            )
            .also(first.1, format!("over {}", axes(first)))
            .help("to run the node for every pair of elements, write cross = true"),
        ),
        ([] | [_], Some(place)) => problems.push(
            Problem::at(
                place,
                format!("`cross`: the inputs of `{}` have nothing to cross", node.name),
                "without effect",
            )
            .help("remove it: the lists that feed this node are already joined by name"),
        ),
        _ => {}
    }
}

/// A relation is looked up by the name of the node's own element.
fn relations(links: &Links, at: usize, mapped: &[Output], known: &[Option<NodeAxes>], problems: &mut Vec<Problem>) {
    for input in &links.nodes[at].inputs {
        let Some(via) = input.via else { continue };
        let Some(axes) = of_output(links, known, via) else { continue };
        // Where there are several lists, the one that the relation's own node made is meant.
        if mapped.len() != 1 && !mapped.iter().any(|axis| axis.0 == via.0) {
            let message =
                format!("`via` needs a node that is mapped over one list, this one is mapped over {}", mapped.len());
            let help = "another port must take the list whose names the relation knows";
            problems.push(Problem::at(input.place, message, "related to what?").help(help));
        } else if let Some(axis) = axes.iter().find(|a| !mapped.contains(a)) {
            let message = format!(
                "the relation `{}` is itself a list over `{}`",
                links.output_name(via),
                links.output_name(*axis)
            );
            problems.push(Problem::at(input.place, message, "not one relation"));
        }
    }
}
