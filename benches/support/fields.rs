//! Voxel fields of simple scenes, made directly in voxel space, for tests and benchmarks.
//!
//! The including module must have `voxel` in scope.

use super::{
    view::Cell,
    voxel::{Field, Frustum, Slices, Voxel},
};

/// Filled voxels (x, y, layer) of parallelograms, before anything is hidden.
pub struct Solid {
    pub size: [u32; 2],
    pub layers: u32,
    filled: Vec<bool>,
}

impl Solid {
    pub fn new(width: u32, height: u32, layers: u32) -> Self {
        Self { size: [width, height], layers, filled: vec![false; (width * height * layers) as usize] }
    }

    fn at(&self, x: i64, y: i64, l: i64) -> Option<usize> {
        let (w, h) = (i64::from(self.size[0]), i64::from(self.size[1]));
        let inside = (0..w).contains(&x) && (0..h).contains(&y) && (0..i64::from(self.layers)).contains(&l);
        inside.then_some(((l * h + y) * w + x) as usize)
    }

    /// Fills what the parallelogram `origin + s·u + t·v` passes through; z in layers. Where it passes from one layer to the
    /// next, both are filled, as `render-slices` does along the borders.
    pub fn patch(&mut self, origin: [f64; 3], u: [f64; 3], v: [f64; 3]) {
        let steps = |d: [f64; 3]| (d.iter().map(|c| c.abs()).fold(0.0, f64::max) * 4.0).ceil().max(1.0) as u32;
        let (m, n) = (steps(u), steps(v));
        let reach = u[2].abs() / f64::from(m) + v[2].abs() / f64::from(n);
        for i in 0..=m {
            for j in 0..=n {
                let (s, t) = (f64::from(i) / f64::from(m), f64::from(j) / f64::from(n));
                let p: [f64; 3] = std::array::from_fn(|k| origin[k] + s * u[k] + t * v[k]);
                for z in [p[2] + 0.5 - reach, p[2] + 0.5 + reach] {
                    if let Some(i) = self.at(p[0].floor() as i64, p[1].floor() as i64, z.floor() as i64) {
                        self.filled[i] = true;
                    }
                }
            }
        }
    }

    /// A house: front at layer `z`, `depth` layers deep, its back shrunk towards the picture's centre by `shrink` per layer.
    pub fn house(&mut self, x: [f64; 2], y: [f64; 2], z: f64, depth: f64, shrink: f64) {
        let centre = self.size.map(|s| f64::from(s) / 2.0);
        let f = libm::pow(1.0 - shrink, depth);
        let back =
            |x: f64, y: f64| [(centre[0] + (x - centre[0]) * f) - x, (centre[1] + (y - centre[1]) * f) - y, depth];
        let (w, h) = (x[1] - x[0], y[1] - y[0]);
        self.patch([x[0], y[0], z], [w, 0.0, 0.0], [0.0, h, 0.0]);
        self.patch([x[0], y[0], z], [w, 0.0, 0.0], back(x[0], y[0]));
        self.patch([x[0], y[0], z], [0.0, h, 0.0], back(x[0], y[0]));
        self.patch([x[1], y[0], z], [0.0, h, 0.0], back(x[1], y[0]));
    }

    /// The voxels that stay visible (section 4.2), as a field of frustum 0.
    pub fn field(&self) -> Field {
        let [w, h] = self.size;
        let mut hidden = vec![false; (w * h) as usize];
        let mut voxels = Vec::new();
        for l in 0..self.layers {
            let layer = &self.filled[(l * w * h) as usize..((l + 1) * w * h) as usize];
            for y in 0..h {
                for x in 0..w {
                    let i = (y * w + x) as usize;
                    if layer[i] && !hidden[i] {
                        voxels.push(voxel(x, y, l));
                    }
                }
            }
            let solid: Vec<bool> = layer.iter().zip(&hidden).map(|(a, b)| *a || *b).collect();
            for y in 0..h {
                for x in 0..w {
                    let inside = x > 0 && y > 0 && x + 1 < w && y + 1 < h;
                    hidden[(y * w + x) as usize] =
                        inside && (y - 1..=y + 1).all(|j| (x - 1..=x + 1).all(|i| solid[(j * w + i) as usize]));
                }
            }
        }
        Field { frustum: 0, voxels: voxels.into(), objects: vec!["thing".into()], ..Field::default() }
    }
}

pub fn voxel(x: u32, y: u32, layer: u32) -> Voxel {
    let shade = (x * 7 + y * 13 + layer * 29) as u8;
    Voxel {
        x: x as u16,
        y: y as u16,
        layer: layer as u16,
        ring: 0,
        inside: 0,
        color: [shade, shade / 2, 128, 255],
        normal: [0, 0],
        object: 0,
    }
}

/// A small generator of numbers below `n` (xorshift).
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, n: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 32) % u64::from(n)) as u32
    }
}

/// A plain with houses up to the horizon, `width` pixels wide and a fifth as high.
pub fn skyline(width: u32, layers: u32, houses: u32, seed: u64) -> Solid {
    let height = width / 5;
    let mut solid = Solid::new(width, height, layers);
    let (w, h, n) = (f64::from(width), f64::from(height), f64::from(layers - 1));
    // The plain rises in the picture with distance.
    let ground = |z: f64| h * (1.0 - 0.4 * z / n) - 1.0;
    solid.patch([0.0, ground(0.0), 0.0], [w, 0.0, 0.0], [0.0, ground(n) - ground(0.0), n]);
    let mut random = Random(seed * 2 + 1);
    for _ in 0..houses {
        let z = f64::from(random.below(layers - 3));
        let x = f64::from(random.below(width));
        let size = [8 + random.below(width / 24), 6 + random.below(height / 3)].map(f64::from);
        let foot = ground(z);
        solid.house([x, x + size[0]], [foot - size[1], foot], z, f64::from(1 + random.below(3)), 0.01);
    }
    solid
}

/// One frustum with as many pixels and layers as the fields need; distances are plausible but play no part in meshing.
pub fn slices(size: [u32; 2], layers: u32) -> Slices {
    use glam::DVec3;
    let frustum = Frustum {
        right: DVec3::X,
        up: DVec3::Y,
        forward: DVec3::NEG_Z,
        left: -0.5,
        right_tan: 0.5,
        bottom: -0.5,
        top: 0.5,
        size,
        across: [None; 4],
    };
    Slices {
        cell: Cell { centre: DVec3::ZERO, half: DVec3::ONE },
        frusta: vec![frustum],
        layers: (0..layers).map(|l| 10.5 + f64::from(l)).collect(),
        borders: (0..=layers).map(|l| 10.0 + f64::from(l)).collect(),
        alpha: 0.001,
    }
}
