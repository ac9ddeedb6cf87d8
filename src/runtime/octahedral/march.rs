//! A ray's way through a frame: a relief map that shows its surface from one side.

use super::sample::Frame;
use glam::{DVec2, DVec3};

/// A frame of a view.
pub(super) struct Tilted<'a> {
    pub frame: Frame<'a>,
    pub weight: f32,
    pub direction: DVec3,
    pub right: DVec3,
    pub up: DVec3,
}

/// A ray as a frame sees it.
pub(super) struct Ray {
    /// Where it begins, from the centre of the windows, metres.
    pub start: DVec3,
    pub ray: DVec3,
    /// Its parameter on the plane through the centre that faces the frame.
    pub middle: f64,
    /// Change of height along it, below 0.
    pub slope: f64,
    /// Half the side of the windows, metres.
    pub radius: f64,
    /// Mip level.
    pub level: f32,
}

/// What a frame knows of a ray.
pub(super) enum Met {
    /// It meets the surface at this place of the frame.
    Surface(DVec2),
    /// It passes all that the frame shows.
    Nothing,
    /// It passes behind an outline, where the frame sees nothing.
    Hidden,
}

/// A point of the ray beside the frame's surface.
#[derive(Clone, Copy)]
struct Point {
    uv: DVec2,
    covered: bool,
    /// Height over the surface, radii; 0 where nothing is covered.
    gap: f64,
}

impl Point {
    fn below(&self) -> bool {
        self.covered && self.gap < 0.0
    }
}

/// Halvings of the step in which the ray meets the surface.
const BISECTIONS: u32 = 5;

/// Texels are covered from this alpha on.
const COVERED: f32 = 0.5;

/// A ray that is so far below the surface where it enters an outline passes behind it; texels.
const WALL: f64 = 3.0;

impl Ray {
    /// Its parameter at a height, in radii.
    pub fn at(&self, height: f64) -> f64 {
        self.middle + height * self.radius / self.slope
    }

    fn place(&self, tilted: &Tilted, height: f64) -> DVec2 {
        let p = (self.start + self.ray * self.at(height)) / self.radius;
        DVec2::new(p.dot(tilted.right) + 1.0, 1.0 - p.dot(tilted.up)) * 0.5
    }

    fn point(&self, tilted: &Tilted, height: f64) -> Point {
        let uv = self.place(tilted, height);
        let inside = uv.cmpge(DVec2::ZERO).all() && uv.cmple(DVec2::ONE).all();
        let covered = inside && tilted.frame.coverage(uv, self.level) >= COVERED;
        let gap = if covered { height - tilted.frame.height(uv, self.level) } else { 0.0 };
        Point { uv, covered, gap }
    }

    /// The first crossing from above the surface to below it, from the plane nearest to the frame's camera to the farthest: found in `steps` equal
    /// steps of height, then by bisection. Where the ray enters an outline far below the surface it is behind it, and that is no crossing. Without
    /// steps the frame is a flat picture on the plane through the centre.
    pub fn met(&self, tilted: &Tilted, steps: u32) -> Met {
        if steps == 0 {
            let point = self.point(tilted, 0.0);
            return if point.covered { Met::Surface(point.uv) } else { Met::Nothing };
        }
        let wall = WALL * 2.0 * libm::exp2(self.level.into()) / f64::from(tilted.frame.tile);
        let (mut before, mut hidden) = (self.point(tilted, 1.0), false);
        for i in 1..=steps {
            let height = |i: u32| 1.0 - 2.0 * f64::from(i) / f64::from(steps);
            let (mut high, mut low) = (height(i - 1), height(i));
            let point = self.point(tilted, low);
            let (below, was_below) = (point.below(), before.below());
            if below && !was_below {
                let (mut above, mut under) = (before.covered, point);
                for _ in 0..BISECTIONS {
                    let half = (high + low) * 0.5;
                    let p = self.point(tilted, half);
                    if p.below() {
                        (low, under) = (half, p);
                    } else {
                        (high, above) = (half, p.covered);
                    }
                }
                if above || -under.gap <= wall {
                    return Met::Surface(under.uv);
                }
                hidden = true;
            }
            before = point;
        }
        if hidden { Met::Hidden } else { Met::Nothing }
    }
}
