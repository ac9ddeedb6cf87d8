//! Hexagonal view cells: prisms over a grid of hexagons that tile the ground plane (Chen et al. 2003, section 3.1.1).
//!
//! The ground is the plane of x and z. Hexagons have corners towards ±x ("flat top"): columns lie 1.5 sizes apart, rows √3 sizes,
//! odd columns half a row further. A point belongs to the hexagon whose centre is nearest.

use crate::math::Aabb;
use glam::{DVec2, DVec3};

/// √3.
const SQRT_3: f64 = 1.732_050_807_568_877_2;

/// A hexagonal prism from anywhere in which stand-ins must look right. Metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prism {
    /// Of the hexagon, at half of the height.
    pub centre: DVec3,
    /// Centre to corner, > 0.
    pub size: f64,
    /// Half of the height, ≥ 0.
    pub half_height: f64,
}

impl Prism {
    /// The six corners of the hexagon, counter-clockwise seen from below (x to z), about its centre.
    pub fn hexagon(size: f64) -> [DVec2; 6] {
        let (h, w) = (size * 0.5, size * SQRT_3 * 0.5);
        [(size, 0.0), (h, w), (-h, w), (-size, 0.0), (-h, -w), (h, -w)].map(DVec2::from)
    }

    /// The twelve corners of the prism.
    pub fn corners(&self) -> [DVec3; 12] {
        let flat = Self::hexagon(self.size);
        std::array::from_fn(|i| {
            let y = if i < 6 { -self.half_height } else { self.half_height };
            self.centre + DVec3::new(flat[i % 6].x, y, flat[i % 6].y)
        })
    }

    /// Radius of the sphere about the centre that holds the prism.
    pub fn radius(&self) -> f64 {
        libm::hypot(self.size, self.half_height)
    }

    pub fn bounds(&self) -> Aabb {
        let half = DVec3::new(self.size, self.half_height, self.size * SQRT_3 * 0.5);
        Aabb { min: self.centre - half, max: self.centre + half }
    }

    /// Whether `p` lies in the prism, sides included.
    pub fn contains(&self, p: DVec3) -> bool {
        let d = (p - self.centre).abs();
        d.y <= self.half_height && d.z <= self.size * SQRT_3 * 0.5 && SQRT_3 * d.x + d.z <= SQRT_3 * self.size
    }

    /// The point at `u`, each in [0, 1): uniform by volume.
    pub fn point(&self, u: [f64; 3]) -> DVec3 {
        // Three rhombi around the centre, each between two alternate corners.
        let flat = Self::hexagon(self.size);
        let third = (u[0] * 3.0).min(2.999_999);
        let k = third as usize;
        let (a, b) = (flat[2 * k], flat[(2 * k + 2) % 6]);
        let p = a * (third - k as f64) + b * u[1];
        self.centre + DVec3::new(p.x, self.half_height * (2.0 * u[2] - 1.0), p.y)
    }
}

/// A cell of a grid, with what is around it.
#[derive(Clone, Debug, PartialEq)]
pub struct HexCell {
    /// `column,row`.
    pub name: String,
    pub prism: Prism,
    /// Cells that share a side with it: names and centres.
    pub neighbours: Vec<(String, DVec3)>,
}

/// Hexagons that tile a rectangle of the ground, by column and row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HexGrid {
    /// Centre of the prism of column 0 and row 0.
    pub origin: DVec3,
    /// Of a cell, centre to corner, > 0.
    pub size: f64,
    pub half_height: f64,
    pub columns: u32,
    pub rows: u32,
}

impl HexGrid {
    /// The grid whose hexagons cover the rectangle from `min` to `max` (x and z), at the heights from `low` to `high`.
    pub fn over(min: DVec2, max: DVec2, size: f64, low: f64, high: f64) -> Self {
        let row = size * SQRT_3;
        // The first column's centres lie half a size inside: left of them a hexagon is narrower than its neighbours' gap.
        let columns = ((max.x - min.x) / (1.5 * size) - 1e-9).ceil().max(0.0) + 1.0;
        // Odd columns begin half a row later; the even ones must reach the end.
        let rows = ((max.y - min.y) / row - 1e-9).ceil().max(0.0) + 1.0;
        let whole = |n: f64| n.min(f64::from(u32::MAX)) as u32;
        Self {
            origin: DVec3::new(min.x, (low + high) * 0.5, min.y),
            size,
            half_height: (high - low) * 0.5,
            columns: whole(columns),
            rows: whole(rows),
        }
    }

    pub fn count(&self) -> u64 {
        u64::from(self.columns) * u64::from(self.rows)
    }

    /// The cell of a column and a row.
    pub fn cell(&self, column: u32, row: u32) -> Prism {
        let shift = if column % 2 == 1 { 0.5 } else { 0.0 };
        let x = f64::from(column) * 1.5 * self.size;
        let z = (f64::from(row) + shift) * SQRT_3 * self.size;
        Prism { centre: self.origin + DVec3::new(x, 0.0, z), size: self.size, half_height: self.half_height }
    }

    /// The cell with its neighbours.
    pub fn hex_cell(&self, column: u32, row: u32) -> HexCell {
        let neighbours = self.neighbours(column, row);
        let neighbours = neighbours.into_iter().map(|(c, r)| (Self::name(c, r), self.cell(c, r).centre)).collect();
        HexCell { name: Self::name(column, row), prism: self.cell(column, row), neighbours }
    }

    /// Its name: `column,row`.
    pub fn name(column: u32, row: u32) -> String {
        format!("{column},{row}")
    }

    /// Columns and rows in the order of columns.
    pub fn cells(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let rows = self.rows;
        (0..self.columns).flat_map(move |c| (0..rows).map(move |r| (c, r)))
    }

    /// Cells that share a side with one: at most six.
    pub fn neighbours(&self, column: u32, row: u32) -> Vec<(u32, u32)> {
        let (c, r) = (i64::from(column), i64::from(row));
        let lower = if column % 2 == 1 { 0 } else { -1 };
        let around = [
            (c, r - 1),
            (c, r + 1),
            (c - 1, r + lower),
            (c - 1, r + lower + 1),
            (c + 1, r + lower),
            (c + 1, r + lower + 1),
        ];
        let inside =
            |(c, r): &(i64, i64)| (0..i64::from(self.columns)).contains(c) && (0..i64::from(self.rows)).contains(r);
        let mut out: Vec<(u32, u32)> = around.into_iter().filter(inside).map(|(c, r)| (c as u32, r as u32)).collect();
        out.sort_unstable();
        out
    }

    /// The cell over or under which `p` lies, whatever its height; `None` outside of all hexagons. Of two centres equally near, that of the
    /// lower column, then row.
    pub fn locate(&self, p: DVec3) -> Option<(u32, u32)> {
        let d = p - self.origin;
        if !d.is_finite() {
            return None;
        }
        let guess = (d.x / (1.5 * self.size)).round();
        let mut best: Option<(f64, (u32, u32))> = None;
        for c in [guess - 1.0, guess, guess + 1.0] {
            if !(0.0..f64::from(self.columns)).contains(&c) {
                continue;
            }
            let column = c as u32;
            let shift = if column % 2 == 1 { 0.5 } else { 0.0 };
            let r = (d.z / (SQRT_3 * self.size) - shift).round().clamp(0.0, f64::from(self.rows) - 1.0);
            let cell = self.cell(column, r as u32);
            let level = DVec3::new(p.x, cell.centre.y, p.z);
            let far = level.distance_squared(cell.centre);
            // A rounding error beyond the side that two cells share is still inside.
            let grown = Prism { size: cell.size * (1.0 + 1e-9), ..cell };
            if grown.contains(level) && best.is_none_or(|b| far < b.0) {
                best = Some((far, (column, r as u32)));
            }
        }
        best.map(|b| b.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Sequence;

    fn grid() -> HexGrid {
        HexGrid::over(DVec2::new(-3.0, 2.0), DVec2::new(20.0, 15.0), 2.0, 1.0, 3.0)
    }

    #[test]
    fn every_point_of_the_rectangle_lies_in_one_cell() {
        let grid = grid();
        let sequence = Sequence::<3>::new(5);
        for i in 0..5000 {
            let u = sequence.point(i);
            let p = DVec3::new(-3.0 + 23.0 * u[0], 1.0 + 2.0 * u[1], 2.0 + 13.0 * u[2]);
            let (c, r) = grid.locate(p).unwrap_or_else(|| panic!("{p} lies in no cell"));
            assert!(grid.cell(c, r).contains(p));
            let holding = grid.cells().filter(|(c, r)| grid.cell(*c, *r).contains(p)).count();
            assert_eq!(holding, 1, "{p}");
        }
    }

    #[test]
    fn neighbours_share_a_side() {
        let grid = grid();
        for (c, r) in grid.cells() {
            let here = grid.cell(c, r);
            let near = |(x, y): (u32, u32)| {
                let d = grid.cell(x, y).centre.distance(here.centre);
                (x, y) != (c, r) && d < 2.0 * SQRT_3 * 1.01
            };
            let literal: Vec<(u32, u32)> = grid.cells().filter(|n| near(*n)).collect();
            assert_eq!(grid.neighbours(c, r), literal);
        }
        assert_eq!(grid.neighbours(2, 2).len(), 6);
    }

    #[test]
    fn the_papers_grid() {
        // 1650 × 2035 units by cells of 50: the paper has 22 × 24, which leaves a rim outside.
        let grid = HexGrid::over(DVec2::ZERO, DVec2::new(1650.0, 2035.0), 50.0, 0.0, 0.0);
        assert_eq!((grid.columns, grid.rows), (23, 25));
    }

    #[test]
    fn points_fill_the_prism() {
        let prism = Prism { centre: DVec3::new(1.0, 2.0, 3.0), size: 2.0, half_height: 0.5 };
        let sequence = Sequence::<3>::new(1);
        let mut right = 0;
        for i in 0..3000 {
            let p = prism.point(sequence.point(i));
            assert!(prism.contains(p), "{p}");
            right += usize::from(p.x > prism.centre.x);
        }
        assert!((1400..1600).contains(&right), "{right}");
        assert!(prism.corners().iter().all(|c| c.distance(prism.centre) <= prism.radius() + 1e-12));
        assert!(!prism.contains(prism.centre + DVec3::new(1.9, 0.0, 1.0)));
    }

    #[test]
    fn outside_is_no_cell() {
        let grid = grid();
        assert_eq!(grid.locate(DVec3::new(-30.0, 0.0, 0.0)), None);
        assert_eq!(grid.locate(DVec3::new(f64::NAN, 0.0, 0.0)), None);
        assert_eq!(grid.locate(DVec3::new(0.0, 0.0, 1e9)), None);
    }
}
