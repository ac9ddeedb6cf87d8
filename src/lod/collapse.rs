//! Edge collapse of what a cell sees of an object (Chen et al. 2003, sections 3.1.3.3 and 3.1.4).
//!
//! Collapses are half-edge collapses: a vertex moves onto its neighbour, so the vertices that are left are the original's. Two costs
//! can be chosen. The paper's is (1.5 − n_i·n_j)^e · l · (w_i + w_j). Ours measures how far the picture moves, see [`Cost::Parallax`].

use super::quadric::Quadric;
use crate::math::{Stop, Stopped};
use glam::DVec3;
use std::{cmp::Reverse, collections::BinaryHeap};

/// What is collapsed. All lists of vertices are of one length.
#[derive(Clone, Copy, Debug)]
pub struct Mesh<'a> {
    /// About the cell's centre, metres.
    pub positions: &'a [DVec3],
    /// In the space that the cost measures in, pixels; see [`super::parallax`].
    pub screen: &'a [DVec3],
    /// Unit.
    pub normals: &'a [DVec3],
    /// w of the paper.
    pub weight: &'a [f64],
    /// Views that see the vertex.
    pub views: &'a [u32],
    pub triangles: &'a [[u32; 3]],
}

/// What a collapse costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cost<'a> {
    /// (1.5 − n_i·n_j)^e · l · (w_i + w_j), the lighter vertex goes to the heavier.
    Paper {
        exponent: f64,
        /// Eyes that l, the edge's length in pixels, is the largest from.
        eyes: &'a [DVec3],
        /// Pixels per radian.
        focal: f64,
    },
    /// Squared distance from the planes of the faces in `screen`, weighted by their area there, and from the outlines that the centre sees. `hidden` is
    /// the share that faces count of which no view sees a vertex.
    Parallax { outline: f64, hidden: f64 },
}

/// When the collapse ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// The paper's T_l, or the distance in pixels that no collapse may exceed.
    pub tolerance: f64,
    /// Fewer triangles than these are not aimed at; 0 for no limit.
    pub triangles: usize,
    /// Only vertices that share a view, or that none sees, are joined; by the paper's cost, only into one of no less weight (section 3.1.4).
    pub shared_views: bool,
}

/// The triangles that are left, in the mesh's vertex numbers.
///
/// # Errors
/// Where it is stopped.
pub fn collapse(mesh: &Mesh, cost: Cost, goal: &Goal, stop: &Stop) -> Result<Vec<[u32; 3]>, Stopped> {
    let mut work = Work::new(mesh, cost, goal);
    work.fill();
    let mut steps = 0_u32;
    while let Some(Reverse((bits, u, v, stamp))) = work.heap.pop() {
        steps = steps.wrapping_add(1);
        if steps.is_multiple_of(4096) {
            stop.check()?;
        }
        if work.alive <= goal.triangles {
            break;
        }
        if work.stamp(u, v) != stamp || work.around[u as usize].is_empty() {
            continue;
        }
        if matches!(cost, Cost::Paper { .. }) && f64::from_bits(bits) > goal.tolerance {
            break;
        }
        if work.is_allowed(u, v) {
            work.join(u, v);
        }
    }
    Ok(work.left())
}

struct Work<'a> {
    mesh: &'a Mesh<'a>,
    cost: Cost<'a>,
    goal: &'a Goal,
    triangles: Vec<[u32; 3]>,
    /// Whether a triangle is gone.
    gone: Vec<bool>,
    alive: usize,
    /// Triangles around each vertex that are not gone.
    around: Vec<Vec<u32>>,
    /// Grows when what a vertex stands for changes.
    version: Vec<u32>,
    quadrics: Vec<Quadric>,
    /// Cost (as bits: costs are not negative), the vertex that goes, the one that stays, and their versions.
    heap: BinaryHeap<Reverse<(u64, u32, u32, u64)>>,
    /// Marks of vertices, for counting.
    mark: Vec<u32>,
    marks: u32,
}

impl<'a> Work<'a> {
    fn new(mesh: &'a Mesh<'a>, cost: Cost<'a>, goal: &'a Goal) -> Self {
        let n = mesh.positions.len();
        let mut around = vec![Vec::new(); n];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            corners.iter().for_each(|v| around[*v as usize].push(t as u32));
        }
        let quadrics = match cost {
            Cost::Paper { .. } => Vec::new(),
            Cost::Parallax { outline, hidden } => quadrics(mesh, &around, outline, hidden),
        };
        Self {
            mesh,
            cost,
            goal,
            triangles: mesh.triangles.to_vec(),
            gone: vec![false; mesh.triangles.len()],
            alive: mesh.triangles.len(),
            around,
            version: vec![0; n],
            quadrics,
            heap: BinaryHeap::new(),
            mark: vec![0; n],
            marks: 0,
        }
    }

    fn stamp(&self, u: u32, v: u32) -> u64 {
        u64::from(self.version[u as usize]) << 32 | u64::from(self.version[v as usize])
    }

    /// Puts every edge on the heap.
    fn fill(&mut self) {
        let mut edges: Vec<(u32, u32)> = self
            .mesh
            .triangles
            .iter()
            .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
            .map(|(a, b)| (a.min(b), a.max(b)))
            .collect();
        edges.sort_unstable();
        edges.dedup();
        for (a, b) in edges {
            self.push(a, b);
        }
    }

    /// Puts the cheaper direction of an edge on the heap, if one is allowed.
    fn push(&mut self, a: u32, b: u32) {
        let best = match (self.price(a, b), self.price(b, a)) {
            (Some(x), Some(y)) if x <= y => Some((x, a, b)),
            (Some(x), None) => Some((x, a, b)),
            (_, Some(y)) => Some((y, b, a)),
            (None, None) => None,
        };
        if let Some((cost, u, v)) = best {
            self.heap.push(Reverse((cost.to_bits(), u, v, self.stamp(u, v))));
        }
    }

    /// What it costs to move `u` onto `v`; `None` where the rules forbid it.
    fn price(&self, u: u32, v: u32) -> Option<f64> {
        let (i, j) = (u as usize, v as usize);
        let mesh = self.mesh;
        if self.goal.shared_views && mesh.views[i] & mesh.views[j] == 0 && mesh.views[i] | mesh.views[j] != 0 {
            return None;
        }
        match self.cost {
            Cost::Paper { exponent, eyes, focal } => {
                if mesh.weight[i] > mesh.weight[j] {
                    return None;
                }
                let bend = (1.5 - mesh.normals[i].dot(mesh.normals[j])).max(0.0);
                let (p, q) = (mesh.positions[i], mesh.positions[j]);
                let length = |e: &DVec3| angle(p - *e, q - *e) * focal;
                let l = eyes.iter().map(length).fold(0.0, f64::max);
                Some(libm::pow(bend, exponent) * l * (mesh.weight[i] + mesh.weight[j]))
            }
            Cost::Parallax { .. } => {
                let both = self.quadrics[i].add(&self.quadrics[j]);
                let cost = both.at(mesh.screen[j]);
                (cost <= self.goal.tolerance * self.goal.tolerance * both.weight()).then_some(cost)
            }
        }
    }

    /// Whether the surface stays a surface, and no face that stays turns over in the picture.
    fn is_allowed(&mut self, u: u32, v: u32) -> bool {
        let (around_u, around_v) = (&self.around[u as usize], &self.around[v as usize]);
        let shared = around_u.iter().filter(|t| self.triangles[**t as usize].contains(&v)).count();
        if shared == 0 || shared > 2 {
            return false;
        }
        // Every common neighbour is the third corner of a triangle that goes.
        self.marks += 1;
        for t in around_v {
            for w in self.triangles[*t as usize] {
                self.mark[w as usize] = self.marks;
            }
        }
        let mut common = 0;
        let seen = self.marks;
        self.marks += 1;
        for t in around_u {
            for w in self.triangles[*t as usize] {
                if w != u && w != v && self.mark[w as usize] == seen {
                    common += 1;
                    self.mark[w as usize] = self.marks;
                }
            }
        }
        if common != shared {
            return false;
        }
        let screen = self.mesh.screen;
        around_u.iter().all(|t| {
            let corners = self.triangles[*t as usize];
            if corners.contains(&v) {
                return true;
            }
            let normal = |of: [u32; 3]| {
                let [a, b, c] = of.map(|w| screen[w as usize]);
                (b - a).cross(c - a)
            };
            let (before, after) = (normal(corners), normal(corners.map(|w| if w == u { v } else { w })));
            // A face without area has no side to turn.
            before == DVec3::ZERO || before.dot(after) > TURN * before.length() * after.length()
        })
    }

    fn join(&mut self, u: u32, v: u32) {
        for t in std::mem::take(&mut self.around[u as usize]) {
            let corners = self.triangles[t as usize];
            if corners.contains(&v) {
                self.gone[t as usize] = true;
                self.alive -= 1;
                for w in corners.into_iter().filter(|w| *w != u) {
                    self.around[w as usize].retain(|x| *x != t);
                }
            } else {
                self.triangles[t as usize] = corners.map(|w| if w == u { v } else { w });
                self.around[v as usize].push(t);
            }
        }
        if !self.quadrics.is_empty() {
            self.quadrics[v as usize] = self.quadrics[u as usize].add(&self.quadrics[v as usize]);
        }
        self.version[u as usize] += 1;
        self.version[v as usize] += 1;
        // Prices of edges depend on their ends alone: only those of v are new.
        self.marks += 1;
        let mut fresh = Vec::new();
        for t in &self.around[v as usize] {
            for w in self.triangles[*t as usize] {
                if w != v && self.mark[w as usize] != self.marks {
                    self.mark[w as usize] = self.marks;
                    fresh.push(w);
                }
            }
        }
        for w in fresh {
            self.push(v, w);
        }
    }

    fn left(&self) -> Vec<[u32; 3]> {
        self.triangles.iter().zip(&self.gone).filter(|(_, gone)| !**gone).map(|(t, _)| *t).collect()
    }
}

/// Cosine of the largest angle by which a face may turn in one collapse.
const TURN: f64 = 0.1;

/// The angle between two directions, radians.
fn angle(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}

/// One quadric for each vertex: the planes of its faces by their area, and vertical planes along outlines, where the surface ends or turns away from the
/// centre.
fn quadrics(mesh: &Mesh, around: &[Vec<u32>], outline: f64, hidden: f64) -> Vec<Quadric> {
    let corners = |t: [u32; 3]| t.map(|v| mesh.screen[v as usize]);
    let normal = |t: [u32; 3]| {
        let [a, b, c] = corners(t);
        (b - a).cross(c - a)
    };
    let mut out = vec![Quadric::default(); mesh.screen.len()];
    for t in mesh.triangles {
        let n = normal(*t);
        let share = if t.iter().any(|v| mesh.views[*v as usize] != 0) { 1.0 } else { hidden };
        let quadric = Quadric::plane(mesh.screen[t[0] as usize], n.normalize_or_zero(), n.length() * 0.5 * share);
        for v in t {
            out[*v as usize] = out[*v as usize].add(&quadric);
        }
    }
    for (i, t) in mesh.triangles.iter().enumerate() {
        let here = normal(*t).z;
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let other =
                around[a as usize].iter().find(|o| **o as usize != i && mesh.triangles[**o as usize].contains(&b));
            let is_outline = other.is_none_or(|o| (normal(mesh.triangles[*o as usize]).z > 0.0) != (here > 0.0));
            if !is_outline {
                continue;
            }
            let (p, q) = (mesh.screen[a as usize], mesh.screen[b as usize]);
            let along = (q - p).truncate();
            let share = if mesh.views[a as usize] | mesh.views[b as usize] != 0 { outline } else { outline * hidden };
            let across = along.perp().normalize_or_zero().extend(0.0);
            let quadric = Quadric::plane(p, across, along.length() * share);
            for v in [a, b] {
                out[v as usize] = out[v as usize].add(&quadric);
            }
        }
    }
    out
}
