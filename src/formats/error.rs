//! What can be wrong with a file.

use crate::math::Stopped;
use std::path::{Path, PathBuf};

/// Why a file gave no scene, or a scene no file.
#[derive(Clone, Debug, thiserror::Error)]
pub enum FormatError {
    #[error("{}: no such file", file.display())]
    Missing { file: PathBuf },
    #[error("{}: {what}", file.display())]
    Unreadable { file: PathBuf, what: String },
    #[error("{}: unknown kind of file; expected .glb, .gltf, .obj, .ply or .toml", file.display())]
    Kind { file: PathBuf },
    #[error("{}: {place}: {what}", file.display())]
    Invalid { file: PathBuf, place: String, what: String },
    #[error("{}: {place}: {found} {what}; the limit is {limit}", file.display())]
    Limit { file: PathBuf, place: String, what: &'static str, found: u64, limit: u64 },
    #[error(
        "{}: `{target}` lies outside the scene's folder {}; `--allow-outside` permits it",
        file.display(),
        shown(folder)
    )]
    Outside { file: PathBuf, target: String, folder: PathBuf },
    #[error(
        "{}: this link leads to {}, outside the scene's folder {}; `--allow-outside` permits it",
        file.display(),
        to.display(),
        shown(folder)
    )]
    Link { file: PathBuf, to: PathBuf, folder: PathBuf },
    #[error("{object}: {what}")]
    Unwritable { object: String, what: String },
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// A folder for a message; the working folder has no name.
fn shown(folder: &Path) -> std::path::Display<'_> {
    if folder.as_os_str().is_empty() { Path::new(".").display() } else { folder.display() }
}

impl FormatError {
    pub fn invalid(file: &Path, place: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Invalid { file: file.to_owned(), place: place.into(), what: what.into() }
    }
}
