//! What can be wrong with a relief impostor.

use crate::{formats::FormatError, texture::TextureError};

/// Why an impostor cannot be drawn, read or written.
#[derive(Debug, thiserror::Error)]
pub enum OriError {
    /// `place` names the map or the file.
    #[error("{place}: {what}")]
    Invalid { place: String, what: String },
    #[error("{file}: {error}")]
    Texture { file: String, error: TextureError },
    #[error(transparent)]
    Format(#[from] FormatError),
}

impl OriError {
    pub fn invalid(place: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Invalid { place: place.into(), what: what.into() }
    }
}
