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
    edges::{Surfaces, dilate_round, edge_pixels},
    lost::lost,
    nearby::Nearby,
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
    /// See [`super::lost`].
    pub lost: Vec<bool>,
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
    /// Lost pixels (see [`super::lost`]), which are of the other classes too.
    pub lost: u64,
}

impl ClassCounts {
    /// Pixels that are not right.
    pub fn total(&self) -> u64 {
        self.missing + self.extra + self.wrong_surface + self.in_front
    }
}

/// Classifies the pixels of a view. `edges` are the original's discontinuities.
pub fn classify(original: &Surfaces, stand_in: &Surfaces, edges: &[u8], rule: &Rule) -> Classes {
    let width = original.width;
    let band = dilate_round(&edge_pixels(edges, width), width, rule.band_px);
    let reach = (rule.band_px * rule.band_px) as i32;
    let mut nearby = Nearby::new(rule.band_px as i32, width, edges);
    let class: Vec<Class> = (0..original.depth.len())
        .map(|i| {
            let (zo, zs) = (original.depth[i], stand_in.depth[i]);
            match (original.covered(i), stand_in.covered(i)) {
                (false, false) => Class::Right,
                (true, false) => Class::Missing,
                (false, true) => Class::Extra,
                (true, true) if rule.parallax.deeper(i, zo, zs, rule.bound) => {
                    let right = nearby.any(i, reach, |q| !rule.parallax.deeper(i, original.depth[q], zs, rule.bound));
                    if right { Class::Right } else { Class::WrongSurface }
                }
                (true, true) if rule.parallax.deeper(i, zs, zo, rule.bound) => {
                    let right = nearby.any(i, reach, |q| !rule.parallax.deeper(i, zs, original.depth[q], rule.bound));
                    if right { Class::Right } else { Class::InFront }
                }
                _ => Class::Right,
            }
        })
        .collect();
    let holes: Vec<bool> = class.iter().map(|c| matches!(c, Class::Missing | Class::WrongSurface)).collect();
    let crack = cracks(&holes, edges, &band, width);
    let lost = lost(original, stand_in, &class, edges, rule);
    let mut counts = Counts { crack: crack.iter().filter(|c| **c).count() as u64, ..Counts::default() };
    for (i, c) in class.iter().enumerate() {
        counts.covered += u64::from(original.covered(i));
        counts.band += u64::from(band[i]);
        let side = if band[i] { &mut counts.inside } else { &mut counts.outside };
        side.lost += u64::from(lost[i]);
        match c {
            Class::Right => {}
            Class::Missing => side.missing += 1,
            Class::Extra => side.extra += 1,
            Class::WrongSurface => side.wrong_surface += 1,
            Class::InFront => side.in_front += 1,
        }
    }
    Classes { class, band, crack, lost, counts }
}
