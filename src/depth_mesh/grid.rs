//! Addresses in the restricted quadtree: points, their dependencies (figure 3) and quadtree nodes.
//!
//! A point (x, y) of the grid of (2^k+1)² belongs to the level of its half size h, the largest power of two that divides both
//! coordinates. Where x/h and y/h are both odd it is the centre of a quad of side 2h; else it is the midpoint of a horizontal or vertical edge of
//! length 2h. The four corners of the grid belong to no level. Nodes are quads; level 0 is the whole grid, level k−1 has quads
//! of 2 × 2 cells.

/// The boundary of a node from its north-west corner clockwise, in half sides from its centre.
pub(super) const RING: [(isize, isize); 8] = [(-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0)];

/// The point `h` steps of `d` from (x, y).
#[inline]
pub(super) fn step((x, y): (usize, usize), (dx, dy): (isize, isize), h: usize) -> (usize, usize) {
    (x.wrapping_add_signed(dx * h as isize), y.wrapping_add_signed(dy * h as isize))
}

/// The midpoint of a side (0 to 3: N, E, S, W) of the node with half side h around a point.
#[inline]
pub(super) fn midpoint(centre: (usize, usize), h: usize, side: usize) -> (usize, usize) {
    step(centre, RING[2 * side + 1], h)
}

/// A grid of 2^k+1 points a side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Grid {
    pub k: u32,
}

/// Up to four points.
pub(super) type Points<const N: usize> = [Option<(usize, usize)>; N];

impl Grid {
    pub fn of(side: usize) -> Self {
        Self { k: (side - 1).trailing_zeros() }
    }

    /// Cells a side.
    pub fn cells(self) -> usize {
        1 << self.k
    }

    /// Points a side.
    pub fn side(self) -> usize {
        self.cells() + 1
    }

    /// Nodes of the levels before `level`.
    pub fn before(self, level: u32) -> usize {
        ((1usize << (2 * level)) - 1) / 3
    }

    /// Nodes of all levels.
    pub fn nodes(self) -> usize {
        self.before(self.k)
    }

    /// Half the side of a node of `level`.
    pub fn half(self, level: u32) -> usize {
        1 << (self.k - 1 - level)
    }

    /// Node (i, j) of `level`.
    #[inline]
    pub fn node(self, level: u32, i: usize, j: usize) -> usize {
        self.before(level) + (j << level) + i
    }

    /// The node of `level` that holds (x, y) inside.
    #[inline]
    pub fn node_around(self, level: u32, x: usize, y: usize) -> usize {
        let shift = self.k - level;
        self.node(level, x >> shift, y >> shift)
    }

    pub fn is_corner(self, x: usize, y: usize) -> bool {
        (x | y) & (self.cells() - 1) == 0
    }

    /// The half size of a point that is no corner.
    #[inline]
    pub fn half_at(x: usize, y: usize) -> usize {
        1 << (x | y).trailing_zeros()
    }

    /// The two points that (x, y) depends on: none for corners and for the centre of the grid, one for midpoints of the border.
    #[inline]
    pub fn parents(self, x: usize, y: usize) -> Points<2> {
        if self.is_corner(x, y) || Self::half_at(x, y) == self.cells() / 2 && x == y {
            return [None; 2];
        }
        let h = Self::half_at(x, y);
        let inside = |x: usize, y: usize| (x <= self.cells() && y <= self.cells()).then_some((x, y));
        match (x & h != 0, y & h != 0) {
            (true, true) if (x ^ y) & (2 * h) == 0 => [Some((x + h, y - h)), Some((x - h, y + h))],
            (true, true) => [Some((x - h, y - h)), Some((x + h, y + h))],
            (true, false) => [y.checked_sub(h).map(|y| (x, y)), inside(x, y + h)],
            _ => [x.checked_sub(h).map(|x| (x, y)), inside(x + h, y)],
        }
    }

    /// The ends of the edge that a point bisects (a and b of equations 1 and 2); not for corners.
    #[inline]
    pub fn ends(x: usize, y: usize) -> [(usize, usize); 2] {
        let h = Self::half_at(x, y);
        match (x & h != 0, y & h != 0) {
            (true, true) if (x ^ y) & (2 * h) == 0 => [(x - h, y - h), (x + h, y + h)],
            (true, true) => [(x + h, y - h), (x - h, y + h)],
            (true, false) => [(x - h, y), (x + h, y)],
            _ => [(x, y - h), (x, y + h)],
        }
    }

    /// The corners opposite to that edge of the triangles that share it: what a point depends on, corners of the grid included.
    pub fn apexes(self, x: usize, y: usize) -> Points<2> {
        let n = self.cells();
        if 2 * x == n && x == y { [Some((n, 0)), Some((0, n))] } else { self.parents(x, y) }
    }

    /// The points that depend on a point that is no corner.
    #[inline]
    pub fn dependants(self, x: usize, y: usize) -> Points<4> {
        let h = Self::half_at(x, y);
        let n = self.cells();
        let at = |x: Option<usize>, y: Option<usize>| match (x, y) {
            (Some(x), Some(y)) if x <= n && y <= n => Some((x, y)),
            _ => None,
        };
        if x & h != 0 && y & h != 0 {
            return [Some((x, y - h)), Some((x + h, y)), Some((x, y + h)), Some((x - h, y))];
        }
        if h == 1 {
            return [None; 4];
        }
        let q = h / 2;
        let [left, right] = [x.checked_sub(q), Some(x + q)];
        let [above, below] = [y.checked_sub(q), Some(y + q)];
        [at(left, above), at(right, above), at(right, below), at(left, below)]
    }
}
