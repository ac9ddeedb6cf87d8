//! The lines of sight on which surfaces show through gaps, by gap and by where they are.

use super::drop::neighbours;
use crate::voxel::{
    Voxel,
    gaps::Sight,
    touch::{centre, point},
};
use std::{
    cmp::Reverse,
    collections::{BTreeMap, BTreeSet},
};

/// Side of the squares that lines of sight are found by, quarter pixels.
const SQUARE: i32 = 64;

/// A place of the lattice that vertices lie on: quarter pixels and layers.
pub type Place = [i32; 3];

/// Lines of sight by gap, the largest first: those are in one whose voxels in front touch each other.
pub fn gaps(voxels: &[Voxel], sights: Vec<Sight>) -> Vec<Vec<Sight>> {
    let fronts: Vec<u32> = sights.iter().map(Sight::voxel).collect::<BTreeSet<_>>().into_iter().collect();
    let mut gap = vec![usize::MAX; fronts.len()];
    let (mut count, mut open) = (0, Vec::new());
    for first in 0..fronts.len() {
        if gap[first] != usize::MAX {
            continue;
        }
        gap[first] = count;
        open.push(first);
        while let Some(i) = open.pop() {
            for j in neighbours(voxels, fronts[i]).filter_map(|v| fronts.binary_search(&v).ok()) {
                if gap[j] == usize::MAX {
                    gap[j] = count;
                    open.push(j);
                }
            }
        }
        count += 1;
    }
    let mut all = vec![Vec::new(); count];
    for s in sights {
        let front = fronts.partition_point(|v| *v < s.voxel());
        all[gap[front]].push(s);
    }
    all.sort_by_key(|gap| Reverse(gap.len()));
    all
}

/// The lines of sight of all gaps, and which of them no triangle meets yet.
pub struct Lines<'a> {
    /// Every line with the number of its gap, gap by gap.
    all: Vec<(usize, &'a Sight)>,
    met: Vec<bool>,
    /// Where the lines of each gap begin.
    start: Vec<usize>,
    /// Numbers of the lines whose voxels in front lie in a square of pixels.
    squares: BTreeMap<[i32; 2], Vec<usize>>,
}

impl<'a> Lines<'a> {
    pub fn new(voxels: &[Voxel], gaps: &'a [Vec<Sight>]) -> Self {
        let all: Vec<(usize, &Sight)> =
            gaps.iter().enumerate().flat_map(|(i, gap)| gap.iter().map(move |s| (i, s))).collect();
        let mut squares: BTreeMap<[i32; 2], Vec<usize>> = BTreeMap::new();
        for (i, (_, s)) in all.iter().enumerate() {
            let front = centre(&voxels[s.voxel() as usize]);
            squares.entry([front[0], front[1]].map(|x| (x as i32).div_euclid(SQUARE))).or_default().push(i);
        }
        let start = gaps.iter().scan(0, |at, gap| Some(std::mem::replace(at, *at + gap.len()))).chain([all.len()]);
        Self { met: vec![false; all.len()], start: start.collect(), all, squares }
    }

    /// Those of a gap that are open.
    pub fn open(&self, gap: usize) -> impl Iterator<Item = &'a Sight> {
        let of_gap = self.start[gap]..self.start[gap + 1];
        of_gap.filter(|i| !self.met[*i]).map(|i| self.all[i].1)
    }

    /// Those of later gaps that are open and lie around `places`.
    pub fn beside(&self, gap: usize, places: &[Place]) -> impl Iterator<Item = &'a Sight> {
        self.near(places).filter(move |i| self.all[*i].0 > gap && !self.met[*i]).map(|i| self.all[i].1)
    }

    /// Notes which lines of a gap, and of others around it, a triangle meets.
    pub fn close(&mut self, gap: usize, corners: [Place; 3]) {
        let tried = self.near(&corners).chain(self.start[gap]..self.start[gap + 1]);
        let met: Vec<usize> = tried.filter(|i| meets(self.all[*i].1, corners)).collect();
        met.into_iter().for_each(|i| self.met[i] = true);
    }

    /// Numbers of the lines in the squares around `places`, and in those next to them.
    fn near(&self, places: &[Place]) -> impl Iterator<Item = usize> {
        let square = |i: usize| places.iter().map(move |p| p[i].div_euclid(SQUARE));
        let [columns, rows] =
            [0, 1].map(|i| square(i).min().map_or(0, |s| s - 1)..=square(i).max().map_or(0, |s| s + 1));
        rows.flat_map(move |y| columns.clone().filter_map(move |x| self.squares.get(&[x, y]))).flatten().copied()
    }
}

fn meets(sight: &Sight, corners: [Place; 3]) -> bool {
    sight.meets(corners.map(|p| sight.seen(point(p))))
}
