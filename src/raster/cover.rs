//! Coverage: which samples a snapped triangle covers, by exact integer edge functions and the top-left rule.
//!
//! With corners a, b in order, E(p) = (bx−ax)(py−ay) − (by−ay)(px−ax) is positive inside (y down, positive area). A
//! sample on an edge belongs to the triangle whose top or left edge it is, so two triangles that share an edge never
//! both cover a sample and never both miss it. Between neighbouring samples E changes by multiples of 256 steps;
//! ⌊E/256⌋ has the sign of E, and inside a tile fits 32 bits.

use super::camera::STEPS;
use super::tile::Tile;

/// A rectangle of samples, inclusive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rect {
    pub x0: i32,
    pub y0: i32,
    pub x1: i32,
    pub y1: i32,
}

impl Rect {
    pub fn is_empty(&self) -> bool {
        self.x0 > self.x1 || self.y0 > self.y1
    }

    pub fn intersect(self, o: Self) -> Self {
        Self { x0: self.x0.max(o.x0), y0: self.y0.max(o.y0), x1: self.x1.min(o.x1), y1: self.y1.min(o.y1) }
    }
}

/// The samples (pixel centres) inside the bounds of snapped points.
pub(crate) fn samples_within(v: &[[i32; 2]; 3]) -> Rect {
    let half = STEPS / 2;
    let first = |a: i32, b: i32, c: i32| (a.min(b).min(c) + half - 1).div_euclid(STEPS);
    let last = |a: i32, b: i32, c: i32| (a.max(b).max(c) - half).div_euclid(STEPS);
    Rect {
        x0: first(v[0][0], v[1][0], v[2][0]),
        y0: first(v[0][1], v[1][1], v[2][1]),
        x1: last(v[0][0], v[1][0], v[2][0]),
        y1: last(v[0][1], v[1][1], v[2][1]),
    }
}

/// Twice the signed area in steps²; positive where the corners run clockwise as seen on the screen.
pub(crate) fn doubled_area(v: &[[i32; 2]; 3]) -> i64 {
    let d = |i: usize, k: usize| (v[i][k] - v[0][k]) as i64;
    d(1, 0) * d(2, 1) - d(1, 1) * d(2, 0)
}

/// One edge: its ⌊E/256⌋ at a rectangle's first sample and its change to the next sample in x and y.
#[derive(Clone, Copy, Default)]
struct Edge {
    e: i32,
    dx: i32,
    dy: i32,
}

/// The three edges over `rect`; `None` where no sample of it is covered for certain. The triangle has positive area.
fn edges(v: &[[i32; 2]; 3], rect: Rect) -> Option<[Edge; 3]> {
    let (px, py) = (rect.x0 * STEPS + STEPS / 2, rect.y0 * STEPS + STEPS / 2);
    let (w, h) = ((rect.x1 - rect.x0) as i64, (rect.y1 - rect.y0) as i64);
    let mut out = [Edge::default(); 3];
    for (i, edge) in out.iter_mut().enumerate() {
        let (a, b) = (v[i], v[(i + 1) % 3]);
        let (ex, ey) = (b[0] - a[0], b[1] - a[1]);
        let top_left = ey < 0 || (ey == 0 && ex > 0);
        let at = ex as i64 * (py - a[1]) as i64 - ey as i64 * (px - a[0]) as i64 - !top_left as i64;
        let e = at >> STEPS.trailing_zeros();
        let (dx, dy) = (-ey, ex);
        let most = e + (dx as i64 * w).max(0) + (dy as i64 * h).max(0);
        let least = e + (dx as i64 * w).min(0) + (dy as i64 * h).min(0);
        if most < 0 {
            return None;
        }
        // Inside everywhere: an edge that always holds. Otherwise 0 lies within the rectangle's range, so |E/256| is at
        // most the change across it: 64 · 2 · 2²³ < 2³¹.
        *edge = if least >= 0 { Edge::default() } else { Edge { e: e as i32, dx, dy } };
    }
    Some(out)
}

/// Whether any sample of the rectangle might be covered: exact for single edges, so few tiles are visited in vain.
pub(crate) fn may_cover(v: &[[i32; 2]; 3], rect: Rect) -> bool {
    edges(v, rect).is_some()
}

/// Widest and highest rectangle of samples for which [`small_mask`] answers.
pub(crate) const SMALL: i32 = 4;

/// The covered samples of a small triangle (positive area): bit 4·(y − y0) + (x − x0) for the samples of `within`, counted
/// from the first of `all`, the samples within the triangle's bounds.
pub(crate) fn small_mask(v: &[[i32; 2]; 3], all: Rect, within: Rect) -> u16 {
    debug_assert!(all.x1 - all.x0 < SMALL && all.y1 - all.y0 < SMALL);
    // Corners lie less than SMALL + 1 pixels apart: products stay below 2²².
    let (px, py) = (within.x0 * STEPS + STEPS / 2, within.y0 * STEPS + STEPS / 2);
    let mut e = [0i32; 3];
    let mut step = [[0i32; 2]; 3];
    for i in 0..3 {
        let (a, b) = (v[i], v[(i + 1) % 3]);
        let (ex, ey) = (b[0] - a[0], b[1] - a[1]);
        let top_left = ey < 0 || (ey == 0 && ex > 0);
        e[i] = ex * (py - a[1]) - ey * (px - a[0]) - !top_left as i32;
        step[i] = [-ey * STEPS, ex * STEPS];
    }
    let mut mask = 0;
    for y in within.y0..=within.y1 {
        let mut at = e;
        for x in within.x0..=within.x1 {
            let inside = (at[0] | at[1] | at[2]) >= 0;
            mask |= (inside as u16) << (SMALL * (y - all.y0) + (x - all.x0));
            at = [at[0] + step[0][0], at[1] + step[1][0], at[2] + step[2][0]];
        }
        e = [e[0] + step[0][1], e[1] + step[1][1], e[2] + step[2][1]];
    }
    mask
}

/// Calls `span(y, x0, x1)` for the covered samples x0..x1 of every row of `rect`, a rectangle within one tile.
#[inline]
pub(crate) fn cover(v: &[[i32; 2]; 3], rect: Rect, mut span: impl FnMut(i32, i32, i32)) {
    debug_assert!(rect.x1 - rect.x0 < Tile::SIDE as i32 && rect.y1 - rect.y0 < Tile::SIDE as i32);
    let Some([mut a, mut b, mut c]) = edges(v, rect) else { return };
    let n = rect.x1 - rect.x0 + 1;
    for y in rect.y0..=rect.y1 {
        let (from, to) = if n > 16 { span_by_division([a, b, c], n) } else { span_by_steps([a, b, c], n) };
        if from < to {
            span(y, rect.x0 + from, rect.x0 + to);
        }
        for k in [&mut a, &mut b, &mut c] {
            k.e = k.e.wrapping_add(k.dy);
        }
    }
}

/// The first and one past the last of `n` samples of a row that lie inside all three edges.
fn span_by_division(edges: [Edge; 3], n: i32) -> (i32, i32) {
    let (mut from, mut to) = (0, n);
    for k in edges {
        // Where e + dx·i ≥ 0.
        if k.dx > 0 {
            from = from.max(-k.e.div_euclid(k.dx));
        } else if k.dx < 0 {
            to = to.min(k.e.div_euclid(-k.dx) + 1);
        } else if k.e < 0 {
            to = 0;
        }
    }
    (from, to)
}

/// As [`span_by_division`], faster for short rows.
fn span_by_steps([a, b, c]: [Edge; 3], n: i32) -> (i32, i32) {
    let (mut ea, mut eb, mut ec) = (a.e, b.e, c.e);
    let mut step = || {
        (ea, eb, ec) = (ea.wrapping_add(a.dx), eb.wrapping_add(b.dx), ec.wrapping_add(c.dx));
        (ea | eb | ec) >= 0
    };
    let mut inside = (a.e | b.e | c.e) >= 0;
    let mut x = 0;
    while x < n && !inside {
        inside = step();
        x += 1;
    }
    let from = x;
    while x < n && inside {
        inside = step();
        x += 1;
    }
    (from, x)
}
