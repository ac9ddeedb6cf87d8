//! What the mesh before simplification reaches.

use crate::{
    certify,
    engine::artifact::{Artifact, DecodeError, Decoder, Encoder},
};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A ceiling, and how it was looked at: as the certificates whose ceiling it may be have it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ceiling {
    pub sampling: Value,
    pub ceiling: certify::Ceiling,
}

impl Artifact for Ceiling {
    const TYPE: &'static str = "Ceiling";
    const FORMAT: u32 = 1;
    fn encode(&self, out: &mut Encoder) {
        out.json("ceiling", self);
    }
    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        data.json("ceiling")
    }
}
