//! What every pixel of a view says about a stand-in, from depths at pixel centres and never from colour.
//!
//! - *missing*: the original is there, the stand-in is not; *extra*: the reverse;
//! - *wrong surface*: both are there and the stand-in is deeper by more than the bound (see [`super::parallax`]): the
//!   error would show as more than the bound somewhere in the cell. A crack in front of the ground is of this class;
//! - *in front*: both are there and the stand-in is nearer by more than the bound: a fin.
//!
//! The last two have one exception. On a steep surface a displacement within the bound changes the depth by any amount;
//! where the original itself has the stand-in's depth within E pixels on the same continuous surface, the pixel is right.
//!
//! The *band* holds the pixels within E = ceil(bound) pixels of a discontinuity of the original: there a method may
//! displace silhouettes. Outside it no pixel should be of any of these classes.

use super::{
    cracks::cracks,
    deviation::max_deviation,
    edges::{BELOW, RIGHT, Surfaces, dilate_round, edge_pixels},
    parallax::{Angle, Parallax},
};

/// One pixel's class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Both show nothing, or the same surface within the bound.
    Right,
    Missing,
    Extra,
    WrongSurface,
    InFront,
}

/// What a view is classified by.
#[derive(Clone, Debug)]
pub struct Rule {
    pub parallax: Parallax,
    /// The bound as an angle.
    pub bound: Angle,
    /// E: the bound in whole pixels.
    pub band_px: u32,
}

/// A classified view.
#[derive(Clone, Debug)]
pub struct Classes {
    pub class: Vec<Class>,
    pub band: Vec<bool>,
    pub crack: Vec<bool>,
    pub counts: Counts,
}

/// Pixels of each class in one view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Pixels where the original is there.
    pub covered: u64,
    /// Pixels of the band.
    pub band: u64,
    /// Outside the band.
    pub outside: ClassCounts,
    /// Inside the band.
    pub inside: ClassCounts,
    /// Pixels of cracks (see [`super::cracks`]), anywhere.
    pub crack: u64,
    /// See [`super::deviation`]; pixels.
    pub max_deviation: f64,
}

impl Counts {
    /// The stand-in is nowhere where the original is, nor anywhere else.
    pub fn missing_everywhere(&self) -> bool {
        self.outside.missing + self.inside.missing == self.covered && self.outside.extra + self.inside.extra == 0
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClassCounts {
    pub missing: u64,
    pub extra: u64,
    pub wrong_surface: u64,
    pub in_front: u64,
}

impl ClassCounts {
    pub fn total(&self) -> u64 {
        self.missing + self.extra + self.wrong_surface + self.in_front
    }
}

/// Classifies the pixels of a view. `edges` are the original's discontinuities.
pub fn classify(original: &Surfaces, stand_in: &Surfaces, edges: &[u8], rule: &Rule) -> Classes {
    let width = original.width;
    let band = dilate_round(&edge_pixels(edges, width), width, rule.band_px);
    let mut nearby = Nearby::new(rule.band_px, width, edges);
    let class: Vec<Class> = (0..original.depth.len())
        .map(|i| {
            let (zo, zs) = (original.depth[i], stand_in.depth[i]);
            match (original.covered(i), stand_in.covered(i)) {
                (false, false) => Class::Right,
                (true, false) => Class::Missing,
                (false, true) => Class::Extra,
                (true, true) if rule.parallax.deeper(i, zo, zs, rule.bound) => {
                    let right = nearby.any(i, |q| !rule.parallax.deeper(i, original.depth[q], zs, rule.bound));
                    if right { Class::Right } else { Class::WrongSurface }
                }
                (true, true) if rule.parallax.deeper(i, zs, zo, rule.bound) => {
                    let right = nearby.any(i, |q| !rule.parallax.deeper(i, zs, original.depth[q], rule.bound));
                    if right { Class::Right } else { Class::InFront }
                }
                _ => Class::Right,
            }
        })
        .collect();
    let holes: Vec<bool> = class.iter().map(|c| matches!(c, Class::Missing | Class::WrongSurface)).collect();
    let crack = cracks(&holes, edges, &band, width);
    let mut counts = Counts {
        crack: crack.iter().filter(|c| **c).count() as u64,
        max_deviation: max_deviation(original, stand_in, rule),
        ..Counts::default()
    };
    for (i, c) in class.iter().enumerate() {
        counts.covered += u64::from(original.covered(i));
        counts.band += u64::from(band[i]);
        let side = if band[i] { &mut counts.inside } else { &mut counts.outside };
        match c {
            Class::Right => {}
            Class::Missing => side.missing += 1,
            Class::Extra => side.extra += 1,
            Class::WrongSurface => side.wrong_surface += 1,
            Class::InFront => side.in_front += 1,
        }
    }
    Classes { class, band, crack, counts }
}

/// Searches the pixels within a radius that lie on the same continuous surface of the original: reached by
/// steps to 4-neighbours without crossing a discontinuity.
struct Nearby<'a> {
    radius: i32,
    width: i32,
    edges: &'a [u8],
    /// Stamp of the search that reached a place of the window last.
    reached: Vec<u32>,
    stamp: u32,
    queue: Vec<(i32, i32)>,
}

impl<'a> Nearby<'a> {
    fn new(radius: u32, width: usize, edges: &'a [u8]) -> Self {
        let side = 2 * radius as usize + 1;
        let reached = vec![0; side * side];
        Self { radius: radius as i32, width: width as i32, edges, reached, stamp: 0, queue: Vec::new() }
    }

    /// True where `right(q)` holds for a pixel q so reached from `i`.
    fn any(&mut self, i: usize, right: impl Fn(usize) -> bool) -> bool {
        let (r, w, h) = (self.radius, self.width, (self.edges.len() / self.width as usize) as i32);
        let (x0, y0) = (i as i32 % w, i as i32 / w);
        self.stamp = self.stamp.wrapping_add(1);
        self.queue.clear();
        self.queue.push((0, 0));
        let mut next = 0;
        while let Some(&(dx, dy)) = self.queue.get(next) {
            next += 1;
            let q = ((y0 + dy) * w + x0 + dx) as usize;
            if right(q) {
                return true;
            }
            for (sx, sy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let (ex, ey) = (dx + sx, dy + sy);
                let (x, y) = (x0 + ex, y0 + ey);
                if ex * ex + ey * ey > r * r || x < 0 || y < 0 || x >= w || y >= h {
                    continue;
                }
                // The discontinuity is stored with the left or upper pixel of the pair.
                let first = if sx + sy > 0 { q } else { (y * w + x) as usize };
                if self.edges[first] & if sx != 0 { RIGHT } else { BELOW } != 0 {
                    continue;
                }
                let place = &mut self.reached[((ey + r) * (2 * r + 1) + ex + r) as usize];
                if *place != self.stamp {
                    *place = self.stamp;
                    self.queue.push((ex, ey));
                }
            }
        }
        false
    }
}
