//! Opaque colours in blocks of 4 × 4 texels, 8 bytes each (BC1; the colours of BC3).
//!
//! Format: two colours of 5, 6 and 5 bits, then 2 bits a texel. Where the first colour's number is greater, two more lie evenly between them; else one, and
//! black. The colours of BC3 are always of the first kind.

use std::{cmp::Ordering, sync::LazyLock};

/// The colours of a block, rounded to the nearest byte. `always_four`: as the colours of BC3 are.
pub(super) fn decode(block: [u8; 8], always_four: bool) -> [[u8; 3]; 16] {
    let [a, b] = [[block[0], block[1]], [block[2], block[3]]].map(u16::from_le_bytes);
    let palette: [[u8; 3]; 4] = {
        let (p, q) = (expand(a), expand(b));
        let mix = |s: u32, t: u32| {
            std::array::from_fn(|c| {
                // Codes of 5 or 6 bits become bytes after the mixing: v·255/31, or v·255/63.
                let top = (s + t) * if c == 1 { 63 } else { 31 };
                ((2 * 255 * (s * p[c] + t * q[c]) + top) / (2 * top)) as u8
            })
        };
        if a > b || always_four {
            [mix(1, 0), mix(0, 1), mix(2, 1), mix(1, 2)]
        } else {
            [mix(1, 0), mix(0, 1), mix(1, 1), [0; 3]]
        }
    };
    let indices = u32::from_le_bytes([block[4], block[5], block[6], block[7]]);
    std::array::from_fn(|i| palette[(indices >> (2 * i)) as usize & 3])
}

/// The codes of red, green and blue.
fn expand(color: u16) -> [u32; 3] {
    [u32::from(color >> 11), u32::from(color >> 5 & 63), u32::from(color & 31)]
}

/// A block near to `colors`: the best endpoints of those that the cluster fit tries. Errors of sRGB colours are weighted by how bright the channels look.
///
/// The colours are sorted along their principal axis; every way of cutting this order into clusters, one for each colour of the block, gives endpoints by
/// least squares (Brown 2006, "DXT Compression Techniques"). Black is never taken from a block of three colours, where some read it as transparent.
pub(super) fn encode(colors: &[[u8; 3]; 16], srgb: bool, always_four: bool) -> [u8; 8] {
    if colors.iter().all(|c| *c == colors[0]) {
        return flat(colors[0]);
    }
    let weights = if srgb { LUMA } else { [1.0; 3] };
    let scale = weights.map(|w: f32| w.sqrt() / 255.0);
    let points = colors.map(|c| std::array::from_fn(|i| f32::from(c[i]) * scale[i]));
    let fit = Fit::new(&points, scale);
    let four = pack(&points, scale, fit.ends(true), true);
    if always_four {
        return four.1;
    }
    let three = pack(&points, scale, fit.ends(false), false);
    if three.0 < four.0 { three.1 } else { four.1 }
}

/// How much red, green and blue contribute to luminance (BT.709).
const LUMA: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Highest codes.
const TOP: [f32; 3] = [31.0, 63.0, 31.0];

/// Colours, scaled so that all channels count alike, along an axis.
struct Fit {
    /// Sum of the first 0 to 16 colours along the axis.
    sums: [[f32; 3]; 17],
    scale: [f32; 3],
}

impl Fit {
    fn new(points: &[[f32; 3]; 16], scale: [f32; 3]) -> Self {
        let axis = principal_axis(points);
        let along = points.map(|p| p[0] * axis[0] + p[1] * axis[1] + p[2] * axis[2]);
        let mut order: [usize; 16] = std::array::from_fn(|i| i);
        order.sort_by(|a, b| along[*a].total_cmp(&along[*b]));
        let mut sums = [[0.0; 3]; 17];
        for (n, i) in order.into_iter().enumerate() {
            sums[n + 1] = std::array::from_fn(|c| sums[n][c] + points[i][c]);
        }
        Self { sums, scale }
    }

    /// The codes of the two endpoints with the least error, where the colours of the block are four or three.
    fn ends(&self, four: bool) -> [[u8; 3]; 2] {
        let mut best = (f32::INFINITY, [[0; 3]; 2]);
        for i in 0..=16 {
            for j in i..=16 {
                if four {
                    for k in j..=16 {
                        // Shares of the first endpoint in the four clusters: 1, 2/3, 1/3, 0.
                        self.consider([i, j - i, k - j], [&self.sums[i], &self.sums[j], &self.sums[k]], &mut best);
                    }
                } else {
                    self.consider_three([i, j - i], [&self.sums[i], &self.sums[j]], &mut best);
                }
            }
        }
        best.1
    }

    /// Clusters of this many colours with these sums up to their ends; what is left is the last cluster.
    fn consider(&self, n: [usize; 3], s: [&[f32; 3]; 3], best: &mut (f32, [[u8; 3]; 2])) {
        let [n0, n1, n2] = n.map(|n| n as f32);
        let n3 = 16.0 - n0 - n1 - n2;
        let quadratic = [n0 + (4.0 * n1 + n2) / 9.0, n3 + (4.0 * n2 + n1) / 9.0, (n1 + n2) * 2.0 / 9.0];
        let first = std::array::from_fn(|c| (s[0][c] + s[1][c] + s[2][c]) / 3.0);
        self.solve(quadratic, first, best);
    }

    fn consider_three(&self, n: [usize; 2], s: [&[f32; 3]; 2], best: &mut (f32, [[u8; 3]; 2])) {
        let [n0, n1] = n.map(|n| n as f32);
        let quadratic = [n0 + n1 / 4.0, 16.0 - n0 - n1 * 0.75, n1 / 4.0];
        let first = std::array::from_fn(|c| (s[0][c] + s[1][c]) / 2.0);
        self.solve(quadratic, first, best);
    }

    /// Least squares: `quadratic` holds the sums of a², b² and a·b over the colours' shares a and b = 1 − a of the endpoints, `first` that of a·colour.
    fn solve(&self, [aa, bb, ab]: [f32; 3], first: [f32; 3], best: &mut (f32, [[u8; 3]; 2])) {
        let det = aa * bb - ab * ab;
        if det < 1e-4 {
            return;
        }
        let (mut error, mut ends) = (0.0, [[0; 3]; 2]);
        for c in 0..3 {
            let (pa, pb) = (first[c], self.sums[16][c] - first[c]);
            let unit = TOP[c] / (255.0 * self.scale[c]);
            let code = |v: f32| (v * unit + 0.5).clamp(0.0, TOP[c]) as u8;
            let codes = [code((pa * bb - pb * ab) / det), code((pb * aa - pa * ab) / det)];
            let [a, b] = codes.map(|v| f32::from(v) / unit);
            // Without the sum of the colours' squares, which is the same for all.
            error += a * a * aa + b * b * bb + 2.0 * (a * b * ab - a * pa - b * pb);
            (ends[0][c], ends[1][c]) = (codes[0], codes[1]);
        }
        if error < best.0 {
            *best = (error, ends);
        }
    }
}

/// The direction in which points differ most; any where they do not.
fn principal_axis(points: &[[f32; 3]; 16]) -> [f32; 3] {
    let mean: [f32; 3] = std::array::from_fn(|c| points.iter().map(|p| p[c]).sum::<f32>() / 16.0);
    let mut covariance = [[0.0_f32; 3]; 3];
    for p in points {
        let d: [f32; 3] = std::array::from_fn(|c| p[c] - mean[c]);
        for (row, a) in covariance.iter_mut().zip(d) {
            row.iter_mut().zip(d).for_each(|(m, b)| *m += a * b);
        }
    }
    // Power iteration from the row of the greatest variance, which is never perpendicular to the axis.
    let widest = (0..3).fold(0, |w, c| if covariance[c][c] > covariance[w][w] { c } else { w });
    let mut axis = covariance[widest];
    for _ in 0..8 {
        let next = covariance.map(|row| row[0] * axis[0] + row[1] * axis[1] + row[2] * axis[2]);
        let greatest = next.iter().fold(0.0_f32, |m, v| m.max(v.abs()));
        if !(greatest > 0.0) {
            break;
        }
        axis = next.map(|v| v / greatest);
    }
    axis
}

/// The block of two endpoints with the nearest of its colours for each texel, and its error.
fn pack(points: &[[f32; 3]; 16], scale: [f32; 3], ends: [[u8; 3]; 2], four: bool) -> (f32, [u8; 8]) {
    let number = |e: [u8; 3]| u16::from(e[0]) << 11 | u16::from(e[1]) << 5 | u16::from(e[2]);
    let [mut a, mut b] = ends;
    // The order of the endpoints tells the two kinds of blocks apart.
    if (number(a) > number(b)) != four {
        (a, b) = (b, a);
    }
    let mix = |share: f32| -> [f32; 3] {
        std::array::from_fn(|c| (share * f32::from(a[c]) + (1.0 - share) * f32::from(b[c])) * 255.0 / TOP[c] * scale[c])
    };
    let palette = if four {
        vec![mix(1.0), mix(0.0), mix(2.0 / 3.0), mix(1.0 / 3.0)]
    } else {
        vec![mix(1.0), mix(0.0), mix(0.5)]
    };
    // Equal endpoints make a block of three colours, whose first is as good as all.
    let palette = if a == b { &palette[..1] } else { &palette[..] };
    let (mut error, mut indices) = (0.0, 0_u32);
    for (i, p) in points.iter().enumerate() {
        let far = |q: &[f32; 3]| (0..3).map(|c| (p[c] - q[c]) * (p[c] - q[c])).sum::<f32>();
        let mut nearest = (far(&palette[0]), 0);
        for (j, q) in palette.iter().enumerate().skip(1) {
            let d = far(q);
            if d < nearest.0 {
                nearest = (d, j as u32);
            }
        }
        error += nearest.0;
        indices |= nearest.1 << (2 * i);
    }
    (error, bytes(number(a), number(b), indices))
}

fn bytes(a: u16, b: u16, indices: u32) -> [u8; 8] {
    (u64::from(a) | u64::from(b) << 16 | u64::from(indices) << 32).to_le_bytes()
}

/// For each byte the two codes of 5 or 6 bits whose mixture 2:1 is nearest to it; of equal ones, those nearest to each other.
static MIXTURES: LazyLock<[[[u8; 2]; 256]; 2]> = LazyLock::new(|| {
    [31_i32, 63].map(|top| {
        std::array::from_fn(|v| {
            let mut best = (i32::MAX, [0; 2]);
            for a in 0..=top {
                for b in 0..=top {
                    let error = ((2 * a + b) * 255 - 3 * top * v as i32).abs() * 64 + (a - b).abs();
                    if error < best.0 {
                        best = (error, [a as u8, b as u8]);
                    }
                }
            }
            best.1
        })
    })
});

/// The block that shows one colour.
fn flat(color: [u8; 3]) -> [u8; 8] {
    let [r, g, b] =
        [(0, color[0]), (1, color[1]), (0, color[2])].map(|(table, v)| MIXTURES[table][v as usize].map(u16::from));
    let [first, second] = [0, 1].map(|i| r[i] << 11 | g[i] << 5 | b[i]);
    match first.cmp(&second) {
        // All texels take the mixture 2:1 of the first and second, or that of the second and first.
        Ordering::Greater => bytes(first, second, 0xaaaa_aaaa),
        Ordering::Less => bytes(second, first, 0xffff_ffff),
        Ordering::Equal => bytes(first, second, 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn blocks_are_as_the_format_says() {
        let indices = 0b11_10_01_00_u8;
        let block = |a: u16, b: u16| {
            let ([a0, a1], [b0, b1]) = (a.to_le_bytes(), b.to_le_bytes());
            [a0, a1, b0, b1, indices, indices, indices, indices]
        };
        let (red, blue) = (31 << 11, 31);
        let four = decode(block(red, blue), false);
        assert_eq!(four[..4], [[255, 0, 0], [0, 0, 255], [170, 0, 85], [85, 0, 170]]);
        let three = decode(block(blue, red), false);
        assert_eq!(three[4..8], [[0, 0, 255], [255, 0, 0], [128, 0, 128], [0, 0, 0]]);
        assert_eq!(decode(block(blue, red), true)[..4], [[0, 0, 255], [255, 0, 0], [85, 0, 170], [170, 0, 85]]);
        // A code in the middle of the range: 17·255/31 = 139.8, 33·255/63 = 133.6.
        assert_eq!(decode(block(17 << 11 | 33 << 5 | 17, 0), false)[0], [140, 134, 140]);
    }

    fn squared(colors: &[[u8; 3]; 16], block: [u8; 8], always_four: bool) -> u32 {
        let decoded = decode(block, always_four);
        let pairs = decoded.as_flattened().iter().zip(colors.as_flattened());
        pairs.map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2)).sum()
    }

    /// The simple encoder: the ends of the colours' bounding box, and the nearest of the four colours.
    fn box_fit(colors: &[[u8; 3]; 16]) -> [u8; 8] {
        let code = |pick: fn(u8, u8) -> u8, start: u8| {
            let [r, g, b] = std::array::from_fn(|c| colors.iter().fold(start, |m, t| pick(m, t[c])));
            let scale = |v: u8, top: u32| ((u32::from(v) * top + 127) / 255) as u16;
            scale(r, 31) << 11 | scale(g, 63) << 5 | scale(b, 31)
        };
        let (high, low) = (code(u8::max, 0), code(u8::min, 255));
        let ([a0, a1], [b0, b1]) = (high.to_le_bytes(), low.to_le_bytes());
        let palette = decode([a0, a1, b0, b1, 0b11_10_01_00, 0, 0, 0], true);
        let mut bits = 0_u32;
        for (i, t) in colors.iter().enumerate() {
            let far = |j: &usize| (0..3).map(|c| u32::from(palette[*j][c].abs_diff(t[c])).pow(2)).sum::<u32>();
            bits |= ((0..4).min_by_key(far).unwrap() as u32) << (2 * i);
        }
        let [i0, i1, i2, i3] = bits.to_le_bytes();
        [a0, a1, b0, b1, i0, i1, i2, i3]
    }

    proptest! {
        #[test]
        fn no_worse_than_the_simple_encoder(
            start in prop::array::uniform3(0..=255_u8),
            end in prop::array::uniform3(0..=255_u8),
            at in prop::array::uniform16(0..=255_u16),
            noise in prop::array::uniform16(0..=12_u8),
        ) {
            let colors: [[u8; 3]; 16] = std::array::from_fn(|i| std::array::from_fn(|c| {
                let v = (u16::from(start[c]) * (255 - at[i]) + u16::from(end[c]) * at[i]) / 255;
                (v as u8).saturating_add(noise[(5 * i + c) % 16])
            }));
            for always_four in [false, true] {
                let found = squared(&colors, encode(&colors, false, always_four), always_four);
                let simple = squared(&colors, box_fit(&colors), true);
                // Errors here are of rounded bytes.
                prop_assert!(f64::from(found).sqrt() <= f64::from(simple).sqrt() + 4.0, "{} {}", found, simple);
            }
        }

        #[test]
        fn blocks_are_opaque(colors in prop::array::uniform16(prop::array::uniform3(prop::sample::select(vec![0, 3, 90, 255_u8])))) {
            let block = encode(&colors, true, false);
            let four = u16::from_le_bytes([block[0], block[1]]) > u16::from_le_bytes([block[2], block[3]]);
            let indices = u32::from_le_bytes([block[4], block[5], block[6], block[7]]);
            prop_assert!(four || (0..16).all(|i| indices >> (2 * i) & 3 != 3));
            // The colours of BC3 read the same with either rule.
            let block = encode(&colors, true, true);
            prop_assert_eq!(decode(block, true), decode(block, false));
        }

        #[test]
        fn one_colour_is_met_within_the_steps_of_the_codes(color in prop::array::uniform3(0..=255_u8)) {
            for always_four in [false, true] {
                let decoded = decode(encode(&[color; 16], true, always_four), always_four);
                for (a, b) in decoded.as_flattened().iter().zip([color; 16].as_flattened()) {
                    prop_assert!(a.abs_diff(*b) <= 2, "{} {}", a, b);
                }
            }
        }

        #[test]
        fn colours_on_a_line_perpendicular_to_grey_are_kept_apart(red in 0..=255_u8, n in 1..16_usize) {
            let colors: [[u8; 3]; 16] = std::array::from_fn(|i| if i < n { [red, 255 - red, 80] } else { [255 - red, red, 80] });
            let decoded = decode(encode(&colors, false, false), false);
            for (a, b) in decoded.as_flattened().iter().zip(colors.as_flattened()) {
                prop_assert!(a.abs_diff(*b) <= 5, "{:?} {:?}", decoded, colors);
            }
        }
    }
}
