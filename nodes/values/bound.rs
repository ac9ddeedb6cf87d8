//! The error that a method promises not to exceed.

use crate::engine::artifact::{Artifact, DecodeError, Decoder, Encoder};
use serde::{Deserialize, Serialize};

/// A method's own error bound, as it stands in the certificate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bound {
    /// What is bounded and by whom, such as `tdm: displacement on the screen`.
    pub kind: String,
    pub value: f64,
    /// Such as `px`.
    pub unit: String,
}

impl Artifact for Bound {
    const TYPE: &'static str = "Bound";
    const FORMAT: u32 = 1;
    fn encode(&self, out: &mut Encoder) {
        out.json("bound", self);
    }
    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        data.json("bound")
    }
}
