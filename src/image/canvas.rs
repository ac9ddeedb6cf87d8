//! Drawing on pictures: filled boxes, enlarged parts of other pictures, frames, and text in a bitmap font.

use super::Picture;
use font8x8::legacy::BASIC_LEGACY;

/// Pixels of a character's cell at scale 1.
pub const CELL: usize = 8;

/// A part of a picture: first pixel, width and height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Area {
    pub x: usize,
    pub y: usize,
    pub width: usize,
    pub height: usize,
}

impl Picture {
    /// A picture of one colour.
    pub fn filled(width: usize, height: usize, colour: [u8; 4]) -> Self {
        Self { width: width as u32, height: height as u32, texels: vec![colour; width * height] }
    }

    /// Sets a pixel; places outside the picture are ignored.
    fn set(&mut self, x: usize, y: usize, colour: [u8; 4]) {
        if x < self.width as usize && y < self.height as usize {
            self.texels[y * self.width as usize + x] = colour;
        }
    }

    /// Fills a box.
    pub fn fill(&mut self, area: Area, colour: [u8; 4]) {
        for y in area.y..area.y + area.height {
            for x in area.x..area.x + area.width {
                self.set(x, y, colour);
            }
        }
    }

    /// Draws the outline of a box, one pixel wide, just outside it where there is room.
    pub fn frame(&mut self, area: Area, colour: [u8; 4]) {
        let (x0, y0) = (area.x.saturating_sub(1), area.y.saturating_sub(1));
        let (x1, y1) = (area.x + area.width, area.y + area.height);
        for x in x0..=x1 {
            self.set(x, y0, colour);
            self.set(x, y1, colour);
        }
        for y in y0..=y1 {
            self.set(x0, y, colour);
            self.set(x1, y, colour);
        }
    }

    /// Draws `part` of `from`, each of its pixels as a square of `factor` pixels, with its corner at (`x`, `y`).
    pub fn enlarge(&mut self, from: &Picture, part: Area, factor: usize, x: usize, y: usize) {
        for v in 0..part.height * factor {
            for u in 0..part.width * factor {
                let (a, b) = (part.x + u / factor, part.y + v / factor);
                self.set(x + u, y + v, from.texels[b * from.width as usize + a]);
            }
        }
    }

    /// Writes one line of text, each character in a cell of `scale` times [`CELL`] pixels. Characters without a glyph
    /// show as `?`.
    pub fn text(&mut self, text: &str, x: usize, y: usize, scale: usize, colour: [u8; 4]) {
        for (i, c) in text.chars().enumerate() {
            let glyph = BASIC_LEGACY.get(c as usize).filter(|_| !c.is_control()).unwrap_or(&BASIC_LEGACY['?' as usize]);
            for (row, bits) in glyph.iter().enumerate() {
                for column in (0..CELL).filter(|column| bits >> column & 1 == 1) {
                    let (left, top) = (x + (i * CELL + column) * scale, y + row * scale);
                    self.fill(Area { x: left, y: top, width: scale, height: scale }, colour);
                }
            }
        }
    }
}

/// `text` in lines of at most `columns` characters, broken at blanks; longer words are cut.
pub fn wrap(text: &str, columns: usize) -> Vec<String> {
    let columns = columns.max(1);
    let mut lines: Vec<String> = Vec::new();
    let mut line = String::new();
    for word in text.split_whitespace() {
        let letters: Vec<char> = word.chars().collect();
        for piece in letters.chunks(columns) {
            let used = line.chars().count();
            if used > 0 && used + 1 + piece.len() > columns {
                lines.push(std::mem::take(&mut line));
            }
            if !line.is_empty() {
                line.push(' ');
            }
            line.extend(piece);
        }
    }
    if !line.is_empty() {
        lines.push(line);
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    const INK: [u8; 4] = [255; 4];

    #[test]
    fn text_leaves_marks_inside_its_cells_only() {
        let mut p = Picture::filled(40, 20, [0; 4]);
        p.text("I?", 2, 3, 2, INK);
        let marked: Vec<usize> = (0..p.texels.len()).filter(|i| p.texels[*i] == INK).collect();
        assert!(marked.len() > 40 && marked.len() < 300, "{}", marked.len());
        assert!(marked.iter().all(|i| (2..34).contains(&(i % 40)) && (3..19).contains(&(i / 40))));
        // What has no glyph shows as a question mark; what lies outside is cut off.
        let mut q = Picture::filled(40, 20, [0; 4]);
        q.text("I→", 2, 3, 2, INK);
        assert_eq!(p, q);
        q.text("outside", 30, 15, 3, INK);
    }

    #[test]
    fn enlarged_pixels_are_squares() {
        let texels = (0..6).map(|i| [i; 4]).collect();
        let from = Picture { width: 3, height: 2, texels };
        let mut to = Picture::filled(5, 4, [9; 4]);
        to.enlarge(&from, Area { x: 1, y: 0, width: 2, height: 2 }, 2, 0, 0);
        let row = |y: usize| to.texels[y * 5..][..5].iter().map(|t| t[0]).collect::<Vec<_>>();
        assert_eq!([row(0), row(1), row(2)], [vec![1, 1, 2, 2, 9], vec![1, 1, 2, 2, 9], vec![4, 4, 5, 5, 9]]);
    }

    #[test]
    fn lines_break_at_blanks() {
        assert_eq!(wrap("one two  three", 7), ["one two", "three"]);
        assert_eq!(wrap("abcdefgh i", 3), ["abc", "def", "gh", "i"]);
        assert!(wrap("", 5).is_empty());
    }
}
