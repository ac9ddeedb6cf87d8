//! meshoptimizer's simplifier on any scene.

use crate::{
    array::Array,
    engine::node::{Ctx, Node, NodeError},
    math::{Stop, Stopped},
    mesh::simplify::{Goal, Surface, compact, simplify},
    ports,
    scene::{Mesh, Object, Part, Scene},
    view::Cell,
};
use bytemuck::Pod;
use glam::DVec3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{collections::BTreeMap, sync::Arc};

/// Simplifies every mesh of a scene by meshoptimizer's quadrics. Vertices stay where they are and keep their attributes; materials, names
/// and places stay. Objects that share a mesh share the simplified one. It knows nothing of views.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Share of its triangles that each mesh keeps, 0 to 1. Topology and seams may keep more.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub ratio: f64,
    /// Triangles of the whole scene, 1 or more, shared among its meshes by their numbers of triangles; in place of `ratio`.
    #[schemars(range(min = 1))]
    pub triangles: Option<u32>,
    /// How far the surface may move, metres, above 0; it then keeps more triangles than asked for where it must. No bound where there is none.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "m"))]
    pub error: Option<f64>,
    /// How far the surface of each object may move in pictures from the cell, pixels, above 0; then at least 4 triangles of a mesh are kept. Needs `cell`.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-unit" = "px"))]
    pub pixels: Option<f64>,
    /// Width of these pictures, pixels.
    #[schemars(range(min = 1), extend("x-unit" = "px"))]
    pub resolution: u32,
    /// Field of view of these pictures, degrees, more than 0 and less than 180.
    #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 180.0, "x-unit" = "degrees"))]
    pub fov: f64,
    /// What attributes count beside the shape, 0 or more: at 1 a difference of 1 in a normal's, a colour's or a texture coordinate's component
    /// counts as a displacement by the mesh's extent.
    #[schemars(range(min = 0.0))]
    pub attributes: f64,
    /// Whether vertices of open edges stay where they are.
    pub lock_border: bool,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            ratio: 0.5,
            triangles: None,
            error: None,
            pixels: None,
            resolution: 1024,
            fov: 45.0,
            attributes: 0.1,
            lock_border: false,
        }
    }
}

ports! {
    pub struct In {
        /// What to simplify.
        scene: Arc<Scene>,
        /// From where `pixels` are seen.
        cell: Option<Arc<Cell>>,
    }
}

ports! {
    pub struct Out {
        /// The same scene in fewer triangles. Parts and objects of which no triangle is left are gone.
        scene: Arc<Scene>,
    }
}

pub struct Quadric;

impl Node for Quadric {
    const KIND: &'static str = "collapse";
    const METHOD: &'static str = "quadric";
    const VERSION: u32 = 1;
    /// meshoptimizer is C++.
    const NATIVE: bool = true;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(_: &Params, sizes: &[u64]) -> u64 {
        // Adjacency, quadrics and attributes' gradients beside positions and triangles.
        (16 << 20) + sizes.first().copied().unwrap_or(0).saturating_mul(10)
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let scene = &*inputs.scene;
        let before = scene.triangle_count();
        let cell = match (params.pixels, inputs.cell.as_deref()) {
            (Some(_), None) => {
                return Err(NodeError::Failed("`pixels` needs the port `cell`: from where are they seen?".into()));
            }
            (None, Some(_)) => return Err(NodeError::Failed("`cell` is connected, and no `pixels` are given".into())),
            (_, cell) => cell,
        };
        let ratio = params.triangles.map_or(params.ratio, |n| (f64::from(n) / before.max(1) as f64).min(1.0));
        let simple = collapse(scene, ratio, params, cell, ctx.stop)?;
        let (left, asked) = (simple.triangle_count(), (ratio * before as f64).round() as usize);
        if params.error.is_none() && params.pixels.is_none() && left as f64 > 1.1 * asked as f64 {
            (ctx.warn)(format!(
                "{left} of {before} triangles are left, {asked} were asked for: seams and topology allow no fewer"
            ));
        }
        Ok(Out { scene: Arc::new(simple) })
    }
}

/// Simplifies each mesh once, however many parts show it, within the least error that one of its copies allows.
fn collapse(scene: &Scene, ratio: f64, params: &Params, cell: Option<&Cell>, stop: &Stop) -> Result<Scene, Stopped> {
    let mut number: BTreeMap<usize, usize> = BTreeMap::new();
    let mut meshes: Vec<(&Mesh, f64)> = Vec::new();
    let mut shown: Vec<usize> = Vec::new();
    for object in &scene.objects {
        let error = allowed(object, params, cell) / scale(object);
        for part in &object.parts {
            let at = *number.entry(Arc::as_ptr(&part.mesh).addr()).or_insert(meshes.len());
            match meshes.get_mut(at) {
                Some((_, least)) => *least = least.min(error),
                None => meshes.push((&part.mesh, error)),
            }
            shown.push(at);
        }
    }
    let least = if params.pixels.is_some() { 4 } else { 0 };
    let one = |(mesh, error): &(&Mesh, f64)| {
        stop.check()?;
        let triangles = ((mesh.triangles.len() as f64 * ratio).ceil() as usize).max(least);
        let goal = Goal { triangles, error: *error as f32, lock_border: params.lock_border };
        Ok(Arc::new(fewer(mesh, &goal, params.attributes as f32)))
    };
    let simple: Vec<Arc<Mesh>> = meshes.par_iter().map(one).collect::<Result<_, Stopped>>()?;
    let mut shown = shown.into_iter();
    let mut objects = Vec::with_capacity(scene.objects.len());
    for object in &scene.objects {
        let parts = object.parts.iter().zip(shown.by_ref());
        let parts = parts.map(|(part, at)| Part { mesh: simple[at].clone(), material: part.material.clone() });
        let parts: Vec<Part> = parts.filter(|part| !part.mesh.triangles.is_empty()).collect();
        if !parts.is_empty() {
            objects.push(Object { parts, ..object.clone() });
        }
    }
    Ok(Scene { objects })
}

/// How far the object's surface may move, metres.
fn allowed(object: &Object, params: &Params, cell: Option<&Cell>) -> f64 {
    let seen = cell.zip(params.pixels).map_or(f64::INFINITY, |(cell, pixels)| {
        let (low, high) = (cell.centre - cell.half, cell.centre + cell.half);
        let bounds = object.bounds();
        // Between two boxes, axis by axis.
        let gap = (bounds.min - high).max(low - bounds.max).max(DVec3::ZERO);
        pixels * 2.0 * libm::tan(params.fov.to_radians() * 0.5) / f64::from(params.resolution) * gap.length()
    });
    params.error.unwrap_or(f64::INFINITY).min(seen)
}

/// The largest factor by which the object's place stretches a length along its axes.
fn scale(object: &Object) -> f64 {
    let m = object.transform.as_dmat4();
    let longest = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.truncate().length()).into_iter().fold(0.0, f64::max);
    if longest > 0.0 { longest } else { 1.0 }
}

fn fewer(mesh: &Mesh, goal: &Goal, weight: f32) -> Mesh {
    let (attributes, weights) = attributes(mesh, weight);
    let surface =
        Surface { positions: &mesh.positions, attributes: &attributes, weights: &weights, triangles: &mesh.triangles };
    let (used, triangles) = compact(mesh.positions.len(), &simplify(&surface, goal));
    Mesh {
        positions: gather(&mesh.positions, &used),
        normals: gather(&mesh.normals, &used),
        tangents: gather(&mesh.tangents, &used),
        uv: [gather(&mesh.uv[0], &used), gather(&mesh.uv[1], &used)],
        colors: gather(&mesh.colors, &used),
        triangles: triangles.into(),
    }
}

/// Normals, first texture coordinates and colours, those that are there, vertex by vertex; and a weight for each number.
fn attributes(mesh: &Mesh, weight: f32) -> (Vec<f32>, Vec<f32>) {
    let sets: [&[f32]; 3] = [mesh.normals.as_flattened(), mesh.uv[0].as_flattened(), mesh.colors.as_flattened()];
    let count = mesh.positions.len().max(1);
    let sets: Vec<(&[f32], usize)> =
        sets.into_iter().map(|set| (set, set.len() / count)).filter(|(_, n)| *n > 0).collect();
    let width = sets.iter().map(|(_, n)| n).sum();
    let vertex = |v: usize| sets.iter().flat_map(move |(set, n)| &set[v * n..(v + 1) * n]).copied();
    let all = if width == 0 { Vec::new() } else { (0..mesh.positions.len()).flat_map(vertex).collect() };
    (all, vec![weight; width])
}

/// The entries of `used` vertices of an attribute that may be absent.
fn gather<T: Pod>(values: &Array<T>, used: &[u32]) -> Array<T> {
    if values.is_empty() {
        Array::default()
    } else {
        used.iter().map(|v| values[*v as usize]).collect::<Vec<T>>().into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::testing::refused;
    use crate::scene::builtin;

    fn run(scene: &Scene, params: &Params) -> Scene {
        let ratio = params.triangles.map_or(params.ratio, |n| f64::from(n) / scene.triangle_count() as f64);
        collapse(scene, ratio, params, None, &Stop::default()).unwrap()
    }

    #[test]
    fn a_scene_keeps_its_look_in_fewer_triangles() {
        let scene = builtin::make("car", 1).unwrap();
        let before = scene.triangle_count();
        let half = run(&scene, &Params::default());
        assert!(half.triangle_count() < before * 3 / 4, "{} of {before}", half.triangle_count());
        let names = |s: &Scene| s.objects.iter().map(|o| o.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&half), names(&scene));
        for (object, old) in half.objects.iter().zip(&scene.objects) {
            assert_eq!(object.transform, old.transform);
            for (part, old) in object.parts.iter().zip(&old.parts) {
                let (mesh, old) = (&part.mesh, &old.mesh);
                assert_eq!(mesh.normals.is_empty(), old.normals.is_empty());
                assert!(mesh.normals.is_empty() || mesh.normals.len() == mesh.positions.len());
                // Vertices are the old ones, with what belonged to them.
                for (v, p) in mesh.positions.iter().enumerate() {
                    let is = |w: &usize| {
                        old.positions[*w] == *p && (old.normals.is_empty() || old.normals[*w] == mesh.normals[v])
                    };
                    assert!((0..old.positions.len()).any(|w| is(&w)));
                }
            }
        }
        assert_eq!(run(&scene, &Params { ratio: 1.0, ..Params::default() }).triangle_count(), before);
        let none = Params { error: Some(1e-9), ratio: 0.0, ..Params::default() };
        assert!(run(&scene, &none).triangle_count() > before / 2, "nothing may move");
        let few = run(&scene, &Params { triangles: Some(before as u32 / 3), ..Params::default() });
        assert!(few.triangle_count() < half.triangle_count());
    }

    #[test]
    fn shared_meshes_stay_shared_and_the_largest_copy_decides_the_error() {
        let scene = builtin::make("solids", 1).unwrap();
        let mut object = scene.objects.iter().max_by_key(|o| o.triangle_count()).unwrap().clone();
        let mut other = object.clone();
        other.name += "-2";
        let within = |objects: &[&Object], error: f64| {
            let scene = Scene { objects: objects.iter().map(|o| (*o).clone()).collect() };
            run(&scene, &Params { ratio: 0.0, error: Some(error), attributes: 0.0, ..Params::default() })
        };
        let both = within(&[&object, &other], 0.05);
        assert!(Arc::ptr_eq(&both.objects[0].parts[0].mesh, &both.objects[1].parts[0].mesh));
        other.transform = glam::Mat4::from_scale(glam::Vec3::splat(10.0)) * other.transform;
        let large = within(&[&object, &other], 0.05);
        object.transform = other.transform;
        assert_eq!(large.objects[0].parts[0].mesh, within(&[&object], 0.05).objects[0].parts[0].mesh);
        assert!(large.triangle_count() > both.triangle_count());
    }

    #[test]
    fn pixels_are_those_of_the_nearest_point_of_the_cell() {
        let scene = builtin::make("car", 1).unwrap();
        let size = scene.bounds().diagonal();
        let params = Params { ratio: 0.0, pixels: Some(1.0), attributes: 0.0, ..Params::default() };
        let count = |distance: f64| {
            let half = DVec3::splat(0.5);
            let centre = DVec3::new(scene.bounds().max.x + distance * size + 0.5, 0.5, 0.0);
            collapse(&scene, 0.0, &params, Some(&Cell { centre, half }), &Stop::default()).unwrap().triangle_count()
        };
        let counts = [0.0, 1.0, 30.0, 1e4].map(count);
        assert!(counts.windows(2).all(|w| w[0] >= w[1]) && counts[0] > counts[2], "{counts:?}");
        assert!(counts[3] > 0, "something is left of everything");
        let distance = 5.0;
        let cell =
            Cell { centre: DVec3::new(scene.objects[0].bounds().max.x + distance, 0.0, 0.0), half: DVec3::splat(0.1) };
        let per_pixel = 2.0 * libm::tan(params.fov.to_radians() * 0.5) / f64::from(params.resolution);
        let nearest =
            cell.centre.clamp(scene.objects[0].bounds().min, scene.objects[0].bounds().max).distance(cell.centre);
        let allowed = allowed(&scene.objects[0], &params, Some(&cell));
        assert!((allowed - per_pixel * (nearest - 0.1)).abs() < 0.05 * allowed, "{allowed}");
        // Neither goes without the other.
        let said = |pixels, cell: Option<Cell>| {
            let params = Params { pixels, ..Params::default() };
            let inputs = In { scene: Arc::new(scene.clone()), cell: cell.map(Arc::new) };
            crate::nodes::testing::run::<Quadric>(&params, inputs).0.map(|_| ()).unwrap_err().to_string()
        };
        assert!(said(Some(1.0), None).contains("port `cell`") && said(None, Some(cell)).contains("no `pixels`"));
    }

    #[test]
    fn parameters_are_checked() {
        let bad: [(&str, Params); 4] = [
            ("ratio", Params { ratio: 1.5, ..Params::default() }),
            ("triangles", Params { triangles: Some(0), ..Params::default() }),
            ("error", Params { error: Some(-1.0), ..Params::default() }),
            ("attributes", Params { attributes: -0.1, ..Params::default() }),
        ];
        for (name, params) in bad {
            assert_eq!(refused::<Quadric>(&params).as_deref(), Some(name));
        }
        assert_eq!(refused::<Quadric>(&Params::default()), None);
    }
}
