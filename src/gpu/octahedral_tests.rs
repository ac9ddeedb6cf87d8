//! Parity of octahedral impostors drawn by the device with those drawn by the CPU.

use super::{
    octahedral,
    tests::{gpu, same_layout},
};
use crate::{
    math::Stop,
    octahedral::{Grid, tests::impostor},
    raster::{Cpu, Gloss, Light, Rendering, Shading},
    runtime::{
        Context, StandIn,
        octahedral::{Drawing, Model, OctahedralStandIn, SHADER},
    },
    scene::builtin,
    view::{Projection, View},
};
use glam::DVec3;
use std::sync::Arc;
use wgpu::naga::{front::wgsl, valid};

#[test]
fn the_shader_is_valid_and_shares_the_structs() {
    let module = wgsl::parse_str(SHADER).unwrap_or_else(|e| panic!("{}", e.emit_to_string(SHADER)));
    valid::Validator::new(valid::ValidationFlags::all(), valid::Capabilities::default()).validate(&module).unwrap();
    same_layout!(&module, "Frame", octahedral::Frame, clip, depth, eye, to_sun, sun, sky, ground, shading, sample_size);
    same_layout!(
        &module,
        "Impostor",
        octahedral::Impostor,
        window,
        card,
        corners,
        frames,
        tile,
        levels,
        hemi,
        steps,
        emits
    );
}

#[test]
fn parity_of_pictures_and_depths() {
    let Some(gpu) = gpu() else { return };
    let gloss = Some(Gloss { strength: 0.5, exponent: 30.0 });
    let lit = Shading::Lit(Light { gloss, ..Light::default() });
    let scene = builtin::make("solids", 1).unwrap();
    let (centre, radius) = (scene.bounds().centre(), scene.bounds().diagonal() * 0.5);
    let mut worst = Vec::new();
    for (grid, shading, steps, samples, away, orthographic) in [
        (Grid { side: 6, hemi: false }, Shading::Unlit, 16, 1, 3.0, false),
        (Grid { side: 6, hemi: false }, lit, 24, 3, 4.0, false),
        // Far away, so that coarse levels are read.
        (Grid { side: 6, hemi: false }, Shading::Unlit, 16, 1, 60.0, false),
        (Grid { side: 5, hemi: true }, lit, 9, 2, 3.0, true),
        (Grid { side: 5, hemi: true }, Shading::Unlit, 0, 1, 3.0, false),
    ] {
        let mut impostor = impostor(&scene, grid, 64, 64);
        impostor.atlas.emissive = Some(impostor.atlas.color.clone());
        let model = || Model::new(impostor.clone(), Drawing { steps }).unwrap();
        let stand_in = OctahedralStandIn::new(model());
        for d in [
            DVec3::new(1.0, 0.4, 0.3),
            DVec3::new(-0.4, 0.6, 0.8),
            DVec3::new(0.1, 1.0, 0.05),
            DVec3::new(0.5, -0.7, 0.2),
        ] {
            let eye = centre + d.normalize() * radius * away;
            let (near, far) = (radius * (away - 1.6), radius * (away + 1.6));
            let side = if away > 10.0 { 40 } else { 120 };
            let fov = if away > 10.0 { 0.045 } else { 0.75 };
            let mut view = View::look_at(eye, centre, DVec3::Y, fov, side + 10, side, near, far);
            if orthographic {
                let half = radius * 1.1;
                view.projection = Projection::Orthographic { left: -half, right: half, bottom: -half, top: half };
            }
            let how = Rendering { shading, ..Rendering::default() }.with_samples(samples);
            let stop = Stop::default();
            let cpu = stand_in.draw(&view, &how, Context { backend: &Cpu, stop: &stop }).unwrap();
            let other = gpu.draw_octahedral(Arc::new(model()), &view, &how, &stop).unwrap();
            let covered = cpu.depth.iter().filter(|z| z.is_finite()).count();
            assert!(covered > 100, "{covered}");
            let far = |(a, b): (&[u8; 4], &[u8; 4])| (0..4).any(|k| a[k].abs_diff(b[k]) > 4);
            let colors = cpu.picture.texels.iter().zip(&other.picture.texels).filter(|t| far(*t)).count();
            let close = |(a, b): (&f32, &f32)| a == b || f64::from((a - b).abs()) < radius * 0.02;
            // With an even number no sample lies at a pixel's centre.
            let depths = cpu.depth.iter().zip(&other.depth).filter(|z| samples % 2 == 1 && !close(*z)).count();
            eprintln!("{grid:?} {samples} {away}: {covered} covered, {colors} colours and {depths} depths differ");
            // Where frames vote narrowly, rounding decides.
            worst.push((colors as f64 / covered as f64, depths as f64 / covered as f64));
        }
    }
    let most = worst.iter().fold((0.0, 0.0), |m: (f64, f64), w| (m.0.max(w.0), m.1.max(w.1)));
    assert!(most.0 <= 0.125 && most.1 <= 0.04, "{most:?} of {worst:?}");
}
