//! Why the engine itself could not go on. What a kind reports is not here: it fails its node and stands in the report.

use super::suggest::{elide, nearest};
use std::path::{Path, PathBuf};

#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    #[error("cache {path}: {what}")]
    Cache { path: PathBuf, what: String },
    /// The folder holds something else, so nothing is written to it and nothing in it is deleted.
    #[error("cache {path}: {what}")]
    NotACache { path: PathBuf, what: String },
    /// The index is no sound SQLite file. The bake sets it aside and starts again.
    #[error("cache {path}: the index is damaged ({what}); the next bake or `farfield cache verify` sets it aside")]
    Damaged { path: PathBuf, what: String },
    #[error("no node `{name}` in this pipeline{}", near.as_ref().map(|n| format!("; did you mean `{n}`?")).unwrap_or_default())]
    UnknownNode { name: String, near: Option<String> },
    #[error("cannot publish {path}: {what}")]
    Publish { path: PathBuf, what: String },
    /// The second level of the cache cannot be what was asked for. One that fails while it works is a warning.
    #[error("remote cache {url}: {what}")]
    Remote { url: String, what: String },
    #[error("{path}: {what}")]
    File { path: PathBuf, what: String },
    /// The schedule cannot go on with what it believed of the cache; the bake starts again. Never seen by callers.
    #[error("{0}")]
    Again(String),
    #[error("interrupted")]
    Interrupted,
}

impl EngineError {
    /// A node that is not among those `known`, with the nearest name that is.
    pub fn unknown_node<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Self {
        Self::UnknownNode { name: elide(name, 80), near: nearest(name, known).map(str::to_owned) }
    }

    /// 2 for a wrong argument (a node, the cache's folder, the remote cache), 130 for an interruption, else 1.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::UnknownNode { .. } | Self::NotACache { .. } | Self::Remote { .. } => 2,
            Self::Interrupted => 130,
            _ => 1,
        }
    }

    pub(crate) fn cache(path: &Path, what: impl ToString) -> Self {
        Self::Cache { path: path.to_owned(), what: what.to_string() }
    }

    pub(crate) fn publish(path: &Path, what: impl ToString) -> Self {
        Self::Publish { path: path.to_owned(), what: what.to_string() }
    }
}
