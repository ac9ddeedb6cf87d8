//! Whether a grid point splits a triangle that deviates by more than a tolerance from the grid points that it covers.
//!
//! A triangulation consists of triangles whose hypotenuse has an unselected midpoint. If neither of the two triangles that
//! share the hypotenuse deviates by more than ε, no grid point is farther than ε from the triangle that stands in for it,
//! whatever its neighbours are: the bound holds triangle by triangle and needs no maximum up the hierarchy.
//!
//! Visiting all points under all triangles of all levels would take ten times longer than everything else. So upper bounds are
//! computed beforehand; the triangles that they leave undecided are scanned once a tolerance is known, until one point exceeds it.

use super::{
    edge_error::{across, point_line},
    grid::{Grid, step},
    map::DepthMap,
    options::Distance,
    rays::Rays,
};
use glam::Vec3;
use rayon::prelude::*;

/// Always scanned: triangles that hold surface and background.
const UNBOUNDED: f32 = 1e30;

/// Upper bounds of the squared distance, metres², of what each grid point's two triangles cover. Corners have none.
///
/// A covered point deviates by its distance from the half of the triangle that covers it, plus the deviation of that half, which is
/// largest at the midpoint of the hypotenuse.
pub(super) fn bounds(map: &DepthMap, rays: &Rays, distance: Distance) -> Vec<f32> {
    let side = map.side();
    let (grid, depth) = (Grid::of(side), map.depth());
    let own = |at: usize| {
        let (x, y) = (at % side, at / side);
        if grid.is_corner(x, y) {
            return 0.0;
        }
        let [a, b] = Grid::ends(x, y);
        let z = [a, b, (x, y)].map(|(x, y)| depth[y * side + x]);
        match z.iter().filter(|z| z.is_finite()).count() {
            0 => 0.0,
            3 if distance == Distance::Depth => {
                let expected = rays.depth_between(z[0], z[1]);
                let deviation = (z[2] - expected).abs();
                if !rays.perspective {
                    return deviation;
                }
                // What is linear over the image is the inverse depth.
                let apexes = grid.apexes(x, y).into_iter().flatten().map(|(x, y)| depth[y * side + x]);
                let deepest = apexes.chain(z).fold(0.0, f32::max);
                let bound = deviation * (deepest / z[2]) * (deepest / expected);
                if bound < UNBOUNDED { bound } else { UNBOUNDED }
            }
            3 => {
                let [a, b, p] = [(a, z[0]), (b, z[1]), ((x, y), z[2])].map(|((x, y), z)| rays.position(x, y, z));
                point_edge(a, b, p).sqrt()
            }
            _ => UNBOUNDED,
        }
    };
    let mut bounds: Vec<f32> = (0..side * side).into_par_iter().with_min_len(4096).map(own).collect();
    for level in (0..grid.k).rev() {
        let h = grid.half(level);
        let n = grid.cells();
        let mut add = |x: usize, y: usize| {
            let dependants = grid.dependants(x, y).into_iter().flatten();
            let most = dependants.map(|(x, y)| bounds[y * side + x]).fold(0.0, f32::max);
            bounds[y * side + x] = (bounds[y * side + x] + most).min(UNBOUNDED);
        };
        for y in (0..=n).step_by(h) {
            let from = if y & h == 0 { h } else { 0 };
            (from..=n).step_by(2 * h).for_each(|x| add(x, y));
        }
        for y in (h..n).step_by(2 * h) {
            (h..n).step_by(2 * h).for_each(|x| add(x, y));
        }
    }
    // Rounding of the sums.
    bounds.iter_mut().for_each(|b| *b = if *b < 1e15 { *b * *b * (1.0 + 1e-5) } else { UNBOUNDED });
    bounds
}

/// Squared distance of p from the edge between a and b.
fn point_edge(a: Vec3, b: Vec3, p: Vec3) -> f32 {
    let along = (b - a).dot(p - a);
    if along <= 0.0 {
        (p - a).length_squared()
    } else if along >= (b - a).length_squared() {
        (p - b).length_squared()
    } else {
        point_line(a, b, p)
    }
}

/// A quarter or a half of a quad of side 2h.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    North,
    East,
    South,
    West,
    NorthEast,
    SouthEast,
    SouthWest,
    NorthWest,
}

impl Shape {
    /// Corners from the centre in half sides.
    fn corners(self) -> [(isize, isize); 3] {
        let [nw, ne, se, sw, c] = [(-1, -1), (1, -1), (1, 1), (-1, 1), (0, 0)];
        match self {
            Self::North => [nw, ne, c],
            Self::East => [ne, se, c],
            Self::South => [se, sw, c],
            Self::West => [sw, nw, c],
            Self::NorthEast => [nw, ne, se],
            Self::SouthEast => [ne, se, sw],
            Self::SouthWest => [se, sw, nw],
            Self::NorthWest => [sw, nw, ne],
        }
    }

    /// Rows that it covers.
    fn rows(self, h: isize) -> [isize; 2] {
        match self {
            Self::North => [-h, 0],
            Self::South => [0, h],
            _ => [-h, h],
        }
    }

    /// Columns that it covers in row s.
    fn columns(self, h: isize, s: isize) -> [isize; 2] {
        match self {
            Self::North | Self::South => [-s.abs(), s.abs()],
            Self::East => [s.abs(), h],
            Self::West => [-h, -s.abs()],
            Self::NorthEast => [s, h],
            Self::SouthWest => [-h, s],
            Self::NorthWest => [-h, -s],
            Self::SouthEast => [-s, h],
        }
    }

    fn is_half(self) -> bool {
        matches!(self, Self::NorthEast | Self::SouthEast | Self::SouthWest | Self::NorthWest)
    }
}

/// A triangle's plane.
struct Plane {
    corners: [Vec3; 3],
    /// Not of unit length.
    normal: Vec3,
    /// The first corner's column and row.
    at: (usize, usize),
}

/// Looks at what triangles cover.
pub(super) struct Scan<'a> {
    pub map: &'a DepthMap,
    pub rays: &'a Rays,
    pub distance: Distance,
}

impl Scan<'_> {
    /// Whether one of the two triangles that (x, y) splits deviates by more than a squared tolerance. One that holds surface and
    /// background deviates by the length of its hypotenuse across the view at least: by that much the outline recedes where it is
    /// cut. Not for corners of the grid.
    pub fn exceeds(&self, x: usize, y: usize, tolerance: f32) -> bool {
        let h = Grid::half_at(x, y);
        let last = self.map.side() - 1;
        let triangles = match (x & h != 0, y & h != 0) {
            (true, true) if (x ^ y) & (2 * h) == 0 => [Some((x, y, Shape::SouthWest)), Some((x, y, Shape::NorthEast))],
            (true, true) => [Some((x, y, Shape::NorthWest)), Some((x, y, Shape::SouthEast))],
            (true, false) => {
                [y.checked_sub(h).map(|y| (x, y, Shape::South)), (y < last).then_some((x, y + h, Shape::North))]
            }
            _ => [x.checked_sub(h).map(|x| (x, y, Shape::East)), (x < last).then_some((x + h, y, Shape::West))],
        };
        triangles.into_iter().flatten().any(|(cx, cy, shape)| self.triangle((x, y), (cx, cy), h, shape, tolerance))
    }

    fn triangle(&self, split: (usize, usize), centre: (usize, usize), h: usize, shape: Shape, tolerance: f32) -> bool {
        let side = self.map.side();
        let points = shape.corners().map(|d| step(centre, d, h));
        let depth = |(x, y): (usize, usize)| self.map.depth()[y * side + x];
        let corners @ [a, b, c] = points.map(|(x, y)| self.rays.position(x, y, depth((x, y))));
        let cut = a.z + b.z + c.z == f32::INFINITY;
        let plane = (!cut).then(|| Plane { corners, normal: (b - a).cross(c - a), at: points[0] });
        // Most often the midpoint itself decides.
        let (x, y) = split;
        if let Some(plane) = plane.as_ref().filter(|_| depth(split) < f32::INFINITY) {
            let line = Line::new(self.rays, plane, y, self.distance != Distance::Depth);
            if self.point(plane, &line, x, y, depth(split), tolerance) {
                return true;
            }
        }
        let mut seen = Seen { background: cut, deepest: -1.0 };
        let [from, to] = shape.rows(h as isize);
        (from..=to).any(|s| {
            let [left, right] = shape.columns(h as isize, s).map(|c| centre.0.wrapping_add_signed(c));
            let y = centre.1.wrapping_add_signed(s);
            self.row(y, left, right, plane.as_ref(), tolerance, &mut seen)
                || seen.background
                    && seen.deepest >= 0.0
                    && across(self.rays, h, shape.is_half(), seen.deepest) > tolerance
        })
    }

    fn row(&self, y: usize, left: usize, right: usize, plane: Option<&Plane>, tolerance: f32, seen: &mut Seen) -> bool {
        let side = self.map.side();
        let depths = &self.map.depth()[y * side + left..=y * side + right];
        let Some(plane) = plane else {
            let finite = depths.iter().filter(|z| z.is_finite());
            seen.deepest = finite.fold(seen.deepest, |a, z| a.max(*z));
            return false;
        };
        let line = Line::new(self.rays, plane, y, self.distance != Distance::Depth);
        let columns = &self.rays.x[left..=right];
        let (xs, zs) = (columns.chunks_exact(LANES), depths.chunks_exact(LANES));
        let rest = columns.len() - xs.remainder().len();
        let mut lanes = Extremes { most: [0.0; LANES], deepest: [seen.deepest; LANES], background: [0; LANES] };
        for (x, z) in xs.zip(zs) {
            for i in 0..LANES {
                lanes.add(i, z[i], line.bound(x[i], z[i]));
            }
        }
        for (i, (&x, &z)) in columns[rest..].iter().zip(&depths[rest..]).enumerate() {
            lanes.add(i, z, line.bound(x, z));
        }
        let Extremes { most, deepest, background } = lanes;
        let most = most.into_iter().fold(0.0, f32::max);
        seen.deepest = deepest.into_iter().fold(seen.deepest, f32::max);
        seen.background |= background != [0; LANES];
        most > tolerance
            && (left..).zip(depths).any(|(x, &z)| z < f32::INFINITY && self.point(plane, &line, x, y, z, tolerance))
    }

    #[inline]
    fn point(&self, plane: &Plane, line: &Line, x: usize, y: usize, z: f32, tolerance: f32) -> bool {
        line.bound(self.rays.x[x], z) > tolerance
            && (self.distance == Distance::Depth || squared_distance(plane, self.rays.position(x, y, z)) > tolerance)
    }
}

/// What a triangle was seen to hold.
struct Seen {
    background: bool,
    /// Depth of the deepest surface; −1 without any.
    deepest: f32,
}

/// Points that are compared at a time: several vector registers.
const LANES: usize = 8;

/// The largest bound, the largest depth and whether there is background, side by side for vector registers.
struct Extremes {
    most: [f32; LANES],
    deepest: [f32; LANES],
    background: [u32; LANES],
}

impl Extremes {
    #[inline(always)]
    fn add(&mut self, i: usize, z: f32, bound: f32) {
        let surface = z < f32::INFINITY;
        let bound = if surface { bound } else { 0.0 };
        let z = if surface { z } else { -1.0 };
        self.most[i] = if bound > self.most[i] { bound } else { self.most[i] };
        self.deepest[i] = if z > self.deepest[i] { z } else { self.deepest[i] };
        self.background[i] |= u32::from(!surface);
    }
}

/// A plane along a row. With q the distance of a point from it times the normal's length, and s the normal along the point's ray, q/s is the
/// difference of planar depth. Times the ray's length it bounds the distance from the triangle from above.
struct Line {
    /// s = slope·x + along.
    slope: f32,
    along: f32,
    /// q = (z − depth)·s + shift·(x − origin) + base: differences only, so that distant cameras lose no digits.
    depth: f32,
    shift: f32,
    origin: f32,
    base: f32,
    /// Squared length of a ray: stretch·x² + length.
    stretch: f32,
    length: f32,
}

impl Line {
    /// Row y; without `length` of rays bounds are of planar depth.
    fn new(rays: &Rays, plane: &Plane, y: usize, length: bool) -> Self {
        let Plane { corners: [a, ..], normal, at } = plane;
        let (w, scale, row) = (rays.stretch(a.z), f32::from(rays.perspective), rays.y[y]);
        let stretch = if length { scale } else { 0.0 };
        Self {
            slope: scale * normal.x,
            along: scale * normal.y * row + normal.z,
            depth: a.z,
            shift: w * normal.x,
            origin: rays.x[at.0],
            // A triangle without area bounds nothing: every point is looked at.
            base: if *normal == Vec3::ZERO && length { 1.0 } else { w * normal.y * (row - rays.y[at.1]) },
            stretch,
            length: 1.0 + stretch * row * row,
        }
    }

    /// Squared.
    #[inline(always)]
    fn bound(&self, x: f32, z: f32) -> f32 {
        let s = self.slope * x + self.along;
        let q = (z - self.depth) * s + self.shift * (x - self.origin) + self.base;
        let d = q / s;
        d * d * (self.stretch * x * x + self.length)
    }
}

/// Squared distance of a point from a triangle.
fn squared_distance(plane: &Plane, p: Vec3) -> f32 {
    let Plane { corners: [a, b, c], normal, .. } = *plane;
    let area = normal.length_squared();
    let inside =
        area > 0.0 && [(a, b), (b, c), (c, a)].into_iter().all(|(s, e)| (e - s).cross(p - s).dot(normal) >= 0.0);
    if inside {
        let d = (p - a).dot(normal);
        return d * (d / area);
    }
    let to_edge = |s: Vec3, e: Vec3| {
        let (d, q) = (e - s, p - s);
        let length = d.length_squared();
        let t = if length > 0.0 { (d.dot(q) / length).clamp(0.0, 1.0) } else { 0.0 };
        (q - d * t).length_squared()
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}
