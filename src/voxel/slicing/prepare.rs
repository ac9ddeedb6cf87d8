//! One pass over the geometry: each triangle in a frustum's camera space, clipped, snapped, with the layers it reaches.

use super::spans::{Depths, doubled_area};
use crate::{
    math::{Projection, Stop, Stopped, View},
    raster::{Cutout, Geometry, Polygon},
    voxel::{Frustum, Slices},
};
use glam::DVec3;
use rayon::prelude::*;

/// The triangles of a scene in world space, relative to the cell's centre. Materials that are all hole are left out.
pub struct Soup {
    /// Corners in the order of the mesh's indices.
    pub corners: Vec<[DVec3; 3]>,
    /// Number of each in the [`Geometry`].
    pub numbers: Vec<u32>,
}

impl Soup {
    pub fn new(geometry: &Geometry, centre: DVec3) -> Self {
        let draws = || geometry.draws().iter().filter(|d| d.cutout != Cutout::Hidden);
        let count = |d: &crate::raster::Draw| d.mesh.triangles.len() as u32;
        let numbers = draws().flat_map(|d| d.first..d.first + count(d)).collect();
        let corners = draws().flat_map(|d| (0..count(d)).map(move |t| d.corners(t).map(|p| p - centre)));
        Self { corners: corners.collect(), numbers }
    }
}

/// A frustum's pixel grid.
#[derive(Clone, Debug)]
pub struct Screen {
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Pixels per tangent, and the pixel position of the axis.
    scale: f64,
    origin: (f64, f64),
    pub width: u32,
    pub height: u32,
    near: f64,
}

/// Snapped coordinates stay within this many pixels of the image, so that products of two fit 64 bits.
const GUARD: f64 = 500_000.0;

impl Screen {
    pub fn new(f: &Frustum, near: f64) -> Self {
        let scale = f64::from(f.size[0]) / (f.right_tan - f.left);
        Self {
            right: f.right,
            up: f.up,
            forward: f.forward,
            scale,
            origin: (-f.left * scale, f.top * scale),
            width: f.size[0],
            height: f.size[1],
            near,
        }
    }

    fn local(&self, p: DVec3) -> DVec3 {
        DVec3::new(p.dot(self.right), p.dot(self.up), p.dot(self.forward))
    }

    fn pixel(&self, p: DVec3) -> [f64; 2] {
        [p.x / p.z * self.scale + self.origin.0, self.origin.1 - p.y / p.z * self.scale]
    }

    /// The plane through three points of camera space as inverse depth over the image (see [`Depths`]); `None` where
    /// it is seen so nearly edge-on that depths on it have no meaning.
    fn plane(&self, v: &[DVec3; 3]) -> Option<[f64; 3]> {
        let n = (v[1] - v[0]).cross(v[2] - v[0]);
        let distance = n.dot(v[0]);
        let scale = n.length() * v[0].length();
        if distance.abs() <= scale * 1e-9 {
            return None;
        }
        let n = n / distance;
        let (a, b) = (n.x / self.scale, -n.y / self.scale);
        Some([a, b, n.z - a * self.origin.0 - b * self.origin.1])
    }
}

/// The view whose pixels are the samples of a frustum: what shading needs.
pub fn sample_view(slices: &Slices, frustum: &Frustum, samples: u32) -> View {
    View {
        eye: slices.cell.centre,
        right: frustum.right,
        up: frustum.up,
        forward: frustum.forward,
        projection: Projection::Perspective {
            left: frustum.left,
            right: frustum.right_tan,
            bottom: frustum.bottom,
            top: frustum.top,
        },
        width: frustum.size[0] * samples,
        height: frustum.size[1] * samples,
        near: slices.borders[0],
        far: slices.borders[slices.layers.len()],
    }
}

fn snap(p: [f64; 2]) -> [i32; 2] {
    p.map(|x| (x * 256.0).round_ties_even() as i32)
}

/// A triangle that may fill pixels of a frustum.
#[derive(Clone, Copy, Debug)]
pub struct Item {
    /// Index into the soup.
    pub source: u32,
    /// The layers it reaches.
    pub first: u16,
    pub last: u16,
    /// It begins in front of the nearest border.
    pub from_near: bool,
    /// Pixel rows it may touch, both included.
    pub rows: [u32; 2],
    /// Its pieces on the pixel grid: `pieces[start..start + len]`; none where it is seen edge-on.
    start: u32,
    len: u32,
    plane: [f64; 3],
    /// Least and greatest inverse depth of its corners.
    range: [f64; 2],
}

/// A frustum's triangles.
pub struct Prepared {
    pub items: Vec<Item>,
    pieces: Vec<[[i32; 2]; 3]>,
}

impl Prepared {
    pub fn new(soup: &Soup, slices: &Slices, screen: &Screen, stop: &Stop) -> Result<Self, Stopped> {
        let chunks: Vec<Self> = soup
            .corners
            .par_chunks(4096)
            .enumerate()
            .map(|(i, chunk)| {
                stop.check()?;
                let mut out = Self { items: Vec::new(), pieces: Vec::new() };
                for (k, triangle) in chunk.iter().enumerate() {
                    out.add((i * 4096 + k) as u32, triangle, slices, screen);
                }
                Ok(out)
            })
            .collect::<Result<_, Stopped>>()?;
        let mut all = Self { items: Vec::new(), pieces: Vec::new() };
        for mut chunk in chunks {
            let base = all.pieces.len() as u32;
            all.items.extend(chunk.items.iter().map(|item| Item { start: item.start + base, ..*item }));
            all.pieces.append(&mut chunk.pieces);
        }
        Ok(all)
    }

    pub fn pieces(&self, item: &Item) -> &[[[i32; 2]; 3]] {
        &self.pieces[item.start as usize..(item.start + item.len) as usize]
    }

    fn add(&mut self, source: u32, triangle: &[DVec3; 3], slices: &Slices, screen: &Screen) {
        let v = triangle.map(|p| screen.local(p));
        if v.iter().all(|p| p.z < screen.near) {
            return;
        }
        let mut polygon = Polygon::triangle(v);
        let from_near = v.iter().any(|p| p.z < screen.near);
        if from_near {
            polygon.clip(|p| p.z - screen.near);
        }
        let inside = |p: &DVec3| screen.pixel(*p).iter().all(|x| x.abs() <= GUARD);
        if !polygon.corners().iter().all(inside) {
            let t = GUARD * 0.5 / screen.scale;
            let sides: [fn(DVec3, f64) -> f64; 4] =
                [|p, t| p.z * t - p.x, |p, t| p.z * t + p.x, |p, t| p.z * t - p.y, |p, t| p.z * t + p.y];
            sides.iter().for_each(|side| polygon.clip(|p| side(p, t)));
        }
        let corners = polygon.corners();
        if corners.is_empty() {
            return;
        }
        let z = corners.iter().map(|p| p.z);
        let (least, most) = (z.clone().fold(f64::INFINITY, f64::min), z.fold(0.0, f64::max));
        let layer =
            |z: f64| (slices.borders.partition_point(|b| *b <= z).max(1) - 1).min(slices.layers.len() - 1) as u16;

        let snapped: Vec<_> = corners.iter().map(|p| snap(screen.pixel(*p))).collect();
        let bounds = |k: usize| snapped.iter().fold((i32::MAX, i32::MIN), |b, p| (b.0.min(p[k]), b.1.max(p[k])));
        let ((x0, x1), (y0, y1)) = (bounds(0), bounds(1));
        // Closed pixels, and one more because cuts are snapped on their own.
        let (w, h) = (screen.width as i32 * 256, screen.height as i32 * 256);
        if x1 < -256 || x0 > w + 256 || y1 < -256 || y0 > h + 256 {
            return;
        }
        let row = |y: i32| y.div_euclid(256).clamp(0, screen.height as i32 - 1) as u32;

        let start = self.pieces.len();
        let plane = screen.plane(&v);
        if plane.is_some() {
            for pair in snapped[1..].windows(2) {
                let mut piece = [snapped[0], pair[0], pair[1]];
                match doubled_area(&piece).signum() {
                    0 => continue,
                    -1 => piece.swap(1, 2),
                    _ => {}
                }
                self.pieces.push(piece);
            }
        }
        let item = Item {
            source,
            first: layer(least),
            last: layer(most),
            from_near,
            rows: [row(y0 - 257), row(y1 + 256)],
            start: start as u32,
            len: (self.pieces.len() - start) as u32,
            plane: plane.unwrap_or_default(),
            range: [1.0 / most, 1.0 / least],
        };
        if item.len > 0 || item.first < item.last || from_near {
            self.items.push(item);
        }
    }
}

impl Item {
    pub fn depths<'a>(&self, inverse: &'a [f64]) -> Depths<'a> {
        Depths { inverse, plane: self.plane, range: self.range, first: self.first, last: self.last }
    }

    /// The borders that cut it: between layers j − 1 and j; 0 is the nearest border, in front of layer 0.
    pub fn cuts(&self) -> std::ops::RangeInclusive<u16> {
        if self.from_near { 0..=self.last } else { self.first + 1..=self.last }
    }
}

/// Where a triangle meets a border: a segment on the pixel grid, with the barycentric coordinates of its ends.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    pub ends: [[i32; 2]; 2],
    pub weights: [[f64; 3]; 2],
}

impl Cut {
    /// Ends are computed from the nearer to the farther corner of each edge, so triangles that share an edge agree.
    pub fn new(triangle: &[DVec3; 3], border: f64, screen: &Screen) -> Option<Self> {
        let v = triangle.map(|p| screen.local(p));
        let mut ends = [([0.0; 2], [0.0; 3]); 2];
        let mut n = 0;
        for (i, k) in [(0, 1), (1, 2), (2, 0)] {
            let (near, far) = if v[i].z < v[k].z { (i, k) } else { (k, i) };
            if v[near].z < border && border <= v[far].z {
                let t = (border - v[near].z) / (v[far].z - v[near].z);
                let mut weights = [0.0; 3];
                (weights[near], weights[far]) = (1.0 - t, t);
                let p = v[near] + (v[far] - v[near]) * t;
                *ends.get_mut(n)? = (screen.pixel(DVec3::new(p.x, p.y, border)), weights);
                n += 1;
            }
        }
        let ([a, b], 2) = (ends, n) else { return None };
        let (from, to) = screen.clip_segment(a.0, b.0)?;
        let at = |t: f64| {
            let mix = |a: f64, b: f64| a + (b - a) * t;
            let p = if t == 0.0 {
                a.0
            } else if t == 1.0 {
                b.0
            } else {
                [mix(a.0[0], b.0[0]), mix(a.0[1], b.0[1])]
            };
            (snap(p), std::array::from_fn(|i| mix(a.1[i], b.1[i])))
        };
        let (a, b) = (at(from), at(to));
        Some(Self { ends: [a.0, b.0], weights: [a.1, b.1] })
    }

    /// The point of the segment nearest to the centre of a pixel: squared distance (steps²) and barycentric coordinates.
    pub fn nearest(&self, x: u32, y: u32) -> (f64, [f64; 3]) {
        let c = [f64::from(x) * 256.0 + 128.0, f64::from(y) * 256.0 + 128.0];
        let [a, b] = self.ends.map(|e| e.map(f64::from));
        let d = [b[0] - a[0], b[1] - a[1]];
        let length = d[0] * d[0] + d[1] * d[1];
        let along = (c[0] - a[0]) * d[0] + (c[1] - a[1]) * d[1];
        let t = if length > 0.0 { (along / length).clamp(0.0, 1.0) } else { 0.5 };
        let off = [a[0] + d[0] * t - c[0], a[1] + d[1] * t - c[1]];
        let [wa, wb] = self.weights;
        (off[0] * off[0] + off[1] * off[1], std::array::from_fn(|i| wa[i] + (wb[i] - wa[i]) * t))
    }
}

impl Screen {
    /// The part of a segment within the guard band, as parameters (Liang and Barsky 1984).
    fn clip_segment(&self, a: [f64; 2], b: [f64; 2]) -> Option<(f64, f64)> {
        let (mut from, mut to) = (0.0f64, 1.0f64);
        for k in 0..2 {
            let d = b[k] - a[k];
            for (distance, slope) in [(a[k] + GUARD, d), (GUARD - a[k], -d)] {
                // distance + slope·t ≥ 0
                if slope > 0.0 {
                    from = from.max(-distance / slope);
                } else if slope < 0.0 {
                    to = to.min(-distance / slope);
                } else if distance < 0.0 {
                    return None;
                }
            }
        }
        (from <= to).then_some((from, to))
    }
}
