//! Directions for relief maps (Andújar et al. 2007, section 3.1): regular ones moved to where the picture tells more and is stable, or the ones that
//! show most of what others have not shown.

use super::entropy::{Probe, Seen, Sight, information};
use crate::math::{Stop, Stopped};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Between directions that are compared, degrees: the six around one are those in which its picture should be stable.
const STEP: f64 = 2.0;

/// How regular directions are moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perturbation {
    /// At most, degrees.
    pub reach: f64,
    /// Bits of entropy that the share of the picture costs which a step in any direction reveals.
    pub stability: f64,
}

/// A direction that was moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    pub direction: DVec3,
    /// H(v) − λ·mean over the six vⱼ 2° away of Σ Aᵢ(vⱼ)/Aₜ over the faces i unseen in v; that of the regular direction, then that of this one.
    pub scores: [f64; 2],
    /// Whether it shows anything.
    pub blank: bool,
}

/// Moves each of `regular` (unit) to the best-scored direction that is found within reach: from the regular one to the best of its six neighbours in a triangular
/// lattice of 2°, and on as long as the score grows.
pub fn perturb(probe: &Probe, regular: &[DVec3], how: Perturbation, stop: &Stop) -> Result<Vec<Moved>, Stopped> {
    regular.par_iter().map(|d| Search::new(probe, *d, how, stop).climb()).collect()
}

/// A place in a triangular lattice on the plane that touches the sphere in a regular direction.
type Place = [i32; 2];

const AROUND: [Place; 6] = [[1, 0], [0, 1], [-1, 1], [-1, 0], [0, -1], [1, -1]];

struct Look {
    sight: Sight,
    entropy: f64,
}

struct Search<'a> {
    probe: &'a Probe<'a>,
    centre: DVec3,
    /// Tangents, orthonormal.
    axes: [DVec3; 2],
    how: Perturbation,
    stop: &'a Stop,
    looks: BTreeMap<Place, Look>,
}

impl<'a> Search<'a> {
    fn new(probe: &'a Probe, centre: DVec3, how: Perturbation, stop: &'a Stop) -> Self {
        let (x, y) = centre.any_orthonormal_pair();
        Self { probe, centre, axes: [x, y], how, stop, looks: BTreeMap::new() }
    }

    /// Degrees from the regular direction.
    fn offset(place: Place) -> DVec2 {
        let [q, r] = place.map(f64::from);
        STEP * DVec2::new(q + 0.5 * r, 0.75_f64.sqrt() * r)
    }

    fn direction(&self, place: Place) -> DVec3 {
        let offset = Self::offset(place);
        if place == [0, 0] {
            return self.centre;
        }
        let angle = offset.length().to_radians();
        let across = (self.axes[0] * offset.x + self.axes[1] * offset.y).normalize();
        (self.centre * libm::cos(angle) + across * libm::sin(angle)).normalize()
    }

    fn look(&mut self, place: Place) -> Result<&Look, Stopped> {
        if !self.looks.contains_key(&place) {
            let sight = self.probe.sight(self.direction(place), self.stop)?;
            self.looks.insert(place, Look { entropy: sight.entropy(), sight });
        }
        Ok(&self.looks[&place])
    }

    fn score(&mut self, place: Place) -> Result<f64, Stopped> {
        let mut seen = Seen::none(self.probe.face_count());
        let stability = self.how.stability;
        let look = self.look(place)?;
        let entropy = look.entropy;
        if stability == 0.0 {
            return Ok(entropy);
        }
        seen.add(&look.sight);
        let mut revealed = 0.0;
        for step in AROUND {
            revealed += self.look(beside(place, step))?.sight.beyond(&seen);
        }
        Ok(entropy - stability * revealed / AROUND.len() as f64)
    }

    fn climb(mut self) -> Result<Moved, Stopped> {
        let (mut at, mut best) = ([0, 0], self.score([0, 0])?);
        let first = best;
        loop {
            let from = at;
            let mut beyond = Vec::new();
            for place in AROUND.map(|step| beside(from, step)) {
                if Self::offset(place).length() <= self.how.reach + 1e-9 {
                    beyond.push((self.look(place)?.entropy, place));
                }
            }
            // No score is above its entropy: those that cannot be better need no look around.
            beyond.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            for (entropy, place) in beyond {
                if entropy <= best {
                    break;
                }
                let score = self.score(place)?;
                if score > best {
                    (at, best) = (place, score);
                }
            }
            if at == from {
                break;
            }
        }
        let blank = self.look(at)?.sight.faces.is_empty();
        Ok(Moved { direction: self.direction(at), scores: [first, best], blank })
    }
}

fn beside(place: Place, step: Place) -> Place {
    [place[0] + step[0], place[1] + step[1]]
}

/// What a greedy choice of directions shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Greedy {
    /// Numbers of candidates in the order of their choice.
    pub chosen: Vec<usize>,
    /// Faces that are seen in one of them.
    pub seen: usize,
    /// Those of the chosen that show nothing.
    pub blank: Vec<usize>,
}

/// Chooses up to `count` of the candidates (unit), one after the other: the one with the most information on faces that no other chosen one shows, of equals the first. The background
/// is no face. Where no candidate shows another face, all count again.
pub fn greedy(probe: &Probe, candidates: &[DVec3], count: usize, stop: &Stop) -> Result<Greedy, Stopped> {
    let sights: Vec<Sight> = candidates.par_iter().map(|d| probe.sight(*d, stop)).collect::<Result<_, _>>()?;
    let none = || Seen::none(probe.face_count());
    let (mut seen, mut ever) = (none(), none());
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < count.min(candidates.len()) {
        stop.check()?;
        let gain = |s: &Sight| s.faces.iter().filter(|f| !seen.has(f.0)).map(|f| information(f.1)).sum::<f64>();
        let gains: Vec<f64> = sights.par_iter().map(gain).collect();
        let open = (0..candidates.len()).filter(|i| !chosen.contains(i));
        let Some(best) = open.reduce(|a, b| if gains[b] > gains[a] { b } else { a }) else { break };
        if gains[best] == 0.0 && seen.count() > 0 {
            seen = none();
            continue;
        }
        seen.add(&sights[best]);
        ever.add(&sights[best]);
        chosen.push(best);
    }
    let blank = chosen.iter().copied().filter(|i| sights[*i].faces.is_empty()).collect();
    Ok(Greedy { chosen, seen: ever.count(), blank })
}
