//! What must hold of peeling, packing and the parity test.

use super::*;
use crate::{
    math::{Stop, squared_distance},
    raster::{
        Cpu, Geometry,
        tests::{mesh, octahedron, scene},
    },
    scene::{Mesh, Scene},
};
use glam::DVec3;
use proptest::prelude::*;

/// A box with its faces outwards.
pub(super) fn cuboid(low: [f32; 3], high: [f32; 3]) -> Mesh {
    let at = |i: u32, k: usize| if i >> k & 1 == 1 { high[k] } else { low[k] };
    let points: Vec<[f32; 3]> = (0..8).map(|i| [at(i, 0), at(i, 1), at(i, 2)]).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    mesh(&points, &quads.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).concat())
}

pub(super) fn together(meshes: &[Mesh]) -> Scene {
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    for m in meshes {
        let first = points.len() as u32;
        points.extend_from_slice(&m.positions);
        faces.extend(m.triangles.iter().map(|t| t.map(|i| i + first)));
    }
    scene(mesh(&points, &faces))
}

pub(super) fn run(scene: &Scene, forward: DVec3, resolution: u32, repair: Repair) -> Result<Peeled, PeelError> {
    let direction = Direction::new(forward).unwrap();
    let how = Peeling { resolution, samples: 1, repair };
    peel(&Cpu, &Geometry::new(scene), &direction, &how, &Stop::default())
}

/// Whether a point lies inside by crossings of a ray with every triangle, in another direction than the peel's.
fn exact(geometry: &Geometry, p: DVec3) -> bool {
    let d = DVec3::new(0.377, 0.811, 0.447);
    let crossed = |t: &u32| {
        let [a, b, c] = geometry.positions(*t).map(|q| q - p);
        let volume = |u: DVec3, v: DVec3| d.dot(u.cross(v));
        let (u, v, w) = (volume(b, c), volume(c, a), volume(a, b));
        let n = (b - a).cross(c - a);
        let one_side = (u > 0.0 && v > 0.0 && w > 0.0) || (u < 0.0 && v < 0.0 && w < 0.0);
        one_side && n.dot(a) / n.dot(d) > 0.0
    };
    (0..geometry.triangle_count()).filter(crossed).count() % 2 == 1
}

/// Image and all layouts answer alike, and as the mesh itself where a point is farther than 0.75 texel from the surface; how
/// many points were inside.
fn check(scene: &Scene, forward: DVec3, resolution: u32) -> usize {
    let geometry = Geometry::new(scene);
    assert!(closedness(&geometry).is_closed());
    let Peeled { image, frame, odd, .. } = run(scene, forward, resolution, Repair::None).unwrap();
    assert!(odd.is_empty());
    let cropped = image.crop().unwrap();
    let packed: Vec<Packed> = Layout::ALL.into_iter().map(|l| Packed::new(&cropped, l).unwrap()).collect();
    let (to_texture, from_texture) = (frame.to_texture(), frame.to_texture().inverse());
    let sequence = crate::math::Sequence::<3>::new(5);
    let mut inside = 0;
    for i in 0..3000 {
        let world = from_texture.transform_point3(DVec3::from(sequence.point(i)) * 1.1 - 0.05);
        let point = to_texture.transform_point3(world).as_vec3().to_array();
        let found = image.contains(point);
        assert_eq!(cropped.contains(point), found);
        for p in &packed {
            assert_eq!(p.contains(point), found, "{:?} {point:?}", p.layout());
        }
        let nearest = (0..geometry.triangle_count()).map(|t| squared_distance(geometry.positions(t), world).sqrt());
        if nearest.fold(f64::INFINITY, f64::min) > 0.75 * frame.side() / f64::from(resolution) {
            assert_eq!(found, exact(&geometry, world), "{world} {point:?}");
        }
        inside += usize::from(found);
    }
    inside
}

#[test]
fn the_grid_answers_as_all_triangles_do() {
    let concave = together(&[octahedron(2), cuboid([0.5, -0.3, -0.4], [3.0, 0.2, 0.6])]);
    let geometry = Geometry::new(&concave);
    let frame = CubeFrame::around(&geometry, &Direction::new(DVec3::new(0.3, -0.8, 0.5)).unwrap()).unwrap();
    let (judge, from_texture) = (Exact::new(&geometry, &frame), frame.to_texture().inverse());
    let sequence = crate::math::Sequence::<3>::new(2);
    let mut inside = 0;
    for i in 0..3000 {
        let point = DVec3::from(sequence.point(i));
        let world = from_texture.transform_point3(point);
        assert_eq!(judge.contains(point), exact(&geometry, world), "{world}");
        let nearest = (0..geometry.triangle_count()).map(|t| squared_distance(geometry.positions(t), world).sqrt());
        let nearest = nearest.fold(f64::INFINITY, f64::min) / frame.side();
        assert!(judge.is_near(point, nearest * 1.001 + 1e-9) && !judge.is_near(point, nearest * 0.999));
        inside += usize::from(judge.contains(point));
    }
    assert!(inside > 100, "{inside}");
}

#[test]
fn solids_are_found_inside_and_outside() {
    let directions = [DVec3::NEG_Z, DVec3::new(0.3, -0.8, 0.5), DVec3::Y];
    let concave = together(&[
        cuboid([0.0; 3], [3.0, 1.0, 1.0]),
        // Shares no face with the first, touches it at an edge.
        cuboid([0.0, 1.0, 1.0], [1.0, 3.0, 2.0]),
    ]);
    let nested = together(&[cuboid([0.0; 3], [4.0; 3]), cuboid([1.0; 3], [3.0; 3]), cuboid([1.5; 3], [2.5; 3])]);
    for direction in directions {
        for scene in [scene(octahedron(2)), scene(cuboid([0.0; 3], [1.0, 2.0, 3.0])), concave.clone(), nested.clone()] {
            assert!(check(&scene, direction, 96) > 50);
        }
    }
}

#[test]
fn eighteen_layers() {
    let slabs: Vec<Mesh> = (0..9).map(|i| cuboid([0.0, 0.0, i as f32], [8.0, 8.0, i as f32 + 0.6])).collect();
    let scene = together(&slabs);
    assert!(check(&scene, DVec3::NEG_Z, 64) > 500);
    let image = run(&scene, DVec3::NEG_Z, 64, Repair::None).unwrap().image;
    assert_eq!(image.depth_complexity(), 18);
    let valid = |i: usize| image.layer(i).iter().filter(|d| **d < 1.0).count();
    assert_eq!((valid(0), valid(17)), (image.covered(), image.covered()));
    assert!(image.layer(18).iter().all(|d| *d == 1.0));
}

#[test]
fn equal_depths_are_kept() {
    // Twice the same box: strict peeling would keep one of each pair and call the inside of the box solid.
    let scene = together(&[cuboid([0.0; 3], [1.0; 3]), cuboid([0.0; 3], [1.0; 3])]);
    let image = run(&scene, DVec3::NEG_Z, 32, Repair::None).unwrap().image;
    assert_eq!(image.depth_complexity(), 4);
    assert!(!image.contains([0.5, 0.5, 0.5]));
}

#[test]
fn an_open_surface_is_reported_and_repaired() {
    let mut open = octahedron(2);
    let mut faces = open.triangles.to_vec();
    // The face nearest to the viewer on +Z.
    let height = |f: &[u32; 3]| f.iter().map(|i| open.positions[*i as usize][2]).sum::<f32>();
    let at = (0..faces.len()).max_by(|a, b| height(&faces[*a]).total_cmp(&height(&faces[*b]))).unwrap();
    faces.remove(at);
    open.triangles = faces.into();
    let scene = scene(open);
    assert_eq!(closedness(&Geometry::new(&scene)).open_edges, 3);
    let error = run(&scene, DVec3::NEG_Z, 128, Repair::None).unwrap_err();
    let PeelError::Open { odd } = &error else { panic!("{error}") };
    assert!(odd.len() > 10 && odd.iter().all(|o| o.crossings == 1), "{odd:?}");
    assert!(error.to_string().contains("not closed"), "{error}");
    let inside = |ray: &OddRay| [(ray.texel[0] as f32 + 0.5) / 128.0, (ray.texel[1] as f32 + 0.5) / 128.0, 0.5];
    for repair in [Repair::Drop, Repair::Pair] {
        let done = run(&scene, DVec3::NEG_Z, 128, repair).unwrap();
        assert_eq!(&done.odd, odd);
        assert!(odd.iter().all(|o| !done.image.contains(inside(o))));
        assert!(done.image.contains([0.3, 0.5, 0.5]));
    }
    // Seen from the side the ray through the hole enters twice or leaves twice: what remains in turn is kept.
    let side = run(&scene, DVec3::X, 128, Repair::Pair).unwrap();
    assert!(side.odd.iter().all(|o| o.crossings == 1 || o.crossings == 3) && side.image.contains([0.5, 0.5, 0.5]));
}

#[test]
fn nothing_is_an_error() {
    assert!(matches!(run(&Scene::default(), DVec3::Z, 8, Repair::None), Err(PeelError::Empty)));
    let point = scene(mesh(&[[1.0; 3]; 3], &[[0, 1, 2]]));
    assert!(matches!(run(&point, DVec3::Z, 8, Repair::None), Err(PeelError::Empty)));
    let flat = scene(mesh(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]));
    assert!(matches!(run(&flat, DVec3::X, 8, Repair::None), Err(PeelError::Missed(8))));
    assert!(matches!(run(&flat, DVec3::Z, 0, Repair::None), Err(PeelError::Resolution(0))));
}

#[test]
fn sizes_are_counted_as_in_table_1() {
    // A box fills its crop: raw is as small as can be, and the paper's layout twice as large and an index more.
    let image =
        run(&scene(cuboid([0.0; 3], [2.0, 1.0, 1.0])), DVec3::NEG_Z, 64, Repair::None).unwrap().image.crop().unwrap();
    assert_eq!(image.region(), Region { x: 0, y: 16, width: 64, height: 32 });
    let n = image.region().texels();
    let values = |layout| Packed::new(&image, layout).unwrap().values();
    assert_eq!((values(Layout::Raw), values(Layout::Ranges)), (2 * n, 4 * n));
    assert_eq!(Packed::smallest(&image, None).unwrap().layout(), Layout::Raw);
    // A ball: one run a row, and no depths in the corners.
    let ball = run(&scene(octahedron(5)), DVec3::new(0.2, 0.3, -1.0), 256, Repair::None).unwrap().image.crop().unwrap();
    let packed = Packed::smallest(&ball, None).unwrap();
    assert_eq!(packed.layout(), Layout::Runs);
    let ratio = packed.values() as f64 / (ball.region().texels() * 2) as f64;
    assert!((0.78..0.81).contains(&ratio), "{ratio}");
    let (side, texture) = Packed::new(&ball, Layout::Ranges).unwrap().texture().map(|(s, t)| (s, t.len())).unwrap();
    let filled = ball.region().texels() + ball.depths().len() / 2;
    assert!(texture == (side * side) as usize && filled <= texture && filled > ((side - 1) * (side - 1)) as usize);
}

fn image() -> impl Strategy<Value = LayeredDepthImage> {
    let ray = prop::collection::vec(0u16..1000, 0..5).prop_map(|mut cuts| {
        cuts.sort_unstable();
        cuts.truncate(cuts.len() / 2 * 2);
        cuts.iter().map(|c| f32::from(*c) / 1000.0).collect::<Vec<f32>>()
    });
    let ray = prop_oneof![2 => Just(Vec::new()), 3 => ray];
    (1u32..9, 1u32..9).prop_flat_map(move |(w, h)| {
        prop::collection::vec(ray.clone(), (w * h) as usize).prop_map(move |rays| LayeredDepthImage::new([w, h], rays))
    })
}

proptest! {
    #[test]
    fn unpacking_is_the_inverse_of_packing(image in image()) {
        for image in [Some(image.clone()), image.crop()].into_iter().flatten() {
            for layout in Layout::ALL {
                prop_assert_eq!(&Packed::new(&image, layout).unwrap().unpack(), &image, "{:?}", layout);
            }
        }
    }

    #[test]
    fn depths_of_16_bits_keep_their_bound(image in image(), squeeze in 0.001..1.0f32, points in prop::collection::vec((0.0..1.0f32, 0.0..1.0f32, 0.0..1.0f32), 30)) {
        prop_assume!(!image.depths().is_empty());
        // Solids that are flat along the rays, and as near to 1 as depths get.
        let most = 1.0 - f32::EPSILON / 2.0;
        let depths: Vec<f32> = image.depths().iter().map(|d| (1.0 - (1.0 - d) * squeeze).min(most)).collect();
        let image = LayeredDepthImage::from_parts(image.size(), image.region(), image.starts().to_vec(), depths).unwrap();
        let grid = DepthQuantizer::around(&image);
        prop_assert_eq!(DepthQuantizer::from_parts(grid.parts()), Some(grid));
        let packed = Packed::smallest(&image, Some(grid)).unwrap();
        let rounded = packed.unpack();
        prop_assert_eq!(rounded.starts(), image.starts());
        for (a, b) in rounded.depths().iter().zip(image.depths()) {
            prop_assert!(f64::from((a - b).abs()) <= grid.bound());
            // In the range of the depths no finer step of a power of two would do.
            prop_assert!(f64::from((a - b).abs()) <= grid.bound() * 0.5 || *b > 1.0 - grid.step());
        }
        let spread = image.depths().iter().fold(0.0f32, |m, d| m.max(*d)) - image.depths().iter().fold(1.0f32, |m, d| m.min(*d));
        prop_assert!(grid.step() <= 1.0 / 65536.0 && (grid.step() <= spread / 32000.0 || grid.parts()[0] == 23));
        for layout in [Layout::Rows, Layout::Runs] {
            let packed = Packed::short(&image, layout, grid).unwrap();
            prop_assert_eq!(&packed.unpack(), &rounded);
            for (s, t, r) in &points {
                prop_assert_eq!(packed.contains([*s, *t, *r]), rounded.contains([*s, *t, *r]));
            }
        }
        prop_assert_eq!(Packed::short(&image, Layout::Ranges, grid), None);
    }

    #[test]
    fn all_layouts_answer_as_the_definition(
        image in image(),
        points in prop::collection::vec((-50i32..1050, -50i32..1050, -2i32..1003), 90),
    ) {
        let cropped = image.crop();
        let many: Vec<[f32; 3]> = points.iter().map(|(s, t, r)| [*s, *t, *r].map(|c| c as f32 / 1000.0)).collect();
        for layout in Layout::ALL {
            let mut inside = vec![true; many.len()];
            Packed::new(&image, layout).unwrap().contain(&many, &mut inside);
            prop_assert_eq!(inside, many.iter().map(|p| image.contains(*p)).collect::<Vec<_>>(), "{:?}", layout);
        }
        for (s, t, r) in points {
            // Also exactly at the ends of ranges and at the borders of texels.
            let point = [s, t, r].map(|c| c as f32 / 1000.0);
            let [w, h] = image.size();
            let (x, y) = ((point[0] * w as f32).floor(), (point[1] * h as f32).floor());
            let hit = x >= 0.0 && y >= 0.0 && x < w as f32 && y < h as f32;
            // Figure 5 with the ends of ranges inside: a depth swaps the parity where the point lies beyond it.
            let expect = hit && {
                let ray = image.ray(y as usize * w as usize + x as usize);
                ray.iter().filter(|d| **d < point[2]).count() % 2 == 1 || ray.contains(&point[2])
            };
            prop_assert_eq!(image.contains(point), expect);
            if let Some(cropped) = &cropped {
                prop_assert_eq!(cropped.contains(point), expect);
                for layout in Layout::ALL {
                    prop_assert_eq!(Packed::new(cropped, layout).unwrap().contains(point), expect, "{:?}", layout);
                }
            }
        }
    }

    #[test]
    fn cropping_keeps_what_there_is_and_no_more(image in image()) {
        let Some(cropped) = image.crop() else {
            prop_assert!(image.depths().is_empty());
            return Ok(());
        };
        prop_assert_eq!(cropped.depths(), image.depths());
        let r = cropped.region();
        let filled = |x: u32, y: u32| !cropped.ray((y * r.width + x) as usize).is_empty();
        prop_assert!((0..r.width).any(|x| filled(x, 0)) && (0..r.width).any(|x| filled(x, r.height - 1)));
        prop_assert!((0..r.height).any(|y| filled(0, y)) && (0..r.height).any(|y| filled(r.width - 1, y)));
    }
}

#[test]
fn a_texel_of_several_rays_holds_what_half_of_them_hold() {
    let solid = together(&[octahedron(3), cuboid([-0.9, -0.5, -0.3], [0.2, 1.2, 0.6])]);
    let (geometry, direction) = (Geometry::new(&solid), Direction::new(DVec3::new(0.3, -0.4, -0.8)).unwrap());
    for samples in [2, 4, 3] {
        let how = Peeling { resolution: 90, samples, repair: Repair::None };
        let coarse = peel(&Cpu, &geometry, &direction, &how, &Stop::default()).unwrap().image;
        let how = Peeling { resolution: 90 * samples, samples: 1, repair: Repair::None };
        let fine = peel(&Cpu, &geometry, &direction, &how, &Stop::default()).unwrap().image;
        assert_eq!(coarse.size(), [90; 2]);
        let mut inside = 0;
        for i in 0..90 * 90 {
            for k in 0..40 {
                let z = k as f32 / 40.0 + 0.003;
                let rays = (0..samples * samples).filter(|j| {
                    let (x, y) = (i % 90 * samples + j % samples, i / 90 * samples + j / samples);
                    fine.ray((y * 90 * samples + x) as usize).chunks(2).any(|r| r[0] <= z && z <= r[1])
                });
                let expect = 2 * rays.count() as u32 >= samples * samples;
                let found = coarse.ray(i as usize).chunks(2).any(|r| r[0] <= z && z <= r[1]);
                assert_eq!(found, expect, "{samples}: texel {i}, depth {z}");
                inside += u32::from(found);
            }
        }
        assert!(inside > 10_000);
    }
    let how = Peeling { resolution: 8192, samples: 4, repair: Repair::None };
    let refused = peel(&Cpu, &geometry, &direction, &how, &Stop::default()).unwrap_err();
    assert!(refused.to_string().contains("32768 rays"), "{refused}");
}
