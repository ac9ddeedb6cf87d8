//! Surfaces that hide others from every point of a cell, and the edges at which they may end.

use crate::scene::{Alpha, Scene};
use glam::{DAffine3, DVec3, Vec3};

/// The opaque triangles of a shape. Vertices of one position are joined.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Opaque {
    /// Metres, about the shape's origin.
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    /// For each triangle: both sides are drawn.
    double_sided: Vec<bool>,
}

impl Opaque {
    /// Of a scene, without materials that have holes or that light shines through.
    pub fn of(scene: &Scene) -> Self {
        let mut corners: Vec<Vec3> = Vec::new();
        let mut out = Self::default();
        for object in &scene.objects {
            for part in object.parts.iter().filter(|p| p.material.alpha == Alpha::Opaque) {
                let first = corners.len() as u32;
                // Zero has one sign, so that equal positions have equal bits.
                corners.extend(
                    part.mesh.positions.iter().map(|p| object.transform.transform_point3(Vec3::from(*p)) + 0.0),
                );
                out.triangles.extend(part.mesh.triangles.iter().map(|t| t.map(|v| first + v)));
                out.double_sided.resize(out.triangles.len(), part.material.double_sided);
            }
        }
        let bits = |v: u32| corners[v as usize].to_array().map(f32::to_bits);
        let mut order: Vec<u32> = (0..corners.len() as u32).collect();
        order.sort_unstable_by_key(|v| (bits(*v), *v));
        let mut joined = vec![0; corners.len()];
        for (i, v) in order.iter().enumerate() {
            if i == 0 || bits(order[i - 1]) != bits(*v) {
                out.positions.push(corners[*v as usize]);
            }
            joined[*v as usize] = out.positions.len() as u32 - 1;
        }
        out.triangles.iter_mut().flatten().for_each(|v| *v = joined[*v as usize]);
        out
    }

    /// The part that hides what is behind it from all of `eyes` and from all points between them: the triangles that each of them sees from one
    /// side, which is drawn. Their corners are turned to be counter-clockwise seen from the eyes. `place` takes the shape to where the eyes are.
    pub fn towards(&self, place: &DAffine3, eyes: &[DVec3]) -> Patches {
        let positions: Vec<DVec3> = self.positions.iter().map(|p| place.transform_point3(p.as_dvec3())).collect();
        let mirrored = place.matrix3.determinant() < 0.0;
        let mut triangles: Vec<[u32; 3]> = Vec::new();
        for (t, double_sided) in self.triangles.iter().zip(&self.double_sided) {
            let t = if mirrored { [t[0], t[2], t[1]] } else { *t };
            let [a, b, c] = t.map(|v| positions[v as usize]);
            let n = (b - a).cross(c - a);
            if eyes.iter().all(|e| n.dot(*e - a) > 0.0) {
                triangles.push(t);
            } else if *double_sided && eyes.iter().all(|e| n.dot(*e - a) < 0.0) {
                triangles.push([t[0], t[2], t[1]]);
            }
        }
        let edges = borders(&triangles);
        Patches { positions, triangles, edges }
    }
}

/// Continuous surfaces that face a cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Patches {
    /// About the cell's centre, metres.
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Where they do not go on: elsewhere two triangles meet, each the other's neighbour.
    pub edges: Vec<[u32; 2]>,
}

/// Edges that are not shared by just two triangles of one orientation.
fn borders(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let of = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    let mut edges: Vec<([u32; 2], bool)> =
        triangles.iter().flat_map(of).map(|[a, b]| if a < b { ([a, b], true) } else { ([b, a], false) }).collect();
    edges.sort_unstable();
    let same = edges.chunk_by(|a, b| a.0 == b.0);
    same.filter(|e| !matches!(e, [(_, false), (_, true)])).map(|e| e[0].0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{scene::builtin, view::Prism};

    /// A closed solid in front of a cell ends at its outline, which is one loop or more: every vertex of it has an even number of edges.
    #[test]
    fn borders_are_loops() {
        let mut scene = builtin::make("solids", 1).unwrap();
        for part in scene.objects.iter_mut().flat_map(|o| &mut o.parts) {
            std::sync::Arc::make_mut(&mut part.material).double_sided = false;
        }
        let cell = Prism { centre: DVec3::ZERO, size: 1.0, half_height: 0.1 };
        for object in &scene.objects {
            let shape = Opaque::of(&Scene { objects: vec![object.clone()] });
            let patches = shape.towards(&DAffine3::from_translation(DVec3::new(40.0, 3.0, 7.0)), &cell.corners());
            assert!(!patches.triangles.is_empty() && !patches.edges.is_empty(), "{}", object.name);
            assert!(patches.triangles.len() < shape.triangles.len(), "{}", object.name);
            let mut degree = vec![0; patches.positions.len()];
            patches.edges.iter().flatten().for_each(|v| degree[*v as usize] += 1);
            assert!(degree.iter().all(|d| d % 2 == 0), "{}", object.name);
        }
    }

    #[test]
    fn what_has_holes_hides_nothing() {
        let mut scene = builtin::make("solids", 1).unwrap();
        for part in scene.objects.iter_mut().flat_map(|o| &mut o.parts) {
            std::sync::Arc::make_mut(&mut part.material).alpha = Alpha::Mask { cutoff: 0.5 };
        }
        assert_eq!(Opaque::of(&scene), Opaque::default());
    }
}
