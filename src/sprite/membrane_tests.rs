//! What must hold of solids whose surface is open or overlaps itself.

use super::{
    tests::{cuboid, run, together},
    *,
};
use crate::{
    math::{Sequence, Stop},
    raster::{Geometry, tests::mesh},
    scene::{Mesh, Scene},
};
use glam::DVec3;

/// The share of points about which the peeled image differs from `truth`; those within 1.5 texels of where `truth` changes apart.
fn wrong(scene: &Scene, forward: DVec3, truth: impl Fn(DVec3) -> bool) -> f64 {
    const SIDE: u32 = 64;
    let Peeled { image, frame, .. } = run(scene, forward, SIDE, Repair::Winding).unwrap();
    let back = frame.to_texture().inverse();
    let step = 1.5 * frame.side() / f64::from(SIDE);
    let sequence = Sequence::<3>::new(7);
    let (mut tested, mut wrong) = (0, 0);
    for i in 0..4000 {
        let p = DVec3::from(sequence.point(i));
        let world = back.transform_point3(p);
        let offsets = (0..27).map(|k| DVec3::new(f64::from(k % 3), f64::from(k / 3 % 3), f64::from(k / 9)) - 1.0);
        let here = truth(world);
        if offsets.into_iter().all(|o| truth(world + o * step) == here) {
            tested += 1;
            wrong += usize::from(image.contains(p.as_vec3().to_array()) != here);
        }
    }
    assert!(tested > 1000, "{tested}");
    f64::from(wrong as u32) / f64::from(tested)
}

fn in_box(low: [f64; 3], high: [f64; 3]) -> impl Fn(DVec3) -> bool {
    move |p| p.cmpgt(DVec3::from(low)).all() && p.cmplt(DVec3::from(high)).all()
}

fn without(m: &Mesh, faces: &[usize]) -> Mesh {
    let kept: Vec<_> = (0..m.triangles.len()).filter(|t| !faces.contains(t)).map(|t| m.triangles[t]).collect();
    mesh(&m.positions, &kept)
}

const DIRECTIONS: [DVec3; 3] = [DVec3::NEG_Z, DVec3::new(0.6, 0.64, 0.48), DVec3::Y];

/// Where boxes overlap, all of them is inside; the parity of crossings would take the common part out.
#[test]
fn overlapping_solids_are_their_union() {
    let (a, b) = (([-1.0; 3], [0.5; 3]), ([-0.5; 3], [1.0; 3]));
    let scene = together(&[cuboid(a.0, a.1), cuboid(b.0, b.1)]);
    let [a, b] = [a, b].map(|(l, h)| in_box(l.map(f64::from), h.map(f64::from)));
    for forward in DIRECTIONS {
        assert_eq!(wrong(&scene, forward, |p| a(p) || b(p)), 0.0, "{forward}");
    }
}

/// A seam that is open by a hair, and one missing triangle of many: the solid is what it would be if it were closed.
#[test]
fn small_holes_change_little() {
    let ball = crate::raster::tests::octahedron(3);
    let scene = together(&[without(&ball, &[17, 200, 201])]);
    for forward in DIRECTIONS {
        // The facets lie up to 1.5 % inside the ball, less than the margin.
        assert_eq!(wrong(&scene, forward, |p| p.length() < 0.99), 0.0, "{forward}");
    }
}

/// A box without its front: by definition inside is where the winding number of what is left says so, along whatever direction
/// it is peeled; also along rays that meet no triangle on one side of it.
#[test]
fn open_boxes_are_closed_by_the_winding_number() {
    let all = cuboid([-1.0, -0.8, -0.6], [1.0, 0.8, 0.6]);
    for missing in [vec![0, 1], vec![4, 5, 6, 7]] {
        let open = without(&all, &missing);
        let at = |i: u32| DVec3::from(open.positions[i as usize].map(f64::from));
        let triangles: Vec<_> = open.triangles.iter().map(|t| t.map(at)).collect();
        // By solid angles (van Oosterom and Strackee), all of them.
        let angle = |[a, b, c]: [DVec3; 3]| {
            let below = a.length() * b.length() * c.length()
                + a.dot(b) * c.length()
                + b.dot(c) * a.length()
                + c.dot(a) * b.length();
            2.0 * libm::atan2(a.dot(b.cross(c)), below)
        };
        let truth = |p: DVec3| {
            triangles.iter().map(|t| angle(t.map(|q| q - p))).sum::<f64>().abs() > 2.0 * std::f64::consts::PI
        };
        let scene = together(std::slice::from_ref(&open));
        for forward in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z, DVec3::new(0.6, 0.64, 0.48)] {
            assert_eq!(wrong(&scene, forward, truth), 0.0, "{forward} without {missing:?}");
        }
    }
}

/// What is closed stays what it was, bit for bit but for coincident crossings.
#[test]
fn closed_solids_stay_as_they_are() {
    let scene = together(&[cuboid([-1.0, -0.8, -0.6], [1.0, 0.8, 0.6])]);
    let direction = DVec3::new(0.6, 0.64, 0.48);
    let by_parity = run(&scene, direction, 48, Repair::None).unwrap();
    let by_winding = run(&scene, direction, 48, Repair::Winding).unwrap();
    assert_eq!(by_parity.image, by_winding.image);
    assert_eq!((by_parity.repair, by_winding.repair), (Repair::None, Repair::Winding));
}

#[test]
fn an_open_surface_says_what_to_do() {
    let scene = together(&[without(&cuboid([-1.0; 3], [1.0; 3]), &[0])]);
    let message = run(&scene, DVec3::X, 32, Repair::None).unwrap_err().to_string();
    assert!(message.contains("--set peel.repair=winding"), "{message}");
}

#[test]
fn the_same_bytes_for_any_thread_count() {
    let scene = together(&[without(&crate::raster::tests::octahedron(4), &[3, 90, 91, 92])]);
    let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    let once = |n| pool(n).install(|| run(&scene, DIRECTIONS[1], 80, Repair::Winding).unwrap());
    assert_eq!(once(1), once(3));
}

#[test]
fn a_stop_is_obeyed() {
    let scene = together(&[without(&crate::raster::tests::octahedron(3), &[3])]);
    let stop = Stop::default();
    stop.set();
    let how = Peeling { resolution: 64, samples: 1, repair: Repair::Winding };
    let direction = Direction::new(DVec3::X).unwrap();
    let result = peel(&crate::raster::Cpu, &Geometry::new(&scene), &direction, &how, &stop);
    assert!(matches!(result, Err(PeelError::Stopped(_))));
}
