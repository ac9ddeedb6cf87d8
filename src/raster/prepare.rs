//! One pass over the geometry: transform, clip, snap, and sort into tiles what may be seen.
//!
//! The result can be traversed many times. Within a tile triangles come in the order of their numbers.

use super::{
    Geometry, Options, Sides, Tile,
    camera::{Camera, OUTSIDE, Vertex},
    clip::clip_to_view,
    cover::{Rect, SMALL, cover, doubled_area, may_cover, samples_within, small_mask},
    geometry::{Cutout, Draw},
    tile::TileGrid,
};
use crate::{
    math::{Stop, Stopped},
    view::View,
};
use glam::DVec3;
use rayon::prelude::*;

/// A triangle, or a piece of one that was clipped, on the pixel grid.
#[derive(Clone, Copy, Debug)]
pub struct ScreenTriangle {
    /// Corners in 1/256 px, y down; positive area (clockwise on the screen).
    pub corners: [[i32; 2]; 3],
    /// Number in the [`Geometry`].
    pub triangle: u32,
    /// Least and greatest planar depth of the clipped triangle, metres.
    pub depth: [f32; 2],
    flags: u16,
    /// The covered samples of a small triangle, see [`small_mask`].
    mask: u16,
    /// a·px + b·py + c is 1/depth (perspective) or depth.
    plane: [f64; 3],
}

const PERSPECTIVE: u16 = 1;
const MASKED: u16 = 2;
const BACK: u16 = 4;
/// `mask` says which samples are covered.
const IS_SMALL: u16 = 8;

/// The triangles of a view, sorted into tiles.
pub struct Prepared<'a> {
    pub geometry: &'a Geometry,
    pub view: View,
    pub(crate) camera: Camera,
    pub(crate) grid: TileGrid,
    chunks: Vec<Chunk>,
}

/// The prepared form of a run of consecutive triangles.
#[derive(Default)]
pub(crate) struct Chunk {
    pub triangles: Vec<ScreenTriangle>,
    /// The tiles `first_tile..first_tile + starts.len() − 1` hold `entries[starts[t]..starts[t + 1]]`,
    /// ascending indices into `triangles`.
    first_tile: u32,
    starts: Vec<u32>,
    entries: Vec<u32>,
}

/// Triangles worked on by one task.
const CHUNK: usize = 8192;
/// Vertices transformed before their triangles are worked on, so that memory stays bounded with many instances.
const BATCH: usize = 1 << 21;

impl ScreenTriangle {
    /// Planar depth (metres) of the triangle's plane at a continuous pixel position, kept within the clipped
    /// triangle's own depths: where an edge was snapped outward, or the plane is seen edge-on, nothing is extrapolated.
    #[inline]
    pub fn depth_at(&self, px: f64, py: f64) -> f32 {
        let q = self.plane[0] * px + (self.plane[1] * py + self.plane[2]);
        self.depth_of(q)
    }

    #[inline]
    fn depth_of(&self, q: f64) -> f32 {
        let z = if self.flags & PERSPECTIVE != 0 { 1.0 / q } else { q } as f32;
        // Written so that a NaN becomes the least depth, and a plane that leaves the half-space in front the greatest.
        let z = if z < 0.0 && self.flags & PERSPECTIVE != 0 {
            self.depth[1]
        } else {
            z.max(self.depth[0]).min(self.depth[1])
        };
        // There is one zero.
        z + 0.0
    }

    /// Coefficients of the function a·px + b·py + c that equals 1/depth in a perspective view and depth in an
    /// orthographic one.
    pub fn plane(&self) -> [f64; 3] {
        self.plane
    }

    /// Its material has holes, to be asked for sample by sample.
    pub fn masked(&self) -> bool {
        self.flags & MASKED != 0
    }

    /// It lies within 4×4 samples.
    #[cfg(feature = "gpu")]
    pub(crate) fn small(&self) -> bool {
        self.flags & IS_SMALL != 0
    }

    /// The samples within its bounds: least x and y, then greatest.
    #[cfg(feature = "gpu")]
    pub(crate) fn samples(&self) -> [i32; 4] {
        let Rect { x0, y0, x1, y1 } = samples_within(&self.corners);
        [x0, y0, x1, y1]
    }

    /// Seen from behind.
    pub fn back(&self) -> bool {
        self.flags & BACK != 0
    }

    /// Calls `row(y, x0, x1)` for the pixels x0..x1 of each row of `tile` whose centres the triangle covers.
    #[inline]
    pub fn cover(&self, tile: &Tile, mut row: impl FnMut(i32, i32, i32)) {
        let all = samples_within(&self.corners);
        let rect = all.intersect(rect_of(tile));
        if rect.is_empty() {
            return;
        }
        if self.flags & IS_SMALL == 0 {
            return cover(&self.corners, rect, row);
        }
        for y in rect.y0..=rect.y1 {
            // A row of a triangle is one run of samples.
            let bits = (self.mask >> (SMALL * (y - all.y0))) & 0xf;
            let from = (all.x0 + bits.trailing_zeros() as i32).max(rect.x0);
            let to = (all.x0 + 16 - bits.leading_zeros() as i32).min(rect.x1 + 1);
            if from < to {
                row(y, from, to);
            }
        }
    }
}

fn rect_of(t: &Tile) -> Rect {
    Rect { x0: t.x as i32, y0: t.y as i32, x1: (t.x + t.width) as i32 - 1, y1: (t.y + t.height) as i32 - 1 }
}

impl<'a> Prepared<'a> {
    /// Transforms, clips and sorts the triangles of `geometry` for `view`.
    ///
    /// # Panics
    /// Where the view is larger than [`super::MAX_SIDE`] or its window or depth range is empty.
    pub fn new(geometry: &'a Geometry, view: &View, options: &Options, stop: &Stop) -> Result<Self, Stopped> {
        Self::with_tiles(geometry, view, options, Tile::SIDE, stop)
    }

    /// As [`Prepared::new`], with tiles of `side` ≤ [`Tile::SIDE`] pixels.
    pub(crate) fn with_tiles(
        geometry: &'a Geometry,
        view: &View,
        options: &Options,
        side: u32,
        stop: &Stop,
    ) -> Result<Self, Stopped> {
        let camera = Camera::new(view);
        let grid = TileGrid::new(view.width, view.height, side);
        let mut prepared = Self { geometry, view: *view, camera, grid, chunks: Vec::new() };
        let mut batch = Batch::default();
        for draw in geometry.draws() {
            let seen = draw.cutout != Cutout::Hidden && !draw.mesh.triangles.is_empty() && grid.len() > 0;
            if !seen || out_of_sight(draw, &camera, view) {
                continue;
            }
            if batch.vertices + draw.mesh.positions.len() > BATCH {
                prepared.work(&batch, options, stop)?;
                batch = Batch::default();
            }
            batch.push(draw);
        }
        prepared.work(&batch, options, stop)?;
        Ok(prepared)
    }

    fn work(&mut self, batch: &Batch, options: &Options, stop: &Stop) -> Result<(), Stopped> {
        let (camera, grid) = (&self.camera, &self.grid);
        let vertices = batch.transform(camera, stop)?;
        let chunks: Vec<Chunk> = (0..batch.triangles.div_ceil(CHUNK))
            .into_par_iter()
            .map(|i| {
                stop.check()?;
                let mut chunk = Chunk::default();
                batch.for_triangles(i * CHUNK..(i + 1) * CHUNK, |item, range| {
                    let setup = Setup::new(camera, grid, item.draw, options.sides);
                    let vertices = &vertices[item.vertex..];
                    let first = item.draw.first + range.start as u32;
                    for (number, indices) in (first..).zip(&item.draw.mesh.triangles[range]) {
                        let corners = indices.map(|v| &vertices[v as usize]);
                        setup.triangle(number, corners, &mut chunk.triangles);
                    }
                });
                chunk.sort_into_tiles(grid);
                Ok(chunk)
            })
            .collect::<Result<_, Stopped>>()?;
        self.chunks.extend(chunks.into_iter().filter(|c| !c.triangles.is_empty()));
        Ok(())
    }

    pub fn tile_count(&self) -> usize {
        self.grid.len()
    }

    pub fn tile(&self, index: u32) -> Tile {
        self.grid.tile(index)
    }

    /// The triangles that may cover pixels of a tile, by ascending number.
    pub fn triangles_in(&self, tile: u32) -> impl Iterator<Item = &ScreenTriangle> {
        self.chunks.iter().flat_map(move |c| c.in_tile(tile).iter().map(|e| &c.triangles[*e as usize]))
    }

    /// The snapped triangles in the order of their numbers, chunk by chunk.
    #[cfg(feature = "gpu")]
    pub(crate) fn chunks(&self) -> &[Chunk] {
        &self.chunks
    }

    /// All triangles that may cover a pixel centre, by ascending number.
    pub fn triangles(&self) -> impl Iterator<Item = &ScreenTriangle> {
        self.chunks.iter().flat_map(|c| &c.triangles)
    }
}

impl Chunk {
    /// Indices into `triangles` of those that may cover pixels of a tile, ascending.
    pub fn in_tile(&self, tile: u32) -> &[u32] {
        let Some(t) = tile.checked_sub(self.first_tile) else { return &[] };
        match self.starts.get(t as usize..t as usize + 2) {
            Some(s) => &self.entries[s[0] as usize..s[1] as usize],
            None => &[],
        }
    }

    fn sort_into_tiles(&mut self, grid: &TileGrid) {
        let mut pairs: Vec<(u32, u32)> = Vec::with_capacity(self.triangles.len() * 5 / 4);
        let whole = rect_of(&Tile { index: 0, x: 0, y: 0, width: grid.width, height: grid.height });
        for (i, t) in self.triangles.iter().enumerate() {
            let r = samples_within(&t.corners).intersect(whole);
            let (tx0, tx1) = (grid.line_of(r.x0), grid.line_of(r.x1));
            let (ty0, ty1) = (grid.line_of(r.y0), grid.line_of(r.y1));
            if tx0 == tx1 && ty0 == ty1 {
                pairs.push((ty0 * grid.columns + tx0, i as u32));
                continue;
            }
            for ty in ty0..=ty1 {
                for tx in tx0..=tx1 {
                    let tile = ty * grid.columns + tx;
                    if may_cover(&t.corners, r.intersect(rect_of(&grid.tile(tile)))) {
                        pairs.push((tile, i as u32));
                    }
                }
            }
        }
        let Some(first) = pairs.iter().map(|p| p.0).min() else { return };
        let last = pairs.iter().map(|p| p.0).max().unwrap_or(first);
        self.first_tile = first;
        self.starts = vec![0; (last - first) as usize + 2];
        for (tile, _) in &pairs {
            self.starts[(tile - first) as usize + 1] += 1;
        }
        for t in 1..self.starts.len() {
            self.starts[t] += self.starts[t - 1];
        }
        let mut next = self.starts.clone();
        self.entries = vec![0; pairs.len()];
        for (tile, i) in pairs {
            let at = &mut next[(tile - first) as usize];
            self.entries[*at as usize] = i;
            *at += 1;
        }
    }
}

/// Draws whose vertices are transformed together.
#[derive(Default)]
struct Batch<'a> {
    items: Vec<Item<'a>>,
    vertices: usize,
    triangles: usize,
}

struct Item<'a> {
    draw: &'a Draw,
    /// First vertex and triangle within the batch.
    vertex: usize,
    triangle: usize,
}

impl<'a> Batch<'a> {
    fn push(&mut self, draw: &'a Draw) {
        self.items.push(Item { draw, vertex: self.vertices, triangle: self.triangles });
        self.vertices += draw.mesh.positions.len();
        self.triangles += draw.mesh.triangles.len();
    }

    fn transform(&self, camera: &Camera, stop: &Stop) -> Result<Vec<Vertex>, Stopped> {
        let mut vertices = vec![Vertex { p: DVec3::ZERO, s: OUTSIDE }; self.vertices];
        vertices.par_chunks_mut(CHUNK).enumerate().try_for_each(|(i, out)| {
            stop.check()?;
            let mut at = i * CHUNK;
            let mut rest = out;
            while !rest.is_empty() {
                let item = &self.items[self.items.partition_point(|k| k.vertex <= at) - 1];
                let positions = &item.draw.mesh.positions[at - item.vertex..];
                let n = positions.len().min(rest.len());
                let (head, tail) = rest.split_at_mut(n);
                let m = camera.object_to_camera(&item.draw.to_world);
                for (v, p) in head.iter_mut().zip(positions) {
                    *v = camera.vertex(m.transform_point3(DVec3::new(p[0] as f64, p[1] as f64, p[2] as f64)));
                }
                rest = tail;
                at += n;
            }
            Ok(())
        })?;
        Ok(vertices)
    }

    /// The part of `range` (triangles of the batch) that lies in each draw, as triangles of its mesh.
    fn for_triangles(&self, range: std::ops::Range<usize>, mut f: impl FnMut(&Item, std::ops::Range<usize>)) {
        let end = range.end.min(self.triangles);
        let mut at = range.start;
        while at < end {
            let item = &self.items[self.items.partition_point(|k| k.triangle <= at) - 1];
            let first = at - item.triangle;
            let n = (item.draw.mesh.triangles.len() - first).min(end - at);
            f(item, first..first + n);
            at += n;
        }
    }
}

/// Whether a draw's bounds lie outside the view entirely.
fn out_of_sight(draw: &Draw, camera: &Camera, view: &View) -> bool {
    let m = camera.object_to_camera(&draw.to_world);
    let corners = draw.bounds.corners().map(|p| m.transform_point3(p));
    let (u, v) = (|px: f64| (px - camera.origin.0) / camera.scale.0, |py: f64| (camera.origin.1 - py) / camera.scale.1);
    // One pixel of slack for snapping and rounding.
    let (left, right) = (u(-1.0), u(view.width as f64 + 1.0));
    let (top, bottom) = (v(-1.0), v(view.height as f64 + 1.0));
    let w = |p: &DVec3| if camera.perspective { p.z } else { 1.0 };
    corners.iter().all(|p| p.z < camera.near)
        || corners.iter().all(|p| p.z > camera.far)
        || corners.iter().all(|p| p.x < left * w(p))
        || corners.iter().all(|p| p.x > right * w(p))
        || corners.iter().all(|p| p.y < bottom * w(p))
        || corners.iter().all(|p| p.y > top * w(p))
}

/// What the triangles of one draw have in common.
struct Setup<'a> {
    camera: &'a Camera,
    grid: &'a TileGrid,
    draw: &'a Draw,
    sides: Sides,
}

impl<'a> Setup<'a> {
    /// `sides` in world space.
    fn new(camera: &'a Camera, grid: &'a TileGrid, draw: &'a Draw, sides: Sides) -> Self {
        let sides = match sides {
            _ if draw.material.double_sided => Sides::Both,
            Sides::FacingAny(points) => Sides::FacingAny(points.map(|p| camera.world_to_camera(p))),
            sides => sides,
        };
        Self { camera, grid, draw, sides }
    }

    /// Whether a triangle (corners in camera space) whose back the view sees is drawn.
    fn shows_back(&self, p: &[DVec3; 3]) -> bool {
        match &self.sides {
            Sides::Both => true,
            Sides::Facing => false,
            Sides::FacingAny(points) => {
                // Right, up and forward are left-handed: orientations are those of a mirror.
                let corners = if self.draw.mirrored { *p } else { [p[0], p[2], p[1]] };
                faces_any(&corners, points)
            }
        }
    }

    fn triangle(&self, number: u32, v: [&Vertex; 3], out: &mut Vec<ScreenTriangle>) {
        let corners = v.map(|v| v.s);
        if corners.contains(&OUTSIDE) {
            return self.clipped(number, v.map(|v| v.p), out);
        }
        let z = v.map(|v| v.p.z);
        let depth = [z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2])];
        self.piece(number, corners, v.map(|v| v.p), depth, out);
    }

    #[cold]
    fn clipped(&self, number: u32, p: [DVec3; 3], out: &mut Vec<ScreenTriangle>) {
        let polygon = clip_to_view(p, self.camera);
        let Some((first, rest)) = polygon.corners().split_first() else { return };
        let z = polygon.corners().iter().map(|p| p.z);
        let depth = [z.clone().fold(f64::INFINITY, f64::min), z.fold(f64::NEG_INFINITY, f64::max)];
        let first = self.camera.snapped(*first);
        for pair in rest.windows(2) {
            let corners = [first, self.camera.snapped(pair[0]), self.camera.snapped(pair[1])];
            self.piece(number, corners, p, depth, out);
        }
    }

    /// Keeps a piece that covers a sample, or might. `p` are the whole triangle's corners in camera space.
    #[inline]
    fn piece(
        &self,
        number: u32,
        mut corners: [[i32; 2]; 3],
        p: [DVec3; 3],
        depth: [f64; 2],
        out: &mut Vec<ScreenTriangle>,
    ) {
        let whole = Rect { x0: 0, y0: 0, x1: self.grid.width as i32 - 1, y1: self.grid.height as i32 - 1 };
        let all = samples_within(&corners);
        let rect = all.intersect(whole);
        if rect.is_empty() {
            return;
        }
        let area = doubled_area(&corners);
        // y points down: a front face runs counter-clockwise in space and has a negative area here.
        let back = (area > 0) != self.draw.mirrored;
        if area == 0 || (back && !self.shows_back(&p)) {
            return;
        }
        if area < 0 {
            corners.swap(1, 2);
        }
        let (mut mask, mut flags) = (0, 0);
        if all.x1 - all.x0 < SMALL && all.y1 - all.y0 < SMALL {
            mask = small_mask(&corners, all, rect);
            flags |= IS_SMALL;
            if mask == 0 {
                return;
            }
        }
        flags |= if self.camera.perspective { PERSPECTIVE } else { 0 };
        flags |= if matches!(self.draw.cutout, Cutout::Masked(_)) { MASKED } else { 0 };
        flags |= if back { BACK } else { 0 };
        out.push(ScreenTriangle {
            corners,
            triangle: number,
            depth: depth.map(|z| z as f32),
            flags,
            mask,
            plane: depth_plane(self.camera, p),
        });
    }
}

/// Whether a triangle, counter-clockwise from its front, faces one of some points.
pub(crate) fn faces_any(corners: &[DVec3; 3], points: &[DVec3]) -> bool {
    let [a, b, c] = *corners;
    let normal = (b - a).cross(c - a);
    points.iter().any(|p| normal.dot(*p - a) > 0.0)
}

/// The function of the pixel position that is 1/depth (perspective) or depth (orthographic) on the plane through `p`.
/// Not finite where the plane is seen exactly edge-on.
pub(crate) fn depth_plane(camera: &Camera, p: [DVec3; 3]) -> [f64; 3] {
    let n = (p[1] - p[0]).cross(p[2] - p[0]);
    let d = n.dot(p[0]);
    if camera.perspective {
        camera.affine(n * (1.0 / d))
    } else {
        camera.affine(DVec3::new(-n.x / n.z, -n.y / n.z, d / n.z))
    }
}
