//! What is seen of an impostor.

use super::*;
use crate::{
    raster::{Geometry, NOTHING, Options, Shader, Shading, nearest, picture},
    runtime::SceneStandIn,
};
use std::sync::OnceLock;

const GRID: Grid = Grid { side: 5, hemi: false };

#[test]
fn along_a_grid_direction_the_capture_is_seen() {
    for scene in [cube(), ball()] {
        for grid in [GRID, Grid { side: 4, hemi: true }] {
            let captures = captured(&scene, grid, 64, 2.0);
            let stand_in = stand_in(packed(&captures, None).unwrap(), 16);
            let radius = stand_in.model().impostor().radius;
            for (name, capture) in &captures {
                // The upper half is drawn as from a little above the horizon.
                if grid.hemi && capture.view.forward.y.abs() < 0.01 {
                    continue;
                }
                let shot = draw(&stand_in, &capture.view, &Rendering::default().with_samples(1));
                let layer = &capture.layers[0];
                for (i, z) in layer.depth.iter().enumerate() {
                    assert_eq!(shot.depth[i].is_finite(), z.is_finite(), "{name}, pixel {i}");
                    assert_eq!(shot.surface[i] != NOTHING, z.is_finite());
                    if z.is_finite() {
                        assert!(f64::from((shot.depth[i] - z).abs()) < radius / 120.0, "{name}: {} {z}", shot.depth[i]);
                        assert_eq!(shot.picture.texels[i], layer.color[i]);
                    }
                }
            }
        }
    }
}

/// Pixels that only one of two pictures covers, as a share of what the first covers.
fn outside(a: &[f32], b: &[f32]) -> f64 {
    let differs = a.iter().zip(b).filter(|(a, b)| a.is_finite() != b.is_finite()).count();
    differs as f64 / a.iter().filter(|z| z.is_finite()).count() as f64
}

fn solids() -> &'static (Scene, Impostor) {
    static SOLIDS: OnceLock<(Scene, Impostor)> = OnceLock::new();
    SOLIDS.get_or_init(|| {
        let scene = builtin::make("solids", 1).unwrap();
        let impostor = impostor(&scene, Grid { side: 8, hemi: false }, 128, 64);
        (scene, impostor)
    })
}

fn original(scene: &Scene, view: &View) -> Vec<f32> {
    let geometry = Geometry::new(scene);
    nearest(&Cpu, &geometry, view, &Options::default(), &Default::default()).unwrap().depth
}

const BETWEEN: [DVec3; 4] =
    [DVec3::new(1.0, 0.3, 0.45), DVec3::new(-0.4, 0.2, 0.9), DVec3::new(0.3, -0.8, -0.5), DVec3::new(-0.9, 0.7, 0.1)];

/// Between grid directions outlines are near to the original's, and parallax brings them nearer.
#[test]
fn outlines_between_grid_directions() {
    let (scene, impostor) = solids();
    let mean = |steps: u32| {
        let stand_in = stand_in(impostor.clone(), steps);
        let errors = BETWEEN.map(|d| {
            let view = towards(scene, d, 96, 4.0);
            outside(&original(scene, &view), &draw(&stand_in, &view, &Rendering::default().with_samples(1)).depth)
        });
        errors.iter().sum::<f64>() / 4.0
    };
    let (flat, few, many) = (mean(0), mean(16), mean(64));
    eprintln!("outside: {flat} flat, {few} and {many} in 16 and 64 steps");
    assert!(few < 0.1 && many <= few + 0.01 && few < flat, "{flat} {few} {many}");
}

#[test]
fn small_changes_of_the_view_change_little() {
    let (scene, impostor) = solids();
    let stand_in = stand_in(impostor.clone(), 16);
    let how = Rendering::default().with_samples(2);
    // Across the diagonal of a cell, across its side, across the square's border, and over the pole.
    for d in
        [DVec3::new(0.5, 0.4, 0.5), DVec3::new(1.0, 0.0, 0.3), DVec3::new(0.01, -1.0, 0.2), DVec3::new(0.0, 1.0, 0.0)]
    {
        let view = |shift: DVec3| towards(scene, d + shift, 64, 4.0);
        let [a, b] = [DVec3::splat(-2e-4), DVec3::splat(2e-4)].map(|shift| View {
            right: view(DVec3::splat(1e-3)).right,
            up: view(DVec3::splat(1e-3)).up,
            ..view(shift)
        });
        // Both look along the same axes: over the pole the picture of `look_at` turns.
        let [a, b] = [a, b].map(|v| View { forward: -v.right.cross(v.up), ..v });
        let [a, b] = [a, b].map(|v| draw(&stand_in, &v, &how).picture);
        let far = a.texels.iter().zip(&b.texels).filter(|(a, b)| (0..3).any(|k| a[k].abs_diff(b[k]) > 12)).count();
        assert!(far <= 60, "{far} pixels changed much around {d}");
    }
}

#[test]
fn colours_and_light_are_those_of_the_original() {
    let (scene, impostor) = solids();
    let stand_in = stand_in(impostor.clone(), 16);
    let geometry = Geometry::new(scene);
    let shader = Shader::new(&geometry);
    for shading in [Shading::Unlit, Shading::Lit(Default::default())] {
        let how = Rendering { shading, ..Rendering::default() };
        for d in BETWEEN {
            let view = towards(scene, d, 96, 4.0);
            let expect = picture(&Cpu, &shader, &view, &how, &Default::default()).unwrap();
            let found = draw(&stand_in, &view, &how).picture;
            let error =
                |(a, b): (&[u8; 4], &[u8; 4])| (0..3).map(|k| f64::from(a[k].abs_diff(b[k]))).sum::<f64>() / 3.0;
            let mean = expect.texels.iter().zip(&found.texels).map(error).sum::<f64>() / expect.texels.len() as f64;
            assert!(mean < 6.0, "{mean} from {d}");
        }
    }
}

#[test]
fn depths_and_planes_are_those_of_the_surface() {
    let scene = ball();
    let stand_in = stand_in(impostor(&scene, GRID, 128, 128), 16);
    let view = towards(&scene, BETWEEN[0], 64, 5.0);
    let shot = draw(&stand_in, &view, &Rendering::default().with_samples(1));
    let expect = original(&scene, &view);
    let geometry = Geometry::new(&scene);
    let reference = SceneStandIn::new(&scene, &geometry);
    let stop = crate::math::Stop::default();
    let reference = reference.draw(&view, &Rendering::default(), Context { backend: &Cpu, stop: &stop }).unwrap();
    let (mut near, mut all) = (0, 0);
    let mut errors = Vec::new();
    for (i, z) in expect.iter().enumerate().filter(|(i, z)| z.is_finite() && shot.depth[*i].is_finite()) {
        all += 1;
        errors.push((shot.depth[i] - z).abs());
        let k = (shot.planes)(shot.surface[i]);
        let (x, y) = ((i % 64) as f64 + 0.5, (i / 64) as f64 + 0.5);
        let ray = view.unproject(x, y, 1.0) - view.eye;
        let d = DVec3::new(ray.dot(view.right), ray.dot(view.up), 1.0);
        assert!((1.0 / k.dot(d) - f64::from(shot.depth[i])).abs() < 1e-3);
        let angle = k.normalize().dot((reference.planes)(reference.surface[i]).normalize());
        near += usize::from(angle.abs() > 0.95);
    }
    assert!(all > 500 && near * 20 > all * 19, "{near} of {all}");
    errors.sort_by(f32::total_cmp);
    assert!(errors[all / 2] < 0.05, "{}", errors[all / 2]);
    assert!(stand_in.saw(DVec3::new(-1.3, 0.5, 1.0)) && !stand_in.saw(DVec3::new(-2.0, 0.5, 1.0)));
}

/// From inside, from the centre and from far away: no panic, and a distant object covers as much as it should.
#[test]
fn eyes_anywhere() {
    let (scene, impostor) = solids();
    let stand_in = stand_in(impostor.clone(), 16);
    let how = Rendering::default().with_samples(1);
    for distance in [1e-9, 0.3, 1.0, 1.05] {
        let mut view = towards(scene, BETWEEN[1], 32, 2.0);
        view.eye = impostor.centre + BETWEEN[1].normalize() * impostor.radius * distance;
        let shot = draw(&stand_in, &view, &how);
        assert!(shot.depth.iter().all(|z| *z > 0.0));
    }
    let far = towards(scene, BETWEEN[1], 16, 400.0);
    let covered = |z: &[f32]| z.iter().filter(|z| z.is_finite()).count();
    let (expect, found) = (covered(&original(scene, &far)), covered(&draw(&stand_in, &far, &how).depth));
    // Half a pixel all around is a third of so small an object.
    assert!(expect.abs_diff(found) <= 12, "{expect} {found}");
    let away = View { forward: -far.forward, right: -far.right, ..far };
    assert_eq!(covered(&draw(&stand_in, &away, &how).depth), 0);
}

#[test]
fn what_it_costs() {
    let (_, impostor) = solids();
    let size = stand_in(impostor.clone(), 16).size();
    let base = u64::from(impostor.atlas.side).pow(2);
    assert_eq!((size.draw_calls, size.triangles), (1, impostor.card.len() as u64 - 2));
    assert_eq!(size.texels, 2 * base);
    // Frames of 64, 32, 16, 8 and 4 texels.
    assert_eq!(size.memory_bytes, 8 * (base + base / 4 + base / 16 + base / 64 + base / 256));
}
