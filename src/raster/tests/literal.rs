//! The rasteriser against its definition: every pixel asks every triangle.

use super::*;
use crate::{
    raster::{camera::Camera, clip::clip_to_view, prepare::depth_plane},
    view::Projection,
};
use proptest::prelude::*;

/// All fragments in order, by wide integers at every pixel centre.
fn literal(scene: &Scene, view: &View) -> Vec<Vec<Fragment>> {
    let geometry = Geometry::new(scene);
    let camera = Camera::new(view);
    let mut pixels = vec![Vec::new(); (view.width * view.height) as usize];
    for triangle in 0..geometry.triangle_count() {
        let draw = geometry.draw_of(triangle);
        let m = camera.object_to_camera(&draw.to_world);
        let indices = draw.mesh.triangles[(triangle - draw.first) as usize];
        let p = indices.map(|i| m.transform_point3(Vec3::from(draw.mesh.positions[i as usize]).as_dvec3()));
        let polygon = clip_to_view(p, &camera);
        let depth = |f: fn(f64, f64) -> f64, from: f64| polygon.corners().iter().map(|p| p.z).fold(from, f);
        let (least, most) = (depth(f64::min, f64::INFINITY) as f32, depth(f64::max, f64::NEG_INFINITY) as f32);
        let [a, b, c] = depth_plane(&camera, p);
        let snapped: Vec<[i32; 2]> = polygon.corners().iter().map(|p| camera.snapped(*p)).collect();
        for k in 2..snapped.len() {
            let v = [snapped[0], snapped[k - 1], snapped[k]];
            for (i, pixel) in pixels.iter_mut().enumerate() {
                let (x, y) = (i as u32 % view.width, i as u32 / view.width);
                if inside(v, x, y) {
                    let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                    let q = a * px + (b * py + c);
                    let z = match view.projection {
                        Projection::Perspective { .. } if 1.0 / q < 0.0 => f64::INFINITY,
                        Projection::Perspective { .. } => 1.0 / q,
                        Projection::Orthographic { .. } => q,
                    };
                    pixel.push(Fragment { triangle, depth: (z as f32).max(least).min(most) + 0.0 });
                }
            }
        }
    }
    for pixel in &mut pixels {
        pixel.sort_by(|a, b| a.depth.total_cmp(&b.depth).then(a.triangle.cmp(&b.triangle)));
    }
    pixels
}

fn inside(v: [[i32; 2]; 3], x: u32, y: u32) -> bool {
    let edge = |a: [i32; 2], b: [i32; 2], p: [i128; 2]| {
        let d = [(b[0] - a[0]) as i128, (b[1] - a[1]) as i128];
        (d[0] * (p[1] - a[1] as i128) - d[1] * (p[0] - a[0] as i128), d)
    };
    let (area, _) = edge(v[0], v[1], [v[2][0] as i128, v[2][1] as i128]);
    if area == 0 {
        return false;
    }
    let v = if area < 0 { [v[0], v[2], v[1]] } else { v };
    let p = [x as i128 * 256 + 128, y as i128 * 256 + 128];
    (0..3).all(|i| {
        let (e, d) = edge(v[i], v[(i + 1) % 3], p);
        e > 0 || (e == 0 && (d[1] < 0 || (d[1] == 0 && d[0] > 0)))
    })
}

fn check(scene: &Scene, view: &View) -> Result<(), TestCaseError> {
    let (expect, found, near) = (literal(scene, view), all(scene, view), first(scene, view));
    for (i, expect) in expect.iter().enumerate() {
        let (x, y) = (i as u32 % view.width, i as u32 / view.width);
        prop_assert_eq!(found.of(x, y), &expect[..], "pixel {}, {}", x, y);
        let nearest = expect.first().copied().unwrap_or(Fragment { triangle: NOTHING, depth: f32::INFINITY });
        prop_assert_eq!(Fragment { triangle: near.triangle[i], depth: near.depth[i] }, nearest, "pixel {}, {}", x, y);
    }
    Ok(())
}

/// Triangles over few places: many share edges and corners, are slivers, lie in one plane, or have no area.
pub fn soup() -> impl Strategy<Value = Scene> {
    let coarse = prop::array::uniform3(-3i8..=3).prop_map(|p| p.map(|c| c as f32 * 0.5));
    let fine = prop::array::uniform3(-2.0f32..2.0);
    let far = prop::array::uniform3(-1e6f32..1e6);
    let place = prop_oneof![6 => coarse, 3 => fine, 1 => far];
    (prop::collection::vec(place, 3..12), prop::collection::vec(prop::array::uniform3(0u32..1000), 1..24)).prop_map(
        |(points, faces)| {
            let n = points.len() as u32;
            scene(mesh(&points, &faces.iter().map(|f| f.map(|i| i % n)).collect::<Vec<_>>()))
        },
    )
}

pub fn any_view() -> impl Strategy<Value = View> {
    let eye = prop::array::uniform3(-2.5f64..2.5);
    (eye, 1u32..140, 1u32..80, prop::array::uniform2(-0.4f64..0.4), any::<bool>(), 0.05f64..1.5).prop_map(
        |(eye, w, h, [dx, dy], perspective, near)| {
            let eye = DVec3::from(eye);
            let view = View::look_at(eye, DVec3::new(0.1, 0.2, 0.3), DVec3::Y, 1.2, w, h, near, 6.0);
            let (left, right, bottom, top) = (dx - 0.7, dx + 0.7, dy - 0.6, dy + 0.6);
            let projection = match perspective {
                true => Projection::Perspective { left, right, bottom, top },
                false => Projection::Orthographic { left: left * 3.0, right: right * 3.0, bottom, top: top * 2.0 },
            };
            View { projection, ..view }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn all_surfaces_are_those_of_the_definition(scene in soup(), view in any_view()) {
        check(&scene, &view)?;
    }
}

#[test]
fn enormous_triangles_through_the_eye() {
    let e = 1e30f32;
    let points = [[-e, -0.5, -e], [e, -0.5, -e], [0.0, -0.5, e], [0.0, e, -3.0], [f32::MAX, f32::MAX, -2.0]];
    let scene = scene(mesh(&points, &[[0, 1, 2], [0, 3, 1], [2, 3, 4], [0, 2, 4]]));
    let view = View { eye: DVec3::ZERO, far: f64::INFINITY, ..ahead(1.0, 70, 67) };
    check(&scene, &view).unwrap();
    let below = all(&scene, &view).of(35, 60).to_vec();
    assert!(below.iter().any(|f| f.triangle == 0 && (f.depth - 0.5 / (26.5 / 33.5)).abs() < 0.1), "{below:?}");
}

#[test]
fn depth_is_that_of_the_ray() {
    let scene = scene(octahedron(2));
    let view = ahead(2.5, 90, 80);
    let geometry = Geometry::new(&scene);
    let found = all(&scene, &view);
    let mut count = 0;
    for y in 0..view.height {
        for x in 0..view.width {
            for f in found.of(x, y) {
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                let [a, b, c] = geometry.positions(f.triangle);
                let n = (b - a).cross(c - a);
                let ray = view.unproject(px, py, 1.0) - view.eye;
                let z = n.dot(a - view.eye) / n.dot(ray);
                let least = [a, b, c].map(|p| view.project(p).2).into_iter().fold(f64::INFINITY, f64::min);
                assert!((z - f.depth as f64).abs() < 1e-5 || f.depth as f64 <= least + 1e-6, "{z} {f:?}");
                count += 1;
            }
        }
    }
    assert!(count > 1000);
}
