//! The ε-z-buffer, the blending, and what pixel centres see.

use super::*;
use crate::{
    image::srgb,
    raster::{Cpu, NOTHING, fragments},
    view::Projection,
};
use glam::DVec3;

fn pair(a: Reference, b: Reference, epsilon: f64) -> Dmesh {
    Dmesh { references: vec![a, b], epsilon, diagonal: 3.0, double_sided: false }
}

fn ahead(side: u32) -> View {
    View::look_at(DVec3::Z * 3.0, DVec3::ZERO, DVec3::Y, 0.8, side, side, 0.1, 100.0)
}

#[test]
fn a_plane_seen_twice_is_the_mean_by_weights() {
    let (left, right) = (DVec3::new(-2.0, 0.5, 2.0), DVec3::new(1.0, 0.0, 4.0));
    let dmesh = pair(
        square("left", left, DVec3::ZERO, [200, 30, 0], 0.5),
        square("right", right, DVec3::ZERO, [0, 90, 250], 0.8),
        0.0,
    );
    let model = Model::new(dmesh.clone()).unwrap();
    let view = ahead(33);
    for (weights, quality) in [
        (Weights::Positional, true),
        (Weights::Positional, false),
        (Weights::Angular, true),
        (Weights::Angular, false),
        (Weights::Uniform, true),
        (Weights::Uniform, false),
    ] {
        let blending = Blending { weights, quality, offset: None };
        let drawn = model.draw(&view, &one_sample(), &blending, &Stop::default()).unwrap();
        let w = [left, right].map(|eye| {
            let cos = (DVec3::ZERO - eye).normalize().dot(DVec3::NEG_Z);
            let angular =
                if cos > 0.5f64.sqrt() { 1.0 } else { libm::cos(libm::acos(cos) - std::f64::consts::FRAC_PI_4) };
            let distance = 1.0 / (eye.distance(DVec3::Z * 3.0) + 0.03);
            match weights {
                Weights::Positional => angular * distance,
                Weights::Angular => angular,
                Weights::Uniform => 1.0,
            }
        });
        let q = if quality { [0.5, 0.8] } else { [1.0, 1.0] };
        let share = w[0] * q[0] / (w[0] * q[0] + w[1] * q[1]);
        let expect = [(200, 0), (30, 90), (0, 250)].map(|(a, b)| {
            let (a, b) = (f64::from(srgb::to_linear(a)), f64::from(srgb::to_linear(b)));
            srgb::from_linear((a * share + b * (1.0 - share)) as f32)
        });
        let middle = 16 * 33 + 16;
        let [r, g, b] = expect;
        assert!(far(&drawn.picture.texels[middle], &[r, g, b, 255]) <= 1, "{weights:?} {quality}");
        assert_eq!((drawn.mask[middle], drawn.count(middle)), (0b11, 2));
        assert!((drawn.depth[middle] - 3.0).abs() < 1e-6);
    }
}

#[test]
fn surfaces_farther_apart_than_the_offset_do_not_blend() {
    let eye = DVec3::Z * 3.0;
    // A texel of the square's view: 2·tan(0.4)/100 per metre of depth.
    let texel = |depth: f64| 2.0 * libm::tan(0.4) / 100.0 * depth;
    for (distance, blends) in [(0.0, true), (0.9, true), (1.1, false)] {
        let epsilon = 0.02;
        let reach = 2.0 * epsilon + texel(3.0);
        let behind = DVec3::NEG_Z * distance * reach;
        // Both are captured from the same distance, so that a texel measures the same on either.
        let dmesh = pair(
            square("near", eye, DVec3::ZERO, [255, 0, 0], 1.0),
            square("far", eye + behind, behind, [0, 0, 255], 1.0),
            epsilon,
        );
        let drawn = draw(&dmesh, &ahead(33), &one_sample());
        let middle = 16 * 33 + 16;
        assert_eq!(drawn.mask[middle], if blends { 0b11 } else { 0b01 }, "{distance}");
        let [r, _, b, _] = drawn.picture.texels[middle];
        assert_eq!((r < 255, b > 0), (blends, blends), "{distance}");
        let blending = Blending { offset: Some(0.5 * distance * reach), ..Blending::default() };
        let model = Model::new(dmesh).unwrap();
        let strict = model.draw(&ahead(33), &one_sample(), &blending, &Stop::default()).unwrap();
        assert_eq!(strict.mask[middle], if distance == 0.0 { 0b11 } else { 0b01 });
    }
}

/// The two passes of the paper, literally: all fragments of all meshes, Z_e their minimum, and a reference counts where any
/// of its fragments passes.
#[test]
fn one_rasterisation_is_the_two_passes_of_the_paper() {
    let scene = solids();
    let dmesh = captured(&scene, 65);
    let model = Model::new(dmesh.clone()).unwrap();
    let mut several = 0;
    for (d, orthographic) in [(DVec3::ONE, false), (DVec3::new(-0.3, 0.2, 1.0), true)] {
        let mut view = towards(&scene, d, 80);
        if orthographic {
            let half = scene.bounds().diagonal() * 0.5;
            view.projection = Projection::Orthographic { left: -half, right: half, bottom: -half, top: half };
        }
        let drawn = draw(&dmesh, &view, &one_sample());
        let stop = Stop::default();
        let all: Vec<_> = (0..6)
            .map(|i| fragments(&Cpu, &model.part(i).1.geometry, &view, &one_sample().options, &stop).unwrap())
            .collect();
        for pixel in 0..80 * 80usize {
            let of = |s: &Selected| all[s.reference].of(pixel as u32 % 80, pixel as u32 / 80);
            let front = drawn.selected.iter().flat_map(of).fold(f32::INFINITY, |z, f| z.min(f.depth));
            let (px, py) = ((pixel % 80) as f64 + 0.5, (pixel / 80) as f64 + 0.5);
            let mut mask = 0;
            for s in &drawn.selected {
                let passes = |z: f32| {
                    let p = view.unproject(px, py, f64::from(z));
                    let texel = dmesh.references[s.reference].texel().dot(p.extend(1.0));
                    f64::from(z) <= f64::from(front) + 2.0 * dmesh.epsilon + texel
                };
                mask |= u64::from(of(s).iter().any(|f| passes(f.depth))) << s.reference;
            }
            assert_eq!((drawn.depth[pixel], drawn.mask[pixel]), (front, mask), "{pixel}");
            several += u32::from(mask.count_ones() > 1);
            if mask != 0 {
                let [a, b, c] = model.positions(drawn.surface[pixel]);
                let p = view.unproject(px, py, f64::from(front));
                let off = (b - a).cross(c - a).normalize_or_zero().dot(p - a);
                assert!(off.abs() < 1e-3 * dmesh.diagonal, "the surface passes through what is seen: {off}");
            } else {
                assert_eq!(drawn.surface[pixel], NOTHING);
            }
        }
    }
    assert!(several > 300, "{several}");
}

/// Figure 22: with a fixed camera and only the weights changing, no pixel jumps, though every reference has a colour of its own.
#[test]
fn weights_that_change_a_little_change_pixels_a_little() {
    let scene = solids();
    let mut dmesh = captured(&scene, 65);
    for (i, reference) in dmesh.references.iter_mut().enumerate() {
        let color = [1, 2, 4].map(|bit| if (i + 1) & bit > 0 { 255 } else { 0 });
        reference.color = square("color", DVec3::Z, DVec3::ZERO, color, 1.0).color;
    }
    let model = Model::new(dmesh).unwrap();
    let view = towards(&scene, DVec3::new(0.4, 0.3, 1.0), 60);
    let at = |t: f64| {
        let angle = 0.2 + 1.2 * t;
        let turned = towards(&scene, DVec3::new(libm::sin(angle), 0.3, libm::cos(angle)), 60);
        let selected = select(model.dmesh(), &turned, Weights::Positional);
        model.draw_selected(&view, &one_sample(), &Blending::default(), selected, &Stop::default()).unwrap().picture
    };
    // The greatest change of a channel from step to step in linear light, and in all.
    let jumps = |steps: u32| {
        let linear =
            |p: &crate::image::Picture| p.texels.iter().flatten().map(|c| srgb::to_linear(*c)).collect::<Vec<_>>();
        let all: Vec<_> = (0..=steps).map(|i| linear(&at(f64::from(i) / f64::from(steps)))).collect();
        let step = |w: &[Vec<f32>]| w[0].iter().zip(&w[1]).fold(0.0f32, |m, (a, b)| m.max((a - b).abs()));
        let (first, last) = (&all[0], &all[all.len() - 1]);
        (all.windows(2).map(step).fold(0.0, f32::max), step(&[first.clone(), last.clone()]))
    };
    let ((coarse, total), (fine, _)) = (jumps(40), jumps(160));
    assert!(total > 0.3, "the weights matter: {total}");
    assert!(coarse < 0.2 && fine < 0.4 * coarse, "steps of {coarse}, and of {fine} where they are a quarter");
}

#[test]
fn backs_are_drawn_on_request() {
    let dmesh = pair(
        square("a", DVec3::Z * 3.0, DVec3::ZERO, [255; 3], 1.0),
        square("b", DVec3::new(0.0, 3.0, 3.0), DVec3::ZERO, [255; 3], 1.0),
        0.01,
    );
    let seen = |dmesh: &Dmesh, eye: DVec3| {
        let view = View::look_at(eye, DVec3::ZERO, DVec3::Y, 0.8, 9, 9, 0.1, 9.0);
        draw(dmesh, &view, &one_sample()).mask[40]
    };
    // From below and behind, where the first is out of the question and the second 116° away.
    let under = DVec3::new(0.0, 2.0, -1.0);
    assert_eq!(seen(&dmesh, DVec3::Z * 3.0), 0b11);
    assert_eq!(seen(&dmesh, under), 0);
    assert_ne!(seen(&Dmesh { double_sided: true, ..dmesh }, under), 0);
}

#[test]
fn nothing_is_drawn_of_nothing() {
    let empty = Dmesh { references: vec![], epsilon: 0.0, diagonal: 1.0, double_sided: false };
    let bare = weights::six();
    for dmesh in [&empty, &bare] {
        let how = Rendering { background: [0.0, 1.0, 0.0], ..Rendering::default() };
        let drawn = draw(dmesh, &ahead(7), &how);
        assert!(drawn.picture.texels.iter().all(|t| *t == [0, 255, 0, 255]));
        assert!(drawn.depth.iter().all(|z| *z == f32::INFINITY) && drawn.mask.iter().all(|m| *m == 0));
        assert!(drawn.surface.iter().all(|t| *t == NOTHING));
        let none = View { width: 0, height: 0, ..ahead(1) };
        assert_eq!(draw(dmesh, &none, &how).picture.texels.len(), 0);
    }
    let dmesh = captured(&solids(), 17);
    let away = View { forward: DVec3::NEG_Z, right: DVec3::X, up: DVec3::Y, eye: DVec3::Z * 900.0, ..ahead(9) };
    let nothing = draw(&dmesh, &View { far: 10.0, ..away }, &one_sample());
    assert!(nothing.mask.iter().all(|m| *m == 0));
}

#[test]
fn broken_data_is_refused() {
    let good = pair(
        square("a", DVec3::Z * 3.0, DVec3::ZERO, [0; 3], 1.0),
        square("b", DVec3::Z * 4.0, DVec3::ZERO, [0; 3], 1.0),
        0.1,
    );
    assert!(good.check().is_ok());
    let broken = |expect: &str, change: &dyn Fn(&mut Dmesh)| {
        let mut dmesh = good.clone();
        change(&mut dmesh);
        let error = Model::new(dmesh).err().expect(expect).to_string();
        assert!(error.contains(expect), "{error}");
    };
    let mesh = |change: &dyn Fn(&mut Mesh)| {
        let mut mesh = (*good.references[0].mesh).clone();
        change(&mut mesh);
        std::sync::Arc::new(mesh)
    };
    broken("at most 64", &|d| d.references = vec![d.references[0].clone(); 65]);
    broken("epsilon", &|d| d.epsilon = f64::NAN);
    broken("diagonal", &|d| d.diagonal = 0.0);
    broken("another reference", &|d| d.references[1].name = "A".into());
    broken("letters, digits", &|d| d.references[1].name = "../a".into());
    broken("4 vertices", &|d| d.references[0].mesh = mesh(&|m| m.triangles = vec![[0, 1, 4]].into()));
    broken("quality: 1", &|d| d.references[0].mesh = mesh(&|m| m.quality = vec![1.0].into()));
    broken("0 to 1", &|d| d.references[0].mesh = mesh(&|m| m.quality = vec![f32::NAN; 4].into()));
    broken("not finite", &|d| d.references[0].mesh = mesh(&|m| m.positions = vec![[f32::INFINITY; 3]; 4].into()));
    broken("window", &|d| d.references[0].view.far = 0.0);
    broken("right × up", &|d| d.references[0].view.up = DVec3::NEG_Y);
    broken("texels", &|d| {
        let mut image = (*d.references[0].color).clone();
        image.height = 3;
        d.references[0].color = std::sync::Arc::new(image);
    });
    let model = Model::new(good.clone()).unwrap();
    assert!(model.with_meshes(&[]).is_err());
    let meshes = [mesh(&|m| m.triangles = vec![[0, 1, 2]].into()), good.references[1].mesh.clone()];
    assert_eq!(model.with_meshes(&meshes).unwrap().dmesh().references[0].mesh.triangles.len(), 1);
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let model = Model::new(captured(&solids(), 33)).unwrap();
    let view = towards(&solids(), DVec3::new(1.0, 0.5, 0.2), 150);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| model.draw(&view, &Rendering::default(), &Blending::default(), &Stop::default()).unwrap())
    };
    assert_eq!(with(1), with(5));
    let stop = Stop::default();
    stop.set();
    assert!(model.draw(&view, &Rendering::default(), &Blending::default(), &stop).is_err());
}
