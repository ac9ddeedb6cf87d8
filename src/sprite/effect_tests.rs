//! What must hold of volumes: rays, zones, overlaps, and pictures with effects.

use super::{
    tests::{cuboid, run, together},
    *,
};
use crate::{
    image::{Picture, srgb},
    math::Stop,
    raster::{
        Cpu, Geometry, Light, Shader,
        tests::{object, octahedron, scene, square},
    },
    scene::{Material, Scene},
    view::View,
};
use glam::{DMat3, DVec3};
use proptest::prelude::*;

fn volume(scene: &Scene, forward: DVec3, resolution: u32, placement: &Placement) -> Volume {
    let peeled = run(scene, forward, resolution, Repair::None).unwrap();
    Volume::new(peeled.image.crop().unwrap(), &peeled.frame, placement)
}

/// An image of `n`² texels with up to two ranges each.
fn image(n: u32) -> impl Strategy<Value = LayeredDepthImage> {
    let ray = prop::collection::vec(0.0..0.99f32, 0..5).prop_map(|mut ray| {
        ray.sort_by(f32::total_cmp);
        ray.truncate(ray.len() / 2 * 2);
        ray
    });
    prop::collection::vec(ray, (n * n) as usize).prop_map(move |rays| LayeredDepthImage::new([n, n], rays))
}

fn vector() -> impl Strategy<Value = DVec3> {
    // Often along an axis of the texels.
    let c = || prop_oneof![3 => -2.0..2.0f64, 1 => Just(0.0)];
    [c(), c(), c()].prop_map(DVec3::from)
}

const FRAME: ([DVec3; 3], DVec3, f64) = ([DVec3::X, DVec3::Y, DVec3::NEG_Z], DVec3::new(0.3, -0.2, 0.1), 2.0);

proptest! {
    #[test]
    fn spans_are_where_points_of_the_ray_lie_inside(
        image in image(40), origin in vector(), direction in vector(), cropped in any::<bool>(),
    ) {
        prop_assume!(direction.length() > 0.1);
        let image = if cropped { image.crop().unwrap_or(image) } else { image };
        let frame = CubeFrame::from_parts(FRAME.0, FRAME.1, FRAME.2).unwrap();
        let volume = Volume::new(image, &frame, &Placement::default());
        let ray = Ray { origin, direction };
        let spans = volume.spans(&ray);
        prop_assert_eq!(volume.first(&ray), spans.first().copied());
        prop_assert_eq!(volume.enter(&ray), spans.first().map(|s| s.enter));
        prop_assert!(spans.windows(2).all(|s| s[0].exit < s[1].enter.t) && spans.iter().all(|s| s.enter.t < s.exit));
        for i in 0..600 {
            let t = f64::from(i) * 0.01;
            let p = volume.to_texture().transform_point3(ray.at(t));
            // Where a point's texel is not certain in 32 bits, or its depth is that of a range's end, either is right.
            let even = [p.x, p.y].iter().any(|c| (c * 40.0 - (c * 40.0).round()).abs() < 1e-4);
            let end = spans.iter().any(|s| (s.enter.t - t).abs() < 1e-5 || (s.exit - t).abs() < 1e-5);
            if !even && !end {
                let inside = spans.iter().any(|s| s.enter.t <= t && t <= s.exit);
                prop_assert_eq!(inside, volume.contains(ray.at(t)), "{} {}", t, p);
            }
        }
    }

    #[test]
    fn zones_count_corners(p in vector(), half in 0.0..0.5f64) {
        let solid = volume(&scene(octahedron(1)), DVec3::NEG_Z, 32, &Placement::default());
        let mut inside = 0;
        for (x, y, z) in [(-1, -1, -1), (1, -1, -1), (-1, 1, -1), (1, 1, -1), (-1, -1, 1), (1, -1, 1), (-1, 1, 1), (1, 1, 1)] {
            inside += u32::from(solid.contains(p + DVec3::new(x.into(), y.into(), z.into()) * half));
        }
        let expect = if inside == 0 { Zone::Outside } else if inside == 8 { Zone::Inside } else { Zone::Border };
        prop_assert_eq!(solid.zone(p, half), expect);
        if half == 0.0 {
            prop_assert!(expect != Zone::Border);
        }
    }

    #[test]
    fn a_placed_volume_holds_the_placed_points(p in vector(), at in vector(), scale in 0.1..9.0f64, angle in -3.0..3.0f64) {
        let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), angle);
        let solid = scene(octahedron(2));
        let still = volume(&solid, DVec3::new(0.3, 0.4, -0.9), 64, &Placement::default());
        let moved = volume(&solid, DVec3::new(0.3, 0.4, -0.9), 64, &Placement { centre: Some(at), scale, turn });
        let t = still.to_texture().transform_point3(p);
        // The solid's cube is around the origin.
        prop_assert!((moved.to_texture().transform_point3(at + turn * (p * scale)) - t).length() < 1e-9);
    }
}

#[test]
fn normals_of_a_sphere_point_outward() {
    let sphere = volume(&scene(octahedron(5)), DVec3::new(0.2, 0.5, -0.8), 256, &Placement::default());
    let mut seen = 0;
    for i in 0..400 {
        let (x, y) = (f64::from(i % 20) * 0.1 - 0.95, f64::from(i / 20) * 0.1 - 0.95);
        for (origin, direction) in [
            (DVec3::new(x, y, 4.0), DVec3::NEG_Z),
            (DVec3::new(-3.0, x, y), DVec3::X),
            (DVec3::new(x, 5.0, y), DVec3::NEG_Y),
        ] {
            let ray = Ray { origin, direction };
            let Some(entry) = sphere.enter(&ray) else {
                assert!(x * x + y * y > 0.94);
                continue;
            };
            let at = ray.at(entry.t);
            assert!((at.length() - 1.0).abs() < 0.03, "{at}");
            // 12°.
            let cosine = sphere.normal(&ray, &entry).dot(at.normalize());
            assert!(cosine > 0.978, "{cosine} at {at}");
            seen += 1;
        }
    }
    assert!(seen > 800);
}

#[test]
fn boxes_share_what_their_bounds_share() {
    let of = |low, high, forward| volume(&scene(cuboid(low, high)), forward, 200, &Placement::default());
    let a = of([0.0; 3], [2.0; 3], DVec3::NEG_Z);
    for forward in [DVec3::NEG_Z, DVec3::X, DVec3::new(0.3, -0.7, 0.5)] {
        let b = of([1.0, 0.5, 1.5], [4.0, 1.5, 5.0], forward);
        for shared in [overlap(&a, &b, &Stop::default()).unwrap(), overlap(&b, &a, &Stop::default()).unwrap()] {
            assert!(shared.collides() && (shared.volume - 0.5).abs() < 0.03, "{shared:?}");
            assert!((shared.bounds.min - DVec3::new(1.0, 0.5, 1.5)).abs().max_element() < 0.04, "{shared:?}");
            assert!((shared.bounds.max - DVec3::new(2.0, 1.5, 2.0)).abs().max_element() < 0.04, "{shared:?}");
        }
        let apart = of([2.1, 0.0, 0.0], [4.0, 1.0, 1.0], forward);
        let none = overlap(&a, &apart, &Stop::default()).unwrap();
        assert!(!none.collides() && none.volume == 0.0 && none.bounds.is_empty());
    }
    // What is hollow holds nothing in its hollow.
    let shell = volume(
        &together(&[cuboid([-1.0; 3], [3.0; 3]), cuboid([-0.5; 3], [2.5; 3])]),
        DVec3::X,
        100,
        &Placement::default(),
    );
    assert!(!overlap(&a, &shell, &Stop::default()).unwrap().collides());
    let stop = Stop::default();
    stop.set();
    assert!(overlap(&a, &shell, &stop).is_err());
}

/// Two squares one behind the other, white and green, seen along −Z in 40×40 pixels: they cover −1 to 1 of −2 to 2.
struct Stage {
    scene: Scene,
    view: View,
    volumes: Vec<Volume>,
}

impl Stage {
    fn new() -> Self {
        let paint = |base_color: [f32; 4]| Material { base_color, unlit: true, ..Material::default() };
        let mut back = object("back", square(), paint([0.0, 1.0, 0.0, 1.0]));
        back.transform = glam::Mat4::from_translation(glam::Vec3::new(0.0, 0.0, -1.0));
        let scene = Scene { objects: vec![back, object("front", square(), paint([1.0; 4]))] };
        let mut view = View::look_at(DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y, 1.0, 40, 40, 0.1, 20.0);
        view.projection = crate::view::Projection::Orthographic { left: -2.0, right: 2.0, bottom: -2.0, top: 2.0 };
        // Left and lower half of the front square, with a common quarter; behind it.
        let of = |mesh| volume(&super::super::raster::tests::scene(mesh), DVec3::NEG_Z, 80, &Placement::default());
        let volumes = vec![
            of(cuboid([-1.5, -1.5, -0.5], [0.0, 1.5, 0.5])),
            of(cuboid([-1.5, -1.5, -0.5], [1.5, 0.0, 0.5])),
            of(cuboid([-0.5, -0.5, -0.7], [0.5, 0.5, -0.3])),
        ];
        Self { scene, view, volumes }
    }

    fn draw(&self, effects: &[Effect], solids: &[Solid], samples: u32) -> Picture {
        let geometry = Geometry::new(&self.scene);
        let names: Vec<String> = ["left", "low", "middle"].map(String::from).to_vec();
        let drawing = Drawing {
            volumes: &self.volumes,
            names: &names,
            effects,
            solids,
            light: Light { sun: [0.0; 3], sky: [1.0; 3], ground: [1.0; 3], ..Light::default() },
            background: [0.0, 0.0, 1.0],
            samples,
        };
        draw(&Cpu, &Shader::new(&geometry), &self.scene.objects, &self.view, &drawing, &Stop::default()).unwrap()
    }
}

/// The pixel at a place of the plane.
fn at(picture: &Picture, x: f64, y: f64) -> [u8; 3] {
    let (px, py) = ((x + 2.0) * 10.0, (2.0 - y) * 10.0);
    let [r, g, b, _] = picture.texels[py as usize * 40 + px as usize];
    [r, g, b]
}

const WHITE: [u8; 3] = [255; 3];
const GREEN: [u8; 3] = [0, 255, 0];
const BLUE: [u8; 3] = [0, 0, 255];
const RED: [u8; 3] = [255, 0, 0];

fn effect(volume: usize, zone: Zone, border: f64, objects: &str, style: Style) -> Effect {
    Effect { volume, zone, border, objects: objects.into(), style }
}

#[test]
fn clipping_shows_what_lies_behind() {
    let stage = Stage::new();
    let plain = stage.draw(&[], &[], 2);
    let hide = |v| effect(v, Zone::Inside, 0.0, "*", Style::Hide);
    let both = stage.draw(&[hide(0), hide(1)], &[], 2);
    for (x, y) in [(-0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)] {
        assert_eq!((at(&plain, x, y), at(&both, x, y)), (WHITE, GREEN), "{x} {y}");
    }
    assert_eq!((at(&both, 0.5, 0.5), at(&both, 1.5, 0.0)), (WHITE, BLUE));
    // Effects by object: nothing hides the one behind, and what hides all of it shows the background.
    assert_eq!(stage.draw(&[effect(0, Zone::Inside, 0.0, "back", Style::Hide)], &[], 2), plain);
    let outside = stage.draw(&[effect(0, Zone::Outside, 0.0, "*", Style::Hide)], &[], 1);
    assert_eq!((at(&outside, -0.5, 0.0), at(&outside, 0.5, 0.0)), (WHITE, BLUE));
}

#[test]
fn effects_of_volumes_that_intersect_add_up() {
    let stage = Stage::new();
    let red = effect(0, Zone::Inside, 0.0, "*", Style::Flat([1.0, 0.0, 0.0]));
    let tint = effect(1, Zone::Inside, 0.0, "*", Style::Tint([0.0; 3]));
    let picture = stage.draw(&[red, tint], &[], 1);
    let half = srgb::from_linear(0.5);
    assert_eq!(at(&picture, 0.5, 0.5), WHITE);
    assert_eq!(at(&picture, -0.5, 0.5), RED);
    assert_eq!(at(&picture, 0.5, -0.5), [half; 3]);
    assert_eq!(at(&picture, -0.5, -0.5), [half, 0, 0]);
    let gray = stage.draw(&[effect(2, Zone::Outside, 0.0, "back", Style::Gray([1.0; 3]))], &[], 1);
    assert_eq!(at(&gray, 0.5, 0.5), WHITE);
}

#[test]
fn borders_are_as_wide_as_the_cube() {
    let stage = Stage::new();
    let border = effect(0, Zone::Border, 0.2, "*", Style::Flat([1.0, 0.0, 0.0]));
    let picture = stage.draw(&[border], &[], 1);
    // The volume ends at x = 0.
    for (x, expect) in [(-0.35, WHITE), (-0.25, WHITE), (-0.15, RED), (-0.05, RED), (0.15, RED), (0.25, WHITE)] {
        assert_eq!(at(&picture, x, 0.0), expect, "{x}");
    }
}

#[test]
fn solids_lie_where_their_depths_say() {
    let stage = Stage::new();
    let solid = |volume, opacity| Solid { volume, color: [1.0, 0.0, 0.0], opacity };
    // The middle one lies between the squares; the left one reaches in front of both.
    let behind = stage.draw(&[], &[solid(2, 1.0)], 1);
    assert_eq!(at(&behind, 0.2, 0.2), WHITE);
    let open = stage.draw(&[effect(1, Zone::Inside, 0.0, "front", Style::Hide)], &[solid(2, 1.0)], 1);
    assert_eq!((at(&open, 0.2, -0.2), at(&open, 0.7, -0.7)), (RED, GREEN));
    let glass = stage.draw(&[], &[solid(0, 0.5)], 1);
    let half = srgb::from_linear(0.5);
    assert_eq!(
        (at(&glass, -0.5, 0.5), at(&glass, -1.2, 0.5), at(&glass, 0.5, 0.5)),
        ([255, half, half], [half, 0, half], WHITE)
    );
    // What happens inside a volume does not happen to its own surface.
    let own = effect(0, Zone::Inside, 0.0, "*", Style::Hide);
    assert_eq!(at(&stage.draw(&[own], &[solid(0, 1.0)], 1), -0.5, 0.5), RED);
    // A solid that is clipped shows its cut.
    let cut = effect(1, Zone::Inside, 0.0, "left", Style::Hide);
    let clipped = stage.draw(&[cut], &[solid(0, 1.0)], 1);
    assert_eq!((at(&clipped, -0.5, 0.5), at(&clipped, -0.5, -0.5)), (RED, WHITE));
}

#[test]
fn lines_and_tiles() {
    let stage = Stage::new();
    let lines = effect(0, Zone::Inside, 0.0, "*", Style::Lines([1.0, 0.0, 0.0]));
    let picture = stage.draw(&[lines], &[], 1);
    assert_eq!((at(&picture, -0.95, 0.5), at(&picture, -0.5, 0.2)), (RED, GREEN));
    // Tiles of 63 samples are not cut in pixels.
    let three = stage.draw(&[], &[], 3);
    let one = stage.draw(&[], &[], 1);
    assert_eq!(three, one);
}
