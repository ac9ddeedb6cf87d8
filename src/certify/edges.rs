//! Depth discontinuities of the original, and the band around them.
//!
//! Two 4-neighbours are separated by a discontinuity where exactly one of them is covered, or where one lies more than
//! one pixel's angle of parallax behind the other (seen from some corner of the cell a gap opens between them) and
//! their surfaces do not meet between the two pixel centres: neither does the plane of one triangle reach the
//! other's depth there, nor do the two planes cross. So neither slanted surfaces nor creases count, however steep.

use super::parallax::{Angle, Parallax};

/// What one scene shows in a view, one sample at every pixel centre, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Surfaces<'a> {
    pub width: usize,
    /// Planar depth in metres; infinite where there is nothing.
    pub depth: &'a [f32],
    /// Triangle numbers; any value where there is nothing.
    pub triangle: &'a [u32],
}

impl Surfaces<'_> {
    pub fn covered(&self, i: usize) -> bool {
        self.depth[i] < f32::INFINITY
    }
}

/// A discontinuity between a pixel and its right neighbour.
pub const RIGHT: u8 = 1;
/// A discontinuity between a pixel and the one below.
pub const BELOW: u8 = 2;

/// [`RIGHT`] and [`BELOW`] for every pixel. `plane(t)` holds the k of triangle t with 1/depth = k·d, d the ray
/// direction (x, y, 1) in camera axes; `pixel` is a pixel's angle.
pub fn discontinuities(s: &Surfaces, parallax: &Parallax, pixel: Angle, plane: &dyn Fn(u32) -> glam::DVec3) -> Vec<u8> {
    let mut edges = vec![0_u8; s.depth.len()];
    for i in 0..s.depth.len() {
        // Most of a picture often shows nothing.
        let below = s.depth.get(i + s.width);
        let alone = s.depth.get(i + 1).is_none_or(|d| *d == f32::INFINITY) && below.is_none_or(|d| *d == f32::INFINITY);
        if alone && !s.covered(i) {
            continue;
        }
        if (i + 1) % s.width != 0 && parted(s, parallax, pixel, plane, i, i + 1) {
            edges[i] |= RIGHT;
        }
        if i + s.width < s.depth.len() && parted(s, parallax, pixel, plane, i, i + s.width) {
            edges[i] |= BELOW;
        }
    }
    edges
}

fn parted(
    s: &Surfaces,
    parallax: &Parallax,
    pixel: Angle,
    plane: &dyn Fn(u32) -> glam::DVec3,
    a: usize,
    b: usize,
) -> bool {
    let (za, zb) = (s.depth[a], s.depth[b]);
    if s.covered(a) != s.covered(b) {
        return true;
    }
    if !s.covered(a) || s.triangle[a] == s.triangle[b] {
        return false;
    }
    // `i` is the nearer pixel: its ray carries both depths.
    let apart = |i: usize, za: f32, zb: f32| parallax.deeper(i, za.min(zb), za.max(zb), pixel);
    if !apart(a, za, zb) {
        return false;
    }
    let (ka, kb) = (plane(s.triangle[a]), plane(s.triangle[b]));
    if !(ka.is_finite() && kb.is_finite()) {
        return true;
    }
    let (da, db) = (parallax.ray(a), parallax.ray(b));
    let (at_a, at_b) = (ka.dot(da) - kb.dot(da), ka.dot(db) - kb.dot(db));
    if at_a * at_b <= 0.0 {
        return false;
    }
    let reaches = |k: glam::DVec3, d: glam::DVec3, i: usize, z: f32| {
        let q = k.dot(d);
        q > 0.0 && !apart(i, (1.0 / q) as f32, z)
    };
    !(reaches(ka, db, b, zb) || reaches(kb, da, a, za))
}

/// True for the pixels on both sides of every discontinuity.
pub fn edge_pixels(edges: &[u8], width: usize) -> Vec<bool> {
    let mut mask = vec![false; edges.len()];
    for (i, e) in edges.iter().enumerate() {
        if e & RIGHT != 0 {
            (mask[i], mask[i + 1]) = (true, true);
        }
        if e & BELOW != 0 {
            (mask[i], mask[i + width]) = (true, true);
        }
    }
    mask
}

/// The pixels whose centre lies at most `radius` pixels (Euclidean) from that of a pixel in `mask`.
/// Radii beyond 60,000 count as 60,000.
pub fn dilate_round(mask: &[bool], width: usize, radius: u32) -> Vec<bool> {
    let reach = radius.min(60_000) as usize;
    let height = mask.len() / width;
    // Distance along the row to the nearest set pixel, `reach + 1` where it is farther.
    let far = (reach + 1) as u16;
    let mut along = vec![far; mask.len()];
    for (row, out) in mask.chunks(width).zip(along.chunks_mut(width)) {
        let mut d = far;
        for (m, o) in row.iter().zip(out.iter_mut()) {
            d = if *m { 0 } else { (d + 1).min(far) };
            *o = d;
        }
        d = far;
        for (m, o) in row.iter().zip(out.iter_mut()).rev() {
            d = if *m { 0 } else { (d + 1).min(far) };
            *o = d.min(*o);
        }
    }
    let mut out = vec![false; mask.len()];
    for y in 0..height {
        for other in y.saturating_sub(reach)..=(y + reach).min(height - 1) {
            let dy = other.abs_diff(y);
            // The widest distance along this row that is near enough.
            let room = (0..=reach).rev().find(|d| d * d + dy * dy <= reach * reach).unwrap_or(0) as u16;
            let (out, along) = (&mut out[y * width..][..width], &along[other * width..][..width]);
            for (o, d) in out.iter_mut().zip(along) {
                *o |= *d <= room;
            }
        }
    }
    out
}

/// The pixels at most `radius` rows and columns from one in `mask`.
pub fn dilate_square(mask: &[bool], width: usize, radius: usize) -> Vec<bool> {
    let height = mask.len() / width;
    let mut rows = vec![false; mask.len()];
    for (row, out) in mask.chunks(width).zip(rows.chunks_mut(width)) {
        for (x, _) in row.iter().enumerate().filter(|(_, m)| **m) {
            out[x.saturating_sub(radius)..(x + radius + 1).min(width)].fill(true);
        }
    }
    let mut out = vec![false; mask.len()];
    for y in 0..height {
        for other in y.saturating_sub(radius)..=(y + radius).min(height - 1) {
            let (out, row) = (&mut out[y * width..][..width], &rows[other * width..][..width]);
            for (o, m) in out.iter_mut().zip(row) {
                *o |= m;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::{Cell, Region, View};
    use glam::DVec3;
    use proptest::prelude::*;

    const N: usize = 16;

    /// A view from the middle of a cell of side 2, 16 pixels wide.
    fn setting() -> (Parallax, Angle) {
        let cell = Cell { centre: DVec3::ZERO, half: DVec3::ONE };
        let view = View::look_at(DVec3::ZERO, -DVec3::Z, DVec3::Y, 0.8, N as u32, N as u32, 0.1, 1000.0);
        (Parallax::new(&view, &Region::Box(cell)), Angle::new(0.8 / N as f64))
    }

    /// Depths of planes, each pixel showing the one that `which` names.
    fn edges_of(planes: &[DVec3], which: impl Fn(usize, usize) -> Option<usize>) -> Vec<u8> {
        let (parallax, pixel) = setting();
        let triangle: Vec<u32> = (0..N * N).map(|i| which(i % N, i / N).map_or(u32::MAX, |p| p as u32)).collect();
        let depth: Vec<f32> = triangle
            .iter()
            .enumerate()
            .map(|(i, t)| planes.get(*t as usize).map_or(f32::INFINITY, |k| 1.0 / k.dot(parallax.ray(i)) as f32))
            .collect();
        let s = Surfaces { width: N, depth: &depth, triangle: &triangle };
        discontinuities(&s, &parallax, pixel, &|t| planes[t as usize])
    }

    #[test]
    fn a_silhouette_against_nothing_is_one_column_of_edges() {
        let edges = edges_of(&[DVec3::new(0.0, 0.0, 0.1)], |x, _| (x < 5).then_some(0));
        for (i, e) in edges.iter().enumerate() {
            assert_eq!(*e, if i % N == 4 { RIGHT } else { 0 });
        }
    }

    #[test]
    fn a_wall_before_another_is_an_edge_and_a_small_step_is_none() {
        let walls = |far: f64| edges_of(&[DVec3::Z / 10.0, DVec3::Z / far], |x, _| Some(usize::from(x >= 5)));
        assert!(walls(40.0).iter().enumerate().all(|(i, e)| (*e == RIGHT) == (i % N == 4)));
        assert!(walls(10.5).iter().all(|e| *e == 0));
    }

    #[test]
    fn steep_ground_and_creases_are_continuous() {
        // Ground 0.3 m below the eye in two triangles, then a wall that stands on it.
        let (ground, wall) = (DVec3::new(0.0, -1.0 / 0.3, 0.0), DVec3::Z / 9.0);
        let (parallax, _) = setting();
        let horizon = (0..N).find(|y| ground.dot(parallax.ray(y * N)) > wall.z).unwrap();
        let edges = edges_of(&[ground, ground, wall], |x, y| match y < horizon {
            true => Some(2),
            false => Some((x + y) % 2),
        });
        assert!(edges.iter().all(|e| *e == 0), "{edges:?}");
    }

    proptest! {
        #[test]
        fn the_round_dilation_is_the_literal_one(
            set in prop::collection::vec(0_usize..20 * 14, 0..6),
            radius in 0_u32..7,
        ) {
            let mut mask = vec![false; 20 * 14];
            for i in &set {
                mask[*i] = true;
            }
            let out = dilate_round(&mask, 20, radius);
            for (i, o) in out.iter().enumerate() {
                let near = set.iter().any(|s| {
                    let (dx, dy) = ((s % 20).abs_diff(i % 20), (s / 20).abs_diff(i / 20));
                    dx * dx + dy * dy <= (radius * radius) as usize
                });
                prop_assert_eq!(*o, near);
            }
            let square = dilate_square(&mask, 20, radius as usize);
            for (i, o) in square.iter().enumerate() {
                let near = set.iter().any(|s| {
                    (s % 20).abs_diff(i % 20).max((s / 20).abs_diff(i / 20)) <= radius as usize
                });
                prop_assert_eq!(*o, near);
            }
        }
    }
}
