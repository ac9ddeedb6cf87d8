//! Cracks: thin groups of missing or wrong-surface pixels on one continuous surface of the original.
//!
//! A *group* is 8-connected; it is thin where it is at most 2 pixels wide, that is where it holds no full square of
//! 3×3 pixels. A thin group is a crack if no discontinuity of the original lies between pixels of its 1-pixel
//! neighbourhood: a displaced silhouette is none. A crack that runs into a silhouette would escape that, so thin parts
//! of any group that lie outside the band and are at least 3 pixels long are cracks too. Nobody knows whether a silhouette lies just beyond the
//! picture's border, so what lies within [`BORDER`] pixels of it is none.

use super::edges::{BELOW, RIGHT, dilate_square};

/// How far from the picture's border cracks are looked for, pixels.
const BORDER: usize = 2;

/// The pixels of cracks. `holes`: missing or wrong-surface pixels; `edges`, `band`: the original's.
pub fn cracks(holes: &[bool], edges: &[u8], band: &[bool], width: usize) -> Vec<bool> {
    let mut out = vec![false; holes.len()];
    if !holes.contains(&true) {
        return out;
    }
    let wide = opened(holes, width);
    let inner = |i: usize| {
        let [x, y] = [i % width, i / width];
        let inside = |at: usize, size: usize| (BORDER..size.saturating_sub(BORDER)).contains(&at);
        inside(x, width) && inside(y, holes.len() / width)
    };
    for group in groups(holes, width) {
        if group.iter().all(|i| !wide[*i] && inner(*i) && continuous(edges, width, *i)) {
            group.iter().for_each(|i| out[*i] = true);
        }
    }
    let thin: Vec<bool> = (0..holes.len()).map(|i| holes[i] && !wide[i] && !band[i] && inner(i)).collect();
    for group in groups(&thin, width) {
        let span = |f: fn(usize, usize) -> usize| {
            let (lo, hi) =
                group.iter().fold((usize::MAX, 0), |(lo, hi), i| (lo.min(f(*i, width)), hi.max(f(*i, width))));
            hi - lo + 1
        };
        if span(|i, w| i % w) >= 3 || span(|i, w| i / w) >= 3 {
            group.iter().for_each(|i| out[*i] = true);
        }
    }
    out
}

/// The pixels of full 3×3 squares.
fn opened(mask: &[bool], width: usize) -> Vec<bool> {
    let height = mask.len() / width;
    let mut centres = vec![false; mask.len()];
    for y in 1..height.saturating_sub(1) {
        for x in 1..width.saturating_sub(1) {
            let i = y * width + x;
            centres[i] = [i - width, i, i + width].iter().all(|c| mask[c - 1] && mask[*c] && mask[c + 1]);
        }
    }
    dilate_square(&centres, width, 1)
}

/// The 8-connected groups of set pixels, each in the order in which it was reached from its first pixel.
fn groups(mask: &[bool], width: usize) -> Vec<Vec<usize>> {
    let mut left = mask.to_vec();
    let mut all = Vec::new();
    for first in 0..mask.len() {
        if !std::mem::take(&mut left[first]) {
            continue;
        }
        let mut group = vec![first];
        let mut next = 0;
        while let Some(&i) = group.get(next) {
            next += 1;
            for j in around(i, width, mask.len()) {
                if std::mem::take(&mut left[j]) {
                    group.push(j);
                }
            }
        }
        all.push(group);
    }
    all
}

/// The pixel and its neighbours inside the picture, row by row.
fn around(i: usize, width: usize, len: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (i % width, i / width);
    (y.saturating_sub(1)..=(y + 1).min(len / width - 1))
        .flat_map(move |v| (x.saturating_sub(1)..=(x + 1).min(width - 1)).map(move |u| v * width + u))
}

/// No discontinuity lies between two pixels of the 3×3 square around pixel `i`.
fn continuous(edges: &[u8], width: usize, i: usize) -> bool {
    let (x, y) = (i % width, i / width);
    around(i, width, edges.len()).all(|j| {
        let (u, v) = (j % width, j / width);
        (edges[j] & RIGHT == 0 || u == x + 1) && (edges[j] & BELOW == 0 || v == y + 1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const W: usize = 24;

    fn mask(f: impl Fn(usize, usize) -> bool) -> Vec<bool> {
        (0..W * W).map(|i| f(i % W, i / W)).collect()
    }

    fn count(holes: &[bool], edges: &[u8], band: &[bool]) -> usize {
        cracks(holes, edges, band, W).iter().filter(|c| **c).count()
    }

    /// A discontinuity between columns 3 and 4, with a band of 4 pixels to each side.
    fn silhouette() -> (Vec<u8>, Vec<bool>) {
        ((0..W * W).map(|i| if i % W == 3 { RIGHT } else { 0 }).collect(), mask(|x, _| x < 8))
    }

    #[test]
    fn thin_lines_are_cracks_and_wide_holes_are_none() {
        let (edges, band) = (vec![0; W * W], vec![false; W * W]);
        assert_eq!(count(&mask(|x, y| x == y && (4..20).contains(&x)), &edges, &band), 16);
        assert_eq!(count(&mask(|x, y| (x == 5 || x == 6) && (2..12).contains(&y)), &edges, &band), 20);
        assert_eq!(count(&mask(|x, y| (5..9).contains(&x) && (5..9).contains(&y)), &edges, &band), 0);
        assert_eq!(count(&mask(|x, y| x == 7 && y == 7), &edges, &band), 1);
    }

    #[test]
    fn a_displaced_silhouette_is_no_crack() {
        let (edges, band) = silhouette();
        assert_eq!(count(&mask(|x, _| x == 4 || x == 5), &edges, &band), 0);
        assert_eq!(count(&mask(|x, y| (4..9).contains(&x) && y < 20), &edges, &band), 0);
    }

    #[test]
    fn a_line_beside_a_silhouette_is_a_crack_once_it_is_detached() {
        let (edges, band) = silhouette();
        assert_eq!(count(&mask(|x, y| x == 5 && (2..20).contains(&y)), &edges, &band), 18);
    }

    #[test]
    fn a_silhouette_may_lie_beyond_the_border() {
        let (edges, band) = (vec![0; W * W], vec![false; W * W]);
        assert_eq!(count(&mask(|x, _| x < 2), &edges, &band), 0);
        assert_eq!(count(&mask(|_, y| y == W - 1), &edges, &band), 0);
        // A crack that runs to the border counts up to there.
        assert_eq!(count(&mask(|_, y| y == 9), &edges, &band), W - 2 * BORDER);
    }

    #[test]
    fn a_crack_that_runs_into_a_silhouette_counts_outside_the_band() {
        let (edges, band) = silhouette();
        assert_eq!(count(&mask(|x, y| x >= 4 && y == 9), &edges, &band), W - 8 - BORDER);
    }
}
