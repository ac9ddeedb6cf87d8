//! The pictures of a certificate: original, stand-in and difference side by side, cropped to the object, and below them
//! the part where most of what the picture is about lies, enlarged; a caption above, a legend below.
//!
//! The difference shows |ΔY| as dark grey on black, and over it in bright colours the pixels that are not right; paler inside
//! the band.

use super::{
    classes::{Class, Classes},
    measure::{Reference, Shot},
    worst::Focus,
};
use crate::image::{
    Picture,
    canvas::{Area, CELL, wrap},
    measure::luminance,
};
use serde::Serialize;

const PAPER: [u8; 4] = [20, 20, 24, 255];
const INK: [u8; 4] = [235, 235, 235, 255];
/// Mid-grey, as `Rendering::default()` has it: beside a panel's picture.
const BACKGROUND: [u8; 4] = [128, 128, 128, 255];
const MARK: [u8; 4] = [255, 255, 255, 255];

/// How much the difference of brightness is enlarged, and how bright it gets at most.
const GAIN: f32 = 4.0;
const BRIGHTEST: f32 = 110.0;
/// Pixels kept around the object.
const MARGIN: usize = 8;
/// Pictures smaller than this are enlarged, by whole factors.
const PANEL: usize = 800;
/// Panels are at least so wide.
const NARROWEST: usize = 480;
const GAP: usize = 8;
/// Scale of the font, and the height of a line in pixels.
const SCALE: usize = 2;
const LINE: usize = CELL * SCALE + 6;
/// How much the marked part is enlarged.
const ZOOM: usize = 8;

/// What is marked in the difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mark {
    Missing,
    Extra,
    WrongSurface,
    InFront,
    Lost,
    Crack,
}

impl Mark {
    const ALL: [Self; 6] = [Self::Missing, Self::Extra, Self::WrongSurface, Self::InFront, Self::Lost, Self::Crack];

    fn of(classes: &Classes, i: usize) -> Option<Self> {
        match classes.class[i] {
            _ if classes.crack[i] => Some(Self::Crack),
            _ if classes.lost[i] => Some(Self::Lost),
            Class::Right => None,
            Class::Missing => Some(Self::Missing),
            Class::Extra => Some(Self::Extra),
            Class::WrongSurface => Some(Self::WrongSurface),
            Class::InFront => Some(Self::InFront),
        }
    }

    fn colour(self) -> [u8; 3] {
        match self {
            Self::Missing => [255, 60, 60],
            Self::Extra => [90, 140, 255],
            Self::WrongSurface => [255, 70, 255],
            Self::InFront => [0, 255, 255],
            Self::Lost => [255, 150, 0],
            Self::Crack => [255, 255, 0],
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Missing => "missing: original only",
            Self::Extra => "extra: stand-in only",
            Self::WrongSurface => "wrong surface: one behind shows",
            Self::InFront => "in front: sticks out",
            Self::Lost => "lost detail: nothing of it is near",
            Self::Crack => "crack",
        }
    }
}

/// The text of a picture.
pub struct Caption {
    /// Above the picture: what is shown, then its figures.
    pub lines: Vec<String>,
    /// Half width of the band, pixels.
    pub band_px: u32,
}

/// Where the pictures of a view lie in its sheet: left, top, width and height in pixels. Every pixel of the view is a square of `scale` pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Panels {
    pub scale: u32,
    pub original: [u32; 4],
    pub stand_in: [u32; 4],
    pub difference: [u32; 4],
}

impl Panels {
    /// Three pictures of one size side by side, and nothing else.
    pub fn thirds(width: u32, height: u32) -> Self {
        let third = |k: u32| [k * width, 0, width, height];
        Self { scale: 1, original: third(0), stand_in: third(1), difference: third(2) }
    }
}

/// The picture of one view, and where in it original, stand-in and difference lie. The window is cropped to what either scene covers.
pub fn sheet(original: &Reference, stand_in: &Shot, focus: Focus, caption: &Caption) -> (Picture, Panels) {
    let (a, b) = (original.shot.picture(), stand_in.picture());
    let classes = original.classes(stand_in);
    let width = a.width as usize;
    let covered: Vec<bool> =
        (0..a.texels.len()).map(|i| original.shot.surfaces().covered(i) || stand_in.surfaces().covered(i)).collect();
    let crop = bounds(&covered, width);
    let factor = (PANEL / crop.width.max(crop.height)).clamp(1, 16);
    let panel = [(crop.width * factor).max(NARROWEST), crop.height * factor];
    let weights = weights(a, b, &classes, focus);
    let zoom = (factor < ZOOM)
        .then(|| marked(&weights, width, crop, [panel[0] / ZOOM, panel[1].clamp(panel[0] / 2, panel[0]) / ZOOM]));

    let sheet_width = 3 * panel[0] + 4 * GAP;
    let columns = (sheet_width - 2 * GAP) / (CELL * SCALE);
    let above: Vec<String> = caption.lines.iter().flat_map(|l| wrap(l, columns)).collect();
    let legend = legend_lines(caption.band_px, columns);
    let zoomed = zoom.map_or(0, |z| LINE + z.height * ZOOM + GAP);
    let height = GAP + (above.len() + 1 + legend.len()) * LINE + panel[1] + GAP + zoomed + GAP;
    let mut sheet = Picture::filled(sheet_width, height, PAPER);

    let mut y = GAP;
    for line in &above {
        sheet.text(line, GAP, y, SCALE, INK);
        y += LINE;
    }
    let enlarged = |factor: usize| if factor == 1 { String::new() } else { format!(", enlarged {factor}x") };
    let far = Picture { texels: difference(a, b, &classes, factor < 4), ..*a };
    let near = Picture { texels: difference(a, b, &classes, false), ..*a };
    let mut lefts = [0; 3];
    let mut row =
        |y: &mut usize, part: Area, factor: usize, panel: [usize; 2], words: [&str; 3], difference: &Picture| {
            for (k, picture) in [a, b, difference].into_iter().enumerate() {
                let x = GAP + k * (panel[0] + GAP);
                sheet.text(&format!("{}{}", words[k], enlarged(factor)), x, *y, SCALE, INK);
                let under = if k == 2 { [0, 0, 0, 255] } else { BACKGROUND };
                sheet.fill(Area { x, y: *y + LINE, width: panel[0], height: panel[1] }, under);
                let left = x + (panel[0] - part.width * factor) / 2;
                if part == crop {
                    lefts[k] = left;
                }
                sheet.enlarge(picture, part, factor, left, *y + LINE);
                if let Some(z) = zoom.filter(|_| part == crop) {
                    let scale = |v: usize, from: usize| (v - from) * factor;
                    let (zx, zy) = (left + scale(z.x, crop.x), *y + LINE + scale(z.y, crop.y));
                    sheet.frame(Area { x: zx, y: zy, width: z.width * factor, height: z.height * factor }, MARK);
                }
            }
            *y += LINE + panel[1] + GAP;
        };
    let top = y + LINE;
    row(&mut y, crop, factor, panel, ["original", "stand-in", "difference"], &far);
    if let Some(z) = zoom {
        row(&mut y, z, ZOOM, [panel[0], z.height * ZOOM], ["framed part"; 3], &near);
    }
    for line in legend {
        for (column, colour, text) in line {
            let x = GAP + column * CELL * SCALE;
            match colour {
                Some([r, g, b]) => {
                    sheet.fill(Area { x, y, width: 2 * CELL * SCALE, height: CELL * SCALE }, [r, g, b, 255]);
                    sheet.text(&text, x + 3 * CELL * SCALE, y, SCALE, INK);
                }
                None => sheet.text(&text, x, y, SCALE, INK),
            }
        }
        y += LINE;
    }
    let [original, stand_in, difference] =
        lefts.map(|left| [left, top, crop.width * factor, crop.height * factor].map(|v| v as u32));
    (sheet, Panels { scale: factor as u32, original, stand_in, difference })
}

/// What the colours of a difference mean.
pub fn legend() -> Vec<([u8; 3], &'static str)> {
    let paler = (pale(Mark::Missing.colour()), "paler colours: at edges, where outlines may move");
    let grey = ([BRIGHTEST as u8; 3], "difference of brightness, 4 ×");
    Mark::ALL.into_iter().map(|m| (m.colour(), m.words())).chain([paler, grey]).collect()
}

/// The entries of the legend in lines: column in characters, swatch, text.
fn legend_lines(band_px: u32, columns: usize) -> Vec<Vec<(usize, Option<[u8; 3]>, String)>> {
    let mut entries: Vec<(Option<[u8; 3]>, String)> =
        Mark::ALL.into_iter().map(|m| (Some(m.colour()), m.words().to_owned())).collect();
    entries.push((
        Some(pale(Mark::Missing.colour())),
        format!("paler colours: within {band_px} px of an edge, where outlines may move"),
    ));
    entries.push((Some([BRIGHTEST as u8; 3]), format!("grey: difference of brightness, {GAIN}x")));
    let mut lines: Vec<Vec<_>> = vec![Vec::new()];
    let mut used = 0;
    for (swatch, text) in entries {
        let needs = 3 + text.len();
        if used > 0 && used + needs > columns {
            lines.push(Vec::new());
            used = 0;
        }
        if let Some(line) = lines.last_mut() {
            line.push((used, swatch, text));
        }
        used += needs + 2;
    }
    lines
}

fn pale(colour: [u8; 3]) -> [u8; 3] {
    colour.map(|c| 255 - (255 - c) / 2)
}

/// The box around the set pixels, with a margin; the whole picture where none is set.
fn bounds(mask: &[bool], width: usize) -> Area {
    let height = mask.len() / width;
    let (mut lo, mut hi) = ([usize::MAX; 2], [0; 2]);
    for i in (0..mask.len()).filter(|i| mask[*i]) {
        let p = [i % width, i / width];
        for k in 0..2 {
            (lo[k], hi[k]) = (lo[k].min(p[k]), hi[k].max(p[k] + 1));
        }
    }
    if lo[0] == usize::MAX {
        return Area { x: 0, y: 0, width, height };
    }
    let (x, y) = (lo[0].saturating_sub(MARGIN), lo[1].saturating_sub(MARGIN));
    Area { x, y, width: (hi[0] + MARGIN).min(width) - x, height: (hi[1] + MARGIN).min(height) - y }
}

/// How much a pixel is what the picture is about; the difference of brightness where nothing is.
fn weights(a: &Picture, b: &Picture, classes: &Classes, focus: Focus) -> Vec<u64> {
    let is = |i: usize| match focus {
        Focus::Wrong => classes.class[i] != Class::Right,
        Focus::Missing => classes.class[i] == Class::Missing,
        Focus::Extra => classes.class[i] == Class::Extra,
        Focus::WrongSurface => classes.class[i] == Class::WrongSurface,
        Focus::InFront => classes.class[i] == Class::InFront,
        Focus::Crack => classes.crack[i],
        Focus::Lost => classes.lost[i],
    };
    // What lies at edges gives way to what does not.
    let weight = |i: usize| if classes.band[i] { 1 } else { 8 };
    let all: Vec<u64> = (0..classes.class.len()).map(|i| if is(i) { weight(i) } else { 0 }).collect();
    if all.iter().any(|w| *w > 0) {
        return all;
    }
    a.texels.iter().zip(&b.texels).map(|(a, b)| (brightness(a) - brightness(b)).abs() as u64).collect()
}

fn brightness(t: &[u8; 4]) -> f32 {
    luminance([t[0].into(), t[1].into(), t[2].into()])
}

/// The part of `crop` of about `size` pixels with most weight, centred on it.
fn marked(weights: &[u64], width: usize, crop: Area, size: [usize; 2]) -> Area {
    let (w, h) = (size[0].clamp(1, crop.width), size[1].clamp(1, crop.height));
    // Sums over all pixels above and to the left.
    let mut sums = vec![0_u64; (crop.width + 1) * (crop.height + 1)];
    let at = |x: usize, y: usize| y * (crop.width + 1) + x;
    for y in 0..crop.height {
        let mut row = 0;
        for x in 0..crop.width {
            row += weights[(crop.y + y) * width + crop.x + x];
            sums[at(x + 1, y + 1)] = sums[at(x + 1, y)] + row;
        }
    }
    let inside = |x: usize, y: usize| sums[at(x + w, y + h)] + sums[at(x, y)] - sums[at(x + w, y)] - sums[at(x, y + h)];
    let (mut best, mut most) = ([0, 0], 0);
    for y in 0..=crop.height - h {
        for x in 0..=crop.width - w {
            let sum = inside(x, y);
            if sum > most {
                (best, most) = ([x, y], sum);
            }
        }
    }
    // Many places may hold the same pixels; the one with their centre in its middle shows most around them.
    let (mut sx, mut sy) = (0, 0);
    for y in best[1]..best[1] + h {
        for x in best[0]..best[0] + w {
            let weight = weights[(crop.y + y) * width + crop.x + x];
            (sx, sy) = (sx + weight * x as u64, sy + weight * y as u64);
        }
    }
    if let (Some(cx), Some(cy)) = (sx.checked_div(most), sy.checked_div(most)) {
        best = [
            (cx as usize).saturating_sub(w / 2).min(crop.width - w),
            (cy as usize).saturating_sub(h / 2).min(crop.height - h),
        ];
    }
    Area { x: crop.x + best[0], y: crop.y + best[1], width: w, height: h }
}

/// `thick`: cracks are drawn with the pixels around them.
fn difference(a: &Picture, b: &Picture, classes: &Classes, thick: bool) -> Vec<[u8; 4]> {
    let width = a.width as usize;
    let mut texels: Vec<[u8; 4]> = (0..a.texels.len())
        .map(|i| {
            let grey = ((brightness(&a.texels[i]) - brightness(&b.texels[i])).abs() * GAIN).min(BRIGHTEST) as u8;
            let [r, g, b] = match Mark::of(classes, i).map(Mark::colour) {
                None => [grey; 3],
                Some(colour) if classes.band[i] && !classes.crack[i] => pale(colour),
                Some(colour) => colour,
            };
            [r, g, b, 255]
        })
        .collect();
    let [r, g, b] = Mark::Crack.colour();
    let height = texels.len() / width;
    for i in (0..texels.len()).filter(|i| thick && classes.crack[*i]) {
        let (x, y) = (i % width, i / width);
        for v in y.saturating_sub(1)..=(y + 1).min(height - 1) {
            for u in x.saturating_sub(1)..=(x + 1).min(width - 1) {
                texels[v * width + u] = [r, g, b, 255];
            }
        }
    }
    texels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_bright_and_differ() {
        let mut all: Vec<[u8; 3]> = Mark::ALL.into_iter().flat_map(|m| [m.colour(), pale(m.colour())]).collect();
        for c in &all {
            assert!(brightness(&[c[0], c[1], c[2], 255]) > 80.0, "{c:?}");
        }
        all.sort();
        all.dedup();
        // Yellow pales into light yellow, and so on: none is another's.
        assert_eq!(all.len(), 2 * Mark::ALL.len());
    }

    #[test]
    fn the_marked_part_holds_most_and_has_it_in_its_middle() {
        let crop = Area { x: 10, y: 5, width: 60, height: 40 };
        let mut weights = vec![0; 100 * 50];
        for (x, y) in [(12, 7), (40, 30), (41, 30), (42, 31)] {
            weights[y * 100 + x] = 1;
        }
        // Outside the crop: not looked at.
        weights[3] = 1000;
        let found = marked(&weights, 100, crop, [20, 10]);
        assert_eq!(found, Area { x: 31, y: 25, width: 20, height: 10 });
        let nothing = marked(&[0; 100 * 50], 100, crop, [500, 500]);
        assert_eq!(nothing, crop);
    }

    #[test]
    fn the_legend_has_every_colour_within_the_width() {
        let lines = legend_lines(3, 60);
        let swatches: Vec<_> = lines.iter().flatten().filter_map(|e| e.1).collect();
        assert!(Mark::ALL.iter().all(|m| swatches.contains(&m.colour())));
        assert!(lines.iter().flatten().all(|(column, _, text)| column + 3 + text.len() <= 60 || *column == 0));
    }
}
