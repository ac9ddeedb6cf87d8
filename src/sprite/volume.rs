//! A depth sprite somewhere in the world, as the effects of section 3.3 ask it: points, borders, and rays.

use super::{CubeFrame, LayeredDepthImage};
use crate::{
    math::Aabb,
    view::{Projection, View},
};
use glam::{DAffine3, DMat3, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// Where a solid is put: scaled and turned about the centre of its cube, which goes to `centre`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Metres; `None` leaves it where it was.
    pub centre: Option<DVec3>,
    /// Above 0.
    pub scale: f64,
    /// A rotation.
    pub turn: DMat3,
}

impl Default for Placement {
    fn default() -> Self {
        Self { centre: None, scale: 1.0, turn: DMat3::IDENTITY }
    }
}

/// Texels along the side of a block that rays pass over where it holds nothing at their depth.
const BLOCK: u32 = 16;
/// Radius of the ball in which normals are estimated, texels.
const BALL: f64 = 3.5;

/// A solid as its image shows it, ready to be asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    image: LayeredDepthImage,
    /// See [`blocks`].
    blocks: Vec<[f32; 2]>,
    to_texture: DAffine3,
    to_world: DAffine3,
}

/// Where a cube around a point lies: the eight-corner test of section 3.3. Shaders know the zones by their numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Zone {
    /// No corner lies inside.
    Outside,
    /// Some corners lie inside and some outside.
    Border,
    /// All corners lie inside.
    #[default]
    Inside,
}

/// Points origin + t·direction, t ≥ 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    pub origin: DVec3,
    pub direction: DVec3,
}

impl Ray {
    /// That of a continuous pixel position; its parameter is the planar depth.
    pub fn of_pixel(view: &View, px: f64, py: f64) -> Self {
        match view.projection {
            Projection::Perspective { .. } => {
                Self { origin: view.eye, direction: view.unproject(px, py, 1.0) - view.eye }
            }
            Projection::Orthographic { .. } => Self { origin: view.unproject(px, py, 0.0), direction: view.forward },
        }
    }

    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}

/// Where a ray enters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    pub t: f64,
    /// The texel of the whole image.
    pub texel: [u32; 2],
}

/// A part of a ray that lies inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    pub enter: Entry,
    pub exit: f64,
}

impl Volume {
    pub fn new(image: LayeredDepthImage, frame: &CubeFrame, placement: &Placement) -> Self {
        let (_, centre, _) = frame.parts();
        let Placement { centre: to, scale, turn } = *placement;
        // The inverse of x ↦ to + turn·scale·(x − centre).
        let back = turn.transpose() * (1.0 / scale);
        let back = DAffine3 { matrix3: back, translation: centre - back * to.unwrap_or(centre) };
        let to_texture = frame.to_texture() * back;
        Self { blocks: blocks(&image), image, to_texture, to_world: to_texture.inverse() }
    }

    pub fn image(&self) -> &LayeredDepthImage {
        &self.image
    }

    /// Around the cube that holds the solid, metres.
    pub fn bounds(&self) -> Aabb {
        let corners = Aabb { min: DVec3::ZERO, max: DVec3::ONE }.corners();
        corners.into_iter().map(|c| self.to_world.transform_point3(c)).collect()
    }

    /// M of equation (2).
    pub fn to_texture(&self) -> &DAffine3 {
        &self.to_texture
    }

    /// The parity test on a point of the world.
    pub fn contains(&self, p: DVec3) -> bool {
        self.image.contains(self.to_texture.transform_point3(p).as_vec3().to_array())
    }

    /// Whether all corners of the cube of half side `half` (metres, along the world's axes) around a point lie inside, or none.
    pub fn zone(&self, p: DVec3, half: f64) -> Zone {
        let corner = |i: u32| DVec3::from([0, 1, 2].map(|k| if i >> k & 1 == 1 { half } else { -half }));
        match (0..8).filter(|i| self.contains(p + corner(*i))).count() {
            0 => Zone::Outside,
            8 => Zone::Inside,
            _ => Zone::Border,
        }
    }

    /// All parts of a ray that lie inside, from its origin on. Each texel is a box over its ranges, as for the parity test.
    pub fn spans(&self, ray: &Ray) -> Vec<Span> {
        let mut spans: Vec<Span> = Vec::new();
        let _ = self.walk(ray, |span| {
            join(&mut spans, span);
            ControlFlow::Continue(())
        });
        spans
    }

    /// The first of [`Volume::spans`]: where the ray enters and where it leaves again.
    pub fn first(&self, ray: &Ray) -> Option<Span> {
        let mut spans: Vec<Span> = Vec::with_capacity(2);
        let _ = self.walk(ray, |span| {
            join(&mut spans, span);
            if spans.len() > 1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        spans.first().copied()
    }

    /// Where a ray enters first.
    pub fn enter(&self, ray: &Ray) -> Option<Entry> {
        let mut entry = None;
        let _ = self.walk(ray, |span| {
            entry = Some(span.enter);
            ControlFlow::Break(())
        });
        entry
    }

    /// Calls `found` with the parts inside of every texel along a ray, in their order.
    fn walk(&self, ray: &Ray, mut found: impl FnMut(Span) -> ControlFlow<()>) -> ControlFlow<()> {
        let (size, region) = (self.image.size().map(f64::from), self.image.region());
        // In texels from the region's corner, and in depth.
        let corner = DVec3::new(f64::from(region.x), f64::from(region.y), 0.0);
        let scale = DVec3::new(size[0], size[1], 1.0);
        let o = self.to_texture.transform_point3(ray.origin) * scale - corner;
        let d = self.to_texture.transform_vector3(ray.direction) * scale;
        let high = [f64::from(region.width), f64::from(region.height), 1.0];
        let (mut from, mut to) = (0.0f64, f64::INFINITY);
        for (o, d, high) in [(o.x, d.x, high[0]), (o.y, d.y, high[1]), (o.z, d.z, high[2])] {
            if d == 0.0 {
                // A texel holds its lower border.
                if !(0.0 <= o && o < high) {
                    return ControlFlow::Continue(());
                }
                continue;
            }
            let (a, b) = (-o / d, (high - o) / d);
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        }
        if !(from < to && to.is_finite()) {
            return ControlFlow::Continue(());
        }
        let plane = [[o.x, d.x], [o.y, d.y]];
        let texels = [[0, region.width], [0, region.height]];
        let coarse = plane.map(|[o, d]| [o / f64::from(BLOCK), d / f64::from(BLOCK)]);
        let blocks = texels.map(|[_, end]| [0, end.div_ceil(BLOCK)]);
        cross(coarse, blocks, [from, to], |block, from, until| {
            let [least, most] = self.blocks[(block[1] * blocks[0][1] + block[0]) as usize];
            let (a, b) = (o.z + d.z * from, o.z + d.z * until);
            if a.max(b) < f64::from(least) || a.min(b) > f64::from(most) {
                return ControlFlow::Continue(());
            }
            let inside = [0, 1].map(|k| [block[k] * BLOCK, ((block[k] + 1) * BLOCK).min(texels[k][1])]);
            cross(plane, inside, [from, until], |[x, y], from, until| {
                let texel = [region.x + x, region.y + y];
                let ranges = self.image.ray((y * region.width + x) as usize).chunks_exact(2);
                let mut part = |range: &[f32]| {
                    let [mut a, mut b] = [range[0], range[1]].map(f64::from);
                    if d.z == 0.0 {
                        (a, b) = if a <= o.z && o.z <= b { (from, until) } else { (until, from) };
                    } else {
                        (a, b) = ((a - o.z) / d.z, (b - o.z) / d.z);
                        (a, b) = (a.min(b).max(from), a.max(b).min(until));
                    }
                    if a < b {
                        found(Span { enter: Entry { t: a, texel }, exit: b })
                    } else {
                        ControlFlow::Continue(())
                    }
                };
                if d.z >= 0.0 {
                    for range in ranges {
                        part(range)?;
                    }
                } else {
                    for range in ranges.rev() {
                        part(range)?;
                    }
                }
                ControlFlow::Continue(())
            })
        })
    }

    /// The outward unit normal where a ray enters, in the world: away from the middle of what a ball of [`BALL`] texels around it holds,
    /// integrated along the rays of the texels.
    pub fn normal(&self, ray: &Ray, entry: &Entry) -> DVec3 {
        let (size, region) = (self.image.size().map(f64::from), self.image.region());
        let p = self.to_texture.transform_point3(ray.at(entry.t));
        let at = [p.x * size[0], p.y * size[1]];
        // Depths in texels too.
        let deep = size[0];
        let mut moment = DVec3::ZERO;
        let reach = BALL as i64;
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let texel = [i64::from(entry.texel[0]) + dx, i64::from(entry.texel[1]) + dy];
                let [Ok(s), Ok(t)] = texel.map(u32::try_from) else { continue };
                let Some(i) = region.at(s, t) else { continue };
                let off = [f64::from(s) + 0.5 - at[0], f64::from(t) + 0.5 - at[1]];
                let square = BALL * BALL - off[0] * off[0] - off[1] * off[1];
                if square <= 0.0 {
                    continue;
                }
                let half = square.sqrt();
                for range in self.image.ray(i).chunks_exact(2) {
                    let [a, b] = [range[0], range[1]].map(|d| ((f64::from(d) - p.z) * deep).clamp(-half, half));
                    moment += DVec3::new(off[0] * (b - a), off[1] * (b - a), 0.5 * (b * b - a * a));
                }
            }
        }
        (self.to_texture.matrix3.transpose() * -moment).normalize_or(-ray.direction.normalize_or_zero())
    }

    /// The ray through a texel's centre, in the world: t is the depth in [0, 1].
    pub(super) fn ray_of(&self, texel: [u32; 2]) -> Ray {
        let at = |k: usize| (f64::from(texel[k]) + 0.5) / f64::from(self.image.size()[k]);
        let origin = self.to_world.transform_point3(DVec3::new(at(0), at(1), 0.0));
        Ray { origin, direction: self.to_world.transform_vector3(DVec3::Z) }
    }
}

/// Adds a part behind the last one, or to it where they touch.
fn join(spans: &mut Vec<Span>, span: Span) {
    match spans.last_mut() {
        Some(last) if span.enter.t <= last.exit => last.exit = last.exit.max(span.exit),
        _ => spans.push(span),
    }
}

/// Calls `visit(cell, from, until)` for the cells of a grid that a ray crosses between two of its parameters, in their order
/// (Amanatides and Woo 1987). Along axis k the ray is at `line[k][0] + t·line[k][1]` and the cells are `cells[k][0]..cells[k][1]`.
fn cross(
    line: [[f64; 2]; 2],
    cells: [[u32; 2]; 2],
    [mut from, to]: [f64; 2],
    mut visit: impl FnMut([u32; 2], f64, f64) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let border = |k: usize, cell: i64| {
        let [o, d] = line[k];
        if d == 0.0 { f64::INFINITY } else { ((cell + i64::from(d > 0.0)) as f64 - o) / d }
    };
    let first = |k: usize| {
        let (at, [low, high]) = (line[k][0] + line[k][1] * from, cells[k].map(i64::from));
        (at.floor() as i64).clamp(low, high - 1)
    };
    let mut cell = [first(0), first(1)];
    let mut next = [border(0, cell[0]), border(1, cell[1])];
    while from < to {
        let k = usize::from(next[1] < next[0]);
        let until = next[k].min(to);
        if from < until {
            visit(cell.map(|c| c as u32), from, until)?;
            from = until;
        }
        cell[k] += if line[k][1] > 0.0 { 1 } else { -1 };
        let inside = (i64::from(cells[k][0])..i64::from(cells[k][1])).contains(&cell[k]);
        if !inside || next[k] == f64::INFINITY {
            break;
        }
        next[k] = border(k, cell[k]);
    }
    ControlFlow::Continue(())
}

/// Least and greatest depth of every block of texels of the region, row by row; none where the first exceeds the second.
fn blocks(image: &LayeredDepthImage) -> Vec<[f32; 2]> {
    let region = image.region();
    let columns = region.width.div_ceil(BLOCK);
    let mut blocks = vec![[f32::INFINITY, f32::NEG_INFINITY]; (columns * region.height.div_ceil(BLOCK)) as usize];
    for i in 0..region.texels() {
        if let [first, .., last] = image.ray(i) {
            let (x, y) = (i as u32 % region.width, i as u32 / region.width);
            let block = &mut blocks[(y / BLOCK * columns + x / BLOCK) as usize];
            *block = [block[0].min(*first), block[1].max(*last)];
        }
    }
    blocks
}
