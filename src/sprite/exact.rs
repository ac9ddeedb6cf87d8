//! Inside and outside by the mesh itself: what sprites are judged against.
//!
//! A ray through the point along a sideways axis of the frame crosses the surface an odd number of times beyond the point if it
//! lies inside. Two triangles that share an edge decide by the same number on which side the ray passes it, and where it is
//! met exactly by the same rule, so no ray slips between them and none is counted twice.

use super::CubeFrame;
use crate::{math::squared_distance, raster::Geometry};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Triangles in a grid over the plane that rays cross.
pub struct Exact {
    /// In texture space, the ray's axis (s) last: (t, r, s).
    triangles: Vec<[DVec3; 3]>,
    /// Cells along a side of the unit square.
    side: usize,
    /// The triangles of cell i are `list[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    list: Vec<u32>,
}

impl Exact {
    pub fn new(geometry: &Geometry, frame: &CubeFrame) -> Self {
        let m = frame.to_texture();
        let turn = |p: DVec3| {
            let q = m.transform_point3(p);
            DVec3::new(q.y, q.z, q.x)
        };
        let triangles: Vec<[DVec3; 3]> =
            (0..geometry.triangle_count()).into_par_iter().map(|t| geometry.positions(t).map(turn)).collect();
        let side = ((triangles.len() as f64).sqrt() as usize).clamp(1, 1024);
        let mut exact = Self { triangles, side, starts: vec![0; side * side + 1], list: Vec::new() };
        let cells =
            |t: &[DVec3; 3]| exact.cells(t[0].min(t[1]).min(t[2]).truncate(), t[0].max(t[1]).max(t[2]).truncate());
        let mut pairs: Vec<(u32, u32)> = exact
            .triangles
            .iter()
            .enumerate()
            .flat_map(|(i, t)| cells(t).map(move |cell| (cell as u32, i as u32)))
            .collect();
        pairs.par_sort_unstable();
        for (cell, _) in &pairs {
            exact.starts[*cell as usize + 1] += 1;
        }
        for i in 0..side * side {
            exact.starts[i + 1] += exact.starts[i];
        }
        exact.list = pairs.into_iter().map(|p| p.1).collect();
        exact
    }

    /// The cells of a rectangle; beyond the unit square the outermost.
    fn cells(&self, low: DVec2, high: DVec2) -> impl Iterator<Item = usize> + use<> {
        let n = self.side;
        let cell = |x: f64| ((x * n as f64) as usize).min(n - 1);
        let (x, y) = (cell(low.x)..=cell(high.x), cell(low.y)..=cell(high.y));
        y.flat_map(move |y| x.clone().map(move |x| y * n + x))
    }

    fn in_cell(&self, cell: usize) -> impl Iterator<Item = &[DVec3; 3]> {
        let list = &self.list[self.starts[cell] as usize..self.starts[cell + 1] as usize];
        list.iter().map(|i| &self.triangles[*i as usize])
    }

    /// Whether a point of texture space lies inside.
    pub fn contains(&self, point: DVec3) -> bool {
        let p = DVec3::new(point.y, point.z, point.x);
        if p.min_element() < 0.0 || p.max_element() > 1.0 {
            return false;
        }
        let cell = self.cells(p.truncate(), p.truncate()).next().unwrap_or(0);
        self.in_cell(cell).filter(|t| crossed_beyond(t, p)).count() % 2 == 1
    }

    /// Whether the surface comes nearer than `distance` (in texture space) to a point of texture space.
    pub fn is_near(&self, point: DVec3, distance: f64) -> bool {
        let p = DVec3::new(point.y, point.z, point.x);
        let mut cells = self.cells(p.truncate() - distance, p.truncate() + distance);
        cells.any(|cell| self.in_cell(cell).any(|t| squared_distance(*t, p) < distance * distance))
    }
}

/// On which side of a–b, seen along the third axis, a point lies: twice the area that they span, exactly turned round where the
/// ends are exchanged. 0 counts as positive for the edge in one direction and as negative in the other.
fn is_left(a: DVec3, b: DVec3, p: DVec3) -> bool {
    let (a, b) = (a.truncate(), b.truncate());
    let ordered = (a.x, a.y) < (b.x, b.y);
    let (from, to) = if ordered { (a, b) } else { (b, a) };
    let left = (to - from).perp_dot(p.truncate() - from) >= 0.0;
    left == ordered
}

/// Whether the ray from `p` along the third axis crosses the triangle.
fn crossed_beyond(t: &[DVec3; 3], p: DVec3) -> bool {
    let [a, b, c] = *t;
    let sides = [is_left(a, b, p), is_left(b, c, p), is_left(c, a, p)];
    if sides[0] != sides[1] || sides[1] != sides[2] {
        return false;
    }
    let n = (b - a).cross(c - a);
    // Seen edge-on it is crossed by its neighbours or not at all.
    n.z != 0.0 && n.dot(a - p) / n.z > 0.0
}
