//! Moving the vertices that are left to where the surface fits best.
//!
//! Contractions leave vertices anywhere within the tolerance: silhouettes draw back, slits open, and surfaces lie in front of or
//! behind what they stand for. Each vertex is moved, step by step, to where the faces around it touch most of their voxels
//! within the boxes that are not enlarged. No triangle is added or lost, and all that a contraction must keep is kept.

use super::{
    contract::{Surface, keeps_side},
    merge::around,
};
use crate::{
    math::{Stop, Stopped},
    voxel::touch::{Point, Toucher},
};

/// Steps to a side that are tried, in quarter pixels, the longest first.
const STRIDES: [f64; 2] = [3.0, 1.0];
/// Rounds over all vertices with one stride.
const ROUNDS: usize = 4;

impl Surface {
    pub fn settle(&mut self, stop: &Stop) -> Result<(), Stopped> {
        let mut star = Vec::new();
        for stride in STRIDES {
            for _ in 0..ROUNDS {
                let mut moved = 0;
                for v in 0..self.points.len() as u32 {
                    if self.is_live(v) && !self.locked[v as usize] {
                        stop.check()?;
                        moved += usize::from(self.settle_vertex(v, stride, &mut star));
                    }
                }
                if moved == 0 {
                    break;
                }
            }
        }
        Ok(())
    }

    fn settle_vertex(&mut self, v: u32, stride: f64, star: &mut Vec<u32>) -> bool {
        self.topology.star(v, star);
        let faces: Vec<u32> = star.iter().map(|c| c / 3).collect();
        if faces.len() > super::cover::MOST_FACES {
            return false;
        }
        self.cover.collect(faces.iter().copied());
        let rim = self.topology.rim(v, star);
        let here = self.points[v as usize];
        let moved = |s: &Self, place: Point| -> Vec<[Point; 3]> {
            let corners = faces.iter().map(|f| s.topology.corners(*f));
            corners.map(|c| c.map(|u| if u == v { place } else { s.points[u as usize] })).collect()
        };
        let old = moved(self, here);
        let mut places: Vec<(usize, Point)> = around(here, stride)
            .skip(1)
            .filter(|p| self.in_bounds(*p))
            .map(|p| (self.cover.tight(&moved(self, p)), p))
            .collect();
        let least = self.cover.tight(&old);
        places.retain(|p| p.0 > least);
        places.sort_by_key(|p| std::cmp::Reverse(p.0));
        for (_, place) in places {
            let new = moved(self, place);
            if old.iter().zip(&new).all(|(o, n)| keeps_side(*o, *n))
                && self.cover.keeps(&new)
                && rim.iter().flatten().all(|u| self.cover.holds_edge(self.points[*u as usize], place))
            {
                self.cover.replace(faces.iter().copied(), &faces);
                self.points[v as usize] = place;
                return true;
            }
        }
        false
    }
}

impl super::cover::Cover {
    /// How many of the collected visible voxels the faces touch within boxes that are not enlarged.
    fn tight(&self, faces: &[[Point; 3]]) -> usize {
        let touchers: Vec<Toucher> = faces.iter().map(|f| Toucher::new(*f, 2.0)).collect();
        self.collected().filter(|c| touchers.iter().any(|t| t.touches(c))).count()
    }
}
