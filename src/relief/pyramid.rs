//! Depth ranges of squares of cells, so that rays skip what they cannot meet.

use super::{
    cell::{Cell, Span},
    field::{Field, Ray},
    trace::Hit,
};
use glam::Vec3;

/// Least and greatest depth of the surfaces in squares of 2^l cells a side, level l by level; without surface the first is above the second.
#[derive(Clone, Debug, Default)]
pub(super) struct Pyramid {
    /// Squares along a side of level 0: a power of two.
    side: u32,
    levels: Vec<Vec<[f32; 2]>>,
    wall: f32,
}

const NOTHING: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

/// How far beyond its cell a meeting still counts, in texel sides, so that rounding opens no gap between cells.
const SLACK: f32 = 2e-3;
/// How far into the next cell a ray is moved to leave one.
const NUDGE: f32 = 5e-4;
/// Rays that are steeper than this, across over along, are moved less.
const STEEP: f32 = 0.05;

impl Pyramid {
    pub fn new(field: &Field, wall: f32) -> Self {
        let side = field.side.next_power_of_two();
        let n = side as usize;
        let base = (0..n * n).map(|i| {
            let (x, y) = ((i % n) as i32, (i / n) as i32);
            Cell::new(field, x, y, wall).range(field, wall).map_or(NOTHING, |(lo, hi)| [lo, hi])
        });
        let mut levels = vec![base.collect::<Vec<_>>()];
        let mut m = n;
        while m > 1 {
            let below = &levels[levels.len() - 1];
            let half = m / 2;
            let level = (0..half * half).map(|i| {
                let at = (i / half) * 2 * m + (i % half) * 2;
                [at, at + 1, at + m, at + m + 1].iter().fold(NOTHING, |[lo, hi], k| {
                    let [a, b] = below[*k];
                    [lo.min(a), hi.max(b)]
                })
            });
            levels.push(level.collect());
            m = half;
        }
        Self { side, levels, wall }
    }

    /// All levels, the finest first.
    pub fn ranges(&self) -> impl Iterator<Item = [f32; 2]> {
        self.levels.iter().flatten().copied()
    }

    /// The first surface that the ray meets from its front between t0 and t1.
    pub fn trace(&self, field: &Field, ray: &Ray, t0: f32, t1: f32) -> Option<Hit> {
        let (o, d) = (ray.origin, ray.direction);
        // Along the map's own direction, up to rounding, texels bound nothing.
        let pace = d.x.abs().max(d.y.abs()).max(STEEP * d.z.abs());
        let (nudge, slack) = (NUDGE / pace, SLACK / pace);
        let top = self.levels.len() - 1;
        // Cells begin at the centre of the first texel.
        let (ox, oy) = (o.x - 0.5, o.y - 0.5);
        let (over_x, over_y) = (1.0 / d.x, 1.0 / d.y);
        // 1 where a square is left through its far side.
        let (far_x, far_y) = (i32::from(d.x > 0.0), i32::from(d.y > 0.0));
        let last = self.side as i32 - 1;
        // Most rays begin near a surface.
        let mut level = 2.min(top);
        // A ray along the map's direction, up to rounding, ends before it has moved so far.
        let mut t = (t0 + nudge).min((t0 + t1) * 0.5);
        while t < t1 {
            // Truncation is the floor of what is not negative.
            let i = ((ox + d.x * t) as i32).clamp(0, last);
            let j = ((oy + d.y * t) as i32).clamp(0, last);
            let from = (t - nudge).max(t0);
            let enter = o.z + d.z * from;
            // Down to the first square that the ray misses, or to a cell.
            loop {
                let (x, y) = (i >> level, j >> level);
                let x_end = if d.x == 0.0 { t1 } else { (((x + far_x) << level) as f32 - ox) * over_x };
                let y_end = if d.y == 0.0 { t1 } else { (((y + far_y) << level) as f32 - oy) * over_y };
                let end = x_end.min(y_end).min(t1).max(t);
                let [lo, hi] = self.levels[level][(y << (top - level)) as usize + x as usize];
                let leave = o.z + d.z * end;
                if enter.max(leave) + SLACK < lo || enter.min(leave) - SLACK > hi {
                    t = end + nudge;
                    level = (level + 1).min(top);
                    break;
                }
                if level == 0 {
                    let span = Span { origin: o, direction: d, from: from - slack, to: end + slack };
                    if let Some(t) = Cell::new(field, i, j, self.wall).meet(field, self.wall, &span) {
                        return Some(Hit { t, point: o + d * t });
                    }
                    t = end + nudge;
                    level = 1.min(top);
                    break;
                }
                level -= 1;
            }
        }
        None
    }

    /// The cells that hold a surface, with a box around it: u, v and w, least and greatest.
    pub fn cells(&self) -> impl Iterator<Item = ([i32; 2], [Vec3; 2])> {
        let cells = self.levels.first().map_or(&[][..], |base| base);
        cells.iter().zip(0_u32..).filter(|([lo, hi], _)| lo <= hi).map(|([lo, hi], i)| {
            let (i, j) = (i % self.side, i / self.side);
            let (x, y) = (i as f32 + 0.5, j as f32 + 0.5);
            ([i as i32, j as i32], [Vec3::new(x, y, *lo) - SLACK, Vec3::new(x + 1.0, y + 1.0, *hi) + SLACK])
        })
    }

    /// Whether the ray meets a surface of this cell from its front.
    pub fn meets_cell(&self, field: &Field, [i, j]: [i32; 2], ray: &Ray) -> bool {
        let (o, d) = (ray.origin, ray.direction);
        let (mut from, mut to) = (f32::NEG_INFINITY, f32::INFINITY);
        let side = |low: i32| (low as f32 + 0.5 - SLACK, low as f32 + 1.5 + SLACK);
        for (o, d, (lo, hi)) in [(o.x, d.x, side(i)), (o.y, d.y, side(j)), (o.z, d.z, (-1.0, field.deep + 1.0))] {
            if d == 0.0 {
                if o < lo || o > hi {
                    return false;
                }
                continue;
            }
            let (a, b) = ((lo - o) / d, (hi - o) / d);
            (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
        }
        from <= to
            && Cell::new(field, i, j, self.wall)
                .meet(field, self.wall, &Span { origin: o, direction: d, from, to })
                .is_some()
    }
}
