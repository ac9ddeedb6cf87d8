//! Colour of stone as a function of the place: value noise in three dimensions, so that the shape of a mesh without texture
//! coordinates can be seen without light, and what happens inside of its silhouette counts in comparisons.

use super::super::random::Random;
use glam::Vec3;

/// Cells along the unit length and weight of each octave.
const OCTAVES: [(f32, f32); 4] = [(5.0, 8.0), (11.0, 5.0), (23.0, 3.0), (47.0, 2.0)];

/// A kind of stone.
#[derive(Clone, Copy, Debug)]
pub struct Stone {
    pub seed: u64,
    /// Linear RGB.
    pub dark: [f32; 3],
    pub light: [f32; 3],
}

impl Stone {
    /// The `i`-th of a series of stones of different hues.
    pub fn nth(i: usize) -> Self {
        const PAIRS: [[[f32; 3]; 2]; 8] = [
            [[0.05, 0.13, 0.09], [0.36, 0.62, 0.45]],
            [[0.22, 0.16, 0.12], [0.85, 0.76, 0.64]],
            [[0.16, 0.07, 0.04], [0.66, 0.36, 0.20]],
            [[0.06, 0.08, 0.14], [0.44, 0.54, 0.70]],
            [[0.20, 0.14, 0.03], [0.80, 0.62, 0.22]],
            [[0.14, 0.14, 0.14], [0.78, 0.77, 0.74]],
            [[0.14, 0.04, 0.07], [0.66, 0.34, 0.40]],
            [[0.07, 0.11, 0.03], [0.48, 0.58, 0.26]],
        ];
        let [dark, light] = PAIRS[i % PAIRS.len()];
        Self { seed: i as u64, dark, light }
    }

    /// Linear RGBA of every point. The pattern is as large as `size`, metres, tells: its coarsest cells are a fifth of it.
    pub fn colors(&self, points: &[[f32; 3]], size: f32) -> Vec<[f32; 4]> {
        let scale = Some(size.recip()).filter(|s| s.is_finite()).unwrap_or(1.0);
        let total: f32 = OCTAVES.iter().map(|(_, weight)| weight).sum();
        let color = |p: &[f32; 3]| {
            let p = Vec3::from(*p) * scale;
            let sum: f32 = (OCTAVES.iter().zip(0u64..)).map(|((cells, w), i)| w * self.noise(p * *cells, i)).sum();
            // Sums of noise gather around their mean; the contrast is raised to use both colours.
            let t = ((sum / total - 0.5) * 2.4 + 0.5).clamp(0.0, 1.0);
            let mix = |c: usize| self.dark[c] + (self.light[c] - self.dark[c]) * t;
            [mix(0), mix(1), mix(2), 1.0]
        };
        points.iter().map(color).collect()
    }

    /// Value noise in [0, 1) of one octave.
    fn noise(&self, p: Vec3, octave: u64) -> f32 {
        // Beyond, cells have no numbers of 32 bits, and points no fractions.
        let p = p.clamp(Vec3::splat(-1e9), Vec3::splat(1e9));
        let cell = p.floor();
        let f = p - cell;
        let f = f * f * (Vec3::splat(3.0) - 2.0 * f);
        let cell = cell.to_array().map(|c| c as i32);
        let corner = |dx: i32, dy: i32, dz: i32| {
            let mut h = Random::new(self.seed ^ (octave << 56));
            for (c, d) in cell.into_iter().zip([dx, dy, dz]) {
                h = Random::new(h.bits() ^ u64::from(c.wrapping_add(d) as u32));
            }
            h.unit()
        };
        let along_x = |dy, dz| {
            let (a, b) = (corner(0, dy, dz), corner(1, dy, dz));
            a + (b - a) * f.x
        };
        let plane = |dz| {
            let (a, b) = (along_x(0, dz), along_x(1, dz));
            a + (b - a) * f.y
        };
        let (a, b) = (plane(0), plane(1));
        a + (b - a) * f.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_vary_and_neighbours_are_alike() {
        let stone = Stone::nth(3);
        let line: Vec<[f32; 3]> = (0..2000).map(|i| [i as f32 * 0.01, 3.0, -2.0]).collect();
        let colors = stone.colors(&line, 20.0);
        let green: Vec<f32> = colors.iter().map(|c| c[1]).collect();
        let (min, max) = green.iter().fold((1f32, 0f32), |(a, b), g| (a.min(*g), b.max(*g)));
        assert!(max - min > 0.5 * (stone.light[1] - stone.dark[1]), "{min} to {max}");
        assert!(green.windows(2).all(|w| (w[0] - w[1]).abs() < 0.03), "the noise jumps");
        assert_eq!(colors, stone.colors(&line, 20.0));
        assert_ne!(colors, Stone { seed: 9, ..stone }.colors(&line, 20.0));
    }

    #[test]
    fn every_point_has_a_colour_in_range() {
        let far = [[0.0; 3], [-1e9, 1e9, 3e38], [f32::MIN_POSITIVE; 3]];
        for size in [0.0, 1e-30, 1.0, 1e30] {
            for c in Stone::nth(0).colors(&far, size) {
                assert!(c.iter().all(|v| (0.0..=1.0).contains(v)), "{c:?} at size {size}");
            }
        }
    }
}
