//! Parity of DMeshes drawn by the device with those drawn by the CPU.

use super::{
    Gpu, dmesh,
    tests::{gpu, same_layout},
};
use crate::{
    image::Picture,
    math::Stop,
    raster::{Gloss, Light, Noise, Rendering, Shading},
    runtime::dmesh::{
        Blending, Dmesh, Model, SHADER, Weights,
        tests::scenes::{captured, towards},
    },
    scene::{Scene, builtin},
    view::{Projection, View},
};
use glam::DVec3;
use std::sync::Arc;
use wgpu::naga::{front::wgsl, valid};

#[test]
fn the_shader_is_valid_and_shares_the_structs() {
    let module = wgsl::parse_str(SHADER).unwrap_or_else(|e| panic!("{}", e.emit_to_string(SHADER)));
    valid::Validator::new(valid::ValidationFlags::all(), valid::Capabilities::default()).validate(&module).unwrap();
    same_layout!(
        &module,
        "Frame",
        dmesh::Frame,
        clip,
        depth,
        eye,
        to_sun,
        sun,
        sky,
        ground,
        background,
        shading,
        period,
        samples,
        layers
    );
    same_layout!(&module, "Reference", dmesh::Reference, texel, spread, slack, weight, quality, mapped);
}

/// Of pixels, how many differ by more than `tolerance` in a channel, and the greatest difference of the others.
fn differing(a: &Picture, b: &Picture, tolerance: u8) -> (usize, u8) {
    let far = |(a, b): (&[u8; 4], &[u8; 4])| (0..4).map(|k| a[k].abs_diff(b[k])).max().unwrap_or(0);
    let all: Vec<u8> = a.texels.iter().zip(&b.texels).map(far).collect();
    let (near, far): (Vec<u8>, Vec<u8>) = all.into_iter().partition(|d| *d <= tolerance);
    (far.len(), near.into_iter().max().unwrap_or(0))
}

struct Case {
    shading: Shading,
    blending: Blending,
    how: Rendering,
    orthographic: bool,
}

fn cases() -> Vec<Case> {
    let gloss = Some(Gloss { strength: 0.5, exponent: 30.0 });
    let lit = Shading::Lit(Light { gloss, ..Light::default() });
    let case = |shading, blending, samples, orthographic| Case {
        shading,
        blending,
        how: Rendering::default().with_samples(samples),
        orthographic,
    };
    let usual = Blending::default();
    vec![
        case(Shading::Unlit, usual, 1, false),
        case(Shading::Unlit, usual, 4, false),
        case(lit, usual, 3, false),
        case(lit, usual, 2, true),
        case(Shading::Noise(Noise { period: 0.2 }), usual, 2, false),
        case(Shading::Unlit, Blending { quality: false, weights: Weights::Uniform, offset: Some(0.1) }, 1, false),
        case(Shading::Unlit, Blending { weights: Weights::Angular, ..usual }, 1, true),
    ]
}

fn view(scene: &Scene, d: DVec3, orthographic: bool) -> View {
    let view = View { height: 130, ..towards(scene, d, 150) };
    if !orthographic {
        return view;
    }
    let half = scene.bounds().diagonal() * 0.5;
    View { projection: Projection::Orthographic { left: -half, right: half, bottom: -half, top: half }, ..view }
}

/// Colours differ by at most 3 of 255 in all but one pixel in a hundred, which lie on edges: coverage is the device's own.
fn same(gpu: &Gpu, scene: &Scene, dmesh: Dmesh) {
    let model = Arc::new(Model::new(dmesh).unwrap());
    let loaded = gpu.load_dmesh(model.clone()).unwrap();
    for (i, case) in cases().into_iter().enumerate() {
        for d in [DVec3::new(1.0, 0.4, 0.3), DVec3::new(-0.4, -0.7, 0.8)] {
            let view = view(scene, d, case.orthographic);
            let how = Rendering { shading: case.shading, ..case.how };
            let cpu = model.draw(&view, &how, &case.blending, &Stop::default()).unwrap();
            let other = gpu.draw_dmesh(&loaded, &view, &how, &case.blending, &Stop::default()).unwrap();
            let covered = cpu.mask.iter().filter(|m| **m != 0).count();
            assert!(covered > 1000, "{covered}");
            let (edges, most) = differing(&cpu.picture, &other.picture, 3);
            let close = |(a, b): (&f32, &f32)| a == b || (a - b).abs() < 1e-4 * a;
            let depths = cpu.depth.iter().zip(&other.depth).filter(|z| !close(*z)).count();
            eprintln!(
                "case {i}: {covered} pixels covered, {edges} differ by more than 3, the others by {most}; {depths} depths differ"
            );
            assert!(edges * 100 <= covered, "case {i}: {edges} of {covered} pixels");
            assert!(depths * 100 <= covered, "case {i}: {depths} of {covered} depths");
        }
    }
}

#[test]
fn parity_on_captured_scenes() {
    let Some(gpu) = gpu() else { return };
    for name in ["solids", "car"] {
        let scene = builtin::make(name, 1).unwrap();
        let mut dmesh = captured(&scene, 129);
        same(gpu, &scene, dmesh.clone());
        // Both sides, no normal maps, and one reference without vertex normals.
        dmesh.double_sided = true;
        dmesh.references.iter_mut().for_each(|r| r.normal_map = None);
        same(gpu, &scene, dmesh);
    }
}

#[test]
fn nothing_is_drawn_of_nothing() {
    let Some(gpu) = gpu() else { return };
    let scene = builtin::make("solids", 1).unwrap();
    let view = view(&scene, DVec3::X, false);
    let how = Rendering { background: [0.0, 0.0, 1.0], ..Rendering::default() };
    let mut bare = captured(&scene, 9);
    bare.references.iter_mut().for_each(|r| r.mesh = Arc::default());
    for dmesh in [Dmesh { references: vec![], ..bare.clone() }, bare] {
        let loaded = gpu.load_dmesh(Arc::new(Model::new(dmesh).unwrap())).unwrap();
        let drawn = gpu.draw_dmesh(&loaded, &view, &how, &Blending::default(), &Stop::default()).unwrap();
        assert!(drawn.picture.texels.iter().all(|t| *t == [0, 0, 255, 255]));
        assert!(drawn.depth.iter().all(|z| *z == f32::INFINITY));
        let none = View { width: 0, ..view };
        let drawn = gpu.draw_dmesh(&loaded, &none, &how, &Blending::default(), &Stop::default()).unwrap();
        assert_eq!(drawn.depth.len(), 0);
    }
}

#[test]
fn a_view_that_is_too_large_is_refused() {
    let Some(gpu) = gpu() else { return };
    let scene = builtin::make("solids", 1).unwrap();
    let loaded = gpu.load_dmesh(Arc::new(Model::new(captured(&scene, 9)).unwrap())).unwrap();
    let view = View { width: 8000, height: 8000, ..view(&scene, DVec3::X, false) };
    let error = gpu.draw_dmesh(&loaded, &view, &Rendering::default(), &Blending::default(), &Stop::default());
    assert!(error.is_err_and(|e| e.to_string().contains("limit")));
}
