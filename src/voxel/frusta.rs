//! Which frusta and layers a selection needs (Jeschke and Wimmer 2002, section 4).
//!
//! One frustum where the selection fits in one of less than 90°, else the needed faces of a cube around the cell. A
//! frustum always looks along an axis of the world, its window may lie off centre: so the cell's half extents as the
//! frustum sees them are exact. Whatever depends on the selection is rounded outward to a fixed grid (a 16th or 32nd of
//! the next lower power of two), so that an object that moves inside these bounds moves no voxel.

use super::{
    Across, Frustum, Slices,
    layers::{Placement, Reach},
    valid::SIDES,
};
use crate::{
    math::{Stop, Stopped},
    raster::Polygon,
    view::Cell,
};
use glam::DVec3;
use rayon::prelude::*;

/// Nearer than this many half extents of the cell nothing is put into layers: their number has no bound there.
pub const NEAREST: f64 = 1.5;
/// The largest tangent in a single frustum's window; beyond it a cube face wastes fewer pixels.
const MAX_TANGENT: f64 = 2.0;

/// What the layers are made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Pixels along a side of the output image.
    pub resolution: u32,
    /// Field of view of the output image, radians, < π.
    pub fov: f64,
    /// Layers at most; what would need more stays geometry.
    pub max_layers: usize,
    /// Pixels along a side of a layer at most.
    pub max_side: u32,
}

impl Lens {
    /// δ: size of an output pixel in tangents.
    pub fn pixel(&self) -> f64 {
        2.0 * libm::tan(self.fov * 0.5) / f64::from(self.resolution)
    }

    /// α: the least angle that an output pixel subtends, that of the image's corners, radians.
    pub fn alpha(&self) -> f64 {
        let t = libm::tan(self.fov * 0.5);
        self.pixel() / (1.0 + 2.0 * t * t)
    }
}

/// Why there are no layers.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FrameError {
    #[error(
        "everything selected lies nearer to the view cell than {NEAREST} times its half extent (or than the largest number of layers allows), where there are no layers: the field would be empty; make the cell smaller or select what is farther away"
    )]
    AllNear,
    #[error(
        "a layer would need {needed} pixels along a side, at most {possible} are possible; lower the resolution or the samples, or make the cell smaller"
    )]
    TooLarge { needed: u64, possible: u32 },
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// A direction in which a frustum may look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    pub name: &'static str,
    pub right: DVec3,
    pub up: DVec3,
    pub forward: DVec3,
}

/// The six axes, sorted by name.
pub const AXES: [Axis; 6] = [
    Axis { name: "+x", right: DVec3::Z, up: DVec3::Y, forward: DVec3::X },
    Axis { name: "+y", right: DVec3::X, up: DVec3::Z, forward: DVec3::Y },
    Axis { name: "+z", right: DVec3::NEG_X, up: DVec3::Y, forward: DVec3::Z },
    Axis { name: "-x", right: DVec3::NEG_Z, up: DVec3::Y, forward: DVec3::NEG_X },
    Axis { name: "-y", right: DVec3::X, up: DVec3::NEG_Z, forward: DVec3::NEG_Y },
    Axis { name: "-z", right: DVec3::X, up: DVec3::Y, forward: DVec3::NEG_Z },
];

impl Axis {
    /// Coordinates to the right, up and forward.
    pub fn local(&self, p: DVec3) -> DVec3 {
        DVec3::new(p.dot(self.right), p.dot(self.up), p.dot(self.forward))
    }

    /// The cell's half extents to the right, up and forward.
    fn half(&self, cell: &Cell) -> DVec3 {
        self.local(cell.half).abs()
    }
}

/// The name of the axis along which a frustum looks.
pub fn axis_name(f: &Frustum) -> &'static str {
    AXES.iter().find(|a| a.forward.dot(f.forward) > 0.5).map_or("frustum", |a| a.name)
}

/// What an axis sees of the selection: bounds of tangents and depths.
#[derive(Clone, Copy, Debug)]
struct Seen {
    left: f64,
    right: f64,
    bottom: f64,
    top: f64,
    near: f64,
    far: f64,
    /// Nothing lies outside the frustum, what is too near for layers excepted.
    all: bool,
}

impl Seen {
    const NOTHING: Self = Self {
        left: f64::INFINITY,
        right: f64::NEG_INFINITY,
        bottom: f64::INFINITY,
        top: f64::NEG_INFINITY,
        near: f64::INFINITY,
        far: 0.0,
        all: true,
    };

    fn union(self, o: Self) -> Self {
        Self {
            left: self.left.min(o.left),
            right: self.right.max(o.right),
            bottom: self.bottom.min(o.bottom),
            top: self.top.max(o.top),
            near: self.near.min(o.near),
            far: self.far.max(o.far),
            all: self.all && o.all,
        }
    }

    fn add(&mut self, p: DVec3) {
        let (u, v) = (p.x / p.z, p.y / p.z);
        let at = Self { left: u, right: u, bottom: v, top: v, near: p.z, far: p.z, all: true };
        *self = self.union(at);
    }

    fn tangent(&self) -> [f64; 2] {
        [self.left.abs().max(self.right.abs()), self.bottom.abs().max(self.top.abs())]
    }

    fn fits_one_frustum(&self) -> bool {
        let less_than_90_degrees = |a: f64, b: f64| libm::atan(b) - libm::atan(a) < std::f64::consts::FRAC_PI_2;
        self.all
            && less_than_90_degrees(self.left, self.right)
            && less_than_90_degrees(self.bottom, self.top)
            && self.tangent().iter().all(|t| *t <= MAX_TANGENT)
    }
}

/// Bounds of what `see` finds in all triangles, folded in any order: minima and maxima do not depend on it.
fn survey(triangles: &[[DVec3; 3]], stop: &Stop, see: impl Fn(&mut Seen, &[DVec3; 3]) + Sync) -> Result<Seen, Stopped> {
    let chunk = |chunk: &[[DVec3; 3]]| {
        stop.check()?;
        let mut seen = Seen::NOTHING;
        chunk.iter().for_each(|t| see(&mut seen, t));
        Ok(seen)
    };
    triangles.par_chunks(4096).map(chunk).try_reduce(|| Seen::NOTHING, |a, b| Ok(a.union(b)))
}

/// What a single frustum along `axis` would have to hold.
fn survey_axis(axis: &Axis, cell: &Cell, triangles: &[[DVec3; 3]], stop: &Stop) -> Result<Seen, Stopped> {
    let box_near = axis.half(cell) * NEAREST;
    survey(triangles, stop, |seen, triangle| {
        if !seen.all {
            return;
        }
        let mut polygon = Polygon::triangle(triangle.map(|p| axis.local(p)));
        let mut front = polygon;
        front.clip(|p| box_near.z - p.z);
        seen.all = front.corners().iter().all(|p| p.abs().cmple(box_near * (1.0 + 1e-9)).all());
        polygon.clip(|p| p.z - box_near.z);
        polygon.corners().iter().for_each(|p| seen.add(*p));
    })
}

/// What the cube's face along `axis` sees beyond depth `near`.
fn survey_face(axis: &Axis, near: f64, triangles: &[[DVec3; 3]], stop: &Stop) -> Result<Seen, Stopped> {
    survey(triangles, stop, |seen, triangle| {
        let mut polygon = Polygon::triangle(triangle.map(|p| axis.local(p)));
        polygon.clip(|p| p.z - near);
        let sides: [fn(DVec3) -> f64; 4] = [|p| p.z - p.x, |p| p.z + p.x, |p| p.z - p.y, |p| p.z + p.y];
        sides.iter().for_each(|side| polygon.clip(side));
        polygon.corners().iter().for_each(|p| seen.add(*p));
    })
}

/// Frusta and layers for triangles given relative to the cell's centre. Square pixels; see [`Lens`] for what for.
/// The resolution of a layer is RES = ⌈2t/δ · near/(near − az)⌉: a viewer at the near side of the cell still gets a
/// voxel a pixel.
pub fn frame(cell: &Cell, triangles: &[[DVec3; 3]], lens: &Lens, stop: &Stop) -> Result<Slices, FrameError> {
    let mut best: Option<(Axis, Seen)> = None;
    for axis in AXES {
        let seen = survey_axis(&axis, cell, triangles, stop)?;
        let size = |s: &Seen| s.tangent()[0].max(s.tangent()[1]);
        if seen.far > 0.0 && seen.fits_one_frustum() && best.is_none_or(|(_, b)| size(&seen) < size(&b)) {
            best = Some((axis, seen));
        }
    }
    if let Some((axis, seen)) = best {
        let az = axis.half(cell).z;
        let window = Window::around(&seen);
        return fit(cell, lens, az, (seen.near, seen.far), |pixel| {
            Ok(vec![(axis, window.image(pixel, lens.max_side)?)])
        });
    }

    let az = cell.half.max_element();
    let mut faces = Vec::new();
    let mut range = (f64::INFINITY, 0.0);
    for axis in AXES {
        let seen = survey_face(&axis, NEAREST * az, triangles, stop)?;
        if seen.far > 0.0 {
            faces.push(axis);
            range = (seen.near.min(range.0), seen.far.max(range.1));
        }
    }
    if faces.is_empty() {
        return Err(FrameError::AllNear);
    }
    let whole = Window { left: -1.0, right: 1.0, bottom: -1.0, top: 1.0 };
    fit(cell, lens, az, range, |pixel| {
        let side = whole.image(2.0 / (2.0 / pixel).ceil(), lens.max_side)?.size[0];
        let image = Image { window: whole, size: [side, side] };
        Ok(faces.iter().map(|axis| (*axis, image)).collect())
    })
}

/// A frustum's image: tangents and pixels.
#[derive(Clone, Copy)]
struct Image {
    window: Window,
    size: [u32; 2],
}

#[derive(Clone, Copy)]
struct Window {
    left: f64,
    right: f64,
    bottom: f64,
    top: f64,
}

impl Window {
    /// Rounded outward to a 16th of the power of two below its larger side.
    fn around(seen: &Seen) -> Self {
        let size = (seen.right - seen.left).max(seen.top - seen.bottom).max(1e-6);
        let step = power_of_two_below(size) / 16.0;
        let (down, up) = (|t: f64| (t / step).floor() * step, |t: f64| (t / step).ceil() * step);
        let (left, bottom) = (down(seen.left), down(seen.bottom));
        Self { left, right: up(seen.right).max(left + step), bottom, top: up(seen.top).max(bottom + step) }
    }

    /// Whole pixels that cover the window; it grows to the right and downward.
    fn image(&self, pixel: f64, max_side: u32) -> Result<Image, FrameError> {
        let count = |extent: f64| (extent / pixel * (1.0 - 1e-12)).ceil().max(1.0);
        let (w, h) = (count(self.right - self.left), count(self.top - self.bottom));
        if w.max(h) > f64::from(max_side) {
            return Err(FrameError::TooLarge { needed: w.max(h) as u64, possible: max_side });
        }
        let window = Self { right: self.left + w * pixel, bottom: self.top - h * pixel, ..*self };
        Ok(Image { window, size: [w as u32, h as u32] })
    }
}

/// Places layers, with the near border moved outward until there are few enough. `images` makes the frusta's images
/// for a size of pixels.
fn fit(
    cell: &Cell,
    lens: &Lens,
    az: f64,
    (nearest, farthest): (f64, f64),
    images: impl Fn(f64) -> Result<Vec<(Axis, Image)>, FrameError>,
) -> Result<Slices, FrameError> {
    let grid = |gap: f64| power_of_two_below(gap) / 32.0;
    let mut gap = {
        let exact = nearest - az;
        ((exact / grid(exact)).floor() * grid(exact)).max((NEAREST - 1.0) * az)
    };
    let far = {
        let exact = farthest - az;
        // Beyond the farthest point, so that it lies in a layer and not on the last border.
        az + ((exact / grid(exact)).floor() + 1.0) * grid(exact)
    };
    loop {
        let near = az + gap;
        if near >= far || near > farthest {
            return Err(FrameError::AllNear);
        }
        let frusta: Vec<_> =
            images(lens.pixel() * gap / near)?.into_iter().map(|(axis, image)| frustum(&axis, &image)).collect();
        let reach = |f: &Frustum| {
            let t = [f.left.abs().max(f.right_tan.abs()), f.bottom.abs().max(f.top.abs())];
            let half =
                DVec3::new(cell.half.dot(f.right.abs()), cell.half.dot(f.up.abs()), cell.half.dot(f.forward.abs()));
            Reach::new(half, t)
        };
        let pixel = (frusta[0].right_tan - frusta[0].left) / f64::from(frusta[0].size[0]);
        let all = frusta.iter().map(reach).reduce(Reach::union);
        let Some(reach) = all else { return Err(FrameError::AllNear) };
        let placement = Placement { reach, pixel, alpha: lens.alpha(), near, far };
        if let Some(placed) = placement.place(lens.max_layers) {
            let (layers, borders) = (placed.layers, placed.borders);
            return Ok(Slices { cell: *cell, frusta: link(frusta), layers, borders, alpha: lens.alpha() });
        }
        gap += grid(gap);
    }
}

fn frustum(axis: &Axis, image: &Image) -> Frustum {
    let Window { left, right, bottom, top } = image.window;
    let Axis { right: to_right, up, forward, .. } = *axis;
    Frustum { right: to_right, up, forward, left, right_tan: right, bottom, top, size: image.size, across: [None; 4] }
}

/// Fills `across` where faces of the cube share an edge.
fn link(mut frusta: Vec<Frustum>) -> Vec<Frustum> {
    let frames: Vec<_> = frusta.iter().map(|f| (f.forward, outward(f), along(f))).collect();
    for (f, (forward, sides, edges)) in frusta.iter_mut().zip(&frames) {
        for side in SIDES {
            let s = side as usize;
            let Some(g) = frames.iter().position(|(g, ..)| g.dot(sides[s]) > 0.5) else { continue };
            let (_, their_sides, their_edges) = &frames[g];
            let Some(t) = SIDES.into_iter().find(|t| their_sides[*t as usize].dot(*forward) > 0.5) else { continue };
            let reversed = their_edges[t as usize].dot(edges[s]) < 0.0;
            f.across[s] = Some(Across { frustum: g as u32, side: t, reversed });
        }
    }
    frusta
}

/// The direction in which each side lies.
fn outward(f: &Frustum) -> [DVec3; 4] {
    [-f.right, f.right, f.up, -f.up]
}

/// The direction in which pixels are counted along each side: from the top or from the left.
fn along(f: &Frustum) -> [DVec3; 4] {
    [-f.up, -f.up, f.right, f.right]
}

/// The greatest power of two that is at most `x`, for normal x > 0.
fn power_of_two_below(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & 0x7ff0_0000_0000_0000)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: Lens = Lens { resolution: 256, fov: std::f64::consts::FRAC_PI_4, max_layers: 1024, max_side: 16384 };

    fn cell(half: f64) -> Cell {
        Cell { centre: DVec3::ZERO, half: DVec3::splat(half) }
    }

    /// Twelve triangles of a box.
    fn cuboid(min: DVec3, max: DVec3) -> Vec<[DVec3; 3]> {
        let c = crate::math::Aabb { min, max }.corners();
        let quads = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
        quads.iter().flat_map(|[i, j, k, l]| [[c[*i], c[*j], c[*k]], [c[*i], c[*k], c[*l]]]).collect()
    }

    fn framed(half: f64, triangles: &[[DVec3; 3]]) -> Slices {
        let slices = frame(&cell(half), triangles, &LENS, &Stop::default()).unwrap();
        assert_eq!(slices.validate(), Ok(()));
        slices
    }

    #[test]
    fn a_distant_box_needs_one_frustum() {
        let triangles = cuboid(DVec3::new(-3.1, -1.1, -25.2), DVec3::new(4.1, 2.1, -20.2));
        let s = framed(1.0, &triangles);
        assert_eq!(s.frusta.len(), 1);
        let f = &s.frusta[0];
        assert_eq!(axis_name(f), "-z");
        for p in triangles.iter().flatten() {
            let (u, v) = (p.x / -p.z, p.y / -p.z);
            assert!(f.left <= u && u <= f.right_tan && f.bottom <= v && v <= f.top);
            assert!(s.borders[0] <= -p.z && -p.z < *s.borders.last().unwrap());
        }
        // A viewer at the near side gets a voxel a pixel.
        let pixel = (f.right_tan - f.left) / f64::from(f.size[0]);
        assert!((pixel - LENS.pixel() * (s.borders[0] - 1.0) / s.borders[0]).abs() < 1e-12);
        assert!((pixel - (f.top - f.bottom) / f64::from(f.size[1])).abs() < 1e-12);
    }

    #[test]
    fn what_moves_inside_moves_no_voxel() {
        let mut triangles = cuboid(DVec3::new(-3.1, -1.1, -25.2), DVec3::new(4.1, 2.1, -20.2));
        let inside = cuboid(DVec3::new(0.0, 0.0, -23.0), DVec3::new(1.0, 1.0, -22.0));
        let moved: Vec<_> = inside.iter().map(|t| t.map(|p| p + DVec3::new(0.3, 0.2, -0.7))).collect();
        let outside = triangles.clone();
        triangles.extend(&inside);
        let a = framed(1.0, &triangles);
        assert_eq!(a, framed(1.0, &[outside.clone(), moved].concat()));
        // Nor does a slight move of what bounds the selection.
        let nudged: Vec<_> = triangles.iter().map(|t| t.map(|p| p + DVec3::splat(1e-4))).collect();
        assert_eq!(a, framed(1.0, &nudged));
    }

    #[test]
    fn a_room_around_the_cell_needs_six_linked_faces() {
        let s = framed(0.5, &cuboid(DVec3::splat(-5.0), DVec3::splat(6.0)));
        assert_eq!(s.frusta.iter().map(axis_name).collect::<Vec<_>>(), AXES.map(|a| a.name));
        for f in &s.frusta {
            assert_eq!((f.size, f.left, f.top), (s.frusta[0].size, -1.0, 1.0));
            assert!((f.right_tan - 1.0).abs() < 1e-12 && (f.bottom + 1.0).abs() < 1e-12);
        }
        // Neighbours see the same direction at the shared edge, and links lead back.
        let n = s.frusta[0].size[0];
        let edge = |f: &Frustum, side: usize, i: u32| {
            let t = (f64::from(i) + 0.5) / f64::from(n) * 2.0 - 1.0;
            f.forward + outward(f)[side] + along(f)[side] * t
        };
        for (i, f) in s.frusta.iter().enumerate() {
            for (side, across) in f.across.iter().enumerate() {
                let a = across.unwrap();
                let g = &s.frusta[a.frustum as usize];
                for k in [0, 3, n - 1] {
                    let there = if a.reversed { n - 1 - k } else { k };
                    assert!((edge(f, side, k) - edge(g, a.side as usize, there)).length() < 1e-9);
                }
                let back = g.across[a.side as usize].unwrap();
                assert_eq!((back.frustum as usize, back.side as usize, back.reversed), (i, side, a.reversed));
            }
        }
    }

    #[test]
    fn only_the_faces_that_see_something_are_made() {
        let mut triangles = cuboid(DVec3::new(-1.0, -1.0, -9.0), DVec3::new(1.0, 1.0, -8.0));
        triangles.extend(cuboid(DVec3::new(8.0, -1.0, -1.0), DVec3::new(9.0, 1.0, 1.0)));
        let s = framed(0.5, &triangles);
        assert_eq!(s.frusta.iter().map(axis_name).collect::<Vec<_>>(), ["+x", "-z"]);
        assert_eq!(s.frusta[0].across[0].map(|a| a.frustum), Some(1));
        assert_eq!(s.frusta[1].across.iter().flatten().count(), 1);
    }

    #[test]
    fn a_selection_at_45_degrees_fits_one_frustum() {
        let s = framed(0.5, &cuboid(DVec3::new(9.0, -1.0, -12.0), DVec3::new(11.0, 1.0, -10.0)));
        assert_eq!(s.frusta.len(), 1);
        assert!(s.frusta[0].left > 0.5);
    }

    #[test]
    fn few_layers_move_the_near_border_outward() {
        let triangles = cuboid(DVec3::new(-6.0, -3.0, -60.0), DVec3::new(6.0, 3.0, -4.0));
        let all = framed(1.0, &triangles);
        let few = frame(&cell(1.0), &triangles, &Lens { max_layers: 20, ..LENS }, &Stop::default()).unwrap();
        assert!(all.layers.len() > 20 && few.layers.len() <= 20 && few.layers.len() > 15);
        assert!(few.borders[0] > all.borders[0]);
    }

    #[test]
    fn geometry_that_is_all_too_near_is_an_error() {
        let near = cuboid(DVec3::new(-1.0, -1.0, -1.4), DVec3::new(1.0, 1.0, -1.2));
        let error = frame(&cell(1.0), &near, &LENS, &Stop::default()).unwrap_err();
        assert_eq!(error, FrameError::AllNear);
        assert_eq!(frame(&cell(1.0), &[], &LENS, &Stop::default()), Err(FrameError::AllNear));
    }
}
