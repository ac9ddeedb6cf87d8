//! Parity of a cell's stand-ins drawn by the device with those drawn by the CPU.

use super::{
    hybrid_lod,
    tests::{gpu, same_layout},
};
use crate::{
    lod::{entry::Entry, tests::stand_ins},
    math::Stop,
    raster::{Cpu, Geometry, Noise, Rendering, Shading},
    runtime::{
        Context, StandIn,
        hybrid_lod::{SHADER, cell_stand_in, cell_tests::flat},
    },
    scene::Scene,
    view::View,
};
use glam::{DVec3, Mat4};
use std::{collections::BTreeSet, sync::Arc};
use wgpu::naga::{front::wgsl, valid};

#[test]
fn the_shader_is_valid_and_shares_the_structs() {
    let module = wgsl::parse_str(SHADER).unwrap_or_else(|e| panic!("{}", e.emit_to_string(SHADER)));
    valid::Validator::new(valid::ValidationFlags::all(), valid::Capabilities::default()).validate(&module).unwrap();
    same_layout!(&module, "Frame", hybrid_lod::Frame, clip);
    let (members, size) = super::tests::layout(&module, "Page");
    assert_eq!(members, [("scale".to_owned(), 0), ("layer".to_owned(), 8)]);
    assert_eq!(size, size_of::<hybrid_lod::Page>());
}

/// Colours differ by at most 4 of 255 in all but one pixel in a hundred, which lie on edges, and depths by one in 10,000 likewise: coverage is the device's own.
#[test]
fn parity_of_pictures_and_depths() {
    let Some(gpu) = gpu() else { return };
    // One page, and several of different sizes.
    for (name, distance, page) in [("torus", 9.0, 4096), ("torus", 9.0, PAGE), ("sphere", 30.0, 4096)] {
        let scene = Arc::new(stand_ins(name, distance, page));
        let images: BTreeSet<[u32; 2]> = scene.objects[0]
            .parts
            .iter()
            .filter_map(|p| p.material.base_color_texture.as_ref())
            .map(|t| [t.image.width, t.image.height])
            .collect();
        assert_eq!(images.len() > 1, page == PAGE, "{images:?}");
        let geometry = Geometry::new(&scene);
        let entry = Entry::default();
        let stand_in = cell_stand_in(&scene, &geometry, &entry);
        let (target, centre) = (scene.bounds().centre(), scene.objects[0].transform.w_axis.truncate().as_dvec3());
        let away = centre.distance(target);
        for (shift, samples) in
            [(DVec3::ZERO, 1), (DVec3::new(0.4, 0.2, 1.9), 3), (DVec3::new(-1.5, -0.3, -1.2), 2), (DVec3::X * 3.5, 1)]
        {
            let fov = libm::atan(1.2 * scene.bounds().diagonal() / away) * 0.8;
            let view = View::look_at(centre + shift, target, DVec3::Y, fov, 140, 120, away * 0.1, away * 4.0);
            let how = Rendering::default().with_samples(samples);
            let stop = Stop::default();
            let cpu = stand_in.draw(&view, &how, Context { backend: &Cpu, stop: &stop }).unwrap();
            let other = gpu.draw_hybrid_lod(scene.clone(), &view, &how, &stop).unwrap();
            let covered = cpu.depth.iter().filter(|z| z.is_finite()).count();
            assert!(covered > 1000, "{covered}");
            let most = |(a, b): (&[u8; 4], &[u8; 4])| (0..4).map(|k| a[k].abs_diff(b[k])).max().unwrap_or(0);
            let colors: Vec<u8> = cpu.picture.texels.iter().zip(&other.picture.texels).map(most).collect();
            let far = colors.iter().filter(|d| **d > 4).count();
            let close = |(a, b): (&f32, &f32)| a == b || (a - b).abs() < 1e-4 * a;
            // With an even number no sample lies at a pixel's centre.
            let depths = cpu.depth.iter().zip(&other.depth).filter(|z| samples % 2 == 1 && !close(*z)).count();
            eprintln!("{name} {page} {shift} {samples}: {covered} covered, {far} colours and {depths} depths differ");
            assert!(far * 100 <= covered, "{name} {page} {shift}: {far} of {covered} pixels");
            assert!(depths * 100 <= covered, "{name} {page} {shift}: {depths} of {covered} depths");
        }
    }
}

const PAGE: u32 = 64;

#[test]
fn from_the_centre_the_device_shows_what_was_captured() {
    let Some(gpu) = gpu() else { return };
    let flat = flat(1.1, 12.0, 5.0);
    let how = Rendering::default().with_samples(1);
    let drawn = gpu.draw_hybrid_lod(Arc::new(flat.scene()), &flat.view(), &how, &Stop::default()).unwrap();
    // Devices filter with 8 bits of fraction.
    let (differing, all) = flat.differing(&drawn.picture, &drawn.depth, 3);
    assert!(differing == 0 && all > 300, "{differing} of {all}");
}

#[test]
fn what_is_no_cell_is_refused() {
    let Some(gpu) = gpu() else { return };
    let flat = flat(0.5, 12.0, 5.0);
    let draw = |scene: Scene, how: &Rendering| {
        gpu.draw_hybrid_lod(Arc::new(scene), &flat.view(), how, &Stop::default()).map_err(|e| e.to_string())
    };
    let how = Rendering::default().with_samples(1);
    let refused = |change: &dyn Fn(&mut Scene), what: &str| {
        let mut scene = flat.scene();
        let second = scene.objects[0].clone();
        scene.objects.push(second);
        change(&mut scene);
        let text = draw(scene, &how).unwrap_err();
        assert!(text.contains(what), "{text}");
    };
    refused(&|s| s.objects[1].transform = Mat4::IDENTITY, "one transform");
    refused(&|s| Arc::make_mut(&mut s.objects[0].parts[0].mesh).uv[1] = Default::default(), "two sets");
    refused(
        &|s| {
            let mesh = Arc::make_mut(&mut s.objects[0].parts[0].mesh);
            mesh.uv[1] = mesh.uv[1].iter().map(|_| [0.0; 2]).collect();
        },
        "depths above 0",
    );
    refused(&|s| Arc::make_mut(&mut s.objects[0].parts[0].material).base_color_texture = None, "a texture");
    let noise = Rendering { shading: Shading::Noise(Noise { period: 1.0 }), ..how };
    assert!(draw(flat.scene(), &noise).unwrap_err().contains("no noise"));
    // Nothing to draw is a legal cell.
    let empty = draw(Scene::default(), &how).unwrap();
    assert!(empty.depth.iter().all(|z| z.is_infinite()));
}
