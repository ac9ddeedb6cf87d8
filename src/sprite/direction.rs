//! Along which direction to peel (section 4.1): the fewest layers, and of equals the most of the image used.

use super::{CubeFrame, PeelError};
use crate::{
    math::Stop,
    raster::{Backend, Geometry, Options, Prepared, fragments_in_tiles},
};
use glam::DVec3;

/// A direction in which rays run, with what is up in their image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    forward: DVec3,
    up: DVec3,
}

impl Direction {
    /// Up is +Y, or +Z where rays run along Y. `None` where `forward` has no direction.
    pub fn new(forward: DVec3) -> Option<Self> {
        let forward = forward.try_normalize()?;
        let up = if forward.cross(DVec3::Y).length_squared() < 1e-12 { DVec3::Z } else { DVec3::Y };
        let right = forward.cross(up).normalize();
        Some(Self { forward, up: right.cross(forward) })
    }

    /// Right, up and forward: orthonormal, right × up = −forward.
    pub fn axes(&self) -> [DVec3; 3] {
        [self.forward.cross(self.up), self.up, self.forward]
    }

    pub fn forward(&self) -> DVec3 {
        self.forward
    }

    /// `None` where the two are not orthonormal.
    pub fn from_parts(forward: DVec3, up: DVec3) -> Option<Self> {
        let unit = |v: DVec3| (v.length_squared() - 1.0).abs() < 1e-9;
        (unit(forward) && unit(up) && forward.dot(up).abs() < 1e-9).then_some(Self { forward, up })
    }
}

/// The axes of the paper's grid: its eye turns about the x and the y axis in steps of 360°/`segments`. Directions and their
/// opposites see the same layers, and many places of the grid are the same axis: each is given once.
pub fn candidates([horizontal, vertical]: [u32; 2]) -> Vec<Direction> {
    let mut found: Vec<Direction> = Vec::new();
    for h in 0..horizontal {
        for v in 0..vertical {
            let angle = |i: u32, n: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
            let (phi, theta) = (angle(h, horizontal), angle(v, vertical));
            let turned =
                DVec3::new(libm::sin(phi) * libm::cos(theta), -libm::sin(theta), -libm::cos(phi) * libm::cos(theta));
            let same = |d: &Direction| d.forward.dot(turned).abs() > 1.0 - 1e-9;
            if !found.iter().any(same) {
                found.extend(Direction::new(turned));
            }
        }
    }
    found
}

/// `count` axes spread over a hemisphere by the golden angle; the first runs along −Z.
pub fn spread(count: u32) -> Vec<Direction> {
    const GOLDEN: f64 = 2.399_963_229_728_653;
    let at = |i: u32| {
        let z = 1.0 - f64::from(i) / f64::from(count);
        let (r, turn) = ((1.0 - z * z).max(0.0).sqrt(), GOLDEN * f64::from(i));
        DVec3::new(r * libm::cos(turn), r * libm::sin(turn), -z)
    };
    (0..count).filter_map(|i| Direction::new(at(i))).collect()
}

/// What a direction would give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    pub direction: Direction,
    /// d: most crossings of a ray.
    pub depth_complexity: u32,
    /// o: share of the texels that hold any.
    pub coverage: f64,
}

/// Judges directions at `resolution`² texels; the best first, equals in their given order.
pub fn judge(
    backend: &dyn Backend,
    geometry: &Geometry,
    directions: &[Direction],
    resolution: u32,
    stop: &Stop,
) -> Result<Vec<Candidate>, PeelError> {
    let mut judged = Vec::with_capacity(directions.len());
    for direction in directions {
        let frame = CubeFrame::around(geometry, direction).ok_or(PeelError::Empty)?;
        let prepared = Prepared::new(geometry, &frame.view(resolution), &Options::BOTH, stop)?;
        let tiles = fragments_in_tiles(backend, &prepared, stop, |_, f| {
            let counts = f.offsets.windows(2).map(|o| o[1] - o[0]);
            (counts.clone().max().unwrap_or(0), counts.filter(|n| *n > 0).count())
        })?;
        let depth_complexity = tiles.iter().map(|t| t.0).max().unwrap_or(0);
        let covered: usize = tiles.iter().map(|t| t.1).sum();
        // What no ray meets is no way to see a solid.
        if depth_complexity > 0 {
            let coverage = covered as f64 / (f64::from(resolution) * f64::from(resolution));
            judged.push(Candidate { direction: *direction, depth_complexity, coverage });
        }
    }
    judged.sort_by(|a, b| a.depth_complexity.cmp(&b.depth_complexity).then(b.coverage.total_cmp(&a.coverage)));
    if judged.is_empty() { Err(PeelError::Missed(resolution)) } else { Ok(judged) }
}
