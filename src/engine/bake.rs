//! Baking a plan: what to bake with, what came of it.

use super::{error::EngineError, events::Events, plan::Plan};
use crate::math::Stop;
use std::path::PathBuf;

/// How to bake. None of these may change the bytes that come out.
#[derive(Clone, Debug)]
pub struct Options {
    /// The cache folder; made where it is missing.
    pub cache: PathBuf,
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
    /// Share of the hits, 0 to 1, that are recomputed and compared.
    pub audit: f64,
    /// Where to write a Chrome trace.
    pub profile: Option<PathBuf>,
}

impl Options {
    pub fn new(cache: impl Into<PathBuf>, out: impl Into<PathBuf>) -> Self {
        Self {
            cache: cache.into(),
            out: out.into(),
            jobs: 0,
            memory: 0,
            only: Vec::new(),
            force: Vec::new(),
            keep_going: false,
            dry_run: false,
            audit: 0.0,
            profile: None,
        }
    }
}

/// How a bake ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    Baked,
    /// A node failed; nothing was published.
    Failed,
    /// A bound of `[require]` was missed; the result lies in `rejected/`.
    NotMet,
    Interrupted,
}

impl Outcome {
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Baked => 0,
            Self::Failed => 1,
            Self::NotMet => 3,
            Self::Interrupted => 130,
        }
    }
}

/// What a dry run says of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Forecast {
    Hit,
    /// At least one element has to run.
    Runs,
    /// Something above it runs; whether it runs too depends on what comes out there.
    MayRun,
}

/// What became of one node.
#[derive(Clone, Debug)]
pub struct NodeReport {
    pub name: String,
    pub kind: &'static str,
    /// Elements taken from the cache. A node that is not mapped counts as one element.
    pub hits: u64,
    /// Elements that ran to the end.
    pub runs: u64,
    pub failed: u64,
    /// Elements that could not run because something that they need failed.
    pub skipped: u64,
    /// Summed over the runs.
    pub seconds: f64,
    /// Only in a dry run.
    pub forecast: Option<Forecast>,
}

/// A failed element and its cause.
#[derive(Clone, Debug)]
pub struct Failure {
    pub node: String,
    pub element: Option<String>,
    pub message: String,
}

/// A missed bound of `[require]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Unmet {
    pub node: String,
    /// Path into the certificate.
    pub path: String,
    /// What stands there; absent where the path leads to no number.
    pub measured: Option<f64>,
    pub min: Option<f64>,
    pub max: Option<f64>,
}

/// What came of a bake.
#[derive(Clone, Debug)]
pub struct Report {
    pub outcome: Outcome,
    /// In the order of the plan; only the nodes that were asked for.
    pub nodes: Vec<NodeReport>,
    pub errors: Vec<Failure>,
    pub unmet: Vec<Unmet>,
    pub warnings: usize,
    /// Files written in this bake, below `folder`.
    pub published: Vec<String>,
    /// `out/<pipeline>`, or its `rejected/` where a bound was missed.
    pub folder: PathBuf,
    /// Wall clock.
    pub seconds: f64,
    /// Highest resident memory of the process in bytes, where the system tells.
    pub peak_memory: Option<u64>,
}

impl Report {
    pub fn hits(&self) -> u64 {
        self.nodes.iter().map(|n| n.hits).sum()
    }
    pub fn runs(&self) -> u64 {
        self.nodes.iter().map(|n| n.runs).sum()
    }
}

/// Bakes `plan`. Failures of nodes stand in the report; an error means that the engine itself could not go on.
pub fn bake(plan: &Plan, options: &Options, stop: &Stop, events: &dyn Events) -> Result<Report, EngineError> {
    let _ = (plan, options, stop, events);
    Err(EngineError::Again("not built yet".into()))
}
