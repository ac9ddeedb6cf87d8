//! Captures.

use super::camera::{get_view, put_view};
use crate::{
    capture::{Capture, Layer},
    engine::artifact::{Artifact, DecodeError, Decoder, Encoder},
    math::Aabb,
};
use glam::DVec3;

/// Layers that a capture may have.
const MOST: u32 = 64;

impl Artifact for Capture {
    const TYPE: &'static str = "Capture";
    const FORMAT: u32 = 2;

    fn encode(&self, out: &mut Encoder) {
        put_view(out, &self.view);
        out.array("bounds", &[self.bounds.min.to_array(), self.bounds.max.to_array()]);
        out.array("marks", &[u32::from(self.double_sided), self.layers.len() as u32]);
        for (i, layer) in self.layers.iter().enumerate() {
            out.array(format!("depth {i}"), &layer.depth);
            out.array(format!("color {i}"), &layer.color);
            out.array(format!("normal {i}"), &layer.normal);
            out.array(format!("object {i}"), &layer.object);
            out.array(format!("triangle {i}"), &layer.triangle);
        }
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let bounds = data.array::<[f64; 3]>("bounds")?;
        let marks = data.array::<u32>("marks")?;
        let ([min, max], &[double_sided, layers @ 1..=MOST]) = (&bounds[..], &marks[..]) else {
            return Err(DecodeError::section("marks", "expected a box, a mark and a number of layers"));
        };
        let layer = |i: u32| {
            Ok(Layer {
                depth: data.array(&format!("depth {i}"))?,
                color: data.array(&format!("color {i}"))?,
                normal: data.array(&format!("normal {i}"))?,
                object: data.array(&format!("object {i}"))?,
                triangle: data.array(&format!("triangle {i}"))?,
            })
        };
        let capture = Self {
            view: get_view(data)?,
            bounds: Aabb { min: DVec3::from(*min), max: DVec3::from(*max) },
            double_sided: double_sided != 0,
            layers: (0..layers).map(layer).collect::<Result<_, DecodeError>>()?,
        };
        match capture.fault() {
            Some(what) => Err(DecodeError::section("layers", what)),
            None => Ok(capture),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        engine::artifact::{from_bytes, to_bytes},
        view::View,
    };
    use std::sync::Arc;

    fn capture() -> Capture {
        let layer = Layer {
            depth: vec![1.0, f32::INFINITY].into(),
            color: vec![[1, 2, 3, 255], [0; 4]].into(),
            normal: vec![[0, 0, 32767, 0], [0; 4]].into(),
            object: vec![0, u32::MAX].into(),
            triangle: vec![7, u32::MAX].into(),
        };
        Capture {
            view: View::look_at(DVec3::ONE, DVec3::ZERO, DVec3::Y, 0.7, 2, 1, 0.1, 9.0),
            bounds: Aabb { min: DVec3::ZERO, max: DVec3::ONE },
            double_sided: true,
            layers: vec![layer.clone(), layer],
        }
    }

    #[test]
    fn decodes_what_was_encoded() {
        assert_eq!(from_bytes::<Capture>(Arc::new(to_bytes(&capture()))), Ok(capture()));
    }

    #[test]
    fn refuses_images_of_another_size() {
        let mut wrong = capture();
        wrong.layers[1].depth = vec![1.0].into();
        assert!(from_bytes::<Capture>(Arc::new(to_bytes(&wrong))).is_err());
        let mut wrong = capture();
        wrong.layers[0].depth = vec![1.0, f32::NAN].into();
        assert!(from_bytes::<Capture>(Arc::new(to_bytes(&wrong))).is_err());
    }
}
