//! Which shading original and stand-in are compared under: always the same for both.

use super::views::Sampling;
use crate::{
    raster::{Light, Noise, Shading},
    scene::Scene,
    view::Region,
};

/// What the user may ask for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// Unlit, or noise where the original has no colour.
    #[default]
    Auto,
    /// The base colour as it is.
    Unlit,
    /// A sun and a sky; materials that say they are unlit (a stand-in into which light was baked) stay as they are.
    Lit,
    /// Base colour times a noise of the surface point.
    Noise,
}

/// A pattern of the noise is about this many pixels wide in the middle of the selection.
const PATTERN_PX: f64 = 16.0;

/// The shading, and the certificate's words for it.
pub fn choose(choice: Choice, original: &Scene, region: &Region, sampling: &Sampling) -> (Shading, String) {
    match choice {
        Choice::Auto if colorless(original) => choose(Choice::Noise, original, region, sampling),
        Choice::Auto | Choice::Unlit => (Shading::Unlit, "unlit: base colour".into()),
        Choice::Lit => {
            let light = Light::default();
            let ([x, y, z], [r, g, b]) = (light.to_sun.to_array(), light.sun);
            let (s, e) = (light.sky, light.ground);
            let text = format!(
                "lit: sun ({r}, {g}, {b}) from ({x}, {y}, {z}), sky ({}, {}, {}) above, ({}, {}, {}) below; \
                 unlit materials as they are",
                s[0], s[1], s[2], e[0], e[1], e[2]
            );
            (Shading::Lit(light), text)
        }
        Choice::Noise => {
            let (eyes, target) = (region.bounds(), original.bounds());
            let distance = eyes.centre().distance(target.centre()).max(0.5 * target.diagonal());
            let period = PATTERN_PX * sampling.pixel_angle() * distance;
            (
                Shading::Noise(Noise { period }),
                format!("noise: base colour times a 3D value noise of period {period:.4} m"),
            )
        }
    }
}

/// Nothing but silhouettes would be seen: one colour everywhere, no texture, no vertex colours.
pub fn colorless(scene: &Scene) -> bool {
    let mut parts = scene.objects.iter().flat_map(|o| &o.parts);
    let first = scene.objects.iter().flat_map(|o| &o.parts).next().map(|p| p.material.base_color);
    parts.all(|p| {
        p.material.base_color_texture.is_none()
            && p.mesh.colors.windows(2).all(|c| c[0] == c[1])
            && Some(p.material.base_color) == first
    })
}
