//! One channel in blocks of 4 × 4 texels, 8 bytes each (BC4; the alpha of BC3; both channels of BC5).
//!
//! Format: two endpoints, then 3 bits a texel. Where the first endpoint is greater, eight values lie evenly between the two; else six, and 0 and 255. What
//! graphics cards make of it is not rounded to bytes, so errors are judged against the exact values (Vulkan specification, "RGTC compressed
//! texture image formats").

/// The eight values of a block times `7` or `5`, the factor given with them, in the order of their indices.
fn palette(a: u8, b: u8) -> ([i32; 8], i32) {
    let (p, q) = (i32::from(a), i32::from(b));
    if a > b {
        ([7 * p, 7 * q, 6 * p + q, 5 * p + 2 * q, 4 * p + 3 * q, 3 * p + 4 * q, 2 * p + 5 * q, p + 6 * q], 7)
    } else {
        ([5 * p, 5 * q, 4 * p + q, 3 * p + 2 * q, 2 * p + 3 * q, p + 4 * q, 0, 5 * 255], 5)
    }
}

/// The values of a block, rounded to the nearest byte.
pub(super) fn decode(block: [u8; 8]) -> [u8; 16] {
    let (values, scale) = palette(block[0], block[1]);
    let indices = u64::from_le_bytes(block) >> 16;
    std::array::from_fn(|i| {
        let value = values[(indices >> (3 * i)) as usize & 7];
        ((2 * value + scale) / (2 * scale)) as u8
    })
}

/// A block that is as near to `values` as the search below finds.
///
/// Endpoints a little inside the values' range often serve the values between better. So the search starts at the best of a few such pairs and walks to the
/// neighbouring pair with the least sum of squared errors, until no neighbour is better: once for each of the two kinds of blocks, so that texels of 0 and 255
/// cost the others nothing.
pub(super) fn encode(values: &[u8; 16]) -> [u8; 8] {
    let (mut low, mut high) = (255_u8, 0_u8);
    let (mut inner_low, mut inner_high) = (255_u8, 0_u8);
    for v in values {
        (low, high) = (low.min(*v), high.max(*v));
        if *v != 0 && *v != 255 {
            (inner_low, inner_high) = (inner_low.min(*v), inner_high.max(*v));
        }
    }
    if low == high {
        return pack(low, low, values);
    }
    // A short range is met exactly by steps of one.
    let high_start = low.saturating_add(7).max(high);
    let low_start = high_start.saturating_sub(7).min(low);
    let mut best = (i64::MAX, 0, 0);
    for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
        // In 28ths of the range: a quarter of a step between two values.
        let inset = |n: u16| (u16::from(high - low) * n / 28) as u8;
        let (a, b) = (high_start.saturating_sub(inset(i)), low_start.saturating_add(inset(j)));
        if a > b {
            best = best.min((error(values, a, b), a, b));
        }
    }
    best = walk(values, best, |a, b| a > b);
    if low == 0 || high == 255 {
        let (a, b) = if inner_low > inner_high { (low, low) } else { (inner_low, inner_high) };
        let six = walk(values, (error(values, a, b), a, b), |a, b| a <= b);
        if six.0 < best.0 {
            best = six;
        }
    }
    pack(best.1, best.2, values)
}

/// How far the first endpoints lie inside the range, in 28ths of it.
/// Walks from an error and endpoints to better ones that `allowed` permits. Errors are in units of 1/35².
fn walk(values: &[u8; 16], start: (i64, u8, u8), allowed: impl Fn(u8, u8) -> bool) -> (i64, u8, u8) {
    let mut best = start;
    loop {
        let centre = best;
        for da in -1..=1_i16 {
            for db in -1..=1_i16 {
                let moved = (u8::try_from(i16::from(centre.1) + da), u8::try_from(i16::from(centre.2) + db));
                let (Ok(a), Ok(b)) = moved else { continue };
                if (a, b) == (centre.1, centre.2) || !allowed(a, b) {
                    continue;
                }
                let found = error(values, a, b);
                if found < best.0 {
                    best = (found, a, b);
                }
            }
        }
        if best == centre {
            return best;
        }
    }
}

/// The sum of squared errors with the best indices, in units of 1/35².
fn error(values: &[u8; 16], a: u8, b: u8) -> i64 {
    let (palette, scale) = palette(a, b);
    let unit = 35 / scale;
    let sum: i32 = values
        .iter()
        .map(|v| {
            let v = i32::from(*v) * scale;
            let d = palette.iter().fold(i32::MAX, |m, p| m.min((p - v).abs()));
            d * d
        })
        .sum();
    i64::from(sum) * i64::from(unit * unit)
}

/// The block with these endpoints and the best indices; of equal ones the first.
fn pack(a: u8, b: u8, values: &[u8; 16]) -> [u8; 8] {
    let (palette, scale) = palette(a, b);
    let mut bits = u64::from(a) | u64::from(b) << 8;
    for (i, v) in values.iter().enumerate() {
        let v = i32::from(*v) * scale;
        let mut index = 0;
        for j in 1..8 {
            if (palette[j] - v).abs() < (palette[index] - v).abs() {
                index = j;
            }
        }
        bits |= (index as u64) << (16 + 3 * i);
    }
    bits.to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn squared(values: &[u8; 16], block: [u8; 8]) -> i64 {
        error(values, block[0], block[1])
    }

    #[test]
    fn blocks_are_as_the_format_says() {
        // 200 and 60: eight values; 60 and 200: six, 0 and 255.
        let indices = [0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7_u64];
        let bits: u64 = indices.iter().enumerate().map(|(i, index)| index << (16 + 3 * i)).sum();
        let eight = decode((bits | 200 | 60 << 8).to_le_bytes());
        assert_eq!(eight[..8], [200, 60, 180, 160, 140, 120, 100, 80]);
        let six = decode((bits | 60 | 200 << 8).to_le_bytes());
        assert_eq!(six[8..], [60, 200, 88, 116, 144, 172, 0, 255]);
    }

    #[test]
    fn flat_and_short_ranges_and_extremes_are_exact() {
        let mut cases = vec![[0; 16], [255; 16], [77; 16]];
        cases.push(std::array::from_fn(|i| 100 + (i % 8) as u8));
        cases.push(std::array::from_fn(|i| 249 + (i % 7) as u8));
        cases.push(std::array::from_fn(|i| [0, 255, 90, 95, 100, 105, 110, 115][i % 8]));
        cases.push(std::array::from_fn(|i| if i < 8 { 0 } else { 255 }));
        for case in cases {
            assert_eq!(decode(encode(&case)), case);
        }
    }

    proptest! {
        /// All pairs of endpoints, the slow way.
        #[test]
        fn the_walk_comes_close_to_the_best_endpoints(low in 0..=255_u8, span in 1..=255_u8, raw in prop::array::uniform16(0..=255_u8)) {
            let values = raw.map(|v| low.saturating_add((u16::from(v) * u16::from(span) / 255) as u8));
            let found = squared(&values, encode(&values));
            let mut least = i64::MAX;
            for a in 0..=255 {
                for b in 0..=255 {
                    least = least.min(error(&values, a, b));
                }
            }
            // In roots of squares: twice as much, and four codes.
            prop_assert!((found as f64).sqrt() <= 2.0 * (least as f64).sqrt() + 4.0 * 35.0, "{} {}", found, least);
        }

        #[test]
        fn decoded_values_have_the_error_that_was_searched_for(values in prop::array::uniform16(0..=255_u8)) {
            let block = encode(&values);
            let bytes = decode(block);
            let found: f64 = bytes.iter().zip(&values).map(|(a, b)| { let d = f64::from(*a) - f64::from(*b); d * d }).sum();
            let said = squared(&values, block) as f64 / (35.0 * 35.0);
            // Each value is rounded by at most a half.
            prop_assert!((found.sqrt() - said.sqrt()).abs() <= 2.0, "{} {}", found, said);
        }
    }
}
