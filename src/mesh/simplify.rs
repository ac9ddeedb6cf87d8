//! Fewer triangles by meshoptimizer: edge collapse by quadric error (Garland and Heckbert, *Surface Simplification Using Quadric Error
//! Metrics*, 1997; with attributes as in Hoppe, *New Quadric Metric for Simplifying Meshes with Appearance Attributes*, 1999).
//!
//! Vertices never move: the result is a choice of the surface's own, so their attributes stay exact.

use meshopt::{SimplifyOptions, VertexDataAdapter};

/// A triangle mesh, borrowed.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    pub positions: &'a [[f32; 3]],
    /// `weights.len()` numbers per vertex.
    pub attributes: &'a [f32],
    /// What a difference of 1 in each attribute costs: 1 is as much as a displacement by the mesh's extent. At most 32.
    pub weights: &'a [f32],
    /// Indices into the positions.
    pub triangles: &'a [[u32; 3]],
}

/// When simplification ends. Topology and seams may end it before.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// Stop at this many triangles.
    pub triangles: usize,
    /// Stop before the surface moves by more, in the positions' unit; infinite for no bound.
    pub error: f32,
    /// Whether vertices of open edges stay.
    pub lock_border: bool,
}

/// The triangles that are left, in the surface's vertex numbers.
///
/// # Panics
/// Where `attributes` is shorter than the weights ask for, or a triangle names a vertex that is not there.
pub fn simplify(surface: &Surface, goal: &Goal) -> Vec<[u32; 3]> {
    let Surface { positions, attributes, weights, triangles } = *surface;
    let count = positions.len();
    assert!(weights.len() <= 32 && attributes.len() >= count * weights.len(), "an attribute is missing");
    assert!(triangles.as_flattened().iter().all(|v| (*v as usize) < count), "a triangle names no vertex");
    let size = size_of::<[f32; 3]>();
    let Ok(vertices) = VertexDataAdapter::new(bytemuck::cast_slice(positions), size, 0) else { return Vec::new() };
    let mut options = SimplifyOptions::ErrorAbsolute;
    options.set(SimplifyOptions::LockBorder, goal.lock_border);
    let left = meshopt::simplify_with_attributes_and_locks(
        triangles.as_flattened(),
        &vertices,
        attributes,
        weights,
        size_of::<f32>() * weights.len().max(1),
        &vec![false; count],
        goal.triangles.saturating_mul(3),
        goal.error.min(f32::MAX),
        options,
        None,
    );
    left.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect()
}

/// The vertices that `triangles` use, in the order of their first use, and the triangles in these vertices' numbers.
pub fn compact(vertices: usize, triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<[u32; 3]>) {
    let mut number = vec![u32::MAX; vertices];
    let mut used = Vec::new();
    let mut renumber = |v: u32| {
        let slot = &mut number[v as usize];
        if *slot == u32::MAX {
            *slot = used.len() as u32;
            used.push(v);
        }
        *slot
    };
    let triangles = triangles.iter().map(|t| t.map(&mut renumber)).collect();
    (used, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of n × n cells in the plane z = f(x, y), sides of length 1.
    fn sheet(n: u32, f: impl Fn(f32, f32) -> f32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let at = |x: u32, y: u32| [x as f32 / n as f32, y as f32 / n as f32];
        let positions = (0..=n).flat_map(|y| (0..=n).map(move |x| at(x, y))).map(|[x, y]| [x, y, f(x, y)]).collect();
        let number = |x: u32, y: u32| y * (n + 1) + x;
        let cell = |x: u32, y: u32| {
            let [a, b, c, d] = [number(x, y), number(x + 1, y), number(x + 1, y + 1), number(x, y + 1)];
            [[a, b, c], [a, c, d]]
        };
        (positions, (0..n).flat_map(|y| (0..n).flat_map(move |x| cell(x, y))).collect())
    }

    fn left(positions: &[[f32; 3]], triangles: &[[u32; 3]], goal: Goal) -> Vec<[u32; 3]> {
        simplify(&Surface { positions, attributes: &[], weights: &[], triangles }, &goal)
    }

    const FREE: Goal = Goal { triangles: 0, error: f32::INFINITY, lock_border: false };

    #[test]
    fn goals_are_kept() {
        let (positions, triangles) = sheet(16, |x, y| 0.1 * (x * x + y));
        let half = left(&positions, &triangles, Goal { triangles: 256, ..FREE });
        assert!((200..=256).contains(&half.len()), "{}", half.len());
        // A plane costs nothing: few of its 128 triangles are left within any error.
        let (plane, faces) = sheet(8, |_, _| 0.0);
        assert!(left(&plane, &faces, Goal { error: 1e-4, ..FREE }).len() <= 12);
        let (hills, faces) = sheet(8, |x, y| if (x, y) == (0.5, 0.5) { 0.2 } else { 0.0 });
        let kept = left(&hills, &faces, Goal { error: 0.01, ..FREE });
        assert!(kept.as_flattened().contains(&40), "the hill of 0.2 stays within an error of 0.01");
        let locked = left(&plane, &faces, Goal { error: 1e-4, lock_border: true, ..FREE });
        let border = |v: &u32| v.is_multiple_of(9) || v % 9 == 8 || v / 9 == 0 || v / 9 == 8;
        let stayed: std::collections::BTreeSet<u32> = locked.as_flattened().iter().copied().filter(border).collect();
        assert_eq!(stayed.len(), 32);
    }

    #[test]
    fn attributes_count() {
        let (plane, faces) = sheet(8, |_, _| 0.0);
        let colours: Vec<f32> = plane.iter().map(|p| if p[0] < 0.4 { 0.0 } else { 1.0 }).collect();
        let with = |weights: &[f32]| {
            let surface = Surface { positions: &plane, attributes: &colours, weights, triangles: &faces };
            simplify(&surface, &Goal { error: 0.01, ..FREE }).len()
        };
        assert_eq!(with(&[0.0]), 2);
        assert!(with(&[1.0]) > 2, "the border between colours stays");
    }

    #[test]
    fn only_used_vertices_are_kept() {
        assert_eq!(compact(5, &[[4, 1, 3], [3, 1, 4]]), (vec![4, 1, 3], vec![[0, 1, 2], [2, 1, 0]]));
        assert_eq!(compact(0, &[]), (vec![], vec![]));
        let none = Surface { positions: &[], attributes: &[], weights: &[], triangles: &[] };
        assert!(simplify(&none, &FREE).is_empty());
    }
}
