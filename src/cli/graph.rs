//! `farfield graph`: the plan as a drawing.

use super::{Done, pipeline::PipelineArgs, print};
use crate::engine::{
    plan::{OutputRef, Plan},
    registry::Registry,
};
use std::fmt::Write;

/// Prints a pipeline's graph for Graphviz or Mermaid
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    pipeline: PipelineArgs,
    #[arg(long, value_enum, default_value_t = Format::Dot)]
    format: Format,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Format {
    /// Graphviz: `farfield graph tdm | dot -Tsvg > tdm.svg`
    Dot,
    /// Mermaid, which Markdown renderers draw
    Mermaid,
}

pub fn run(args: &Args, registry: &Registry) -> Done {
    let plan = args.pipeline.load(registry)?;
    print(&match args.format {
        Format::Dot => dot(&plan),
        Format::Mermaid => mermaid(&plan),
    })
}

/// An edge: from, to, what flows, whether it is gathered into a list.
pub fn edges(plan: &Plan) -> impl Iterator<Item = (OutputRef, usize, String, bool)> + '_ {
    plan.nodes.iter().enumerate().flat_map(move |(to, node)| {
        let wired = node.inputs.iter().zip(&node.kind.spec().inputs);
        wired.flat_map(move |(input, port)| {
            let values = input.from.map(|from| (from, to, label(plan, from, port.name), !input.gathered.is_empty()));
            let names = input.via.map(|via| (via, to, format!("{} via", port.name), false));
            [values, names].into_iter().flatten()
        })
    })
}

/// The port's name, and the type that flows where the name does not say it.
fn label(plan: &Plan, from: OutputRef, port: &str) -> String {
    let ty = plan.nodes[from.node.0 as usize].kind.spec().outputs[from.port as usize].ty.name;
    if ty.eq_ignore_ascii_case(port) { port.to_owned() } else { format!("{port}: {ty}") }
}

/// Name, kind, and the lists over which the node is mapped.
fn caption(plan: &Plan, at: usize, newline: &str) -> String {
    let node = &plan.nodes[at];
    let mut text = node.name.clone();
    let title = node.kind.spec().title();
    if title != node.name {
        write!(text, "{newline}{title}").expect("a String takes all");
    }
    for axis in &node.axes {
        let made_by = &plan.nodes[axis.node.0 as usize];
        let port = made_by.kind.spec().outputs[axis.port as usize].name;
        write!(text, "{newline}for each of {}.{port}", made_by.name).expect("a String takes all");
    }
    text
}

fn dot(plan: &Plan) -> String {
    let mut out = format!("digraph \"{}\" {{\n  rankdir = LR;\n  node [shape = box, style = rounded];\n", plan.name);
    for at in 0..plan.nodes.len() {
        let shape = if plan.nodes[at].axes.is_empty() { "" } else { ", peripheries = 2" };
        out += &format!("  n{at} [label = \"{}\"{shape}];\n", caption(plan, at, "\\n"));
    }
    for (from, to, label, gathered) in edges(plan) {
        let style = if gathered { ", style = bold" } else { "" };
        out += &format!("  n{} -> n{to} [label = \"{label}\"{style}];\n", from.node.0);
    }
    for (i, file) in plan.files.iter().enumerate() {
        out += &format!("  f{i} [label = \"{}\", shape = note];\n  n{} -> f{i};\n", file.path, file.from.node.0);
    }
    out + "}\n"
}

fn mermaid(plan: &Plan) -> String {
    let mut out = String::from("flowchart LR\n");
    for at in 0..plan.nodes.len() {
        let (open, close) = if plan.nodes[at].axes.is_empty() { ("(\"", "\")") } else { ("[[\"", "\"]]") };
        out += &format!("  n{at}{open}{}{close}\n", caption(plan, at, "<br>"));
    }
    for (from, to, label, gathered) in edges(plan) {
        let arrow = if gathered { "==>" } else { "-->" };
        out += &format!("  n{} {arrow}|\"{label}\"| n{to}\n", from.node.0);
    }
    for (i, file) in plan.files.iter().enumerate() {
        out += &format!("  f{i}>\"{}\"]\n  n{} --> f{i}\n", file.path, file.from.node.0);
    }
    out
}
