//! What was measured in every view: what a histogram over the region is made of.

use super::{classes::ClassCounts, figures::rounded, measure::ViewFigures};
use serde::Serialize;

/// A number for each view, in their order, by the name that the measure has in the certificate. Classes of pixels are counted outside the band,
/// lost detail and cracks everywhere.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PerView {
    /// dB; nothing where neither scene is seen.
    pub psnr_y_object_db: Vec<Option<f64>>,
    pub ssim_object: Vec<Option<f64>>,
    pub missing_px: Vec<u64>,
    pub wrong_surface_px: Vec<u64>,
    pub lost_detail_px: Vec<u64>,
    pub crack_px: Vec<u64>,
    pub in_front_px: Vec<u64>,
    pub extra_px: Vec<u64>,
    /// Pixels.
    pub max_deviation_px: Vec<f64>,
}

impl PerView {
    pub fn of(views: &[ViewFigures]) -> Self {
        let some = |f: &dyn Fn(&ViewFigures) -> Option<f64>, places: i32| {
            views.iter().map(|v| f(v).map(|x| rounded(x, places))).collect()
        };
        let outside = |f: fn(&ClassCounts) -> u64| views.iter().map(|v| f(&v.counts.outside)).collect();
        Self {
            psnr_y_object_db: some(&|v| v.psnr_object, 3),
            ssim_object: some(&|v| v.ssim_object, 5),
            missing_px: outside(|c| c.missing),
            wrong_surface_px: outside(|c| c.wrong_surface),
            lost_detail_px: views.iter().map(|v| v.counts.outside.lost + v.counts.inside.lost).collect(),
            crack_px: views.iter().map(|v| v.counts.crack).collect(),
            in_front_px: outside(|c| c.in_front),
            extra_px: outside(|c| c.extra),
            max_deviation_px: views.iter().map(|v| rounded(v.max_deviation, 3)).collect(),
        }
    }
}
