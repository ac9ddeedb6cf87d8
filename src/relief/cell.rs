//! The surface between four texel centres.

use super::field::{Field, Texel};
use glam::Vec3;

/// The surfaces in one cell: the square between the centres of texels (i, j), (i + 1, j), (i, j + 1) and (i + 1, j + 1).
///
/// Texels whose depths are less than a wall apart are one sheet, which is bilinear between them. A sheet ends half-way to the texels of another, and
/// where the interpolated edge value falls to 0.
pub(super) struct Cell {
    texels: [Texel; 4],
    /// Corner of the cell with the least u and v.
    corner: [f32; 2],
    /// Bit k of sheet s: texel k belongs to it. Unused ones are 0.
    sheets: [u8; 4],
    first: [i32; 2],
}

/// The part of a ray that is looked at.
#[derive(Clone, Copy)]
pub(super) struct Span {
    pub origin: Vec3,
    pub direction: Vec3,
    pub from: f32,
    pub to: f32,
}

impl Cell {
    pub fn new(field: &Field, i: i32, j: i32, wall: f32) -> Self {
        let texels = [field.texel(i, j), field.texel(i + 1, j), field.texel(i, j + 1), field.texel(i + 1, j + 1)];
        let mut sheets = [0_u8; 4];
        let mut taken = 0_u8;
        for k in 0..4 {
            if taken >> k & 1 == 1 || texels[k].depth == f32::INFINITY {
                continue;
            }
            let mut bits = 0;
            for (l, t) in texels.iter().enumerate() {
                if taken >> l & 1 == 0 && (t.depth - texels[k].depth).abs() <= wall {
                    bits |= 1 << l;
                }
            }
            sheets[k] = bits;
            taken |= bits;
        }
        Self { texels, corner: [i as f32 + 0.5, j as f32 + 0.5], sheets, first: [i, j] }
    }

    /// Depths of a sheet at the four corners; those that do not belong to it continue what does.
    fn corners(&self, field: &Field, wall: f32, bits: u8) -> [f32; 4] {
        let has = |k: usize| bits >> k & 1 == 1;
        let depth = |k: usize| self.texels[k].depth;
        // Straight on from corner a to corner k, through the texel on the other side of a where it belongs to the surface.
        let on = |a: usize, k: usize| {
            let at = |k: usize| (self.first[0] + (k & 1) as i32, self.first[1] + (k >> 1) as i32);
            let ((ax, ay), (kx, ky)) = (at(a), at(k));
            let before = field.texel(2 * ax - kx, 2 * ay - ky).depth;
            if (before - depth(a)).abs() <= wall { 2.0 * depth(a) - before } else { depth(a) }
        };
        std::array::from_fn(|k| {
            if has(k) {
                return depth(k);
            }
            // The corners beside it and the one across.
            let (a, b, c) = (k ^ 1, k ^ 2, k ^ 3);
            match (has(a), has(b), has(c)) {
                (true, true, true) => depth(a) + depth(b) - depth(c),
                (true, true, false) => (on(a, k) + on(b, k)) * 0.5,
                (true, false, _) => on(a, k),
                (false, true, _) => on(b, k),
                (false, false, _) => depth(c),
            }
        })
    }

    /// Least and greatest depth of all sheets at the corners; `None` where there is no surface.
    pub fn range(&self, field: &Field, wall: f32) -> Option<(f32, f32)> {
        let mut range: Option<(f32, f32)> = None;
        for bits in self.sheets.into_iter().filter(|b| *b != 0) {
            for d in self.corners(field, wall, bits) {
                let (lo, hi) = range.unwrap_or((d, d));
                range = Some((lo.min(d), hi.max(d)));
            }
        }
        range
    }

    /// The first t of the span at which the ray goes from in front of a sheet to behind it.
    pub fn meet(&self, field: &Field, wall: f32, span: &Span) -> Option<f32> {
        let mut first: Option<f32> = None;
        for bits in self.sheets.into_iter().filter(|b| *b != 0) {
            if let Some(t) = self.meet_sheet(field, wall, bits, span)
                && first.is_none_or(|f| t < f)
            {
                first = Some(t);
            }
        }
        first
    }

    fn meet_sheet(&self, field: &Field, wall: f32, bits: u8, span: &Span) -> Option<f32> {
        let [h00, h10, h01, h11] = self.corners(field, wall, bits);
        // Height above the near plane: h00 + b·x + c·y + d·x·y with x, y from the corner; the ray's depth less that is e + f·t + g·t².
        let (b, c, d) = (h10 - h00, h01 - h00, h00 - h10 - h01 + h11);
        let start = span.origin + span.direction * span.from;
        let (x, y) = (start.x - self.corner[0], start.y - self.corner[1]);
        let (dx, dy, dz) = (span.direction.x, span.direction.y, span.direction.z);
        let e = start.z - (h00 + b * x + c * y + d * x * y);
        let f = dz - (b * dx + c * dy + d * (x * dy + y * dx));
        let g = -d * dx * dy;
        let t = rising_root(e, f, g)?;
        if !(t >= 0.0 && span.from + t <= span.to) {
            return None;
        }
        let (x, y) = (x + dx * t, y + dy * t);
        self.shows(bits, x, y).then_some(span.from + t)
    }

    /// Whether the sheet is there at (x, y) from the corner of the cell.
    fn shows(&self, bits: u8, x: f32, y: f32) -> bool {
        let (x, y) = (x.clamp(0.0, 1.0), y.clamp(0.0, 1.0));
        let weights = [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y];
        let (mut edge, mut own, mut most) = (0.0, 0, -1.0);
        for (k, t) in self.texels.iter().enumerate() {
            edge += weights[k] * t.edge;
            if t.depth < f32::INFINITY && weights[k] > most {
                (own, most) = (k, weights[k]);
            }
        }
        edge > 0.0 && bits >> own & 1 == 1
    }
}

/// The root of e + f·t + g·t² at which it rises; for roots of a quadratic that is −2e / (f + √(f² − 4eg)).
fn rising_root(e: f32, f: f32, g: f32) -> Option<f32> {
    let under = f * f - 4.0 * e * g;
    if !(under > 0.0) {
        return None;
    }
    let root = under.sqrt();
    // Where f is negative the first form cancels.
    let t = if f >= 0.0 { -2.0 * e / (f + root) } else { (root - f) / (2.0 * g) };
    t.is_finite().then_some(t)
}
