//! Pixels on one continuous surface.

use super::edges::{BELOW, RIGHT};

/// Searches the pixels around one that lie on the same continuous surface: reached by steps to 4-neighbours without
/// crossing a discontinuity.
pub struct Nearby<'a> {
    radius: i32,
    width: i32,
    edges: &'a [u8],
    /// Stamp of the search that reached a place of the window last.
    reached: Vec<u32>,
    stamp: u32,
    queue: Vec<(i32, i32)>,
}

impl<'a> Nearby<'a> {
    /// `radius`: pixels, the largest of any search.
    pub fn new(radius: i32, width: usize, edges: &'a [u8]) -> Self {
        let side = 2 * radius as usize + 1;
        let reached = vec![0; side * side];
        Self { radius, width: width as i32, edges, reached, stamp: 0, queue: Vec::new() }
    }

    /// True where `right(q)` holds for a pixel q so reached from `i` through pixels whose squared distance is at most `within`.
    pub fn any(&mut self, i: usize, within: i32, right: impl Fn(usize) -> bool) -> bool {
        self.visit(i, within, |q, _| right(q))
    }

    /// The least squared distance of a pixel q so reached with `right(q)`; `None` where there is none.
    pub fn nearest(&mut self, i: usize, within: i32, right: impl Fn(usize) -> bool) -> Option<i32> {
        let mut least = None;
        self.visit(i, within, |q, d| {
            if least.is_none_or(|l| d < l) && right(q) {
                least = Some(d);
            }
            false
        });
        least
    }

    /// Calls `stop` with the pixels and their squared distances until it says so; whether it did.
    fn visit(&mut self, i: usize, within: i32, mut stop: impl FnMut(usize, i32) -> bool) -> bool {
        let (r, w, h) = (self.radius, self.width, (self.edges.len() / self.width as usize) as i32);
        debug_assert!(within <= r * r);
        let (x0, y0) = (i as i32 % w, i as i32 / w);
        self.stamp = self.stamp.wrapping_add(1);
        self.queue.clear();
        self.queue.push((0, 0));
        let mut next = 0;
        while let Some(&(dx, dy)) = self.queue.get(next) {
            next += 1;
            let q = ((y0 + dy) * w + x0 + dx) as usize;
            if stop(q, dx * dx + dy * dy) {
                return true;
            }
            for (sx, sy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let (ex, ey) = (dx + sx, dy + sy);
                let (x, y) = (x0 + ex, y0 + ey);
                if ex * ex + ey * ey > within || x < 0 || y < 0 || x >= w || y >= h {
                    continue;
                }
                // The discontinuity is stored with the left or upper pixel of the pair.
                let first = if sx + sy > 0 { q } else { (y * w + x) as usize };
                if self.edges[first] & if sx != 0 { RIGHT } else { BELOW } != 0 {
                    continue;
                }
                let place = &mut self.reached[((ey + r) * (2 * r + 1) + ex + r) as usize];
                if *place != self.stamp {
                    *place = self.stamp;
                    self.queue.push((ex, ey));
                }
            }
        }
        false
    }
}
