//! Random maps, and checks that several tests share.

mod conforming;
mod cuts;
mod errors;
mod literal;
mod maps;
mod views;

use super::*;
use crate::view::{Projection, View};
use glam::DVec3;

/// Numbers that look random (SplitMix64).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// 0 to 1.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
}

/// A camera at the origin that looks along −Z, with a window of 2 m at depth 1 (2.2 m in orthographic views).
pub fn camera(side: u32, perspective: bool) -> View {
    let projection = match perspective {
        true => Projection::Perspective { left: -0.4, right: 0.42, bottom: -0.41, top: 0.39 },
        false => Projection::Orthographic { left: -1.0, right: 1.2, bottom: -1.1, top: 1.1 },
    };
    View {
        eye: DVec3::new(0.5, -0.25, 1.0),
        right: DVec3::X,
        up: DVec3::Y,
        forward: DVec3::NEG_Z,
        projection,
        width: side,
        height: side,
        near: 0.01,
        far: 100.0,
    }
}

pub fn map(side: usize, perspective: bool, depth: impl FnMut((usize, usize)) -> f32) -> DepthMap {
    let points = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
    DepthMap::new(camera(side as u32, perspective), points.map(depth).collect()).unwrap()
}

/// Waves, noise, steps; with background in it if asked for.
pub fn random_map(random: &mut Random, side: usize, holes: bool) -> DepthMap {
    let (fx, fy) = (random.unit() * 6.0, random.unit() * 6.0);
    let (wave, noise, steps) = (random.unit() * 0.3, random.unit() * random.unit() * 0.1, random.unit() < 0.3);
    let (cut, slope) = (random.unit(), random.unit() - 0.5);
    let (hx, hy, r) = (random.unit(), random.unit(), random.unit() * 0.4);
    let perspective = random.unit() < 0.5;
    map(side, perspective, |(i, j)| {
        let (x, y) = (i as f64 / side as f64, j as f64 / side as f64);
        let z = 2.0 + wave * libm::sin(fx * x) * libm::cos(fy * y) + noise * random.unit();
        let z = z + if steps && x + slope * y > cut { 0.7 } else { 0.0 };
        let hole = holes && ((x - hx) * (x - hx) + (y - hy) * (y - hy) < r * r || random.unit() < 0.01);
        if hole { f32::INFINITY } else { z as f32 }
    })
}

pub fn options() -> Options {
    Options { segmentation: Segmentation::None, ..Options::for_extent(2.0) }
}

/// A triangle from its smallest corner on.
pub fn turned(t: [u32; 3]) -> [u32; 3] {
    let [a, b, c] = t;
    let least = a.min(b).min(c);
    if least == a {
        t
    } else if least == b {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Triangles by grid points.
pub fn faces(t: &Triangulation) -> Vec<[u32; 3]> {
    t.triangles.iter().map(|c| c.map(|i| t.vertices[i as usize])).collect()
}

/// All measures and kinds of propagation.
pub fn all_options() -> impl Iterator<Item = Options> {
    let errors = [ErrorMeasure::Edge, ErrorMeasure::Exact];
    let kinds = [Propagation::Paper, Propagation::Refine];
    errors
        .into_iter()
        .flat_map(move |error| kinds.map(|propagation| Options { error, propagation, ..Options::for_extent(2.0) }))
}
