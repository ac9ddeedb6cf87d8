//! A triangle mesh as a corner table: who lies across every edge, and one corner of every vertex.
//!
//! Corner 3f + i is the i-th vertex of face f. What always holds: an edge has at most two faces, of opposite direction; the
//! faces around a vertex form one fan or one ring; a boundary vertex's corner is the first of its fan, so that turning
//! from it with [`Topology::turn`] visits the whole fan.

/// No corner, no vertex.
pub const NONE: u32 = u32::MAX;

pub fn next(c: u32) -> u32 {
    if c % 3 == 2 { c - 2 } else { c + 1 }
}

pub fn prev(c: u32) -> u32 {
    if c.is_multiple_of(3) { c + 2 } else { c - 1 }
}

pub struct Topology {
    /// Vertex of every corner; `NONE` for the corners of a removed face.
    pub vertex: Vec<u32>,
    /// The corner beyond the edge that lies opposite, `NONE` on the boundary.
    pub opposite: Vec<u32>,
    /// One corner of every vertex, `NONE` where the vertex has no face.
    pub corner: Vec<u32>,
}

impl Topology {
    /// `faces` must be a manifold: see the module's invariants.
    pub fn new(vertex_count: usize, faces: &[[u32; 3]]) -> Self {
        let vertex: Vec<u32> = faces.iter().flatten().copied().collect();
        // Corners by vertex; an edge is found among the corners of its lower end.
        let mut start = vec![0u32; vertex_count + 1];
        for v in &vertex {
            start[*v as usize] += 1;
        }
        let mut sum = 0;
        for s in &mut start {
            sum += *s;
            *s = sum;
        }
        let mut by_vertex = vec![0; vertex.len()];
        for c in (0..vertex.len() as u32).rev() {
            let at = &mut start[vertex[c as usize] as usize];
            *at -= 1;
            by_vertex[*at as usize] = c;
        }
        let mut opposite = vec![NONE; vertex.len()];
        let mut corner = vec![NONE; vertex_count];
        for v in 0..vertex_count {
            let around = &by_vertex[start[v] as usize..start[v + 1] as usize];
            if let Some(first) = around.first() {
                corner[v] = *first;
            }
            // Edge v → n of one face is edge n → v of the other: there, n's successor is v.
            for &c in around {
                let n = vertex[next(c) as usize];
                if let Some(&d) = around.iter().find(|d| vertex[prev(**d) as usize] == n) {
                    opposite[prev(c) as usize] = next(d);
                    opposite[next(d) as usize] = prev(c);
                }
            }
        }
        let mut topology = Self { vertex, opposite, corner };
        for v in 0..vertex_count as u32 {
            topology.rewind(v);
        }
        topology
    }

    pub fn at(&self, c: u32) -> u32 {
        self.vertex[c as usize]
    }

    pub fn is_live(&self, face: u32) -> bool {
        self.vertex[3 * face as usize] != NONE
    }

    pub fn corners(&self, face: u32) -> [u32; 3] {
        [self.vertex[3 * face as usize], self.vertex[3 * face as usize + 1], self.vertex[3 * face as usize + 2]]
    }

    /// The same vertex's corner in the next face of its fan, across the edge to its predecessor.
    pub fn turn(&self, c: u32) -> u32 {
        match self.opposite[next(c) as usize] {
            NONE => NONE,
            o => next(o),
        }
    }

    fn turn_back(&self, c: u32) -> u32 {
        match self.opposite[prev(c) as usize] {
            NONE => NONE,
            o => prev(o),
        }
    }

    pub fn is_boundary(&self, v: u32) -> bool {
        self.opposite[prev(self.corner[v as usize]) as usize] == NONE
    }

    /// The vertex's corners in order of its fan.
    pub fn star(&self, v: u32, into: &mut Vec<u32>) {
        into.clear();
        let first = self.corner[v as usize];
        let mut c = first;
        while c != NONE {
            into.push(c);
            c = self.turn(c);
            if c == first {
                break;
            }
        }
    }

    /// The vertex's neighbours in order of its fan; on the boundary one more than it has faces.
    pub fn ring(&self, v: u32, star: &[u32], into: &mut Vec<u32>) {
        into.clear();
        into.extend(star.iter().map(|c| self.at(next(*c))));
        if let Some(last) = star.last().filter(|_| self.is_boundary(v)) {
            into.push(self.at(prev(*last)));
        }
    }

    /// The boundary's next and previous vertex at `v`, as its faces run; `None` inside the surface. `star`: that of `v`.
    pub fn rim(&self, v: u32, star: &[u32]) -> Option<[u32; 2]> {
        let (first, last) = star.first().zip(star.last()).filter(|_| self.is_boundary(v))?;
        Some([self.at(next(*first)), self.at(prev(*last))])
    }

    /// Makes one of the two boundary edges between `b` and `x` that a contraction leaves where it closes a triangular hole.
    pub fn close(&mut self, b: u32, x: u32) {
        let mut star = Vec::new();
        self.star(b, &mut star);
        let open = |c: &u32| self.opposite[*c as usize] == NONE;
        let leaving = star.iter().filter(|c| self.at(next(**c)) == x).map(|c| prev(*c)).find(open);
        let coming = star.iter().filter(|c| self.at(prev(**c)) == x).map(|c| next(*c)).find(open);
        if let (Some(l), Some(c)) = (leaving, coming) {
            self.opposite[l as usize] = c;
            self.opposite[c as usize] = l;
        }
    }

    /// Moves the vertex's corner to the first of its fan.
    fn rewind(&mut self, v: u32) {
        let first = self.corner[v as usize];
        if first == NONE {
            return;
        }
        let mut c = first;
        loop {
            match self.turn_back(c) {
                NONE => break,
                back if back == first => break,
                back => c = back,
            }
        }
        self.corner[v as usize] = c;
    }

    /// Removes vertex `a`, whose corners are `star`, by moving it onto its neighbour `b`. Returns the faces that vanish.
    pub fn contract(&mut self, star: &[u32], b: u32) -> [u32; 2] {
        let a = self.at(star[0]);
        let mut gone = [NONE; 2];
        let mut keep = NONE;
        let mut sides = [NONE; 2];
        for &c in star {
            let (n, p) = (next(c), prev(c));
            let (at_b, at_x) = if self.at(n) == b {
                (n, p)
            } else if self.at(p) == b {
                (p, n)
            } else {
                self.vertex[c as usize] = b;
                keep = c;
                continue;
            };
            let (beyond_a, beyond_b) = (self.opposite[c as usize], self.opposite[at_b as usize]);
            let x = self.at(at_x);
            let slot = usize::from(gone[0] != NONE);
            gone[slot] = c / 3;
            sides[slot] = x;
            for (here, there) in [(beyond_a, beyond_b), (beyond_b, beyond_a)] {
                if here != NONE {
                    self.opposite[here as usize] = there;
                }
            }
            // The edge b–x is seen from `beyond_a`, a–x (now b–x) from `beyond_b`: both know a living corner of b and x.
            for (beyond, order) in [(beyond_a, at_b == n), (beyond_b, at_b == p)] {
                if beyond == NONE {
                    continue;
                }
                // Beyond a face that runs b → x, the edge runs x → b: x follows the opposite corner.
                let (cx, cb) = if order { (next(beyond), prev(beyond)) } else { (prev(beyond), next(beyond)) };
                self.corner[x as usize] = cx;
                keep = cb;
            }
            if beyond_a == NONE && beyond_b == NONE && self.corner[x as usize] / 3 == c / 3 {
                self.corner[x as usize] = NONE;
            }
        }
        for f in gone {
            if f != NONE {
                for c in 3 * f..3 * f + 3 {
                    self.vertex[c as usize] = NONE;
                    self.opposite[c as usize] = NONE;
                }
            }
        }
        self.corner[a as usize] = NONE;
        self.corner[b as usize] = keep;
        self.rewind(b);
        for x in sides {
            if x != NONE {
                self.rewind(x);
            }
        }
        gone
    }

    /// The boundary loop through boundary vertex `v` (v first), if it has at most `most` edges; runs as its faces see it.
    pub fn boundary_loop(&self, v: u32, most: usize, into: &mut Vec<u32>) -> bool {
        into.clear();
        let mut at = v;
        while into.len() < most {
            into.push(at);
            at = self.at(next(self.corner[at as usize]));
            if at == v {
                return true;
            }
        }
        false
    }

    /// A dead slot for one more face.
    pub fn push_face(&mut self) -> u32 {
        self.vertex.extend([NONE; 3]);
        self.opposite.extend([NONE; 3]);
        self.vertex.len() as u32 / 3 - 1
    }

    /// Fills (part of) a hole: `faces` go into dead slots; each edge of theirs lies on the boundary or between two of them.
    pub fn fill(&mut self, slots: &[u32], faces: &[[u32; 3]]) {
        for (face, slot) in faces.iter().zip(slots) {
            self.vertex[3 * *slot as usize..][..3].copy_from_slice(face);
        }
        let rim: Vec<([u32; 2], u32)> = faces
            .iter()
            .flatten()
            .map(|v| {
                let c = self.corner[*v as usize];
                // The first corner of a fan has no face across its edge to the next vertex.
                ([self.at(next(c)), *v], prev(c))
            })
            .collect();
        self.link(faces, slots.iter().copied(), &rim);
    }

    /// Removes one face of a part that goes as a whole.
    pub fn remove_face(&mut self, face: u32) {
        for c in 3 * face..3 * face + 3 {
            let v = self.vertex[c as usize];
            self.corner[v as usize] = NONE;
            self.vertex[c as usize] = NONE;
            self.opposite[c as usize] = NONE;
        }
    }

    /// Replaces the faces of a whole star by `faces` (fewer, over the same ring), in the slots of the first of them.
    pub fn refill(&mut self, star: &[u32], faces: &[[u32; 3]]) {
        let a = self.at(star[0]);
        // Directed edges of the hole's rim as its faces will see them, with the corners beyond.
        let rim: Vec<([u32; 2], u32)> =
            star.iter().map(|c| ([self.at(next(*c)), self.at(prev(*c))], self.opposite[*c as usize])).collect();
        for c in star.iter().flat_map(|c| 3 * (c / 3)..3 * (c / 3) + 3) {
            self.vertex[c as usize] = NONE;
            self.opposite[c as usize] = NONE;
        }
        self.corner[a as usize] = NONE;
        for (face, c) in faces.iter().zip(star) {
            self.vertex[3 * (c / 3) as usize..][..3].copy_from_slice(face);
        }
        self.link(faces, star.iter().map(|c| c / 3), &rim);
    }

    /// Joins new faces to each other and, along `rim` (directed as the new faces see it), to the corners beyond.
    fn link(&mut self, faces: &[[u32; 3]], slots: impl Iterator<Item = u32>, rim: &[([u32; 2], u32)]) {
        let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(faces.len() * 3);
        for (face, slot) in faces.iter().zip(slots) {
            edges.extend((0..3).map(|i| ([face[(i + 1) % 3], face[(i + 2) % 3]], 3 * slot + i as u32)));
        }
        for (edge, c) in &edges {
            let inside = edges.iter().find(|(e, _)| *e == [edge[1], edge[0]]).map(|(_, d)| *d);
            let beyond = inside.or_else(|| rim.iter().find(|(e, _)| e == edge).map(|(_, d)| *d)).unwrap_or(NONE);
            self.opposite[*c as usize] = beyond;
            if beyond != NONE {
                self.opposite[beyond as usize] = *c;
            }
        }
        for (edge, c) in &edges {
            self.corner[edge[0] as usize] = next(*c);
        }
        for v in faces.iter().flatten() {
            self.rewind(*v);
        }
    }
}
