//! Moving the vertices that are left to where the surface fits best.
//!
//! Contractions leave vertices anywhere within the tolerance: silhouettes draw back, slits open, and surfaces lie in front of or
//! behind what they stand for. Each vertex is moved, step by step, to where the faces around it touch most of their voxels
//! within the boxes that are not enlarged. No triangle is added or lost, and all that a contraction must keep is kept.

use super::{
    contract::keeps_side,
    cover::{Demand, any_touches},
    merge::around,
    surface::Surface,
};
use crate::{
    math::{Stop, Stopped},
    voxel::touch::{Point, Toucher},
};
use rayon::prelude::*;

/// Steps to a side that are tried, in quarter pixels, the longest first.
const STRIDES: [f64; 2] = [3.0, 1.0];
/// Most voxels that the faces around a vertex are compared by.
const SAMPLES: usize = 256;
/// What a bare end of the surface counts more than a voxel that is not touched.
const BARE_END: usize = 4;
/// Half sides of the box around a voxel's centre that a face must touch to cover it: a quarter pixel, and a layer.
const CENTRE: Point = [1.0, 1.0, 4.0];
/// Rounds over all vertices with one stride.
const ROUNDS: usize = 2;

impl Surface {
    pub fn settle(&mut self, stop: &Stop) -> Result<(), Stopped> {
        let mut star = Vec::new();
        for stride in STRIDES {
            let mut since = 0;
            for _ in 0..ROUNDS {
                let start = self.clock;
                for v in 0..self.points.len() as u32 {
                    if self.is_live(v) && !self.locked[v as usize] && self.changed[v as usize] > since {
                        stop.check()?;
                        self.settle_vertex(v, stride, &mut star);
                    }
                }
                if self.clock == start {
                    break;
                }
                since = start;
            }
        }
        Ok(())
    }

    fn settle_vertex(&mut self, v: u32, stride: f64, star: &mut Vec<u32>) {
        self.topology.star(v, star);
        let faces: Vec<u32> = star.iter().map(|c| c / 3).collect();
        if faces.len() > super::cover::MOST_FACES {
            return;
        }
        self.cover.collect(faces.iter().copied());
        let mut ring = Vec::new();
        self.topology.ring(v, star, &mut ring);
        let here = self.points[v as usize];
        let moved = |s: &Self, place: Point| -> Vec<[Point; 3]> {
            let corners = faces.iter().map(|f| s.topology.corners(*f));
            corners.map(|c| c.map(|u| if u == v { place } else { s.points[u as usize] })).collect()
        };
        let open = self.topology.is_boundary(v);
        let old = moved(self, here);
        let (samples, loose) = self.cover.samples(&old);
        let places: Vec<Point> = around(here, stride).skip(1).filter(|p| self.in_bounds(*p)).collect();
        let mut places: Vec<(usize, Point)> = places
            .par_iter()
            .with_min_len(places.len().div_ceil(rayon::current_num_threads()))
            .map(|p| (Fit::of(&moved(self, *p)).loose(&samples, loose), *p))
            .filter(|p| p.0 < loose)
            .collect();
        places.sort_by_key(|p| p.0);
        for (_, place) in places {
            let new = moved(self, place);
            if old.iter().zip(&new).all(|(o, n)| keeps_side(*o, *n))
                && self.cover.keeps(&new)
                && ring.iter().all(|u| {
                    let outer = open || self.topology.is_boundary(*u);
                    self.cover.holds(self.points[*u as usize], place, outer)
                })
            {
                self.cover.replace(faces.iter().copied(), &faces);
                self.points[v as usize] = place;
                self.note(v);
                return;
            }
        }
    }
}

/// A visible voxel that faces are compared by.
struct Sample {
    centre: Point,
    demand: Demand,
    /// Which of the faces touched it, and which covered its centre, where the vertex is now: likely they do elsewhere too.
    last: [usize; 2],
}

impl super::cover::Cover {
    /// A sample of the collected visible voxels, and how loosely `faces` fit it. Those that they miss come first: a place that is no better
    /// for them is found out at once.
    fn samples(&self, faces: &[[Point; 3]]) -> (Vec<Sample>, usize) {
        let every = self.collected_count().div_ceil(SAMPLES).max(1);
        let fit = Fit::of(faces);
        let of = |(centre, demand): (&Point, Demand)| {
            let mut last = [0; 2];
            let misses = fit.misses(centre, demand, &mut last);
            (misses, Sample { centre: *centre, demand, last })
        };
        let (missed, met): (Vec<_>, Vec<_>) = self.collected().step_by(every).map(of).partition(|s| s.0 > 0);
        let sum = missed.iter().map(|s| s.0).sum();
        (missed.into_iter().chain(met).map(|s| s.1).collect(), sum)
    }
}

/// Faces prepared for comparison with samples.
struct Fit {
    touchers: Vec<Toucher>,
    covering: Vec<Toucher>,
}

impl Fit {
    fn of(faces: &[[Point; 3]]) -> Self {
        Self {
            touchers: faces.iter().map(|f| Toucher::new(*f, 2.0)).collect(),
            covering: faces.iter().map(|f| Toucher::oblong(*f, CENTRE)).collect(),
        }
    }

    /// 1 if no face touches the voxel's box, which is not enlarged; where the surface ends and the faces leave the voxel's centre bare,
    /// [`BARE_END`] more. `last`: see [`Sample::last`].
    fn misses(&self, centre: &Point, demand: Demand, last: &mut [usize; 2]) -> usize {
        let apart = !any_touches(&self.touchers, centre, &mut last[0]);
        let bare = demand == Demand::End && !any_touches(&self.covering, centre, &mut last[1]);
        usize::from(apart) + if bare { BARE_END } else { 0 }
    }

    /// The sum over all samples; `most` stands for anything more.
    fn loose(&self, samples: &[Sample], most: usize) -> usize {
        let mut sum = 0;
        for s in samples {
            sum += self.misses(&s.centre, s.demand, &mut s.last.clone());
            if sum >= most {
                return most;
            }
        }
        sum
    }
}
