//! The figures of a stand-in over all its views, rounded as they stand in the certificate.

use super::{classes::ClassCounts, measure::ViewFigures};
use crate::image::measure::PSNR_CAP_DB;
use serde::{Deserialize, Serialize};

/// Decimals of a ratio of pixels: a single pixel of a hundred million shows.
pub(super) const RATIO_PLACES: i32 = 8;

/// Rounds to `places` decimals.
pub fn rounded(x: f64, places: i32) -> f64 {
    let scale = [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8][places.clamp(0, 8) as usize];
    (x * scale).round() / scale
}

/// Of a measure of which more is better.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeanMin {
    pub mean: f64,
    pub min: f64,
}

/// Of a measure of which less is better.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeanMax {
    pub mean: f64,
    pub max: f64,
}

/// Pixels of a kind in a view.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Count {
    pub mean: f64,
    pub max: f64,
    /// Over the original's covered pixels, all views together.
    pub ratio: f64,
}

/// Pixels of a kind in all views.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Total {
    pub total: u64,
    /// Over the original's covered pixels.
    pub ratio: f64,
}

/// Pixels of the original that the stand-in shows nowhere near (see [`super::lost`]).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LostDetail {
    pub mean: f64,
    pub max: f64,
    /// Over the original's covered pixels, all views together.
    pub ratio: f64,
    /// The same of those inside the band: thin parts and outlines. No other count outside the band has them.
    pub band_ratio: f64,
}

/// What happens within the band around the original's discontinuities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// Its half width E in pixels.
    pub px: u32,
    /// Differing pixels of all classes inside it, over the original's covered pixels; all views together.
    pub differing_ratio: f64,
    /// The pixels of the band over the original's covered pixels; all views together.
    pub share: f64,
    pub missing_px: Count,
    pub extra_px: Count,
    pub wrong_surface_px: Count,
    pub in_front_px: Count,
}

/// What was measured over many views. Pixel counts are a view's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    pub psnr_y_db: MeanMin,
    /// Over the object's pixels: both coverages, dilated by 4 pixels.
    pub psnr_y_object_db: MeanMin,
    pub ssim: MeanMin,
    pub ssim_object: MeanMin,
    /// Outside the band, as the next three.
    pub missing_px: Count,
    pub extra_px: Count,
    pub wrong_surface_px: Count,
    pub in_front_px: Count,
    pub crack_px: Total,
    /// Inside and outside the band.
    pub lost_detail_px: LostDetail,
    pub band: Band,
    pub max_deviation_px: f64,
    /// Pixels where the stand-in's nearest surface is the back of a single-sided material. As in engines it is not drawn.
    pub back_facing_px: MeanMax,
    /// The original's.
    pub covered_px: MeanMax,
}

impl Figures {
    /// `views` is not empty.
    pub fn of(views: &[ViewFigures], band_px: u32) -> Self {
        let least = |places, best: f64, values: &mut dyn Iterator<Item = f64>| {
            let (mut sum, mut count, mut min) = (0.0, 0_u32, f64::INFINITY);
            for v in values {
                (sum, count, min) = (sum + v, count + 1, min.min(v));
            }
            // Nothing was seen, and so nothing differs.
            if count == 0 {
                return MeanMin { mean: best, min: best };
            }
            MeanMin { mean: rounded(sum / f64::from(count), places), min: rounded(min, places) }
        };
        let most = |f: &dyn Fn(&ViewFigures) -> u64| {
            let (sum, max) = views.iter().map(f).fold((0, 0), |(s, m), v| (s + v, v.max(m)));
            MeanMax { mean: rounded(sum as f64 / views.len() as f64, 3), max: max as f64 }
        };
        let sum = |f: &dyn Fn(&ViewFigures) -> u64| views.iter().map(f).sum::<u64>();
        let covered = sum(&|v| v.counts.covered).max(1) as f64;
        let ratio = |of: u64| rounded(of as f64 / covered, RATIO_PLACES);
        let count = |f: &dyn Fn(&ViewFigures) -> u64| {
            let MeanMax { mean, max } = most(f);
            Count { mean, max, ratio: ratio(sum(f)) }
        };
        let class = |side: &dyn Fn(&ViewFigures) -> ClassCounts, f: fn(&ClassCounts) -> u64| count(&|v| f(&side(v)));
        let lost = count(&|v| v.counts.outside.lost + v.counts.inside.lost);
        let cracks = sum(&|v| v.counts.crack);
        let (outside, inside) = (|v: &ViewFigures| v.counts.outside, |v: &ViewFigures| v.counts.inside);
        Self {
            psnr_y_db: least(3, PSNR_CAP_DB, &mut views.iter().map(|v| v.psnr)),
            psnr_y_object_db: least(3, PSNR_CAP_DB, &mut views.iter().filter_map(|v| v.psnr_object)),
            ssim: least(5, 1.0, &mut views.iter().map(|v| v.ssim)),
            ssim_object: least(5, 1.0, &mut views.iter().filter_map(|v| v.ssim_object)),
            missing_px: class(&outside, |c| c.missing),
            extra_px: class(&outside, |c| c.extra),
            wrong_surface_px: class(&outside, |c| c.wrong_surface),
            in_front_px: class(&outside, |c| c.in_front),
            crack_px: Total { total: cracks, ratio: ratio(cracks) },
            lost_detail_px: LostDetail {
                mean: lost.mean,
                max: lost.max,
                ratio: lost.ratio,
                band_ratio: ratio(sum(&|v| v.counts.inside.lost)),
            },
            band: Band {
                px: band_px,
                differing_ratio: rounded(sum(&|v| v.counts.inside.total()) as f64 / covered, 6),
                share: rounded(sum(&|v| v.counts.band) as f64 / covered, 4),
                missing_px: class(&inside, |c| c.missing),
                extra_px: class(&inside, |c| c.extra),
                wrong_surface_px: class(&inside, |c| c.wrong_surface),
                in_front_px: class(&inside, |c| c.in_front),
            },
            max_deviation_px: rounded(views.iter().map(|v| v.max_deviation).fold(0.0, f64::max), 3),
            back_facing_px: most(&|v| v.back_facing),
            covered_px: most(&|v| v.counts.covered),
        }
    }
}
