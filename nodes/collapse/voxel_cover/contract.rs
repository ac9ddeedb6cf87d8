//! One contraction: may vertex `a` move onto its neighbour `b`?

use super::{
    cover::{Cover, MOST_FACES},
    topology::{Topology, next, prev},
};
use crate::voxel::touch::{Point, front_area, normal};

/// The mesh while it is simplified.
pub struct Surface {
    pub topology: Topology,
    pub cover: Cover,
    /// Vertices, quarter units; they never move.
    pub points: Vec<Point>,
    /// Vertices on seams stay.
    pub locked: Vec<bool>,
    pub scratch: Scratch,
}

/// Buffers of the contraction under test.
#[derive(Default)]
pub struct Scratch {
    pub star: Vec<u32>,
    other: Vec<u32>,
    new: Vec<[Point; 3]>,
    slots: Vec<u32>,
    /// Vertices next to `a`, marked by the number of the attempt.
    marks: Vec<u32>,
    attempt: u32,
}

impl Surface {
    pub fn triangle(&self, face: u32) -> [Point; 3] {
        self.topology.corners(face).map(|v| self.points[v as usize])
    }

    pub fn is_live(&self, vertex: u32) -> bool {
        self.topology.corner[vertex as usize] != super::topology::NONE
    }

    /// Squared length of the edge a–b; an integer.
    pub fn squared(&self, a: u32, b: u32) -> u64 {
        let (a, b) = (self.points[a as usize], self.points[b as usize]);
        (0..3).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum::<f64>() as u64
    }

    /// Moves `a` onto `b` if nothing forbids it; `a` is gone then.
    pub fn contract(&mut self, a: u32, b: u32) -> bool {
        if self.locked[a as usize] {
            return false;
        }
        let mut s = std::mem::take(&mut self.scratch);
        let done = self.allowed(a, b, &mut s);
        if done {
            self.cover.replace(s.star.iter().map(|c| c / 3), &s.slots);
            self.topology.contract(&s.star, b);
        }
        self.scratch = s;
        done
    }

    fn allowed(&mut self, a: u32, b: u32, s: &mut Scratch) -> bool {
        let topology = &self.topology;
        topology.star(a, &mut s.star);
        let ends_at = |c: u32| topology.at(next(c)) == b || topology.at(prev(c)) == b;
        let vanish = s.star.iter().filter(|c| ends_at(**c)).count();
        let boundary = topology.is_boundary(a);
        let Some((&first, &last)) = s.star.first().zip(s.star.last()) else { return false };
        // The other end of the boundary edge that vanishes into a–b, if `a` lies on the boundary (figure 13).
        let other_end = match (boundary, topology.at(next(first)), topology.at(prev(last))) {
            (false, ..) => None,
            (true, n, p) if n == b => Some(p),
            (true, n, p) if p == b => Some(n),
            _ => return false,
        };
        if vanish != if boundary { 1 } else { 2 } || s.star.len() - vanish > MOST_FACES {
            return false;
        }
        // What remains turns over nowhere.
        s.new.clear();
        s.slots.clear();
        for &c in &s.star {
            if ends_at(c) {
                continue;
            }
            let (n, p) = (self.points[topology.at(next(c)) as usize], self.points[topology.at(prev(c)) as usize]);
            let (old, new) = ([self.points[a as usize], n, p], [self.points[b as usize], n, p]);
            if !keeps_side(old, new) {
                return false;
            }
            s.new.push(new);
            s.slots.push(c / 3);
        }
        if !self.stays_manifold(b, boundary, s) {
            return false;
        }
        self.cover.collect(s.star.iter().map(|c| c / 3));
        if let Some(end) = other_end
            && !self.cover.holds_edge(self.points[end as usize], self.points[b as usize])
        {
            return false;
        }
        self.cover.keeps(&s.new)
    }

    /// The link condition: the ends of the edge share no neighbours but those in the faces that vanish.
    fn stays_manifold(&self, b: u32, boundary: bool, s: &mut Scratch) -> bool {
        let topology = &self.topology;
        s.marks.resize(self.points.len(), 0);
        s.attempt += 1;
        for &c in &s.star {
            s.marks[topology.at(next(c)) as usize] = s.attempt;
            s.marks[topology.at(prev(c)) as usize] = s.attempt;
        }
        topology.star(b, &mut s.other);
        let mut shared = 0;
        for &c in &s.other {
            shared += u32::from(s.marks[topology.at(next(c)) as usize] == s.attempt);
        }
        if topology.is_boundary(b)
            && let Some(&last) = s.other.last()
        {
            shared += u32::from(s.marks[topology.at(prev(last)) as usize] == s.attempt);
        }
        // A boundary edge's only face must not be all there is.
        shared == if boundary { 1 } else { 2 } && !(s.star.len() == 1 && s.other.len() == 1)
    }
}

/// Whether a face stays on its side: as the cell's centre sees it, nothing folds over. A wall, which the centre sees
/// edge-on, has no side there; its normal turns by at most 80°.
pub fn keeps_side(old: [Point; 3], new: [Point; 3]) -> bool {
    let [before, after] = [old, new].map(|[a, b, c]| front_area(a, b, c));
    if after < 0.0 {
        return false;
    }
    if before > 0.0 && after > 0.0 {
        return true;
    }
    let [m, n] = [old, new].map(|[a, b, c]| normal(a, b, c));
    within_80_degrees(m, n)
}

/// Whether two vectors, neither zero, enclose at most 80°.
pub fn within_80_degrees(m: Point, n: Point) -> bool {
    let dot = |u: Point, v: Point| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    /// cos² 80°
    const LEAST: f64 = 0.030_153_689_607_045_8;
    let along = dot(m, n);
    along > 0.0 && along * along >= LEAST * dot(m, m) * dot(n, n)
}
