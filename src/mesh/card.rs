//! Convex polygons around points of a plane: the cards that impostors are drawn on.
//!
//! Polygons are lists of corners, counter-clockwise.

use glam::DVec2;

/// The convex hull of points (Andrew's monotone chain), without corners on its sides. Fewer than three corners where the points lie on a line.
pub fn hull(points: &[DVec2]) -> Vec<DVec2> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let chain = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut out: Vec<DVec2> = Vec::new();
        for p in points {
            while let [.., a, b] = out[..]
                && (b - a).perp_dot(p - b) <= 0.0
            {
                out.pop();
            }
            out.push(p);
        }
        out.pop();
        out
    };
    let mut out = chain(&mut sorted.iter().copied());
    out.extend(chain(&mut sorted.iter().rev().copied()));
    out
}

/// The part of a convex polygon on the inner side of every line: where p·normal ≤ distance.
pub fn cut(polygon: &[DVec2], lines: &[(DVec2, f64)]) -> Vec<DVec2> {
    let mut polygon = polygon.to_vec();
    for (normal, distance) in lines {
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (i, a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            let (da, db) = (a.dot(*normal) - distance, b.dot(*normal) - distance);
            if da <= 0.0 {
                kept.push(*a);
            }
            if (da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0) {
                kept.push(*a + (b - *a) * (da / (da - db)));
            }
        }
        polygon = kept;
    }
    polygon
}

/// A convex polygon of at most `most` corners (≥ 4) around a convex one. Again and again the side whose removal adds the least area
/// goes, and its neighbours are prolonged until they meet.
pub fn simplify(polygon: &[DVec2], most: usize) -> Vec<DVec2> {
    let mut corners = polygon.to_vec();
    while corners.len() > most.max(4) {
        let n = corners.len();
        // Without the side from corner i to i + 1 both become one point.
        let joint = |i: usize| {
            let [a, b, c, d] = [n - 1, 0, 1, 2].map(|k| corners[(i + k) % n]);
            let (e, f) = (b - a, c - d);
            let det = e.perp_dot(f);
            // The neighbours meet beyond the side where they turn by less than half a turn.
            (det < 0.0).then(|| {
                let p = a + e * ((d - a).perp_dot(f) / det);
                (i, p, (p - b).perp_dot(c - p).abs())
            })
        };
        let best = (0..n).filter_map(joint).filter(|j| j.1.is_finite()).min_by(|a, b| a.2.total_cmp(&b.2));
        let Some((i, p, _)) = best else { return corners };
        corners[i] = p;
        corners.remove((i + 1) % n);
    }
    corners
}

/// Signed area, positive where the corners run counter-clockwise.
pub fn area(polygon: &[DVec2]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>() * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn holds(polygon: &[DVec2], p: DVec2) -> bool {
        (0..polygon.len()).all(|i| {
            let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
            (b - a).perp_dot(p - a) >= -1e-6
        })
    }

    fn points() -> impl Strategy<Value = Vec<DVec2>> {
        prop::collection::vec((-20..20_i32, -20..20_i32), 3..80)
            .prop_map(|v| v.into_iter().map(|(x, y)| DVec2::new(x.into(), y.into())).collect())
    }

    proptest! {
        #[test]
        fn polygons_hold_their_points(points in points(), most in 4..9_usize) {
            let hull = hull(&points);
            prop_assume!(hull.len() >= 3);
            prop_assert!(area(&hull) > 0.0 && hull.iter().all(|c| points.contains(c)));
            let card = simplify(&hull, most);
            prop_assert!(card.len() <= most && card.len() <= hull.len() && area(&card) >= area(&hull) - 1e-6);
            for p in &points {
                prop_assert!(holds(&hull, *p) && holds(&card, *p), "{:?} {:?}", p, card);
            }
        }
    }

    #[test]
    fn a_circle_becomes_an_octagon() {
        let circle: Vec<DVec2> = (0..64)
            .map(|i| {
                let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(i) / 64.0);
                DVec2::new(cos, sin)
            })
            .collect();
        let card = simplify(&hull(&circle), 8);
        // A regular octagon around it has 8·tan(π/8) = 3.314.
        assert!(card.len() == 8 && (3.31..3.45).contains(&area(&card)), "{}", area(&card));
        let square = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)].map(DVec2::from);
        let sides: Vec<_> = circle.iter().map(|n| (*n, 1.0)).collect();
        assert!((std::f64::consts::PI..3.16).contains(&area(&cut(&square, &sides))));
        assert_eq!(cut(&square, &[(DVec2::X, -3.0)]), []);
        assert_eq!(hull(&[DVec2::ZERO, DVec2::ONE, DVec2::ONE * 2.0]).len(), 2);
    }
}
