//! The ε-z-buffer and the blending of what passes it: sections 6.3 and 6.4.

use super::{
    Blending, Model, Reference, Selected,
    facet::{Facet, Shade},
    model::Part,
};
use crate::{
    image::srgb,
    math::{Stop, Stopped},
    raster::{Camera, Memo, NOTHING, Prepared, Rendering, Samples, Tile},
    view::View,
};
use glam::Vec3;

/// Least weight w·ρ of a fragment, the smallest normal 16-bit float: what is covered has a colour, however little it weighs, and
/// renderers can keep weights in such floats.
const LEAST: f32 = 1.0 / 16384.0;

/// The selected references seen by one view.
pub(super) struct Layers<'a> {
    view: View,
    layers: Vec<Layer<'a>>,
    /// The part of the offset that is the same everywhere.
    slack: f64,
    /// A texel of the reference comes on top of it.
    with_texel: bool,
    quality: bool,
}

struct Layer<'a> {
    index: usize,
    reference: &'a Reference,
    part: &'a Part,
    weight: f32,
    prepared: Prepared<'a>,
}

impl<'a> Layers<'a> {
    /// `view` counts samples; `side`: samples along a tile.
    pub fn new(
        model: &'a Model,
        selected: &[Selected],
        view: &View,
        side: u32,
        how: &Rendering,
        blending: &Blending,
        stop: &Stop,
    ) -> Result<Self, Stopped> {
        let layers = selected.iter().map(|s| {
            let (reference, part) = model.part(s.reference);
            let prepared = Prepared::with_tiles(&part.geometry, view, &how.options, side, stop)?;
            Ok(Layer { index: s.reference, reference, part, weight: s.weight as f32, prepared })
        });
        Ok(Self {
            view: *view,
            layers: layers.collect::<Result<_, Stopped>>()?,
            slack: blending.offset.unwrap_or(2.0 * model.dmesh().epsilon),
            with_texel: blending.offset.is_none(),
            quality: blending.quality,
        })
    }

    /// What each reference shows of a tile, one after the other.
    fn fill(&self, tile: &Tile, samples: &mut Vec<Samples>) {
        samples.resize_with(self.layers.len(), Samples::default);
        for (layer, samples) in self.layers.iter().zip(samples) {
            samples.fill(&layer.prepared, tile.index);
        }
    }

    /// Z_e at sample `at` of a tile.
    fn front(samples: &[Samples], at: usize) -> f32 {
        samples.iter().fold(f32::INFINITY, |z, s| z.min(s.depth[at]))
    }

    /// Whether a fragment at depth `z` at the sample position (px, py) counts where the nearest lies at `front`.
    fn passes(&self, layer: &Layer, z: f32, front: f32, px: f64, py: f64) -> bool {
        if z <= front || z == f32::INFINITY {
            return z < f32::INFINITY;
        }
        let z = f64::from(z);
        let behind = z - f64::from(front) - self.slack;
        behind <= 0.0 || (self.with_texel && behind <= layer.part.texel.dot(self.view.unproject(px, py, z).extend(1.0)))
    }

    /// Depth, surface and mask of the samples of a tile.
    pub fn centres(&self, tile: Tile, samples: &mut Vec<Samples>) -> (Vec<f32>, Vec<u32>, Vec<u64>) {
        self.fill(&tile, samples);
        let n = tile.pixels();
        let (mut depth, mut surface, mut mask) = (vec![f32::INFINITY; n], vec![NOTHING; n], vec![0; n]);
        for at in 0..n {
            let front = Self::front(samples, at);
            let (x, y) = tile.pixel(at);
            for (layer, s) in self.layers.iter().zip(&*samples) {
                let z = s.depth[at];
                if self.passes(layer, z, front, f64::from(x) + 0.5, f64::from(y) + 0.5) {
                    mask[at] |= 1 << layer.index;
                }
                if z == front && z < depth[at] {
                    depth[at] = z;
                    surface[at] = layer.part.first + s.triangle[at];
                }
            }
        }
        (depth, surface, mask)
    }
}

/// The pixels of a tile of samples, row by row. `camera` counts squares that are shaded each by itself.
pub(super) fn resolve(
    layers: &Layers,
    camera: &Camera,
    tile: &Tile,
    samples: &mut Vec<Samples>,
    how: &Rendering,
) -> Vec<[u8; 4]> {
    layers.fill(tile, samples);
    let s = how.samples_per_axis as usize;
    let side = s / how.shades_per_axis as usize;
    let mut brush = Brush {
        layers,
        camera,
        tile,
        samples,
        how,
        side,
        facets: layers.layers.iter().map(|_| Memo::default()).collect(),
        seen: Vec::new(),
    };
    let share = 1.0 / (s * s) as f32;
    let [r, g, b] = how.background.map(srgb::from_linear);
    let (width, height) = (tile.width as usize / s, tile.height as usize / s);
    let mut texels = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let (mut sum, mut missing) = (Vec3::ZERO, 0);
            for sy in (y * s..(y + 1) * s).step_by(side) {
                for sx in (x * s..(x + 1) * s).step_by(side) {
                    missing += brush.square(sx, sy, &mut sum);
                }
            }
            if missing == s * s {
                texels.push([r, g, b, 255]);
                continue;
            }
            let sum = (sum + Vec3::from(how.background) * missing as f32).to_array();
            let [r, g, b] = sum.map(|c| srgb::from_linear(c * share));
            texels.push([r, g, b, 255]);
        }
    }
    texels
}

struct Brush<'a> {
    layers: &'a Layers<'a>,
    camera: &'a Camera,
    tile: &'a Tile,
    samples: &'a [Samples],
    how: &'a Rendering,
    /// Samples along a square.
    side: usize,
    /// For each layer.
    facets: Vec<Memo<Facet<'a>>>,
    /// For each sample of a square and each layer: the triangle that counts there, and how it looks.
    seen: Vec<(u32, Shade)>,
}

impl Brush<'_> {
    /// Adds the normalised colours of the samples of a square, whose first is (x, y) of the tile, to `sum`; the number of those that see
    /// nothing. The samples that see the same triangle share one colour, taken at their mean position.
    fn square(&mut self, x: usize, y: usize, sum: &mut Vec3) -> usize {
        let (n, m) = (self.side, self.layers.layers.len());
        let width = self.tile.width as usize;
        let at = |k: usize| (y + k / n) * width + x + k % n;
        let count = n * n;
        self.seen.clear();
        self.seen.resize(count * m, (NOTHING, Shade::default()));
        let mut missing = 0;
        for k in 0..count {
            let front = Layers::front(self.samples, at(k));
            if front == f32::INFINITY {
                missing += 1;
                continue;
            }
            let px = (self.tile.x as usize + x + k % n) as f64 + 0.5;
            let py = (self.tile.y as usize + y + k / n) as f64 + 0.5;
            for (i, layer) in self.layers.layers.iter().enumerate() {
                let z = self.samples[i].depth[at(k)];
                if self.layers.passes(layer, z, front, px, py) {
                    self.seen[k * m + i].0 = self.samples[i].triangle[at(k)];
                }
            }
        }
        if missing == count {
            return missing;
        }
        for i in 0..m {
            self.shade(i, x, y);
        }
        for seen in self.seen.chunks(m) {
            // I = Σ C_i with C_i = w_i·ρ̄·(R, G, B, 1), divided by its alpha.
            let (mut color, mut alpha) = (Vec3::ZERO, 0.0);
            for (layer, (triangle, shade)) in self.layers.layers.iter().zip(seen) {
                if *triangle != NOTHING {
                    let quality = if self.layers.quality { shade.quality } else { 1.0 };
                    let weight = (layer.weight * quality).max(LEAST);
                    color += shade.color * weight;
                    alpha += weight;
                }
            }
            if alpha > 0.0 {
                *sum += color / alpha;
            }
        }
        missing
    }

    /// Shades what counts of layer `i` in a square.
    fn shade(&mut self, i: usize, x: usize, y: usize) {
        let (n, m) = (self.side, self.layers.layers.len());
        let layer = &self.layers.layers[i];
        for k in 0..n * n {
            let triangle = self.seen[k * m + i].0;
            if triangle == NOTHING {
                continue;
            }
            if let Some(first) = (0..k).find(|j| self.seen[j * m + i].0 == triangle) {
                self.seen[k * m + i].1 = self.seen[first * m + i].1;
                continue;
            }
            let (mut count, mut dx, mut dy) = (0, 0, 0);
            for k in (k..n * n).filter(|k| self.seen[k * m + i].0 == triangle) {
                (count, dx, dy) = (count + 1, dx + 2 * (k % n) + 1, dy + 2 * (k / n) + 1);
            }
            let place = |tile: u32, at: usize, twice: usize| {
                ((tile as usize + at) as f64 + twice as f64 / (2 * count) as f64) / n as f64
            };
            let (px, py) = (place(self.tile.x, x, dx), place(self.tile.y, y, dy));
            let facet = self.facets[i].get(triangle, || Facet::new(layer.reference, layer.part, self.camera, triangle));
            self.seen[k * m + i].1 = facet.shade(px, py, &self.how.shading);
        }
    }
}
