//! Captures: what a camera sees of a scene, as images of depth, colour and normals, one or more layers deep.
//!
//! One writer, the rasteriser, and many readers: depth-meshes and whatever else is made from images of a scene. The pixel centres of a
//! capture are its samples: nothing is averaged over an edge.

mod dilate;
mod render;

pub use dilate::dilate;
pub use render::{Capturing, capture};

use crate::{array::Array, math::Aabb, raster::NOTHING, view::View};
use glam::DVec3;

/// What one camera sees.
#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    pub view: View,
    /// Bounding box of the captured scene, metres; empty where there is none.
    pub bounds: Aabb,
    /// Some material shows both sides.
    pub double_sided: bool,
    /// At least one; the first is the nearest surface of every pixel.
    pub layers: Vec<Layer>,
}

/// Images of one surface for each pixel, row by row from the top; each has `view.width × view.height` elements.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Planar depth, metres; infinite where there is nothing.
    pub depth: Array<f32>,
    /// Base colour without light, sRGB-encoded; alpha 255 where there is a surface, else 0.
    pub color: Array<[u8; 4]>,
    /// Unit vectors in world space times 32,767, towards the camera; the fourth number is 0.
    pub normal: Array<[i16; 4]>,
    /// Number of the object in the scene; [`NOTHING`] where there is none.
    pub object: Array<u32>,
    /// Number of the triangle in the scene; [`NOTHING`] where there is none.
    pub triangle: Array<u32>,
    /// Occlusion, roughness and metallic from 0 to 1 as bytes; the fourth is 255 where there is a surface, else 0. Empty where not captured.
    pub orm: Array<[u8; 4]>,
    /// Emitted light, sRGB-encoded and cut at 1; alpha as `orm` has it. Empty where not captured.
    pub emissive: Array<[u8; 4]>,
}

impl Layer {
    /// No pixel shows a surface.
    pub fn is_empty(&self) -> bool {
        self.triangle.iter().all(|t| *t == NOTHING)
    }
}

impl Capture {
    /// What is wrong with its images; `None` where they are as their types say.
    pub fn fault(&self) -> Option<String> {
        let pixels = self.view.width as usize * self.view.height as usize;
        if self.layers.is_empty() {
            return Some("no layer".into());
        }
        for (i, layer) in self.layers.iter().enumerate() {
            let lengths =
                [layer.depth.len(), layer.color.len(), layer.normal.len(), layer.object.len(), layer.triangle.len()];
            if lengths.iter().any(|n| *n != pixels) {
                return Some(format!("layer {i}: images of {lengths:?} pixels, expected {pixels}"));
            }
            let optional = [layer.orm.len(), layer.emissive.len()];
            if optional != [0; 2] && optional != [pixels; 2] {
                return Some(format!("layer {i}: material images of {optional:?} pixels, expected none or {pixels}"));
            }
            if let Some(z) = layer.depth.iter().find(|z| z.is_nan() || **z < 0.0) {
                return Some(format!("layer {i}: a depth of {z}"));
            }
        }
        None
    }
}

/// A unit vector as it is stored.
pub fn pack_normal(n: DVec3) -> [i16; 4] {
    let c = |v: f64| (v * 32767.0).round().clamp(-32767.0, 32767.0) as i16;
    [c(n.x), c(n.y), c(n.z), 0]
}

#[cfg(test)]
mod tests;
