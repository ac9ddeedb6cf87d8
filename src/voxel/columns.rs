//! Voxels by pixel: the columns of a field through its layers.

use super::Voxel;
use glam::{DVec2, dvec2};

/// Voxels by pixel.
pub struct Columns<'a> {
    pub voxels: &'a [Voxel],
    /// Row of the first entry of `rows`.
    top: u16,
    /// First column of each row, and one past the end.
    rows: Vec<u32>,
    /// (x, first number), and one past the end.
    columns: Vec<(u16, u32)>,
    /// Numbers of voxels, by (y, x, layer).
    numbers: Vec<u32>,
}

impl<'a> Columns<'a> {
    /// Of those `numbers` of `voxels`, which are sorted by (layer, y, x); in any order, no two equal.
    pub fn new(voxels: &'a [Voxel], numbers: impl IntoIterator<Item = u32>) -> Self {
        // By y, x and number, which keeps layers in order.
        let key = |i: u32| {
            let v = &voxels[i as usize];
            u64::from(v.y) << 48 | u64::from(v.x) << 32 | u64::from(i)
        };
        let mut keys: Vec<u64> = numbers.into_iter().map(key).collect();
        keys.sort_unstable();
        let numbers: Vec<u32> = keys.into_iter().map(|k| k as u32).collect();
        let at = |i: usize| &voxels[numbers[i] as usize];
        let top = numbers.first().map_or(0, |i| voxels[*i as usize].y);
        let (mut rows, mut columns): (Vec<u32>, Vec<(u16, u32)>) = (Vec::new(), Vec::new());
        for i in 0..numbers.len() {
            let v = at(i);
            let new_row = i == 0 || at(i - 1).y != v.y;
            if new_row {
                rows.resize(usize::from(v.y - top) + 1, columns.len() as u32);
            }
            if new_row || at(i - 1).x != v.x {
                columns.push((v.x, i as u32));
            }
        }
        rows.push(columns.len() as u32);
        columns.push((u16::MAX, numbers.len() as u32));
        Self { voxels, top, rows, columns, numbers }
    }

    /// Numbers of the voxels at a pixel, nearest layer first.
    pub fn column(&self, x: f64, y: f64) -> &[u32] {
        let row = y.floor() - f64::from(self.top);
        if !(row >= 0.0 && row + 1.0 < self.rows.len() as f64) {
            return &[];
        }
        let [first, end] = [self.rows[row as usize] as usize, self.rows[row as usize + 1] as usize];
        let x = x.floor();
        let row = &self.columns[first..end];
        // Most rows have no gaps: there the first column's place tells the answer.
        let guess = row.first().map_or(0.0, |c| x - f64::from(c.0)).max(0.0) as usize;
        let at = match row.get(guess) {
            Some(c) if f64::from(c.0) == x => first + guess,
            _ => first + row.partition_point(|c| f64::from(c.0) < x),
        };
        if at == end || f64::from(self.columns[at].0) != x {
            return &[];
        }
        &self.numbers[self.columns[at].1 as usize..self.columns[at + 1].1 as usize]
    }

    /// All columns: x, y and the numbers of the voxels there, nearest layer first.
    pub fn all(&self) -> impl Iterator<Item = (u16, u16, &[u32])> {
        self.columns.windows(2).take(self.columns.len() - 1).map(|w| {
            let numbers = &self.numbers[w[0].1 as usize..w[1].1 as usize];
            (w[0].0, self.voxels[numbers[0] as usize].y, numbers)
        })
    }
}

/// The four places nearest to `p` of those that divide each pixel's side into `fine` parts, their centres, and their bilinear weights;
/// without those that count for nothing.
pub fn around(p: DVec2, fine: f64) -> impl Iterator<Item = (DVec2, f64)> {
    let place = move |(x, y): (f64, f64)| {
        let at = (((p + dvec2(x, y) / fine) * fine).floor() + 0.5) / fine;
        (at, (1.0 - fine * (at.x - p.x).abs()) * (1.0 - fine * (at.y - p.y).abs()))
    };
    [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)].into_iter().map(place).filter(|(_, weight)| *weight > 1e-6)
}
