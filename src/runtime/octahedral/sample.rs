//! Samples of a frame: filtered as a renderer's sampler does, without reading beyond the frame.

use crate::{array::Array, image::srgb, octahedral::Atlas};
use glam::{DVec2, Vec3};

/// A frame in the atlases of all levels.
#[derive(Clone, Copy)]
pub(super) struct Frame<'a> {
    pub levels: &'a [Atlas],
    pub column: u32,
    pub row: u32,
    /// Texels along its side on the base level.
    pub tile: u32,
}

/// Four texels of a level and their shares.
struct Quad {
    at: [usize; 4],
    share: [f32; 4],
}

impl Quad {
    fn mean(&self, image: &Array<[u8; 4]>, k: usize) -> f32 {
        (0..4).map(|i| f32::from(image[self.at[i]][k]) * self.share[i]).sum()
    }

    fn light(&self, image: &Array<[u8; 4]>) -> Vec3 {
        (0..4)
            .map(|i| {
                let [r, g, b, _] = image[self.at[i]];
                Vec3::new(srgb::to_linear(r), srgb::to_linear(g), srgb::to_linear(b)) * self.share[i]
            })
            .sum()
    }

    fn normal(&self, image: &Array<[u8; 4]>) -> Vec3 {
        Vec3::from([0, 1, 2].map(|k| self.mean(image, k) / 127.5 - 1.0))
    }
}

impl<'a> Frame<'a> {
    /// The texels around `uv` (in the frame, v down) on a level; those beyond the frame are its outermost.
    fn quad(&self, level: usize, uv: DVec2) -> Quad {
        let side = self.tile >> level;
        let most = f64::from(side - 1);
        let p = (uv * f64::from(side) - 0.5).clamp(DVec2::ZERO, DVec2::splat(most));
        let (x, y) = (p.x as u32, p.y as u32);
        let (fx, fy) = ((p.x - f64::from(x)) as f32, (p.y - f64::from(y)) as f32);
        let (dx, dy) = (usize::from(x + 1 < side), usize::from(y + 1 < side));
        let width = self.levels[level].side as usize;
        let first = (self.row * side + y) as usize * width + (self.column * side + x) as usize;
        Quad {
            at: [first, first + dx, first + dy * width, first + dy * width + dx],
            share: [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy],
        }
    }

    /// What `value` gives on the two levels around `level`, mixed.
    fn mix<V>(&self, uv: DVec2, level: f32, value: impl Fn(&Atlas, &Quad) -> V) -> V
    where
        V: std::ops::Mul<f32, Output = V> + std::ops::Add<Output = V>,
    {
        let last = self.levels.len() - 1;
        let low = (level as usize).min(last);
        let part = (level - low as f32).clamp(0.0, 1.0);
        let at = |l: usize| value(&self.levels[l], &self.quad(l, uv));
        if part > 0.0 && low < last { at(low) * (1.0 - part) + at(low + 1) * part } else { at(low) }
    }

    /// Height over the plane through the centre, radii.
    pub fn height(&self, uv: DVec2, level: f32) -> f64 {
        f64::from(self.mix(uv, level, |atlas, quad| quad.mean(&atlas.normal, 3))) / 127.5 - 1.0
    }

    /// Share that the object covers, 0 to 1.
    pub fn coverage(&self, uv: DVec2, level: f32) -> f32 {
        self.mix(uv, level, |atlas, quad| quad.mean(&atlas.color, 3)) / 255.0
    }

    /// Linear.
    pub fn color(&self, uv: DVec2, level: f32) -> Vec3 {
        self.mix(uv, level, |atlas, quad| quad.light(&atlas.color))
    }

    /// World space, not unit.
    pub fn normal(&self, uv: DVec2, level: f32) -> Vec3 {
        self.mix(uv, level, |atlas, quad| quad.normal(&atlas.normal))
    }

    /// Linear; black where nothing emits light.
    pub fn emissive(&self, uv: DVec2, level: f32) -> Vec3 {
        self.mix(uv, level, |atlas, quad| atlas.emissive.as_ref().map_or(Vec3::ZERO, |image| quad.light(image)))
    }
}
