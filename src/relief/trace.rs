//! One ray against one height field (section 3.3).

use super::{Field, Ray, field::Texel};
use glam::Vec3;

/// How a ray looks for the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Search {
    /// So many steps of equal length through the field's box, then so many halvings (section 3.3, after Policarpo et al. 2005).
    Linear { steps: u32, halvings: u32 },
    /// Every cell whose range of depths the ray crosses, found by a pyramid of such ranges.
    Pyramid,
}

/// How rays are traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trace {
    pub search: Search,
    /// Depths of neighbouring texels that differ by more, in texel sides, are a wall: nothing is known of what lies between them.
    pub wall: f32,
}

impl Default for Trace {
    fn default() -> Self {
        Self { search: Search::Pyramid, wall: 4.0 }
    }
}

/// Where a ray meets the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Along the ray.
    pub t: f32,
    /// In texel units.
    pub point: Vec3,
}

impl Field {
    pub(super) fn texel(&self, i: i32, j: i32) -> Texel {
        let last = self.side as i32 - 1;
        if i < 0 || j < 0 || i > last || j > last {
            return Texel { depth: f32::INFINITY, edge: -0.5 };
        }
        self.texels[(j * (last + 1) + i) as usize]
    }

    /// Depth of the surface at (u, v); infinite where there is none. Texels whose depths are less than `wall` apart are one surface
    /// between their centres, interpolated; others end half-way.
    pub fn height(&self, u: f32, v: f32, wall: f32) -> f32 {
        let (x, y) = (u - 0.5, v - 0.5);
        let (i, j) = (x.floor(), y.floor());
        let (fx, fy) = (x - i, y - j);
        let (i, j) = (i as i32, j as i32);
        let texels = [self.texel(i, j), self.texel(i + 1, j), self.texel(i, j + 1), self.texel(i + 1, j + 1)];
        let weights = [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy];
        let mut edge = 0.0;
        let (mut own, mut most) = (f32::INFINITY, -1.0);
        for (t, w) in texels.iter().zip(weights) {
            edge += w * t.edge;
            if t.depth < f32::INFINITY && w > most {
                (own, most) = (t.depth, w);
            }
        }
        if !(edge > 0.0) {
            return f32::INFINITY;
        }
        let (mut sum, mut of) = (0.0, 0.0);
        for (t, w) in texels.iter().zip(weights) {
            if (t.depth - own).abs() <= wall {
                sum += w * t.depth;
                of += w;
            }
        }
        sum / of
    }

    /// The unit normal of the surface at a point on it, in texel units: against w.
    pub fn normal(&self, p: Vec3, wall: f32) -> Vec3 {
        let slope = |du: f32, dv: f32| {
            let (a, b) = (self.height(p.x - du, p.y - dv, wall), self.height(p.x + du, p.y + dv, wall));
            // At an edge one side alone.
            let s = match ((a - p.z).abs() <= wall, (b - p.z).abs() <= wall) {
                (true, true) => b - a,
                (true, false) => 2.0 * (p.z - a),
                (false, true) => 2.0 * (b - p.z),
                (false, false) => 0.0,
            };
            s * 0.5 / (du + dv)
        };
        Vec3::new(slope(0.5, 0.0), slope(0.0, 0.5), -1.0).normalize()
    }

    /// The part [t0, t1] of a ray inside the field's box, from ≤ t ≤ to.
    pub fn clip(&self, ray: &Ray, from: f32, to: f32) -> Option<(f32, f32)> {
        let [x0, y0, x1, y1] = self.window;
        let (lo, hi) = (Vec3::new(x0, y0, 0.0), Vec3::new(x1, y1, self.deep));
        let (mut t0, mut t1) = (from, to);
        for k in 0..3 {
            let (o, d) = (ray.origin[k], ray.direction[k]);
            if d == 0.0 {
                if o < lo[k] || o > hi[k] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((lo[k] - o) / d, (hi[k] - o) / d);
            (t0, t1) = (t0.max(a.min(b)), t1.min(a.max(b)));
        }
        (t0 <= t1 && t1 < f32::INFINITY).then_some((t0, t1))
    }
}

/// Where `ray` meets the surface of `field` first, for `from` ≤ t ≤ `to`; `None` where it meets a wall first, or nothing.
pub fn trace(field: &Field, ray: &Ray, from: f32, to: f32, how: &Trace) -> Option<Hit> {
    let (t0, t1) = field.clip(ray, from, to)?;
    match how.search {
        Search::Linear { steps, halvings } => linear(field, ray, t0, t1, how.wall, steps, halvings),
        Search::Pyramid => field.pyramid.trace(field, ray, t0, t1),
    }
}

/// How far the point at t lies below the surface of its column; infinite below zero where the column has none.
fn below(field: &Field, ray: &Ray, t: f32, wall: f32) -> (f32, f32) {
    let p = ray.origin + ray.direction * t;
    let height = field.height(p.x, p.y, wall);
    (p.z - height, height)
}

fn linear(field: &Field, ray: &Ray, t0: f32, t1: f32, wall: f32, steps: u32, halvings: u32) -> Option<Hit> {
    let step = (t1 - t0) / steps as f32;
    // The ray enters the box through its front, where nothing can be, or through a side.
    let mut above = t0;
    let mut found = None;
    for i in 0..=steps {
        let t = t0 + step * i as f32;
        if below(field, ray, t, wall).0 >= 0.0 {
            found = Some(t);
            break;
        }
        above = t;
    }
    refine(field, ray, above, found?, wall, halvings)
}

/// Narrows the interval between a point above the surface and one below it, and judges whether there is a wall between them.
fn refine(field: &Field, ray: &Ray, mut above: f32, mut under: f32, wall: f32, halvings: u32) -> Option<Hit> {
    for _ in 0..halvings {
        let middle = (above + under) * 0.5;
        if below(field, ray, middle, wall).0 >= 0.0 {
            under = middle;
        } else {
            above = middle;
        }
    }
    let (a, b) = (below(field, ray, above, wall).1, below(field, ray, under, wall).1);
    let jump = a - b;
    // Written so that infinite depths count as walls.
    if !(jump.abs() <= wall) {
        return None;
    }
    Some(Hit { t: under, point: ray.origin + ray.direction * under })
}
