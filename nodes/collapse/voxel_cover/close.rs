//! Closing holes that are smaller than the tolerance.
//!
//! Where a surface passes from layer to layer along a diagonal, the meshing operator leaves gaps no larger than a voxel.
//! No pixel is seen through them, but each keeps at least three vertices. A hole is closed where the enlarged
//! boxes of the voxels around it hold all of it: what figure 14 asks of an edge, asked of a face.

use super::{
    remove::{MOST_SIDES, Triangulations, agrees},
    surface::Surface,
    topology::NONE,
};
use crate::{
    math::{Stop, Stopped},
    voxel::touch::{Point, normal},
};

impl Surface {
    /// Closes every hole of up to [`MOST_SIDES`] sides that may be closed; returns how many.
    pub fn close_holes(&mut self, all: &Triangulations, stop: &Stop) -> Result<usize, Stopped> {
        let mut free: Vec<u32> =
            (0..self.topology.vertex.len() as u32 / 3).filter(|f| !self.topology.is_live(*f)).collect();
        let (mut rim, mut closed) = (Vec::new(), 0);
        for v in 0..self.points.len() as u32 {
            if v % 1024 == 0 {
                stop.check()?;
            }
            // Each loop once, from its smallest vertex.
            if self.is_live(v)
                && self.topology.is_boundary(v)
                && self.topology.boundary_loop(v, MOST_SIDES, &mut rim)
                && rim.iter().all(|u| *u >= v)
                && self.close(&rim, all, &mut free)
            {
                closed += 1;
            }
        }
        Ok(closed)
    }

    fn close(&mut self, rim: &[u32], all: &Triangulations, free: &mut Vec<u32>) -> bool {
        let n = rim.len();
        if n < 3 || free.len() < n - 2 || rim.iter().any(|v| self.locked[*v as usize]) {
            return false;
        }
        // Faces in the hole run against its rim as the faces around see it.
        let ring: Vec<u32> = rim.iter().rev().copied().collect();
        let points: Vec<Point> = ring.iter().map(|v| self.points[*v as usize]).collect();
        let (mut star, mut around) = (Vec::new(), Vec::new());
        for v in &ring {
            self.topology.star(*v, &mut star);
            around.extend(star.iter().map(|c| c / 3));
        }
        around.sort_unstable();
        around.dedup();
        let mut sum = [0.0; 3];
        for f in &around {
            let [a, b, c] = self.triangle(*f);
            let m = normal(a, b, c);
            (0..3).for_each(|i| sum[i] += m[i]);
        }
        self.cover.collect(around.iter().copied());
        let fits = |s: &mut Self, t: [u8; 3]| {
            let [i, j, k] = t.map(usize::from);
            let corners = [points[i], points[j], points[k]];
            let free = |p: usize, q: usize| q == p + 1 || (p, q) == (0, n - 1) || !s.are_neighbours(ring[p], ring[q]);
            let ok = agrees(corners, sum) && free(i, j) && free(j, k) && free(i, k);
            // The far side of a lone triangle is no hole.
            let back = |f: &u32| {
                let mut c = s.topology.corners(*f);
                c.sort_unstable();
                let mut mine = [ring[i], ring[j], ring[k]];
                mine.sort_unstable();
                c == mine
            };
            ok && !around.iter().any(back) && s.cover.holds_face(corners, false)
        };
        let Some(chosen) = all.0[n].iter().find(|t| t.iter().all(|t| fits(self, *t))) else { return false };
        let slots: Vec<u32> = (0..chosen.len()).filter_map(|_| free.pop()).collect();
        let faces: Vec<[u32; 3]> = chosen.iter().map(|t| t.map(|i| ring[usize::from(i)])).collect();
        for (t, slot) in chosen.iter().zip(&slots) {
            self.cover.add(*slot, t.map(|i| points[usize::from(i)]));
        }
        debug_assert!(slots.iter().all(|s| self.topology.opposite[3 * *s as usize] == NONE));
        self.topology.fill(&slots, &faces);
        ring.iter().for_each(|v| self.note(*v));
        true
    }
}
