//! A walk through view cells: what each frame shows, and what changes where the walker enters another cell (Chen et al. 2003, section 4).

use super::{directions::Sheet, rounded};
use crate::{
    image::{
        Picture,
        measure::{luminances, psnr, psnr_within},
    },
    math::{Aabb, Stopped},
    raster::{Geometry, Rendering},
    runtime::{Context, SceneStandIn, Shot, StandIn},
    scene::Scene,
    view::{Pose, View},
};
use glam::DVec3;
use serde::Serialize;

/// How somebody walks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Metres a second, > 0.
    pub speed: f64,
    /// Radians a second, > 0.
    pub turn: f64,
    /// Seconds between frames, > 0.
    pub step: f64,
}

/// Frames in a row at most.
const MOST_FRAMES: usize = 1_000_000;

/// The poses of a walk along straight lines, at least one point; aiming vectors are unit vectors along the ground. The walker looks where it goes: at a corner it
/// stops and turns at its rate.
pub fn poses(path: &[DVec3], pace: &Pace) -> Vec<Pose> {
    let flat = |d: DVec3| DVec3::new(d.x, 0.0, d.z).try_normalize();
    let Some(first) = path.first() else { return Vec::new() };
    let mut heading = path.windows(2).find_map(|p| flat(p[1] - p[0])).unwrap_or(DVec3::NEG_Z);
    let mut out = vec![Pose { eye: *first, aim: heading }];
    // Seconds until the next frame.
    let mut left = pace.step;
    for pair in path.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let goal = flat(to - from).unwrap_or(heading);
        let angle = libm::atan2(heading.cross(goal).y, heading.dot(goal));
        let start = heading;
        for (seconds, moving) in [(angle.abs() / pace.turn, false), (from.distance(to) / pace.speed, true)] {
            let mut at = left;
            while at <= seconds && out.len() < MOST_FRAMES {
                let pose = if moving {
                    Pose { eye: from.lerp(to, at / seconds), aim: goal }
                } else {
                    Pose { eye: from, aim: glam::DQuat::from_rotation_y(angle * at / seconds) * start }
                };
                out.push(pose);
                at += pace.step;
            }
            left = at - seconds;
            heading = goal;
        }
    }
    out
}

/// A frame to be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    pub view: View,
    /// The cell that the eye is in.
    pub cell: usize,
}

/// What one frame shows.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FrameFigures {
    /// Of luminance, over the whole picture as in the paper, dB.
    pub psnr_y_db: f64,
    /// Over pixels that original or stand-in cover, dB; nothing where there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr_y_object_db: Option<f64>,
    /// Pixels of the original.
    pub covered: u64,
    /// Pixels of it that the stand-in does not cover, and the reverse.
    pub missing: u64,
    pub extra: u64,
    /// No hole is wider, pixels: where the stand-in shows nothing of what the original does, or what lies far behind it.
    pub hole_px: u32,
    /// Triangles of objects whose bounds meet the view: of what is drawn, and of the original.
    pub triangles: u64,
    pub original_triangles: u64,
    /// Where the frame before was in another cell: how this view differs from the one that the other cell's stand-ins would show.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub popping: Option<Popping>,
}

/// What a change of the cell does to one view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Popping {
    /// Between the two cells' pictures.
    pub psnr_y_db: f64,
    /// Share of the pixels that either covers whose luminance changes by more than 32 of 255.
    pub share: f64,
}

/// A change of luminance that is seen.
const SEEN: f32 = 32.0;
/// What is so many times as far away as the original's surface lies behind it.
const BEHIND: f32 = 1.1;

/// What a walk gives.
#[derive(Clone, Debug, Default)]
pub struct Walked {
    pub frames: Vec<FrameFigures>,
    /// Original, stand-in and difference of the frame of least PSNR.
    pub worst: Option<(usize, Picture)>,
    /// The same of the frame in the middle of the walk.
    pub middle: Option<Picture>,
}

/// A scene made ready, with what tells which objects a view meets.
struct Ready<'a> {
    drawn: SceneStandIn<'a>,
    boxes: Vec<(Aabb, u64)>,
}

impl<'a> Ready<'a> {
    fn new(scene: &Scene, geometry: &'a Geometry) -> Self {
        let boxes = scene.objects.iter().map(|o| (o.bounds(), o.triangle_count() as u64)).collect();
        Self { drawn: SceneStandIn::new(scene, geometry), boxes }
    }

    fn triangles(&self, view: &View) -> u64 {
        self.boxes.iter().filter(|(b, _)| meets(view, b)).map(|b| b.1).sum()
    }
}

/// Whether a box may be seen: no side of the frustum has all of its corners outside.
fn meets(view: &View, b: &Aabb) -> bool {
    if b.is_empty() {
        return false;
    }
    let corners = b.corners().map(|c| {
        let d = c - view.eye;
        DVec3::new(d.dot(view.right), d.dot(view.up), d.dot(view.forward))
    });
    let (crate::view::Projection::Perspective { left, right, bottom, top }
    | crate::view::Projection::Orthographic { left, right, bottom, top }) = view.projection;
    let outside: [&dyn Fn(&DVec3) -> bool; 5] =
        [&|c| c.z <= 0.0, &|c| c.x < left * c.z, &|c| c.x > right * c.z, &|c| c.y < bottom * c.z, &|c| c.y > top * c.z];
    !outside.iter().any(|o| corners.iter().all(*o))
}

/// Why a walk ended.
#[derive(Debug, thiserror::Error)]
pub enum WalkError<E> {
    /// The scene of a cell could not be had.
    #[error(transparent)]
    Cell(E),
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// Draws `frames` of the original and of what `scene_of` gives for each frame's cell: its stand-ins and the objects that are drawn as they are. `progress` is told
/// how many frames of how many are done.
///
/// # Errors
/// What `scene_of` returns; where it is stopped.
pub fn walk<E>(
    original: &Scene,
    frames: &[Frame],
    scene_of: &dyn Fn(usize) -> Result<Scene, E>,
    how: &Rendering,
    context: Context,
    progress: &dyn Fn(u64, u64),
) -> Result<Walked, WalkError<E>> {
    let geometry = Geometry::new(original);
    let original = Ready::new(original, &geometry);
    let mut out = Walked::default();
    let mut worst = f64::INFINITY;
    // What the cell before shows of the first frame of the next.
    let mut before: Option<(Picture, Vec<bool>)> = None;
    let mut start = 0;
    while start < frames.len() {
        let cell = frames[start].cell;
        let end = start + frames[start..].iter().take_while(|f| f.cell == cell).count();
        let scene = scene_of(cell).map_err(WalkError::Cell)?;
        let geometry = Geometry::new(&scene);
        let here = Ready::new(&scene, &geometry);
        for (i, Frame { view, .. }) in frames.iter().enumerate().take(end).skip(start) {
            let (a, b) = (original.drawn.draw(view, how, context)?, here.drawn.draw(view, how, context)?);
            let mut figures = compare(&a, &b);
            figures.triangles = here.triangles(view);
            figures.original_triangles = original.triangles(view);
            figures.popping = before.take().map(|(picture, seen)| popping(&picture, &seen, &b));
            if i == frames.len() / 2 {
                out.middle = Some(Sheet::of(&a, &b).picture());
            }
            if figures.psnr_y_db < worst {
                worst = figures.psnr_y_db;
                out.worst = Some((i, Sheet::of(&a, &b).picture()));
            }
            out.frames.push(figures);
            progress(i as u64 + 1, frames.len() as u64);
        }
        if let Some(next) = frames.get(end) {
            let shot = here.drawn.draw(&next.view, how, context)?;
            before = Some((shot.picture.clone(), covered(&shot)));
        }
        start = end;
    }
    Ok(out)
}

fn popping(before: &Picture, seen: &[bool], after: &Shot) -> Popping {
    let (a, b) = (luminances(before), luminances(&after.picture));
    let either: Vec<bool> = seen.iter().zip(covered(after)).map(|(a, b)| *a || b).collect();
    let changed = (0..a.len()).filter(|i| either[*i] && (a[*i] - b[*i]).abs() > SEEN).count();
    let all = either.iter().filter(|e| **e).count().max(1);
    Popping { psnr_y_db: rounded(psnr(&a, &b), 3), share: rounded(changed as f64 / all as f64, 6) }
}

fn covered(shot: &Shot) -> Vec<bool> {
    shot.depth.iter().map(|z| z.is_finite()).collect()
}

fn compare(a: &Shot, b: &Shot) -> FrameFigures {
    let (ya, yb) = (luminances(&a.picture), luminances(&b.picture));
    let (ca, cb) = (covered(a), covered(b));
    let either: Vec<bool> = ca.iter().zip(&cb).map(|(a, b)| *a || *b).collect();
    let hole = |(za, zb): (&f32, &f32)| za.is_finite() && *zb > za * BEHIND;
    let holes: Vec<bool> = a.depth.iter().zip(b.depth.iter()).map(hole).collect();
    let count = |what: (bool, bool)| ca.iter().zip(&cb).filter(|(a, b)| (**a, **b) == what).count() as u64;
    FrameFigures {
        psnr_y_db: rounded(psnr(&ya, &yb), 3),
        psnr_y_object_db: psnr_within(&ya, &yb, &either).map(|d| rounded(d, 3)),
        covered: ca.iter().filter(|c| **c).count() as u64,
        missing: count((true, false)),
        extra: count((false, true)),
        hole_px: width(holes, a.picture.width as usize),
        ..FrameFigures::default()
    }
}

/// The width of the widest part of a mask, even: twice as often as its outer pixels can be taken away.
fn width(mut mask: Vec<bool>, width: usize) -> u32 {
    let mut times = 0;
    while mask.contains(&true) {
        // What the frame cuts off goes on.
        let set = |i: Option<usize>| i.and_then(|i| mask.get(i)).is_none_or(|m| *m);
        let inner = |i: usize| {
            let (left, right) = ((!i.is_multiple_of(width)).then(|| i - 1), (i % width + 1 < width).then_some(i + 1));
            mask[i] && [left, right, i.checked_sub(width), Some(i + width)].into_iter().all(set)
        };
        let next: Vec<bool> = (0..mask.len()).map(inner).collect();
        if next == mask {
            // Nothing but holes.
            return width as u32;
        }
        mask = next;
        times += 2;
    }
    times
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{math::Stop, raster::Cpu, scene::builtin};

    const PACE: Pace = Pace { speed: 2.0, turn: 1.0, step: 0.25 };

    #[test]
    fn walkers_keep_their_pace() {
        let path = [DVec3::ZERO, DVec3::X * 3.0, DVec3::new(3.0, 0.0, 4.0)];
        let poses = poses(&path, &PACE);
        let turn = std::f64::consts::FRAC_PI_2;
        // 1.5 s, a quarter turn of 1.57 s, 2 s.
        assert_eq!(poses.len(), ((1.5 + turn + 2.0) / 0.25) as usize + 1);
        for pair in poses.windows(2) {
            assert!(pair[0].eye.distance(pair[1].eye) <= 0.5 + 1e-9);
            let angle = pair[0].aim.angle_between(pair[1].aim);
            assert!(angle <= 0.25 + 1e-9, "{angle}");
            assert!((pair[1].aim.length() - 1.0).abs() < 1e-12);
        }
        assert_eq!(poses.last().map(|p| p.aim), Some(DVec3::Z));
        assert_eq!(super::poses(&[DVec3::ONE], &PACE).len(), 1);
    }

    #[test]
    fn holes_are_as_wide_as_their_widest_part() {
        // A line one pixel wide, a square of five, and a strip along the frame.
        let mask = |kind: u32| -> Vec<bool> {
            let set = |i: u32| {
                let (x, y) = (i % 16, i / 16);
                match kind {
                    0 => false,
                    1 => y == 3,
                    2 => (4..9).contains(&x) && (2..7).contains(&y),
                    3 => x < 3,
                    _ => true,
                }
            };
            (0..256).map(set).collect()
        };
        assert_eq!([0, 1, 2, 3, 4].map(|kind| width(mask(kind), 16)), [0, 2, 6, 6, 16]);
    }

    #[test]
    fn the_original_in_its_own_place_differs_nowhere() {
        let scene = builtin::make("solids", 1).unwrap();
        let b = scene.bounds();
        let view = |x: f64| {
            let eye = b.centre() + DVec3::new(x, 0.0, b.diagonal());
            View::look_at(eye, eye - DVec3::Z, DVec3::Y, 1.0, 64, 64, 0.01, 1e3)
        };
        let frames: Vec<Frame> = (0..4).map(|i| Frame { view: view(0.1 * i as f64), cell: i / 2 }).collect();
        let stop = Stop::default();
        let context = Context { backend: &Cpu, stop: &stop };
        // The second cell lacks an object.
        let scene_of = |cell: usize| {
            let objects = scene.objects[..scene.objects.len() - cell].to_vec();
            Ok::<_, std::convert::Infallible>(Scene { objects })
        };
        let walked = walk(&scene, &frames, &scene_of, &Rendering::default(), context, &|_, _| {}).unwrap();
        let [a, b, c, d] = &walked.frames[..] else { panic!("four frames") };
        for same in [a, b] {
            assert_eq!((same.missing, same.extra, same.psnr_y_db, same.popping), (0, 0, 100.0, None));
            assert_eq!(same.hole_px, 0);
            assert_eq!(same.triangles, same.original_triangles);
        }
        let popping = c.popping.unwrap();
        assert!(c.hole_px > 4, "an object is missing: {}", c.hole_px);
        assert!(c.missing > 0 && c.triangles < c.original_triangles && popping.psnr_y_db == c.psnr_y_db, "{c:?}");
        assert!(d.popping.is_none() && walked.worst.is_some() && walked.middle.is_some());
        let fails = |_| Err::<Scene, &str>("gone");
        assert!(matches!(
            walk(&scene, &frames, &fails, &Rendering::default(), context, &|_, _| {}),
            Err(WalkError::Cell("gone"))
        ));
    }
}
