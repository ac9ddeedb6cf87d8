//! Structural similarity of luminance.
//!
//! Wang, Bovik, Sheikh and Simoncelli, "Image quality assessment: from error visibility to structural similarity",
//! 2004, equation 13: an 11×11 Gaussian window with σ = 1.5, K1 = 0.01, K2 = 0.03, L = 255. The window is separable
//! and renormalised at the picture's sides, so that the map has a value for every pixel.

/// Half the window: 5 pixels to each side of its centre.
pub const SSIM_RADIUS: usize = 5;
const C1: f32 = (0.01 * 255.0) * (0.01 * 255.0);
const C2: f32 = (0.03 * 255.0) * (0.03 * 255.0);

/// SSIM at every pixel of two luminance planes in [0, 255], `width` wide. Values lie in [−1, 1].
pub fn ssim_map(a: &[f32], b: &[f32], width: usize) -> Vec<f32> {
    let window = window();
    let height = a.len() / width;
    // Moments of a row, filtered along the row; a ring of 11 rows is all that the columns need.
    let mut rows: Vec<Vec<[f32; 5]>> = vec![vec![[0.0; 5]; width]; 2 * SSIM_RADIUS + 1];
    let mut moments = vec![[0.0_f32; 5]; width];
    let mut ready = 0;
    let mut out = Vec::with_capacity(a.len());
    for y in 0..height {
        while ready < height && ready <= y + SSIM_RADIUS {
            let (ra, rb) = (&a[ready * width..][..width], &b[ready * width..][..width]);
            for ((m, a), b) in moments.iter_mut().zip(ra).zip(rb) {
                *m = [*a, *b, a * a, b * b, a * b];
            }
            let ring = rows.len();
            filter_row(&moments, &window, &mut rows[ready % ring]);
            ready += 1;
        }
        let (first, last) = (y.saturating_sub(SSIM_RADIUS), (y + SSIM_RADIUS).min(height - 1));
        let total: f32 = (first..=last).map(|r| window[r + SSIM_RADIUS - y]).sum();
        let mut sums = vec![[0.0_f32; 5]; width];
        for r in first..=last {
            let w = window[r + SSIM_RADIUS - y] / total;
            for (sum, row) in sums.iter_mut().zip(&rows[r % rows.len()]) {
                for k in 0..5 {
                    sum[k] += w * row[k];
                }
            }
        }
        out.extend(sums.iter().map(|s| {
            let [ma, mb, aa, bb, ab] = *s;
            let (va, vb, cov) = (aa - ma * ma, bb - mb * mb, ab - ma * mb);
            ((2.0 * ma * mb + C1) * (2.0 * cov + C2)) / ((ma * ma + mb * mb + C1) * (va + vb + C2))
        }));
    }
    out
}

/// The window's weights along one axis, of sum 1.
fn window() -> [f32; 2 * SSIM_RADIUS + 1] {
    let w: [f64; 2 * SSIM_RADIUS + 1] = std::array::from_fn(|i| {
        let d = i as f64 - SSIM_RADIUS as f64;
        libm::exp(-d * d / (2.0 * 1.5 * 1.5))
    });
    let total: f64 = w.iter().sum();
    w.map(|w| (w / total) as f32)
}

/// One row through the window; beyond the row's ends the weights that are left are renormalised.
fn filter_row(row: &[[f32; 5]], window: &[f32; 2 * SSIM_RADIUS + 1], out: &mut [[f32; 5]]) {
    let n = row.len();
    for (x, out) in out.iter_mut().enumerate() {
        let (first, last) = (x.saturating_sub(SSIM_RADIUS), (x + SSIM_RADIUS).min(n - 1));
        let weights = &window[first + SSIM_RADIUS - x..=last + SSIM_RADIUS - x];
        let mut sum = [0.0_f32; 5];
        for (v, w) in row[first..=last].iter().zip(weights) {
            for k in 0..5 {
                sum[k] += w * v[k];
            }
        }
        if weights.len() < window.len() {
            let total: f32 = weights.iter().sum();
            sum = sum.map(|s| s / total);
        }
        *out = sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Equation 13 read literally, in f64, window by window.
    fn literal(a: &[f32], b: &[f32], width: usize, x: usize, y: usize) -> f64 {
        let height = a.len() / width;
        let r = SSIM_RADIUS as i64;
        let (mut total, mut s) = (0.0, [0.0; 5]);
        for dy in -r..=r {
            for dx in -r..=r {
                let (u, v) = (x as i64 + dx, y as i64 + dy);
                if u < 0 || v < 0 || u >= width as i64 || v >= height as i64 {
                    continue;
                }
                let w = libm::exp(-((dx * dx + dy * dy) as f64) / 4.5);
                let i = v as usize * width + u as usize;
                let (p, q) = (f64::from(a[i]), f64::from(b[i]));
                total += w;
                for (s, m) in s.iter_mut().zip([p, q, p * p, q * q, p * q]) {
                    *s += w * m;
                }
            }
        }
        let [ma, mb, aa, bb, ab] = s.map(|s| s / total);
        let (c1, c2) = (6.5025, 58.5225);
        (2.0 * ma * mb + c1) * (2.0 * (ab - ma * mb) + c2)
            / ((ma * ma + mb * mb + c1) * (aa - ma * ma + bb - mb * mb + c2))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]
        #[test]
        fn the_separable_filter_is_the_literal_one(
            width in 1_usize..24,
            height in 1_usize..24,
            seed in prop::collection::vec((0.0_f32..255.0, 0.0_f32..255.0), 24 * 24),
        ) {
            let n = width * height;
            let a: Vec<f32> = seed[..n].iter().map(|p| p.0).collect();
            let b: Vec<f32> = seed[..n].iter().map(|p| p.1).collect();
            let map = ssim_map(&a, &b, width);
            prop_assert_eq!(map.len(), n);
            for (i, v) in map.iter().enumerate() {
                let expect = literal(&a, &b, width, i % width, i / width);
                prop_assert!((f64::from(*v) - expect).abs() < 2e-3, "{} {} at {}", v, expect, i);
            }
        }
    }

    #[test]
    fn equal_pictures_are_similar_and_a_negative_is_not() {
        let a: Vec<f32> = (0..400).map(|i| if (i / 3 + i / 20) % 2 == 0 { 30.0 } else { 220.0 }).collect();
        let b: Vec<f32> = a.iter().map(|v| 250.0 - v).collect();
        assert!(ssim_map(&a, &a, 20).iter().all(|v| (v - 1.0).abs() < 1e-4));
        assert!(ssim_map(&a, &b, 20).iter().all(|v| *v < 0.0));
    }
}
