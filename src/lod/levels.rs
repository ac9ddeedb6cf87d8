//! Simplified meshes of an object for every distance: where stand-ins start from. Far cells start from a mesh that differs from the original
//! by a fraction of a pixel, which costs a fraction of its time.

use crate::{
    array::Array,
    image::srgb,
    mesh::simplify::{Goal, Surface, compact, simplify},
    raster::texel_at,
    scene::{Part, Scene},
};
use glam::Vec3;
use std::collections::BTreeMap;

/// Meshes of one object, finest first, about its own origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    /// At least one: the first is the original with vertices of one position joined.
    pub levels: Vec<Level>,
    /// Some material shows both sides.
    pub double_sided: bool,
}

/// One mesh. Its vertices are some of the original's.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// How far its surface lies from the original's, by the simplifier's quadrics, metres.
    pub error: f64,
    /// Metres.
    pub positions: Array<[f32; 3]>,
    /// The original's base colour at the vertex, sRGB-encoded.
    pub colors: Array<[u8; 4]>,
    pub triangles: Array<[u32; 3]>,
}

/// Errors of the levels after the first: from this share of the object's diagonal, each twice the one before.
const FIRST: f64 = 1.0 / 16384.0;
const LEVELS: i32 = 10;
/// A level is kept where it has at most this share of the one before.
const WORTH: f64 = 0.7;

/// At most `most` levels of a scene, which is taken as one object. `None` where it has no triangle.
pub fn levels(scene: &Scene, most: u32) -> Option<Levels> {
    let first = weld(scene);
    if first.triangles.is_empty() {
        return None;
    }
    let diagonal = crate::math::Aabb::of(first.positions.iter().map(|p| Vec3::from(*p))).diagonal();
    let mut out = vec![first];
    for k in 0..LEVELS {
        if out.len() >= most as usize {
            break;
        }
        let error = diagonal * FIRST * f64::from(1_u32 << k);
        let last = &out[out.len() - 1];
        let surface = Surface { positions: &last.positions, attributes: &[], weights: &[], triangles: &last.triangles };
        // What the level before lost already, this one cannot lose again.
        let goal = Goal { triangles: 0, error: (error - last.error) as f32, lock_border: false };
        let left = simplify(&surface, &goal);
        if left.is_empty() || left.len() as f64 > last.triangles.len() as f64 * WORTH {
            continue;
        }
        let (used, triangles) = compact(last.positions.len(), &left);
        out.push(Level {
            error,
            positions: used.iter().map(|v| last.positions[*v as usize]).collect(),
            colors: used.iter().map(|v| last.colors[*v as usize]).collect(),
            triangles: triangles.into_iter().collect(),
        });
    }
    let double_sided = scene.objects.iter().flat_map(|o| &o.parts).any(|p| p.material.double_sided);
    Some(Levels { levels: out, double_sided })
}

impl Levels {
    /// Those of an object without triangles.
    pub fn empty() -> Self {
        let level =
            Level { error: 0.0, positions: Array::default(), colors: Array::default(), triangles: Array::default() };
        Self { levels: vec![level], double_sided: false }
    }

    /// The coarsest level that differs by at most `error` metres.
    pub fn within(&self, error: f64) -> &Level {
        self.levels.iter().rev().find(|l| l.error <= error).unwrap_or(&self.levels[0])
    }
}

/// All parts as one mesh, vertices of one position joined, triangles without area left out.
fn weld(scene: &Scene) -> Level {
    let mut number: BTreeMap<[u32; 3], u32> = BTreeMap::new();
    let (mut positions, mut colors, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for object in &scene.objects {
        let transform = object.transform.as_dmat4();
        let mirrored = transform.determinant() < 0.0;
        for part in &object.parts {
            let joined: Vec<u32> = (0..part.mesh.positions.len())
                .map(|v| {
                    let p = transform.transform_point3(Vec3::from(part.mesh.positions[v]).as_dvec3()).as_vec3();
                    // −0 and 0 are one place.
                    *number.entry(p.to_array().map(|c| (c + 0.0).to_bits())).or_insert_with(|| {
                        positions.push(p.to_array());
                        colors.push(color(part, v));
                        positions.len() as u32 - 1
                    })
                })
                .collect();
            for t in part.mesh.triangles.iter() {
                let [a, b, c] = t.map(|v| joined[v as usize]);
                if a != b && b != c && c != a {
                    triangles.push(if mirrored { [a, c, b] } else { [a, b, c] });
                }
            }
        }
    }
    let (used, triangles) = compact(positions.len(), &triangles);
    Level {
        error: 0.0,
        positions: used.iter().map(|v| positions[*v as usize]).collect(),
        colors: used.iter().map(|v| colors[*v as usize]).collect(),
        triangles: triangles.into_iter().collect(),
    }
}

/// Base colour at a vertex.
fn color(part: &Part, vertex: usize) -> [u8; 4] {
    let mut c = part.material.base_color;
    if let Some(own) = part.mesh.colors.get(vertex) {
        c.iter_mut().zip(own).for_each(|(c, o)| *c *= o);
    }
    if let Some(texel) = part.material.base_color_texture.as_ref().and_then(|t| texel_at(t, &part.mesh, vertex as u32))
    {
        c.iter_mut().zip(texel).for_each(|(c, t)| *c *= srgb::to_linear(t));
    }
    let [r, g, b, _] = c.map(srgb::from_linear);
    [r, g, b, 255]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;
    use glam::DVec3;

    fn sphere() -> Scene {
        let mut scene = builtin::make("solids", 1).unwrap();
        scene.objects.retain(|o| o.name.contains("sphere"));
        scene
    }

    #[test]
    fn levels_get_coarser_within_their_error() {
        let scene = sphere();
        let levels = levels(&scene, 11).unwrap();
        assert!(levels.levels.len() >= 3);
        let bounds = scene.bounds();
        let (centre, radius) = (bounds.centre(), bounds.size().y * 0.5);
        for pair in levels.levels.windows(2) {
            assert!(pair[1].triangles.len() < pair[0].triangles.len() && pair[1].error > pair[0].error);
        }
        let own = levels.levels[0].triangles.iter().flat_map(|t| {
            let p: Vec<DVec3> =
                t.iter().map(|v| Vec3::from(levels.levels[0].positions[*v as usize]).as_dvec3()).collect();
            [(p[0] + p[1]) * 0.5, (p[0] + p[1] + p[2]) / 3.0]
        });
        let own = own.map(|p| (p.distance(centre) - radius).abs()).fold(0.0, f64::max);
        for level in &levels.levels {
            let positions: Vec<DVec3> = level.positions.iter().map(|p| Vec3::from(*p).as_dvec3()).collect();
            for t in level.triangles.iter() {
                let [a, b, c] = t.map(|v| positions[v as usize]);
                let off = ((a + b + c) / 3.0).distance(centre) - radius;
                // Quadrics are means over a vertex's planes: twice that is what the farthest is.
                assert!(off.abs() <= own + 3.0 * level.error + 1e-6, "{} {off} {}", level.triangles.len(), level.error);
            }
        }
        assert_eq!(levels.within(0.0), &levels.levels[0]);
        assert_eq!(levels.within(f64::INFINITY), levels.levels.last().unwrap());
    }

    #[test]
    fn vertices_are_joined_and_coloured() {
        let mut scene = builtin::make("car", 1).unwrap();
        let before = scene.triangle_count();
        let levels = levels(&scene, 11).unwrap();
        assert!(levels.levels[0].triangles.len() <= before && levels.levels[0].triangles.len() > before / 2);
        let mut seen = std::collections::BTreeSet::new();
        assert!(levels.levels[0].positions.iter().all(|p| seen.insert(p.map(f32::to_bits))));
        assert!(levels.levels[0].colors.iter().collect::<std::collections::BTreeSet<_>>().len() > 2);
        scene.objects.clear();
        assert_eq!(super::levels(&scene, 11), None);
    }
}
