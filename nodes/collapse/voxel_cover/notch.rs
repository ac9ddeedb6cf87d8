//! Filling notches: slits and steps in a boundary that are smaller than a voxel.
//!
//! The meshing operator leaves slits half a voxel wide, where a surface that is seen edge-on changes its row, and steps at every
//! voxel of a ragged edge. Nothing is seen through them, but their two sides may move apart by the tolerance each. So before
//! anything moves, the boundary's corners are filled with one triangle each, from the smallest on: slits close from
//! their ends.

use super::{remove::agrees, surface::Surface};
use crate::{
    math::{Stop, Stopped},
    voxel::touch::normal,
};
use std::{cmp::Reverse, collections::BinaryHeap};

/// Longest new edge, squared, in quarter units: a voxel's diagonal in one plane.
const LONGEST: u64 = 32;

impl Surface {
    /// Fills all notches; returns how many.
    pub fn fill_notches(&mut self, stop: &Stop) -> Result<usize, Stopped> {
        let mut queue = BinaryHeap::new();
        let (mut star, mut filled) = (Vec::new(), 0);
        for v in 0..self.points.len() as u32 {
            self.queue_notch(v, &mut queue, &mut star);
        }
        while let Some(Reverse((squared, w))) = queue.pop() {
            let Some([n, p]) = self.notch(w, &mut star) else { continue };
            if self.squared(n, p) != squared || !self.fill_notch(n, w, p) {
                continue;
            }
            filled += 1;
            if filled % 1024 == 0 {
                stop.check()?;
            }
            for v in [n, p] {
                self.queue_notch(v, &mut queue, &mut star);
            }
        }
        Ok(filled)
    }

    fn queue_notch(&self, w: u32, queue: &mut BinaryHeap<Reverse<(u64, u32)>>, star: &mut Vec<u32>) {
        if let Some([n, p]) = self.notch(w, star) {
            let squared = self.squared(n, p);
            if squared <= LONGEST {
                queue.push(Reverse((squared, w)));
            }
        }
    }

    /// The boundary's next and previous vertex at `w`, as its faces run.
    fn notch(&self, w: u32, star: &mut Vec<u32>) -> Option<[u32; 2]> {
        if !self.is_live(w) || !self.topology.is_boundary(w) {
            return None;
        }
        self.topology.star(w, star);
        self.topology.rim(w, star)
    }

    fn fill_notch(&mut self, n: u32, w: u32, p: u32) -> bool {
        if n == p || [n, w, p].iter().any(|v| self.locked[*v as usize]) {
            return false;
        }
        let closes = self.notch(n, &mut Vec::new()).is_some_and(|[after, _]| after == p);
        if !closes && self.are_neighbours(n, p) {
            return false;
        }
        let corners = [n, w, p].map(|v| self.points[v as usize]);
        let mut around = Vec::new();
        let mut star = Vec::new();
        let mut sides = Vec::new();
        for v in [n, w, p] {
            self.topology.star(v, &mut star);
            around.extend(star.iter().map(|c| c / 3));
            if v == w {
                sides.extend([star[0] / 3, star[star.len() - 1] / 3]);
            }
        }
        let turned = |f: &u32| {
            let [a, b, c] = self.triangle(*f);
            !agrees(corners, normal(a, b, c))
        };
        // The far side of a lone triangle is no notch.
        if sides[0] == sides[1] && closes || sides.iter().any(turned) {
            return false;
        }
        around.sort_unstable();
        around.dedup();
        self.cover.collect(around.iter().copied());
        if !self.cover.holds_face(corners, false) {
            return false;
        }
        let slot = self.topology.push_face();
        self.cover.push_face();
        self.cover.add(slot, corners);
        self.topology.fill(&[slot], &[[n, w, p]]);
        [n, w, p].iter().for_each(|v| self.note(*v));
        true
    }
}
