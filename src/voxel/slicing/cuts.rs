//! The cuts of the surface along the borders between layers, drawn conservatively: a pixel whose closed square a cut
//! touches is filled in the layers on both sides.
//!
//! Coordinates are steps of 1/256 pixel, y down; which pixels a cut touches is exact in integers.

use super::{Face, Soup, groups::Groups, mask, samples::Part};
use crate::{
    math::{Stop, Stopped},
    raster::{Cutout, Holes},
    voxel::{Frustum, Slices},
};
use glam::DVec3;
use rayon::prelude::*;

/// Fixed-point steps per pixel.
pub const STEPS: i64 = 256;

/// A frustum's pixel grid.
#[derive(Clone, Debug)]
pub struct Screen {
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Pixels per tangent, and the pixel position of the axis.
    scale: f64,
    origin: (f64, f64),
    pub width: u32,
    pub height: u32,
}

/// Snapped coordinates stay within this many pixels of the image, so that products of two fit 64 bits.
const GUARD: f64 = 500_000.0;

impl Screen {
    pub fn new(f: &Frustum) -> Self {
        let scale = f64::from(f.size[0]) / (f.right_tan - f.left);
        Self {
            right: f.right,
            up: f.up,
            forward: f.forward,
            scale,
            origin: (-f.left * scale, f.top * scale),
            width: f.size[0],
            height: f.size[1],
        }
    }

    fn local(&self, p: DVec3) -> DVec3 {
        DVec3::new(p.dot(self.right), p.dot(self.up), p.dot(self.forward))
    }

    fn pixel(&self, p: DVec3) -> [f64; 2] {
        [p.x / p.z * self.scale + self.origin.0, self.origin.1 - p.y / p.z * self.scale]
    }

    /// Whether a triangle of camera space may be in the image: not where it lies beyond one side, a pixel farther out.
    fn may_see(&self, v: &[DVec3; 3]) -> bool {
        let (u, w) = (|px: f64| (px - self.origin.0) / self.scale, |py: f64| (self.origin.1 - py) / self.scale);
        let (left, right) = (u(-1.0), u(f64::from(self.width) + 1.0));
        let (top, bottom) = (w(-1.0), w(f64::from(self.height) + 1.0));
        let beyond = v.iter().all(|p| p.x < left * p.z)
            || v.iter().all(|p| p.x > right * p.z)
            || v.iter().all(|p| p.y > top * p.z)
            || v.iter().all(|p| p.y < bottom * p.z);
        !beyond
    }

    /// The part of a segment within the guard band, as parameters (Liang and Barsky 1984).
    fn clip_segment(&self, a: [f64; 2], b: [f64; 2]) -> Option<(f64, f64)> {
        let (mut from, mut to) = (0.0f64, 1.0f64);
        for k in 0..2 {
            let d = b[k] - a[k];
            for (distance, slope) in [(a[k] + GUARD, d), (GUARD - a[k], -d)] {
                // distance + slope·t ≥ 0
                if slope > 0.0 {
                    from = from.max(-distance / slope);
                } else if slope < 0.0 {
                    to = to.min(-distance / slope);
                } else if distance < 0.0 {
                    return None;
                }
            }
        }
        (from <= to).then_some((from, to))
    }
}

fn snap(p: [f64; 2]) -> [i32; 2] {
    p.map(|x| (x * STEPS as f64).round_ties_even() as i32)
}

/// Which triangles each border cuts: places in the [`Soup`], ascending.
pub struct Crossings(Groups);

impl Crossings {
    /// Borders 0 (in front of layer 0) to the one in front of the last layer.
    pub fn new(soup: &Soup, slices: &Slices, screen: &Screen, stop: &Stop) -> Result<Self, Stopped> {
        let borders = &slices.borders[..slices.layers.len()];
        let chunks: Vec<Vec<(u16, u32)>> = soup
            .corners
            .par_chunks(4096)
            .enumerate()
            .map(|(i, chunk)| {
                stop.check()?;
                let mut out = Vec::new();
                for (k, triangle) in chunk.iter().enumerate() {
                    let v = triangle.map(|p| screen.local(p));
                    let (near, far) = (v[0].z.min(v[1].z).min(v[2].z), v[0].z.max(v[1].z).max(v[2].z));
                    let cut = borders.partition_point(|b| *b <= near)..borders.partition_point(|b| *b <= far);
                    if !cut.is_empty() && screen.may_see(&v) {
                        out.extend(cut.map(|b| (b as u16, (i * 4096 + k) as u32)));
                    }
                }
                Ok(out)
            })
            .collect::<Result<_, Stopped>>()?;
        let pairs = chunks.iter().flatten().map(|(border, source)| (usize::from(*border), *source));
        Ok(Self(Groups::new(borders.len(), pairs)))
    }
}

impl Face<'_> {
    /// Calls `found(y, x0, x1, source, cut)` for the pixels x0..=x1 of row y that the cuts along a border touch. Holes are left out.
    pub fn visit_cuts(
        &self,
        border: usize,
        stop: &Stop,
        mut found: impl FnMut(i32, i32, i32, u32, &Cut),
    ) -> Result<(), Stopped> {
        let mut holes = Holes::new(&self.prepared);
        for (count, source) in self.crossings.0.of(border).iter().enumerate() {
            if count % 1024 == 0 {
                stop.check()?;
            }
            let triangle = &self.soup.corners[*source as usize];
            let Some(cut) = Cut::new(triangle, self.borders[border], &self.screen) else { continue };
            let number = self.soup.numbers[*source as usize];
            let masked = matches!(self.prepared.geometry.draw_of(number).cutout, Cutout::Masked(_));
            touch(cut.ends[0], cut.ends[1], self.screen.height as i32, self.screen.width as i32, |y, x0, x1| {
                if !masked {
                    return found(y, x0, x1, *source, &cut);
                }
                for x in x0..=x1 {
                    if holes.solid_at(number, cut.nearest(x as u32, y as u32).1) {
                        found(y, x, x, *source, &cut);
                    }
                }
            });
        }
        Ok(())
    }

    /// The pixels that the cuts along each border touch.
    pub fn cut_parts(&self, stop: &Stop) -> Result<Vec<Vec<Part>>, Stopped> {
        let parts = (0..self.borders.len() - 1).into_par_iter().map(|border| {
            let mut parts: Vec<Part> = Vec::new();
            self.visit_cuts(border, stop, |y, x0, x1, _, _| {
                for x in (x0..=x1).step_by(64) {
                    let bits = !0 >> (63 - (x1 - x).min(63));
                    mask::for_words(x as u32, bits, |word, bits| {
                        parts.push(Part { layer: border as u16, y: y as u16, word: word as u32, bits });
                    });
                }
            })?;
            parts.sort_unstable_by_key(|p| (p.y, p.word));
            parts.dedup_by(|p, kept| {
                let same = (p.y, p.word) == (kept.y, kept.word);
                kept.bits |= if same { p.bits } else { 0 };
                same
            });
            Ok(parts)
        });
        parts.collect()
    }
}

/// Where a triangle meets a border: a segment on the pixel grid, with the barycentric coordinates of its ends.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    pub ends: [[i32; 2]; 2],
    pub weights: [[f64; 3]; 2],
}

impl Cut {
    /// Ends are computed from the nearer to the farther corner of each edge, so triangles that share an edge agree.
    pub fn new(triangle: &[DVec3; 3], border: f64, screen: &Screen) -> Option<Self> {
        let v = triangle.map(|p| screen.local(p));
        let mut ends = [([0.0; 2], [0.0; 3]); 2];
        let mut n = 0;
        for (i, k) in [(0, 1), (1, 2), (2, 0)] {
            let (near, far) = if v[i].z < v[k].z { (i, k) } else { (k, i) };
            if v[near].z < border && border <= v[far].z {
                let t = (border - v[near].z) / (v[far].z - v[near].z);
                let mut weights = [0.0; 3];
                (weights[near], weights[far]) = (1.0 - t, t);
                let p = v[near] + (v[far] - v[near]) * t;
                *ends.get_mut(n)? = (screen.pixel(DVec3::new(p.x, p.y, border)), weights);
                n += 1;
            }
        }
        let ([a, b], 2) = (ends, n) else { return None };
        let (from, to) = screen.clip_segment(a.0, b.0)?;
        let at = |t: f64| {
            let mix = |a: f64, b: f64| a + (b - a) * t;
            let p = if t == 0.0 {
                a.0
            } else if t == 1.0 {
                b.0
            } else {
                [mix(a.0[0], b.0[0]), mix(a.0[1], b.0[1])]
            };
            (snap(p), std::array::from_fn(|i| mix(a.1[i], b.1[i])))
        };
        let (a, b) = (at(from), at(to));
        Some(Self { ends: [a.0, b.0], weights: [a.1, b.1] })
    }

    /// The point of the segment nearest to the centre of a pixel: squared distance (steps²) and barycentric coordinates.
    pub fn nearest(&self, x: u32, y: u32) -> (f64, [f64; 3]) {
        let c = [f64::from(x) * 256.0 + 128.0, f64::from(y) * 256.0 + 128.0];
        let [a, b] = self.ends.map(|e| e.map(f64::from));
        let d = [b[0] - a[0], b[1] - a[1]];
        let length = d[0] * d[0] + d[1] * d[1];
        let along = (c[0] - a[0]) * d[0] + (c[1] - a[1]) * d[1];
        let t = if length > 0.0 { (along / length).clamp(0.0, 1.0) } else { 0.5 };
        let off = [a[0] + d[0] * t - c[0], a[1] + d[1] * t - c[1]];
        let [wa, wb] = self.weights;
        (off[0] * off[0] + off[1] * off[1], std::array::from_fn(|i| wa[i] + (wb[i] - wa[i]) * t))
    }
}

/// Calls `span(y, x0, x1)` with the pixels x0..=x1 of every row whose closed squares the segment touches, within an image of
/// `height` rows and `width` columns.
pub fn touch(a: [i32; 2], b: [i32; 2], height: i32, width: i32, mut span: impl FnMut(i32, i32, i32)) {
    // One canonical direction: downward, then to the right.
    let (a, b) = if (a[1], a[0]) <= (b[1], b[0]) { (a, b) } else { (b, a) };
    let [ax, ay, bx, by] = [a[0], a[1], b[0], b[1]].map(i64::from);
    let (dx, dy) = (bx - ax, by - ay);
    let first_row = (ay.div_euclid(STEPS) - i64::from(ay.rem_euclid(STEPS) == 0)).max(0);
    let last_row = by.div_euclid(STEPS).min(i64::from(height) - 1);
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

/// Whether a segment meets a closed pixel, by separating axes in integers.
#[cfg(test)]
pub fn meets([a, b]: [[i32; 2]; 2], x: i64, y: i64) -> bool {
    let [ax, ay, bx, by] = [a[0], a[1], b[0], b[1]].map(i64::from);
    let (l, t) = (x * STEPS, y * STEPS);
    let (r, d) = (l + STEPS, t + STEPS);
    let side = |x: i64, y: i64| ((bx - ax) * (y - ay) - (by - ay) * (x - ax)).signum();
    let sides = [side(l, t), side(r, t), side(l, d), side(r, d)];
    let beyond = ax.max(bx) < l || ax.min(bx) > r || ay.max(by) < t || ay.min(by) > d;
    !beyond && !sides.iter().all(|s| *s > 0) && !sides.iter().all(|s| *s < 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = [i32; 2]> {
        // Often on lines between pixels.
        let c = || prop_oneof![-300..2500i32, (-1..9i32).prop_map(|p| p * 256)];
        [c(), c()]
    }

    proptest! {
        #[test]
        fn touched_pixels_are_those_that_meet_the_segment(a in point(), b in point()) {
            let mut touched = vec![];
            touch(a, b, 8, 8, |y, x0, x1| touched.extend((x0..=x1).map(|x| (y, x))));
            let mut reversed = vec![];
            touch(b, a, 8, 8, |y, x0, x1| reversed.extend((x0..=x1).map(|x| (y, x))));
            let all = (0..8).flat_map(|y| (0..8).map(move |x| (y, x)));
            prop_assert_eq!(&touched, &all.filter(|(y, x)| meets([a, b], (*x).into(), (*y).into())).collect::<Vec<_>>());
            prop_assert_eq!(touched, reversed);
        }
    }
}
