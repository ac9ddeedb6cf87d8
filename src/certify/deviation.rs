//! The largest deviation on the screen: how far a wrong pixel is from the nearest pixel where it would be right.
//!
//! Where the stand-in is missing or deeper than the bound allows at pixel p, the original's surface at p would be right at
//! any pixel q where the stand-in is at most as deep; and where the surface itself goes on from p to q without a discontinuity
//! and the stand-in is right at q, its outline has moved no farther than that. (A plane's depth changes by any amount from
//! pixel to pixel at a grazing angle; the first alone would find a row that is cut off nowhere near.) Where the stand-in
//! is extra or in front, likewise with the roles exchanged. Depths are compared as in [`super::classes`]. The distance between
//! the centres of p and q, less half a pixel, estimates the distance to the outline between q and its neighbour to within half a
//! pixel.

use super::{classes::Rule, edges::Surfaces, nearby::Nearby};

/// Larger deviations are reported as this many pixels less one half.
pub const DEVIATION_CAP_PX: i32 = 32;

/// What a scene shows in a view, and its discontinuities.
pub struct Seen<'a> {
    pub surfaces: Surfaces<'a>,
    pub edges: &'a [u8],
}

/// The largest deviation of a view in pixels; 0 where no pixel deviates.
pub fn max_deviation(original: &Seen, stand_in: &Seen, rule: &Rule) -> f64 {
    let squared = one_way(original, &stand_in.surfaces, rule).max(one_way(stand_in, &original.surfaces, rule));
    if squared == 0 { 0.0 } else { f64::from(squared).sqrt() - 0.5 }
}

/// The largest squared distance from a pixel where `b` lies behind what is seen to the nearest where it does not.
fn one_way(seen: &Seen, b: &Surfaces, rule: &Rule) -> i32 {
    let a = &seen.surfaces;
    let offsets = offsets();
    let (w, h) = (a.width as i32, (a.depth.len() / a.width) as i32);
    let cap = DEVIATION_CAP_PX * DEVIATION_CAP_PX;
    let mut nearby = Nearby::new(DEVIATION_CAP_PX, a.width, seen.edges);
    let behind = |q: usize, z: f32| rule.parallax.deeper(q, z, b.depth[q], rule.bound);
    // Offsets up to `most` are those no farther than the largest deviation so far, `farthest`.
    let (mut most, mut farthest) = (0, 0);
    for p in 0..a.depth.len() {
        let z = a.depth[p];
        if !behind(p, z) {
            continue;
        }
        let (x0, y0) = ((p % a.width) as i32, (p / a.width) as i32);
        let as_near = |&(dx, dy): &(i32, i32)| {
            let (x, y) = (x0 + dx, y0 + dy);
            x >= 0 && y >= 0 && x < w && y < h && !behind((y * w + x) as usize, z)
        };
        let goes_on = |q: usize| !behind(q, a.depth[q]);
        if offsets[..most].iter().any(as_near) || nearby.any(p, farthest, goes_on) {
            continue;
        }
        let squared = |(dx, dy): &(i32, i32)| dx * dx + dy * dy;
        let of_depth = offsets[most..].iter().find(|o| as_near(o)).map_or(cap, squared);
        // A detour may lead nearer than the search above could go.
        farthest = farthest.max(nearby.nearest(p, of_depth, goes_on).unwrap_or(of_depth));
        if farthest == cap {
            break;
        }
        most = offsets.partition_point(|o| squared(o) <= farthest);
    }
    farthest
}

/// The offsets within the cap, by distance; the first is (0, 0), the last one at the cap.
fn offsets() -> Vec<(i32, i32)> {
    let r = DEVIATION_CAP_PX;
    let mut all: Vec<(i32, i32)> = (-r..=r)
        .flat_map(|dy| (-r..=r).map(move |dx| (dx, dy)))
        .filter(|(dx, dy)| dx * dx + dy * dy <= r * r)
        .collect();
    all.sort_by_key(|(dx, dy)| (dx * dx + dy * dy, *dy, *dx));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        certify::{
            edges::{BELOW, RIGHT},
            parallax::{Angle, Parallax},
        },
        view::{Cell, Region, View},
    };
    use glam::DVec3;
    use proptest::prelude::*;

    const N: usize = 14;

    /// The definition, pixel by pixel: the nearest pixel at which `b` is as near, or, over pixels of the same surface that are no
    /// farther away than that, at which it is right.
    fn literal(seen: &Seen, b: &Surfaces, rule: &Rule) -> i32 {
        let a = &seen.surfaces;
        let behind = |q: usize, z: f32| rule.parallax.deeper(q, z, b.depth[q], rule.bound);
        let squared = |p: usize, q: usize| {
            let d = |f: fn(usize) -> usize| f(p) as i32 - f(q) as i32;
            d(|i| i % N).pow(2) + d(|i| i / N).pow(2)
        };
        let mut most = 0;
        for p in (0..N * N).filter(|p| behind(*p, a.depth[*p])) {
            let cap = DEVIATION_CAP_PX * DEVIATION_CAP_PX;
            let of_depth = (0..N * N).filter(|q| !behind(*q, a.depth[p])).map(|q| squared(p, q)).min().unwrap_or(cap);
            let mut reached = vec![p];
            let mut at = 0;
            while let Some(&i) = reached.get(at) {
                at += 1;
                let steps = [
                    (i % N > 0, i.wrapping_sub(1), i.wrapping_sub(1), RIGHT),
                    (i % N + 1 < N, i + 1, i, RIGHT),
                    (i >= N, i.wrapping_sub(N), i.wrapping_sub(N), BELOW),
                    (i + N < N * N, i + N, i, BELOW),
                ];
                for (there, n, first, side) in steps {
                    let open = there && seen.edges[first] & side == 0 && squared(p, n) <= of_depth;
                    if open && !reached.contains(&n) {
                        reached.push(n);
                    }
                }
            }
            let right = reached.into_iter().filter(|q| !behind(*q, a.depth[*q])).map(|q| squared(p, q)).min();
            most = most.max(right.unwrap_or(of_depth));
        }
        most
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn the_search_is_the_literal_one(
            a in prop::collection::vec(prop_oneof![2 => Just(2.0f32), 2 => Just(4.0), 1 => Just(f32::INFINITY)], N * N),
            b in prop::collection::vec(prop_oneof![1 => Just(2.0f32), 4 => Just(4.0), 4 => Just(f32::INFINITY)], N * N),
            edges in prop::collection::vec(prop_oneof![3 => Just(0u8), 1 => Just(RIGHT), 1 => Just(BELOW), 1 => Just(RIGHT | BELOW)], N * N),
        ) {
            let cell = Cell { centre: DVec3::ZERO, half: DVec3::ONE };
            let view = View::look_at(DVec3::ZERO, -DVec3::Z, DVec3::Y, 0.8, N as u32, N as u32, 0.1, 1000.0);
            let rule = Rule { parallax: Parallax::new(&view, &Region::Box(cell)), bound: Angle::new(0.1), band_px: 2 };
            let triangle = vec![0; N * N];
            let surfaces = |depth| Surfaces { width: N, depth, triangle: &triangle };
            let seen = Seen { surfaces: surfaces(&a), edges: &edges };
            prop_assert_eq!(one_way(&seen, &surfaces(&b), &rule), literal(&seen, &surfaces(&b), &rule));
        }
    }
}
