//! One vertex for every distinct corner: a vertex of the file with what else a corner names.

use std::collections::BTreeMap;

const NONE: u32 = u32::MAX;
/// Corners of one vertex that are searched one by one; there are mostly few of them.
const SHORT: u32 = 32;

/// Numbers distinct corners in the order of first use.
pub(super) struct Weld<K> {
    /// For every vertex of the file the last corner made of it.
    last: Vec<u32>,
    corners: Vec<(u32, K)>,
    /// For every corner the one made of the same vertex before, and how many there are with it.
    before: Vec<(u32, u32)>,
    /// The corners of vertices that have more than [`SHORT`].
    long: BTreeMap<(u32, K), u32>,
}

impl<K: Copy + Ord> Weld<K> {
    pub fn new(vertices: usize) -> Self {
        Self { last: vec![NONE; vertices], corners: Vec::new(), before: Vec::new(), long: BTreeMap::new() }
    }

    /// The number of a corner of `vertex`.
    pub fn number(&mut self, vertex: u32, what: K) -> u32 {
        let corner = (vertex, what);
        let head = self.last[vertex as usize];
        let count = if head == NONE { 0 } else { self.before[head as usize].1 };
        if count > SHORT {
            if let Some(at) = self.long.get(&corner) {
                return *at;
            }
        } else if let Some(at) = self.chain(head).find(|at| self.corners[*at as usize] == corner) {
            return at;
        }
        let at = self.corners.len() as u32;
        self.corners.push(corner);
        self.before.push((head, count + 1));
        self.last[vertex as usize] = at;
        if count >= SHORT {
            let new: Vec<u32> = if count == SHORT { self.chain(at).collect() } else { vec![at] };
            self.long.extend(new.into_iter().map(|at| (self.corners[at as usize], at)));
        }
        at
    }

    fn chain(&self, head: u32) -> impl Iterator<Item = u32> {
        let some = |at: u32| (at != NONE).then_some(at);
        std::iter::successors(some(head), move |at| some(self.before[*at as usize].0))
    }

    /// The corners numbered so far; the next one is number 0 again.
    pub fn take(&mut self) -> Vec<(u32, K)> {
        let corners = std::mem::take(&mut self.corners);
        corners.iter().for_each(|(vertex, _)| self.last[*vertex as usize] = NONE);
        self.before.clear();
        self.long.clear();
        corners
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn equal_corners_have_one_number(corners in prop::collection::vec((0u32..3, 0u32..100), 0..600)) {
            let mut weld = Weld::new(3);
            for _ in 0..2 {
                let mut known = BTreeMap::new();
                for (v, what) in &corners {
                    let next = known.len() as u32;
                    let expect = *known.entry((*v, *what)).or_insert(next);
                    prop_assert_eq!(weld.number(*v, *what), expect);
                }
                let made = weld.take();
                prop_assert_eq!(made.len(), known.len());
                prop_assert!(made.iter().zip(0..).all(|(c, i)| known[c] == i));
            }
        }
    }
}
