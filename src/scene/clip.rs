//! Cutting a scene to a box, or a box out of a scene (Sutherland and Hodgman 1974), with all that its vertices carry.
//!
//! A cut point depends only on the two ends of its edge and the planes, never on the triangle: triangles that share an edge stay joined, and a mesh without
//! cracks has none after it was cut. Triangles that lie inside keep their vertices.

use super::{Mesh, Object, Part, Scene};
use crate::math::Aabb;
use bytemuck::Pod;
use glam::{DAffine3, DVec3, DVec4, Vec3};
use std::{collections::BTreeMap, sync::Arc};

/// What is kept: n·p + d ≥ 0 for (n, d).
type Plane = DVec4;

/// The parts of the objects that lie in `bounds` (world space, metres). Objects without any are left out; parts that lie inside as a whole are shared.
pub fn clip_scene(scene: &Scene, bounds: &Aabb) -> Scene {
    let whole = |object: &Object| Piece {
        parts: object.parts.iter().map(|p| (0..p.mesh.triangles.len() as u32).collect()).collect(),
    };
    let objects = scene.objects.iter().filter_map(|o| clip_object(o, &whole(o), bounds)).collect();
    Scene { objects }
}

/// The parts of the objects that lie outside `bounds` (world space, metres): what [`clip_scene`] leaves away. What lies on the box's sides goes with its
/// inside. The cut stays open. Triangles that the box does not meet keep their vertices, so a cut may end in the middle of their edges.
pub fn cut_box(scene: &Scene, bounds: &Aabb) -> Scene {
    let object = |object: &Object| {
        if !object.bounds().overlaps(bounds) {
            return Some(object.clone());
        }
        let planes = planes(object, bounds);
        let part = |part: &Part| {
            let mesh = cut_mesh(&part.mesh, &planes)?;
            let mesh = mesh.map_or_else(|| part.mesh.clone(), Arc::new);
            Some(Part { mesh, material: part.material.clone() })
        };
        let parts: Vec<Part> = object.parts.iter().filter_map(part).collect();
        (!parts.is_empty()).then(|| Object { name: object.name.clone(), transform: object.transform, parts })
    };
    Scene { objects: scene.objects.iter().filter_map(object).collect() }
}

/// Triangles of an object, by part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Piece {
    pub parts: Vec<Vec<u32>>,
}

/// The part of the triangles of `piece` that lies in `bounds`; `None` where there is none.
pub fn clip_object(object: &Object, piece: &Piece, bounds: &Aabb) -> Option<Object> {
    let planes = planes(object, bounds);
    let part = |(part, triangles): (&Part, &Vec<u32>)| {
        let mesh = clip_mesh(&part.mesh, triangles, &planes)?;
        let mesh = mesh.map_or_else(|| part.mesh.clone(), Arc::new);
        Some(Part { mesh, material: part.material.clone() })
    };
    let parts: Vec<Part> = object.parts.iter().zip(&piece.parts).filter_map(part).collect();
    (!parts.is_empty()).then(|| Object { name: object.name.clone(), transform: object.transform, parts })
}

/// The six sides of a box of the world in object space, as distances in the world.
fn planes(object: &Object, bounds: &Aabb) -> [Plane; 6] {
    let to_world = DAffine3::from_mat4(object.transform.as_dmat4());
    let plane = |n: DVec3, d: f64| (to_world.matrix3.transpose() * n).extend(n.dot(to_world.translation) + d);
    let (lo, hi) = (bounds.min, bounds.max);
    [
        plane(DVec3::X, -lo.x),
        plane(DVec3::NEG_X, hi.x),
        plane(DVec3::Y, -lo.y),
        plane(DVec3::NEG_Y, hi.y),
        plane(DVec3::Z, -lo.z),
        plane(DVec3::NEG_Z, hi.z),
    ]
}

/// A corner of a cut triangle.
#[derive(Clone, Copy, Debug)]
struct Corner {
    position: DVec3,
    /// Of the triangle's corners.
    weights: DVec3,
    /// Which corner of the triangle it is.
    own: Option<usize>,
}

impl Corner {
    fn cut(inner: &Self, di: f64, outer: &Self, d_o: f64) -> Self {
        let t = di / (di - d_o);
        let between = |a: DVec3, b: DVec3| a + (b - a) * t;
        Self {
            position: between(inner.position, outer.position),
            weights: between(inner.weights, outer.weights),
            own: None,
        }
    }
}

/// Above 0 on the inner side.
fn distance(plane: &Plane, corner: &Corner) -> f64 {
    plane.truncate().dot(corner.position) + plane.w
}

/// What lies on the inner side of a plane.
fn clip(polygon: &[Corner], plane: &Plane) -> Vec<Corner> {
    let distance = |c: &Corner| distance(plane, c);
    let mut out = Vec::with_capacity(polygon.len() + 1);
    for (i, b) in polygon.iter().enumerate() {
        let a = &polygon[(i + polygon.len() - 1) % polygon.len()];
        let (da, db) = (distance(a), distance(b));
        // Points on the plane are inside; a cut there would give them again.
        if (da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0) {
            out.push(if da > 0.0 { Corner::cut(a, da, b, db) } else { Corner::cut(b, db, a, da) });
        }
        if db >= 0.0 {
            out.push(*b);
        }
    }
    if out.len() < 3 {
        out.clear();
    }
    out
}

/// The parts of a mesh's `triangles` inside all planes: `Some(None)` where that is the whole mesh, `None` where it is nothing.
fn clip_mesh(mesh: &Mesh, triangles: &[u32], planes: &[Plane]) -> Option<Option<Mesh>> {
    let mut builder = Builder::new(mesh);
    let mut whole = triangles.len() == mesh.triangles.len();
    for indices in triangles.iter().map(|t| mesh.triangles[*t as usize]) {
        let mut polygon = polygon(mesh, indices);
        for plane in planes {
            polygon = clip(&polygon, plane);
        }
        let kept = polygon.len() == 3 && polygon.iter().all(|c| c.own.is_some());
        whole &= kept;
        builder.add(indices, &polygon);
    }
    builder.outcome(whole)
}

/// The parts of a mesh that lie outside some of the planes; the result is as that of [`clip_mesh`].
fn cut_mesh(mesh: &Mesh, planes: &[Plane]) -> Option<Option<Mesh>> {
    let mut builder = Builder::new(mesh);
    let mut whole = true;
    for indices in mesh.triangles.iter().copied() {
        let all = polygon(mesh, indices);
        // Outside the first plane, inside that and outside the second, and so on: the pieces do not overlap.
        let (mut rest, mut pieces) = (all.clone(), Vec::new());
        for plane in planes {
            if rest.iter().any(|c| distance(plane, c) < 0.0) {
                pieces.push(clip(&rest, &-*plane));
                rest = clip(&rest, plane);
            }
        }
        // A triangle beside the box stays as it is, although planes of its sides may cut it.
        let missed = rest.is_empty();
        whole &= missed;
        if missed {
            builder.add(indices, &all);
        } else {
            pieces.iter().for_each(|piece| builder.add(indices, piece));
        }
    }
    builder.outcome(whole)
}

fn polygon(mesh: &Mesh, indices: [u32; 3]) -> Vec<Corner> {
    let corner = |k: usize| Corner {
        position: Vec3::from(mesh.positions[indices[k] as usize]).as_dvec3(),
        weights: DVec3::AXES[k],
        own: Some(k),
    };
    [0, 1, 2].map(corner).to_vec()
}

/// Collects vertices: equal ones once.
struct Builder<'a> {
    mesh: &'a Mesh,
    out: Vertices,
    /// Numbers of the mesh's vertices that are used.
    kept: BTreeMap<u32, u32>,
    /// Numbers of cut vertices, by their bits.
    cut: BTreeMap<Vec<u32>, u32>,
    triangles: Vec<[u32; 3]>,
}

#[derive(Default)]
struct Vertices {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    tangents: Vec<[f32; 4]>,
    uv: [Vec<[f32; 2]>; 2],
    colors: Vec<[f32; 4]>,
}

impl<'a> Builder<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        Self { mesh, out: Vertices::default(), kept: BTreeMap::new(), cut: BTreeMap::new(), triangles: Vec::new() }
    }

    fn add(&mut self, indices: [u32; 3], polygon: &[Corner]) {
        let corners: Vec<u32> = polygon.iter().map(|c| self.vertex(indices, c)).collect();
        let Some((first, rest)) = corners.split_first() else { return };
        let uncut = polygon.iter().all(|c| c.own.is_some());
        for pair in rest.windows(2) {
            let triangle = [*first, pair[0], pair[1]];
            // Pieces that rounding has left without area.
            let distinct = triangle.map(|i| self.out.positions[i as usize].map(f32::to_bits));
            if uncut || (distinct[0] != distinct[1] && distinct[1] != distinct[2] && distinct[2] != distinct[0]) {
                self.triangles.push(triangle);
            }
        }
    }

    fn vertex(&mut self, indices: [u32; 3], corner: &Corner) -> u32 {
        let next = self.out.positions.len() as u32;
        let m = self.mesh;
        if let Some(k) = corner.own {
            let i = indices[k];
            let number = *self.kept.entry(i).or_insert(next);
            if number == next {
                let i = i as usize;
                self.out.positions.push(m.positions[i]);
                self.out.normals.extend(m.normals.get(i));
                self.out.tangents.extend(m.tangents.get(i));
                (0..2).for_each(|s| self.out.uv[s].extend(m.uv[s].get(i)));
                self.out.colors.extend(m.colors.get(i));
            }
            return number;
        }
        let mix = Mix::new(indices, corner.weights);
        let position = corner.position.as_vec3().to_array();
        let normal = mix.unit(&m.normals);
        let tangent = mix.tangent(&m.tangents);
        let uv = [0, 1].map(|s| mix.of(&m.uv[s]));
        let color = mix.of(&m.colors);
        let mut key = bits(&[position]);
        key.extend(bits(normal.as_slice()).into_iter().chain(bits(tangent.as_slice())));
        uv.iter().for_each(|uv| key.extend(bits(uv.as_slice())));
        key.extend(bits(color.as_slice()));
        let number = *self.cut.entry(key).or_insert(next);
        if number == next {
            self.out.positions.push(position);
            self.out.normals.extend(normal);
            self.out.tangents.extend(tangent);
            self.out.uv.iter_mut().zip(uv).for_each(|(all, uv)| all.extend(uv));
            self.out.colors.extend(color);
        }
        number
    }

    /// `Some(None)` where the result is the whole mesh, `None` where it is nothing.
    fn outcome(self, whole: bool) -> Option<Option<Mesh>> {
        match (self.triangles.is_empty(), whole) {
            (true, _) => None,
            (false, true) => Some(None),
            (false, false) => Some(Some(self.finish())),
        }
    }

    fn finish(self) -> Mesh {
        let Vertices { positions, normals, tangents, uv, colors } = self.out;
        Mesh {
            positions: positions.into(),
            normals: normals.into(),
            tangents: tangents.into(),
            uv: uv.map(Into::into),
            colors: colors.into(),
            triangles: self.triangles.into(),
        }
    }
}

fn bits<T: Pod>(values: &[T]) -> Vec<u32> {
    bytemuck::cast_slice(values).to_vec()
}

/// A weighted mean of a triangle's vertices.
struct Mix {
    indices: [u32; 3],
    weights: [f64; 3],
    /// The corner of the greatest weight; of equals the one with the lower vertex number, so that triangles on both sides of an edge agree.
    nearest: usize,
}

impl Mix {
    fn new(indices: [u32; 3], weights: DVec3) -> Self {
        let weights = weights.to_array();
        let nearer = |a: usize, b: usize| {
            let heavier = weights[b] > weights[a] || (weights[b] == weights[a] && indices[b] < indices[a]);
            if heavier { b } else { a }
        };
        Self { indices, weights, nearest: nearer(nearer(0, 1), 2) }
    }

    fn sum<const N: usize>(&self, values: &[[f32; N]]) -> Option<[f64; N]> {
        if values.is_empty() {
            return None;
        }
        let corners = self.indices.map(|i| values[i as usize]);
        Some(std::array::from_fn(|k| (0..3).map(|c| f64::from(corners[c][k]) * self.weights[c]).sum()))
    }

    fn of<const N: usize>(&self, values: &[[f32; N]]) -> Option<[f32; N]> {
        self.sum(values).map(|v| v.map(|v| v as f32))
    }

    /// Of unit length; opposite vectors give that of the nearest corner.
    fn unit(&self, values: &[[f32; 3]]) -> Option<[f32; 3]> {
        let sum = DVec3::from(self.sum(values)?);
        let nearest = values[self.indices[self.nearest] as usize];
        Some(sum.try_normalize().map_or(nearest, |v| v.as_vec3().to_array()))
    }

    fn tangent(&self, values: &[[f32; 4]]) -> Option<[f32; 4]> {
        let [x, y, z, _] = self.sum(values)?;
        let nearest = values[self.indices[self.nearest] as usize];
        let Some(unit) = DVec3::new(x, y, z).try_normalize() else { return Some(nearest) };
        Some(unit.as_vec3().extend(nearest[3]).to_array())
    }
}
