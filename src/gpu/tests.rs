//! Parity of the two back ends, and validation of the shaders.

use super::{machine, work, *};
use crate::{
    math::Stop,
    raster::{
        Backend, Cpu, Geometry, NOTHING, Options, Prepared, coverage, fragments_in_tiles, nearest_in_tiles,
        tests::{ahead, literal, mesh, object, square},
    },
    scene::{Alpha, Image, Material, Scene, Texture, Wrap, builtin},
    sprite::{DepthQuantizer, Direction, Layout, Packed, Peeling, Placement, Ray, Repair, Volume, peel},
    view::Cell,
    view::{Projection, View},
    voxel::{
        frusta::{Lens, frame},
        slicing::{Fineness, Soup, slice},
    },
};
use glam::{DVec3, Mat4, Vec3};
use proptest::prelude::*;
use std::sync::{Arc, OnceLock};

const MEMORY: u64 = 256 << 20;

/// The first adapter with so much memory; `None`, after saying so, where there is none and `FARFIELD_REQUIRE_GPU` does not ask
/// for one.
fn open(memory: u64) -> Option<Gpu> {
    match Gpu::open(Wanted::Any, memory) {
        Ok(gpu) => Some(gpu),
        Err(e) if std::env::var_os("FARFIELD_REQUIRE_GPU").is_none_or(|v| v.is_empty() || v == "0") => {
            eprintln!("skipped: {e}");
            None
        }
        Err(e) => panic!("FARFIELD_REQUIRE_GPU is set, but {e}"),
    }
}

/// One device for all tests.
pub(super) fn gpu() -> Option<&'static Gpu> {
    static GPU: OnceLock<Option<Gpu>> = OnceLock::new();
    GPU.get_or_init(|| open(MEMORY)).as_ref()
}

/// Asserts that a struct of a shader has the members, offsets and size of its twin.
macro_rules! same_layout {
    ($module:expr, $name:literal, $ty:ty, $($field:ident),* $(,)?) => {
        let members = vec![$((stringify!($field).to_owned(), std::mem::offset_of!($ty, $field))),*];
        assert_eq!($crate::gpu::tests::layout($module, $name), (members, size_of::<$ty>()), $name);
    };
}
pub(super) use same_layout;

/// Names and offsets of a struct's members, and its size.
pub(in crate::gpu) fn layout(module: &wgpu::naga::Module, name: &str) -> (Vec<(String, usize)>, usize) {
    let (_, ty) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name)).unwrap();
    let wgpu::naga::TypeInner::Struct { members, span } = &ty.inner else { panic!("{name} is no struct") };
    let members = members.iter().map(|m| (m.name.clone().unwrap(), m.offset as usize)).collect();
    (members, *span as usize)
}

#[test]
fn shaders_are_valid_and_share_the_structs() {
    use wgpu::naga::{front::wgsl, valid};
    let classify = machine::classify_source();
    let probe = machine::probe_source();
    for source in [machine::NEAREST, machine::FRAGMENTS, &classify, &probe] {
        let module = wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)));
        valid::Validator::new(valid::ValidationFlags::all(), valid::Capabilities::default()).validate(&module).unwrap();
        if source == classify || source == probe {
            same_layout!(
                &module,
                "Sprite",
                machine::Sprite,
                world_to_texture,
                region,
                sections,
                size,
                packing,
                depth_complexity,
                depth_base,
                depth_step
            );
            continue;
        }
        same_layout!(&module, "Triangle", work::Triangle, corners, first, a, b, c, low, high, exponent, padding);
        same_layout!(&module, "Item", work::Item, triangle, tile);
        same_layout!(
            &module,
            "Frame",
            work::Frame,
            width,
            height,
            first_row,
            columns,
            side,
            items,
            base,
            perspective,
            round
        );
    }
}

/// What tiles see, and their fragments as bits.
type Everything = (Vec<(Vec<u32>, Vec<u32>)>, Vec<(Vec<u32>, Vec<(u32, u32)>)>);

fn everything(backend: &dyn Backend, prepared: &Prepared) -> Everything {
    let stop = Stop::default();
    let bits = |z: &[f32]| z.iter().map(|z| z.to_bits()).collect::<Vec<_>>();
    let near = nearest_in_tiles(backend, prepared, &stop, |_, z, t| (bits(z), t.to_vec())).unwrap();
    let all = fragments_in_tiles(backend, prepared, &stop, |_, f| {
        (f.offsets.clone(), f.fragments.iter().map(|f| (f.triangle, f.depth.to_bits())).collect())
    });
    (near, all.unwrap())
}

/// Both operations give the same on both back ends, bit for bit; how many pixels see something.
fn same(scene: &Scene, view: &View, gpu: &Gpu) -> usize {
    let geometry = Geometry::new(scene);
    let prepared = Prepared::new(&geometry, view, &Options::default(), &Stop::default()).unwrap();
    let (cpu, other) = (everything(&Cpu, &prepared), everything(gpu, &prepared));
    assert!(cpu.0 == other.0, "nearest surfaces differ");
    assert!(cpu.1 == other.1, "fragments differ");
    assert_eq!(gpu.warnings(), Vec::<String>::new(), "the CPU must not have taken over");
    cpu.0.iter().flat_map(|(_, t)| t).filter(|t| **t != NOTHING).count()
}

fn around(scene: &Scene, distance: f64, side: u32) -> Vec<View> {
    let bounds = scene.bounds();
    let (centre, radius) = (bounds.centre(), bounds.min.distance(bounds.max) * 0.5);
    [DVec3::Z, DVec3::new(1.0, 0.4, 0.3), DVec3::new(-0.3, 1.0, 0.01), DVec3::new(-1.0, -0.2, -1.0)]
        .map(|d| {
            let eye = centre + d.normalize() * radius * distance;
            View::look_at(eye, centre, DVec3::Y, 0.8, side, side * 3 / 4, radius * 1e-3, radius * (distance + 2.0))
        })
        .to_vec()
}

#[test]
fn parity_on_the_built_in_scenes() {
    let Some(gpu) = gpu() else { return };
    let before = gpu.undecided();
    let mut tiles = 0;
    for name in ["car", "solids", "city"] {
        let scene = builtin::make(name, 1).unwrap();
        // From outside, and from among the objects, where triangles cross the near plane.
        for distance in [2.5, 0.3] {
            let seen: usize = around(&scene, distance, 200).iter().map(|view| same(&scene, view, gpu)).sum();
            assert!(seen > 1000, "{name} {distance}");
            tiles += 4 * 12;
            for view in around(&scene, distance, 200) {
                let geometry = Geometry::new(&scene);
                let prepared = Prepared::new(&geometry, &view, &Options::default(), &Stop::default()).unwrap();
                let known = prepared.triangles().filter(|t| work::Triangle::new(t, &prepared).is_some()).count();
                assert!(known * 10 >= prepared.triangles().count() * 9, "shaders decide on nearly all triangles");
            }
        }
    }
    let undecided = gpu.undecided() - before;
    assert!(undecided * 3 < tiles, "shaders decide on most tiles: {undecided} of {tiles} are left");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Shared edges, slivers, coplanar and huge faces, faces through the eye; both projections.
    #[test]
    fn parity_on_soups(scene in literal::soup(), view in literal::any_view()) {
        if let Some(gpu) = gpu() {
            same(&scene, &view, gpu);
        }
    }
}

#[test]
fn parity_of_coverage() {
    let Some(gpu) = gpu() else { return };
    let scene = builtin::make("solids", 1).unwrap();
    let geometry = Geometry::new(&scene);
    let run = |backend: &dyn Backend| {
        let views = around(&scene, 2.0, 160);
        coverage(backend, &geometry, &views, &Options::default(), &Stop::default(), |_, c| c.clone()).unwrap()
    };
    let found = run(gpu);
    assert!(found == run(&Cpu) && found.len() == 4 && found[3].pixels.iter().sum::<u32>() > 1000);
}

#[test]
fn parity_of_faces_in_one_plane() {
    let Some(gpu) = gpu() else { return };
    // The same square, cut along either diagonal, moved within its plane, tilted, twice the same.
    let tilt = Mat4::from_rotation_y(0.7) * Mat4::from_rotation_x(0.4);
    let mut other = square();
    other.triangles = vec![[0, 1, 3], [1, 2, 3]].into();
    let scene = Scene {
        objects: (0..12)
            .map(|i| {
                let shift = Vec3::new(0.01 * (i / 3) as f32, 0.013 * (i / 2) as f32, 0.0);
                let m = if i % 2 == 0 { square() } else { other.clone() };
                let mut o = object(&format!("{i:02}"), m, Material::default());
                o.transform = tilt * Mat4::from_translation(shift);
                o
            })
            .collect(),
    };
    assert!(same(&scene, &ahead(2.0, 150, 130), gpu) > 2000);
}

#[test]
fn parity_of_what_lies_behind_an_orthographic_eye() {
    let Some(gpu) = gpu() else { return };
    // Two tilted squares that cross, and one at depth 0 exactly.
    let objects = [0.6f32, -0.5, 0.0].map(|turn| {
        let mut o = object(&format!("{turn}"), square(), Material::default());
        let away = if turn == 0.0 { 0.0 } else { 2.5 };
        o.transform = Mat4::from_translation(Vec3::new(0.0, 0.0, away)) * Mat4::from_rotation_y(turn);
        o
    });
    let scene = Scene { objects: objects.into() };
    let projection = Projection::Orthographic { left: -1.2, right: 1.2, bottom: -1.0, top: 1.0 };
    // Depths of the tilted ones: −3.4 to −1.6.
    let view = View { eye: DVec3::ZERO, near: -9.0, far: 9.0, projection, ..ahead(1.0, 170, 150) };
    assert!(same(&scene, &view, gpu) > 10_000);
}

#[test]
fn parity_at_the_horizon() {
    let Some(gpu) = gpu() else { return };
    // Ground that ends far away: between its last sample and its end its plane passes the horizon.
    let e = 4e6f32;
    let ground = mesh(&[[-e, -1.0, 5.0], [e, -1.0, 5.0], [e, -1.0, -e], [-e, -1.0, -e]], &[[0, 1, 2], [0, 2, 3]]);
    let mut wall = object("wall", square(), Material::default());
    wall.transform = Mat4::from_translation(Vec3::new(0.0, 0.0, -40.0)) * Mat4::from_scale(Vec3::splat(3.0));
    for near in [0.1, 1e-3] {
        let scene = Scene { objects: vec![object("ground", ground.clone(), Material::default()), wall.clone()] };
        let view = View { eye: DVec3::ZERO, near, far: 1e9, ..ahead(1.0, 150, 151) };
        assert!(same(&scene, &view, gpu) > 10_000);
    }
}

#[test]
fn parity_of_huge_and_tiny_faces() {
    let Some(gpu) = gpu() else { return };
    let e = 1e30f32;
    let mut points = vec![[-e, -0.5, -e], [e, -0.5, -e], [0.0, -0.5, e], [0.0, e, -3.0], [f32::MAX, f32::MAX, -2.0]];
    let mut faces = vec![[0, 1, 2], [0, 3, 1], [2, 3, 4], [0, 2, 4]];
    for i in 0..3000u32 {
        let (x, y) = ((i % 60) as f32 * 0.013 - 0.4, (i / 60) as f32 * 0.011 - 0.3);
        let first = points.len() as u32;
        points.extend([[x, y, -1.0], [x + 0.001, y, -1.0], [x, y + 0.002, -1.001]]);
        faces.push([first, first + 1, first + 2]);
    }
    let scene = crate::raster::tests::scene(mesh(&points, &faces));
    let view = View { eye: DVec3::ZERO, far: f64::INFINITY, ..ahead(1.0, 200, 170) };
    assert!(same(&scene, &view, gpu) > 10_000);
    let projection = Projection::Orthographic { left: -0.05, right: 0.05, bottom: -0.04, top: 0.04 };
    let view = View { near: -5.0, far: 50.0, projection, ..view };
    assert!(same(&scene, &view, gpu) > 200);
}

#[test]
fn parity_of_materials_with_holes() {
    let Some(gpu) = gpu() else { return };
    let texels: Vec<[u8; 4]> = (0..64u32).map(|i| [200, 90, 30, (i * 37 % 256) as u8]).collect();
    let texture = Texture {
        image: Arc::new(Image { name: String::new(), width: 8, height: 8, texels: texels.into() }),
        uv_set: 0,
        offset: [0.0; 2],
        rotation: 0.0,
        scale: [3.0; 2],
        wrap: [Wrap::Repeat; 2],
        smooth: true,
    };
    let leaf =
        Material { base_color_texture: Some(texture), alpha: Alpha::Mask { cutoff: 0.5 }, ..Material::default() };
    let mut objects: Vec<_> = (0..4)
        .map(|i| {
            let mut o = object(&format!("leaf {i}"), square(), leaf.clone());
            o.transform = Mat4::from_translation(Vec3::new(0.1, 0.0, 0.2)) * Mat4::from_rotation_y(0.4 * i as f32);
            o
        })
        .collect();
    objects.push(object("wall", square(), Material::default()));
    assert!(same(&Scene { objects }, &ahead(2.0, 190, 140), gpu) > 5000);
}

#[test]
fn parity_of_eight_million_fragments() {
    let Some(gpu) = gpu() else { return };
    // 2,000 squares behind each other, each over 64×64 pixels.
    let points: Vec<[f32; 3]> = (0..2000)
        .flat_map(|i| {
            let z = -1.0 - i as f32 * 1e-3;
            [[-4.0, -4.0, z], [4.0, -4.0, z], [4.0, 4.0, z], [-4.0, 4.0, z]]
        })
        .collect();
    let faces: Vec<[u32; 3]> =
        (0..2000).flat_map(|i| [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]]).collect();
    let scene = crate::raster::tests::scene(mesh(&points, &faces));
    let view = View { eye: DVec3::ZERO, ..ahead(1.0, 64, 64) };
    let geometry = Geometry::new(&scene);
    let prepared = Prepared::new(&geometry, &view, &Options::default(), &Stop::default()).unwrap();
    let count = |backend: &dyn Backend| {
        let lists = fragments_in_tiles(backend, &prepared, &Stop::default(), |_, f| f.fragments.clone());
        lists.unwrap().concat()
    };
    let (cpu, other) = (count(&Cpu), count(gpu));
    assert_eq!(cpu.len(), 8_192_000);
    assert!(cpu == other && gpu.warnings().is_empty(), "{:?}", gpu.warnings());
    assert!(gpu.most_memory() <= MEMORY, "{}", gpu.most_memory());
}

#[test]
fn parity_within_little_memory() {
    let scene = builtin::make("city", 1).unwrap();
    let view = around(&scene, 1.2, 300).swap_remove(1);
    // Bands, batches and halves; then too little for one chunk of triangles.
    let Some(small) = open(8 << 20) else { return };
    assert!(same(&scene, &view, &small) > 1000);
    assert!(small.most_memory() <= 8 << 20, "{}", small.most_memory());
    let Some(tiny) = open(1 << 18) else { return };
    let geometry = Geometry::new(&scene);
    let prepared = Prepared::new(&geometry, &view, &Options::default(), &Stop::default()).unwrap();
    assert!(everything(&tiny, &prepared) == everything(&Cpu, &prepared));
    assert!(tiny.warnings()[0].contains("the CPU does such views"), "{:?}", tiny.warnings());
}

#[test]
fn parity_of_points_in_sprites() {
    let Some(gpu) = gpu() else { return };
    let scene = builtin::make("solids", 1).unwrap();
    let geometry = Geometry::new(&scene);
    let stop = Stop::default();
    let sequence = crate::math::Sequence::<3>::new(3);
    for forward in [DVec3::NEG_Z, DVec3::new(0.4, -0.7, 0.2)] {
        let direction = Direction::new(forward).unwrap();
        let peeled =
            peel(&Cpu, &geometry, &direction, &Peeling { resolution: 200, samples: 1, repair: Repair::None }, &stop)
                .unwrap();
        let image = peeled.image.crop().unwrap();
        let mut points: Vec<[f32; 3]> =
            (0..100_000).map(|i| sequence.point(i).map(|c| (c * 1.1 - 0.05) as f32)).collect();
        // Exactly at the ends of ranges and at the borders of texels; and what is no number.
        for (i, d) in image.depths().iter().enumerate().step_by(7) {
            points.push([(i % 200) as f32 / 200.0, (i / 200 % 200) as f32 / 200.0, *d]);
        }
        points.push([f32::NAN, 0.5, 0.5]);
        points.push([0.5, 0.5, f32::NAN]);
        let grid = DepthQuantizer::around(&image);
        let short = [Layout::Rows, Layout::Runs].map(|l| Packed::short(&image, l, grid).unwrap());
        for packed in Layout::ALL.map(|l| Packed::new(&image, l).unwrap()).iter().chain(&short) {
            let found = gpu.classify(packed, &points, &stop).unwrap();
            let expect: Vec<bool> = points.iter().map(|p| packed.contains(*p)).collect();
            assert!(found == expect, "{:?}", packed.layout());
            assert!(found.iter().filter(|f| **f).count() > 1000);
        }
    }
}

/// Zones and rays in 32 bits against those in 64: they may differ where a corner or a ray touches a texel's border.
#[test]
fn effects_in_shaders_are_those_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let scene = builtin::make("solids", 1).unwrap();
    let stop = Stop::default();
    let (mut sprites, mut data, mut volumes) = (Vec::new(), Vec::new(), Vec::new());
    for (i, object) in scene.objects.iter().enumerate() {
        let geometry = Geometry::new(&Scene { objects: vec![object.clone()] });
        let direction = Direction::new(DVec3::new(0.3, 0.2 * i as f64, -0.9)).unwrap();
        let peeled =
            peel(&Cpu, &geometry, &direction, &Peeling { resolution: 150, samples: 1, repair: Repair::None }, &stop)
                .unwrap();
        let image = peeled.image.crop().unwrap();
        let grid = DepthQuantizer::around(&image);
        for layout in Layout::ALL {
            for packed in [Packed::new(&image, layout), Packed::short(&image, layout, grid)].into_iter().flatten() {
                let volume = Volume::new(packed.unpack(), &peeled.frame, &Placement::default());
                let (bytes, sections) = packed.file();
                data.resize(data.len().next_multiple_of(16), 0);
                sprites.push(super::sprite::sprite(&packed, &sections, data.len() as u32 / 4, volume.to_texture()));
                data.extend(bytes);
                volumes.push(volume);
            }
        }
    }
    let sequence = crate::math::Sequence::<6>::new(5);
    let mut rays = Vec::new();
    for k in 0..volumes.len() as u32 * 500 {
        let (i, p) = (k as usize % volumes.len(), sequence.point(k));
        let bounds = volumes[i].bounds();
        let origin = bounds.min + bounds.size() * (DVec3::new(p[0], p[1], p[2]) * 1.6 - 0.3);
        let direction = DVec3::new(p[3], p[4], p[5]) * 2.0 - 1.0;
        // Every tenth along an axis.
        let direction = if k % 10 == 0 {
            DVec3::from([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]][k as usize / 10 % 3])
        } else {
            direction
        };
        rays.push([origin.extend(0.05).as_vec4().to_array(), direction.extend(i as f64).as_vec4().to_array()]);
    }
    let asked = rays.clone();
    let found = gpu.call(move |machine| machine.probe(&sprites, &data, &asked, &Stop::default())).unwrap();
    let (mut hits, mut inside, mut differ) = (0, 0, [0; 3]);
    for (ray, found) in rays.iter().zip(found.chunks(4)) {
        let [o, d] = ray.map(|v| DVec3::new(v[0].into(), v[1].into(), v[2].into()));
        let volume = &volumes[ray[1][3] as usize];
        differ[0] += u32::from(volume.contains(o) != (found[0] == 1));
        inside += found[0];
        differ[1] += u32::from(volume.zone(o, 0.05f32.into()) as u32 != found[1]);
        let span = [found[2], found[3]].map(|bits| f64::from(f32::from_bits(bits)));
        let same = match volume.first(&Ray { origin: o, direction: d }) {
            None => span[0] > span[1],
            Some(s) => (s.enter.t - span[0]).abs() < 1e-3 && (s.exit - span[1]).abs() < 1e-3,
        };
        hits += u32::from(span[0] <= span[1]);
        differ[2] += u32::from(!same);
    }
    let n = rays.len() as u32;
    assert!(hits > n / 10 && inside > n / 25, "{hits} {inside} of {n}");
    assert!(differ[0] <= n / 1000 && differ[1] <= n / 1000 && differ[2] <= n / 1000, "{differ:?} of {n}");
}

#[test]
fn parity_of_slices() {
    const FINENESS: Fineness = Fineness { samples: 2, skirt: 2, quarters: true };
    let Some(gpu) = gpu() else { return };
    for (name, half) in [("car", 1.0), ("solids", 0.4)] {
        let scene = builtin::make(name, 1).unwrap();
        let (geometry, stop) = (Geometry::new(&scene), Stop::default());
        let centre = DVec3::new(0.3, 1.1, 9.7);
        let cell = Cell { centre, half: DVec3::splat(half) };
        let soup = Soup::new(&geometry, &cell);
        let lens = Lens { resolution: 300, fov: 0.8, max_layers: 200, max_side: 4000 };
        let slices = frame(&cell, &soup.corners, &lens, &stop).unwrap();
        let by = |backend| slice(backend, &scene, &geometry, &soup, &slices, FINENESS, &stop).unwrap();
        let fields = by(gpu);
        assert!(fields == by(&Cpu), "{name}");
        assert!(fields.iter().map(|f| f.voxels.len()).sum::<usize>() > 500, "{name}");
    }
}

#[test]
fn parity_after_the_device_is_lost() {
    let Some(gpu) = open(MEMORY) else { return };
    let scene = builtin::make("car", 1).unwrap();
    let geometry = Geometry::new(&scene);
    let view = around(&scene, 2.0, 100).swap_remove(0);
    let prepared = Prepared::new(&geometry, &view, &Options::default(), &Stop::default()).unwrap();
    let before = everything(&gpu, &prepared);
    assert!(gpu.warnings().is_empty());
    gpu.lose();
    assert!(everything(&gpu, &prepared) == before);
    assert!(gpu.warnings().len() == 1 && gpu.warnings()[0].contains("the CPU goes on"), "{:?}", gpu.warnings());
}

#[test]
fn a_stop_is_heeded() {
    let Some(gpu) = gpu() else { return };
    let scene = builtin::make("car", 1).unwrap();
    let geometry = Geometry::new(&scene);
    let view = around(&scene, 2.0, 100).swap_remove(0);
    let prepared = Prepared::new(&geometry, &view, &Options::default(), &Stop::default()).unwrap();
    let stop = Stop::default();
    stop.set();
    // By the device's thread, which has all it needs.
    let [band] = &work::bands(&prepared, &gpu.room(), 20).unwrap()[..] else { panic!() };
    let inside = work::Work::new(&prepared, band, &gpu.room()).unwrap();
    let set = stop.clone();
    let done = gpu.call(move |machine| machine.count(&inside, &set));
    assert!(matches!(done, Err(GpuError::Stopped(_))));
    assert!(nearest_in_tiles(gpu, &prepared, &stop, |_, _, _| ()).is_err());
    assert!(fragments_in_tiles(gpu, &prepared, &stop, |_, _| ()).is_err());
    assert!(gpu.warnings().is_empty());
}

#[test]
fn an_adapter_that_is_not_there_is_named() {
    let text = Gpu::open(Wanted::Named("no such adapter"), MEMORY).err().unwrap().to_string();
    assert!(text.starts_with("there is no GPU adapter") && text.contains("farfield devices"), "{text}");
}
