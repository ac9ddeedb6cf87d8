//! How to bake.

use super::{facts::Facts, node::Device, remote::RemoteOptions};
use std::{path::PathBuf, sync::Arc};

/// How to bake. None of these may change the bytes that come out.
#[derive(Clone, Debug)]
pub struct Options {
    /// The cache folder; made where it is missing.
    pub cache: PathBuf,
    /// A second level of the cache that machines share; a dry run does not ask it.
    pub remote: Option<RemoteOptions>,
    /// The folder above `<pipeline>/`.
    pub out: PathBuf,
    /// Tasks and threads at a time; 0: as many as the machine has.
    pub jobs: usize,
    /// Bytes that running tasks may use together, as estimated by their kinds; 0: three quarters of the machine's memory.
    pub memory: u64,
    /// Only these nodes and what they need; empty: all. Nothing is published then. A prefix `part` names all of `part/…`.
    pub only: Vec<String>,
    /// These nodes run although the cache holds their results.
    pub force: Vec<String>,
    /// After a failure, bake whatever does not depend on it.
    pub keep_going: bool,
    /// Say what would run; run nothing, write nothing.
    pub dry_run: bool,
    /// Replace files below the output folder that no bake has published, unless this bake reads them.
    pub overwrite: bool,
    /// Share of the hits, 0 to 1, that are recomputed and compared.
    pub audit: f64,
    /// Where to write a Chrome trace.
    pub profile: Option<PathBuf>,
    /// Makes the report that is written beside what was published, as an HTML document without its doctype; `None`: none is written.
    pub report: Option<fn(&Facts) -> String>,
    /// What kinds are given to compute on ([`super::node::Ctx::device`]).
    pub device: Option<Arc<Device>>,
}

impl Options {
    pub fn new(cache: impl Into<PathBuf>, out: impl Into<PathBuf>) -> Self {
        Self {
            // `create_dir_all` cannot make `new/.`; the components of it are those of `new`.
            cache: cache.into().components().collect(),
            remote: None,
            out: out.into().components().collect(),
            jobs: 0,
            memory: 0,
            only: Vec::new(),
            force: Vec::new(),
            keep_going: false,
            dry_run: false,
            overwrite: false,
            audit: 0.0,
            profile: None,
            report: None,
            device: None,
        }
    }
}
