//! FLIP: how visible the difference of two pictures is when they are shown in turn.
//!
//! Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", 2020, by NVIDIA's own code (`nv-flip`),
//! which is C++: its last digits may depend on the machine, so results are rounded before they are stored.

use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, FlipPool};

/// The mean FLIP error in [0, 1], at the paper's default of 67 pixels per degree of the eye.
/// Both pictures are sRGB, `width` × `height`, three bytes a pixel.
pub fn flip(original: &[u8], other: &[u8], width: u32, height: u32) -> f64 {
    let original = FlipImageRgb8::with_data(width, height, original);
    let other = FlipImageRgb8::with_data(width, height, other);
    let map = nv_flip::flip(original, other, DEFAULT_PIXELS_PER_DEGREE);
    f64::from(FlipPool::from_image(&map).mean())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pictures_do_not_flip_and_black_against_white_does() {
        let (black, white) = ([0_u8; 32 * 32 * 3], [255_u8; 32 * 32 * 3]);
        assert!(flip(&black, &black, 32, 32) < 1e-6);
        assert!(flip(&black, &white, 32, 32) > 0.9);
    }
}
