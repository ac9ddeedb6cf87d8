//! Colours of the visible voxels: per sample the nearest surface within the layer, averaged over the covered samples.

use super::{
    band::{Band, Found, Job},
    mask, skirt,
};
use crate::{
    image::srgb,
    math::{Stop, Stopped},
    raster::{Facet, Shader, Shading, Surface},
    voxel::Voxel,
};
use glam::Vec3;
use std::ops::Range;

/// The nearest surface at a sample.
#[derive(Clone, Copy)]
struct Sample {
    /// Inverse depth; 0 where nothing covers the sample.
    q: f64,
    source: u32,
}

/// A point of a cut, for voxels that no sample covers.
#[derive(Clone, Copy)]
struct Point {
    distance: f64,
    source: u32,
    weights: [f64; 3],
}

const NO_SAMPLE: Sample = Sample { q: 0.0, source: u32::MAX };
const NO_POINT: Point = Point { distance: f64::INFINITY, source: u32::MAX, weights: [0.0; 3] };

/// The visible voxels of a band in layers `batch`, whose masks say which they are; sorted by (layer, y, x), `object`
/// being the object's number in the scene. Also where each layer of the batch ends.
pub fn paint(
    band: &Band,
    job: &Job,
    shader: &Shader,
    batch: &Range<u16>,
    stop: &Stop,
) -> Result<(Vec<Voxel>, Vec<usize>), Stopped> {
    let slots = Slots::new(band, job);
    let n = job.samples.0 as i32;
    let per_voxel = (n * n) as usize;
    let mut samples = vec![NO_SAMPLE; slots.count * per_voxel];
    let mut points = vec![NO_POINT; slots.count];
    let top = band.rows.start as i32;
    let row_of = |layer: u16, y: i32| usize::from(layer - batch.start) * band.height() + (y - top) as usize;
    band.visit(job, batch, stop, |item, found| match found {
        Found::Samples { layer, y, x0, x1 } => {
            let depths = item.depths(job.inverse);
            slots.each(row_of(layer, y / n), x0 / n, x1 / n, |x, slot| {
                for sx in (x as i32 * n).max(x0)..=(x as i32 * n + n - 1).min(x1) {
                    let sample = &mut samples[slot * per_voxel + (y % n * n + sx % n) as usize];
                    let q = depths.at(job.samples, sx, y);
                    if (q, sample.source) > (sample.q, item.source) {
                        *sample = Sample { q, source: item.source };
                    }
                }
            });
        }
        Found::Cut { layer, y, x0, x1, cut } => slots.each(row_of(layer, y), x0, x1, |x, slot| {
            let point = &mut points[slot];
            let (distance, weights) = cut.nearest(x, y as u32);
            if (distance, item.source) < (point.distance, point.source) {
                *point = Point { distance, source: item.source, weights };
            }
        }),
    })?;

    let mut looks = Looks { job, shader, last: None };
    let mut voxels = Vec::with_capacity(slots.count);
    let mut ends = Vec::with_capacity(batch.len());
    for layer in batch.clone() {
        stop.check()?;
        for y in band.rows.clone() {
            slots.each(row_of(layer, y as i32), 0, job.screen.width as i32 - 1, |x, slot| {
                let mut mean = Mean::default();
                for (i, sample) in samples[slot * per_voxel..][..per_voxel].iter().enumerate() {
                    if sample.source != u32::MAX {
                        let at = [x * n as u32 + i as u32 % n as u32, y * n as u32 + i as u32 / n as u32];
                        mean.add(sample.source, sample.q, &looks.at(sample.source, at));
                    }
                }
                if mean.count == 0 {
                    let point = &points[slot];
                    debug_assert_ne!(point.source, u32::MAX, "a filled voxel has a surface");
                    mean.add(point.source, 0.0, &looks.point(point.source, point.weights));
                }
                let object = mean.object(|source| job.geometry.object_of(job.soup.numbers[source as usize]));
                voxels.push(Voxel {
                    x: x as u16,
                    y: y as u16,
                    layer,
                    ring: if slots.is_hidden(row_of(layer, y as i32), x) { skirt::UNREACHED } else { 0 },
                    inside: slots.inside(row_of(layer, y as i32), x),
                    color: mean.color(),
                    normal: octahedral(mean.normal),
                    object,
                });
            });
        }
        ends.push(voxels.len());
    }
    Ok((voxels, ends))
}

/// Numbers of the visible voxels of a band.
struct Slots<'a> {
    masks: &'a [u64],
    hidden: &'a [u64],
    inside: &'a [u64],
    words: usize,
    /// Voxels before each word.
    before: Vec<u32>,
    count: usize,
}

impl<'a> Slots<'a> {
    fn new(band: &'a Band, job: &Job) -> Self {
        let mut count = 0;
        let before = band.masks.iter().map(|word| {
            let here = count;
            count += word.count_ones();
            here
        });
        let before = before.collect();
        Self {
            masks: &band.masks,
            hidden: &band.hidden,
            inside: &band.inside,
            words: job.words,
            before,
            count: count as usize,
        }
    }

    fn is_hidden(&self, row: usize, x: u32) -> bool {
        mask::get(&self.hidden[row * self.words..(row + 1) * self.words], x as i32)
    }

    fn inside(&self, row: usize, x: u32) -> u8 {
        let rows = self.inside[4 * row * self.words..].chunks(self.words).take(4);
        rows.enumerate().map(|(side, row)| u8::from(mask::get(row, x as i32)) << side).sum()
    }

    /// Calls `f` with the visible pixels x0..=x1 of a row of the masks and their numbers.
    #[inline]
    fn each(&self, row: usize, x0: i32, x1: i32, mut f: impl FnMut(u32, usize)) {
        let at = row * self.words;
        let words = &self.masks[at..at + self.words];
        mask::for_set(words, x0 as u32, x1 as u32, |x| {
            let bit = x as usize + 1;
            let below = words[bit / 64] & !(!0 << (bit % 64));
            f(x, (self.before[at + bit / 64] + below.count_ones()) as usize);
        });
    }
}

/// Shades; remembers the last triangle.
struct Looks<'a, 'g> {
    job: &'a Job<'g>,
    shader: &'a Shader<'a>,
    last: Option<(u32, Facet<'a>)>,
}

impl Looks<'_, '_> {
    fn facet(&mut self, source: u32) -> &Facet<'_> {
        let last = match self.last.take() {
            Some(last) if last.0 == source => last,
            _ => (source, self.shader.facet(&self.job.camera, self.job.soup.numbers[source as usize])),
        };
        &self.last.insert(last).1
    }

    fn at(&mut self, source: u32, sample: [u32; 2]) -> Surface {
        self.facet(source).surface(f64::from(sample[0]) + 0.5, f64::from(sample[1]) + 0.5)
    }

    fn point(&mut self, source: u32, weights: [f64; 3]) -> Surface {
        self.facet(source).point(weights)
    }
}

/// Sums over a voxel's covered samples.
#[derive(Default)]
struct Mean {
    count: u32,
    /// Linear light.
    sum: [f32; 3],
    normal: Vec3,
    /// Source and inverse depth of each.
    sources: Vec<(u32, f64)>,
}

impl Mean {
    fn add(&mut self, source: u32, q: f64, surface: &Surface) {
        let seen = surface.seen(&Shading::Unlit);
        self.sum = std::array::from_fn(|k| self.sum[k] + seen[k]);
        self.normal += surface.normal;
        self.count += 1;
        self.sources.push((source, q));
    }

    fn color(&self) -> [u8; 4] {
        let [r, g, b] = self.sum.map(|s| srgb::from_linear(s / self.count as f32));
        [r, g, b, 255]
    }

    /// The object of most samples; of several, the nearest, then the first.
    fn object(&self, object_of: impl Fn(u32) -> u32) -> u32 {
        let mut objects: Vec<(u32, u32, f64)> = Vec::with_capacity(self.sources.len());
        for (source, q) in &self.sources {
            let object = object_of(*source);
            match objects.iter_mut().find(|o| o.0 == object) {
                Some(o) => *o = (object, o.1 + 1, o.2.max(*q)),
                None => objects.push((object, 1, *q)),
            }
        }
        let rank = |o: &(u32, u32, f64)| (o.1, o.2, std::cmp::Reverse(o.0));
        let best = objects.into_iter().reduce(|a, b| if rank(&b) > rank(&a) { b } else { a });
        best.map_or(0, |o| o.0)
    }
}

/// A direction as an octahedral normal scaled to ±32767; (0, 0, 1) where it has no length.
pub fn octahedral(n: Vec3) -> [i16; 2] {
    let size = n.x.abs() + n.y.abs() + n.z.abs();
    if !(size > 0.0 && size.is_finite()) {
        return [0, 0];
    }
    let (x, y) = (n.x / size, n.y / size);
    let sign = |v: f32| if v < 0.0 { -1.0 } else { 1.0 };
    let (x, y) = if n.z < 0.0 { ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)) } else { (x, y) };
    [x, y].map(|v| (v * 32767.0).round() as i16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn octahedral_normals_of_the_axes() {
        let cases = [
            (Vec3::X, [32767, 0]),
            (Vec3::NEG_X, [-32767, 0]),
            (Vec3::NEG_Y, [0, -32767]),
            (Vec3::Z, [0, 0]),
            (Vec3::NEG_Z, [32767, 32767]),
            (Vec3::ZERO, [0, 0]),
        ];
        for (n, expect) in cases {
            assert_eq!(octahedral(n), expect, "{n}");
        }
    }
}
