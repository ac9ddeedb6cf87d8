//! Removing a vertex and triangulating its hole in any way that keeps the cover.
//!
//! A contraction only tries the fans of the hole; where all of them fold over or uncover a voxel, another triangulation often
//! does not. Holes of up to [`MOST_SIDES`] sides are tried in full, those with the shortest diagonals first.

use super::{
    contract::{Facing, look, within_80_degrees},
    surface::Surface,
};
use crate::voxel::touch::{Point, normal, squared};

/// The largest hole whose triangulations are all tried: 8 sides have 132.
pub const MOST_SIDES: usize = 8;

/// All triangulations of polygons with up to [`MOST_SIDES`] sides, by number of sides; corners ascending.
pub struct Triangulations(pub Vec<Vec<Vec<[u8; 3]>>>);

impl Triangulations {
    pub fn new() -> Self {
        Self((0..=MOST_SIDES as u8).map(|n| if n < 3 { Vec::new() } else { between(0, n - 1) }).collect())
    }
}

/// Triangulations of the polygon i, i + 1, …, j.
fn between(i: u8, j: u8) -> Vec<Vec<[u8; 3]>> {
    if j - i < 2 {
        return vec![Vec::new()];
    }
    let mut all = Vec::new();
    for k in i + 1..j {
        for left in between(i, k) {
            for right in between(k, j) {
                let mut one = vec![[i, k, j]];
                one.extend(left.iter().copied().chain(right));
                all.push(one);
            }
        }
    }
    all
}

/// What is known of a triangle of the hole.
#[derive(Clone)]
enum Known {
    Nothing,
    Forbidden,
    /// Bit i: touches the i-th voxel that no other face covers.
    Touches(Vec<u64>),
}

impl Surface {
    /// Removes `a` if some triangulation of the hole keeps everything that a contraction must keep.
    pub fn remove(&mut self, a: u32, all: &Triangulations) -> bool {
        if self.locked[a as usize] {
            return false;
        }
        let mut star = Vec::new();
        self.topology.star(a, &mut star);
        let boundary = self.topology.is_boundary(a);
        let mut ring = Vec::new();
        self.topology.ring(a, &star, &mut ring);
        let n = ring.len();
        if !(3..=MOST_SIDES).contains(&n) {
            return false;
        }
        // Of a tetrahedron two faces would be left, back to back.
        if n == 3 && !boundary && !self.topology.is_boundary(ring[0]) {
            let mut other = Vec::new();
            self.topology.star(ring[0], &mut other);
            if other.len() == 3 {
                return false;
            }
        }
        self.cover.collect(star.iter().map(|c| c / 3));
        let points: Vec<Point> = ring.iter().map(|v| self.points[*v as usize]).collect();
        let on_seam = |v: u32| self.locked[v as usize];
        if boundary && on_seam(ring[0]) && on_seam(ring[n - 1]) {
            return false;
        }
        // The side that closes the hole of a boundary vertex is a new boundary edge.
        if boundary && (self.are_neighbours(ring[n - 1], ring[0]) || !self.cover.holds(points[n - 1], points[0], true))
        {
            return false;
        }
        let squared = |i: u8, j: u8| squared(points[i as usize], points[j as usize]);
        let mut order: Vec<(f64, usize)> = all.0[n]
            .iter()
            .enumerate()
            .map(|(i, t)| (t.iter().map(|[i, _, j]| squared(*i, *j)).sum::<f64>(), i))
            .collect();
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));

        let steep = self.steep_normal(&star);
        let needed = self.cover.needed();
        let mut known = vec![Known::Nothing; n * n * n];
        let mut union = vec![0u64; needed.len().div_ceil(64)];
        let chosen = order.iter().map(|(_, i)| &all.0[n][*i]).find(|triangulation| {
            union.fill(0);
            for t in triangulation.iter() {
                let [i, j, k] = t.map(usize::from);
                let slot = &mut known[(i * n + j) * n + k];
                if matches!(slot, Known::Nothing) {
                    let corners = [points[i], points[j], points[k]];
                    let closes = (i, k) == (0, n - 1);
                    let free = |p: usize, q: usize| q == p + 1 || !self.are_neighbours(ring[p], ring[q]);
                    let ok = agrees(corners, steep) && free(i, j) && free(j, k) && (closes || free(i, k));
                    let old = |p: usize, q: usize| q == p + 1 || (p, q) == (0, n - 1);
                    let mut holds = |p: usize, q: usize| {
                        let outer = [p, q].iter().any(|k| self.topology.is_boundary(ring[*k]));
                        old(p, q) || self.cover.holds(points[p], points[q], outer)
                    };
                    let ok = ok && holds(i, j) && holds(j, k) && holds(i, k);
                    *slot = if ok { Known::Touches(self.cover.touched(corners, &needed)) } else { Known::Forbidden };
                }
                match slot {
                    Known::Touches(bits) => union.iter_mut().zip(bits).for_each(|(u, b)| *u |= *b),
                    _ => return false,
                }
            }
            union.iter().map(|u| u.count_ones() as usize).sum::<usize>() == needed.len()
        });
        let Some(chosen) = chosen else { return false };
        let new: Vec<[Point; 3]> = chosen.iter().map(|t| t.map(|i| points[usize::from(i)])).collect();
        if !self.cover.keeps(&new) {
            return false;
        }
        let faces: Vec<[u32; 3]> = chosen.iter().map(|t| t.map(|i| ring[usize::from(i)])).collect();
        let slots: Vec<u32> = star.iter().map(|c| c / 3).take(faces.len()).collect();
        self.cover.replace(star.iter().map(|c| c / 3), &slots);
        self.topology.refill(&star, &faces);
        ring.iter().for_each(|v| self.note(*v));
        true
    }

    /// Sum of the normals of the steep faces; zero if there are none.
    fn steep_normal(&self, star: &[u32]) -> Point {
        let mut sum = [0.0; 3];
        for c in star {
            let [a, b, c] = self.triangle(c / 3);
            let n = normal(a, b, c);
            if look(n) == Facing::Steep {
                (0..3).for_each(|i| sum[i] += n[i]);
            }
        }
        sum
    }
}

/// A new face must show its front to the cell or else, if it is steep, agree with those that it replaces.
pub fn agrees([a, b, c]: [Point; 3], steep: Point) -> bool {
    let n = normal(a, b, c);
    match look(n) {
        Facing::Front => true,
        Facing::Steep => within_80_degrees(steep, n),
        Facing::Back => false,
    }
}
