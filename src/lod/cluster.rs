//! Clusters: objects behind and beside each other that share one mesh and one texture (Chen et al. 2003, section 3.1.6).
//!
//! The paper's greedy way: objects by falling projected area; each is joined with every cluster that it can be joined with, those that it
//! overlaps most first. Joined are objects whose union needs a smaller texture than the parts and still passes the test for
//! the self-occluding error.

use super::outline::Outline;
use std::f64::consts::{PI, TAU};

/// Pixels beside a texture that belong to it.
const GUTTER: f64 = 2.0;

/// The rectangle that an outline covers on a cylinder around the cell's centre, in pixels: x to the right, y upwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    pub min: [f64; 2],
    pub max: [f64; 2],
    /// Pixels of a whole turn.
    turn: f64,
}

impl Rect {
    /// What `outline` covers, seen from the origin with `focal` pixels per radian.
    pub fn of(outline: &Outline, focal: f64) -> Self {
        let middle = outline.centre();
        let heading = libm::atan2(middle.x, -middle.z);
        let mut out = Self { min: [f64::INFINITY; 2], max: [f64::NEG_INFINITY; 2], turn: focal * TAU };
        for p in outline.corners() {
            let mut turned = libm::atan2(p.x, -p.z) - heading;
            if turned > PI {
                turned -= TAU;
            } else if turned < -PI {
                turned += TAU;
            }
            let at = [(heading + turned) * focal, p.y / libm::hypot(p.x, p.z).max(f64::MIN_POSITIVE) * focal];
            for k in 0..2 {
                (out.min[k], out.max[k]) = (out.min[k].min(at[k]), out.max[k].max(at[k]));
            }
        }
        out
    }

    /// Pixels of a texture for it.
    pub fn texels(&self) -> f64 {
        (0..2).map(|k| self.max[k] - self.min[k] + 2.0 * GUTTER).product()
    }

    /// The same rectangle a whole turn further or back, whichever is nearest to `other`.
    fn towards(&self, other: &Self) -> Self {
        let turns = ((other.min[0] + other.max[0] - self.min[0] - self.max[0]) * 0.5 / self.turn).round() * self.turn;
        Self { min: [self.min[0] + turns, self.min[1]], max: [self.max[0] + turns, self.max[1]], turn: self.turn }
    }

    /// Pixels that both cover.
    pub fn overlap(&self, other: &Self) -> f64 {
        let o = other.towards(self);
        (0..2).map(|k| (self.max[k].min(o.max[k]) - self.min[k].max(o.min[k])).max(0.0)).product()
    }

    pub fn union(&self, other: &Self) -> Self {
        let o = other.towards(self);
        Self {
            min: std::array::from_fn(|k| self.min[k].min(o.min[k])),
            max: std::array::from_fn(|k| self.max[k].max(o.max[k])),
            turn: self.turn,
        }
    }
}

/// Objects that share a stand-in.
#[derive(Clone, Debug, PartialEq)]
pub struct Cluster {
    /// Their numbers, rising.
    pub members: Vec<usize>,
    pub outline: Outline,
    pub rect: Rect,
}

impl Cluster {
    fn union(&self, other: &Self) -> Self {
        let mut members: Vec<usize> = self.members.iter().chain(&other.members).copied().collect();
        members.sort_unstable();
        Self { members, outline: self.outline.union(&other.outline), rect: self.rect.union(&other.rect) }
    }
}

/// Clusters of the objects with these outlines, each seen from the origin with `focal` pixels per radian. `passes` is the test for the
/// self-occluding error. The clusters are in the order of their first members.
pub fn cluster(outlines: &[Outline], focal: f64, passes: &dyn Fn(&Outline) -> bool) -> Vec<Cluster> {
    let one =
        |i: usize| Cluster { members: vec![i], outline: outlines[i].clone(), rect: Rect::of(&outlines[i], focal) };
    let mut sorted: Vec<Cluster> = (0..outlines.len()).map(one).collect();
    sorted.sort_by(|a, b| b.rect.texels().total_cmp(&a.rect.texels()));
    let mut clusters: Vec<Cluster> = Vec::new();
    for object in sorted {
        let mut joined = object.clone();
        let mut order: Vec<usize> = (0..clusters.len()).collect();
        let overlaps: Vec<f64> = clusters.iter().map(|c| c.rect.overlap(&object.rect)).collect();
        order.sort_by(|a, b| overlaps[*b].total_cmp(&overlaps[*a]));
        let mut gone = Vec::new();
        for at in order {
            let both = joined.union(&clusters[at]);
            let saves = both.rect.texels() < joined.rect.texels() + clusters[at].rect.texels();
            if saves && passes(&both.outline) {
                joined = both;
                gone.push(at);
            }
        }
        gone.sort_unstable();
        for at in gone.into_iter().rev() {
            clusters.remove(at);
        }
        clusters.push(joined);
    }
    clusters.sort_by_key(|c| c.members[0]);
    clusters
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    /// A box of side `2 half` on the ground, at an angle in turns and a distance.
    fn boxed(turn: f64, distance: f64, half: f64) -> Outline {
        let c = DVec2::new(libm::sin(turn * TAU), -libm::cos(turn * TAU)) * distance;
        let plan = [(-half, -half), (half, -half), (half, half), (-half, half)];
        Outline { plan: plan.iter().map(|(x, z)| c + DVec2::new(*x, *z)).collect(), low: 0.0, high: 2.0 * half }
    }

    #[test]
    fn one_behind_the_other_joins_and_one_aside_does_not() {
        let objects = [boxed(0.0, 100.0, 5.0), boxed(0.001, 112.0, 5.0), boxed(0.25, 100.0, 5.0)];
        let found = cluster(&objects, 800.0, &|_| true);
        assert_eq!(found.iter().map(|c| c.members.clone()).collect::<Vec<_>>(), [vec![0, 1], vec![2]]);
        assert_eq!(cluster(&objects, 800.0, &|o| o.depth() < 15.0).len(), 3, "the union is too deep");
    }

    #[test]
    fn the_seam_of_the_turn_is_no_border() {
        let at = |turn| Rect::of(&boxed(turn, 100.0, 5.0), 800.0);
        let (a, b, c) = (at(0.4999), at(0.5001), at(0.5001 - 1.0));
        assert!(a.overlap(&b) > 0.9 * 80.0 * 80.0 && (a.overlap(&b) - a.overlap(&c)).abs() < 1e-6);
        let (plain, moved) = (at(0.2499).union(&at(0.2599)), at(0.4999).union(&at(0.5099)));
        assert!((plain.texels() / moved.texels() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn textures_never_grow_and_every_object_has_one_cluster() {
        let sequence = crate::math::Sequence::<3>::new(9);
        let objects: Vec<Outline> = (0..60)
            .map(|i| sequence.point(i))
            .map(|u| boxed(u[0] * 0.2, 60.0 + 200.0 * u[1], 8.0 + 2.0 * u[2]))
            .collect();
        let found = cluster(&objects, 400.0, &|o| o.depth() < 100.0);
        let mut members: Vec<usize> = found.iter().flat_map(|c| c.members.clone()).collect();
        members.sort_unstable();
        assert_eq!(members, (0..60).collect::<Vec<_>>());
        let alone: f64 = objects.iter().map(|o| Rect::of(o, 400.0).texels()).sum();
        let together: f64 = found.iter().map(|c| c.rect.texels()).sum();
        assert!(found.len() < 60 && together < alone, "{} {together} {alone}", found.len());
    }
}
