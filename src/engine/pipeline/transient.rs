//! `transient = true`: the bytes of a node's outputs are not kept. That is of use only where other nodes take them, and
//! wrong where they leave the pipeline.

use super::{
    link::{Links, Output},
    problem::Problem,
    publish::FileEntry,
    require::Bound,
};

/// Refuses transient nodes whose outputs leave the pipeline, and those that nothing reads.
pub fn transient(links: &Links, files: &[FileEntry], bounds: &[Bound], problems: &mut Vec<Problem>) {
    for (at, node) in links.nodes.iter().enumerate() {
        let Some(place) = node.transient else { continue };
        let name = node.name;
        let mut refuse = |message: String, label: &str, help: &str| {
            problems.push(Problem::at(place, message, label).help(help));
        };
        if let Some((path, _)) = files.iter().find(|(_, from)| from.0 == at) {
            refuse(
                format!("[files] publishes `{path}` from `{name}`, whose outputs are not kept"),
                "transient",
                "remove it: what is published has to be kept",
            );
        }
        if bounds.iter().any(|bound| bound.from.0 == at) {
            refuse(
                format!("[require] judges `{name}`, whose outputs are not kept"),
                "transient",
                "remove it: what is judged has to be kept",
            );
        }
        let reads = |from: &Option<Output>| from.is_some_and(|from| from.0 == at);
        let mut inputs = links.nodes.iter().flat_map(|n| &n.inputs);
        let unknown = links.nodes.iter().any(|n| n.broken);
        if !unknown && !inputs.any(|i| reads(&i.from) || reads(&i.via)) {
            refuse(
                format!("no node reads an output of `{name}`"),
                "without effect",
                "a transient node makes values that other nodes take from memory",
            );
        }
    }
}
