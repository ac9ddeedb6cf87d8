//! Figures of each way in which a stand-in can be drawn, and of what no capture saw.
//!
//! A stand-in that is made of reference views can show nothing that none of them saw. The pixels whose surface none saw are the
//! floor: errors are counted with them and without.

use super::{
    classes::{Class, Classes},
    figures::{Count, MeanMax, MeanMin, RATIO_PLACES, rounded},
    measure::ViewFigures,
};
use crate::runtime::Drawn;
use serde::Serialize;

/// One view drawn in one way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModeView {
    pub figures: ViewFigures,
    pub drawn: Drawn,
    /// Pixels of the original whose surface no capture saw.
    pub floor: u64,
    /// Pixels whose surface some capture saw and that are missing, or of a wrong surface, inside and outside the band.
    pub seen_missing: u64,
    pub seen_wrong: u64,
    /// The same outside the band.
    pub seen_missing_outside: u64,
    pub seen_wrong_outside: u64,
}

impl ModeView {
    /// `unseen`: for each pixel of the original that is covered, whether no capture saw its surface.
    pub fn of(figures: ViewFigures, drawn: Drawn, classes: &Classes, unseen: &[bool]) -> Self {
        let mut out = Self { figures, drawn, floor: unseen.iter().filter(|u| **u).count() as u64, ..Self::default() };
        for (i, class) in classes.class.iter().enumerate().filter(|(i, _)| !unseen[*i]) {
            let outside = u64::from(!classes.band[i]);
            match class {
                Class::Missing => {
                    out.seen_missing += 1;
                    out.seen_missing_outside += outside;
                }
                Class::WrongSurface => {
                    out.seen_wrong += 1;
                    out.seen_wrong_outside += outside;
                }
                _ => {}
            }
        }
        out
    }
}

/// Pixels of a class, with those at edges.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Everywhere {
    /// Outside the band.
    #[serde(flatten)]
    pub outside: Count,
    /// Inside and outside the band, over the original's covered pixels.
    pub with_edges_ratio: f64,
    /// Outside the band, without the floor.
    pub without_floor: Count,
    /// Inside and outside the band, without the floor, over the original's covered pixels.
    pub without_floor_with_edges_ratio: f64,
}

/// What was measured of one way to draw a stand-in.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModeFigures {
    pub triangles_per_view: MeanMax,
    pub references_per_view: MeanMax,
    pub psnr_y_object_db: MeanMin,
    /// Pixels whose surface no reference saw.
    pub floor_px: Count,
    pub missing_px: Everywhere,
    pub wrong_surface_px: Everywhere,
}

impl ModeFigures {
    /// `views` is not empty.
    pub fn of(views: &[ModeView]) -> Self {
        let n = views.len() as f64;
        let covered = views.iter().map(|v| v.figures.counts.covered).sum::<u64>().max(1) as f64;
        let most = |f: &dyn Fn(&ModeView) -> u64| {
            let (sum, max) = views.iter().map(f).fold((0, 0), |(s, m), v| (s + v, v.max(m)));
            (sum, MeanMax { mean: rounded(sum as f64 / n, 3), max: max as f64 })
        };
        let ratio = |of: u64| rounded(of as f64 / covered, RATIO_PLACES);
        let count = |f: &dyn Fn(&ModeView) -> u64| {
            let (sum, MeanMax { mean, max }) = most(f);
            Count { mean, max, ratio: ratio(sum) }
        };
        let sum = |f: &dyn Fn(&ModeView) -> u64| ratio(most(f).0);
        let psnr: Vec<f64> = views.iter().filter_map(|v| v.figures.psnr_object).collect();
        let (least, total) = psnr.iter().fold((f64::INFINITY, 0.0), |(l, t), p| (p.min(l), t + p));
        Self {
            triangles_per_view: most(&|v| v.drawn.triangles).1,
            references_per_view: most(&|v| v.drawn.references.into()).1,
            psnr_y_object_db: if psnr.is_empty() {
                MeanMin { mean: 0.0, min: 0.0 }
            } else {
                MeanMin { mean: rounded(total / psnr.len() as f64, 3), min: rounded(least, 3) }
            },
            floor_px: count(&|v| v.floor),
            missing_px: Everywhere {
                outside: count(&|v| v.figures.counts.outside.missing),
                with_edges_ratio: sum(&|v| v.figures.counts.outside.missing + v.figures.counts.inside.missing),
                without_floor: count(&|v| v.seen_missing_outside),
                without_floor_with_edges_ratio: sum(&|v| v.seen_missing),
            },
            wrong_surface_px: Everywhere {
                outside: count(&|v| v.figures.counts.outside.wrong_surface),
                with_edges_ratio: sum(&|v| {
                    v.figures.counts.outside.wrong_surface + v.figures.counts.inside.wrong_surface
                }),
                without_floor: count(&|v| v.seen_wrong_outside),
                without_floor_with_edges_ratio: sum(&|v| v.seen_wrong),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_capture_saw_is_no_error_without_the_floor() {
        let class = vec![Class::Missing, Class::Missing, Class::WrongSurface, Class::Right, Class::Missing];
        let classes = Classes {
            class,
            band: vec![false, false, false, false, true],
            crack: vec![false; 5],
            lost: vec![false; 5],
            counts: Default::default(),
        };
        let mut figures = ViewFigures::default();
        figures.counts.covered = 5;
        (figures.counts.outside.missing, figures.counts.outside.wrong_surface) = (2, 1);
        figures.counts.inside.missing = 1;
        let unseen = [true, false, false, true, false];
        let view = ModeView::of(figures, Drawn { triangles: 10, references: 2 }, &classes, &unseen);
        let f = ModeFigures::of(&[view]);
        assert_eq!((f.floor_px.mean, f.floor_px.ratio), (2.0, 0.4));
        assert_eq!((f.missing_px.outside.mean, f.missing_px.without_floor.mean), (2.0, 1.0));
        assert_eq!((f.missing_px.with_edges_ratio, f.missing_px.without_floor_with_edges_ratio), (0.6, 0.4));
        assert_eq!((f.wrong_surface_px.outside.mean, f.wrong_surface_px.without_floor.mean), (1.0, 1.0));
        assert_eq!((f.triangles_per_view.max, f.references_per_view.mean), (10.0, 2.0));
    }
}
