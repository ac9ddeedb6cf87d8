//! Generalised triangle strips (figure 13).

/// Triangle strips. Triangle i of a strip has the corners i, i+1, i+2 of its list, counter-clockwise for even i and clockwise for odd
/// i. A swap is a repeated corner: `x y x z` makes a triangle without area, after which `y x z` goes on from edge `x z`
/// instead of `y z`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Strips {
    /// Corners of all strips, one after the other.
    pub indices: Vec<u32>,
    /// Where each strip begins in `indices`.
    pub starts: Vec<u32>,
}

impl Strips {
    pub fn clear(&mut self) {
        self.indices.clear();
        self.starts.clear();
    }

    pub fn len(&self) -> usize {
        self.starts.len()
    }

    pub fn is_empty(&self) -> bool {
        self.starts.is_empty()
    }

    /// The corners of each strip.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let ends = self.starts.iter().skip(1).copied().chain([self.indices.len() as u32]);
        self.starts.iter().zip(ends).map(|(&from, to)| &self.indices[from as usize..to as usize])
    }

    /// The triangles with an area, counter-clockwise, in the order of the strips.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.iter().flat_map(|strip| {
            let turned = |(i, t): (usize, &[u32])| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
            strip.windows(3).enumerate().map(turned).filter(|[a, b, c]| a != b && b != c && c != a)
        })
    }

    /// Adds a counter-clockwise triangle, to the last strip where it shares the right edge with its last triangle.
    pub(super) fn push(&mut self, triangle: [u32; 3]) {
        if !self.extend(triangle) {
            self.starts.push(self.indices.len() as u32);
            self.indices.extend(triangle);
        }
    }

    fn extend(&mut self, triangle: [u32; 3]) -> bool {
        let Some(&start) = self.starts.last() else { return false };
        let end = self.indices.len();
        let Some(&[p, q, z]) = self.indices.last_chunk() else { return false };
        let shared = |v: u32| triangle.contains(&v);
        let Some(new) = triangle.into_iter().find(|v| ![p, q, z].contains(v)) else { return false };
        match (shared(p), shared(q), shared(z)) {
            (false, true, true) => {}
            (true, false, true) if end - start as usize > 3 => {
                self.indices.pop();
                self.indices.extend([p, z]);
            }
            // The first triangle of a strip may begin at any corner.
            (true, false, true) => self.indices[end - 3..].copy_from_slice(&[q, z, p]),
            (true, true, false) if end - start as usize == 3 => self.indices[end - 3..].copy_from_slice(&[z, p, q]),
            _ => return false,
        }
        self.indices.push(new);
        true
    }
}
