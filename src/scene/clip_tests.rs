//! Clipping and splitting.

use super::{
    Material, Mesh, Object, Part, Scene,
    clip::{clip_scene, cut_box},
    split::{Division, SplitError, Splitting, split},
};
use crate::math::{Aabb, Stop};
use glam::{DVec3, Mat4, Quat, Vec3};
use proptest::prelude::*;
use std::{collections::BTreeMap, sync::Arc};

fn scene_of(mesh: Mesh, transform: Mat4) -> Scene {
    let part = Part { mesh: Arc::new(mesh), material: Arc::new(Material::default()) };
    Scene { objects: vec![Object { name: "a".into(), transform, parts: vec![part] }] }
}

fn triangles(scene: &Scene) -> Vec<[DVec3; 3]> {
    let mut out = Vec::new();
    for object in &scene.objects {
        let transform = object.transform.as_dmat4();
        for part in &object.parts {
            let place = |i: u32| transform.transform_point3(Vec3::from(part.mesh.positions[i as usize]).as_dvec3());
            out.extend(part.mesh.triangles.iter().map(|t| t.map(place)));
        }
    }
    out
}

fn area(scene: &Scene) -> f64 {
    triangles(scene).iter().map(|[a, b, c]| (*b - *a).cross(*c - *a).length() * 0.5).sum()
}

/// Whether the scene keeps what the module promises of meshes.
fn sound(scene: &Scene) {
    for mesh in scene.objects.iter().flat_map(|o| &o.parts).map(|p| &p.mesh) {
        let n = mesh.positions.len();
        assert!(!mesh.triangles.is_empty() && mesh.triangles.iter().flatten().all(|i| (*i as usize) < n));
        for length in [mesh.normals.len(), mesh.tangents.len(), mesh.uv[0].len(), mesh.uv[1].len(), mesh.colors.len()] {
            assert!(length == 0 || length == n);
        }
        for v in mesh.normals.iter().map(|v| Vec3::from(*v)) {
            assert!((v.length() - 1.0).abs() < 1e-5);
        }
    }
}

/// A mesh with all attributes: linear functions of the place where that is possible.
fn dressed(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    let n = positions.len();
    Mesh {
        normals: vec![[0.0, 0.6, 0.8]; n].into(),
        tangents: vec![[1.0, 0.0, 0.0, -1.0]; n].into(),
        uv: [
            positions.iter().map(|p| [p[0] * 2.0, p[1] + p[2]]).collect(),
            positions.iter().map(|p| [p[2], 1.0 - p[0]]).collect(),
        ],
        colors: positions.iter().map(|p| [p[0] * 0.1 + 0.5, p[1] * 0.1 + 0.5, 0.5, 1.0]).collect(),
        positions: positions.into(),
        triangles: triangles.into(),
    }
}

fn soup() -> impl Strategy<Value = Mesh> {
    let point = prop::array::uniform3(-2.0_f32..2.0);
    (prop::collection::vec(point, 3..12), prop::collection::vec(prop::array::uniform3(0_u32..1000), 1..12)).prop_map(
        |(points, faces)| {
            let n = points.len() as u32;
            dressed(points, faces.into_iter().map(|t| t.map(|i| i % n)).collect())
        },
    )
}

fn turn() -> impl Strategy<Value = Mat4> {
    (prop::array::uniform3(-1.0_f32..1.0), -3.0_f32..3.0, 0.3_f32..2.0).prop_map(|(axis, angle, scale)| {
        let axis = Vec3::from(axis).try_normalize().unwrap_or(Vec3::X);
        Mat4::from_scale_rotation_translation(
            Vec3::new(scale, 1.0, -scale),
            Quat::from_axis_angle(axis, angle),
            Vec3::new(0.3, -0.2, 0.1),
        )
    })
}

/// The eight boxes around a point that fill a large one.
fn eight(middle: DVec3) -> Vec<Aabb> {
    let far = Aabb { min: DVec3::splat(-50.0), max: DVec3::splat(50.0) };
    far.corners().iter().map(|c| Aabb { min: c.min(middle), max: c.max(middle) }).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn parts_in_disjoint_boxes_have_the_area_of_the_whole(mesh in soup(), turn in turn(), at in prop::array::uniform3(-1.0_f64..1.0)) {
        let scene = scene_of(mesh, turn);
        let parts: Vec<Scene> = eight(at.into()).iter().map(|b| clip_scene(&scene, b)).collect();
        parts.iter().for_each(sound);
        let (sum, whole) = (parts.iter().map(area).sum::<f64>(), area(&scene));
        prop_assert!((sum - whole).abs() < 1e-4 * (1.0 + whole), "{sum} {whole}");
    }

    #[test]
    fn what_is_left_lies_in_the_box_and_carries_its_attributes(mesh in soup(), turn in turn(), lo in prop::array::uniform3(-2.0_f64..1.0), size in 0.1_f64..2.0) {
        let bounds = Aabb { min: lo.into(), max: DVec3::from(lo) + size };
        let scene = scene_of(mesh, turn);
        let part = clip_scene(&scene, &bounds);
        sound(&part);
        for p in triangles(&part).into_iter().flatten() {
            prop_assert!((p - p.clamp(bounds.min, bounds.max)).length() < 1e-5, "{p}");
        }
        for mesh in part.objects.iter().flat_map(|o| &o.parts).map(|p| &p.mesh) {
            let positions: &[[f32; 3]] = &mesh.positions;
            let expect = dressed(positions.to_vec(), mesh.triangles.to_vec());
            for i in 0..positions.len() {
                let close = |a: &[f32], b: &[f32]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4);
                prop_assert!(close(&mesh.uv[0][i], &expect.uv[0][i]) && close(&mesh.uv[1][i], &expect.uv[1][i]));
                prop_assert!(close(&mesh.colors[i], &expect.colors[i]) && close(&mesh.normals[i], &expect.normals[i]));
                prop_assert!(close(&mesh.tangents[i], &expect.tangents[i]));
            }
        }
        // A box around everything changes nothing, not even what is shared.
        let all = clip_scene(&scene, &Aabb { min: DVec3::splat(-99.0), max: DVec3::splat(99.0) });
        prop_assert!(Arc::ptr_eq(&all.objects[0].parts[0].mesh, &scene.objects[0].parts[0].mesh));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn what_is_cut_out_and_what_is_left_are_the_whole(mesh in soup(), turn in turn(), lo in prop::array::uniform3(-2.0_f64..1.0), size in 0.1_f64..2.0) {
        let bounds = Aabb { min: lo.into(), max: DVec3::from(lo) + size };
        let scene = scene_of(mesh, turn);
        let (inner, outer) = (clip_scene(&scene, &bounds), cut_box(&scene, &bounds));
        sound(&outer);
        let (sum, whole) = (area(&inner) + area(&outer), area(&scene));
        prop_assert!((sum - whole).abs() < 1e-4 * (1.0 + whole), "{sum} {whole}");
        // No point of what is left lies deep inside.
        let deep = Aabb { min: bounds.min + 1e-4, max: bounds.max - 1e-4 };
        let left = area(&clip_scene(&outer, &deep));
        prop_assert!(left < 1e-6, "{left} left inside");
        for mesh in outer.objects.iter().flat_map(|o| &o.parts).map(|p| &p.mesh) {
            let expect = dressed(mesh.positions.to_vec(), mesh.triangles.to_vec());
            for (a, b) in mesh.uv[0].iter().zip(expect.uv[0].iter()) {
                prop_assert!((a[0] - b[0]).abs() < 1e-4 && (a[1] - b[1]).abs() < 1e-4);
            }
        }
        // A box beside everything changes nothing, not even what is shared.
        let same = cut_box(&scene, &Aabb { min: DVec3::splat(98.0), max: DVec3::splat(99.0) });
        prop_assert!(Arc::ptr_eq(&same.objects[0].parts[0].mesh, &scene.objects[0].parts[0].mesh));
    }
}

#[test]
fn triangles_on_the_side_of_a_cut_go_once() {
    let box_of = |half: f64| Aabb { min: DVec3::splat(-half), max: DVec3::splat(half) };
    let side = |z: f32| vec![[-0.5, -0.5, z], [0.5, -0.5, z], [0.0, 0.5, z]];
    let on = scene_of(dressed(side(1.0), vec![[0, 1, 2]]), Mat4::IDENTITY);
    assert!(cut_box(&on, &box_of(1.0)).objects.is_empty());
    let beyond = scene_of(dressed(side(1.01), vec![[0, 1, 2]]), Mat4::IDENTITY);
    assert_eq!(cut_box(&beyond, &box_of(1.0)), beyond);
}

#[test]
fn cut_meshes_have_no_cracks() {
    // A closed ball cut by a box: edges that belong to one triangle lie on the box's sides.
    let ball = crate::raster::tests::octahedron(4);
    let bounds = Aabb { min: DVec3::new(-0.31, -0.47, -2.0), max: DVec3::new(0.83, 0.59, 0.77) };
    let part = clip_scene(&scene_of(ball, Mat4::IDENTITY), &bounds);
    let mesh = &part.objects[0].parts[0].mesh;
    let mut edges: BTreeMap<[[u32; 3]; 2], i32> = BTreeMap::new();
    for [a, b, c] in mesh.triangles.iter() {
        for (s, e) in [(a, b), (b, c), (c, a)] {
            let [s, e] = [s, e].map(|i| mesh.positions[*i as usize].map(f32::to_bits));
            let forwards = s < e;
            *edges.entry(if forwards { [s, e] } else { [e, s] }).or_default() += if forwards { 1 } else { -1 };
        }
    }
    let open: Vec<_> = edges.iter().filter(|(_, n)| **n != 0).map(|(e, _)| *e).collect();
    assert!(open.len() > 20);
    for edge in open {
        let on = |k: usize, side: f64| edge.iter().all(|p| (f64::from(f32::from_bits(p[k])) - side).abs() < 1e-6);
        assert!(
            (0..3).any(|k| on(k, bounds.min[k]) || on(k, bounds.max[k])),
            "{:?}",
            edge.map(|p| p.map(f32::from_bits))
        );
    }
}

#[test]
fn degenerate_triangles_and_nan_do_no_harm() {
    let mut mesh =
        dressed(vec![[0.0; 3], [1.0; 3], [f32::NAN, 0.0, 0.0], [4.0, 0.0, 0.0]], vec![[0, 0, 1], [0, 1, 2], [0, 3, 1]]);
    mesh.normals = vec![[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]].into();
    let bounds = Aabb { min: DVec3::splat(-0.5), max: DVec3::splat(0.5) };
    let part = clip_scene(&scene_of(mesh, Mat4::IDENTITY), &bounds);
    sound(&part);
    assert!(triangles(&part).iter().flatten().all(|p| p.is_finite()));
    assert!(clip_scene(&part, &Aabb { min: DVec3::splat(7.0), max: DVec3::splat(8.0) }).objects.is_empty());
}

fn how(division: Division, levels: u32) -> Splitting {
    Splitting { division, levels, min_triangles: 0 }
}

#[test]
fn trees_hold_the_scene_at_every_level() {
    let scene = crate::scene::builtin::make("solids", 1).unwrap();
    for (division, most) in [(Division::Octree, 8), (Division::Bintree, 2), (Division::Kd, 2)] {
        let (tree, scenes) = split(&scene, how(division, 3), &Stop::default()).unwrap();
        assert_eq!((tree.regions.len(), &scenes[0]), (scenes.len(), &scene));
        assert!(tree.regions.is_sorted_by(|a, b| a.name < b.name) && tree.regions[0].name == "root");
        scenes.iter().for_each(sound);
        for (region, part) in tree.regions.iter().zip(&scenes) {
            assert_eq!(region.triangles, part.triangle_count() as u64);
            let find = |name: &String| tree.regions.iter().position(|r| r.name == *name).unwrap();
            let children: Vec<usize> = region.children.iter().map(find).collect();
            assert!(children.len() <= most);
            let depth = region.name.matches('.').count();
            assert_eq!(children.is_empty(), depth == 3, "{}", region.name);
            if children.is_empty() {
                continue;
            }
            // The children's boxes without inflation hold all of the parent's part in its own box.
            let box_of = |b: [[f64; 3]; 2]| Aabb { min: b[0].into(), max: b[1].into() };
            let own = area(&clip_scene(part, &box_of(region.bounds)));
            let of_child = |c: &usize| area(&clip_scene(&scenes[*c], &box_of(tree.regions[*c].bounds)));
            let sum: f64 = children.iter().map(of_child).sum();
            assert!((sum - own).abs() < 1e-4 * own, "{division:?} {}: {sum} {own}", region.name);
            for c in children {
                let (inner, outer) = (box_of(tree.regions[c].bounds), box_of(tree.regions[c].inflated));
                let margin = 0.01 * box_of(region.bounds).size().max_element();
                assert!((inner.min - outer.min - margin).abs().max_element() < 1e-12);
                assert!((outer.max - inner.max - margin).abs().max_element() < 1e-12);
            }
        }
    }
}

#[test]
fn small_flat_and_too_many() {
    let scene = crate::scene::builtin::make("solids", 1).unwrap();
    let stop = Stop::default();
    let names = |scene: &Scene, how| {
        let (tree, _) = split(scene, how, &stop).unwrap();
        tree.regions.into_iter().map(|r| r.name).collect::<Vec<_>>()
    };
    assert_eq!(names(&scene, how(Division::Octree, 0)), ["root"]);
    assert_eq!(names(&scene, Splitting { min_triangles: 1_000_000, ..how(Division::Kd, 6) }), ["root"]);
    // A flat scene has four parts.
    let card = scene_of(crate::raster::tests::square(), Mat4::IDENTITY);
    assert_eq!(names(&card, how(Division::Octree, 1)), ["root", "root.0", "root.1", "root.2", "root.3"]);
    let point = scene_of(dressed(vec![[1.0; 3]], vec![[0, 0, 0]]), Mat4::IDENTITY);
    assert_eq!(names(&point, how(Division::Octree, 3)), ["root"]);
    assert_eq!(split(&Scene::default(), how(Division::Octree, 1), &stop), Err(SplitError::Empty));
    assert_eq!(split(&scene, how(Division::Octree, 6), &stop).map(|s| s.0.regions.len()), Err(SplitError::Many));
    stop.set();
    assert!(matches!(split(&scene, how(Division::Octree, 1), &stop), Err(SplitError::Stopped(_))));
}
