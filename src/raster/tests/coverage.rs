//! What must hold of coverage whatever the scene: nothing missed, nothing twice, nothing that depends on threads.

use super::*;
use crate::{
    scene::{Alpha, Image, Texture, Wrap},
    view::Projection,
};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn a_closed_mesh_is_entered_as_often_as_left(
        shifts in prop::collection::vec(prop::array::uniform3(-0.3f32..0.3), 66),
        eye in prop::array::uniform3(-1.0f64..1.0),
        orthographic in any::<bool>(),
    ) {
        let m = octahedron(2);
        let moved: Vec<[f32; 3]> =
            m.positions.iter().zip(&shifts).map(|(p, s)| std::array::from_fn(|k| p[k] + s[k])).collect();
        let scene = scene(mesh(&moved, &m.triangles));
        let eye = DVec3::from(eye).try_normalize().unwrap_or(DVec3::X) * 3.0;
        let mut view = View::look_at(eye, DVec3::ZERO, DVec3::Y, 0.9, 100, 90, 0.01, 10.0);
        if orthographic {
            view.projection = Projection::Orthographic { left: -2.0, right: 2.0, bottom: -2.0, top: 2.0 };
        }
        let f = all(&scene, &view);
        prop_assert!(f.fragments.len() > 1000);
        for y in 0..90 {
            for x in 0..100 {
                prop_assert_eq!(f.of(x, y).len() % 2, 0, "pixel {}, {}", x, y);
            }
        }
    }

    #[test]
    fn a_triangulated_plane_covers_each_pixel_once(
        shifts in prop::collection::vec(prop::array::uniform2(-0.24f32..0.24), 49),
        diagonals in prop::collection::vec(any::<bool>(), 36),
        tilt in prop::array::uniform2(-0.1f32..0.1),
        size in (1u32..130, 1u32..130),
    ) {
        let side = 7u32;
        let points: Vec<[f32; 3]> = (0..side * side).map(|i| {
            let (x, y) = ((i % side) as f32 - 3.0, (i / side) as f32 - 3.0);
            // The border stays outside the view.
            let inner = x.abs() < 3.0 && y.abs() < 3.0;
            let s = if inner { shifts[i as usize] } else { [x * 2.0, y * 2.0] };
            let (x, y) = (x + s[0], y + s[1]);
            [x, y, -3.0 + tilt[0] * x + tilt[1] * y]
        }).collect();
        let faces: Vec<[u32; 3]> = (0..36).flat_map(|q| {
            let a = q / 6 * side + q % 6;
            let (b, c, d) = (a + 1, a + side + 1, a + side);
            if diagonals[q as usize] { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
        }).collect();
        let view = View {
            eye: DVec3::ZERO,
            projection: Projection::Perspective { left: -0.8, right: 0.8, bottom: -0.8, top: 0.8 },
            ..ahead(1.0, size.0, size.1)
        };
        let f = all(&scene(mesh(&points, &faces)), &view);
        let once = f.offsets.iter().enumerate().all(|(i, o)| *o == i as u64);
        prop_assert!(once);
    }
}

/// What a view shows does not depend on the threads, and `nearest` is the first of all surfaces.
#[test]
fn any_number_of_threads() {
    let scene = scene(octahedron(5));
    let view = ahead(1.7, 200, 150);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| (first(&scene, &view), all(&scene, &view)))
    };
    let (near, every) = run(1);
    assert_eq!((near.clone(), every.clone()), run(3));
    for (i, t) in near.triangle.iter().enumerate() {
        let (x, y) = (i as u32 % view.width, i as u32 / view.width);
        let f = every.of(x, y).first();
        assert_eq!(f.map_or(NOTHING, |f| f.triangle), *t);
        assert_eq!(f.map_or(f32::INFINITY, |f| f.depth), near.depth[i]);
    }
    assert!(near.triangle.contains(&NOTHING) && near.triangle.iter().any(|t| *t != NOTHING));
}

#[test]
fn tiles_come_in_order_and_agree_with_the_whole() {
    let scene = scene(octahedron(3));
    let view = ahead(1.5, 150, 140);
    let geometry = Geometry::new(&scene);
    let (options, stop) = (Options::default(), Stop::default());
    let whole = all(&scene, &view);
    let prepared = Prepared::new(&geometry, &view, &options, &stop).unwrap();
    let tiles = fragments_in_tiles(&Cpu, &prepared, &stop, |tile, f| {
        for i in 0..tile.pixels() {
            let (x, y) = tile.pixel(i);
            assert_eq!(f.of(i), whole.of(x, y));
        }
        tile.index
    });
    assert_eq!(tiles.unwrap(), (0..9).collect::<Vec<_>>());
}

#[test]
fn a_stop_is_heeded() {
    let stop = Stop::default();
    stop.set();
    let scene = scene(octahedron(1));
    let geometry = Geometry::new(&scene);
    assert!(nearest(&Cpu, &geometry, &ahead(2.0, 8, 8), &Options::default(), &stop).is_err());
}

#[test]
fn nothing_to_see() {
    let empty = Scene::default();
    assert_eq!(first(&empty, &ahead(2.0, 3, 2)).triangle, [NOTHING; 6]);
    let behind = View { eye: DVec3::new(0.0, 0.0, -5.0), ..ahead(1.0, 8, 8) };
    assert!(all(&scene(octahedron(1)), &behind).fragments.is_empty());
    assert!(first(&scene(octahedron(1)), &View { width: 0, ..ahead(2.0, 8, 5) }).triangle.is_empty());
    let broken = mesh(&[[f32::NAN; 3], [f32::INFINITY, 0.0, 0.0], [0.0; 3]], &[[0, 1, 2], [2, 1, 0], [2, 2, 2]]);
    assert!(all(&scene(broken), &ahead(2.0, 20, 20)).fragments.is_empty());
}

#[test]
fn equal_depths_are_ordered_by_number() {
    let objects = ["a", "b", "c"].map(|n| object(n, square(), Material::default()));
    let f = all(&Scene { objects: objects.to_vec() }, &ahead(2.0, 32, 32));
    let middle = f.of(12, 16);
    assert_eq!(middle.len(), 3);
    assert!(middle.windows(2).all(|p| p[0].triangle < p[1].triangle && p[0].depth == p[1].depth));
}

#[test]
fn instances_share_numbers_in_order() {
    let shared = object("a", octahedron(1), Material { double_sided: false, ..Material::default() });
    let mut other = shared.clone();
    other.name = "b".to_owned();
    other.transform = Mat4::from_translation(Vec3::new(0.0, 0.0, -3.0)) * Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let scene = Scene { objects: vec![shared, other] };
    let geometry = Geometry::new(&scene);
    assert_eq!(geometry.triangle_count(), 64);
    assert_eq!(geometry.locate(40), TriangleOrigin { object: 1, part: 0, triangle: 8 });
    assert_eq!((geometry.object_of(31), geometry.object_of(32), geometry.part_of(63)), (0, 1, 0));
    // A mirrored instance keeps its faces outward.
    for t in 0..64 {
        let [a, b, c] = geometry.positions(t);
        let centre = DVec3::new(0.0, 0.0, if t < 32 { 0.0 } else { -3.0 });
        assert!((b - a).cross(c - a).dot(a - centre) > 0.0, "{t}");
    }
    let middle = fragments(&Cpu, &geometry, &ahead(4.0, 33, 33), &Options::BOTH, &Stop::default()).unwrap();
    let middle = middle.of(16, 16).to_vec();
    assert_eq!(middle.iter().map(|f| f.triangle / 32).collect::<Vec<_>>(), [0, 0, 1, 1]);
    let cull = Options { sides: Sides::Facing };
    let front = fragments(&Cpu, &geometry, &ahead(4.0, 33, 33), &cull, &Stop::default()).unwrap();
    assert_eq!(front.of(16, 16).iter().map(|f| f.triangle / 32).collect::<Vec<_>>(), [0, 1]);
    assert!(front.of(16, 16)[0].depth < 3.5);
}

/// A texture of two texels: the left one is a hole.
#[test]
fn backs_of_single_sided_materials_are_asked_for() {
    let single = || Material { double_sided: false, ..Material::default() };
    let mut near = object("near", square(), single());
    let far = object("far", square(), Material::default());
    let count = |near: &Object, options: &Options| {
        let mut far = far.clone();
        far.transform = Mat4::from_translation(Vec3::new(0.0, 0.0, -1.0));
        let geometry = Geometry::new(&Scene { objects: vec![far, near.clone()] });
        fragments(&Cpu, &geometry, &ahead(2.0, 9, 9), options, &Stop::default()).unwrap().of(4, 4).len()
    };
    assert_eq!(count(&near, &Options::default()), 2);
    // Mirrored from left to right it still faces the eye.
    near.transform = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    assert_eq!(count(&near, &Options::default()), 2);
    // Turned round, or mirrored from front to back, it shows its back.
    for turn in [Mat4::from_rotation_y(std::f32::consts::PI), Mat4::from_scale(Vec3::new(1.0, 1.0, -1.0))] {
        near.transform = turn;
        assert_eq!(count(&near, &Options::default()), 1);
        assert_eq!(count(&near, &Options::BOTH), 2);
        // Of points around the eye none sees the front; one behind it does.
        let mut points = [DVec3::new(0.0, 0.0, 2.0); 8];
        assert_eq!(count(&near, &Options { sides: Sides::FacingAny(points) }), 1);
        points[5].z = -1.0;
        assert_eq!(count(&near, &Options { sides: Sides::FacingAny(points) }), 2);
        let both = Object { parts: object("", square(), Material::default()).parts, ..near.clone() };
        assert_eq!(count(&both, &Options::default()), 2);
    }
}

fn half_hole(alpha: Alpha, smooth: bool) -> Material {
    let image = Image { name: String::new(), width: 2, height: 1, texels: vec![[9, 9, 9, 0], [9, 9, 9, 255]].into() };
    let texture = Texture {
        image: Arc::new(image),
        uv_set: 0,
        offset: [0.0; 2],
        rotation: 0.0,
        scale: [1.0; 2],
        wrap: [Wrap::Clamp; 2],
        smooth,
    };
    Material { base_color_texture: Some(texture), alpha, ..Material::default() }
}

#[test]
fn alpha_below_the_cutoff_is_a_hole() {
    let view = ahead(1.0, 64, 64);
    for (alpha, smooth, expect) in [
        (Alpha::Opaque, false, 64),
        (Alpha::Mask { cutoff: 0.5 }, false, 32),
        (Alpha::Blend, true, 32),
        (Alpha::Mask { cutoff: 0.25 }, true, 40),
        (Alpha::Mask { cutoff: 0.0 }, true, 64),
        (Alpha::Mask { cutoff: 1.5 }, true, 0),
    ] {
        let scene = Scene { objects: vec![object("a", square(), half_hole(alpha, smooth))] };
        let near = first(&scene, &view);
        let row = |y: usize| near.triangle[y * 64..][..64].iter().filter(|t| **t != NOTHING).count();
        assert_eq!(row(20), expect, "{alpha:?}");
        assert_eq!(all(&scene, &view).fragments.len(), expect * 64, "{alpha:?}");
        assert_eq!(near.triangle[20 * 64] == NOTHING, expect < 64, "{alpha:?}");
    }
}

#[test]
fn vertex_alpha_counts() {
    let mut m = square();
    m.colors = [0.0, 1.0, 1.0, 0.0].map(|a| [1.0, 1.0, 1.0, a]).to_vec().into();
    let scene = Scene { objects: vec![object("a", m, Material { alpha: Alpha::Blend, ..Material::default() })] };
    assert_eq!(all(&scene, &ahead(1.0, 64, 64)).fragments.len(), 32 * 64);
}
