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
