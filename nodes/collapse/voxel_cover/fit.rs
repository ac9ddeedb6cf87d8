//! The factor that meets a number of triangles.

use super::{Goal, Silhouette, simplify};
use crate::{
    math::{Stop, Stopped},
    voxel::VoxelMesh,
};
use rayon::prelude::*;
use std::ops::RangeInclusive;

/// Factors that make sense.
pub const FACTORS: RangeInclusive<f64> = 1.0..=8.0;
/// Factors that are tried lie this far apart: what differs by less differs by fewer triangles than chance.
const STEP: f64 = 1.0 / 16.0;
/// A number of triangles between this share of the target and the target ends the search.
const ENOUGH: f64 = 0.97;

/// Meshes that meet a target together.
pub struct Fit {
    /// The factor with which all of them were simplified.
    pub factor: f64,
    pub meshes: Vec<VoxelMesh>,
}

#[derive(Debug, thiserror::Error)]
pub enum FitError {
    #[error(
        "{target} triangles cannot be reached: the largest factor, {most}, leaves {least}; ask for {least} or more, or lower the resolution"
    )]
    Unreachable { target: usize, most: f64, least: usize },
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// The smallest factor with which `meshes` have at most `target` triangles together, to one step, by bisection. The number of
/// triangles falls with the factor but for a few per cent; what is returned meets the target whatever lies between.
pub fn fit(
    meshes: &[&VoxelMesh],
    target: usize,
    factors: RangeInclusive<f64>,
    silhouette: Silhouette,
    stop: &Stop,
) -> Result<Fit, FitError> {
    let (least, most) = (*factors.start(), *factors.end());
    let with = |step: u32| -> Result<Fit, Stopped> {
        let factor = (least + f64::from(step) * STEP).min(most);
        let meshes =
            meshes.par_iter().map(|m| simplify(m, Goal { factor, silhouette }, stop)).collect::<Result<_, _>>()?;
        Ok(Fit { factor, meshes })
    };
    let count = |fit: &Fit| fit.meshes.iter().map(|m| m.faces.len()).sum::<usize>();
    // `best` meets the target with `high` steps; with `low` − 1 steps, if there are such, it is missed.
    let (mut low, mut high) = (0, ((most - least) / STEP).ceil() as u32);
    let mut best = with(high)?;
    if count(&best) > target {
        return Err(FitError::Unreachable { target, most, least: count(&best) });
    }
    // Most targets are met by small factors, so those are tried first.
    let mut next = high / 8;
    while low < high && (count(&best) as f64) < ENOUGH * target as f64 {
        let tried = with(next)?;
        if count(&tried) <= target {
            (best, high) = (tried, next);
        } else {
            low = next + 1;
        }
        next = low + (high - low) / 2;
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{sample_fields as fields, voxel::cover_mesh::cover_meshes};

    fn skyline() -> Vec<VoxelMesh> {
        let solid = fields::skyline(160, 14, 10, 5);
        let slices = fields::slices(solid.size, solid.layers);
        cover_meshes(&slices, &[&solid.field()], &Stop::default()).unwrap().into_iter().map(|m| m.1).collect()
    }

    fn faces(meshes: &[VoxelMesh]) -> usize {
        meshes.iter().map(|m| m.faces.len()).sum()
    }

    #[test]
    fn a_target_is_met_with_about_the_smallest_factor() {
        let all = skyline();
        let all: Vec<&VoxelMesh> = all.iter().collect();
        let with = |factor| {
            all.iter()
                .map(|m| simplify(m, Goal { factor, silhouette: Silhouette::Geometry }, &Stop::default()).unwrap())
                .collect::<Vec<_>>()
        };
        let target = faces(&with(2.0));
        let found = fit(&all, target, 1.0..=8.0, Silhouette::Geometry, &Stop::default()).unwrap();
        assert!(faces(&found.meshes) <= target, "{} faces", faces(&found.meshes));
        // The count is not quite monotone in the factor, so that bisection may pass one that leaves a few less; none leaves many less.
        for k in (16..).map(|k| f64::from(k) / 16.0).take_while(|k| *k < found.factor).step_by(4) {
            assert!(faces(&with(k)) as f64 > 0.9 * target as f64, "{} faces at {k}, {}", faces(&with(k)), found.factor);
        }
        // They are what that factor makes, and say so: the error bound follows.
        assert_eq!(found.meshes, with(found.factor));
        assert!(found.meshes.iter().all(|m| m.factor == found.factor));
        let again = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(
            again.install(|| fit(&all, target, 1.0..=8.0, Silhouette::Geometry, &Stop::default())).unwrap().meshes,
            found.meshes
        );
        // Anything is enough for the smallest.
        assert_eq!(fit(&all, usize::MAX, 1.0..=8.0, Silhouette::Geometry, &Stop::default()).unwrap().factor, 1.0);
    }

    #[test]
    fn what_cannot_be_reached_names_what_can() {
        let all = skyline();
        let all: Vec<&VoxelMesh> = all.iter().collect();
        let least = match fit(&all, 1, 1.0..=3.0, Silhouette::Alpha, &Stop::default()) {
            Err(FitError::Unreachable { target: 1, most: 3.0, least }) => least,
            other => panic!("{:?}", other.map(|f| f.factor)),
        };
        let found = fit(&all, least, 1.0..=3.0, Silhouette::Alpha, &Stop::default()).unwrap();
        assert!(faces(&found.meshes) <= least);
    }
}
