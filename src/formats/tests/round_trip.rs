//! What is written comes back.

use super::*;
use crate::formats::{GlbOptions, from_glb, write_glb};
use glam::{Quat, Vec3, vec3};
use proptest::prelude::*;

fn back(scene: &Scene, unlit: bool) -> Scene {
    let bytes = write_glb(scene, &GlbOptions { unlit, normal_maps: false }).unwrap();
    let scene = from_glb(Path::new("memory.glb"), Arc::new(bytes), &small()).unwrap();
    keeps_its_promises(&scene);
    scene
}

#[test]
fn a_lit_scene_comes_back_as_it_was() {
    let scene = everything();
    let again = back(&scene, false);
    assert_eq!(again, scene);
    // Instances share their geometry again, and materials their images.
    assert!(Arc::ptr_eq(&again.objects[0].parts[0].mesh, &again.objects[1].parts[0].mesh));
    assert!(Arc::ptr_eq(&again.objects[0].parts[0].material, &again.objects[1].parts[0].material));
}

#[test]
fn unlit_keeps_the_base_colour_and_nothing_else() {
    let scene = back(&everything(), true);
    let m = &scene.objects[0].parts[0].material;
    assert!(m.unlit && m.base_color_texture.is_some());
    assert!(m.normal_texture.is_none() && m.emissive_texture.is_none() && m.metallic_roughness_texture.is_none());
    assert!(m.occlusion_texture.is_none());
    assert_eq!(m.alpha, Alpha::Mask { cutoff: 0.25 });
}

#[test]
fn shared_things_are_stored_once() {
    let mut scene = everything();
    let one = write_glb(&scene, &GlbOptions::default()).unwrap().len();
    for i in 0..10 {
        // Equal in content, another in memory.
        let mut object = everything().objects[0].clone();
        object.name = format!("copy {i}");
        object.transform = Mat4::from_translation(vec3(i as f32, 0.0, 0.0));
        scene.objects.push(object);
    }
    let many = write_glb(&scene, &GlbOptions::default()).unwrap().len();
    assert!(many - one < 10 * 90, "{one} bytes, with ten more instances {many}");
}

#[test]
fn sheared_objects_are_stored_in_world_space() {
    let shear = Mat4::from_rotation_z(0.5) * Mat4::from_scale(vec3(1.0, -3.0, 1.0)) * Mat4::from_rotation_z(0.7);
    let mesh = Arc::new(Mesh { normals: vec![[0.0, 0.0, 1.0]; 3].into(), ..triangle() });
    let part = Part { mesh, material: Arc::default() };
    let scene = Scene { objects: vec![Object { name: "s".into(), transform: shear, parts: vec![part] }] };
    let again = back(&scene, false);
    let (a, b) = (again.bounds(), scene.bounds());
    assert!((a.min - b.min).abs().max_element() < 1e-6 && (a.max - b.max).abs().max_element() < 1e-6);
    let mesh = &again.objects[0].parts[0].mesh;
    assert_eq!(again.objects[0].transform, Mat4::IDENTITY);
    // The mirroring has turned the triangle round, so that its front is still where its normals point.
    let [a, b, c] = mesh.triangles[0].map(|v| Vec3::from(mesh.positions[v as usize]));
    assert!((b - a).cross(c - a).dot(Vec3::from(mesh.normals[0])) > 0.0);
}

#[test]
fn textures_without_coordinates_are_left_out_where_they_are_missing() {
    let mut scene = everything();
    let mut mesh = (*scene.objects[0].parts[0].mesh).clone();
    mesh.uv[0] = Default::default();
    scene.objects[0].parts[0].mesh = Arc::new(mesh);
    let again = back(&scene, false);
    let m = &again.objects[0].parts[0].material;
    assert!(m.base_color_texture.is_some(), "its coordinates are the second set");
    assert!(m.normal_texture.is_none());
    assert!(again.objects[1].parts[0].material.normal_texture.is_some());
}

#[test]
fn more_than_65535_vertices_need_wide_numbers() {
    let n = 65_536u32;
    let positions = (0..n).map(|i| [i as f32, (i % 7) as f32, 0.0]).collect();
    let mesh = Mesh { positions, triangles: vec![[n - 1, 0, 1]].into(), ..Mesh::default() };
    let part = Part { mesh: Arc::new(mesh), material: Arc::default() };
    let scene = Scene { objects: vec![Object { name: "s".into(), transform: Mat4::IDENTITY, parts: vec![part] }] };
    let bytes = write_glb(&scene, &GlbOptions::default()).unwrap();
    let again = from_glb(Path::new("m.glb"), Arc::new(bytes), &Limits::default()).unwrap();
    assert_eq!(again.bounds(), scene.bounds());
}

#[test]
fn what_cannot_be_written_is_an_error() {
    let mut scene = everything();
    let mut mesh = triangle();
    mesh.positions = vec![[f32::NAN, 0.0, 0.0]; 3].into();
    scene.objects[1].parts[0].mesh = Arc::new(mesh);
    let e = write_glb(&scene, &GlbOptions::default()).unwrap_err().to_string();
    assert_eq!(e, "a: a vertex that is not finite");
}

proptest! {
    #[test]
    fn any_placement_comes_back(t in prop::array::uniform3(-1e3f32..1e3), q in prop::array::uniform4(-1f32..1.0),
                                s in prop::array::uniform3(prop_oneof![0.01f32..10.0, -10f32..-0.01])) {
        let q = Quat::from_array(q);
        prop_assume!(q.length() > 0.1);
        let transform = Mat4::from_scale_rotation_translation(s.into(), q.normalize(), t.into());
        let part = Part { mesh: Arc::new(triangle()), material: Arc::default() };
        let scene = Scene { objects: vec![Object { name: "s".into(), transform, parts: vec![part] }] };
        let again = back(&scene, false);
        for (x, y) in scene.objects[0].transform.to_cols_array().iter().zip(again.objects[0].transform.to_cols_array()) {
            prop_assert!((x - y).abs() <= 2e-6 * x.abs().max(10.0), "{x} {y}");
        }
    }
}
