use super::*;
use crate::{
    math::Stop,
    raster::{Cpu, Geometry, Shader},
    scene::{Scene, builtin},
};

fn take(scene: &Scene, layers: u32, backs: bool) -> Capture {
    let geometry = Geometry::new(scene);
    let shader = Shader::new(&geometry);
    let bounds = scene.bounds();
    let eye = bounds.centre() + DVec3::new(0.3, 0.4, 1.0).normalize() * bounds.diagonal() * 1.5;
    let view = View::look_at(eye, bounds.centre(), DVec3::Y, 0.7, 65, 65, 0.1, 100.0 * bounds.diagonal());
    capture(&Cpu, &shader, bounds, &view, Capturing { layers, backs }, &Stop::default()).unwrap()
}

#[test]
fn materials_arrive_where_they_are_asked_for() {
    use crate::scene::{Image, Material, Mesh, Object, Part, Texture, Wrap};
    use std::sync::Arc;
    let image = |texel: [u8; 4]| Texture {
        image: Arc::new(Image { name: String::new(), width: 1, height: 1, texels: vec![texel].into() }),
        uv_set: 0,
        offset: [0.0; 2],
        rotation: 0.0,
        scale: [1.0; 2],
        wrap: [Wrap::Repeat; 2],
        smooth: true,
    };
    let mesh = |x: f32| Mesh {
        positions: vec![[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]].into(),
        triangles: vec![[0, 1, 2]].into(),
        ..Mesh::default()
    };
    let plain = Material { metallic: 0.25, roughness: 0.5, emissive: [0.5, 0.0, 4.0], ..Material::default() };
    let textured = Material {
        metallic_roughness_texture: Some(image([7, 102, 204, 255])),
        occlusion_strength: 0.5,
        occlusion_texture: Some(image([51, 7, 7, 255])),
        emissive: [1.0; 3],
        emissive_texture: Some(image([10, 20, 30, 255])),
        ..plain.clone()
    };
    let part = |mesh, material| Part { mesh: Arc::new(mesh), material: Arc::new(material) };
    let parts = vec![part(mesh(-1.5), plain), part(mesh(0.5), textured)];
    let scene = Scene { objects: vec![Object { name: "o".into(), transform: glam::Mat4::IDENTITY, parts }] };
    let geometry = Geometry::new(&scene);
    let view = View::look_at(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, DVec3::Y, 0.9, 64, 64, 0.1, 9.0);
    let how = Capturing { layers: 2, backs: true };
    let take = |shader: &Shader| capture(&Cpu, shader, scene.bounds(), &view, how, &Stop::default()).unwrap();
    let (with, without) = (take(&Shader::with_finishes(&geometry)), take(&Shader::new(&geometry)));
    assert_eq!((with.fault(), without.fault()), (None, None));
    let mut seen = [0, 0];
    for (with, without) in with.layers.iter().zip(&without.layers) {
        assert!(without.orm.is_empty() && without.emissive.is_empty());
        // Nothing else changes.
        let (orm, emissive) = (Array::default(), Array::default());
        assert_eq!(&Layer { orm, emissive, ..with.clone() }, without);
        for (i, triangle) in with.triangle.iter().enumerate() {
            let expected = match triangle {
                // Half of the linear light is 188 of 255.
                0 => ([255, 128, 64, 255], [188, 0, 255, 255]),
                // Occlusion 1 + ½ (0.2 − 1); factors ½ and ¼ times 0.4 and 0.8.
                1 => ([153, 51, 51, 255], [10, 20, 30, 255]),
                _ => ([0; 4], [0; 4]),
            };
            assert_eq!((with.orm[i], with.emissive[i]), expected);
            if let Some(n) = seen.get_mut(*triangle as usize) {
                *n += 1;
            }
        }
    }
    assert!(seen.iter().all(|n| *n > 50), "{seen:?}");
}

#[test]
fn layers_lie_behind_each_other() {
    let scene = builtin::make("city", 1).unwrap();
    let one = take(&scene, 1, false);
    let four = take(&scene, 4, true);
    assert_eq!((one.fault(), four.fault()), (None, None));
    assert_eq!(one.layers[0], four.layers[0]);
    let mut deeper = 0;
    for pair in four.layers.windows(2) {
        for (a, b) in pair[0].depth.iter().zip(pair[1].depth.iter()) {
            assert!(a < b || b.is_infinite(), "{a} {b}");
            deeper += usize::from(b.is_finite());
        }
    }
    assert!(deeper > 500, "{deeper}");
}

#[test]
fn normals_face_the_camera_and_backs_are_left_out() {
    let scene = builtin::make("car", 1).unwrap();
    let with = take(&scene, 3, true);
    let without = take(&scene, 3, false);
    let filled =
        |c: &Capture| c.layers[1..].iter().map(|l| l.depth.iter().filter(|d| d.is_finite()).count()).sum::<usize>();
    assert!(filled(&with) > filled(&without) + 50, "{} {}", filled(&with), filled(&without));
    let (mut towards, mut away) = (0, 0);
    for (i, n) in without.layers[0].normal.iter().enumerate().filter(|(_, n)| **n != [0; 4]) {
        let n = DVec3::new(n[0].into(), n[1].into(), n[2].into()) / 32767.0;
        assert!((n.length() - 1.0).abs() < 1e-3);
        let (x, y) = ((i % 65) as f64 + 0.5, (i / 65) as f64 + 0.5);
        let ray = without.view.unproject(x, y, 1.0) - without.view.eye;
        *if n.dot(ray) < 0.0 { &mut towards } else { &mut away } += 1;
    }
    // Smooth normals of coarse meshes turn away at some outlines.
    assert!(towards > 300 && away * 20 < towards, "{towards} towards the camera, {away} away");
}
