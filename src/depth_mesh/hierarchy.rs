//! The restricted quadtree over a depth map, initialised (section 4.2).

use super::{
    bounds::Sphere,
    edge_error::edge_errors,
    exact_error::{Scan, bounds},
    grid::{Grid, midpoint},
    map::DepthMap,
    normals,
    options::{Distance, ErrorMeasure, Options, OptionsError, Propagation},
    propagate::{parent, splits},
    rays::Rays,
    segment::Segmenter,
    selection::Selection,
};
use glam::Vec3;
use rayon::prelude::*;

/// A depth map with what triangulations of it need: errors, segmentation flags, bounding spheres. Map and options determine
/// everything else within milliseconds, so those two are what is worth storing.
#[derive(Clone, Debug, PartialEq)]
pub struct Hierarchy {
    map: DepthMap,
    options: Options,
    distance: Distance,
    pub(super) grid: Grid,
    pub(super) rays: Rays,
    /// Squared error per grid point, or a bound of it.
    error: Vec<f32>,
    /// Eight segmentation flags per node.
    flags: Vec<u8>,
    /// Largest squared error of the points of a node, its border included.
    pub(super) node_error: Vec<f32>,
    /// Of all levels but the finest, or of the only one.
    pub(super) spheres: Vec<Sphere>,
    /// What is selected in any case.
    pub(super) splits: Option<Selection>,
}

impl Hierarchy {
    pub fn new(map: DepthMap, options: &Options) -> Result<Self, OptionsError> {
        options.check()?;
        let rays = Rays::new(map.view());
        let distance = match (options.distance, options.error) {
            (Distance::Planar, ErrorMeasure::Exact) => Distance::Full,
            (Distance::Planar, _) if !rays.narrow => Distance::Full,
            (distance, _) => distance,
        };
        let grid = Grid::of(map.side());
        let error = match options.error {
            ErrorMeasure::Edge => edge_errors(&map, &rays, distance),
            ErrorMeasure::Exact => bounds(&map, &rays, distance),
        };
        let mut nodes = Nodes::new(grid, options.propagation);
        nodes.leaves(&map, &error, &Segmenter::new(&map, &rays, options));
        nodes.climb(&error);
        let levels = (grid.k - 1).max(1);
        let spheres = (0..levels).flat_map(|level| nodes.spheres(level, &rays)).collect();
        let splits = (options.propagation == Propagation::Refine).then(|| splits(grid, &nodes.flags, &nodes.all));
        let Nodes { flags, error: node_error, .. } = nodes;
        Ok(Self { map, options: options.clone(), distance, grid, rays, error, flags, node_error, spheres, splits })
    }

    pub fn map(&self) -> &DepthMap {
        &self.map
    }

    pub fn options(&self) -> &Options {
        &self.options
    }

    /// How errors were measured: where [`Distance::Planar`] does not hold, `Full`.
    pub fn distance(&self) -> Distance {
        self.distance
    }

    /// Squared errors of all grid points, row by row, metres²; upper bounds with [`ErrorMeasure::Exact`]. They are not maximised up
    /// the hierarchy: closing a selection under its dependencies has the same effect.
    pub fn error(&self) -> &[f32] {
        &self.error
    }

    /// Whether the triangles that a grid point splits deviate by more than a squared tolerance: by its error, or by what is found under them
    /// where errors are bounds. Corners of the grid split nothing.
    pub(super) fn exceeds(&self, x: usize, y: usize, tolerance: f32) -> bool {
        self.error[y * self.map.side() + x] > tolerance
            && (self.options.error == ErrorMeasure::Edge
                || Scan { map: &self.map, rays: &self.rays, distance: self.distance }.exceeds(x, y, tolerance))
    }

    /// Segmentation flags of all quadtree nodes, level by level from the root, rows from the top: bits 0 to 7 for the triangles a1, a2, b1 to
    /// d2 of figure 11.
    pub fn flags(&self) -> &[u8] {
        &self.flags
    }

    /// The position of a grid point in the camera's frame (x right, y up, z forward), metres; `None` for background.
    pub fn camera_position(&self, x: usize, y: usize) -> Option<Vec3> {
        let z = self.map.depth()[y * self.map.side() + x];
        (z < f32::INFINITY).then(|| self.rays.position(x, y, z))
    }

    /// The unit normal of a grid point in the camera's frame, towards the camera.
    pub fn camera_normal(&self, x: usize, y: usize) -> Vec3 {
        normals::normal(&self.map, &self.rays, &self.options, x, y)
    }

    /// How squarely the camera samples a grid point: ρ of section 4.2, 0 to 1.
    pub fn quality(&self, x: usize, y: usize) -> f32 {
        normals::quality(&self.rays, x, y, self.camera_normal(x, y))
    }

    /// The sphere of the node of `level` around (x, y), or of the one above for nodes of the finest level.
    pub(super) fn sphere_around(&self, level: u32, x: usize, y: usize) -> usize {
        self.grid.node_around(level.min(self.grid.k.saturating_sub(2)), x, y)
    }
}

/// What is known per node while a hierarchy is made; nodes of a level are one after the other, levels from the root.
struct Nodes {
    grid: Grid,
    flags: Vec<u8>,
    /// Flags joined by and; empty where nothing asks for them.
    all: Vec<u8>,
    error: Vec<f32>,
    /// Least and largest finite depth.
    range: Vec<[f32; 2]>,
}

impl Nodes {
    fn new(grid: Grid, propagation: Propagation) -> Self {
        let count = grid.nodes();
        let all = if propagation == Propagation::Refine { vec![0; count] } else { Vec::new() };
        Self { grid, flags: vec![0; count], all, error: vec![0.0; count], range: vec![[0.0; 2]; count] }
    }

    /// The finest level.
    fn leaves(&mut self, map: &DepthMap, error: &[f32], segmenter: &Segmenter) {
        let (side, level) = (map.side(), self.grid.k - 1);
        let (first, wide) = (self.grid.before(level), 1usize << level);
        let depth = map.depth();
        let rows = self.flags[first..]
            .par_chunks_mut(wide)
            .zip(self.error[first..].par_chunks_mut(wide))
            .zip(self.range[first..].par_chunks_mut(wide));
        rows.with_min_len(8).enumerate().for_each(|(j, ((flags, errors), ranges))| {
            let y = 2 * j + 1;
            let lines = [y - 1, y, y + 1].map(|y| &depth[y * side..][..side]);
            for i in 0..wide {
                let x = 2 * i + 1;
                let (mut nearest, mut farthest, mut background) = (f32::INFINITY, f32::NEG_INFINITY, false);
                for line in lines {
                    for &z in &line[x - 1..x + 2] {
                        nearest = nearest.min(z);
                        let surface = z < f32::INFINITY;
                        farthest = farthest.max(if surface { z } else { f32::NEG_INFINITY });
                        background |= !surface;
                    }
                }
                ranges[i] = [nearest, farthest];
                flags[i] = segmenter.flags(x, y, nearest, farthest, background);
                errors[i] = own_error(error, side, x, y, 1);
            }
        });
        if !self.all.is_empty() {
            let flags = &self.flags[first..];
            self.all[first..].copy_from_slice(flags);
        }
    }

    /// All coarser levels.
    fn climb(&mut self, error: &[f32]) {
        let side = self.grid.side();
        for level in (0..self.grid.k - 1).rev() {
            let (h, wide) = (self.grid.half(level), 1usize << level);
            let (first, next) = (self.grid.before(level), self.grid.before(level + 1));
            let children = |i: usize, j: usize| {
                let at = (2 * j) * 2 * wide + 2 * i;
                [at, at + 1, at + 2 * wide + 1, at + 2 * wide]
            };
            let (flags, finer_flags) = self.flags[first..].split_at_mut(next - first);
            let (errors, finer_errors) = self.error[first..].split_at_mut(next - first);
            let (ranges, finer_ranges) = self.range[first..].split_at_mut(next - first);
            let rows = flags.par_chunks_mut(wide).zip(errors.par_chunks_mut(wide)).zip(ranges.par_chunks_mut(wide));
            rows.with_min_len(16).enumerate().for_each(|(j, ((flags, errors), ranges))| {
                for i in 0..wide {
                    let of = children(i, j);
                    flags[i] = parent(of.map(|c| finer_flags[c]), |a, b| a | b);
                    let own = own_error(error, side, (2 * i + 1) * h, (2 * j + 1) * h, h);
                    errors[i] = of.map(|c| finer_errors[c]).into_iter().fold(own, f32::max);
                    let [n, f] = of
                        .map(|c| finer_ranges[c])
                        .into_iter()
                        .fold([f32::INFINITY, f32::NEG_INFINITY], |a, b| [a[0].min(b[0]), a[1].max(b[1])]);
                    ranges[i] = [n, f];
                }
            });
            if !self.all.is_empty() {
                let (all, finer) = self.all[first..].split_at_mut(next - first);
                for (at, all) in all.iter_mut().enumerate() {
                    *all = parent(children(at % wide, at / wide).map(|c| finer[c]), |a, b| a & b);
                }
            }
        }
    }

    fn spheres(&self, level: u32, rays: &Rays) -> Vec<Sphere> {
        let (first, wide, size) = (self.grid.before(level), 1usize << level, 2 * self.grid.half(level));
        let sphere = |at: usize| {
            let (x, y) = (at % wide * size, at / wide * size);
            Sphere::around(rays, [x, x + size], [y, y + size], self.range[first + at])
        };
        (0..wide * wide).into_par_iter().with_min_len(256).map(sphere).collect()
    }
}

/// The largest error of a node's centre and the midpoints of its sides.
fn own_error(error: &[f32], side: usize, x: usize, y: usize, h: usize) -> f32 {
    let midpoints = (0..4).map(|q| midpoint((x, y), h, q));
    midpoints.map(|(x, y)| error[y * side + x]).fold(error[y * side + x], f32::max)
}
