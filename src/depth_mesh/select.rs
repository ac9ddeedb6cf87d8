//! Which points a triangulation needs: for a tolerance in metres (section 4.3) or in pixels of a novel view (section 4.4).

use super::{
    emit::{Culling, Scratch, Triangulation, emit},
    frustum::Frustum,
    grid::{Grid, midpoint},
    hierarchy::Hierarchy,
    mesh::DepthMesh,
    options::ErrorMeasure,
    selection::Selection,
};
use crate::view::View;

/// Buffers that triangulations reuse, and the latest result. One serves hierarchies of any sizes.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    selection: Option<Selection>,
    verdicts: Vec<u8>,
    open: Open,
    nodes: Vec<Visit>,
    scratch: Scratch,
    triangulation: Triangulation,
}

impl Workspace {
    /// The latest result.
    pub fn triangulation(&self) -> &Triangulation {
        &self.triangulation
    }

    /// What was selected for it.
    pub fn selection(&self) -> Option<&Selection> {
        self.selection.as_ref()
    }

    /// Keeps only the latest result.
    pub fn into_triangulation(self) -> Triangulation {
        self.triangulation
    }

    /// An empty selection for grids of `side` points.
    fn start(&mut self, side: usize) -> Selection {
        match self.selection.take() {
            Some(mut selection) if selection.side() == side => {
                selection.clear();
                selection
            }
            _ => Selection::new(side),
        }
    }
}

impl Hierarchy {
    /// The triangulation for a tolerance ε in metres (equation 3): the points whose error is larger, and what they depend on.
    /// A negative ε gives the full resolution.
    pub fn static_mesh(&self, epsilon: f32) -> DepthMesh {
        let mut workspace = Workspace::default();
        self.triangulate(epsilon, &mut workspace);
        self.mesh(&workspace.triangulation)
    }

    /// [`Hierarchy::static_mesh`] without positions and normals, in buffers that are reused.
    pub fn triangulate<'w>(&self, epsilon: f32, workspace: &'w mut Workspace) -> &'w Triangulation {
        let mut selection = workspace.start(self.map().side());
        let bound = epsilon * epsilon;
        if epsilon < 0.0 {
            selection.fill();
        } else if self.options().error == ErrorMeasure::Exact {
            let splits = self.splits.iter().flat_map(Selection::points);
            self.descend(&mut selection, &mut workspace.open, splits, |x, y| self.exceeds(x, y, bound));
        } else {
            selection.above(self.error(), bound);
            if let Some(splits) = &self.splits {
                selection.union(splits);
            }
            selection.close();
        }
        self.finish(selection, None, workspace)
    }

    /// The triangulation of any selection of points and what they depend on. The selection must be made for grids of this side.
    pub fn triangulate_selection<'w>(&self, points: &Selection, workspace: &'w mut Workspace) -> &'w Triangulation {
        assert_eq!(points.side(), self.map().side(), "a selection belongs to grids of its own side");
        let mut selection = points.clone();
        selection.close();
        self.finish(selection, None, workspace)
    }

    /// The triangulation for `view` (equation 4): the points whose error looks larger than `tau` pixels there, d·f/|p − e| > τ with f pixels
    /// per unit of tangent, and what they depend on. In orthographic views d is scaled alone. Nodes outside the
    /// frustum are neither refined nor triangulated. `tau` = 0 asks for every point with an error.
    ///
    /// With [`ErrorMeasure::Edge`] every point is judged at its own distance; nodes are left out whose largest error is too small even
    /// at the distance of their bounding sphere. With [`ErrorMeasure::Exact`] points are judged at the distance of the sphere.
    pub fn view_dependent<'w>(&self, view: &View, tau: f32, workspace: &'w mut Workspace) -> &'w Triangulation {
        let mut selection = workspace.start(self.map().side());
        let frustum = Frustum::new(self.map().view(), view);
        let tolerance = frustum.tolerance(tau);
        let mut verdicts = std::mem::take(&mut workspace.verdicts);
        let mut culling = Culling::new(&frustum, self, &mut verdicts);
        match self.options().error {
            ErrorMeasure::Edge => {
                self.visit(&mut selection, &mut workspace.nodes, &mut culling, tolerance);
                selection.close();
            }
            ErrorMeasure::Exact => self.descend_in_view(&mut selection, &mut workspace.open, &mut culling, tolerance),
        }
        self.finish(selection, Some(&mut culling), workspace);
        workspace.verdicts = verdicts;
        &workspace.triangulation
    }

    fn finish<'w>(
        &self,
        selection: Selection,
        culling: Option<&mut Culling>,
        workspace: &'w mut Workspace,
    ) -> &'w Triangulation {
        emit(self, &selection, culling, &mut workspace.scratch, &mut workspace.triangulation);
        workspace.selection = Some(selection);
        &workspace.triangulation
    }

    /// The smallest closed selection that holds `first`, and every wanted point at least one of whose parents it holds: from the top
    /// down, so that only triangles are split that would otherwise be drawn. `wanted` is asked once per point.
    fn descend(
        &self,
        selection: &mut Selection,
        open: &mut Open,
        first: impl Iterator<Item = (usize, usize)>,
        mut wanted: impl FnMut(usize, usize) -> bool,
    ) {
        let short = |(x, y): (usize, usize)| (x as u16, y as u16);
        let Open { points: open, asked } = open;
        open.clear();
        let asked = match asked {
            Some(asked) if asked.side() == selection.side() => {
                asked.clear();
                asked
            }
            _ => asked.insert(Selection::new(selection.side())),
        };
        for (x, y) in first {
            selection.insert(x, y);
            open.push(short((x, y)));
        }
        let centre = self.grid.cells() / 2;
        if wanted(centre, centre) && selection.insert(centre, centre) {
            open.push(short((centre, centre)));
        }
        while let Some((x, y)) = open.pop() {
            let (x, y) = (usize::from(x), usize::from(y));
            for p in self.grid.parents(x, y).into_iter().flatten() {
                if selection.insert(p.0, p.1) {
                    open.push(short(p));
                }
            }
            for p in self.grid.dependants(x, y).into_iter().flatten() {
                if !selection.contains(p.0, p.1) && asked.insert(p.0, p.1) && wanted(p.0, p.1) {
                    selection.insert(p.0, p.1);
                    open.push(short(p));
                }
            }
        }
    }

    fn descend_in_view(&self, selection: &mut Selection, open: &mut Open, culling: &mut Culling, tolerance: f32) {
        let frustum = culling.frustum;
        // Of the nodes that hold the two triangles of a point, those in view; the nearest of their spheres.
        let mut distance = |x: usize, y: usize| {
            let h = Grid::half_at(x, y);
            let level = self.grid.k - 1 - h.trailing_zeros();
            let centre = x & h != 0 && y & h != 0;
            let nodes = if centre { [Some((x, y)), None] } else { self.grid.parents(x, y) };
            let seen = nodes.into_iter().flatten().filter_map(|(x, y)| {
                let node = self.sphere_around(level, x, y);
                let missed = culling.misses(self, node);
                (!missed).then(|| self.spheres[node].squared_distance(frustum.eye))
            });
            seen.reduce(f32::min)
        };
        let splits = self.splits.iter().flat_map(Selection::points);
        let splits: Vec<_> = splits.filter(|&(x, y)| distance(x, y).is_some()).collect();
        self.descend(selection, open, splits.into_iter(), |x, y| {
            distance(x, y).is_some_and(|d| self.exceeds(x, y, frustum.at(tolerance, d)))
        });
    }

    /// Selects the points of nodes in view whose own error shows.
    fn visit(&self, selection: &mut Selection, open: &mut Vec<Visit>, culling: &mut Culling, tolerance: f32) {
        let (side, frustum) = (self.map().side(), culling.frustum);
        open.clear();
        open.push(Visit { level: 0, i: 0, j: 0, distance: 0.0 });
        while let Some(Visit { level, i, j, mut distance }) = open.pop() {
            let node = self.grid.node(level, usize::from(i), usize::from(j));
            let h = self.grid.half(level);
            let (x, y) = ((2 * usize::from(i) + 1) * h, (2 * usize::from(j) + 1) * h);
            if culling.misses(self, node) {
                continue;
            }
            if let Some(sphere) = self.spheres.get(node) {
                distance = sphere.squared_distance(frustum.eye);
            }
            let splits = self.splits.as_ref().filter(|s| s.contains(x, y));
            if splits.is_none() && !(self.node_error[node] > frustum.at(tolerance, distance)) {
                continue;
            }
            for (x, y) in std::iter::once((x, y)).chain((0..4).map(|q| midpoint((x, y), h, q))) {
                let at = y * side + x;
                let (error, z) = (self.error()[at], self.map().depth()[at]);
                // Background has no place of its own.
                let from_eye = || match z < f32::INFINITY {
                    true => (self.rays.position(x, y, z) - frustum.eye).length_squared(),
                    false => distance,
                };
                let split = self.splits.as_ref().is_some_and(|s| s.contains(x, y));
                if split || error > 0.0 && error > frustum.at(tolerance, from_eye()) {
                    selection.insert(x, y);
                }
            }
            if h > 1 {
                for (di, dj) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    open.push(Visit { level: level + 1, i: 2 * i + di, j: 2 * j + dj, distance });
                }
            }
        }
    }
}

/// Points whose dependencies are to be looked at, and those that were asked for.
#[derive(Clone, Debug, Default)]
struct Open {
    points: Vec<(u16, u16)>,
    asked: Option<Selection>,
}

/// A node to look at.
#[derive(Clone, Copy, Debug)]
struct Visit {
    level: u32,
    i: u16,
    j: u16,
    /// Least squared distance from the eye of the node above.
    distance: f32,
}
