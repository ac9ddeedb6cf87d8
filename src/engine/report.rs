//! What came of a bake: for the program that asked for it, and for events.

use super::remote::Traffic;
use std::path::PathBuf;

/// The result of an audit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Audit {
    /// Hits that were computed again.
    pub runs: u64,
    /// Of these, those that gave other bytes.
    pub different_runs: u64,
    /// Bytes of the outputs that were compared.
    pub bytes: u64,
    /// Of these, bytes that differ, and bytes that only one of the two results has.
    pub different_bytes: u64,
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
    /// Empty where the kind has no methods.
    pub method: &'static str,
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
    /// What the measure means and its unit, as its kind says; empty where it does not.
    pub about: String,
    pub unit: String,
    /// The published picture that shows it.
    pub picture: Option<PathBuf>,
    /// The argument with which the bake takes it as it is.
    pub accept: String,
}

/// A bound of `[require]` and what a certificate says of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// With the certificate's element, where it has one: `evaluate/cell 3,4`.
    pub node: String,
    /// Path into the certificate.
    pub path: String,
    /// What stands there; absent where the path leads to no number, which misses every bound.
    pub measured: Option<f64>,
    pub min: Option<f64>,
    pub max: Option<f64>,
    /// What the measure means and its unit, as its kind says; empty where it does not.
    pub about: String,
    pub unit: String,
    pub met: bool,
}

/// Why a node ran, or gave another result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reason {
    pub node: String,
    /// What it did: `collapse ran for 3 of 7 elements`.
    pub did: String,
    /// What had changed of its key.
    pub cause: String,
    /// The node from which the change came; absent where it began here.
    pub from: Option<String>,
}

/// What came of a bake.
#[derive(Clone, Debug)]
pub struct Report {
    pub outcome: Outcome,
    /// In the order of the plan; only the nodes that were asked for.
    pub nodes: Vec<NodeReport>,
    pub errors: Vec<Failure>,
    pub unmet: Vec<Unmet>,
    /// All bounds of `[require]`, met or not; empty where nothing was published.
    pub judged: Vec<Judged>,
    pub warnings: usize,
    /// Files written in this bake, below `folder`.
    pub published: Vec<String>,
    /// Files of the outside world that nodes read or looked for, now or when their results were stored; sorted. The
    /// pipeline's own texts are not among them.
    pub files: Vec<PathBuf>,
    /// What the second level of the cache gave and took; `None` where none was asked.
    pub remote: Option<Traffic>,
    /// What came of [`Options::audit`](super::options::Options::audit); `None` where none was asked for.
    pub audit: Option<Audit>,
    /// `out/<pipeline>`, or its `rejected/` where a bound was missed.
    pub folder: PathBuf,
    /// Where a bound was missed: when the results were published that `out/<pipeline>` still holds.
    pub accepted: Option<std::time::SystemTime>,
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
