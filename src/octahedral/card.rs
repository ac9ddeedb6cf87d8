//! The card on which an impostor is drawn.

use super::{Grid, Impostor, axes};
use crate::mesh::card;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Directions along a side of the grid that the card is fitted to.
const DIRECTIONS: u32 = 33;
/// Angles at which the card is measured.
const ANGLES: usize = 64;
/// Corners of a card.
const CORNERS: usize = 8;
/// Between the directions the outline bulges by less, as a share of the radius; two texels come on top.
const BULGE: f64 = 0.005;

/// Corners of a convex polygon of at most 8 corners that holds the object as it is seen from every direction of the grid's range; see
/// [`Impostor::card`]. The whole window where no texel is covered.
pub fn fit_card(impostor: &Impostor) -> Vec<[f64; 2]> {
    let points = outline(impostor);
    let grid = Grid { side: DIRECTIONS, hemi: impostor.grid.hemi };
    let angle = |i: usize| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * i as f64 / ANGLES as f64);
        DVec2::new(cos, sin)
    };
    let directions = (0..grid.side * grid.side).into_par_iter();
    let reach: Vec<f64> = directions
        .map(|i| {
            let [right, up] = axes(grid.direction(i % grid.side, i / grid.side));
            let flat: Vec<DVec2> = points.iter().map(|p| DVec2::new(p.dot(right), p.dot(up))).collect();
            let flat = card::hull(&flat);
            (0..ANGLES).map(|k| flat.iter().map(|p| p.dot(angle(k))).fold(f64::NEG_INFINITY, f64::max)).collect()
        })
        .reduce(
            || vec![f64::NEG_INFINITY; ANGLES],
            |a: Vec<f64>, b: Vec<f64>| a.iter().zip(b).map(|(a, b)| a.max(b)).collect(),
        );
    let margin = BULGE + 2.0 * impostor.texel() / impostor.radius;
    let sides: Vec<(DVec2, f64)> = reach.iter().enumerate().map(|(k, r)| (angle(k), r + margin)).collect();
    let window = [DVec2::new(-1.0, -1.0), DVec2::new(1.0, -1.0), DVec2::new(1.0, 1.0), DVec2::new(-1.0, 1.0)];
    // No frame holds anything beyond its window's circumcircle.
    let all = || window.map(|c| c.to_array()).to_vec();
    if points.is_empty() {
        return all();
    }
    let polygon = card::simplify(&card::cut(&window.map(|c| c * 2.0), &sides), CORNERS);
    if (3..=CORNERS).contains(&polygon.len()) { polygon.iter().map(DVec2::to_array).collect() } else { all() }
}

/// Points of the captured surface, in radii about the centre, of which the object's convex hull is made: the hull's corners of every frame.
fn outline(impostor: &Impostor) -> Vec<DVec3> {
    let Impostor { grid, tile, atlas, .. } = impostor;
    let frames = (0..grid.side * grid.side).into_par_iter();
    let found: Vec<Vec<DVec3>> = frames
        .map(|i| {
            let (column, row) = (i % grid.side, i / grid.side);
            let direction = grid.direction(column, row);
            let [right, up] = axes(direction);
            let first = row as usize * *tile as usize * atlas.side as usize + column as usize * *tile as usize;
            let mut ends = Vec::new();
            for y in 0..*tile as usize {
                // Between the first and the last covered texel of a row nothing is a corner.
                let line = &atlas.color[first + y * atlas.side as usize..][..*tile as usize];
                let covered = |t: &[u8; 4]| t[3] > 0;
                if let (Some(a), Some(b)) = (line.iter().position(covered), line.iter().rposition(covered)) {
                    ends.extend([a, b].map(|x| (x, y)));
                }
            }
            let place = |v: usize| (v as f64 + 0.5) / f64::from(*tile) * 2.0 - 1.0;
            let flat: Vec<DVec2> = ends.iter().map(|(x, y)| DVec2::new(place(*x), -place(*y))).collect();
            let corners = card::hull(&flat);
            let height = |p: &DVec2| {
                let at = ends.iter().zip(&flat).find(|(_, q)| *q == p).map_or((0, 0), |(at, _)| *at);
                f64::from(atlas.normal[first + at.1 * atlas.side as usize + at.0][3]) / 127.5 - 1.0
            };
            corners.iter().map(|p| right * p.x + up * p.y + direction * height(p)).collect()
        })
        .collect();
    found.concat()
}
