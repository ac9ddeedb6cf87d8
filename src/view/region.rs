//! The places from which a stand-in is looked at.

use super::Cell;
use crate::math::Aabb;
use glam::DVec3;

/// Where the eyes of those who look at a stand-in are. Metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Region {
    /// Anywhere in a box.
    Box(Cell),
    /// On the surface of a sphere around the object, `radius` > 0.
    Sphere { centre: DVec3, radius: f64 },
    /// On the straight lines from point to point, at least one.
    Path(Vec<DVec3>),
}

/// Points of a path that errors are judged from, at most.
const STATIONS: usize = 16;

impl Region {
    /// The eye at place `u` of the region, each in [0, 1): uniform by volume, by area and by length.
    pub fn eye(&self, u: [f64; 3]) -> DVec3 {
        match self {
            Self::Box(cell) => cell.centre + cell.half * (DVec3::from(u) * 2.0 - 1.0),
            Self::Sphere { centre, radius } => {
                let (z, angle) = (2.0 * u[0] - 1.0, std::f64::consts::TAU * u[1]);
                let around = (1.0 - z * z).max(0.0).sqrt();
                *centre + *radius * DVec3::new(around * libm::cos(angle), z, around * libm::sin(angle))
            }
            Self::Path(points) => along(points, u[0]),
        }
    }

    /// Where errors peak: the corners of a box, those of the cube inscribed in a sphere, stations of a path.
    pub fn extremes(&self) -> Vec<DVec3> {
        match self {
            Self::Box(cell) => cell.corners().to_vec(),
            Self::Sphere { centre, radius } => {
                let half = radius / 3.0_f64.sqrt();
                Aabb { min: *centre - half, max: *centre + half }.corners().to_vec()
            }
            Self::Path(points) => match points.len() {
                0..=STATIONS => points.clone(),
                _ => (0..STATIONS).map(|i| along(points, i as f64 / (STATIONS - 1) as f64)).collect(),
            },
        }
    }

    /// Around all of it.
    pub fn bounds(&self) -> Aabb {
        match self {
            Self::Box(cell) => cell.bounds(),
            Self::Sphere { centre, radius } => Aabb { min: *centre - *radius, max: *centre + *radius },
            Self::Path(points) => points.iter().copied().collect(),
        }
    }
}

/// The point at share `t` of the length of a line of points; the first where there is no length.
fn along(points: &[DVec3], t: f64) -> DVec3 {
    let total: f64 = points.windows(2).map(|p| p[0].distance(p[1])).sum();
    let mut left = t.clamp(0.0, 1.0) * total;
    for p in points.windows(2) {
        let length = p[0].distance(p[1]);
        if left <= length && length > 0.0 {
            return p[0].lerp(p[1], left / length);
        }
        left -= length;
    }
    if t > 0.0 { points.last() } else { points.first() }.copied().unwrap_or(DVec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Sequence;

    #[test]
    fn eyes_lie_in_their_region() {
        let sequence = Sequence::<3>::new(3);
        let cell = Cell { centre: DVec3::new(1.0, 2.0, 3.0), half: DVec3::new(0.5, 1.0, 2.0) };
        let (centre, radius) = (DVec3::new(-1.0, 0.5, 2.0), 3.0);
        let path = vec![DVec3::ZERO, DVec3::X * 4.0, DVec3::new(4.0, 4.0, 0.0)];
        for i in 0..200 {
            let u = sequence.point(i);
            assert!((Region::Box(cell).eye(u) - cell.centre).abs().cmple(cell.half).all());
            let on = Region::Sphere { centre, radius }.eye(u);
            assert!((on.distance(centre) - radius).abs() < 1e-12);
            let p = Region::Path(path.clone()).eye(u);
            assert!(p.z == 0.0 && (p.y == 0.0 && p.x <= 4.0 || p.x == 4.0 && p.y <= 4.0), "{p}");
        }
    }

    #[test]
    fn a_sphere_is_covered_evenly() {
        let sequence = Sequence::<3>::new(1);
        let region = Region::Sphere { centre: DVec3::ZERO, radius: 1.0 };
        let eyes: Vec<DVec3> = (0..6000).map(|i| region.eye(sequence.point(i))).collect();
        for axis in DVec3::AXES.into_iter().flat_map(|a| [a, -a]) {
            // A cap of one sixth of the area: height 2/6 of the diameter.
            let share = eyes.iter().filter(|e| e.dot(axis) > 2.0 / 3.0).count() as f64 / 6000.0;
            assert!((share - 1.0 / 6.0).abs() < 0.01, "{axis}: {share}");
        }
    }

    #[test]
    fn paths_of_any_length() {
        let one = Region::Path(vec![DVec3::ONE]);
        assert_eq!(one.eye([0.7, 0.0, 0.0]), DVec3::ONE);
        assert_eq!(one.extremes(), [DVec3::ONE]);
        let long = Region::Path((0..100).map(|i| DVec3::X * f64::from(i)).collect());
        assert_eq!(long.extremes().len(), STATIONS);
        assert_eq!(long.extremes().last(), Some(&(DVec3::X * 99.0)));
    }
}
