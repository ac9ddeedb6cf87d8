//! Bit masks of an image: one bit a pixel, rows of 64-bit words, with an apron of one pixel all round.
//!
//! Pixel (x, y) is bit x + 1 of row y + 1; bits beyond the apron are 0.

/// Shape of a mask.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    pub width: u32,
    pub height: u32,
    /// Words in a row.
    pub words: usize,
}

impl Shape {
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, words: (width as usize + 2).div_ceil(64) }
    }

    /// A mask of zeros, apron included.
    pub fn zeros(&self) -> Vec<u64> {
        vec![0; self.words * (self.height as usize + 2)]
    }

    /// Where row y begins; y = −1 and y = height are the apron.
    pub fn row(&self, y: i32) -> usize {
        (y + 1) as usize * self.words
    }
}

/// Calls `f(word, bits)` with where in a row the pixels x + i lie whose bit i is set in `bits`.
#[inline]
pub fn for_words(x: u32, bits: u64, mut f: impl FnMut(usize, u64)) {
    let (word, shift) = ((x as usize + 1) / 64, (x + 1) % 64);
    f(word, bits << shift);
    let rest = bits >> 1 >> (63 - shift);
    if rest != 0 {
        f(word + 1, rest);
    }
}

/// Pixel x of a row; −1 and the width are the apron.
#[inline]
pub fn get(row: &[u64], x: i32) -> bool {
    let bit = (x + 1) as usize;
    row[bit / 64] >> (bit % 64) & 1 == 1
}

pub fn put(row: &mut [u64], x: i32, value: bool) {
    let bit = (x + 1) as usize;
    row[bit / 64] = row[bit / 64] & !(1 << (bit % 64)) | u64::from(value) << (bit % 64);
}

/// One row of the mask eroded by 3×3: pixels that are set together with their eight neighbours. `out`'s apron is 0.
pub fn erode_row(above: &[u64], row: &[u64], below: &[u64], width: u32, out: &mut [u64]) {
    let column = |w: usize| above[w] & row[w] & below[w];
    let last = out.len() - 1;
    let (mut left, mut here) = (0, column(0));
    for (w, out) in out.iter_mut().enumerate() {
        let right = if w < last { column(w + 1) } else { 0 };
        *out = here & (here << 1 | left >> 63) & (here >> 1 | right << 63);
        (left, here) = (here, right);
    }
    put(out, -1, false);
    put(out, width as i32, false);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn words_erode_as_single_pixels_do(
            width in 1..200u32,
            rows in prop::array::uniform3(prop::collection::vec(prop::bool::weighted(0.9), 202)),
        ) {
            let shape = Shape::new(width, 1);
            let mut mask = shape.zeros();
            for (y, pixels) in (-1..=1).zip(&rows) {
                for x in -1..=width as i32 {
                    let at = shape.row(y);
                    put(&mut mask[at..at + shape.words], x, pixels[(x + 1) as usize]);
                }
            }
            let mut out = vec![!0; shape.words];
            let row = |y: i32| &mask[shape.row(y)..shape.row(y) + shape.words];
            erode_row(row(-1), row(0), row(1), width, &mut out);
            for x in -1..=width as i32 {
                let inside = x >= 0 && x < width as i32;
                let expect = inside && rows.iter().all(|r| r[x as usize] && r[(x + 1) as usize] && r[(x + 2) as usize]);
                prop_assert_eq!(get(&out, x), expect, "{}", x);
            }
        }

        #[test]
        fn bits_land_on_their_pixels(x in 0..300u32, bits in any::<u64>()) {
            let mut row = vec![0; Shape::new(400, 1).words];
            for_words(x, bits, |word, bits| row[word] |= bits);
            for i in -1..400i32 {
                let bit = i - x as i32;
                prop_assert_eq!(get(&row, i), (0..64).contains(&bit) && bits >> bit & 1 == 1, "{}", i);
            }
        }
    }
}
