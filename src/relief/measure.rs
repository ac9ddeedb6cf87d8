//! What original and maps cover in many directions, and the choice of maps that follows (sections 3.2 and 3.4).

use super::{
    Field, ReliefMap, Trace, coverage,
    coverage::Mask,
    select::{Choice, Covered, POOL, Subset, choose, closest, projected_length_threshold},
};
use crate::{
    math::{Stop, Stopped},
    raster::{Backend, Geometry, NOTHING, Options, nearest},
    view::{View, directions},
};
use glam::DVec3;
use rayon::prelude::*;

/// What original and maps cover, seen from many directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// Pixels along a side of the viewport, which is fitted to the original's projection in each direction: s0 of section 3.4.
    pub size: u32,
    /// How the maps were traced.
    pub trace: Trace,
    /// Names of the maps, and the directions towards their cameras.
    pub maps: Vec<(String, DVec3)>,
    /// Unit vectors from the object towards the eye.
    pub directions: Vec<DVec3>,
    /// One for each direction.
    pub covered: Vec<Covered>,
}

/// The maps that directions need, and up to which size they may be used.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    pub size: u32,
    pub trace: Trace,
    pub choice: Choice,
    /// Names of the maps, in their order.
    pub maps: Vec<String>,
    pub directions: Vec<DVec3>,
    /// One for each direction.
    pub subsets: Vec<Subset>,
}

/// A table of shares of s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    pub min: f64,
    pub avg: f64,
    pub max: f64,
}

/// The camera of a viewport: fitted to the original's projection. `None` where there is nothing to see.
pub fn viewport(corners: &[DVec3], direction: DVec3, size: u32) -> Option<View> {
    directions::look_along(corners.iter().copied(), direction, size, 0.0)
}

/// What is measured: a scene, and the scene that it is a part of.
#[derive(Clone, Copy)]
pub struct Original<'a> {
    pub geometry: &'a Geometry,
    /// Corners of its triangles.
    pub corners: &'a [DVec3],
    /// What it is a part of, with the corners of that: what this hides need not be covered, so that the inside of a part that was cut open does not count.
    pub whole: Option<(&'a Geometry, &'a [DVec3])>,
}

impl Original<'_> {
    /// What is covered in a view, and what of it nothing hides.
    fn masks(&self, backend: &dyn Backend, view: &View, stop: &Stop) -> Result<[Mask; 2], Stopped> {
        let seen = nearest(backend, self.geometry, view, &Options::default(), stop)?;
        let covered = Mask::new(seen.triangle.len(), |i| seen.triangle[i] != NOTHING);
        let Some((whole, corners)) = self.whole else { return Ok([covered.clone(), covered]) };
        let depth = |p: &DVec3| (*p - view.eye).dot(view.forward);
        let near = corners.iter().map(depth).fold(view.near, f64::min);
        let far = corners.iter().map(depth).fold(view.far, f64::max);
        let slack = (far - near) * HIDES;
        let wide = View { near: near - slack, far: far + slack, ..*view };
        let all = nearest(backend, whole, &wide, &Options::default(), stop)?;
        let visible =
            Mask::new(seen.depth.len(), |i| covered.covers(i) && f64::from(seen.depth[i] - all.depth[i]) <= slack);
        Ok([covered, visible])
    }
}

/// What lies so much nearer hides a part, as a share of the whole scene's depth.
const HIDES: f64 = 1e-4;

/// Measures what original and maps cover. Of each direction's maps only the [`POOL`] nearest are drawn.
pub fn measure(
    backend: &dyn Backend,
    original: Original,
    maps: &[(&str, &ReliefMap)],
    directions: Vec<DVec3>,
    size: u32,
    trace: Trace,
    stop: &Stop,
) -> Result<Coverage, Stopped> {
    let fields: Vec<Field> = maps.par_iter().map(|(_, map)| Field::new(map, trace.wall)).collect();
    let towards: Vec<DVec3> = fields.iter().map(|f| f.towards).collect();
    let covered = directions
        .par_iter()
        .map(|direction| {
            stop.check()?;
            let nearest_maps = closest(&towards, *direction, POOL);
            let Some(view) = viewport(original.corners, *direction, size) else {
                let nothing = Mask::empty(size as usize * size as usize);
                let maps = nearest_maps.iter().map(|m| (*m, nothing.clone())).collect();
                return Ok(Covered { original: nothing, maps });
            };
            let [covered, visible] = original.masks(backend, &view, stop)?;
            let maps = nearest_maps
                .into_iter()
                .map(|m| {
                    let mut mask = coverage::of_map(&fields[m as usize], &view, &trace, stop)?;
                    // What is hidden is neither missing nor extra.
                    mask.remove(&covered, &visible);
                    Ok((m, mask))
                })
                .collect::<Result<_, Stopped>>()?;
            Ok(Covered { original: visible, maps })
        })
        .collect::<Result<_, Stopped>>()?;
    let maps = maps.iter().zip(towards).map(|((name, _), t)| ((*name).to_owned(), t)).collect();
    Ok(Coverage { size, trace, maps, directions, covered })
}

impl Coverage {
    /// Chooses the maps of each direction; nothing is drawn.
    pub fn select(&self, choice: Choice) -> Selection {
        let pixels = u64::from(self.size) * u64::from(self.size);
        Selection {
            size: self.size,
            trace: self.trace,
            choice,
            maps: self.maps.iter().map(|m| m.0.clone()).collect(),
            directions: self.directions.clone(),
            subsets: (0..self.covered.len())
                .into_par_iter()
                .map(|i| {
                    let Choice::Best { neighbours, .. } = choice else {
                        return choose(&self.covered[i], &[], choice, pixels);
                    };
                    // The first is the direction itself.
                    let near = closest(&self.directions, self.directions[i], neighbours as usize + 1);
                    let beside: Vec<&Covered> = near.iter().skip(1).map(|j| &self.covered[*j as usize]).collect();
                    choose(&self.covered[i], &beside, choice, pixels)
                })
                .collect(),
        }
    }
}

impl Selection {
    fn spread(&self, pixels: impl Fn(&Subset) -> u64) -> Spread {
        let all = f64::from(self.size) * f64::from(self.size);
        let shares = || self.subsets.iter().map(|s| pixels(s) as f64 / all);
        Spread {
            min: shares().fold(f64::INFINITY, f64::min).min(1.0),
            avg: shares().sum::<f64>() / self.subsets.len().max(1) as f64,
            max: shares().fold(0.0, f64::max),
        }
    }

    /// Coverage error: pixels of the original that are missing, as a share of s².
    pub fn missing(&self) -> Spread {
        self.spread(|s| s.missing)
    }

    /// Pixels beyond the original, as a share of s².
    pub fn extra(&self) -> Spread {
        self.spread(|s| s.extra)
    }

    /// Maps drawn a frame: mean and greatest number.
    pub fn maps_per_frame(&self) -> (f64, usize) {
        let numbers = || self.subsets.iter().map(|s| s.maps.len());
        (numbers().sum::<usize>() as f64 / self.subsets.len().max(1) as f64, numbers().max().unwrap_or(0))
    }

    /// The projected length threshold, pixels; infinite where nothing is missing.
    pub fn plt(&self) -> f64 {
        projected_length_threshold(self.size, self.subsets.iter().map(|s| s.missing).max().unwrap_or(0))
    }

    /// Directions whose subset does not meet the goal; 0 without one.
    pub fn beyond_goal(&self) -> usize {
        let Choice::Best { goal, .. } = self.choice else { return 0 };
        let most = goal * f64::from(self.size) * f64::from(self.size);
        self.subsets.iter().filter(|s| s.missing as f64 > most).count()
    }
}
