//! The sun and the sky under which surfaces are lit.

use glam::Vec3;

/// A sun without shadows and a sky that is brighter above than below. Colours are linear and say what share of its
/// base colour a white, matt surface shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Unit vector towards the sun.
    pub to_sun: Vec3,
    pub sun: [f32; 3],
    /// Seen by surfaces that face up (+Y).
    pub sky: [f32; 3],
    /// Seen by surfaces that face down.
    pub ground: [f32; 3],
    /// Surfaces mirror the sun; `None`: they are matt.
    pub gloss: Option<Gloss>,
}

/// The highlight of Blinn's model (1977): the sun's colour times strength · (n·h)^exponent · (n·l), h halfway between the
/// directions to the sun and to the eye. The factor n·l lets it fade where the surface turns away from the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gloss {
    /// ≥ 0.
    pub strength: f32,
    /// > 0; larger makes smaller highlights.
    pub exponent: f32,
}

impl Default for Light {
    /// An afternoon sun, 50° high in the direction +X +Z, under a blue sky.
    fn default() -> Self {
        Self {
            to_sun: Vec3::new(0.454_519_48, 0.766_044_44, 0.454_519_48),
            sun: [0.72, 0.68, 0.60],
            sky: [0.30, 0.35, 0.42],
            ground: [0.17, 0.15, 0.13],
            gloss: None,
        }
    }
}

impl Light {
    /// Light that a matt white surface with the unit normal `n` reflects.
    pub fn on(&self, n: Vec3) -> [f32; 3] {
        let sun = n.dot(self.to_sun).max(0.0);
        let up = 0.5 + 0.5 * n.y;
        std::array::from_fn(|k| self.sun[k] * sun + self.ground[k] + (self.sky[k] - self.ground[k]) * up)
    }

    /// `lit` with the highlight of a surface with the unit normal `n`, seen from the unit direction `to_eye`.
    pub fn with_highlight(&self, lit: [f32; 3], n: Vec3, to_eye: Vec3) -> [f32; 3] {
        let Some(gloss) = self.gloss else { return lit };
        let h = (self.to_sun + to_eye).normalize_or_zero();
        let share = gloss.strength * libm::powf(n.dot(h).max(0.0), gloss.exponent) * n.dot(self.to_sun).max(0.0);
        std::array::from_fn(|k| lit[k] + self.sun[k] * share)
    }
}
