//! Occlusion culling by region: which objects no point of a cell can see (Chen et al. 2003, section 3.1.7).
//!
//! The paper leaves the method open and names extended projections (Durand et al. 2000). This is another one, which uses that occluders are meshes. Let
//! d(ω) be the distance of the first surface in direction ω from the cell's centre O, and P a point behind it: |P| > d. Walk from P towards an eye E of
//! the cell. The walk begins behind the first surface and ends before it, for no occluder reaches into the cell. So it meets the surface, and E does not see
//! P, unless d jumps where the walk passes: from a near surface at depth a to a far one, while the walk is between. It jumps at borders of
//! surfaces only ([`Patches`]), and a walk that is no nearer than a deviates from P's place in the picture by at most
//!
//! (e − s·e_z) · (Z − a) / (a·(Z − e_z))
//!
//! units of the tangent, for an eye (e, e_z) in the camera's frame, P at tangents s and depth Z. So P is hidden from the whole cell if
//! it is hidden from the centre and no visible border lies so near to it in the centre's picture. The deviation is largest at the cell's corners and at
//! P's greatest depth. Where one occluder ends before another, its border counts as a gap between them, though the other may go on behind it.
//!
//! Depths are sampled at pixels; borders are drawn as lines through all pixels that they touch, so that a gap between two samples is no surface.

use super::{
    occluder::{Opaque, Patches},
    outline::Outline,
    subject::Placement,
    window::focal,
};
use crate::{
    math::{Stop, Stopped},
    raster::{Backend, Geometry, Nearest, Options, nearest},
    scene::{Material, Mesh, Object, Part, Scene},
    view::{Prism, Projection, View},
};
use glam::{DVec3, Mat4};
use std::{f64::consts::PI, sync::Arc};

/// Pictures around the centre. Objects whose middle lies within 30° of a picture's axis are looked for in it.
pub(super) const HEADINGS: u32 = 6;
/// Tangents that the pictures show: 51° to the sides, 31° below and 45° above the horizon.
const SIDE: f64 = 1.25;
const BELOW: f64 = 0.6;
const ABOVE: f64 = 1.0;
/// Pixels by which places in a picture may be wrong: borders are known to half a step along a line and to a pixel beside it.
const SLACK: f64 = 2.0;
/// Share of its depth by which a surface may be deeper between pixels than at them.
const DEEPER: f32 = 1e-3;

/// Whether each of `objects` may be seen from `cell`. Hidden ones stand outside it. `image_res`: pixels along a side of a picture of 60°; a coarser
/// picture finds fewer objects hidden, never more.
///
/// # Errors
/// Where it is stopped.
pub fn visible(
    backend: &dyn Backend,
    cell: &Prism,
    objects: &[(&Placement, &Opaque)],
    image_res: f64,
    stop: &Stop,
) -> Result<Vec<bool>, Stopped> {
    let local = Prism { centre: DVec3::ZERO, ..*cell };
    let outlines: Vec<Option<Outline>> = objects
        .iter()
        .map(|(p, _)| p.outline.as_ref().map(|o| o.about(cell.centre)).filter(|o| !o.meets(&local)))
        .collect();
    let reach = outlines.iter().flatten().flat_map(Outline::corners).map(|c| c.length()).fold(0.0, f64::max);
    let mut patches: Vec<Patches> = Vec::new();
    for ((placement, shape), outline) in objects.iter().zip(&outlines) {
        if outline.as_ref().is_some_and(|o| casts_umbra(o, cell.size, reach)) {
            stop.check()?;
            let mut place = placement.transform;
            place.translation -= cell.centre;
            patches.push(shape.towards(&place, &local.corners()));
        }
    }
    let mut seen = vec![true; objects.len()];
    if patches.is_empty() {
        return Ok(seen);
    }
    let scene = occluders(&patches);
    let geometry = Geometry::new(&scene);
    for heading in 0..HEADINGS {
        let view = picture(heading, image_res, reach);
        let looked_for: Vec<(usize, Target)> = outlines
            .iter()
            .enumerate()
            .filter_map(|(i, o)| Some((i, Target::of(o.as_ref()?, &view, &local)?)))
            .collect();
        if looked_for.is_empty() {
            continue;
        }
        let depths = Depths(nearest(backend, &geometry, &view, &Options::default(), stop)?);
        let borders = depths.borders(&view, &patches);
        for (i, target) in looked_for {
            stop.check()?;
            seen[i] = !depths.hide(&target) || borders.iter().any(|b| target.may_be_seen_past(b));
        }
    }
    Ok(seen)
}

/// Whether an outline is wide enough to hide anything from a cell of a size: the shadows that it casts from opposite sides of the cell meet
/// before `reach`, where the scene ends.
fn casts_umbra(outline: &Outline, size: f64, reach: f64) -> bool {
    let plan = &outline.plan;
    let width = plan.iter().flat_map(|a| plan.iter().map(|b| a.distance(*b))).fold(0.0, f64::max);
    // A hexagon is nowhere narrower than from side to side.
    width > 3.0_f64.sqrt() * size * (1.0 - outline.nearest() / reach)
}

/// The patches as an object about the cell's centre.
fn occluders(patches: &[Patches]) -> Scene {
    let material = Arc::new(Material::default());
    let part = |p: &Patches| {
        let mesh = Mesh {
            positions: p.positions.iter().map(|p| p.as_vec3().to_array()).collect(),
            triangles: p.triangles.iter().copied().collect(),
            ..Mesh::default()
        };
        Part { mesh: Arc::new(mesh), material: material.clone() }
    };
    let object =
        Object { name: "occluders".into(), transform: Mat4::IDENTITY, parts: patches.iter().map(part).collect() };
    Scene { objects: vec![object] }
}

/// The picture around one heading.
pub(super) fn picture(heading: u32, image_res: f64, reach: f64) -> View {
    let focal = focal(image_res);
    let angle = f64::from(heading) * PI * 2.0 / f64::from(HEADINGS);
    let forward = DVec3::new(libm::sin(angle), 0.0, -libm::cos(angle));
    let (width, height) = ((2.0 * SIDE * focal).ceil(), ((BELOW + ABOVE) * focal).ceil());
    let side = 0.5 * width / focal;
    View {
        eye: DVec3::ZERO,
        right: forward.cross(DVec3::Y),
        up: DVec3::Y,
        forward,
        projection: Projection::Perspective { left: -side, right: side, bottom: ABOVE - height / focal, top: ABOVE },
        width: width as u32,
        height: height as u32,
        near: reach * 1e-6,
        far: reach * 2.0,
    }
}

/// Pixels per unit of the tangent.
fn scale(view: &View) -> f64 {
    match view.projection {
        Projection::Perspective { left, right, .. } => f64::from(view.width) / (right - left),
        Projection::Orthographic { .. } => unreachable!("these pictures are in perspective"),
    }
}

/// A border in a pixel, and the depth of what ends there.
struct Border {
    x: u32,
    y: u32,
    depth: f64,
}

/// Where an object is in a picture.
struct Target {
    /// Pixels, at the left and at the top, at the right and at the bottom.
    min: [f64; 2],
    max: [f64; 2],
    near: f64,
    far: f64,
    /// Pixels by which a walk deviates, before the factor (Z − a) / a: to the right and downwards, least and most.
    least: [f64; 2],
    most: [f64; 2],
}

impl Target {
    /// `None` where it belongs to another picture, or where this one does not hold all of it.
    fn of(outline: &Outline, view: &View, cell: &Prism) -> Option<Self> {
        let middle = outline.centre();
        let (ahead, aside) = (middle.dot(view.forward), middle.dot(view.right).abs());
        if ahead <= 0.0 || aside > ahead * 0.578 {
            return None;
        }
        let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let (mut near, mut far) = (f64::INFINITY, 0.0_f64);
        for corner in outline.corners() {
            let z = corner.dot(view.forward);
            if z <= cell.size {
                return None;
            }
            let (x, y, _) = view.project(corner);
            for (k, v) in [x, y].into_iter().enumerate() {
                (min[k], max[k]) = (min[k].min(v), max[k].max(v));
            }
            (near, far) = (near.min(z), far.max(z));
        }
        let size = [f64::from(view.width), f64::from(view.height)];
        if (0..2).any(|k| min[k] < SLACK || max[k] > size[k] - SLACK) {
            return None;
        }
        let focal = scale(view);
        // Tangents of the ends: the principal point is where the axis meets the picture.
        let (cx, cy, _) = view.project(view.forward);
        let tangents = [[min[0] - cx, max[0] - cx], [cy - max[1], cy - min[1]]].map(|t| t.map(|p| p / focal));
        let (mut least, mut most) = ([0.0_f64; 2], [0.0_f64; 2]);
        for e in cell.corners() {
            let [x, y, z] = [e.dot(view.right), e.dot(view.up), e.dot(view.forward)];
            for (k, e) in [x, y].into_iter().enumerate() {
                for s in tangents[k] {
                    let deviation = (e - s * z) / (far - z) * focal;
                    let down = if k == 0 { deviation } else { -deviation };
                    (least[k], most[k]) = (least[k].min(down), most[k].max(down));
                }
            }
        }
        Some(Self { min, max, near, far, least, most })
    }

    /// Whether a walk from the object may pass the border on its far side.
    fn may_be_seen_past(&self, border: &Border) -> bool {
        let factor = (self.far - border.depth) / border.depth;
        let at = [f64::from(border.x) + 0.5, f64::from(border.y) + 0.5];
        factor > 0.0
            && (0..2).all(|k| {
                at[k] - factor * self.most[k] <= self.max[k] + SLACK
                    && at[k] - factor * self.least[k] >= self.min[k] - SLACK
            })
    }
}

/// The depths of occluders in a picture.
struct Depths(Nearest);

impl Depths {
    /// The greatest depth in a pixel and those around it; infinite where one of them shows nothing or lies outside.
    fn greatest(&self, x: i64, y: i64) -> f32 {
        let (w, h) = (i64::from(self.0.width), i64::from(self.0.height));
        if x < 1 || y < 1 || x + 1 >= w || y + 1 >= h {
            return f32::INFINITY;
        }
        let row = |y: i64| (y * w + x - 1) as usize..(y * w + x + 2) as usize;
        (y - 1..=y + 1).flat_map(|y| &self.0.depth[row(y)]).fold(0.0, |a, b| a.max(*b))
    }

    /// Whether the centre sees nothing of an object.
    fn hide(&self, target: &Target) -> bool {
        let [(x0, x1), (y0, y1)] = [0, 1].map(|k| (target.min[k].floor() as i64, target.max[k].ceil() as i64));
        (y0..=y1).all(|y| (x0..=x1).all(|x| f64::from(self.greatest(x, y)) < target.near))
    }

    /// Borders that may be visible: one for each pixel, with the least depth. At the picture's frame surfaces end too, for nothing is known
    /// beyond it.
    fn borders(&self, view: &View, patches: &[Patches]) -> Vec<Border> {
        let (w, h) = (self.0.width, self.0.height);
        let mut least = vec![f32::INFINITY; w as usize * h as usize];
        for patch in patches {
            for [a, b] in &patch.edges {
                line(view, patch.positions[*a as usize], patch.positions[*b as usize], &mut |x, y, depth| {
                    let at = &mut least[y as usize * w as usize + x as usize];
                    *at = at.min(depth as f32);
                });
            }
        }
        let mut out = Vec::new();
        for y in 0..h {
            for x in 0..w {
                let at = y as usize * w as usize + x as usize;
                let frame = x < 2 || y < 2 || x + 2 >= w || y + 2 >= h;
                let depth = if frame { least[at].min(self.0.depth[at]) } else { least[at] };
                // Hidden borders are those behind surfaces that go on around them. Between samples a surface may be a little deeper.
                if depth.is_finite() && depth <= self.greatest(x.into(), y.into()) * (1.0 + DEEPER) {
                    // A depth between two pixels is as near as the nearest of both.
                    out.push(Border { x, y, depth: f64::from(depth) * (1.0 - 1e-6) });
                }
            }
        }
        out
    }
}

/// Calls `mark` for the pixels that the line from `a` to `b` passes, with depths that are not greater than the line's there.
fn line(view: &View, a: DVec3, b: DVec3, mark: &mut dyn FnMut(u32, u32, f64)) {
    let depth = |p: DVec3| p.dot(view.forward);
    let (za, zb) = (depth(a), depth(b));
    if za.max(zb) <= view.near {
        return;
    }
    let cut = |p: DVec3, q: DVec3| p + (q - p) * ((view.near - depth(p)) / (depth(q) - depth(p)));
    let (a, b) = (if za < view.near { cut(a, b) } else { a }, if zb < view.near { cut(b, a) } else { b });
    let ((xa, ya, za), (xb, yb, zb)) = (view.project(a), view.project(b));
    let (w, h) = (f64::from(view.width), f64::from(view.height));
    // The part within the picture.
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for (p, d, size) in [(xa, xb - xa, w), (ya, yb - ya, h)] {
        if d == 0.0 {
            if p < 0.0 || p >= size {
                return;
            }
        } else {
            let (s, t) = (-p / d, (size - p) / d);
            (from, to) = (from.max(s.min(t)), to.min(s.max(t)));
        }
    }
    if from > to {
        return;
    }
    let steps = (2.0 * (to - from) * libm::hypot(xb - xa, yb - ya)).ceil().max(1.0);
    // Inverse depth is linear along the picture.
    let inverse = |t: f64| 1.0 / za + (1.0 / zb - 1.0 / za) * t.clamp(0.0, 1.0);
    let step = (to - from) / steps;
    for i in 0..=steps as u64 {
        let t = from + step * i as f64;
        let (x, y) = (xa + (xb - xa) * t, ya + (yb - ya) * t);
        if (0.0..w).contains(&x) && (0.0..h).contains(&y) {
            mark(x as u32, y as u32, 1.0 / inverse(t - step).max(inverse(t + step)));
        }
    }
}
