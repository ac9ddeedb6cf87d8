//! What regional culling hides, compared with lines and with pictures.

use super::{
    occluder::Opaque,
    outline::Outline,
    subject::Placement,
    umbra::{HEADINGS, picture, visible},
};
use crate::{
    math::{Sequence, Stop},
    raster::{Cpu, Geometry, NOTHING, Options, nearest},
    scene::{Material, Mesh, Object, Part, Scene, builtin},
    view::{Prism, View},
};
use glam::{DAffine3, DVec3, Mat4, Vec3};
use proptest::prelude::*;
use std::sync::Arc;

/// A box, closed and single-sided, without the faces in front whose middle lies in a hole: `front` divides its face towards −x into a grid, of which
/// these are left out.
fn boxed(min: DVec3, max: DVec3, holes: &[usize], double_sided: bool) -> Scene {
    const GRID: usize = 5;
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    let mut quad = |corners: [DVec3; 4]| {
        let first = positions.len() as u32;
        positions.extend(corners.map(|c| c.as_vec3().to_array()));
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    };
    let p = |x: f64, y: f64, z: f64| min + (max - min) * DVec3::new(x, y, z);
    for i in (0..GRID * GRID).filter(|i| !holes.contains(i)) {
        let (z, y, n) = ((i % GRID) as f64, (i / GRID) as f64, GRID as f64);
        let at = |z: f64, y: f64| p(0.0, y / n, z / n);
        quad([at(z, y), at(z + 1.0, y), at(z + 1.0, y + 1.0), at(z, y + 1.0)]);
    }
    quad([p(1.0, 0.0, 0.0), p(1.0, 1.0, 0.0), p(1.0, 1.0, 1.0), p(1.0, 0.0, 1.0)]);
    quad([p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(1.0, 0.0, 1.0), p(0.0, 0.0, 1.0)]);
    quad([p(0.0, 1.0, 0.0), p(0.0, 1.0, 1.0), p(1.0, 1.0, 1.0), p(1.0, 1.0, 0.0)]);
    quad([p(0.0, 0.0, 0.0), p(0.0, 1.0, 0.0), p(1.0, 1.0, 0.0), p(1.0, 0.0, 0.0)]);
    quad([p(0.0, 0.0, 1.0), p(1.0, 0.0, 1.0), p(1.0, 1.0, 1.0), p(0.0, 1.0, 1.0)]);
    let mesh = Mesh {
        positions: positions.into_iter().collect(),
        triangles: triangles.into_iter().collect(),
        ..Mesh::default()
    };
    let material = Arc::new(Material { double_sided, ..Material::default() });
    let part = Part { mesh: Arc::new(mesh), material };
    Scene { objects: vec![Object { name: "box".into(), transform: Mat4::IDENTITY, parts: vec![part] }] }
}

const CELL: Prism = Prism { centre: DVec3::new(3.0, 1.7, -2.0), size: 2.0, half_height: 0.2 };

/// What is found of scenes of one object each, whose coordinates are about the middle of the cell on the ground.
fn found(scenes: &[Scene], image_res: f64) -> Vec<bool> {
    let ground = DVec3::new(CELL.centre.x, 0.0, CELL.centre.z);
    let all: Vec<(Placement, Opaque)> = scenes
        .iter()
        .map(|s| {
            let object = Object { transform: Mat4::from_translation(ground.as_vec3()), ..s.objects[0].clone() };
            let transform = DAffine3::from_translation(ground);
            (Placement { transform, outline: Outline::of(&object), triangles: 1 }, Opaque::of(s))
        })
        .collect();
    let lent: Vec<(&Placement, &Opaque)> = all.iter().map(|(p, o)| (p, o)).collect();
    visible(&Cpu, &CELL, &lent, image_res, &Stop::default()).unwrap()
}

/// Whether a drawn side of a triangle lies between an eye and a point.
fn blocked(scenes: &[Scene], eye: DVec3, point: DVec3) -> bool {
    scenes.iter().flat_map(|s| &s.objects[0].parts).any(|part| {
        part.mesh.triangles.iter().any(|t| {
            let [a, b, c] = t.map(|v| Vec3::from(part.mesh.positions[v as usize]).as_dvec3());
            let (d, n) = (point - eye, (b - a).cross(c - a));
            let facing = -d.dot(n);
            if facing == 0.0 || (facing < 0.0 && !part.material.double_sided) {
                return false;
            }
            let at = (a - eye).dot(n) / d.dot(n);
            let p = eye + d * at;
            let inside = [(a, b), (b, c), (c, a)].iter().all(|(u, v)| (*v - *u).cross(p - *u).dot(n) >= 0.0);
            (0.0..1.0 - 1e-9).contains(&at) && inside
        })
    })
}

fn wall(holes: &[usize]) -> Scene {
    boxed(DVec3::new(20.0, 0.0, -15.0), DVec3::new(22.0, 12.0, 15.0), holes, false)
}

fn hut(z: f64) -> Scene {
    boxed(DVec3::new(60.0, 0.0, z - 2.0), DVec3::new(64.0, 4.0, z + 2.0), &[], false)
}

#[test]
fn a_wall_hides_what_is_behind_and_not_what_is_aside() {
    // The eye at z = 1.7 looks past the wall's end, at x = 22 and z = 15, and meets z = 38 at x = 60.
    assert_eq!(found(&[wall(&[]), hut(0.0), hut(45.0), hut(70.0)], 512.0), [true, false, true, true]);
    let tall = boxed(DVec3::new(60.0, 0.0, -2.0), DVec3::new(64.0, 60.0, 2.0), &[], false);
    assert_eq!(found(&[wall(&[]), tall], 512.0), [true, true], "it stands out above");
    let before = boxed(DVec3::new(10.0, 0.0, -1.0), DVec3::new(12.0, 1.0, 1.0), &[], false);
    assert_eq!(found(&[wall(&[]), before], 512.0), [true, true]);
}

#[test]
fn one_sees_through_a_window() {
    // The middle of the front is open at the ground; the back of a closed box is not drawn from the front, so one looks into the box and at its far side from behind.
    let open = [wall(&[2]), hut(0.0)];
    assert_eq!(found(&open, 512.0), [true, true]);
    // Far from the middle, the window shows other places.
    assert_eq!(found(&[wall(&[4]), hut(-18.0)], 512.0), [true, false]);
}

#[test]
fn a_slit_between_two_walls_is_seen_though_it_is_narrower_than_a_pixel() {
    let half = |z0: f64, z1: f64| boxed(DVec3::new(20.0, 0.0, z0), DVec3::new(22.0, 12.0, z1), &[], false);
    let slit = [half(-15.0, -0.0005), half(0.0005, 15.0), hut(0.0)];
    assert_eq!(found(&slit, 128.0), [true, true, true]);
    // They overlap. What is behind them is hidden, but the end of the one in front counts as a gap.
    let fused =
        [half(-15.0, 1.0), boxed(DVec3::new(19.0, 0.0, -1.0), DVec3::new(22.5, 12.0, 15.0), &[], false), hut(0.0)];
    assert_eq!(found(&fused, 512.0), [true, true, true]);
}

#[test]
fn a_finer_picture_hides_what_a_coarser_one_hides() {
    let scenes: Vec<Scene> = std::iter::once(wall(&[])).chain((0..12).map(|i| hut(f64::from(i) * 3.0))).collect();
    let hidden = |res: f64| found(&scenes, res).into_iter().filter(|v| !v).count();
    let (coarse, fine) = (hidden(64.0), hidden(1024.0));
    assert!(coarse <= fine && fine >= 5, "{coarse} {fine}");
}

/// No object that is left out covers a pixel of pictures from a cell between the buildings of a city.
#[test]
fn nothing_is_hidden_in_a_city_that_its_pictures_show() {
    const EYES: u32 = 12;
    let city = builtin::make("city", 1).unwrap();
    let shapes: Vec<Opaque> = city
        .objects
        .iter()
        .map(|o| Opaque::of(&Scene { objects: vec![Object { transform: Mat4::IDENTITY, ..o.clone() }] }))
        .collect();
    let places: Vec<Placement> = city
        .objects
        .iter()
        .map(|o| Placement {
            transform: DAffine3::from_mat4(o.transform.as_dmat4()),
            outline: Outline::of(o),
            triangles: 1,
        })
        .collect();
    let lent: Vec<(&Placement, &Opaque)> = places.iter().zip(&shapes).collect();
    let bounds = city.bounds();
    let free = |cell: &Prism| {
        let about = |p: &Placement| p.outline.as_ref().map(|o| o.about(cell.centre));
        let low = |o: &Outline| o.high < cell.half_height;
        places.iter().filter_map(about).all(|o| !o.meets(&Prism { centre: DVec3::ZERO, ..*cell }) || low(&o))
    };
    let sequence = Sequence::<3>::new(3);
    let cell = (0..4000)
        .map(|i| sequence.point(i))
        .map(|u| bounds.min + (bounds.max - bounds.min) * (DVec3::new(u[0], 0.0, u[2]) * 0.5 + 0.25))
        .map(|p| Prism { centre: DVec3::new(p.x, bounds.min.y + 1.7, p.z), size: 3.0, half_height: 0.2 })
        .find(free)
        .unwrap();
    let seen = visible(&Cpu, &cell, &lent, 512.0, &Stop::default()).unwrap();
    let hidden = seen.iter().filter(|s| !**s).count();
    assert!(hidden * 4 > city.objects.len(), "{hidden} of {}", city.objects.len());
    let geometry = Geometry::new(&city);
    for i in 0..EYES {
        let eye = cell.point(sequence.point(i));
        for heading in 0..HEADINGS {
            let view = View { eye, ..picture(heading, 200.0, bounds.diagonal()) };
            let picture = nearest(&Cpu, &geometry, &view, &Options::default(), &Stop::default()).unwrap();
            for t in picture.triangle.iter().filter(|t| **t != NOTHING) {
                let object = geometry.object_of(*t) as usize;
                assert!(seen[object], "{} from {eye}", city.objects[object].name);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    /// The literal way: no line from an eye of the cell to a point of a hidden object is free. Few wide boxes stand before many small ones.
    #[test]
    fn nothing_is_hidden_that_an_eye_sees(
        wide in prop::collection::vec((prop::array::uniform2(0.0..1.0_f64), 3.0..12.0_f64, prop::collection::vec(0..25_usize, 0..2), any::<bool>()), 2..5),
        seed in 0..1000_u64,
    ) {
        let at = |u: f64, v: f64, from: f64| {
            let (angle, r) = ((u - 0.5) * 1.6, from + 50.0 * v);
            DVec3::new(libm::cos(angle) * r, 0.0, libm::sin(angle) * r)
        };
        let sequence = Sequence::<6>::new(seed);
        let mut scenes: Vec<Scene> = wide.iter().map(|(u, d, holes, double)| {
            let at = at(u[0], u[1], 14.0);
            boxed(at - DVec3::new(1.0, 0.0, *d), at + DVec3::new(1.0, 14.0, *d), if *double { holes } else { &[] }, *double)
        }).collect();
        scenes.extend((0..40).map(|i| sequence.point(i)).map(|u| {
            let at = at(u[0], u[1], 40.0);
            boxed(at - DVec3::new(u[2], 0.0, u[3]), at + DVec3::new(u[2], 4.0 * u[4], u[3]), &[], false)
        }));
        let local = Prism { centre: DVec3::Y * CELL.centre.y, ..CELL };
        let eyes: Vec<DVec3> = (0..12).map(|k| local.point([0, 1, 2].map(|i| sequence.point(k)[i]))).chain(local.corners()).collect();
        for (i, _) in found(&scenes, 256.0).into_iter().enumerate().filter(|(_, seen)| !seen) {
            let corners = Outline::of(&scenes[i].objects[0]).unwrap().corners();
            let (min, max) = (corners[0], corners[6]);
            for k in 0..60 {
                let u = sequence.point(100 + k);
                let mut v = DVec3::new(u[3], u[4], u[5]);
                (0..3).filter(|a| k % 4 == 3 || k as usize % 4 == *a).for_each(|a| v[a] = v[a].round());
                for eye in &eyes {
                    prop_assert!(blocked(&scenes, *eye, min + (max - min) * v), "object {i} from {eye}");
                }
            }
        }
    }
}
