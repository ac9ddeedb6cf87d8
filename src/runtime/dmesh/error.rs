//! What can be wrong with a DMesh.

use crate::formats::FormatError;

/// Why a DMesh cannot be drawn, read or written.
#[derive(Debug, thiserror::Error)]
pub enum DmeshError {
    /// `place` names the reference or the file.
    #[error("{place}: {what}")]
    Invalid { place: String, what: String },
    #[error(transparent)]
    Format(#[from] FormatError),
}

impl DmeshError {
    pub fn invalid(place: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Invalid { place: place.into(), what: what.into() }
    }
}
