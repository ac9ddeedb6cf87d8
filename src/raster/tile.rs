//! Tiles: the rectangles in which a view is worked through, each by one thread.

/// A rectangle of a view's pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Number of the tile, row by row from the top left.
    pub index: u32,
    /// The first pixel.
    pub x: u32,
    pub y: u32,
    /// Pixels of this tile, at most [`Tile::SIDE`]; fewer at the right and bottom border of a view.
    pub width: u32,
    pub height: u32,
}

impl Tile {
    /// Greatest width and height.
    pub const SIDE: u32 = 64;

    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Position of view pixel (x, y) in arrays over this tile's pixels, row by row.
    pub fn at(&self, x: u32, y: u32) -> usize {
        (y - self.y) as usize * self.width as usize + (x - self.x) as usize
    }

    /// The view pixel at position `i` of such an array.
    pub fn pixel(&self, i: usize) -> (u32, u32) {
        let w = self.width as usize;
        (self.x + (i % w) as u32, self.y + (i / w) as u32)
    }
}

/// The tiles of a view.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TileGrid {
    pub width: u32,
    pub height: u32,
    pub columns: u32,
    pub rows: u32,
    pub side: u32,
    /// ⌈2²⁰/side⌉: x·reciprocal / 2²⁰ is ⌊x/side⌋ for x < 2¹⁴ and side ≤ 64.
    reciprocal: u32,
}

impl TileGrid {
    /// `side` ≤ [`Tile::SIDE`].
    pub fn new(width: u32, height: u32, side: u32) -> Self {
        debug_assert!((1..=Tile::SIDE).contains(&side));
        let reciprocal = (1u32 << 20).div_ceil(side);
        Self { width, height, columns: width.div_ceil(side), rows: height.div_ceil(side), side, reciprocal }
    }

    pub fn len(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Column of pixel x, or row of pixel y.
    pub fn line_of(&self, x: i32) -> u32 {
        ((x as u64 * self.reciprocal as u64) >> 20) as u32
    }

    pub fn tile(&self, index: u32) -> Tile {
        let (x, y) = (index % self.columns * self.side, index / self.columns * self.side);
        Tile { index, x, y, width: self.side.min(self.width - x), height: self.side.min(self.height - y) }
    }

    /// Cuts an image (row by row) into the rows of its tiles, so that each tile can be written by a thread of its own.
    pub fn split<'a, T>(&self, image: &'a mut [T]) -> Vec<Vec<&'a mut [T]>> {
        let mut tiles: Vec<Vec<&mut [T]>> = (0..self.len()).map(|_| Vec::with_capacity(self.side as usize)).collect();
        if self.width == 0 {
            return tiles;
        }
        for (y, row) in image.chunks_mut(self.width as usize).enumerate() {
            let first = y / self.side as usize * self.columns as usize;
            for (column, part) in row.chunks_mut(self.side as usize).enumerate() {
                tiles[first + column].push(part);
            }
        }
        tiles
    }

    /// The image, row by row, whose tiles have these values, each row by row.
    pub fn join<T: Copy>(&self, tiles: &[Vec<T>], fill: T) -> Vec<T> {
        let mut image = vec![fill; self.width as usize * self.height as usize];
        for (rows, tile) in self.split(&mut image).into_iter().zip(tiles) {
            let mut rest = &tile[..];
            for row in rows {
                let (first, others) = rest.split_at(row.len());
                row.copy_from_slice(first);
                rest = others;
            }
        }
        image
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_a_view_once() {
        for (w, h, side) in [(1, 1, 64), (64, 65, 64), (200, 130, 63), (16384, 1, 60), (77, 16384, 64)] {
            let grid = TileGrid::new(w, h, side);
            let mut image = vec![0u8; (w * h) as usize];
            for (i, rows) in grid.split(&mut image).into_iter().enumerate() {
                let tile = grid.tile(i as u32);
                assert_eq!((rows.len(), rows[0].len()), (tile.height as usize, tile.width as usize));
                let last = (tile.x + tile.width - 1, tile.y + tile.height - 1);
                for (x, y) in [(tile.x, tile.y), last] {
                    assert_eq!(grid.line_of(y as i32) * grid.columns + grid.line_of(x as i32), i as u32);
                    assert_eq!(tile.pixel(tile.at(x, y)), (x, y));
                }
                rows.into_iter().flatten().for_each(|p| *p += 1);
            }
            assert!(image.iter().all(|p| *p == 1));
        }
    }
}
