//! One contraction: may vertex `a` move onto its neighbour `b`?

use super::{
    cover::MOST_FACES,
    queue::Rank,
    surface::{Scratch, Surface},
    topology::{NONE, next, prev},
};
use crate::voxel::touch::{Point, dot, normal, sub};

impl Surface {
    /// What moving a vertex costs: squared distances from the planes of the faces around it, times their areas, and from the lines of its
    /// boundary edges, times their lengths, unless alpha cuts the outline.
    pub fn quadric(&self, a: u32) -> Quadric {
        let topology = &self.topology;
        let here = self.points[a as usize];
        let mut sum = Quadric::default();
        let first = topology.corner[a as usize];
        let mut c = first;
        while c != NONE {
            let [p, q, r] = self.triangle(c / 3);
            sum.add_plane(normal(p, q, r));
            for (edge, end) in [(prev(c), next(c)), (next(c), prev(c))] {
                if !self.alpha && topology.opposite[edge as usize] == NONE {
                    sum.add_line(sub(self.points[topology.at(end) as usize], here));
                }
            }
            c = topology.turn(c);
            if c == first {
                break;
            }
        }
        sum
    }

    /// When the edge between two vertices is tried, and its ends, that first which had better move onto the other: by its length, as in the paper,
    /// times what it costs to move one onto the other.
    pub fn rank(&self, [a, b]: [u32; 2], [of_a, of_b]: [&Quadric; 2]) -> (Rank, [u32; 2]) {
        let along = sub(self.points[b as usize], self.points[a as usize]);
        let (onto_b, onto_a) = (of_a.at(along), of_b.at(along));
        let rank = Rank::of((onto_b.min(onto_a) + 1.0) * dot(along, along).sqrt());
        (rank, if onto_b <= onto_a + EQUAL { [a, b] } else { [b, a] })
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
            if let Link::Closes(x) = s.link {
                self.topology.close(b, x);
                self.note(x);
            }
            self.note(b);
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
        // On a seam no edge appears that the other frustum does not have.
        if other_end.is_some_and(|end| self.locked[end as usize] && self.locked[b as usize]) {
            return false;
        }
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
        s.link = self.links(a, b, vanish, s);
        if s.link == Link::Forbidden {
            return false;
        }
        self.cover.collect(s.star.iter().map(|c| c / 3));
        if !self.cover.keeps(&s.new) {
            return false;
        }
        let to = self.points[b as usize];
        let fresh = s.ring_a.iter().filter(|x| **x != b && !s.ring_b.contains(x));
        let edges_hold = fresh.copied().all(|x| {
            let outer = self.topology.is_boundary(x) || self.topology.is_boundary(b);
            self.cover.holds(self.points[x as usize], to, outer)
        });
        let Link::Closes(x) = s.link else { return edges_hold };
        edges_hold && self.cover.holds_face([a, b, x].map(|v| self.points[v as usize]), false)
    }

    /// Whether `a` can move onto `b` so that what is left is a manifold.
    ///
    /// Plainly it can where the ends of the edge share no neighbours but those in the faces that vanish (the link condition).
    /// With one more shared neighbour x the contraction closes a triangular hole, which [`Topology::close`] completes, or would
    /// pinch a handle. Handles stay: where they came apart, their two sides moved away from each other, and cracks opened.
    pub fn links(&self, a: u32, b: u32, vanish: usize, s: &mut Scratch) -> Link {
        let topology = &self.topology;
        topology.star(b, &mut s.other);
        if s.star.len() == 1 && s.other.len() == 1 {
            return Link::Forbidden;
        }
        s.marks.resize(self.points.len(), 0);
        s.attempt += 1;
        topology.ring(a, &s.star, &mut s.ring_a);
        topology.ring(b, &s.other, &mut s.ring_b);
        for &v in &s.ring_a {
            s.marks[v as usize] = s.attempt;
        }
        // Of a tetrahedron two faces would be left, back to back.
        if !topology.is_boundary(a) && !topology.is_boundary(b) && s.ring_a.len() <= 3 && s.ring_b.len() <= 3 {
            return Link::Forbidden;
        }
        let shared = s.ring_b.iter().filter(|v| s.marks[**v as usize] == s.attempt).count();
        if shared == vanish {
            return Link::Plain;
        }
        if shared != vanish + 1 {
            return Link::Forbidden;
        }
        let opposite = |v: u32| {
            s.star.iter().any(|c| {
                let (n, p) = (topology.at(next(*c)), topology.at(prev(*c)));
                (n == b && p == v) || (p == b && n == v)
            })
        };
        let extra = s.ring_b.iter().find(|v| s.marks[**v as usize] == s.attempt && !opposite(**v));
        let Some(&x) = extra else { return Link::Forbidden };
        // The ring of `b` afterwards: in place of `a` stand the neighbours of `a` between those in the vanishing faces.
        let m = s.ring_a.len();
        let Some(at) = s.ring_a.iter().position(|v| *v == b) else { return Link::Forbidden };
        let Some(place) = s.ring_b.iter().position(|v| *v == a) else { return Link::Forbidden };
        let chain: Vec<u32> = (1..m).map(|k| s.ring_a[(at + k) % m]).collect();
        let inner = match (vanish, at) {
            (2, _) => &chain[1..m - 2],
            (_, 0) => &chain[1..],
            _ => &chain[..m - 2],
        };
        let merged: Vec<u32> = s.ring_b[..place].iter().chain(inner).chain(&s.ring_b[place + 1..]).copied().collect();
        let first = merged.iter().position(|v| *v == x);
        let last = merged.iter().rposition(|v| *v == x);
        let (Some(i), Some(j)) = (first, last) else { return Link::Forbidden };
        let closed = closes(i, j, merged.len(), topology.is_boundary(b));
        let mut star = Vec::new();
        let mut ring = Vec::new();
        topology.star(x, &mut star);
        topology.ring(x, &star, &mut ring);
        let first = ring.iter().position(|v| *v == a || *v == b);
        let last = ring.iter().rposition(|v| *v == a || *v == b);
        let (Some(i), Some(j)) = (first, last) else { return Link::Forbidden };
        // An edge on a seam between frusta must stay on the boundary.
        let on_seam = self.locked[b as usize] && self.locked[x as usize];
        if closed && closes(i, j, ring.len(), topology.is_boundary(x)) && !on_seam {
            Link::Closes(x)
        } else {
            Link::Forbidden
        }
    }
}

/// Costs that differ by less do so by rounding.
const EQUAL: f64 = 1e-6;

/// A quadratic form of the way that a vertex goes: xx, yy, zz, xy, yz, zx.
#[derive(Clone, Copy, Debug, Default)]
pub struct Quadric([f64; 6]);

impl Quadric {
    /// The squared distance from a plane through the vertex, times the area of a face in it with this normal (of twice its area's length).
    fn add_plane(&mut self, n: Point) {
        let weight = 0.5 / dot(n, n).sqrt();
        self.add(weight, n);
    }

    /// The squared distance from a line through the vertex, times the length of `along`.
    fn add_line(&mut self, along: Point) {
        let length = dot(along, along).sqrt();
        (0..3).for_each(|i| self.0[i] += length);
        self.add(-1.0 / length, along);
    }

    /// weight · (v · d)²
    fn add(&mut self, weight: f64, v: Point) {
        for i in 0..3 {
            self.0[i] += weight * v[i] * v[i];
            self.0[3 + i] += weight * v[i] * v[(i + 1) % 3];
        }
    }

    /// The cost of going by `d`, or by −d.
    fn at(&self, d: Point) -> f64 {
        let q = &self.0;
        let sum = (0..3).map(|i| q[i] * d[i] * d[i] + 2.0 * q[3 + i] * d[i] * d[(i + 1) % 3]).sum::<f64>();
        sum.max(0.0)
    }
}

/// What a contraction does to the manifold.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub enum Link {
    #[default]
    Forbidden,
    Plain,
    /// Closes the triangular hole between the edge and this vertex.
    Closes(u32),
}

/// Whether a fan becomes a ring of at least three faces where the same neighbour stands at places i < j of its ring.
fn closes(i: usize, j: usize, ring: usize, open: bool) -> bool {
    open && i == 0 && j == ring - 1 && ring > 3
}

/// How a face with this normal looks from the cell. Layers move by at most a pixel each against one another while the
/// viewer crosses the cell, so over all of it the third component of the normal changes by at most |x| + |y|.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facing {
    /// From everywhere its front is seen.
    Front,
    /// Seen edge-on from somewhere in the cell: walls and other steep faces.
    Steep,
    /// From everywhere its back is seen: the surface has folded over.
    Back,
}

pub fn look(n: Point) -> Facing {
    let turn = n[0].abs() + n[1].abs();
    if n[2] < -turn {
        Facing::Front
    } else if n[2] > turn {
        Facing::Back
    } else {
        Facing::Steep
    }
}

/// Whether a face stays on its side: nothing folds over. A steep face has no side that counts for the whole cell; its
/// normal turns by at most 80° at once.
pub fn keeps_side(old: [Point; 3], new: [Point; 3]) -> bool {
    let [m, n] = [old, new].map(|[a, b, c]| normal(a, b, c));
    match (look(m), look(n)) {
        (_, Facing::Back) => false,
        (Facing::Front, Facing::Front) => true,
        _ => within_80_degrees(m, n),
    }
}

/// Whether two vectors, neither zero, enclose at most 80°.
pub fn within_80_degrees(m: Point, n: Point) -> bool {
    /// cos² 80°
    const LEAST: f64 = 0.030_153_689_607_045_8;
    let along = dot(m, n);
    along > 0.0 && along * along >= LEAST * dot(m, m) * dot(n, n)
}
