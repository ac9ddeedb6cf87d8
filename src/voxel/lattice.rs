//! The nearest voxels of a point, from voxels sorted by (layer, y, x).
//!
//! The order itself is the index: layers, rows within a layer and voxels within a row are each visited outwards from
//! the point, and a layer or row that lies farther than the worst of the best found ends its search. Exact, and its
//! answer depends on nothing but the voxels and the point.

use super::Voxel;
use glam::DVec3;

/// The most voxels that a search returns.
pub const MOST: usize = 16;

/// Voxels with an index of their layers and rows.
pub struct Lattice<'a> {
    voxels: &'a [Voxel],
    /// (layer, first row), and one past the end.
    layers: Vec<(u16, u32)>,
    /// (y, first voxel), and one past the end.
    rows: Vec<(u16, u32)>,
}

/// The `len` nearest voxels found, nearest first; equal distances by number.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    n: usize,
    len: usize,
    found: [(f64, u32); MOST],
}

impl Nearest {
    /// Will hold at most `n` voxels, 1 to [`MOST`].
    pub fn new(n: usize) -> Self {
        Self { n: n.clamp(1, MOST), len: 0, found: [(f64::INFINITY, u32::MAX); MOST] }
    }

    /// (squared distance in voxel sides, voxel number).
    pub fn found(&self) -> &[(f64, u32)] {
        &self.found[..self.len]
    }

    fn worst(&self) -> f64 {
        if self.len < self.n { f64::INFINITY } else { self.found[self.n - 1].0 }
    }

    fn insert(&mut self, d2: f64, voxel: u32) {
        let new = (d2, voxel);
        let at = self.found[..self.len].iter().position(|f| new < *f).unwrap_or(self.len);
        if at < self.n {
            self.len = (self.len + 1).min(self.n);
            self.found[at..self.len].rotate_right(1);
            self.found[at] = new;
        }
    }
}

/// The centre of a voxel in voxel space: x and y in pixels, z the layer.
pub fn centre(v: &Voxel) -> DVec3 {
    DVec3::new(f64::from(v.x) + 0.5, f64::from(v.y) + 0.5, f64::from(v.layer))
}

/// The nearest `n` of a few voxels in any order, by looking at all; `weight` as in [`Lattice::nearest`].
pub fn nearest_of_few(voxels: &[Voxel], p: DVec3, weight: DVec3, n: usize) -> Nearest {
    let mut best = Nearest::new(n);
    for (i, v) in voxels.iter().enumerate() {
        let d = centre(v) - p;
        best.insert(weight.z * (d.z * d.z) + weight.y * (d.y * d.y) + weight.x * (d.x * d.x), i as u32);
    }
    best
}

/// How many of `items` have their centre (`place` + ½) below `at`. Most rows have no gaps: there the first item's place
/// tells the answer, elsewhere it bounds the search.
fn position<T>(items: &[T], place: impl Fn(&T) -> u16, at: f64) -> usize {
    let Some(first) = items.first() else { return 0 };
    let below = |i: &T| f64::from(place(i)) + 0.5 < at;
    let guess = (at - f64::from(place(first)) + 0.5).clamp(0.0, items.len() as f64) as usize;
    if (guess == 0 || below(&items[guess - 1])) && items.get(guess).is_none_or(|i| !below(i)) {
        return guess;
    }
    items.partition_point(below)
}

/// Visits 0..len outwards from `start`, the nearer side first, as long as the squared distance (`gap`) of what is
/// next is at most `limit()`.
fn outwards<S>(
    state: &mut S,
    (start, first, end): (usize, usize, usize),
    gap: impl Fn(usize) -> f64,
    limit: impl Fn(&S) -> f64,
    mut visit: impl FnMut(&mut S, usize, f64),
) {
    let (mut below, mut above) = (start, start);
    let mut down = if below > first { gap(below - 1) } else { f64::INFINITY };
    let mut up = if above < end { gap(above) } else { f64::INFINITY };
    loop {
        let next = down.min(up);
        if next == f64::INFINITY || next > limit(state) {
            return;
        }
        if down <= up {
            below -= 1;
            visit(state, below, down);
            down = if below > first { gap(below - 1) } else { f64::INFINITY };
        } else {
            visit(state, above, up);
            above += 1;
            up = if above < end { gap(above) } else { f64::INFINITY };
        }
    }
}

impl<'a> Lattice<'a> {
    /// `voxels` must be sorted by (layer, y, x).
    pub fn new(voxels: &'a [Voxel]) -> Self {
        let (mut layers, mut rows) = (Vec::new(), Vec::new());
        let mut last = None;
        for (i, v) in voxels.iter().enumerate() {
            if last.is_none_or(|(l, _)| l != v.layer) {
                layers.push((v.layer, rows.len() as u32));
            }
            if last != Some((v.layer, v.y)) {
                rows.push((v.y, i as u32));
            }
            last = Some((v.layer, v.y));
        }
        layers.push((u16::MAX, rows.len() as u32));
        rows.push((u16::MAX, voxels.len() as u32));
        Self { voxels, layers, rows }
    }

    /// The `n` nearest voxels of `p` (x, y in pixels, z the layer) where a squared distance is the sum of the axes'
    /// squared distances, each times its `weight` (> 0); fewer only where there are fewer.
    pub fn nearest(&self, p: DVec3, weight: DVec3, n: usize) -> Nearest {
        let square = |d: f64| d * d;
        let layers = &self.layers[..self.layers.len() - 1];
        let start = layers.partition_point(|l| f64::from(l.0) < p.z);
        let mut best = Nearest::new(n);
        outwards(
            &mut best,
            (start, 0, layers.len()),
            |l| weight.z * square(f64::from(layers[l].0) - p.z),
            Nearest::worst,
            |best, l, dz| {
                let range = (self.layers[l].1 as usize, self.layers[l + 1].1 as usize);
                let start = range.0 + position(&self.rows[range.0..range.1], |r| r.0, p.y);
                outwards(
                    best,
                    (start, range.0, range.1),
                    |r| dz + weight.y * square(f64::from(self.rows[r].0) + 0.5 - p.y),
                    Nearest::worst,
                    |best, r, dyz| {
                        let range = (self.rows[r].1 as usize, self.rows[r + 1].1 as usize);
                        let start = range.0 + position(&self.voxels[range.0..range.1], |v| v.x, p.x);
                        outwards(
                            best,
                            (start, range.0, range.1),
                            |v| dyz + weight.x * square(f64::from(self.voxels[v].x) + 0.5 - p.x),
                            Nearest::worst,
                            |best, v, d2| best.insert(d2, v as u32),
                        );
                    },
                );
            },
        );
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxel::testing::voxel;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn agrees_with_looking_at_all(
            places in prop::collection::btree_set((0..6u16, 0..12u16, 0..12u16), 1..80),
            p in (-3.0..15.0f64, -3.0..15.0f64, -3.0..9.0f64),
            snap in any::<bool>(),
            weight in prop::array::uniform3(prop::sample::select(vec![0.0625, 1.0, 4.0])),
            n in 1..6usize,
        ) {
            let voxels: Vec<_> = places.iter().map(|&(l, y, x)| voxel(x, y, l, [0; 3])).collect();
            let mut p = DVec3::from(p);
            if snap {
                p = (p * 2.0).round() / 2.0;
            }
            let weight = DVec3::from(weight);
            let fast = Lattice::new(&voxels).nearest(p, weight, n);
            let few = nearest_of_few(&voxels, p, weight, n);
            prop_assert_eq!(few.found().len(), fast.found().len());
            let mut slow: Vec<_> = voxels.iter().enumerate().map(|(i, v)| {
                let d = centre(v) - p;
                (weight.z * (d.z * d.z) + weight.y * (d.y * d.y) + weight.x * (d.x * d.x), i as u32)
            }).collect();
            slow.sort_by(|a, b| a.partial_cmp(b).unwrap());
            slow.truncate(n);
            prop_assert_eq!(fast.found().len(), slow.len());
            for (f, s) in fast.found().iter().zip(&slow) {
                prop_assert!((f.0 - s.0).abs() < 1e-12);
            }
            if snap {
                prop_assert_eq!(fast.found(), &slow[..]);
                prop_assert_eq!(few.found(), &slow[..]);
            }
        }
    }

    #[test]
    fn nothing_to_find() {
        assert!(Lattice::new(&[]).nearest(DVec3::ZERO, DVec3::ONE, 4).found().is_empty());
    }
}
