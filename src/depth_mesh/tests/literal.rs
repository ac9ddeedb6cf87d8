//! The paper's recursion word for word: triangles are bisected at the midpoint of their hypotenuse. Slow, and compared with the
//! rest on small grids.

use super::*;
use crate::math::squared_distance;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

type Point = (usize, usize);

/// A triangle with its hypotenuse from `l` to `r`, counter-clockwise as the camera sees it (y down).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Tri {
    pub l: Point,
    pub apex: Point,
    pub r: Point,
}

impl Tri {
    pub fn middle(self) -> Point {
        ((self.l.0 + self.r.0) / 2, (self.l.1 + self.r.1) / 2)
    }

    pub fn is_leaf(self) -> bool {
        self.l.0.abs_diff(self.r.0) <= 1 && self.l.1.abs_diff(self.r.1) <= 1
    }

    pub fn split(self) -> [Self; 2] {
        let m = self.middle();
        [Self { l: self.l, apex: m, r: self.apex }, Self { l: self.apex, apex: m, r: self.r }]
    }

    /// Corners, counter-clockwise.
    pub fn corners(self) -> [Point; 3] {
        let at = |p: Point| (p.0 as i64, p.1 as i64);
        let (l, a, r) = (at(self.l), at(self.apex), at(self.r));
        // Rows run downwards.
        let turn = (a.0 - l.0) * (r.1 - l.1) - (a.1 - l.1) * (r.0 - l.0);
        if turn < 0 { [self.l, self.apex, self.r] } else { [self.l, self.r, self.apex] }
    }

    pub fn covers(self, p: Point) -> bool {
        let c = self.corners().map(|(x, y)| (x as i64, y as i64));
        let p = (p.0 as i64, p.1 as i64);
        (0..3).all(|i| {
            let (a, b) = (c[i], c[(i + 1) % 3]);
            (b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0) <= 0
        })
    }

    pub fn leaves(self) -> Vec<Self> {
        if self.is_leaf() { vec![self] } else { self.split().into_iter().flat_map(Self::leaves).collect() }
    }
}

pub fn roots(n: usize) -> [Tri; 2] {
    [Tri { l: (0, 0), apex: (0, n), r: (n, n) }, Tri { l: (n, n), apex: (n, 0), r: (0, 0) }]
}

pub fn each(t: Tri, work: &mut impl FnMut(Tri)) {
    work(t);
    if !t.is_leaf() {
        for half in t.split() {
            each(half, work);
        }
    }
}

/// What every midpoint depends on: the apexes of the triangles that it splits, as far as they are no corners of the grid.
pub fn dependencies(n: usize) -> BTreeMap<Point, BTreeSet<Point>> {
    let mut found: BTreeMap<Point, BTreeSet<Point>> = BTreeMap::new();
    for root in roots(n) {
        each(root, &mut |t| {
            if !t.is_leaf() {
                let on = found.entry(t.middle()).or_default();
                if t.apex.0 % n != 0 || t.apex.1 % n != 0 {
                    on.insert(t.apex);
                }
            }
        });
    }
    found
}

pub fn close(n: usize, selected: &mut BTreeSet<Point>) {
    fn add(p: Point, dependencies: &BTreeMap<Point, BTreeSet<Point>>, selected: &mut BTreeSet<Point>) {
        for &q in &dependencies[&p] {
            if selected.insert(q) {
                add(q, dependencies, selected);
            }
        }
    }
    let dependencies = dependencies(n);
    for p in selected.clone() {
        if dependencies.contains_key(&p) {
            add(p, &dependencies, selected);
        }
    }
}

/// The triangles of a closed selection.
pub fn triangulation(n: usize, selected: &BTreeSet<Point>) -> Vec<Tri> {
    fn descend(t: Tri, selected: &BTreeSet<Point>, found: &mut Vec<Tri>) {
        if !t.is_leaf() && selected.contains(&t.middle()) {
            t.split().into_iter().for_each(|t| descend(t, selected, found));
        } else {
            found.push(t);
        }
    }
    let mut found = Vec::new();
    roots(n).into_iter().for_each(|t| descend(t, selected, &mut found));
    found
}

/// Positions in world space.
pub fn position(map: &DepthMap, (x, y): Point) -> Option<DVec3> {
    let z = map.depth()[y * map.side() + x];
    z.is_finite().then(|| map.view().unproject(x as f64 + 0.5, y as f64 + 0.5, f64::from(z)))
}

/// A leaf is a rubber sheet by equations (10) and (11), or touches background.
pub fn cut(map: &DepthMap, options: &Options, t: Tri) -> bool {
    let Some([a, b, c]) = corners(map, t) else { return true };
    let view = map.view();
    let z = [a, b, c].map(|p| (p - view.eye).dot(view.forward));
    let range = z.iter().fold(f64::MIN, |a, b| a.max(*b)) - z.iter().fold(f64::MAX, |a, b| a.min(*b));
    let v = match view.projection {
        Projection::Perspective { .. } => ((a + b + c) / 3.0 - view.eye).normalize(),
        Projection::Orthographic { .. } => view.forward,
    };
    let n = (b - a).cross(c - a).normalize();
    options.segmentation != Segmentation::None
        && range > f64::from(options.lambda)
        && v.dot(n).abs() < libm::cos((90.0 - f64::from(options.omega)).to_radians())
}

fn corners(map: &DepthMap, t: Tri) -> Option<[DVec3; 3]> {
    let [a, b, c] = t.corners().map(|p| position(map, p));
    Some([a?, b?, c?])
}

/// Equations (1) and (2), or the exact deviation, for points that touch no background. Not squared.
pub fn error(map: &DepthMap, options: &Options, p: Point) -> Option<f64> {
    let n = map.side() - 1;
    let mut splits = Vec::new();
    for root in roots(n) {
        each(root, &mut |t| {
            if !t.is_leaf() && t.middle() == p {
                splits.push(t);
            }
        });
    }
    if options.error == ErrorMeasure::Exact {
        let mut most = 0.0f64;
        for t in splits {
            let corners = corners(map, t)?;
            for q in (0..=n).flat_map(|y| (0..=n).map(move |x| (x, y))).filter(|q| t.covers(*q)) {
                most = most.max(squared_distance(corners, position(map, q)?));
            }
        }
        return Some(most.sqrt());
    }
    let t = splits[0];
    let [a, b, q] = [position(map, t.l)?, position(map, t.r)?, position(map, p)?];
    let diagonal = t.l.0 != t.r.0 && t.l.1 != t.r.1;
    if diagonal || options.distance == Distance::Full {
        return Some((b - a).cross(b - q).length() / (b - a).length());
    }
    let view = map.view();
    let axis = if t.l.1 == t.r.1 { view.right } else { view.up };
    let flat = |p: DVec3| ((p - view.eye).dot(axis), (p - view.eye).dot(view.forward));
    let ((ya, za), (yb, zb), (yp, zp)) = (flat(a), flat(b), flat(q));
    let m = (zb - za) / (yb - ya);
    Some((m * (yp - ya) - (zp - za)).abs() / (1.0 + m * m).sqrt())
}
