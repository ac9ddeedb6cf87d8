//! Peak signal-to-noise ratio of luminance: 10 log10(255² / MSE), in dB (Chen et al. 2003, section 4.2).

/// Equal pictures have no noise; their ratio counts as this many dB.
pub const PSNR_CAP_DB: f64 = 100.0;

/// The ratio for a mean squared error of luminance in [0, 255]².
pub fn decibel(mse: f64) -> f64 {
    if mse <= 0.0 { PSNR_CAP_DB } else { (10.0 * libm::log10(255.0 * 255.0 / mse)).min(PSNR_CAP_DB) }
}

/// Sum of squared differences.
pub fn squared_error(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a - b) * f64::from(a - b)).sum()
}

/// PSNR over the whole picture. The planes have equal, non-zero lengths.
pub fn psnr(a: &[f32], b: &[f32]) -> f64 {
    decibel(squared_error(a, b) / a.len() as f64)
}

/// PSNR over the pixels where `mask` is set; `None` where it is nowhere set.
pub fn psnr_within(a: &[f32], b: &[f32], mask: &[bool]) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0_u64);
    for ((a, b), m) in a.iter().zip(b).zip(mask) {
        if *m {
            sum += f64::from(a - b) * f64::from(a - b);
            count += 1;
        }
    }
    (count > 0).then(|| decibel(sum / count as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pictures_reach_the_cap() {
        assert_eq!(psnr(&[1.0, 2.0], &[1.0, 2.0]), PSNR_CAP_DB);
    }

    #[test]
    fn black_against_white_is_zero_and_a_tenth_is_twenty() {
        assert_eq!(psnr(&[0.0; 4], &[255.0; 4]), 0.0);
        assert!((psnr(&[0.0; 4], &[25.5; 4]) - 20.0).abs() < 1e-9);
    }

    #[test]
    fn the_mask_chooses_pixels() {
        let (a, b) = ([0.0, 0.0, 9.0], [25.5, 0.0, 9.0]);
        assert!((psnr_within(&a, &b, &[true, false, false]).unwrap() - 20.0).abs() < 1e-9);
        assert_eq!(psnr_within(&a, &b, &[false, true, true]), Some(PSNR_CAP_DB));
        assert_eq!(psnr_within(&a, &b, &[false; 3]), None);
    }
}
