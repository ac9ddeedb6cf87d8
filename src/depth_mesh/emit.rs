//! From a closed selection to triangles and strips, by one top-down traversal (section 4.3; figure 13).
//!
//! The traversal follows a Sierpinski curve: it runs through every triangle from one end of its hypotenuse to the other, so that
//! consecutive triangles share an edge.

use super::{frustum::Frustum, hierarchy::Hierarchy, selection::Selection, strips::Strips};

/// A conforming triangulation of part of a depth map. Triangles are counter-clockwise as the reference camera sees them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Triangulation {
    /// Grid points (y · side + x) in ascending order, each a corner of a triangle.
    pub vertices: Vec<u32>,
    /// Indices into `vertices`, in the order of the strips.
    pub triangles: Vec<[u32; 3]>,
    /// The same triangles; indices into `vertices`.
    pub strips: Strips,
    /// Triangles that were left out because they are cut; those on nothing but background are not counted.
    pub cut: usize,
}

impl Triangulation {
    /// Triangles per strip; 0 without strips.
    pub fn mean_strip_length(&self) -> f64 {
        if self.strips.is_empty() { 0.0 } else { self.triangles.len() as f64 / self.strips.len() as f64 }
    }

    fn clear(&mut self) {
        self.vertices.clear();
        self.triangles.clear();
        self.strips.clear();
        self.cut = 0;
    }
}

/// Which nodes a view misses, as far as they were asked for.
pub(super) struct Culling<'a> {
    pub frustum: &'a Frustum,
    /// Per node with a sphere.
    pub verdicts: &'a mut Vec<u8>,
}

const UNKNOWN: u8 = 0;
const SEEN: u8 = 1;
const MISSED: u8 = 2;

impl<'a> Culling<'a> {
    pub fn new(frustum: &'a Frustum, hierarchy: &Hierarchy, verdicts: &'a mut Vec<u8>) -> Self {
        verdicts.clear();
        verdicts.resize(hierarchy.spheres.len(), UNKNOWN);
        Self { frustum, verdicts }
    }

    /// Whether the view sees nothing of a node. Those of the finest level are judged with the one above.
    pub fn misses(&mut self, hierarchy: &Hierarchy, node: usize) -> bool {
        let Some(verdict) = self.verdicts.get_mut(node) else { return false };
        if *verdict == UNKNOWN {
            *verdict = if self.frustum.misses(&hierarchy.spheres[node]) { MISSED } else { SEEN };
        }
        *verdict == MISSED
    }
}

/// Buffers that emission needs besides its result.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    used: Option<Selection>,
    /// Per grid point, valid where `used`.
    number: Vec<u32>,
}

/// A point as y · 65536 + x: the mean of two is the point between them.
type Packed = u32;

fn pack(x: usize, y: usize) -> Packed {
    (y << 16 | x) as u32
}

fn unpack(p: Packed) -> (usize, usize) {
    ((p & 0xffff) as usize, (p >> 16) as usize)
}

struct Emitter<'a, 'c> {
    hierarchy: &'a Hierarchy,
    selection: &'a Selection,
    culling: Option<&'a mut Culling<'c>>,
    used: &'a mut Selection,
    out: &'a mut Triangulation,
}

/// Triangulates a closed selection.
pub(super) fn emit(
    hierarchy: &Hierarchy,
    selection: &Selection,
    culling: Option<&mut Culling>,
    scratch: &mut Scratch,
    out: &mut Triangulation,
) {
    let side = hierarchy.map().side();
    if scratch.used.as_ref().is_none_or(|used| used.side() != side) {
        *scratch = Scratch { used: Some(Selection::new(side)), number: vec![0; side * side] };
    }
    out.clear();
    let Some(used) = scratch.used.as_mut() else { return };
    used.clear();
    Emitter { hierarchy, selection, culling, used, out }.grid();
    for (x, y) in used.points() {
        let at = y * side + x;
        scratch.number[at] = out.vertices.len() as u32;
        out.vertices.push(at as u32);
    }
    let numbers = out.triangles.as_flattened_mut().iter_mut().chain(&mut out.strips.indices);
    for v in numbers {
        *v = scratch.number[*v as usize];
    }
}

impl Emitter<'_, '_> {
    fn grid(&mut self) {
        let n = self.hierarchy.grid.cells();
        let [nw, ne, se, sw] = [pack(0, 0), pack(n, 0), pack(n, n), pack(0, n)];
        let centre = pack(n / 2, n / 2);
        if self.misses(0, centre) {
            return;
        }
        if self.selected(centre) {
            for (l, r, quarter) in [(nw, sw, 3), (sw, se, 2), (se, ne, 1), (ne, nw, 0)] {
                self.quarter(centre, l, r, quarter, 0);
            }
        } else {
            let flags = self.hierarchy.flags()[0];
            self.triangle([nw, sw, se], flags & 0b1111_0000 != 0);
            self.triangle([se, ne, nw], flags & 0b0000_1111 != 0);
        }
    }

    /// The quarter (0 to 3: N, E, S, W) of the node of `level` around `centre` with hypotenuse from l to r, counter-clockwise.
    fn quarter(&mut self, centre: Packed, l: Packed, r: Packed, quarter: usize, level: u32) {
        let middle = (l + r) / 2;
        let (x, y) = unpack(centre);
        let flags = self.hierarchy.flags()[self.hierarchy.grid.node_around(level, x, y)] >> (2 * quarter);
        if !self.selected(middle) {
            return self.triangle([l, r, centre], flags & 0b11 != 0);
        }
        // Halves are numbered clockwise and visited counter-clockwise.
        self.half(centre, [l, middle, centre], [quarter, (quarter + 3) % 4], flags & 0b10 != 0, level);
        self.half(centre, [centre, middle, r], [(quarter + 1) % 4, quarter], flags & 0b01 != 0, level);
    }

    /// Half a quarter of a node: two quarters of a node of the next level, of which `quarters` names the sides in the order of the
    /// corners.
    fn half(&mut self, centre: Packed, corners: [Packed; 3], quarters: [usize; 2], cut: bool, level: u32) {
        let [l, apex, r] = corners;
        let child = (l + r) / 2;
        if level + 1 < self.hierarchy.grid.k {
            if self.misses(level + 1, child) {
                return;
            }
            if self.selected(child) {
                self.quarter(child, l, apex, quarters[0], level + 1);
                return self.quarter(child, apex, r, quarters[1], level + 1);
            }
        }
        debug_assert!(l == centre || r == centre);
        self.triangle(corners, cut);
    }

    fn triangle(&mut self, corners: [Packed; 3], cut: bool) {
        let side = self.hierarchy.map().side();
        let at = corners.map(|c| {
            let (x, y) = unpack(c);
            (y * side + x) as u32
        });
        if cut {
            let depth = self.hierarchy.map().depth();
            self.out.cut += usize::from(at.iter().any(|&i| depth[i as usize] < f32::INFINITY));
            return;
        }
        for (x, y) in corners.map(unpack) {
            self.used.insert(x, y);
        }
        self.out.triangles.push(at);
        self.out.strips.push(at);
    }

    fn selected(&self, p: Packed) -> bool {
        let (x, y) = unpack(p);
        self.selection.contains(x, y)
    }

    fn misses(&mut self, level: u32, centre: Packed) -> bool {
        let Some(culling) = self.culling.as_mut() else { return false };
        let (x, y) = unpack(centre);
        culling.misses(self.hierarchy, self.hierarchy.grid.node_around(level, x, y))
    }
}
