//! Sets of grid points, and their closure under the dependency relation.

use super::grid::Grid;

const BITS: usize = u64::BITS as usize;

/// A set of grid points: one bit each, rows padded to whole words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selection {
    side: usize,
    /// Words per row.
    stride: usize,
    words: Vec<u64>,
}

impl Selection {
    /// The empty set for a grid of `side` = 2^k+1 points a side.
    pub fn new(side: usize) -> Self {
        let stride = side.div_ceil(BITS);
        Self { side, stride, words: vec![0; stride * side] }
    }

    pub fn side(&self) -> usize {
        self.side
    }

    pub fn clear(&mut self) {
        self.words.fill(0);
    }

    /// Every point.
    pub fn fill(&mut self) {
        let last = self.last();
        for row in self.words.chunks_exact_mut(self.stride) {
            row.fill(u64::MAX);
            row[self.stride - 1] = last;
        }
    }

    /// The bits of the last word of a row that are points.
    fn last(&self) -> u64 {
        u64::MAX >> (self.stride * BITS - self.side)
    }

    #[inline]
    pub fn contains(&self, x: usize, y: usize) -> bool {
        self.words[y * self.stride + x / BITS] >> (x % BITS) & 1 != 0
    }

    /// Whether the point is new.
    #[inline]
    pub fn insert(&mut self, x: usize, y: usize) -> bool {
        let word = &mut self.words[y * self.stride + x / BITS];
        let bit = 1 << (x % BITS);
        let new = *word & bit == 0;
        *word |= bit;
        new
    }

    pub fn union(&mut self, other: &Self) {
        for (word, other) in self.words.iter_mut().zip(&other.words) {
            *word |= other;
        }
    }

    pub fn count(&self) -> usize {
        self.words.iter().map(|w| w.count_ones() as usize).sum()
    }

    /// All points (x, y), row by row.
    pub fn points(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.words.iter().enumerate().flat_map(move |(at, &word)| {
            let (x, y) = (at % self.stride * BITS, at / self.stride);
            std::iter::successors((word != 0).then_some(word), |w| Some(w & (w - 1)).filter(|w| *w != 0))
                .map(move |w| (x + w.trailing_zeros() as usize, y))
        })
    }

    /// Makes this the set of points whose value is greater than `bound`. `values` are row by row.
    pub fn above(&mut self, values: &[f32], bound: f32) {
        for (row, values) in self.words.chunks_exact_mut(self.stride).zip(values.chunks_exact(self.side)) {
            for (word, values) in row.iter_mut().zip(values.chunks(BITS)) {
                *word = values.iter().enumerate().fold(0, |bits, (b, v)| bits | u64::from(*v > bound) << b);
            }
        }
    }

    /// Adds what selected points depend on, from the finest level to the coarsest (figure 3).
    pub fn close(&mut self) {
        let n = self.side - 1;
        let mut h = 1;
        while h <= n / 2 {
            // Patterns of 4h points must repeat within a word.
            if 4 * h <= BITS {
                self.close_midpoints(h);
                if h < n / 2 {
                    self.close_centres(h);
                }
            } else {
                self.close_one_by_one(h);
            }
            h *= 2;
        }
    }

    /// A bit every `period` bits, starting at `first`.
    fn pattern(first: usize, period: usize) -> u64 {
        (first..BITS).step_by(period).fold(0, |bits, b| bits | 1 << b)
    }

    fn close_midpoints(&mut self, h: usize) {
        let n = self.side - 1;
        let (stride, last) = (self.stride, self.last());
        let (odd, even) = (Self::pattern(h, 2 * h), Self::pattern(0, 2 * h));
        for y in (0..=n).step_by(2 * h) {
            for w in 0..stride {
                let bits = self.words[y * stride + w] & odd;
                if bits == 0 {
                    continue;
                }
                if y > 0 {
                    self.words[(y - h) * stride + w] |= bits;
                }
                if y < n {
                    self.words[(y + h) * stride + w] |= bits;
                }
            }
        }
        for y in (h..n).step_by(2 * h) {
            let row = &mut self.words[y * stride..(y + 1) * stride];
            for w in 0..stride {
                let own = row[w] & even;
                let before = if w > 0 { row[w - 1] & even } else { 0 };
                let after = if w + 1 < stride { row[w + 1] & even } else { 0 };
                row[w] |= own << h | before >> (BITS - h) | own >> h | after << (BITS - h);
            }
            row[stride - 1] &= last;
        }
    }

    fn close_centres(&mut self, h: usize) {
        let n = self.side - 1;
        let stride = self.stride;
        let (first, third) = (Self::pattern(h, 4 * h), Self::pattern(3 * h, 4 * h));
        for y in (h..n).step_by(2 * h) {
            // Quads whose diagonal falls to the right, and those in which it rises.
            let (falling, rising) = if y & (2 * h) == 0 { (first, third) } else { (third, first) };
            for w in 0..stride {
                let row = y * stride;
                let own = self.words[row + w];
                let before = if w > 0 { self.words[row + w - 1] } else { 0 };
                let after = if w + 1 < stride { self.words[row + w + 1] } else { 0 };
                if own | before | after == 0 {
                    continue;
                }
                let right = |mask: u64| (own & mask) << h | (before & mask) >> (BITS - h);
                let left = |mask: u64| (own & mask) >> h | (after & mask) << (BITS - h);
                self.words[(y - h) * stride + w] |= right(falling) | left(rising);
                self.words[(y + h) * stride + w] |= left(falling) | right(rising);
            }
        }
    }

    fn close_one_by_one(&mut self, h: usize) {
        let grid = Grid::of(self.side);
        let n = self.side - 1;
        let mut add = |x: usize, y: usize| {
            if self.contains(x, y) {
                for (x, y) in grid.parents(x, y).into_iter().flatten() {
                    self.insert(x, y);
                }
            }
        };
        for y in (0..=n).step_by(h) {
            let (from, step) = if y & h == 0 { (h, 2 * h) } else { (0, 2 * h) };
            for x in (from..=n).step_by(step) {
                add(x, y);
            }
        }
        for y in (h..n).step_by(2 * h) {
            for x in (h..n).step_by(2 * h) {
                add(x, y);
            }
        }
    }
}
