//! Captures.

use super::camera::{get_view, put_view};
use crate::{
    array::Array,
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
        let materials = self.layers.iter().any(|l| !l.orm.is_empty());
        let marks = u32::from(self.double_sided) | u32::from(materials) << 1;
        out.array("marks", &[marks, self.layers.len() as u32]);
        for (i, layer) in self.layers.iter().enumerate() {
            out.array(format!("depth {i}"), &layer.depth);
            out.array(format!("color {i}"), &layer.color);
            out.array(format!("normal {i}"), &layer.normal);
            out.array(format!("object {i}"), &layer.object);
            out.array(format!("triangle {i}"), &layer.triangle);
            if materials {
                out.array(format!("orm {i}"), &layer.orm);
                out.array(format!("emissive {i}"), &layer.emissive);
            }
        }
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let bounds = data.array::<[f64; 3]>("bounds")?;
        let marks = data.array::<u32>("marks")?;
        let ([min, max], &[marks @ 0..=3, layers @ 1..=MOST]) = (&bounds[..], &marks[..]) else {
            return Err(DecodeError::section("marks", "expected a box, a mark and a number of layers"));
        };
        let optional = |name: String| match marks & 2 {
            0 => Ok(Array::default()),
            _ => data.array(&name),
        };
        let layer = |i: u32| {
            Ok(Layer {
                depth: data.array(&format!("depth {i}"))?,
                color: data.array(&format!("color {i}"))?,
                normal: data.array(&format!("normal {i}"))?,
                object: data.array(&format!("object {i}"))?,
                triangle: data.array(&format!("triangle {i}"))?,
                orm: optional(format!("orm {i}"))?,
                emissive: optional(format!("emissive {i}"))?,
            })
        };
        let capture = Self {
            view: get_view(data)?,
            bounds: Aabb { min: DVec3::from(*min), max: DVec3::from(*max) },
            double_sided: marks & 1 != 0,
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
            orm: Array::default(),
            emissive: Array::default(),
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
    fn materials_are_kept() {
        let mut with = capture();
        for layer in &mut with.layers {
            layer.orm = vec![[255, 128, 0, 255], [0; 4]].into();
            layer.emissive = vec![[9, 8, 7, 255], [0; 4]].into();
        }
        assert_eq!(from_bytes::<Capture>(Arc::new(to_bytes(&with))), Ok(with.clone()));
        // Of one layer only.
        with.layers[1].orm = Array::default();
        assert!(from_bytes::<Capture>(Arc::new(to_bytes(&with))).is_err());
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
