//! Contracting an edge into a place of its own.
//!
//! Where neither end of an edge can move onto the other, both can often move onto a third place within the tolerance. The places
//! tried are points of the lattice of vertices (quarter pixels and layers) around the ends and between them.

use super::{
    contract::{Link, keeps_side},
    cover::MOST_FACES,
    surface::{Scratch, Surface},
    topology::{next, prev},
};
use crate::voxel::touch::Point;

impl Surface {
    /// Moves both ends of the edge a–b to the first place around them that nothing forbids; `a` is gone then.
    pub fn merge(&mut self, a: u32, b: u32) -> bool {
        if self.locked[a as usize] || self.locked[b as usize] {
            return false;
        }
        let mut s = std::mem::take(&mut self.scratch);
        let topology = &self.topology;
        topology.star(a, &mut s.star);
        let ends_at_b = |c: u32| topology.at(next(c)) == b || topology.at(prev(c)) == b;
        let vanish = s.star.iter().filter(|c| ends_at_b(**c)).count();
        let (open_a, open_b) = (topology.is_boundary(a), topology.is_boundary(b));
        // An edge between two boundaries would pinch the surface.
        let fine = vanish == if open_a && open_b { 1 } else { 2 } && self.links(a, b, vanish, &mut s) == Link::Plain;
        let done = fine && self.merge_to(a, b, &mut s);
        self.scratch = s;
        done
    }

    fn merge_to(&mut self, a: u32, b: u32, s: &mut Scratch) -> bool {
        let topology = &self.topology;
        let mut star_b = Vec::new();
        topology.star(b, &mut star_b);
        let mut faces: Vec<u32> = s.star.iter().chain(&star_b).map(|c| c / 3).collect();
        faces.sort_unstable();
        faces.dedup();
        let kept: Vec<u32> = faces
            .iter()
            .copied()
            .filter(|f| {
                let c = topology.corners(*f);
                !(c.contains(&a) && c.contains(&b))
            })
            .collect();
        if kept.is_empty() || kept.len() > MOST_FACES {
            return false;
        }
        let mut ring = [&s.ring_a[..], &s.ring_b[..]].concat();
        ring.retain(|v| *v != a && *v != b);
        ring.sort_unstable();
        ring.dedup();
        self.cover.collect(faces.iter().copied());
        let open = self.topology.is_boundary(a) || self.topology.is_boundary(b);
        let mut new = Vec::with_capacity(kept.len());
        let ends = [self.points[a as usize], self.points[b as usize]];
        // Where alpha cuts outlines a boundary has farther to go.
        let farther = (open && self.alpha).then_some(OUTER_STRIDE);
        let strides = std::iter::once(STRIDE).chain(farther);
        for place in strides.flat_map(|stride| ends.into_iter().flat_map(move |p| around(p, stride))) {
            if !self.in_bounds(place) {
                continue;
            }
            new.clear();
            let turned = kept.iter().any(|f| {
                let corners = self.topology.corners(*f);
                let old = corners.map(|v| self.points[v as usize]);
                let moved = corners.map(|v| if v == a || v == b { place } else { self.points[v as usize] });
                new.push(moved);
                !keeps_side(old, moved)
            });
            if turned
                || !self.cover.keeps(&new)
                || !ring.iter().all(|v| {
                    let outer = open || self.topology.is_boundary(*v);
                    self.cover.holds(self.points[*v as usize], place, outer)
                })
            {
                continue;
            }
            self.cover.replace(faces.iter().copied(), &kept);
            self.topology.contract(&s.star, b);
            self.points[b as usize] = place;
            self.note(b);
            return true;
        }
        false
    }
}

/// How far to a side places are tried, quarter pixels: what measured best.
const STRIDE: f64 = 3.0;
/// And in a second try, where alpha cuts outlines, at boundaries.
const OUTER_STRIDE: f64 = 6.0;

/// A point and the lattice points beside it: `stride` quarter pixels and a layer to each side.
pub fn around(p: Point, stride: f64) -> impl Iterator<Item = Point> {
    let steps = [0.0, -1.0, 1.0];
    (0..27).map(move |k| [p[0] + stride * steps[k % 3], p[1] + stride * steps[k / 3 % 3], p[2] + 4.0 * steps[k / 9]])
}
