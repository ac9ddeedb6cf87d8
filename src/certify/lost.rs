//! Lost detail: what the original shows and the stand-in shows nowhere near.
//!
//! A method may displace outlines by its bound E, so single pixels near edges prove nothing: a wire that moved by one pixel is
//! missing wherever it was. A covered pixel of the original is *lost* only if
//! - the stand-in shows nothing there or what lies behind (where it shows something in front, such as a leaf of a tree that became
//!   fuller, nothing is seen to be gone: those pixels are counted as in front),
//! - no pixel within E shows the stand-in at the same depth, within the bound as an angle (see [`super::parallax`]), and
//! - no pixel within E, reached over the same continuous surface of the original, is right. (A steep surface has
//!   another depth in every pixel, so the second condition alone would find rows of it that merely moved.)
//!
//! A wire that vanishes is lost; one that moved by less than E is not.

use super::{
    classes::{Class, Rule},
    deviation::DEVIATION_CAP_PX,
    edges::Surfaces,
    nearby::Nearby,
};

/// The lost pixels. `class` classifies the pixels, `edges` are the original's discontinuities. E is `rule.band_px`, but at most
/// [`DEVIATION_CAP_PX`].
pub fn lost(original: &Surfaces, stand_in: &Surfaces, class: &[Class], edges: &[u8], rule: &Rule) -> Vec<bool> {
    let width = original.width;
    let (w, h) = (width as i32, (class.len() / width) as i32);
    let radius = (rule.band_px as i32).min(DEVIATION_CAP_PX);
    let mut nearby = Nearby::new(radius, width, edges);
    let right = |q: usize| original.covered(q) && class[q] == Class::Right;
    let mut is_lost = |p: usize| {
        let z = original.depth[p];
        let same = |x: i32, y: i32| {
            let other = stand_in.depth[(y * w + x) as usize];
            other < f32::INFINITY
                && !rule.parallax.deeper(p, z, other, rule.bound)
                && !rule.parallax.deeper(p, other, z, rule.bound)
        };
        let (x0, y0) = ((p % width) as i32, (p / width) as i32);
        let found = ((y0 - radius).max(0)..=(y0 + radius).min(h - 1)).any(|y| {
            let room = radius * radius - (y - y0) * (y - y0);
            ((x0 - radius).max(0)..=(x0 + radius).min(w - 1)).any(|x| (x - x0) * (x - x0) <= room && same(x, y))
        });
        !found && !nearby.any(p, radius * radius, right)
    };
    let gone = |p: usize| matches!(class[p], Class::Missing | Class::WrongSurface);
    (0..class.len()).map(|p| gone(p) && is_lost(p)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        certify::{
            classes::classify,
            edges::{BELOW, RIGHT},
            parallax::{Angle, Parallax},
        },
        view::{Cell, Region, View},
    };
    use glam::DVec3;
    use proptest::prelude::*;

    const N: usize = 14;

    fn rule(band_px: u32) -> Rule {
        let cell = Cell { centre: DVec3::ZERO, half: DVec3::ONE };
        let view = View::look_at(DVec3::ZERO, -DVec3::Z, DVec3::Y, 0.8, N as u32, N as u32, 0.1, 1000.0);
        Rule { parallax: Parallax::new(&view, &Region::Box(cell)), bound: Angle::new(0.1), band_px }
    }

    fn depths(f: impl Fn(usize, usize) -> f32) -> Vec<f32> {
        (0..N * N).map(|i| f(i % N, i / N)).collect()
    }

    /// Every two neighbours of different depth are separated.
    fn steps(depth: &[f32]) -> Vec<u8> {
        let differs = |i: usize, j: Option<usize>| j.is_some_and(|j| j < N * N && depth[i] != depth[j]);
        (0..N * N)
            .map(|i| {
                let right = if differs(i, (i % N + 1 < N).then_some(i + 1)) { RIGHT } else { 0 };
                right | if differs(i, Some(i + N)) { BELOW } else { 0 }
            })
            .collect()
    }

    fn count(a: &[f32], b: &[f32], edges: &[u8], band_px: u32) -> usize {
        let triangle = vec![0; N * N];
        let (a, b) = (
            Surfaces { width: N, depth: a, triangle: &triangle },
            Surfaces { width: N, depth: b, triangle: &triangle },
        );
        let rule = rule(band_px);
        let class = classify(&a, &b, edges, &rule).class;
        lost(&a, &b, &class, edges, &rule).into_iter().filter(|l| *l).count()
    }

    const FAR: f32 = f32::INFINITY;

    #[test]
    fn a_wire_that_vanishes_is_lost_and_one_that_moved_is_not() {
        let wire = |at: usize| depths(move |x, _| if x == at { 2.0 } else { FAR });
        let original = wire(5);
        let edges = steps(&original);
        assert_eq!(count(&original, &depths(|_, _| FAR), &edges, 2), N);
        assert_eq!(count(&original, &wire(7), &edges, 2), 0);
        assert_eq!(count(&original, &wire(8), &edges, 2), N);
        // Before a wall the loss shows as a wrong surface.
        let before = depths(|x, _| if x == 5 { 2.0 } else { 40.0 });
        assert_eq!(count(&before, &depths(|_, _| 40.0), &steps(&before), 2), N);
        // What stands before it hides it.
        assert_eq!(count(&original, &depths(|x, _| if x == 5 { 1.2 } else { FAR }), &edges, 2), 0);
        // Something else behind stands in its place.
        assert_eq!(count(&original, &depths(|x, _| if x == 5 { 40.0 } else { FAR }), &edges, 2), N);
    }

    #[test]
    fn dashes_are_lost_where_they_are_far_apart() {
        let original = depths(|x, _| if x == 5 { 2.0 } else { FAR });
        let dashes = depths(|x, y| if x == 5 && !(4..10).contains(&y) { 2.0 } else { FAR });
        assert_eq!(count(&original, &dashes, &steps(&original), 2), 2);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        /// The definition, pixel by pixel.
        #[test]
        fn the_search_is_the_literal_one(
            a in prop::collection::vec(prop_oneof![2 => Just(2.0f32), 2 => Just(4.0), 2 => Just(f32::INFINITY)], N * N),
            b in prop::collection::vec(prop_oneof![1 => Just(2.0f32), 2 => Just(4.0), 5 => Just(f32::INFINITY)], N * N),
            edges in prop::collection::vec(prop_oneof![3 => Just(0u8), 1 => Just(RIGHT), 1 => Just(BELOW), 1 => Just(RIGHT | BELOW)], N * N),
            band_px in 1_u32..5,
        ) {
            let triangle = vec![0; N * N];
            // No discontinuity lies beyond the picture.
            let edges: Vec<u8> = edges
                .iter()
                .enumerate()
                .map(|(i, e)| e & if i % N + 1 < N { RIGHT | BELOW } else { BELOW } & if i + N < N * N { RIGHT | BELOW } else { RIGHT })
                .collect();
            let original = Surfaces { width: N, depth: &a, triangle: &triangle };
            let stand_in = Surfaces { width: N, depth: &b, triangle: &triangle };
            let rule = rule(band_px);
            let class = classify(&original, &stand_in, &edges, &rule).class;
            let found = lost(&original, &stand_in, &class, &edges, &rule);
            let near = |p: usize, q: usize| {
                let (dx, dy) = ((p % N) as i32 - (q % N) as i32, (p / N) as i32 - (q / N) as i32);
                dx * dx + dy * dy <= (band_px * band_px) as i32
            };
            for p in 0..N * N {
                let same = |q: usize| {
                    b[q].is_finite()
                        && !rule.parallax.deeper(p, a[p], b[q], rule.bound)
                        && !rule.parallax.deeper(p, b[q], a[p], rule.bound)
                };
                let mut reached = vec![p];
                let mut at = 0;
                while let Some(&i) = reached.get(at) {
                    at += 1;
                    let (x, y) = (i % N, i / N);
                    let mut step = |open: bool, n: usize| {
                        if open && near(p, n) && !reached.contains(&n) {
                            reached.push(n);
                        }
                    };
                    if x + 1 < N { step(edges[i] & RIGHT == 0, i + 1) }
                    if x > 0 { step(edges[i - 1] & RIGHT == 0, i - 1) }
                    if y + 1 < N { step(edges[i] & BELOW == 0, i + N) }
                    if y > 0 { step(edges[i - N] & BELOW == 0, i - N) }
                }
                let expect = a[p].is_finite()
                    && [Class::Missing, Class::WrongSurface].contains(&class[p])
                    && !(0..N * N).any(|q| near(p, q) && same(q))
                    && !reached.iter().any(|q| a[*q].is_finite() && class[*q] == Class::Right);
                prop_assert_eq!(found[p], expect, "pixel {}", p);
            }
        }
    }
}
