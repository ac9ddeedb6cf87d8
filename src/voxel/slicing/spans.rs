//! Which samples a triangle on the sample grid covers, which pixels a cut touches, and which layer a sample lies in.
//!
//! Coordinates are steps of 1/256 pixel, y down, and all decisions exact in integers, but for the depth of a sample:
//! that is one fixed expression, so that every sample of a surface lies in exactly one layer.

/// Fixed-point steps per pixel.
pub const STEPS: i64 = 256;

/// Samples per pixel: `n` by `n`, n a power of two, each in the middle of its share of the pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Samples(pub u32);

impl Samples {
    /// Position of sample column or row `i`, steps.
    #[inline]
    pub fn step(self, i: i32) -> i64 {
        let step = STEPS / i64::from(self.0);
        i64::from(i) * step + step / 2
    }

    /// Position of sample column or row `i`, pixels.
    #[inline]
    pub fn pixel(self, i: i32) -> f64 {
        (f64::from(i) + 0.5) / f64::from(self.0)
    }
}

/// Twice the signed area in square steps; positive where the corners run clockwise on the screen.
pub fn doubled_area(c: &[[i32; 2]; 3]) -> i64 {
    let d = |i: usize, k: usize| i64::from(c[i][k]) - i64::from(c[0][k]);
    d(1, 0) * d(2, 1) - d(1, 1) * d(2, 0)
}

/// E(x, y) of edge `i` of a clockwise triangle, less 1 where the edge is no top or left one: covered where ≥ 0 on all.
#[inline]
pub fn edge(c: &[[i32; 2]; 3], i: usize, x: i64, y: i64) -> i64 {
    let (a, b) = (c[i], c[(i + 1) % 3]);
    let (ex, ey) = (i64::from(b[0]) - i64::from(a[0]), i64::from(b[1]) - i64::from(a[1]));
    let top_left = ey < 0 || (ey == 0 && ex > 0);
    ex * (y - i64::from(a[1])) - ey * (x - i64::from(a[0])) - i64::from(!top_left)
}

/// Calls `span(y, x0, x1)` with the covered sample columns x0..=x1 of every sample row in `rows`, kept to columns
/// 0..`width`.
pub fn cover(
    c: &[[i32; 2]; 3],
    samples: Samples,
    rows: std::ops::Range<i32>,
    width: i32,
    mut span: impl FnMut(i32, i32, i32),
) {
    let step = STEPS / i64::from(samples.0);
    let first = |v: i64| (v - step / 2 + step - 1).div_euclid(step) as i32;
    let last = |v: i64| (v - step / 2).div_euclid(step) as i32;
    let bound = |k: usize| {
        let v = [i64::from(c[0][k]), i64::from(c[1][k]), i64::from(c[2][k])];
        (first(v[0].min(v[1]).min(v[2])), last(v[0].max(v[1]).max(v[2])))
    };
    let ((x_min, x_max), (y_min, y_max)) = (bound(0), bound(1));
    let (x_min, x_max) = (x_min.max(0), x_max.min(width - 1));
    if x_min > x_max {
        return;
    }
    for y in y_min.max(rows.start)..=y_max.min(rows.end - 1) {
        let (mut from, mut to) = (i64::from(x_min), i64::from(x_max));
        for i in 0..3 {
            // E at sample column k is e − slope·k.
            let e = edge(c, i, samples.step(0), samples.step(y));
            let slope = (i64::from(c[(i + 1) % 3][1]) - i64::from(c[i][1])) * step;
            match slope {
                0 if e < 0 => to = from - 1,
                0 => {}
                s if s > 0 => to = to.min(e.div_euclid(s)),
                s => from = from.max(-e.div_euclid(-s)),
            }
        }
        if from <= to {
            span(y, from as i32, to as i32);
        }
    }
}

/// Calls `span(y, x0, x1)` with the pixels x0..=x1 of every pixel row in `rows` whose closed squares the segment
/// touches, kept to 0..`width`.
pub fn touch(a: [i32; 2], b: [i32; 2], rows: std::ops::Range<i32>, width: i32, mut span: impl FnMut(i32, i32, i32)) {
    // One canonical direction: downward, then to the right.
    let (a, b) = if (a[1], a[0]) <= (b[1], b[0]) { (a, b) } else { (b, a) };
    let [ax, ay, bx, by] = [a[0], a[1], b[0], b[1]].map(i64::from);
    let (dx, dy) = (bx - ax, by - ay);
    let first_row = (ay.div_euclid(STEPS) - i64::from(ay.rem_euclid(STEPS) == 0)).max(i64::from(rows.start));
    let last_row = by.div_euclid(STEPS).min(i64::from(rows.end) - 1);
    for row in first_row..=last_row {
        // The segment's x where it enters and leaves the row's strip, times dy (1 for a level segment).
        let (enter, leave, scale) = if dy == 0 {
            (ax, bx, 1)
        } else {
            let at = |y: i64| ax * dy + (y.clamp(ay, by) - ay) * dx;
            (at(row * STEPS), at((row + 1) * STEPS), dy)
        };
        let (least, most) = (enter.min(leave), enter.max(leave));
        let pixel = STEPS * scale;
        // ⌈least/pixel⌉ − 1 and ⌊most/pixel⌋: closed squares, so a segment on a line between pixels touches both.
        let x0 = (-(-least).div_euclid(pixel) - 1).max(0);
        let x1 = most.div_euclid(pixel).min(i64::from(width) - 1);
        if x0 <= x1 {
            span(row as i32, x0 as i32, x1 as i32);
        }
    }
}

/// Inverse depth over the image and the borders it is compared with.
#[derive(Clone, Copy)]
pub struct Depths<'a> {
    /// 1/border for every border.
    pub inverse: &'a [f64],
    /// a·px + b·py + c is the inverse depth of the surface.
    pub plane: [f64; 3],
    /// Its least and greatest value on the surface: nothing is extrapolated where an edge was snapped outward.
    pub range: [f64; 2],
    /// Layers that the surface reaches, both included.
    pub first: u16,
    pub last: u16,
}

impl Depths<'_> {
    /// The layer of an inverse depth.
    #[inline]
    pub fn layer(&self, q: f64) -> u16 {
        let inner = &self.inverse[usize::from(self.first) + 1..=usize::from(self.last)];
        self.first + inner.partition_point(|border| q <= *border) as u16
    }

    #[inline]
    pub fn at(&self, samples: Samples, x: i32, y: i32) -> f64 {
        let q = self.plane[0] * samples.pixel(x) + (self.plane[1] * samples.pixel(y) + self.plane[2]);
        q.max(self.range[0]).min(self.range[1])
    }

    /// Cuts sample columns x0..=x1 of row y into runs of one layer. Inverse depth is monotone along a row, rounding
    /// included, and so is the layer.
    #[inline]
    pub fn runs(&self, samples: Samples, y: i32, x0: i32, x1: i32, mut run: impl FnMut(u16, i32, i32)) {
        if self.first == self.last {
            return run(self.first, x0, x1);
        }
        let layer = |x: i32| self.layer(self.at(samples, x, y));
        let last = layer(x1);
        let mut from = x0;
        while from <= x1 {
            let here = layer(from);
            // The end of the run: the greatest x whose layer is still `here`.
            let (mut low, mut high) = (from, x1);
            if here != last {
                while high - low > 1 {
                    let middle = low + (high - low) / 2;
                    if layer(middle) == here { low = middle } else { high = middle }
                }
            } else {
                low = x1;
            }
            run(here, from, low);
            from = low + 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Whether a segment meets a closed pixel, by separating axes in integers.
    pub fn meets(a: [i32; 2], b: [i32; 2], x: i32, y: i32) -> bool {
        let [ax, ay, bx, by] = [a[0], a[1], b[0], b[1]].map(i64::from);
        let (l, t) = (i64::from(x) * STEPS, i64::from(y) * STEPS);
        let (r, d) = (l + STEPS, t + STEPS);
        if ax.max(bx) < l || ax.min(bx) > r || ay.max(by) < t || ay.min(by) > d {
            return false;
        }
        let side = |x: i64, y: i64| ((bx - ax) * (y - ay) - (by - ay) * (x - ax)).signum();
        let sides = [side(l, t), side(r, t), side(l, d), side(r, d)];
        !(sides.iter().all(|s| *s > 0) || sides.iter().all(|s| *s < 0))
    }

    fn point() -> impl Strategy<Value = [i32; 2]> {
        // Often on lines between pixels.
        let c = || prop_oneof![-300..2500i32, (-1..9i32).prop_map(|p| p * 256)];
        [c(), c()]
    }

    proptest! {
        #[test]
        fn touched_pixels_are_those_that_meet_the_segment(a in point(), b in point()) {
            let mut touched = vec![];
            touch(a, b, 0..8, 8, |y, x0, x1| touched.extend((x0..=x1).map(|x| (y, x))));
            let mut reversed = vec![];
            touch(b, a, 0..8, 8, |y, x0, x1| reversed.extend((x0..=x1).map(|x| (y, x))));
            let all = (0..8).flat_map(|y| (0..8).map(move |x| (y, x)));
            prop_assert_eq!(&touched, &all.filter(|(y, x)| meets(a, b, *x, *y)).collect::<Vec<_>>());
            prop_assert_eq!(touched, reversed);
        }

        #[test]
        fn covered_samples_are_those_inside_all_edges(a in point(), b in point(), c in point(), log in 0..3u32) {
            let (samples, n) = (Samples(1 << log), 8 << log);
            let mut t = [a, b, c];
            if doubled_area(&t) < 0 {
                t.swap(1, 2);
            }
            prop_assume!(doubled_area(&t) > 0);
            let mut covered = vec![];
            cover(&t, samples, 0..n, n, |y, x0, x1| covered.extend((x0..=x1).map(|x| (y, x))));
            let inside = |x: i32, y: i32| (0..3).all(|i| edge(&t, i, samples.step(x), samples.step(y)) >= 0);
            let all = (0..n).flat_map(|y| (0..n).map(move |x| (y, x)));
            prop_assert_eq!(covered, all.filter(|(y, x)| inside(*x, *y)).collect::<Vec<_>>());
        }

        #[test]
        fn runs_agree_with_single_samples(
            plane in [-0.1..0.1f64, -0.1..0.1f64, -1.0..1.0f64],
            first in 0..4u16, span in 0..4u16, x0 in 0..10i32, n in 0..20i32, y in 0..20i32,
        ) {
            let inverse = [1.0, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05, 0.0];
            let depths = Depths { inverse: &inverse, plane, range: [0.1, 0.8], first, last: (first + span).min(6) };
            let mut single: Vec<_> = (x0..=x0 + n).map(|x| (x, depths.layer(depths.at(Samples(2), x, y)))).collect();
            let mut runs = vec![];
            depths.runs(Samples(2), y, x0, x0 + n, |l, a, b| runs.extend((a..=b).map(|x| (x, l))));
            single.sort();
            prop_assert_eq!(runs, single);
        }
    }
}
