//! The writer of windows.

use super::weights::{Window, Windows};
use crate::{
    capture::{Capturing, capture},
    image::srgb,
    math::{Stop, Stopped},
    raster::{Backend, Geometry, Shader},
    scene::Scene,
    view::View,
};

/// What `cameras` see of `scene`, with `samples`² samples a pixel.
///
/// # Errors
/// Where it is stopped.
pub fn windows(
    backend: &dyn Backend,
    scene: &Scene,
    cameras: &[View],
    samples: u32,
    stop: &Stop,
) -> Result<Windows, Stopped> {
    let geometry = Geometry::new(scene);
    let shader = Shader::new(&geometry);
    let bounds = scene.bounds();
    let one = |view: &View| {
        let fine = View { width: view.width * samples, height: view.height * samples, ..*view };
        let seen = capture(backend, &shader, bounds, &fine, Capturing { layers: 1, backs: false }, stop)?;
        let layer = &seen.layers[0];
        let (w, n) = (view.width as usize, samples as usize);
        let pixels = w * view.height as usize;
        let (mut depth, mut color) = (Vec::with_capacity(pixels), Vec::with_capacity(pixels));
        for i in 0..pixels {
            let (x, y) = (i % w * n, i / w * n);
            let (mut nearest, mut sum, mut count) = (f32::INFINITY, [0.0_f32; 3], 0_u32);
            for at in (0..n * n).map(|k| (y + k / n) * w * n + x + k % n) {
                if layer.depth[at].is_finite() {
                    nearest = nearest.min(layer.depth[at]);
                    (0..3).for_each(|k| sum[k] += srgb::to_linear(layer.color[at][k]));
                    count += 1;
                }
            }
            depth.push(nearest);
            color.push(match count {
                0 => [0; 4],
                _ => {
                    let [r, g, b] = sum.map(|s| srgb::from_linear(s / count as f32));
                    // A pixel that is barely touched is still no background.
                    let alpha = (255 * count / (samples * samples)).max(1);
                    [r, g, b, alpha as u8]
                }
            });
        }
        Ok(Window { view: *view, depth: depth.into(), color: color.into() })
    };
    Ok(Windows(cameras.iter().map(one).collect::<Result<_, Stopped>>()?))
}
