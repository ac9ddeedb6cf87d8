//! Dilation: what is beside a surface takes the colour of the nearest pixel of it.

/// Fills the pixels where `known` is false with the value of the nearest known pixel: distances are chessboard distances, of equals the first
/// in reading order of its neighbours wins. Nothing changes where no pixel is known. Linear in the number of pixels.
///
/// # Panics
/// Where the two lists have different lengths, or their length is no multiple of `width`.
pub fn dilate<T: Copy>(values: &mut [T], known: &[bool], width: usize) {
    assert!(values.len() == known.len() && values.len().is_multiple_of(width.max(1)), "one flag a pixel, whole rows");
    let height = values.len() / width.max(1);
    let mut done = known.to_vec();
    let around = |i: usize| {
        let (x, y) = (i % width, i / width);
        let (x0, x1, y0, y1) =
            (x.saturating_sub(1), (x + 1).min(width - 1), y.saturating_sub(1), (y + 1).min(height - 1));
        (y0..=y1).flat_map(move |y| (x0..=x1).map(move |x| y * width + x)).filter(move |j| *j != i)
    };
    let mut ring: Vec<usize> = (0..values.len()).filter(|i| !done[*i] && around(*i).any(|j| done[j])).collect();
    while !ring.is_empty() {
        // All of a ring look at what was there before it.
        let found: Vec<T> =
            ring.iter().map(|i| around(*i).find(|j| done[*j]).map_or(values[*i], |j| values[j])).collect();
        for (i, value) in ring.iter().zip(found) {
            (values[*i], done[*i]) = (value, true);
        }
        let mut next: Vec<usize> = ring.iter().flat_map(|i| around(*i)).filter(|j| !done[*j]).collect();
        next.sort_unstable();
        next.dedup();
        ring = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_pixel_takes_a_nearest_known_one(
            width in 1..9_usize,
            pixels in prop::collection::vec(prop::option::weighted(0.2, 0..100_u32), 1..80),
        ) {
            let n = (pixels.len() / width).max(1) * width;
            let pixels: Vec<Option<u32>> = (0..n).map(|i| pixels.get(i).copied().flatten()).collect();
            let known: Vec<bool> = pixels.iter().map(Option::is_some).collect();
            let mut values: Vec<u32> = pixels.iter().map(|p| p.unwrap_or(1000)).collect();
            dilate(&mut values, &known, width);
            let far = |a: usize, b: usize| (a % width).abs_diff(b % width).max((a / width).abs_diff(b / width));
            for i in 0..n {
                let least = (0..n).filter(|j| known[*j]).map(|j| far(i, j)).min();
                match least {
                    None => prop_assert_eq!(values[i], 1000),
                    Some(d) => {
                        let right = (0..n).any(|j| known[j] && far(i, j) == d && pixels[j] == Some(values[i]));
                        prop_assert!(right, "pixel {} of {}", i, width);
                    }
                }
            }
        }
    }
}
