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

/// A block near to `colors`. Errors of sRGB colours are weighted by how bright the channels look.
///
/// The colours are sorted along their principal axis; every way of cutting this order into clusters, one for each colour of the block, gives endpoints by
/// least squares, of which the best are kept (Brown 2006, "DXT Compression Techniques"). Endpoints are then rounded to codes, and found again for the
/// colours that the texels chose, as long as this helps. Black is never taken from a block of three colours, where some read it as transparent.
pub(super) fn encode(colors: &[[u8; 3]; 16], srgb: bool, always_four: bool) -> [u8; 8] {
    if colors.iter().all(|c| *c == colors[0]) {
        return flat(colors[0]);
    }
    let weights = if srgb { LUMA } else { [1.0; 3] };
    let scale = weights.map(|w: f32| w.sqrt() / 255.0);
    let points = colors.map(|c| std::array::from_fn(|i| f32::from(c[i]) * scale[i]));
    let fit = Fit::new(points, scale);
    let four = fit.best(true);
    if always_four {
        return four.block;
    }
    let three = fit.best(false);
    if three.error < four.error { three.block } else { four.block }
}

/// How much red, green and blue contribute to luminance (BT.709).
const LUMA: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Highest codes.
const TOP: [f32; 3] = [31.0, 63.0, 31.0];

/// Shares of the first endpoint in the colours of a block, by their index.
const FOUR: [f32; 4] = [1.0, 0.0, 2.0 / 3.0, 1.0 / 3.0];
const THREE: [f32; 3] = [1.0, 0.0, 0.5];

/// Sums over sixteen colours of a², b² and a·b, where a and b = 1 − a are a colour's shares of the endpoints.
#[derive(Clone, Copy)]
struct Shares {
    aa: f32,
    bb: f32,
    ab: f32,
    /// 1/(a²·b² − (a·b)²).
    inverse: f32,
}

impl Shares {
    /// `None` where all shares are equal: endpoints are not determined.
    fn of(shares: impl Iterator<Item = f32>) -> Option<Self> {
        let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
        for a in shares {
            let b = 1.0 - a;
            (aa, bb, ab) = (aa + a * a, bb + b * b, ab + a * b);
        }
        let det: f32 = aa * bb - ab * ab;
        (det > 1e-3).then(|| Self { aa, bb, ab, inverse: 1.0 / det })
    }
}

/// A cut of sixteen colours into clusters: how many colours lie before the end of the first, second and third.
type Ends = [usize; 3];

/// Shares of the colours in the clusters of a cut.
fn shares([i, j, k]: Ends, of: [f32; 4]) -> Option<Shares> {
    Shares::of((0..16).map(|n| of[usize::from(n >= i) + usize::from(n >= j) + usize::from(n >= k)]))
}

/// The shares of four clusters, and of three: there the second and third end are one.
const CLUSTERS: [[f32; 4]; 2] = [[1.0, 2.0 / 3.0, 1.0 / 3.0, 0.0], [1.0, 0.5, 0.5, 0.0]];

/// Numbers for each last end of a cut, 0 to 16, and for as many more as make whole vectors.
type Lanes = [f32; 20];

/// [`Shares::inverse`] of all cuts by their first ends; not a number where there is no cut.
struct Inverses {
    /// By i and j, then k.
    four: Vec<Lanes>,
    /// By i, then j.
    three: Vec<Lanes>,
}

static INVERSES: LazyLock<Inverses> = LazyLock::new(|| {
    let lanes = |first: usize, ends: &dyn Fn(usize) -> Ends, of| -> Lanes {
        std::array::from_fn(|last| {
            let cut = (first..=16).contains(&last).then(|| shares(ends(last), of)).flatten();
            cut.map_or(f32::NAN, |s| s.inverse)
        })
    };
    let pairs = (0..=16).flat_map(|i| (0..=16).map(move |j| (i, j)));
    Inverses {
        // Before i there is no j.
        four: pairs.map(|(i, j)| lanes(if j < i { 17 } else { j }, &|k| [i, j, k], CLUSTERS[0])).collect(),
        three: (0..=16).map(|i| lanes(i, &|j| [i, j, j], CLUSTERS[1])).collect(),
    }
});

/// Colours about their mean, scaled so that all channels count alike.
struct Fit {
    points: [[f32; 3]; 16],
    mean: [f32; 3],
    /// Sum of the first 0 to 16 of the colours along the axis.
    sums: [[f32; 3]; 17],
    scale: [f32; 3],
}

/// A block and its sum of squared errors.
struct Packed {
    error: f32,
    block: [u8; 8],
}

impl Fit {
    fn new(points: [[f32; 3]; 16], scale: [f32; 3]) -> Self {
        let mean: [f32; 3] = std::array::from_fn(|c| points.iter().map(|p| p[c]).sum::<f32>() / 16.0);
        let points = points.map(|p| std::array::from_fn(|c| p[c] - mean[c]));
        let axis = principal_axis(&points);
        let along = points.map(|p| p[0] * axis[0] + p[1] * axis[1] + p[2] * axis[2]);
        let mut order: [usize; 16] = std::array::from_fn(|i| i);
        order.sort_by(|a, b| along[*a].total_cmp(&along[*b]));
        let mut sums = [[0.0; 3]; 17];
        for (n, i) in order.into_iter().enumerate() {
            sums[n + 1] = std::array::from_fn(|c| sums[n][c] + points[i][c]);
        }
        Self { points, mean, sums, scale }
    }

    /// The best block of four or three colours that the search finds.
    fn best(&self, four: bool) -> Packed {
        // Where endpoints leave the range of codes or few colours leave a choice, those of the outermost colours can be better.
        let cut = self.cut(four);
        let best = shares(cut, CLUSTERS[usize::from(!four)]);
        let outermost = self.settle(self.outermost(), four);
        let Some(best) = best else { return outermost };
        let fitted = self.settle(self.ends(best, self.first(cut, four)), four);
        if outermost.error < fitted.error { outermost } else { fitted }
    }

    /// The sum of a·colour for a cut.
    fn first(&self, cut: Ends, four: bool) -> [f32; 3] {
        let [i, j, k] = cut.map(|n| &self.sums[n]);
        let (third, last) = if four { (1.0 / 3.0, 1.0) } else { (0.5, 0.0) };
        std::array::from_fn(|c| (i[c] + j[c] + last * k[c]) * third)
    }

    /// The cut of which least squares leave the smallest error; of equal ones the first.
    fn cut(&self, four: bool) -> Ends {
        // About their mean, the colours' sum of a·colour is the negative of that of b·colour, and least squares leave their sum of squares less
        // 16 |sum of a·colour|² / det.
        let third = if four { 1.0 / 3.0 } else { 0.5 };
        let last: [Lanes; 3] = std::array::from_fn(|c| std::array::from_fn(|n| self.sums.get(n).map_or(0.0, |s| s[c])));
        let (mut most, mut best) = (-1.0, [0; 3]);
        let mut search = |start: [f32; 3], inverses: &Lanes, ends: &dyn Fn(usize) -> Ends| {
            let mut gains: Lanes = [0.0; 20];
            for (n, gain) in gains.iter_mut().enumerate() {
                let [x, y, z]: [f32; 3] = std::array::from_fn(|c| (start[c] + last[c][n]) * third);
                *gain = (x * x + y * y + z * z) * inverses[n];
            }
            if gains.iter().fold(-1.0_f32, |m, g| if *g > m { *g } else { m }) > most {
                for (n, gain) in gains.iter().enumerate().filter(|(_, gain)| !gain.is_nan()) {
                    if *gain > most {
                        (most, best) = (*gain, ends(n));
                    }
                }
            }
        };
        for i in 0..=16 {
            if four {
                for j in i..=16 {
                    let start = std::array::from_fn(|c| self.sums[i][c] + self.sums[j][c]);
                    search(start, &INVERSES.four[17 * i + j], &|k| [i, j, k]);
                }
            } else {
                search(self.sums[i], &INVERSES.three[i], &|j| [i, j, j]);
            }
        }
        best
    }

    /// The codes of the first and last colour along the axis.
    fn outermost(&self) -> [[u8; 3]; 2] {
        let last = std::array::from_fn(|c| self.sums[16][c] - self.sums[15][c]);
        [self.sums[1], last].map(|color| self.codes(color))
    }

    /// The best block on the way from endpoints to those that least squares give for the colours that the texels chose.
    fn settle(&self, ends: [[u8; 3]; 2], four: bool) -> Packed {
        let (mut packed, mut shares) = self.pack(ends, four);
        for _ in 0..4 {
            let Some(sums) = Shares::of(shares.into_iter()) else { break };
            let mut first = [0.0; 3];
            for (p, a) in self.points.iter().zip(shares) {
                first.iter_mut().zip(p).for_each(|(sum, v)| *sum += a * v);
            }
            let (next, next_shares) = self.pack(self.ends(sums, first), four);
            if next.error >= packed.error {
                break;
            }
            (packed, shares) = (next, next_shares);
        }
        packed
    }

    /// The codes of the endpoints by least squares; `first` is the sum of a·colour.
    fn ends(&self, sums: Shares, first: [f32; 3]) -> [[u8; 3]; 2] {
        [(sums.bb + sums.ab) * sums.inverse, -(sums.aa + sums.ab) * sums.inverse]
            .map(|factor| self.codes(first.map(|v| v * factor)))
    }

    /// The codes nearest to a colour about the mean.
    fn codes(&self, color: [f32; 3]) -> [u8; 3] {
        std::array::from_fn(|c| {
            let value = (self.mean[c] + color[c]) / (255.0 * self.scale[c]);
            (value * TOP[c] + 0.5).clamp(0.0, TOP[c]) as u8
        })
    }

    /// The block of two endpoints with the nearest of its colours for each texel, and the texels' shares of its first endpoint.
    fn pack(&self, [mut a, mut b]: [[u8; 3]; 2], four: bool) -> (Packed, [f32; 16]) {
        let number = |e: [u8; 3]| u16::from(e[0]) << 11 | u16::from(e[1]) << 5 | u16::from(e[2]);
        // The order of the endpoints tells the two kinds of blocks apart.
        if (number(a) > number(b)) != four {
            (a, b) = (b, a);
        }
        // Equal endpoints make a block of three colours, whose first is as good as all.
        let of: &[f32] = if a == b {
            &THREE[..1]
        } else if four {
            &FOUR
        } else {
            &THREE
        };
        let mut palette = [[f32::INFINITY; 3]; 4];
        for (color, share) in palette.iter_mut().zip(of) {
            for c in 0..3 {
                let code = share * f32::from(a[c]) + (1.0 - share) * f32::from(b[c]);
                color[c] = code * (255.0 / TOP[c]) * self.scale[c] - self.mean[c];
            }
        }
        let (mut error, mut indices, mut shares) = (0.0, 0_u32, [0.0; 16]);
        for (i, p) in self.points.iter().enumerate() {
            let mut nearest = (f32::INFINITY, 0);
            for (j, q) in palette.iter().enumerate() {
                let [x, y, z]: [f32; 3] = std::array::from_fn(|c| p[c] - q[c]);
                let far = x * x + y * y + z * z;
                if far < nearest.0 {
                    nearest = (far, j);
                }
            }
            error += nearest.0;
            indices |= (nearest.1 as u32) << (2 * i);
            shares[i] = of[nearest.1];
        }
        (Packed { error, block: bytes(number(a), number(b), indices) }, shares)
    }
}

/// The direction in which points with the mean 0 differ most; any where they do not.
fn principal_axis(points: &[[f32; 3]; 16]) -> [f32; 3] {
    let mut covariance = [[0.0_f32; 3]; 3];
    for p in points {
        for (row, a) in covariance.iter_mut().zip(p) {
            row.iter_mut().zip(p).for_each(|(m, b)| *m += a * b);
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

    /// Every cut by itself.
    fn literal_cut(fit: &Fit, four: bool) -> Ends {
        let (mut most, mut best) = (-1.0, [0; 3]);
        for i in 0..=16 {
            for j in i..=16 {
                for k in j..=if four { 16 } else { j } {
                    let Some(sums) = shares([i, j, k], CLUSTERS[usize::from(!four)]) else { continue };
                    let [x, y, z] = fit.first([i, j, k], four);
                    let gain = (x * x + y * y + z * z) * sums.inverse;
                    if gain > most {
                        (most, best) = (gain, [i, j, k]);
                    }
                }
            }
        }
        best
    }

    proptest! {
        #[test]
        fn the_best_cut_is_found(colors in prop::array::uniform16(prop::array::uniform3(prop::sample::select(vec![0, 3, 90, 91, 200, 255_u8])))) {
            let scale = LUMA.map(|w: f32| w.sqrt() / 255.0);
            let fit = Fit::new(colors.map(|c| std::array::from_fn(|i| f32::from(c[i]) * scale[i])), scale);
            for four in [true, false] {
                prop_assert_eq!(fit.cut(four), literal_cut(&fit, four));
            }
        }

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
