//! Which face owns each texel of a chart: a growing rectangle of texels.
//!
//! Texel (i, j) has its centre at (i + ½, j + ½). Texels are visited by rectangle, so that an answer depends on the
//! faces and their order only.

use glam::DVec2;

/// Texels farther than this from a face are never read when it is filtered bilinearly.
pub const REACH: f64 = 1.5;

/// A texel's column and row.
pub type Texel = [i32; 2];

/// No face.
pub const NONE: u32 = u32::MAX;

/// A rectangle of texels with owners.
#[derive(Default)]
pub struct TexelOwners {
    /// Texel at the grid's top left.
    origin: Texel,
    size: Texel,
    /// (owner, signed distance of the texel's centre to it), row by row.
    cells: Vec<(u32, f32)>,
    /// Smallest and largest corner of the faces that lie in it.
    bounds: Option<(DVec2, DVec2)>,
}

/// Distance of `p` to a triangle's border, negative inside; degenerate triangles have no inside.
pub fn signed_distance(t: &[DVec2; 3], p: DVec2) -> f64 {
    let mut nearest = f64::INFINITY;
    let area = (t[1] - t[0]).perp_dot(t[2] - t[0]);
    let mut inside = area != 0.0;
    for k in 0..3 {
        let (a, b) = (t[k], t[(k + 1) % 3]);
        let edge = b - a;
        let side = edge.perp_dot(p - a);
        inside &= side == 0.0 || (side > 0.0) == (area > 0.0);
        let along = if edge == DVec2::ZERO { 0.0 } else { ((p - a).dot(edge) / edge.length_squared()).clamp(0.0, 1.0) };
        nearest = nearest.min(p.distance(a + edge * along));
    }
    if inside { -nearest } else { nearest }
}

fn corners(t: &[DVec2; 3]) -> (DVec2, DVec2) {
    (t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2]))
}

/// First and one past the last texel whose centre can lie within `reach` of the box.
fn texels(low: DVec2, high: DVec2, reach: f64) -> (Texel, Texel) {
    let (a, b) = ((low - reach - 0.5).ceil(), (high + reach - 0.5).floor());
    ([a.x as i32, a.y as i32], [b.x as i32 + 1, b.y as i32 + 1])
}

impl TexelOwners {
    /// Whether the faces' bounding box with `t` in it has sides of at most `room`.
    pub fn stays_within(&self, t: &[DVec2; 3], room: f64) -> bool {
        let (mut low, mut high) = corners(t);
        if let Some((a, b)) = self.bounds {
            (low, high) = (low.min(a), high.max(b));
        }
        (high - low).max_element() <= room
    }

    fn index(&self, at: Texel) -> Option<usize> {
        let d = [at[0] - self.origin[0], at[1] - self.origin[1]];
        let inside = (0..2).all(|k| (0..self.size[k]).contains(&d[k]));
        inside.then(|| d[1] as usize * self.size[0] as usize + d[0] as usize)
    }

    /// One past the last texel.
    fn end(&self) -> Texel {
        [0, 1].map(|k| self.origin[k] + self.size[k])
    }

    /// Owner and signed distance of a texel.
    pub fn owner(&self, at: Texel) -> Option<(u32, f64)> {
        self.index(at).map(|i| self.cells[i]).filter(|c| c.0 != NONE).map(|c| (c.0, f64::from(c.1)))
    }

    /// Calls `accept` with the centres and owners of the texels around `t` until one is refused; false then.
    pub fn each(&self, t: &[DVec2; 3], reach: f64, accept: impl Fn(DVec2, Option<(u32, f64)>) -> bool) -> bool {
        let (low, high) = corners(t);
        let (a, b) = texels(low, high, reach);
        let end = self.end();
        (a[1].max(self.origin[1])..b[1].min(end[1])).all(|y| {
            (a[0].max(self.origin[0])..b[0].min(end[0])).all(|x| {
                let owner = self.owner([x, y]);
                owner.is_none() || accept(centre([x, y]), owner)
            })
        })
    }

    /// Grows the rectangle so that every texel near `t` is in it.
    pub fn make_room(&mut self, t: &[DVec2; 3]) {
        let (low, high) = corners(t);
        let (low, high) = self.bounds.map_or((low, high), |(a, b)| (low.min(a), high.max(b)));
        self.bounds = Some((low, high));
        let (mut a, mut b) = texels(low, high, REACH);
        let end = self.end();
        if !self.cells.is_empty() {
            // By halves, on the sides that grow, so that all growing together costs no more than a few copies.
            let more = self.size.map(|s| (s / 2).max(16));
            a = [0, 1].map(|k| if a[k] < self.origin[k] { a[k] - more[k] } else { self.origin[k] });
            b = [0, 1].map(|k| if b[k] > end[k] { b[k] + more[k] } else { end[k] });
            if (a, b) == (self.origin, end) {
                return;
            }
        }
        let size = [b[0] - a[0], b[1] - a[1]];
        let mut cells = vec![(NONE, f32::INFINITY); size[0] as usize * size[1] as usize];
        for y in 0..self.size[1] {
            let w = self.size[0] as usize;
            let from = y as usize * w;
            let to = (y + self.origin[1] - a[1]) as usize * size[0] as usize + (self.origin[0] - a[0]) as usize;
            cells[to..to + w].copy_from_slice(&self.cells[from..from + w]);
        }
        (self.origin, self.size, self.cells) = (a, size, cells);
    }

    /// Gives `face` every texel within `reach` of it that has no owner with a smaller signed distance.
    pub fn claim(&mut self, t: &[DVec2; 3], reach: f64, face: u32) {
        let (low, high) = corners(t);
        let (a, b) = texels(low, high, reach);
        for y in a[1]..b[1] {
            for x in a[0]..b[0] {
                let d = signed_distance(t, centre([x, y]));
                if d > reach {
                    continue;
                }
                let Some(i) = self.index([x, y]) else { continue };
                if (d as f32) < self.cells[i].1 {
                    self.cells[i] = (face, d as f32);
                }
            }
        }
    }

    /// The smallest rectangle of texels that holds the faces: its first texel and its size.
    pub fn rectangle(&self) -> (Texel, Texel) {
        let Some((low, high)) = self.bounds else { return ([0; 2], [1; 2]) };
        let (a, b) = (low.floor(), high.ceil());
        let size = (b - a).max(DVec2::ONE);
        ([a.x as i32, a.y as i32], [size.x as i32, size.y as i32])
    }
}

/// The centre of a texel.
pub fn centre(at: Texel) -> DVec2 {
    DVec2::new(f64::from(at[0]) + 0.5, f64::from(at[1]) + 0.5)
}
