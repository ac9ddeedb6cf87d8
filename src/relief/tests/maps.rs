use super::{cube, map, scene, sphere};
use crate::{
    array::Array,
    capture::{Capturing, capture},
    math::{Sequence, Stop},
    raster::{Cpu, Geometry, Shader},
    relief::{
        DepthBits, Resampling, resample,
        textures::{Compression, compress},
    },
    view::{Region, View, directions::look_along},
};
use glam::DVec3;

fn directions(n: u32) -> Vec<DVec3> {
    let sphere = Region::Sphere { centre: DVec3::ZERO, radius: 1.0 };
    let sequence = Sequence::<3>::new(5);
    (0..n).map(|i| sphere.eye(sequence.point(i))).collect()
}

#[test]
fn depths_of_a_sphere_are_analytic() {
    let scene = sphere(5);
    for (bits, steps) in [(DepthBits::Eight, 240.0), (DepthBits::Sixteen, 65520.0)] {
        for direction in directions(3) {
            let map = map(&scene, direction, 64, 2, bits);
            let step = (map.view.far - map.view.near) / (steps - 1.0);
            let mut compared = 0;
            for i in 0..64 * 64 {
                let Some(z) = map.depth_of(i) else { continue };
                let (x, y) = ((i % 64) as f64 + 0.5, (i / 64) as f64 + 0.5);
                let p = map.view.unproject(x, y, z);
                // Towards the rim the mean of a texel differs from the depth at its centre.
                let aside = p - direction * p.dot(direction);
                if aside.length() > 0.9 {
                    continue;
                }
                assert!((p.length() - 1.0).abs() < step + 0.004, "{bits:?} {direction}: {}", p.length());
                compared += 1;
            }
            assert!(compared > 2000, "{compared}");
        }
    }
}

#[test]
fn depths_and_normals_of_a_cube_are_analytic() {
    let map = map(&cube(), DVec3::Y, 32, 4, DepthBits::Eight);
    for i in 0..32 * 32 {
        let (x, y) = (i % 32, i / 32);
        let inside = (1..31).contains(&x) && (1..31).contains(&y);
        assert_eq!(map.depth_of(i).is_some(), inside, "{x} {y}");
        if let Some(z) = map.depth_of(i) {
            assert!((map.view.unproject(0.0, 0.0, z).y - 1.0).abs() < 1e-9);
            assert_eq!(map.normal[i], [127, 127]);
        }
    }
    // Beside the outline, which runs between texels, surfaces reach half-way.
    let code = u32::from(map.depth[32 * 16]);
    let reach = (f64::from(256 - code) - 0.5) / 16.0;
    assert!((reach - 0.5).abs() <= 1.0 / 16.0, "{reach}");
}

/// Outlines that cut texels anywhere are kept within a sixteenth of a texel and the capture's pixels.
#[test]
fn outlines_are_kept_between_texels() {
    let edge = |x: f32| {
        scene(vec![[-1.0, -1.0, 0.0], [x, -1.0, 0.0], [x, 1.0, 0.0], [-1.0, 1.0, 0.0]], vec![[0, 1, 2], [0, 2, 3]])
    };
    let whole = edge(1.0);
    for k in 0..12 {
        let x = k as f32 / 12.0 * 0.2;
        let cut = edge(x);
        let geometry = Geometry::new(&cut);
        let view = look_along(whole.points().into_iter(), DVec3::Z, 16 * 8, 8.0).unwrap();
        let taken = capture(
            &Cpu,
            &Shader::new(&geometry),
            cut.bounds(),
            &view,
            Capturing { layers: 1, backs: false },
            &Stop::default(),
        );
        let map = resample(&taken.unwrap(), Resampling { samples: 8, bits: DepthBits::Eight }).unwrap();
        let field = crate::relief::Field::new(&map, 4.0);
        // Along the middle row, where the surface ends.
        let row = 8.0;
        let end =
            (0..1600).map(|i| i as f32 * 0.01).filter(|u| field.height(*u, row, 4.0).is_finite()).fold(0.0, f32::max);
        let expected = view.project(DVec3::new(f64::from(x), 0.0, 0.0)).0 as f32 / 8.0;
        assert!((end - expected).abs() < 0.13, "{x}: ends at {end}, expected {expected}");
    }
}

#[test]
fn flat_objects_and_single_triangles_have_maps() {
    let triangle = scene(vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
    let front = map(&triangle, DVec3::Z, 16, 2, DepthBits::Eight);
    assert!(front.covered() > 60 && front.check().is_ok());
    // Edge-on and from behind nothing is seen; that is a legal map.
    for direction in [DVec3::X, DVec3::NEG_Z] {
        let map = map(&triangle, direction, 16, 2, DepthBits::Eight);
        assert_eq!(map.covered(), 0);
        assert!(map.check().is_ok());
    }
}

#[test]
fn materials_of_a_capture_arrive_in_the_map() {
    let scene = cube();
    let geometry = Geometry::new(&scene);
    let view = look_along(scene.points().into_iter(), DVec3::ONE, 32, 1.0).unwrap();
    let shader = Shader::with_finishes(&geometry);
    let how = Capturing { layers: 1, backs: false };
    let mut taken = capture(&Cpu, &shader, scene.bounds(), &view, how, &Stop::default()).unwrap();
    let layer = &mut taken.layers[0];
    assert_eq!(layer.orm.len(), 32 * 32);
    // Every second column differs, so that each texel has a mean.
    let seen: Vec<bool> = layer.depth.iter().map(|d| d.is_finite()).collect();
    let image = |even: [u8; 4], odd: [u8; 4]| {
        let pixel = |i: usize| {
            if !seen[i] {
                [0; 4]
            } else if i.is_multiple_of(2) {
                even
            } else {
                odd
            }
        };
        (0..seen.len()).map(pixel).collect::<Array<[u8; 4]>>()
    };
    layer.orm = image([10, 20, 30, 255], [30, 60, 90, 255]);
    layer.emissive = image([0, 255, 0, 255], [255, 255, 0, 255]);
    let map = resample(&taken, Resampling { samples: 2, bits: DepthBits::Eight }).unwrap();
    let inside = 8 * 16 + 8;
    assert_eq!((map.orm[inside], map.emissive[inside]), ([20, 40, 60, 255], [188, 255, 0, 255]));
    // Texels without surface have the values of the nearest.
    assert!(map.orm.iter().all(|t| t[0] >= 10 && t[3] == 255));
}

#[test]
fn captures_of_other_shapes_are_refused() {
    let scene = cube();
    let geometry = Geometry::new(&scene);
    let take = |view: &View| {
        capture(
            &Cpu,
            &Shader::new(&geometry),
            scene.bounds(),
            view,
            Capturing { layers: 1, backs: false },
            &Stop::default(),
        )
        .unwrap()
    };
    let flat = look_along(scene.points().into_iter(), DVec3::Z, 30, 1.0).unwrap();
    for (view, samples) in [
        (View { width: 28, ..flat }, 2),
        (flat, 4),
        (flat, 30),
        (View::look_at(DVec3::Z * 4.0, DVec3::ZERO, DVec3::Y, 0.9, 30, 30, 0.1, 9.0), 2),
    ] {
        assert!(resample(&take(&view), Resampling { samples, bits: DepthBits::Eight }).is_err(), "{view:?} {samples}");
    }
}

#[test]
fn textures_hold_the_maps() {
    let maps: Vec<_> = [DVec3::X, DVec3::Y].map(|d| map(&sphere(3), d, 16, 1, DepthBits::Eight)).to_vec();
    let both: Vec<_> = maps.iter().collect();
    let plain = compress(&both, Compression { blocks: false, levels: 16 }, &Stop::default()).unwrap();
    for (i, map) in maps.iter().enumerate() {
        assert_eq!(plain.map(i as u32, map.view).as_ref(), Some(map));
    }
    assert_eq!(plain.map(2, maps[0].view), None);
    let blocks = compress(&both, Compression::default(), &Stop::default()).unwrap();
    // Section 4: 2.5 bytes a texel on the first level.
    let base: usize = blocks.named().map(|(_, a)| a.levels[0].len()).sum();
    assert_eq!(base, 2 * 16 * 16 * 5 / 2);
    let read = blocks.map(1, maps[1].view).unwrap();
    assert_eq!(read.depth, maps[1].depth);
    let far = |a: &[u8; 2], b: &[u8; 2]| a[0].abs_diff(b[0]).max(a[1].abs_diff(b[1]));
    assert!(read.normal.iter().zip(maps[1].normal.iter()).all(|(a, b)| far(a, b) < 24));
    let mut other = maps[0].clone();
    other.bits = DepthBits::Sixteen;
    assert!(compress(&[&maps[0], &other], Compression::default(), &Stop::default()).is_err());
    assert!(compress(&[], Compression::default(), &Stop::default()).is_err());
}
