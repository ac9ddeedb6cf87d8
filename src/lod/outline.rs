//! Where an object stands, told without its mesh: a convex polygon on the ground and a range of heights that hold it.

use crate::{mesh::card, scene::Object, view::Prism};
use glam::{DVec2, DVec3, Vec3};

/// Corners of an outline, at most.
const CORNERS: usize = 16;

/// A vertical prism that holds an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Corners (x, z) in order around, metres, convex; one or two where the object has no extent on the ground.
    pub plan: Vec<DVec2>,
    /// The heights between which it lies.
    pub low: f64,
    pub high: f64,
}

impl Outline {
    /// Around the vertices that the object's faces use; `None` where it has no face.
    pub fn of(object: &Object) -> Option<Self> {
        let transform = object.transform.as_dmat4();
        let (mut flat, mut low, mut high) = (Vec::new(), f64::INFINITY, f64::NEG_INFINITY);
        for mesh in object.parts.iter().map(|p| &p.mesh) {
            let mut used = vec![false; mesh.positions.len()];
            mesh.triangles.iter().flatten().for_each(|i| used[*i as usize] = true);
            for (p, _) in mesh.positions.iter().zip(&used).filter(|(_, used)| **used) {
                let p = transform.transform_point3(Vec3::from(*p).as_dvec3());
                (low, high) = (low.min(p.y), high.max(p.y));
                flat.push(DVec2::new(p.x, p.z));
            }
        }
        let plan = card::simplify(&card::hull(&flat), CORNERS);
        (!plan.is_empty()).then_some(Self { plan, low, high })
    }

    /// The outline as seen from `origin`.
    pub fn about(&self, origin: DVec3) -> Self {
        let plan = self.plan.iter().map(|p| *p - DVec2::new(origin.x, origin.z)).collect();
        Self { plan, low: self.low - origin.y, high: self.high - origin.y }
    }

    /// The corners of the prism.
    pub fn corners(&self) -> Vec<DVec3> {
        [self.low, self.high].iter().flat_map(|y| self.plan.iter().map(|p| DVec3::new(p.x, *y, p.y))).collect()
    }

    /// Distance of its nearest point from the origin; 0 where it holds the origin.
    pub fn nearest(&self) -> f64 {
        let flat = if inside(&self.plan, DVec2::ZERO) { 0.0 } else { nearest_on(&self.plan).length() };
        let up = self.low.max(-self.high).max(0.0);
        libm::hypot(flat, up)
    }

    /// Its middle.
    pub fn centre(&self) -> DVec3 {
        let (min, max) =
            self.plan.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
        let m = (min + max) * 0.5;
        DVec3::new(m.x, (self.low + self.high) * 0.5, m.y)
    }

    /// Its extent along the direction from the origin to its middle: the paper's depth l.
    pub fn depth(&self) -> f64 {
        let direction = self.centre().normalize_or(DVec3::X);
        let (near, far) = self
            .corners()
            .iter()
            .map(|c| c.dot(direction))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), d| (a.min(d), b.max(d)));
        far - near
    }

    /// Whether it reaches into the hexagon of a cell about the origin, whatever the heights.
    pub fn meets(&self, cell: &Prism) -> bool {
        let hexagon = Prism::hexagon(cell.size);
        // Convex polygons are apart if a side of one of them parts them.
        !(parted(&hexagon, &self.plan) || parted(&self.plan, &hexagon))
    }

    /// The outline that holds two of them.
    pub fn union(&self, other: &Self) -> Self {
        let all: Vec<DVec2> = self.plan.iter().chain(&other.plan).copied().collect();
        Self {
            plan: card::simplify(&card::hull(&all), CORNERS),
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }
}

/// The point of a convex polygon's boundary that is nearest to the origin.
fn nearest_on(polygon: &[DVec2]) -> DVec2 {
    let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let on = |(a, b): (&DVec2, &DVec2)| {
        let d = *b - *a;
        let t = if d.length_squared() > 0.0 { (-a.dot(d) / d.length_squared()).clamp(0.0, 1.0) } else { 0.0 };
        *a + d * t
    };
    sides.map(on).min_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or(DVec2::ZERO)
}

fn inside(polygon: &[DVec2], p: DVec2) -> bool {
    polygon.len() >= 3
        && polygon.iter().zip(polygon.iter().cycle().skip(1)).all(|(a, b)| (*b - *a).perp_dot(p - *a) >= 0.0)
}

/// Whether a side of `a` has all of `b` strictly outside. A polygon of two corners has the line through them, one of one corner nothing.
fn parted(a: &[DVec2], b: &[DVec2]) -> bool {
    let sides = a.iter().zip(a.iter().cycle().skip(1));
    sides.filter(|(p, q)| p != q).any(|(p, q)| b.iter().all(|c| (*q - *p).perp_dot(*c - *p) < 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, z: f64, half: f64) -> Outline {
        let plan = [(-half, -half), (half, -half), (half, half), (-half, half)];
        Outline { plan: plan.iter().map(|(a, b)| DVec2::new(x + a, z + b)).collect(), low: 0.0, high: 2.0 }
    }

    #[test]
    fn distances_and_depths() {
        let o = square(10.0, 0.0, 1.0);
        assert_eq!(o.nearest(), 9.0);
        assert_eq!(o.about(DVec3::new(0.0, 5.0, 0.0)).nearest(), libm::hypot(9.0, 3.0));
        assert!((square(10.0, 0.0, 1.0).about(DVec3::Y).depth() - 2.0).abs() < 1e-12);
        assert_eq!(square(0.0, 0.0, 3.0).nearest(), 0.0);
        assert_eq!(o.union(&square(20.0, 0.0, 1.0)).nearest(), 9.0);
    }

    #[test]
    fn who_meets_a_cell() {
        let cell = Prism { centre: DVec3::ZERO, size: 2.0, half_height: 1.0 };
        assert!(square(0.0, 0.0, 0.1).meets(&cell), "inside");
        assert!(square(0.0, 0.0, 50.0).meets(&cell), "around");
        assert!(square(2.5, 0.0, 0.6).meets(&cell), "across a corner");
        assert!(!square(2.5, 0.0, 0.4).meets(&cell));
        // Beyond the slanted side, inside the bounding box.
        assert!(!square(1.9, 1.6, 0.1).meets(&cell));
        let point = Outline { plan: vec![DVec2::new(0.5, 0.5)], low: 0.0, high: 1.0 };
        assert!(point.meets(&cell));
        let beside = Outline { plan: vec![DVec2::new(9.0, 0.0), DVec2::new(9.0, 5.0)], low: 0.0, high: 1.0 };
        assert!(!beside.meets(&cell));
    }

    #[test]
    fn it_holds_its_object() {
        let scene = crate::scene::builtin::make("car", 1).unwrap();
        for object in &scene.objects {
            let o = Outline::of(object).unwrap();
            let b = object.bounds();
            assert!((o.low, o.high) == (b.min.y, b.max.y) && o.plan.len() <= CORNERS);
            let one = crate::scene::Scene { objects: vec![object.clone()] };
            for p in one.points() {
                let grown = Outline {
                    plan: o.plan.iter().map(|c| *c + (*c - DVec2::new(o.centre().x, o.centre().z)) * 1e-9).collect(),
                    ..o.clone()
                };
                assert!(grown.plan.len() < 3 || inside(&grown.plan, DVec2::new(p.x, p.z)), "{}: {p}", object.name);
            }
        }
    }
}
