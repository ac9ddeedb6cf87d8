//! Measures that compare two pictures of equal size: PSNR and SSIM of luminance, FLIP.
//!
//! Luminance is Y = 0.299 R + 0.587 G + 0.114 B of sRGB-encoded values in [0, 255]; planes are stored row by row.

mod flip;
mod psnr;
mod ssim;

pub use flip::flip;
pub use psnr::{PSNR_CAP_DB, decibel, psnr, psnr_within, squared_error};
pub use ssim::{SSIM_RADIUS, ssim_map};

use super::Picture;

/// The luminance of sRGB-encoded RGB, same range as its components (Chen et al. 2003, section 4.2).
pub fn luminance(rgb: [f32; 3]) -> f32 {
    0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2]
}

/// The luminance of each pixel of a picture, 0 to 255.
pub fn luminances(picture: &Picture) -> Vec<f32> {
    picture.texels.iter().map(|t| luminance([t[0].into(), t[1].into(), t[2].into()])).collect()
}

/// The mean of `values` where `mask` is set, `None` where it is nowhere set. Summed row by row, in order.
pub fn mean_within(values: &[f32], mask: &[bool]) -> Option<f64> {
    let (mut sum, mut count) = (0.0_f64, 0_u64);
    for (v, m) in values.iter().zip(mask) {
        if *m {
            sum += f64::from(*v);
            count += 1;
        }
    }
    (count > 0).then(|| sum / count as f64)
}
