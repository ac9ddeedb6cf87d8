//! `farfield check`.

use super::{Done, pipeline::PipelineArgs, print, terminal::say};
use crate::engine::{pipeline::name_list, plan::Plan, registry::Registry};

/// Checks a pipeline without running anything
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    pipeline: PipelineArgs,
}

pub fn run(args: &Args, registry: &Registry) -> Done {
    let plan = args.pipeline.load(registry)?;
    for doubt in &plan.doubts {
        say(super::terminal::fill(&format!("warning: {doubt}")));
    }
    // Mistakes of a row are those of the file.
    for row in 0..plan.rows.len() {
        let told = |_: &_| say(format!("in the row `{}` of [batch]", plan.rows[row]));
        args.pipeline.load_row(row, registry).inspect_err(told)?;
    }
    print(&summary(&plan))
}

/// What the pipeline consists of, in a few lines.
fn summary(plan: &Plan) -> String {
    let many = |n: usize, one: &str| format!("{n} {one}{}", if n == 1 { "" } else { "s" });
    let mapped = plan.nodes.iter().filter(|n| !n.axes.is_empty()).count();
    let mut out = format!("ok: pipeline {}, {}", plan.name, many(plan.nodes.len(), "node"));
    if mapped > 0 {
        out += &format!(" ({mapped} mapped over lists)");
    }
    out += &format!(", {}, {}\n", many(plan.files.len(), "file"), many(plan.require.len(), "requirement"));
    if !plan.rows.is_empty() {
        out += &format!(
            "  [batch] bakes it {} times: {}\n",
            plan.rows.len(),
            name_list(plan.rows.iter().map(String::as_str))
        );
    }
    for file in &plan.files {
        let node = &plan.nodes[file.from.node.0 as usize];
        let port = node.kind.spec().outputs[file.from.port as usize].name;
        out += &format!("  {} ← {}.{port}\n", file.path, node.name);
    }
    out
}
