//! Prefetching (Chen et al. 2003, section 3.2): a timestamp that grows as the viewer moves, a queue of cells to read from the disk by
//! t-priority, and a queue of textures on their way from main memory to texture memory.
//!
//! The ground is the x–z plane, y is up; cells are prisms over it, so only x and z count. Nothing here reads a clock or a file: the same
//! calls give the same answers.

use crate::view::Pose;
use glam::{DVec2, DVec3};
use std::collections::{BTreeMap, VecDeque};

/// Entries whose t-priority is smaller than the timestamp minus this are out of date (section 3.2).
pub const STALE_AFTER: u64 = 2;

/// How far the viewer goes or turns before the timestamp grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stride {
    /// Metres, above 0.
    pub distance: f64,
    /// Radians, above 0.
    pub angle: f64,
}

/// The navigation system's timestamp: 0 at first, and 1 more whenever the viewer is a stride's distance away from where it last grew, or
/// looks by a stride's angle elsewhere than then. One pose adds 1 at most, however far it is: it asks for one set of cells.
#[derive(Clone, Debug)]
pub struct Timestamp {
    stride: Stride,
    since: Pose,
    now: u64,
}

impl Timestamp {
    pub fn new(start: Pose, stride: Stride) -> Self {
        Self { stride, since: start, now: 0 }
    }

    pub fn now(&self) -> u64 {
        self.now
    }

    /// Takes the viewer's next pose; whether the timestamp has grown.
    pub fn follow(&mut self, pose: &Pose) -> bool {
        let moved = pose.eye.distance(self.since.eye);
        let turned = angle(pose.aim, self.since.aim);
        let grows = moved >= self.stride.distance || turned >= self.stride.angle;
        if grows {
            self.since = *pose;
            self.now += 1;
        }
        grows
    }
}

/// Between two directions, radians, also where it is small.
fn angle(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}

/// What the priority of a cell depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Of the cell, metres; y does not count.
    pub centre: DVec3,
    /// Of a circle on the ground that holds the cell, metres, above 0.
    pub radius: f64,
}

/// How urgent a cell is, in [0, 1).
///
/// The paper gives only the order: cells in the view frustum above those outside, nearer to the aiming vector higher, nearer to the
/// viewer higher. The formula is ours: (v + q) / 2 with v = 1 in the frustum and 0 outside, and q = (2a + n) / 3, a little below 1 at
/// most; a = (1 + cos θ) / 2 with the angle θ between the aiming vector and the cell's centre, and n = r / (r + d) with the distance
/// d to the centre and the cell's radius r. So every cell in the frustum goes before every cell outside.
///
/// In the frustum is a cell whose circle meets the wedge of `fov` (horizontal, radians) around the aiming vector. Looking straight up or
/// down there is no such wedge: all cells count as seen, and a is 1/2.
pub fn priority(pose: &Pose, fov: f64, cell: &Footprint) -> f64 {
    let ground = |p: DVec3| DVec2::new(p.x, p.z);
    let (to, aim) = (ground(cell.centre - pose.eye), ground(pose.aim));
    let distance = to.length();
    let cos = match (aim.try_normalize(), to.try_normalize()) {
        (Some(aim), Some(to)) => aim.dot(to).clamp(-1.0, 1.0),
        (Some(_), None) => 1.0,
        (None, _) => 0.0,
    };
    let inside = distance <= cell.radius;
    let seen = inside
        || aim.try_normalize().is_none()
        || libm::acos(cos) - libm::asin((cell.radius / distance).min(1.0)) <= fov * 0.5;
    let nearness = cell.radius / (cell.radius + distance);
    let q = (2.0 * (0.5 + 0.5 * cos) + nearness) / 3.0;
    (f64::from(u8::from(seen)) + q.min(1.0 - 1e-6)) * 0.5
}

/// A cell that waits to be read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    pub cell: usize,
    /// The timestamp when it was asked for, plus its priority.
    pub t_priority: f64,
}

/// Cells that wait to be read, each once.
#[derive(Clone, Debug, Default)]
pub struct PrefetchQueue {
    waiting: BTreeMap<usize, f64>,
}

impl PrefetchQueue {
    /// Asks for a cell with a t-priority of `now` + `priority`; one that waits already takes the new t-priority.
    pub fn push(&mut self, cell: usize, now: u64, priority: f64) {
        self.waiting.insert(cell, now as f64 + priority);
    }

    /// Removes the entries that are out of date, t-priority < `now` − [`STALE_AFTER`], and returns their cells.
    pub fn drop_stale(&mut self, now: u64) -> Vec<usize> {
        let oldest = now as f64 - STALE_AFTER as f64;
        let stale: Vec<usize> = self.waiting.iter().filter(|(_, t)| **t < oldest).map(|(cell, _)| *cell).collect();
        stale.iter().for_each(|cell| {
            self.waiting.remove(cell);
        });
        stale
    }

    /// Takes the entry of the highest t-priority; of equals that of the smallest cell number.
    pub fn pop(&mut self) -> Option<Request> {
        let first = |a: &(&usize, &f64), b: &(&usize, &f64)| a.1.total_cmp(b.1).then(b.0.cmp(a.0));
        let (cell, t_priority) = self.waiting.iter().max_by(first).map(|(c, t)| (*c, *t))?;
        self.waiting.remove(&cell);
        Some(Request { cell, t_priority })
    }

    /// Removes the entries of cells that `keep` refuses.
    pub fn retain(&mut self, mut keep: impl FnMut(usize) -> bool) {
        self.waiting.retain(|cell, _| keep(*cell));
    }

    pub fn remove(&mut self, cell: usize) {
        self.waiting.remove(&cell);
    }

    pub fn len(&self) -> usize {
        self.waiting.len()
    }

    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }
}

/// A texture in main memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texture {
    pub cell: usize,
    /// Its number among the cell's textures.
    pub number: usize,
    pub bytes: u64,
}

/// What goes to texture memory before one frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Upload {
    /// In the order of the queue.
    pub textures: Vec<Texture>,
    pub bytes: u64,
    /// The first texture alone is larger than the whole budget; it was loaded nevertheless, and nothing else.
    pub over_budget: bool,
}

/// Textures on their way from main memory to texture memory, first in, first out.
#[derive(Clone, Debug, Default)]
pub struct TextureQueue {
    queue: VecDeque<Texture>,
}

impl TextureQueue {
    pub fn push(&mut self, texture: Texture) {
        self.queue.push_back(texture);
    }

    /// Takes the textures that go to texture memory before a frame, of at most `budget` bytes.
    ///
    /// A texture that is not the frame's first and is larger than what remains of the budget is put back as the first, and the frame has
    /// had its share (section 3.2). So it is the next frame's first, which is loaded whatever its size: a texture larger than the whole
    /// budget is loaded alone, and the answer says so. It would wait forever otherwise, and all behind it.
    pub fn upload(&mut self, budget: u64) -> Upload {
        let mut upload = Upload::default();
        while let Some(texture) = self.queue.pop_front() {
            let first = upload.textures.is_empty();
            if !first && (upload.over_budget || texture.bytes > budget - upload.bytes) {
                self.queue.push_front(texture);
                break;
            }
            upload.bytes = upload.bytes.saturating_add(texture.bytes);
            upload.over_budget |= texture.bytes > budget;
            upload.textures.push(texture);
        }
        upload
    }

    /// Removes the textures of cells that `keep` refuses; the others keep their order.
    pub fn retain(&mut self, mut keep: impl FnMut(usize) -> bool) {
        self.queue.retain(|t| keep(t.cell));
    }

    pub fn len(&self) -> usize {
        self.queue.len()
    }

    pub fn is_empty(&self) -> bool {
        self.queue.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_3, PI};

    fn pose(x: f64, z: f64, turn: f64) -> Pose {
        Pose { eye: DVec3::new(x, 1.7, z), aim: DVec3::new(libm::sin(turn), 0.0, -libm::cos(turn)) }
    }

    #[test]
    fn the_timestamp_counts_strides_and_turns() {
        let mut stamp = Timestamp::new(pose(0.0, 0.0, 0.0), Stride { distance: 5.0, angle: 0.2 });
        assert_eq!(stamp.now(), 0);
        assert!(!stamp.follow(&pose(4.9, 0.0, 0.0)) && !stamp.follow(&pose(4.9, 0.0, 0.19)));
        assert!(stamp.follow(&pose(5.0, 0.0, 0.19)), "moved by the distance");
        // Both are measured from there.
        assert!(!stamp.follow(&pose(9.0, 0.0, 0.38)));
        assert!(stamp.follow(&pose(9.0, 0.0, 0.40)), "turned by the angle");
        assert_eq!(stamp.now(), 2);
        assert!(!stamp.follow(&pose(9.0, 0.0, 0.40)), "a viewer who stands needs nothing new");
        assert!(stamp.follow(&pose(900.0, 0.0, 0.40)));
        assert_eq!(stamp.now(), 3, "a leap is one step");
    }

    #[test]
    fn priorities_follow_the_papers_order() {
        let at = |turn: f64, distance: f64| {
            let p = pose(distance, 0.0, 0.0);
            let centre = p.eye + DVec3::new(libm::sin(turn), 0.0, -libm::cos(turn)) * distance;
            priority(&p, FRAC_PI_3, &Footprint { centre, radius: 50.0 })
        };
        // In the frustum above outside, however near the one outside is.
        assert!(at(0.0, 1e6) > at(PI, 51.0) && at(FRAC_PI_3 * 0.5, 1e5) > at(FRAC_PI_3, 100.0));
        // A cell whose circle only just meets the wedge is seen.
        let half = libm::asin(0.5);
        assert!(at(FRAC_PI_3 * 0.5 + half - 1e-6, 100.0) >= 0.5 && at(FRAC_PI_3 * 0.5 + half + 1e-6, 100.0) < 0.5);
        let falling = |values: &[f64]| values.windows(2).all(|w| w[0] > w[1]);
        // Nearer to the aiming vector, then nearer to the viewer, on both sides of the border.
        assert!(falling(&[at(0.0, 100.0), at(0.2, 100.0), at(-0.4, 100.0), at(1.5, 100.0), at(PI, 100.0)]));
        assert!(falling(&[at(0.1, 60.0), at(0.1, 90.0), at(0.1, 500.0)]));
        assert!(falling(&[at(3.0, 60.0), at(3.0, 90.0), at(3.0, 500.0)]));
        for turn in [0.0, 1.0, PI] {
            for distance in [0.0, 1e-9, 1.0, 50.0, 1e9] {
                assert!((0.0..1.0).contains(&at(turn, distance)), "{turn} {distance}");
            }
        }
        // Looking down, all are seen alike, whatever their direction.
        let down = Pose { aim: DVec3::NEG_Y, ..pose(0.0, 0.0, 0.0) };
        let of = |x: f64| priority(&down, 1.0, &Footprint { centre: DVec3::new(x, 0.0, 0.0), radius: 50.0 });
        assert!(of(100.0) == of(-100.0) && of(100.0) >= 0.5);
    }

    #[test]
    fn the_highest_t_priority_is_read_first() {
        let mut queue = PrefetchQueue::default();
        for (cell, now, priority) in [(4, 1, 0.9), (2, 2, 0.1), (7, 2, 0.6), (5, 2, 0.6), (9, 0, 0.99)] {
            queue.push(cell, now, priority);
        }
        let order: Vec<usize> = std::iter::from_fn(|| queue.pop()).map(|r| r.cell).collect();
        assert_eq!(order, [5, 7, 2, 4, 9], "a later timestamp goes before any priority");
        // Asked for again, a cell waits once, with the new t-priority.
        queue.push(1, 0, 0.9);
        queue.push(3, 1, 0.5);
        queue.push(1, 1, 0.2);
        assert_eq!(queue.len(), 2);
        assert_eq!(queue.pop(), Some(Request { cell: 3, t_priority: 1.5 }));
        assert_eq!(queue.pop(), Some(Request { cell: 1, t_priority: 1.2 }));
        assert!(queue.is_empty());
    }

    #[test]
    fn what_is_out_of_date_is_dropped() {
        let mut queue = PrefetchQueue::default();
        queue.push(0, 0, 0.99);
        queue.push(1, 1, 0.0);
        queue.push(2, 2, 0.5);
        assert_eq!(queue.drop_stale(2), [0usize; 0]);
        assert_eq!(queue.drop_stale(3), [0], "0.99 < 3 − 2; 1 is not below 1");
        assert_eq!(queue.drop_stale(4), [1]);
        assert_eq!(queue.drop_stale(5), [2]);
    }

    fn textures(sizes: &[u64]) -> TextureQueue {
        let mut queue = TextureQueue::default();
        for (number, bytes) in sizes.iter().enumerate() {
            queue.push(Texture { cell: number % 3, number, bytes: *bytes });
        }
        queue
    }

    /// Uploads until nothing is left.
    fn frames(sizes: &[u64], budget: u64) -> Vec<Upload> {
        let mut queue = textures(sizes);
        std::iter::from_fn(|| (!queue.is_empty()).then(|| queue.upload(budget))).take(100).collect()
    }

    #[test]
    fn textures_keep_their_order_and_the_budget() {
        let sizes = [40, 60, 1, 99, 30, 30, 30, 30, 100, 1, 250, 5, 5];
        let all = frames(&sizes, 100);
        let order: Vec<usize> = all.iter().flat_map(|u| &u.textures).map(|t| t.number).collect();
        assert_eq!(order, (0..sizes.len()).collect::<Vec<_>>());
        for upload in &all {
            assert_eq!(upload.bytes, upload.textures.iter().map(|t| t.bytes).sum::<u64>());
            assert_eq!(upload.over_budget, upload.bytes > 100);
            assert!(upload.bytes <= 100 || upload.textures.len() == 1);
        }
        let numbers: Vec<Vec<u64>> = all.iter().map(|u| u.textures.iter().map(|t| t.bytes).collect()).collect();
        assert_eq!(numbers[0], [40, 60]);
        assert_eq!(numbers[1], [1, 99]);
        assert_eq!(numbers[2], [30, 30, 30]);
        // 100 does not fit behind 30 and is not overtaken by 1, which would fit.
        assert_eq!(numbers[3..], [vec![30], vec![100], vec![1], vec![250], vec![5, 5]]);
    }

    #[test]
    fn a_budget_of_nothing_is_one_texture_a_frame() {
        let all = frames(&[7, 0, 9], 0);
        assert_eq!(all.iter().map(|u| u.bytes).collect::<Vec<_>>(), [7, 0, 9]);
        assert_eq!(all.iter().map(|u| u.over_budget).collect::<Vec<_>>(), [true, false, true]);
        let huge = frames(&[u64::MAX, u64::MAX, 1], 10);
        assert_eq!(huge.len(), 3, "sums do not overflow");
    }

    #[test]
    fn textures_of_dropped_cells_leave_the_queue() {
        let mut queue = textures(&[1, 2, 3, 4, 5, 6]);
        queue.retain(|cell| cell != 1);
        assert_eq!(queue.len(), 4);
        assert_eq!(queue.upload(100).textures.iter().map(|t| t.bytes).collect::<Vec<_>>(), [1, 3, 4, 6]);
    }
}
