//! Procedural textures: tileable value noise, courses of blocks, and stains. 8-bit sRGB.

use super::random::Random;
use crate::scene::Image;
use std::sync::Arc;

const SIDE: u32 = 256;

/// Tileable value noise in [0, 1]: `cells` lattice cells along the texture's side, `octaves` halvings.
struct Noise {
    lattice: Vec<f32>,
}

const LATTICE: usize = 64;

impl Noise {
    fn new(seed: u64) -> Self {
        let mut r = Random::new(seed);
        Self { lattice: (0..LATTICE * LATTICE).map(|_| r.unit()).collect() }
    }

    fn octave(&self, u: f32, v: f32, cells: usize) -> f32 {
        let (x, y) = (u * cells as f32, v * cells as f32);
        let (x0, y0) = (x.floor(), y.floor());
        let smooth = |t: f32| t * t * (3.0 - 2.0 * t);
        let (fx, fy) = (smooth(x - x0), smooth(y - y0));
        let at = |i: usize, j: usize| {
            let (i, j) = ((x0 as usize + i) % cells, (y0 as usize + j) % cells);
            self.lattice[(j * LATTICE + i) % (LATTICE * LATTICE)]
        };
        let top = at(0, 0) + (at(1, 0) - at(0, 0)) * fx;
        let bottom = at(0, 1) + (at(1, 1) - at(0, 1)) * fx;
        top + (bottom - top) * fy
    }

    fn at(&self, u: f32, v: f32) -> f32 {
        (self.octave(u, v, 4) * 8.0 + self.octave(u, v, 8) * 4.0 + self.octave(u, v, 16) * 2.0 + self.octave(u, v, 64))
            / 15.0
    }
}

fn paint(name: &str, texel: impl Fn(f32, f32) -> [f32; 3]) -> Arc<Image> {
    let texels = (0..SIDE * SIDE).map(|i| {
        let c = texel((i % SIDE) as f32 / SIDE as f32, (i / SIDE) as f32 / SIDE as f32);
        let [r, g, b] = c.map(|c| (c * 255.0 + 0.5).clamp(0.0, 255.0) as u8);
        [r, g, b, 255]
    });
    Arc::new(Image { name: name.into(), width: SIDE, height: SIDE, texels: texels.collect() })
}

fn mix(a: [f32; 3], b: [f32; 3], t: f32) -> [f32; 3] {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
}

/// Stained material between two colours.
pub fn stained(name: &str, seed: u64, dark: [f32; 3], light: [f32; 3]) -> Arc<Image> {
    let noise = Noise::new(seed);
    paint(name, |u, v| mix(dark, light, noise.at(u, v)))
}

/// Courses of blocks, `rows` of them, each shifted by half a block against the next.
pub fn blocks(name: &str, seed: u64, rows: u32, joint: [f32; 3], dark: [f32; 3], light: [f32; 3]) -> Arc<Image> {
    let noise = Noise::new(seed);
    paint(name, |u, v| {
        let row = (v * rows as f32).floor();
        let x = u * rows as f32 * 0.5 + if (row as u32).is_multiple_of(2) { 0.0 } else { 0.5 };
        let (fx, fy) = (x - x.floor(), v * rows as f32 - row);
        let stone = (x.floor() * 7.0 + row * 13.0) % 5.0 / 5.0;
        let face = mix(dark, light, 0.6 * noise.at(u, v) + 0.4 * stone);
        if fx < 0.04 || fy < 0.08 { mix(joint, face, 0.25) } else { face }
    })
}

/// Painted bands, one above the other: steps, dots, zigzags and plain ground, worn by noise.
pub fn bands(name: &str, seed: u64, ground: [f32; 3], ink: [f32; 3], accent: [f32; 3]) -> Arc<Image> {
    const ROWS: f32 = 8.0;
    let noise = Noise::new(seed);
    paint(name, |u, v| {
        let row = (v * ROWS).floor();
        let (x, y) = (u * 12.0, v * ROWS - row);
        let fx = x - x.floor();
        let painted = match (row as u64 + seed) % 4 {
            _ if !(0.08..0.92).contains(&y) => Some(ink),
            0 => (((fx * 4.0).floor() - (y * 4.0).floor()).rem_euclid(4.0) < 2.0).then_some(ink),
            1 => ((fx - 0.5) * (fx - 0.5) + (y - 0.5) * (y - 0.5) < 0.09).then_some(accent),
            2 => ((fx - 0.5).abs() * 1.6 + 0.1 - y).abs().lt(&0.14).then_some(ink),
            _ => None,
        };
        let worn = noise.at(u, v);
        let face = mix(ground, mix(ground, accent, 0.35), worn);
        painted.map_or(face, |paint| mix(paint, face, 0.15 + 0.4 * worn))
    })
}
