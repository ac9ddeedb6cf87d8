//! What can be wrong with an octahedral impostor.

use crate::formats::FormatError;

/// Why an impostor cannot be drawn, read or written.
#[derive(Debug, thiserror::Error)]
pub enum OctahedralError {
    /// `place` names the file.
    #[error("{place}: {what}")]
    Invalid { place: String, what: String },
    #[error(transparent)]
    Format(#[from] FormatError),
}

impl OctahedralError {
    pub fn invalid(place: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Invalid { place: place.into(), what: what.into() }
    }
}
