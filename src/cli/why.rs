//! `farfield why`.

use super::{Done, folders::CacheArg, pipeline::PipelineArgs, print};
use crate::engine::{bake::Options, registry::Registry, why::why};
use std::path::PathBuf;

/// Explains why a node, or one of its elements, last ran
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    pipeline: PipelineArgs,
    /// NODE, or NODE/ELEMENT
    what: String,
    #[command(flatten)]
    cache: CacheArg,
    /// The folder of the results
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
}

pub fn run(args: &Args, registry: &Registry) -> Done {
    let plan = args.pipeline.load(registry)?;
    let answer = why(&plan, &Options::new(args.cache.folder(), &args.out), &args.what)?;
    print(&format!("{}\n", answer.trim_end()))
}
