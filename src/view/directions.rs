//! Sets of directions around an object, and cameras that look along them.

use super::{Projection, View};
use crate::math::Aabb;
use glam::{DVec2, DVec3};

/// Unit vectors to the centres of the 20 faces of an icosahedron: no direction is farther than about 37.4° from one of them
/// (Andújar et al. 2007, section 3.1).
pub fn icosahedron() -> Vec<DVec3> {
    geodesic(0)
}

/// Unit vectors to the centres of the 20·4^`levels` faces of an icosahedron whose faces are split in four `levels` times and whose
/// corners are moved onto the sphere: 320 for 2 levels (section 3.2). `levels` is at most 8. All directions of a level are, bit for bit, among
/// those of the next.
pub fn geodesic(levels: u32) -> Vec<DVec3> {
    subdivided(levels).into_iter().map(|f| f.centre).collect()
}

/// The directions of [`geodesic`] in the same order, each with a name that it keeps at every level: the number of the icosahedron's face, then a letter
/// for each split, `a` to `c` for the parts at the corners and `d` for the one in the middle; the last `d`s are left out, such as in `v07`, `v07b` and `v07db`.
pub fn named_geodesic(levels: u32) -> Vec<(String, DVec3)> {
    let name = |f: &Facet| {
        let letters: String = f.path.iter().map(|part| char::from(b'a' + part)).collect();
        (format!("v{:02}{}", f.number, letters.trim_end_matches('d')), f.centre)
    };
    subdivided(levels).iter().map(name).collect()
}

/// A face of a subdivided icosahedron.
struct Facet {
    /// Of the icosahedron's face that it is part of.
    number: usize,
    /// Which of four parts, split by split; 3 is the part in the middle.
    path: Vec<u8>,
    corners: [DVec3; 3],
    centre: DVec3,
}

impl Facet {
    fn part(&self, part: u8, corners: [DVec3; 3]) -> Self {
        // The part in the middle has its parent's centre, but for rounding.
        let centre = if part == 3 { self.centre } else { centre(&corners) };
        Self { number: self.number, path: [&self.path[..], &[part]].concat(), corners, centre }
    }

    fn split(&self) -> [Self; 4] {
        let [a, b, c] = self.corners;
        let [ab, bc, ca] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
        [(0, [a, ab, ca]), (1, [ab, b, bc]), (2, [ca, bc, c]), (3, [ab, bc, ca])].map(|(i, k)| self.part(i, k))
    }
}

fn subdivided(levels: u32) -> Vec<Facet> {
    let whole = |(number, corners)| Facet { number, path: Vec::new(), corners, centre: centre(&corners) };
    let mut facets: Vec<Facet> = faces().into_iter().enumerate().map(whole).collect();
    for _ in 0..levels.min(8) {
        facets = facets.iter().flat_map(Facet::split).collect();
    }
    facets
}

fn faces() -> Vec<[DVec3; 3]> {
    let phi = (1.0 + 5.0_f64.sqrt()) * 0.5;
    // The 12 corners; two of them are neighbours where they are 2 apart.
    let mut corners = Vec::with_capacity(12);
    for (s, t) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        corners.extend([DVec3::new(0.0, s, t * phi), DVec3::new(s, t * phi, 0.0), DVec3::new(t * phi, 0.0, s)]);
    }
    let near = |a: DVec3, b: DVec3| (a.distance(b) - 2.0).abs() < 1e-6;
    let mut out = Vec::with_capacity(20);
    for (i, a) in corners.iter().enumerate() {
        for (j, b) in corners.iter().enumerate().skip(i + 1) {
            for c in &corners[j + 1..] {
                if near(*a, *b) && near(*b, *c) && near(*c, *a) {
                    out.push([a.normalize(), b.normalize(), c.normalize()]);
                }
            }
        }
    }
    out
}

fn centre([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (*a + *b + *c).normalize()
}

/// The orthographic camera that looks at a cloud of points from the side where `direction` (unit, from the object to the eye) points,
/// with square pixels. The points' bounding square in the picture, with its centre in the middle, takes all but `margin` pixels on each
/// side; the depth range holds all points. `None` where there is no point.
pub fn look_along(points: impl Iterator<Item = DVec3>, direction: DVec3, pixels: u32, margin: f64) -> Option<View> {
    let view = View::look_at(direction, DVec3::ZERO, DVec3::Y, 1.0, 1, 1, 1.0, 2.0);
    let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in points {
        let p = DVec3::new(p.dot(view.right), p.dot(view.up), p.dot(view.forward));
        (lo, hi) = (lo.min(p), hi.max(p));
    }
    if !(lo.cmple(hi)).all() {
        return None;
    }
    let extent = hi - lo;
    // What has no extent is looked at as if it had one.
    let side = extent.truncate().max_element().max(extent.max_element() * 1e-3).max(1e-9);
    let n = f64::from(pixels);
    let half = side * 0.5 * n / (n - 2.0 * margin).max(n * 0.1);
    let slack = (extent.max_element() * 1e-3).max(1e-9);
    let middle = (lo + hi).truncate() * 0.5;
    let eye = view.right * middle.x + view.up * middle.y + view.forward * (lo.z - slack);
    let projection = Projection::Orthographic { left: -half, right: half, bottom: -half, top: half };
    Some(View { eye, projection, width: pixels, height: pixels, near: 0.0, far: extent.z + 2.0 * slack, ..view })
}

/// The orthographic camera that looks at a sphere (metres, `radius` ≥ 0) from the side where `direction` (unit, from the object to the eye) points.
/// The sphere's disc, in the middle of a square picture, takes all but `margin` pixels on each side; the depth range holds the sphere. The cameras
/// of all directions have equal windows, pixels and depth ranges.
pub fn look_along_sphere(centre: DVec3, radius: f64, direction: DVec3, pixels: u32, margin: f64) -> View {
    let view = View::look_at(direction, DVec3::ZERO, DVec3::Y, 1.0, 1, 1, 1.0, 2.0);
    let radius = radius.max(1e-9);
    let n = f64::from(pixels);
    let half = radius * n / (n - 2.0 * margin).max(n * 0.1);
    let deep = radius * 1.001;
    let projection = Projection::Orthographic { left: -half, right: half, bottom: -half, top: half };
    let eye = centre - view.forward * deep;
    View { eye, projection, width: pixels, height: pixels, near: 0.0, far: 2.0 * deep, ..view }
}

/// Octahedral coordinates of a unit vector, each in [−1, 1]: +Y is the middle of the square, −Y its four corners (Cigolle et al. 2014, with Y up).
pub fn octahedral(d: DVec3) -> DVec2 {
    let p = d / (d.x.abs() + d.y.abs() + d.z.abs());
    let sign = |v: f64| if v < 0.0 { -1.0 } else { 1.0 };
    if p.y >= 0.0 {
        DVec2::new(p.x, p.z)
    } else {
        DVec2::new((1.0 - p.z.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.z))
    }
}

/// The unit vector of octahedral coordinates: inverse of [`octahedral`].
pub fn from_octahedral(e: DVec2) -> DVec3 {
    let y = 1.0 - e.x.abs() - e.y.abs();
    let sign = |v: f64| if v < 0.0 { -1.0 } else { 1.0 };
    let (x, z) = if y >= 0.0 { (e.x, e.y) } else { ((1.0 - e.y.abs()) * sign(e.x), (1.0 - e.x.abs()) * sign(e.y)) };
    DVec3::new(x, y, z).normalize()
}

/// Hemi-octahedral coordinates of a unit vector with y ≥ 0, each in [−1, 1]: +Y is the middle of the square, +X, −X, +Z and −Z its corners (1, 1),
/// (−1, −1), (1, −1) and (−1, 1) (Cigolle et al. 2014, with Y up).
pub fn hemi_octahedral(d: DVec3) -> DVec2 {
    let p = d / (d.x.abs() + d.y.abs() + d.z.abs());
    DVec2::new(p.x + p.z, p.x - p.z)
}

/// The unit vector of hemi-octahedral coordinates: inverse of [`hemi_octahedral`]. On the square's border y is 0.
pub fn from_hemi_octahedral(e: DVec2) -> DVec3 {
    let (x, z) = ((e.x + e.y) * 0.5, (e.x - e.y) * 0.5);
    DVec3::new(x, (1.0 - x.abs() - z.abs()).max(0.0), z).normalize()
}

/// The direction of the frame in column `x` and row `y` of a square of `frames` × `frames`, row 0 at the top of the atlas: grid points lie at octahedral
/// coordinates (2x/(frames − 1) − 1, 2y/(frames − 1) − 1), hemi-octahedral ones where `hemi`. `frames` ≥ 2. The outermost frames lie on the square's border, so
/// that a full grid has its four corners in the direction −Y and each direction between there and the middle of a side twice.
pub fn octahedral_frame(x: u32, y: u32, frames: u32, hemi: bool) -> DVec3 {
    let last = f64::from(frames.max(2) - 1);
    let e = DVec2::new(f64::from(x), f64::from(y)) * 2.0 / last - 1.0;
    if hemi { from_hemi_octahedral(e) } else { from_octahedral(e) }
}

/// Around the pixels of an orthographic view, from its near to its far side, metres; in the view's axes.
pub fn window(view: &View) -> Option<Aabb> {
    match view.projection {
        Projection::Orthographic { left, right, bottom, top } => {
            Some(Aabb { min: DVec3::new(left, bottom, view.near), max: DVec3::new(right, top, view.far) })
        }
        Projection::Perspective { .. } => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Sequence;

    #[test]
    fn twenty_and_three_hundred_and_twenty_directions() {
        let (few, many) = (icosahedron(), geodesic(2));
        assert_eq!((few.len(), many.len(), geodesic(0).len()), (20, 320, 20));
        for set in [&few, &many] {
            assert!(set.iter().all(|d| (d.length() - 1.0).abs() < 1e-12));
            assert!(set.iter().copied().sum::<DVec3>().length() < 1e-9);
        }
        let region = crate::view::Region::Sphere { centre: DVec3::ZERO, radius: 1.0 };
        let sequence = Sequence::<3>::new(1);
        let farthest = |set: &[DVec3]| {
            let nearest = |d: DVec3| set.iter().map(|s| s.dot(d)).fold(-1.0, f64::max);
            (0..20_000).map(|i| nearest(region.eye(sequence.point(i)))).fold(1.0, f64::min)
        };
        let degrees = |cos: f64| libm::acos(cos).to_degrees();
        // The paper gives 37 degrees for 20 directions.
        assert!((36.0..37.5).contains(&degrees(farthest(&few))), "{}", degrees(farthest(&few)));
        assert!((9.0..11.0).contains(&degrees(farthest(&many))), "{}", degrees(farthest(&many)));
    }

    #[test]
    fn octahedral_coordinates_give_their_direction_back() {
        let region = crate::view::Region::Sphere { centre: DVec3::ZERO, radius: 1.0 };
        let sequence = Sequence::<3>::new(4);
        for i in 0..500 {
            let d = region.eye(sequence.point(i));
            let e = octahedral(d);
            assert!(e.abs().max_element() <= 1.0 && from_octahedral(e).distance(d) < 1e-12, "{d}");
        }
        for axis in DVec3::AXES {
            assert!(from_octahedral(octahedral(axis)).distance(axis) < 1e-12);
            assert!(from_octahedral(octahedral(-axis)).distance(-axis) < 1e-12);
        }
    }

    #[test]
    fn a_direction_has_one_name_at_all_levels() {
        let [few, some, many] = [0, 1, 2].map(named_geodesic);
        for (small, large) in [(&few, &some), (&some, &many)] {
            assert!(small.iter().all(|named| large.contains(named)));
        }
        for set in [&few, &some, &many] {
            let names: std::collections::BTreeSet<&str> = set.iter().map(|n| n.0.as_str()).collect();
            assert_eq!(names.len(), set.len());
        }
        assert_eq!(many.iter().map(|n| n.1).collect::<Vec<_>>(), geodesic(2));
        assert!(many.iter().any(|n| n.0 == "v07db") && some.iter().all(|n| n.0.len() <= 4));
    }

    #[test]
    fn hemi_octahedral_coordinates_give_their_direction_back() {
        let region = crate::view::Region::Sphere { centre: DVec3::ZERO, radius: 1.0 };
        let sequence = Sequence::<3>::new(4);
        for i in 0..500 {
            let mut d = region.eye(sequence.point(i));
            d.y = d.y.abs();
            let e = hemi_octahedral(d);
            assert!(e.abs().max_element() <= 1.0 + 1e-12 && from_hemi_octahedral(e).distance(d) < 1e-12, "{d}");
        }
        for (corner, d) in [
            ([1.0, 1.0], DVec3::X),
            ([-1.0, -1.0], -DVec3::X),
            ([1.0, -1.0], DVec3::Z),
            ([-1.0, 1.0], -DVec3::Z),
            ([0.0, 0.0], DVec3::Y),
        ] {
            assert_eq!(from_hemi_octahedral(corner.into()), d);
        }
    }

    #[test]
    fn frames_of_a_grid() {
        for n in 2..=9 {
            for (x, y) in (0..n).flat_map(|y| (0..n).map(move |x| (x, y))) {
                let half = octahedral_frame(x, y, n, true);
                assert!(half.y >= 0.0 && (half.length() - 1.0).abs() < 1e-12);
                // Neighbours in the grid are neighbours in space: mirrored columns give mirrored directions.
                let (d, m) = (octahedral_frame(x, y, n, false), octahedral_frame(n - 1 - x, y, n, false));
                assert!((d * DVec3::new(-1.0, 1.0, 1.0)).distance(m) < 1e-12 || d.y < 0.0, "{d} {m}");
            }
            for (x, y) in [(0, 0), (n - 1, 0), (0, n - 1), (n - 1, n - 1)] {
                assert!(octahedral_frame(x, y, n, false).distance(-DVec3::Y) < 1e-12);
            }
        }
        assert_eq!(octahedral_frame(4, 4, 9, false), DVec3::Y);
        assert_eq!(octahedral_frame(8, 4, 9, false), DVec3::X);
        assert_eq!(octahedral_frame(4, 8, 9, false), DVec3::Z);
        assert_eq!(octahedral_frame(8, 8, 9, true), DVec3::X);
    }

    #[test]
    fn a_sphere_fills_its_picture_from_everywhere() {
        let (centre, radius) = (DVec3::new(3.0, -1.0, 2.0), 2.5);
        for d in geodesic(1).into_iter().chain([DVec3::Y, -DVec3::Y]) {
            let view = look_along_sphere(centre, radius, d, 64, 2.0);
            let side = view.project(centre + view.right * radius);
            assert!((side.0 - 62.0).abs() < 1e-9 && (side.1 - 32.0).abs() < 1e-9);
            let (front, back) = (view.project(centre + d * radius).2, view.project(centre - d * radius).2);
            assert!(front > view.near && back < view.far && front < back);
        }
        let point = look_along_sphere(centre, 0.0, DVec3::X, 64, 2.0);
        assert!(point.near < point.far && window(&point).is_some_and(|w| w.min.x < w.max.x));
    }

    #[test]
    fn pictures_hold_the_points_and_fill_one_side() {
        let points: Vec<DVec3> =
            crate::math::Aabb { min: DVec3::new(-1.0, 2.0, 3.0), max: DVec3::new(4.0, 2.5, 7.0) }.corners().to_vec();
        for d in geodesic(1) {
            let view = look_along(points.iter().copied(), d, 64, 2.0).unwrap();
            assert!(view.forward.distance(-d) < 1e-12);
            let seen: Vec<_> = points.iter().map(|p| view.project(*p)).collect();
            let (lo, hi) =
                seen.iter().fold((64.0f64, 0.0f64), |(l, h), (x, y, _)| (l.min(*x).min(*y), h.max(*x).max(*y)));
            assert!((lo - 2.0).abs() < 1e-6 && (hi - 62.0).abs() < 1e-6, "{lo} {hi}");
            assert!(seen.iter().all(|p| p.2 > view.near && p.2 < view.far));
        }
        assert_eq!(look_along(std::iter::empty(), DVec3::X, 64, 2.0), None);
        let flat = look_along([DVec3::ONE].into_iter(), DVec3::X, 64, 2.0).unwrap();
        assert!(flat.near < flat.far && window(&flat).is_some_and(|w| w.min.x < w.max.x));
    }
}
