//! Which faces cover which voxels, and whether others could take their place.
//!
//! What always holds: a face's list names only voxels whose enlarged box it touches, and every visible voxel stands in a list.
//! Hidden voxels, those of the skirt, may be uncovered; as long as a face names them, boundary edges may run through their boxes.

use crate::voxel::{
    Voxel,
    touch::{self, Point, Toucher, cover_unit, interval_oblong},
};

/// Most faces that one replacement may make.
pub const MOST_FACES: usize = 64;

/// What a voxel demands of the faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Demand {
    /// It may be uncovered.
    Nothing,
    /// To be touched within its enlarged box.
    Touch,
    /// Likewise; the surface ends there, so that it had better be covered as the cell's centre sees it.
    End,
}

pub struct Cover {
    /// Voxel centres, quarter units.
    centres: Vec<Point>,
    /// What each demands.
    demands: Vec<Demand>,
    /// Half side of the enlarged boxes, quarter units.
    half: f64,
    /// How much farther to the sides of the boxes an edge at a boundary may run, quarter units: alpha cuts it there.
    skirt: f64,
    /// Per face: where its list begins in `arena` and how long it is.
    lists: Vec<(u32, u32)>,
    arena: Vec<u32>,
    /// In how many lists every voxel stands.
    count: Vec<u32>,
    /// The replacement under test: its voxels, how many of the old faces name each, and the new faces.
    voxels: Vec<u32>,
    within: Vec<u32>,
    touchers: Vec<Toucher>,
    intervals: Vec<(f64, f64)>,
}

impl Cover {
    pub fn new(voxels: &[Voxel], demands: Vec<Demand>, boxes: Boxes, starts: &[u32], arena: Vec<u32>) -> Self {
        let Boxes { half, skirt } = boxes;
        let mut count = vec![0; voxels.len()];
        for v in &arena {
            count[*v as usize] += 1;
        }
        let lists = starts.windows(2).map(|w| (w[0], w[1] - w[0])).collect();
        let within = vec![0; voxels.len()];
        Self {
            centres: voxels.iter().map(touch::centre).collect(),
            demands,
            half,
            skirt,
            lists,
            arena,
            count,
            voxels: Vec::new(),
            within,
            touchers: Vec::new(),
            intervals: Vec::new(),
        }
    }

    pub fn list(&self, face: u32) -> &[u32] {
        let (start, len) = self.lists[face as usize];
        &self.arena[start as usize..(start + len) as usize]
    }

    /// Begins a replacement: collects the voxels that the `old` faces name.
    pub fn collect(&mut self, old: impl Iterator<Item = u32>) {
        for v in self.voxels.drain(..) {
            self.within[v as usize] = 0;
        }
        for face in old {
            let (start, len) = self.lists[face as usize];
            for &v in &self.arena[start as usize..(start + len) as usize] {
                let within = &mut self.within[v as usize];
                if *within == 0 {
                    self.voxels.push(v);
                }
                *within += 1;
            }
        }
    }

    /// How many voxels are collected, visible or not.
    pub fn collected_count(&self) -> usize {
        self.voxels.len()
    }

    /// Centres of the collected voxels that demand something, and what.
    pub fn collected(&self) -> impl Iterator<Item = (&Point, Demand)> {
        let all = self.voxels.iter().map(|v| (&self.centres[*v as usize], self.demands[*v as usize]));
        all.filter(|(_, demand)| *demand != Demand::Nothing)
    }

    /// Whether the collected voxels' boxes hold the whole edge a–b (figure 14). Where it ends at a boundary (`outer`), it may run farther out
    /// to the sides.
    pub fn holds(&mut self, a: Point, b: Point, outer: bool) -> bool {
        let side = self.half + if outer { self.skirt } else { 0.0 };
        self.holds_within(a, b, [side, side, self.half])
    }

    fn holds_within(&mut self, a: Point, b: Point, half: Point) -> bool {
        self.intervals.clear();
        let [low, high] = [f64::min, f64::max].map(|f| -> Point { std::array::from_fn(|i| f(a[i], b[i])) });
        for v in &self.voxels {
            let c = &self.centres[*v as usize];
            if (0..3).all(|i| low[i] - half[i] <= c[i] && c[i] <= high[i] + half[i]) {
                self.intervals.extend(interval_oblong(a, b, c, half));
            }
        }
        cover_unit(&mut self.intervals)
    }

    /// Whether the collected voxels' boxes hold a whole face, tried along lines from its first corner, half a voxel apart
    /// at their ends. `outer` as in [`Cover::holds`].
    pub fn holds_face(&mut self, [a, b, c]: [Point; 3], outer: bool) -> bool {
        let steps = (touch::squared(b, c).sqrt() / 2.0).ceil().max(1.0);
        (0..=steps as u32).all(|k| {
            let t = f64::from(k) / steps;
            self.holds(a, std::array::from_fn(|i| b[i] + (c[i] - b[i]) * t), outer)
        })
    }

    /// The face loses its list.
    pub fn clear(&mut self, face: u32) {
        let (start, len) = std::mem::take(&mut self.lists[face as usize]);
        for v in &self.arena[start as usize..(start + len) as usize] {
            self.count[*v as usize] -= 1;
        }
    }

    /// Adds voxels to lists: (face, voxel), sorted, no two equal.
    pub fn extend(&mut self, gains: &[(u32, u32)]) {
        for group in gains.chunk_by(|a, b| a.0 == b.0) {
            let face = group[0].0;
            let (start, len) = self.lists[face as usize];
            let list = start as usize..(start + len) as usize;
            let at = self.arena.len();
            self.arena.extend_from_within(list.clone());
            for (_, v) in group {
                if !self.arena[list.clone()].contains(v) {
                    self.arena.push(*v);
                    self.count[*v as usize] += 1;
                }
            }
            self.lists[face as usize] = (at as u32, (self.arena.len() - at) as u32);
        }
    }

    pub fn touches(&self, corners: [Point; 3], voxel: u32) -> bool {
        let c = &self.centres[voxel as usize];
        let beyond = |i: usize| {
            let apart = corners.map(|p| p[i] - c[i]);
            apart.iter().all(|d| *d > self.half) || apart.iter().all(|d| *d < -self.half)
        };
        !(0..3).any(beyond) && Toucher::new(corners, self.half).touches(c)
    }

    /// For every voxel the faces that name it.
    pub fn faces_by_voxel(&self) -> Naming {
        let mut start = vec![0u32; self.centres.len() + 1];
        for (v, count) in self.count.iter().enumerate() {
            start[v + 1] = start[v] + count;
        }
        let mut at = start.clone();
        let mut faces = vec![0; start[self.centres.len()] as usize];
        for face in 0..self.lists.len() as u32 {
            for v in self.list(face) {
                faces[at[*v as usize] as usize] = face;
                at[*v as usize] += 1;
            }
        }
        Naming { start, faces }
    }

    /// Room for one more face.
    pub fn push_face(&mut self) {
        self.lists.push((0, 0));
    }

    /// A new face among those that stay: it covers what it touches of the collected voxels.
    pub fn add(&mut self, slot: u32, corners: [Point; 3]) {
        let toucher = Toucher::new(corners, self.half);
        let start = self.arena.len();
        self.arena.extend(self.voxels.iter().filter(|v| toucher.touches(&self.centres[**v as usize])));
        for v in &self.arena[start..] {
            self.count[*v as usize] += 1;
        }
        self.lists[slot as usize] = (start as u32, (self.arena.len() - start) as u32);
    }

    /// Whether every visible one of the collected voxels is touched by one of the new faces, or by a face that stays (figure 12).
    pub fn keeps(&mut self, new: &[[Point; 3]]) -> bool {
        self.touchers.clear();
        self.touchers.extend(new.iter().map(|t| Toucher::new(*t, self.half)));
        let mut last = 0;
        for i in 0..self.voxels.len() {
            let v = self.voxels[i];
            if self.is_needed(v) && !any_touches(&self.touchers, &self.centres[v as usize], &mut last) {
                // The next attempt with the same voxels will likely fail here too.
                self.voxels.swap(0, i);
                return false;
            }
        }
        true
    }

    /// Whether the collected voxel is visible and covered by old faces only.
    fn is_needed(&self, v: u32) -> bool {
        self.demands[v as usize] != Demand::Nothing && self.count[v as usize] == self.within[v as usize]
    }

    /// The visible ones of the collected voxels that no face but the old ones covers.
    pub fn needed(&self) -> Vec<u32> {
        self.voxels.iter().copied().filter(|v| self.is_needed(*v)).collect()
    }

    /// Bit i: the face touches the i-th voxel's box.
    pub fn touched(&self, corners: [Point; 3], voxels: &[u32]) -> Vec<u64> {
        let toucher = Toucher::new(corners, self.half);
        let word = |chunk: &[u32]| {
            let bit = |(i, v): (usize, &u32)| u64::from(toucher.touches(&self.centres[*v as usize])) << i;
            chunk.iter().enumerate().map(bit).fold(0, |a, b| a | b)
        };
        voxels.chunks(64).map(word).collect()
    }

    /// Carries the replacement out that [`Cover::keeps`] allowed: `old` faces lose their lists, new face i is `slots[i]`.
    pub fn replace(&mut self, old: impl Iterator<Item = u32>, slots: &[u32]) {
        for face in old {
            self.lists[face as usize] = (0, 0);
        }
        for v in &self.voxels {
            self.count[*v as usize] -= self.within[*v as usize];
        }
        for (toucher, &slot) in self.touchers.iter().zip(slots) {
            let start = self.arena.len();
            self.arena.extend(self.voxels.iter().filter(|v| toucher.touches(&self.centres[**v as usize])));
            for v in &self.arena[start..] {
                self.count[*v as usize] += 1;
            }
            self.lists[slot as usize] = (start as u32, (self.arena.len() - start) as u32);
        }
        if self.arena.len() > (1 << 31) {
            self.compact();
        }
    }

    /// Keeps only the lists of `faces`, in their order; the others must be empty. Sorts them, so that samples of their voxels lie apart.
    pub fn select(&mut self, faces: &[u32]) {
        self.lists = faces.iter().map(|f| self.lists[*f as usize]).collect();
        self.compact();
        for (start, len) in &self.lists {
            self.arena[*start as usize..(*start + *len) as usize].sort_unstable();
        }
    }

    /// Whether a single face names the voxel.
    pub fn is_named_once(&self, voxel: u32) -> bool {
        self.count[voxel as usize] == 1
    }

    fn compact(&mut self) {
        let mut arena = Vec::new();
        for (start, len) in &mut self.lists {
            let at = arena.len();
            arena.extend_from_slice(&self.arena[*start as usize..(*start + *len) as usize]);
            *start = at as u32;
        }
        self.arena = arena;
    }
}

/// How far boxes reach, quarter units.
#[derive(Clone, Copy, Debug)]
pub struct Boxes {
    /// Half side of a voxel's enlarged box.
    pub half: f64,
    /// See [`Cover::holds`].
    pub skirt: f64,
}

/// Whether one of the faces touches the box around `c`. `last`: which one did last time; boxes come in runs.
pub fn any_touches(touchers: &[Toucher], c: &Point, last: &mut usize) -> bool {
    if touchers.get(*last).is_some_and(|t| t.touches(c)) {
        return true;
    }
    let found = touchers.iter().position(|t| t.touches(c));
    *last = found.unwrap_or(*last);
    found.is_some()
}

/// For every voxel the faces that name it.
pub struct Naming {
    start: Vec<u32>,
    faces: Vec<u32>,
}

impl Naming {
    pub fn of(&self, voxel: u32) -> &[u32] {
        &self.faces[self.start[voxel as usize] as usize..self.start[voxel as usize + 1] as usize]
    }
}
