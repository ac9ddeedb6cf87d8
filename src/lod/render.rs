//! The writer of windows.

use super::{weights::Window, window::WindowCamera};
use crate::{
    capture::{Capturing, capture},
    image::srgb,
    math::{Aabb, Stop, Stopped},
    raster::{Backend, Geometry, Shader},
    scene::{Object, Part, Scene},
    view::View,
};
use glam::{DAffine3, DMat4};

/// What `camera` sees of its objects, with `samples`² samples a pixel. `shapes` are the parts of each, in the order of the members.
///
/// # Errors
/// Where it is stopped.
pub fn window(
    backend: &dyn Backend,
    camera: &WindowCamera,
    shapes: &[&[Part]],
    samples: u32,
    stop: &Stop,
) -> Result<Window, Stopped> {
    let object = |((name, place), parts): (&(String, DAffine3), &&[Part])| Object {
        name: name.clone(),
        transform: DMat4::from(*place).as_mat4(),
        parts: parts.to_vec(),
    };
    let scene = Scene { objects: camera.members.iter().zip(shapes).map(object).collect() };
    let geometry = Geometry::new(&scene);
    let shader = Shader::new(&geometry);
    let view = &camera.view;
    let fine = View { width: view.width * samples, height: view.height * samples, ..*view };
    // Nothing here asks where the scene ends.
    let seen = capture(backend, &shader, Aabb::EMPTY, &fine, Capturing { layers: 1, backs: false }, stop)?;
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
}
