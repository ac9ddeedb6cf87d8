//! View cells.

use crate::{
    engine::artifact::{Artifact, DecodeError, Decoder, Encoder},
    view::Cell,
};
use glam::DVec3;

impl Artifact for Cell {
    const TYPE: &'static str = "ViewCell";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        out.array("box", &[self.centre.to_array(), self.half.to_array()]);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let stored = data.array::<[f64; 3]>("box")?;
        let [centre, half] = stored[..] else {
            return Err(DecodeError::section(
                "box",
                format!("expected centre and half extents, found {} vectors", stored.len()),
            ));
        };
        let cell = Self { centre: DVec3::from(centre), half: DVec3::from(half) };
        if !(cell.centre.is_finite() && cell.half.is_finite() && cell.half.min_element() > 0.0) {
            return Err(DecodeError::section("box", "expected a finite centre and half extents > 0"));
        }
        Ok(cell)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::artifact::{from_bytes, to_bytes};
    use std::sync::Arc;

    #[test]
    fn decodes_what_it_encoded_and_refuses_the_rest() {
        let cell = Cell { centre: DVec3::new(1.0, -2.0, 3.0), half: DVec3::new(0.5, 1.0, 2.0) };
        assert_eq!(from_bytes(Arc::new(to_bytes(&cell))), Ok(cell));
        for half in [DVec3::ZERO, DVec3::NAN, DVec3::new(1.0, -1.0, 1.0), DVec3::INFINITY] {
            assert!(from_bytes::<Cell>(Arc::new(to_bytes(&Cell { half, ..cell }))).is_err());
        }
    }
}
