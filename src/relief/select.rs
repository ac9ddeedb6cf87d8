//! Which maps a direction of view needs (section 3.2), and how large the object may appear (section 3.4).

use super::coverage::Mask;
use glam::DVec3;

/// How subsets are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Choice {
    /// The m maps whose directions are nearest to the direction of view.
    Closest(u32),
    /// The smallest subset of the pool whose coverage error is at most `goal`, a share of all pixels of the viewport; of those the one with the
    /// least error, of these the first in the order of the pool. All of the pool where none meets the goal.
    ///
    /// Beyond the paper, a subset must also miss no more than [`SLACK`] times the goal in the `neighbours` directions nearest to its own, because it is drawn
    /// for what lies between them too; 0 is the paper's choice.
    Best { goal: f64, neighbours: u32 },
}

/// The maps that are considered for a direction: as many as a set of 63 subsets has.
pub const POOL: usize = 6;

/// How many times the goal a subset may miss in the directions beside its own.
pub const SLACK: f64 = 2.0;

/// Numbers of the up to `m` maps nearest to a direction, the nearest first; of equals the first.
pub fn closest(maps: &[DVec3], direction: DVec3, m: usize) -> Vec<u32> {
    let mut order: Vec<u32> = (0..maps.len() as u32).collect();
    let near = |i: u32| maps[i as usize].dot(direction);
    order.sort_by(|a, b| near(*b).total_cmp(&near(*a)).then(a.cmp(b)));
    order.truncate(m);
    order
}

/// What was measured in one direction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Covered {
    /// What the original covers.
    pub original: Mask,
    /// Numbers of the nearest maps, the nearest first, and what each of them covers.
    pub maps: Vec<(u32, Mask)>,
}

/// The maps that a direction needs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subset {
    /// Numbers of maps, the one nearest to the direction first.
    pub maps: Vec<u32>,
    /// Pixels of the original that none of them covers.
    pub missing: u64,
    /// Pixels that they cover and the original does not.
    pub extra: u64,
}

/// Chooses maps for a direction; `beside` are the directions that [`Choice::Best`] looks at too. `pixels` of the viewport.
pub fn choose(covered: &Covered, beside: &[&Covered], choice: Choice, pixels: u64) -> Subset {
    let count = covered.maps.len().min(POOL);
    let whole = (1_u32 << count) - 1;
    let goal = match choice {
        Choice::Closest(m) => return judge(covered, whole & (1_u32 << m.min(31)).wrapping_sub(1)),
        Choice::Best { goal, .. } => goal,
    };
    let most = goal * pixels as f64;
    for size in 1..=count as u32 {
        let of_size = (1..=whole).filter(|bits| bits.count_ones() == size).map(|bits| judge(covered, bits));
        let good = of_size.filter(|s| {
            let bears = |other: &&Covered| missing(other, &s.maps) as f64 <= SLACK * most;
            s.missing as f64 <= most && beside.iter().all(bears)
        });
        if let Some(best) = good.min_by_key(|s| (s.missing, s.extra)) {
            return best;
        }
    }
    judge(covered, whole)
}

/// Pixels of the original that none of `maps` covers, of those that were drawn in this direction.
fn missing(covered: &Covered, maps: &[u32]) -> u64 {
    covered.original.beyond(&union(covered, covered.maps.iter().filter(|(m, _)| maps.contains(m))))
}

fn judge(covered: &Covered, bits: u32) -> Subset {
    let chosen = || covered.maps.iter().enumerate().filter(move |(i, _)| bits >> i & 1 == 1).map(|(_, m)| m);
    let union = union(covered, chosen());
    Subset {
        maps: chosen().map(|m| m.0).collect(),
        missing: covered.original.beyond(&union),
        extra: union.beyond(&covered.original),
    }
}

/// What several maps cover together.
fn union<'a>(covered: &Covered, maps: impl Iterator<Item = &'a (u32, Mask)>) -> Mask {
    let mut union = Mask(vec![0; covered.original.0.len()]);
    for (_, mask) in maps {
        union.join(mask);
    }
    union
}

/// The projected length threshold in pixels: s0²/GC(s0), the size at which a row of pixels misses one on average; `missing` pixels is the worst of all
/// directions at `size` pixels (section 3.4). Infinite where nothing is missing.
pub fn projected_length_threshold(size: u32, missing: u64) -> f64 {
    f64::from(size) * f64::from(size) / missing as f64
}
