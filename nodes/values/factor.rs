//! By which factor meshes are to be simplified.

use crate::engine::artifact::{Artifact, DecodeError, Decoder, Encoder};

/// The factor of `collapse`, or none: then its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Factor(pub Option<f64>);

impl Artifact for Factor {
    const TYPE: &'static str = "Factor";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        out.array("factor", self.0.as_slice());
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        match data.array::<f64>("factor")?[..] {
            [] => Ok(Self(None)),
            [factor] if factor.is_finite() && factor >= 1.0 => Ok(Self(Some(factor))),
            _ => Err(DecodeError::section("factor", "expected one number of at least 1, or none")),
        }
    }
}
