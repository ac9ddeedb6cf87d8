//! Segmentation flags of coarser nodes (section 5.3, figure 11), and what must be split so that only triangles of the full
//! resolution are cut.

use super::{
    grid::{Grid, RING, midpoint, step},
    selection::Selection,
};

/// For each of a node's triangles which child holds it (north-west, north-east, south-east, south-west) and as which two quarters.
const HALVES: [(usize, [usize; 2]); 8] =
    [(0, [0, 1]), (1, [0, 3]), (1, [1, 2]), (2, [0, 1]), (2, [2, 3]), (3, [1, 2]), (3, [0, 3]), (0, [2, 3])];

/// One flag per quarter of a node, at bits 0, 2, 4 and 6, from those of its halves.
fn quarters(node: u8, join: impl Fn(u8, u8) -> u8) -> u8 {
    join(node, node >> 1) & 0b0101_0101
}

/// Flags of a node from those of its children: S(t) = S(t1) | S(t2), with `join` in place of |.
pub(super) fn parent(children: [u8; 4], join: impl Fn(u8, u8) -> u8 + Copy) -> u8 {
    let children = children.map(|c| quarters(c, join));
    HALVES.iter().enumerate().fold(0, |flags, (t, &(child, [q, r]))| {
        flags | (join(children[child] >> (2 * q), children[child] >> (2 * r)) & 1) << t
    })
}

/// The points that must be selected so that every triangle holds either only cut triangles of the full resolution or none; closed.
/// `any` and `all`: flags of all nodes, joined by or and by and.
pub(super) fn splits(grid: Grid, any: &[u8], all: &[u8]) -> Selection {
    let mut selection = Selection::new(grid.side());
    let n = grid.cells();
    for level in 0..grid.k {
        let h = grid.half(level);
        for (j, i) in (0..1 << level).flat_map(|j| (0..1usize << level).map(move |i| (j, i))) {
            let node = grid.node(level, i, j);
            let mixed = any[node] & !all[node];
            // A quarter whose halves differ is mixed, though neither half is.
            let some = quarters(any[node], |a, b| a | b);
            let every = quarters(all[node], |a, b| a & b);
            let centre = ((2 * i + 1) * h, (2 * j + 1) * h);
            for q in (0..4).filter(|q| (some & !every) >> (2 * q) & 1 != 0) {
                let (x, y) = midpoint(centre, h, q);
                selection.insert(x, y);
            }
            for (t, &(child, _)) in HALVES.iter().enumerate() {
                if h > 1 && mixed >> t & 1 != 0 {
                    let (x, y) = step(centre, RING[2 * child], h / 2);
                    selection.insert(x, y);
                }
            }
        }
    }
    // The two halves of the grid: north with east, south with west.
    if [0b0000_1111, 0b1111_0000].into_iter().any(|half| any[0] & half != 0 && all[0] & half != half) {
        selection.insert(n / 2, n / 2);
    }
    selection.close();
    selection
}
