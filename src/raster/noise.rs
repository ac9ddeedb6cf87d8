//! A noise of the place in space, for surfaces that have no colour of their own.

use glam::DVec3;

/// Value noise: random values on a cubic lattice, blended smoothly (Perlin's 3t² − 2t³) in between; two octaves, the
/// second a quarter as large. The same place has the same value, whatever surface passes through it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Distance of the coarser lattice's points, metres, > 0.
    pub period: f64,
}

impl Noise {
    /// Between 0.05 and 0.95.
    pub fn at(&self, p: DVec3) -> f32 {
        let q = p / self.period;
        0.05 + 0.6 * octave(q, 0) + 0.3 * octave(q * 4.0, 1)
    }
}

fn octave(p: DVec3, seed: u32) -> f32 {
    let cell = p.floor();
    let t = (p - cell).as_vec3();
    let t = t * t * (3.0 - 2.0 * t);
    let [x, y, z] = cell.to_array().map(|v| v as i64 as u32);
    let mut sum = 0.0;
    for corner in 0..8_u32 {
        let [i, j, k] = [corner & 1, corner >> 1 & 1, corner >> 2];
        let side = |bit: u32, t: f32| if bit == 1 { t } else { 1.0 - t };
        let value = hash(x.wrapping_add(i), y.wrapping_add(j), z.wrapping_add(k), seed);
        sum += side(i, t.x) * side(j, t.y) * side(k, t.z) * value;
    }
    sum
}

/// A value in [0, 1) for a lattice point, by multiply and shift (Wang's integer mixing).
fn hash(x: u32, y: u32, z: u32, seed: u32) -> f32 {
    let mut h = seed;
    for v in [x, y, z] {
        h = (h ^ v).wrapping_mul(0x85eb_ca6b);
        h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
        h ^= h >> 16;
    }
    (h >> 8) as f32 / (1_u32 << 24) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_smooth_and_varied() {
        let noise = Noise { period: 2.0 };
        let values: Vec<f32> = (0..4000).map(|i| noise.at(DVec3::new(i as f64 * 0.01 - 20.0, 3.3, -7.1))).collect();
        assert!(values.windows(2).all(|w| (w[0] - w[1]).abs() < 0.03));
        let (lo, hi) = values.iter().fold((1.0_f32, 0.0_f32), |(lo, hi), v| (lo.min(*v), hi.max(*v)));
        assert!(lo >= 0.05 && hi <= 0.95 && hi - lo > 0.5, "{lo} {hi}");
    }
}
