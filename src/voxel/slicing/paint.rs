//! Colours of the visible voxels: per sample the nearest surface within the layer, averaged over the covered samples.

use super::{Face, groups::Groups, samples::layer_of};
use crate::{
    image::srgb,
    math::{Stop, Stopped},
    raster::{Backend, Facet, Fragment, NOTHING, Shader, Shading, Surface, Tile, fragments_in_tiles},
    voxel::{Quarters, Voxel},
};
use glam::Vec3;
use rayon::prelude::*;

/// Samples of a pixel whose layers differ by no more show one surface: it is steep.
const GAP: u16 = 3;

/// The object of a voxel that has no colour yet.
const BARE: u32 = u32::MAX;

/// How a voxel looks; `object` is the object's number in the scene.
#[derive(Clone, Copy)]
struct VoxelPaint {
    color: [u8; 4],
    normal: [i16; 2],
    object: u32,
}

impl VoxelPaint {
    fn put_on(&self, voxel: &mut Voxel) {
        let [r, g, b, _] = self.color;
        (voxel.color, voxel.normal, voxel.object) = ([r, g, b, voxel.color[3]], self.normal, self.object);
    }
}

/// Colours a face's voxels, which are sorted by (layer, y, x); their `object` becomes its number in the scene. Returns
/// the colours of their quarters if `wanted`; a quarter in which no sample is covered looks as the whole voxel does.
pub fn paint(
    backend: &dyn Backend,
    face: &Face,
    shader: &Shader,
    voxels: &mut [Voxel],
    wanted: bool,
    stop: &Stop,
) -> Result<Vec<Quarters>, Stopped> {
    let order = by_tile(face, voxels);
    let mut fine = vec![[None; 4]; if wanted { voxels.len() } else { 0 }];
    let looks = fragments_in_tiles(backend, &face.prepared, stop, |tile, fragments| {
        let list = order.of(tile.index as usize);
        let per_voxel = (face.samples * face.samples) as usize;
        let mut samples = vec![Fragment { triangle: NOTHING, depth: f32::INFINITY }; list.len() * per_voxel];
        let mut coverage = vec![0; list.len()];
        let mut met: Vec<(u16, u32)> = Vec::new();
        // By pixel; within a pixel by layer, because the voxels are.
        let mut by_pixel: Vec<usize> = (0..list.len()).collect();
        let pixel = |i: usize| (voxels[list[i] as usize].y, voxels[list[i] as usize].x);
        by_pixel.sort_by_key(|i| pixel(*i));
        for column in by_pixel.chunk_by(|a, b| pixel(*a) == pixel(*b)) {
            let (y, x) = pixel(column[0]);
            for (s, [sx, sy]) in face.samples_of(x.into(), y.into()).enumerate() {
                let mut rest = fragments.of(tile.at(sx, sy)).iter();
                let mut fragment = rest.next();
                let mut layer = 0;
                for i in column {
                    let wanted = voxels[list[*i] as usize].layer;
                    while let Some(f) = fragment {
                        layer = layer_of(face.borders, f.depth, layer);
                        if layer >= wanted {
                            if layer == wanted {
                                samples[i * per_voxel + s] = *f;
                            }
                            break;
                        }
                        fragment = rest.next();
                    }
                }
            }
            met.clear();
            met.extend(column.iter().map(|i| (voxels[list[*i] as usize].layer, 0)));
            let last = met.last().map_or(0, |m| m.0);
            for (s, [sx, sy]) in face.samples_of(x.into(), y.into()).enumerate() {
                let mut layer = 0;
                for f in fragments.of(tile.at(sx, sy)) {
                    layer = layer_of(face.borders, f.depth, layer);
                    if layer > last + GAP {
                        break;
                    }
                    met.push((layer, 1 << s));
                }
            }
            met.sort_unstable();
            let mut rest = column.iter().peekable();
            for run in met.chunk_by(|a, b| b.0 - a.0 <= GAP) {
                let samples = run.iter().fold(0, |all, m| all | m.1).count_ones() as usize;
                let end = run.last().map_or(0, |m| m.0);
                while let Some(i) = rest.next_if(|i| voxels[list[**i] as usize].layer <= end) {
                    coverage[*i] = (samples * 255 / per_voxel) as u8;
                }
            }
        }
        let mut facets = Facets { face, shader, last: None };
        let look = |(i, samples): (usize, &[Fragment])| {
            let voxel = &voxels[list[i] as usize];
            let mut mean = Mean::default();
            let mut parts: [Mean; 4] = Default::default();
            for (f, at) in samples.iter().zip(face.samples_of(voxel.x.into(), voxel.y.into())) {
                if f.triangle != NOTHING {
                    let surface = facets.at(f.triangle, at);
                    mean.add(f.triangle, f.depth, &surface);
                    if wanted {
                        let half = |i: usize| (2 * (at[i] % face.samples) / face.samples) as usize;
                        parts[half(0) + 2 * half(1)].add(f.triangle, f.depth, &surface);
                    }
                }
            }
            (mean.look(face), coverage[i], if wanted { parts.map(|p| p.color()) } else { [None; 4] })
        };
        samples.chunks(per_voxel).enumerate().map(look).collect::<Vec<_>>()
    })?;
    for (tile, looks) in looks.iter().enumerate() {
        for (i, look) in order.of(tile).iter().zip(looks) {
            let voxel = &mut voxels[*i as usize];
            match look {
                (Some(look), ..) => look.put_on(voxel),
                (None, ..) => voxel.object = BARE,
            }
            voxel.color[3] = look.1;
            if wanted {
                fine[*i as usize] = look.2;
            }
        }
    }
    voxels.par_chunk_by_mut(|a, b| a.layer == b.layer).try_for_each(|layer| paint_bare(face, shader, layer, stop))?;
    let whole = |v: &Voxel| [v.color[0], v.color[1], v.color[2], 255];
    Ok(fine.iter().zip(&*voxels).map(|(q, v)| q.map(|c| c.unwrap_or(whole(v)))).collect())
}

/// Colours those voxels of a layer in which no sample is covered: by the cut that comes nearest to the pixel's centre.
fn paint_bare(face: &Face, shader: &Shader, voxels: &mut [Voxel], stop: &Stop) -> Result<(), Stopped> {
    struct Point {
        distance: f64,
        source: u32,
        weights: [f64; 3],
    }
    let bare: Vec<usize> = (0..voxels.len()).filter(|i| voxels[*i].object == BARE).collect();
    let Some(layer) = bare.first().map(|i| usize::from(voxels[*i].layer)) else { return Ok(()) };
    let place = |i: &usize| (i32::from(voxels[*i].y), i32::from(voxels[*i].x));
    let none = || Point { distance: f64::INFINITY, source: u32::MAX, weights: [0.0; 3] };
    let mut points: Vec<Point> = bare.iter().map(|_| none()).collect();
    for border in [layer, layer + 1] {
        face.visit_cuts(border, stop, |y, x0, x1, source, cut| {
            let first = bare.partition_point(|i| place(i) < (y, x0));
            for (i, point) in bare[first..].iter().zip(&mut points[first..]).take_while(|(i, _)| place(i) <= (y, x1)) {
                let (distance, weights) = cut.nearest(voxels[*i].x.into(), voxels[*i].y.into());
                if (distance, source) < (point.distance, point.source) {
                    *point = Point { distance, source, weights };
                }
            }
        })?;
    }
    let mut facets = Facets { face, shader, last: None };
    for (i, point) in bare.iter().zip(&points) {
        debug_assert_ne!(point.source, u32::MAX, "a filled voxel has a surface");
        let number = face.soup.numbers[point.source as usize];
        let mut mean = Mean::default();
        mean.add(number, f32::INFINITY, &facets.of(number).point(point.weights));
        if let Some(look) = mean.look(face) {
            look.put_on(&mut voxels[*i]);
        }
    }
    Ok(())
}

/// The voxels of each tile of the samples, in their order.
fn by_tile(face: &Face, voxels: &[Voxel]) -> Groups {
    let side = Tile::SIDE / face.samples;
    let columns = face.screen.width.div_ceil(side);
    let tile = |v: &Voxel| (u32::from(v.y) / side * columns + u32::from(v.x) / side) as usize;
    Groups::new(face.prepared.tile_count(), voxels.iter().map(tile).zip(0..))
}

/// Triangles ready for shading; remembers the last.
struct Facets<'a, 'g> {
    face: &'a Face<'g>,
    shader: &'a Shader<'a>,
    last: Option<(u32, Facet<'a>)>,
}

impl Facets<'_, '_> {
    fn of(&mut self, triangle: u32) -> &Facet<'_> {
        let last = match self.last.take() {
            Some(last) if last.0 == triangle => last,
            _ => (triangle, self.shader.facet(&self.face.prepared.camera, triangle)),
        };
        &self.last.insert(last).1
    }

    fn at(&mut self, triangle: u32, sample: [u32; 2]) -> Surface {
        self.of(triangle).surface(f64::from(sample[0]) + 0.5, f64::from(sample[1]) + 0.5)
    }
}

/// Sums over a voxel's covered samples.
#[derive(Default)]
struct Mean {
    count: u32,
    /// Linear light.
    sum: [f32; 3],
    normal: Vec3,
    /// Triangle and depth of each.
    seen: Vec<(u32, f32)>,
}

impl Mean {
    fn add(&mut self, triangle: u32, depth: f32, surface: &Surface) {
        let light = surface.seen(&Shading::Unlit);
        self.sum = std::array::from_fn(|k| self.sum[k] + light[k]);
        self.normal += surface.normal;
        self.count += 1;
        self.seen.push((triangle, depth));
    }

    /// `None` where nothing was seen.
    fn look(&self, face: &Face) -> Option<VoxelPaint> {
        let object = self.object(face)?;
        Some(VoxelPaint { color: self.color()?, normal: octahedral(self.normal), object })
    }

    /// `None` where nothing was seen.
    fn color(&self) -> Option<[u8; 4]> {
        let [r, g, b] = self.sum.map(|s| srgb::from_linear(s / self.count as f32));
        (self.count > 0).then_some([r, g, b, 255])
    }

    /// The object of most samples; of several, the nearest, then the first. None where nothing was seen.
    fn object(&self, face: &Face) -> Option<u32> {
        let mut objects: Vec<(u32, u32, f32)> = Vec::with_capacity(self.seen.len());
        for (triangle, depth) in &self.seen {
            let object = face.prepared.geometry.object_of(*triangle);
            match objects.iter_mut().find(|o| o.0 == object) {
                Some(o) => *o = (object, o.1 + 1, o.2.min(*depth)),
                None => objects.push((object, 1, *depth)),
            }
        }
        let better = |a: &(u32, u32, f32), b: &(u32, u32, f32)| (b.1, a.2, a.0) > (a.1, b.2, b.0);
        objects.into_iter().reduce(|a, b| if better(&a, &b) { b } else { a }).map(|o| o.0)
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
