//! The order in which nodes can run, and the cycles that forbid one.

use super::{link::Links, problem::Problem};
use petgraph::{algo::tarjan_scc, graph::DiGraph};
use std::{
    cmp::Reverse,
    collections::{BTreeSet, BinaryHeap},
};

/// Indices of all nodes, every node after what it reads and otherwise in the order of the file. Nodes of cycles, which
/// are reported, come last.
pub fn order(links: &Links, problems: &mut Vec<Problem>) -> Vec<usize> {
    let count = links.nodes.len();
    let mut feeds: Vec<Vec<u32>> = vec![Vec::new(); count];
    let mut waiting = vec![0_u32; count];
    for (at, node) in links.nodes.iter().enumerate() {
        for (from, _) in node.inputs.iter().flat_map(|i| [i.from, i.via]).flatten() {
            feeds[from].push(at as u32);
            waiting[at] += 1;
        }
    }
    let key = |at: usize| Reverse((links.nodes[at].order, at));
    let mut ready: BinaryHeap<_> = (0..count).filter(|at| waiting[*at] == 0).map(key).collect();
    let mut order = Vec::with_capacity(count);
    while let Some(Reverse((_, at))) = ready.pop() {
        order.push(at);
        for next in &feeds[at] {
            let next = *next as usize;
            waiting[next] -= 1;
            if waiting[next] == 0 {
                ready.push(key(next));
            }
        }
    }
    if order.len() < count {
        cycles(links, &feeds, problems);
        order.extend((0..count).filter(|at| waiting[*at] > 0));
    }
    order
}

/// Nodes of a cycle that are named.
const SHOWN: usize = 8;

/// One problem per group of nodes that feed each other, naming a shortest cycle through its first node.
fn cycles(links: &Links, feeds: &[Vec<u32>], problems: &mut Vec<Problem>) {
    let edges = feeds.iter().enumerate().flat_map(|(from, to)| to.iter().map(move |to| (from as u32, *to)));
    let graph = DiGraph::<(), ()>::from_edges(edges);
    for group in tarjan_scc(&graph) {
        let group: BTreeSet<usize> = group.iter().map(|i| i.index()).collect();
        let Some(first) = group.iter().copied().min_by_key(|at| links.nodes[*at].order) else { continue };
        if group.len() == 1 && !feeds[first].contains(&(first as u32)) {
            continue;
        }
        let path = circle(first, &group, feeds);
        let names: Vec<&str> = path.iter().chain([&first]).map(|at| links.nodes[*at].name).collect();
        let mut around: Vec<(&usize, &usize)> = path.iter().zip(path.iter().skip(1).chain([&first])).collect();
        around.reverse();
        let mut steps = around.into_iter().flat_map(|(from, to)| {
            let inputs = links.nodes[*to].inputs.iter();
            inputs.filter(|i| [i.from, i.via].iter().flatten().any(|o| o.0 == *from)).map(|i| i.place).take(1)
        });
        let Some(place) = steps.next() else { continue };
        let message = match &names[..] {
            [start @ .., last] if names.len() > SHOWN => {
                let more = names.len() - SHOWN;
                format!("a cycle: {} → … {more} more … → {last}", start[..SHOWN - 1].join(" → "))
            }
            _ => format!("a cycle: {}", names.join(" → ")),
        };
        let mut problem = Problem::at(place, message, "closes the cycle")
            .help("a node cannot need its own result; cut one of these ports");
        for place in steps.take(3) {
            problem = problem.also(place, "part of it");
        }
        problems.push(problem);
    }
}

/// A shortest way from `first` along `feeds` back to it, within `group`.
fn circle(first: usize, group: &BTreeSet<usize>, feeds: &[Vec<u32>]) -> Vec<usize> {
    let mut before: Vec<Option<usize>> = vec![None; feeds.len()];
    let mut queue = std::collections::VecDeque::from([first]);
    while let Some(at) = queue.pop_front() {
        for next in feeds[at].iter().map(|n| *n as usize).filter(|n| group.contains(n)) {
            if next == first {
                let mut path = vec![at];
                let mut last = at;
                while let Some(previous) = before[last].filter(|_| last != first) {
                    path.push(previous);
                    last = previous;
                }
                path.reverse();
                return path;
            }
            if before[next].is_none() {
                before[next] = Some(at);
                queue.push_back(next);
            }
        }
    }
    vec![first]
}
