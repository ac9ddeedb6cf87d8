//! Small spheres around points.

use super::directions::geodesic;
use crate::math::Aabb;
use glam::DVec3;
use rayon::prelude::*;

/// Steps of the search for the centre.
const STEPS: u32 = 1000;

/// Centre and radius of a sphere around points, metres: near to the smallest (Bădoiu and Clarkson 2003, section 2: after k steps the radius is at
/// most 1 + 1/√k times the least, in practice far closer). `None` where there is no point; the radius is never 0.
pub fn enclosing_sphere(points: &[DVec3]) -> Option<(DVec3, f64)> {
    // Points that are extreme in some direction stand for all while the centre is sought.
    let extreme: Vec<DVec3> = geodesic(2)
        .par_iter()
        .filter_map(|d| points.iter().copied().reduce(|a, b| if b.dot(*d) > a.dot(*d) { b } else { a }))
        .collect();
    let farthest = |points: &[DVec3], c: DVec3| {
        points.iter().copied().reduce(|a, b| if b.distance_squared(c) > a.distance_squared(c) { b } else { a })
    };
    let mut centre = points.iter().copied().collect::<Aabb>().centre();
    for step in 1..=STEPS {
        centre += (farthest(&extreme, centre)? - centre) / f64::from(step + 1);
    }
    let radius = farthest(points, centre)?.distance(centre);
    Some((centre, (radius * (1.0 + 1e-9)).max(1e-9)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Sequence;

    #[test]
    fn spheres_hold_their_points_and_are_small() {
        let cube = Aabb { min: DVec3::new(1.0, 2.0, 3.0), max: DVec3::new(2.0, 4.0, 5.0) };
        let (centre, radius) = enclosing_sphere(&cube.corners()).unwrap();
        assert!(centre.distance(cube.centre()) < 0.01 && (1.5..1.51).contains(&radius), "{centre} {radius}");
        let sequence = Sequence::<3>::new(7);
        // A cone of height 3 on a disc of radius 1: the smallest sphere goes through the tip and the rim, (9 + 1)/6.
        let cone: Vec<DVec3> = (0..2000)
            .map(|i| {
                let [u, v, w] = sequence.point(i);
                let (sin, cos) = libm::sincos(std::f64::consts::TAU * u);
                DVec3::new(w * cos * v.sqrt(), 3.0 * (1.0 - w), w * sin * v.sqrt())
            })
            .collect();
        let (centre, radius) = enclosing_sphere(&cone).unwrap();
        assert!(cone.iter().all(|p| p.distance(centre) <= radius));
        assert!((1.5..1.68).contains(&radius), "{radius}");
        assert_eq!(enclosing_sphere(&[]), None);
        assert!(enclosing_sphere(&[DVec3::ONE]).is_some_and(|(c, r)| c == DVec3::ONE && r > 0.0));
    }
}
