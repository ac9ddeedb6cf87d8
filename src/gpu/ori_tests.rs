//! Parity of relief impostors drawn by the device with those drawn by the CPU.

use super::{
    DrawnByGpu, Gpu, LoadedOri, ori,
    tests::{gpu, same_layout},
};
use crate::{
    math::Stop,
    raster::{Gloss, Light, Noise, Rendering, Shading},
    relief::{DepthBits, Search, Strategy, Trace},
    runtime::ori::{
        Drawing, Instance, Model, Ori, SHADER, draw, draw_instances,
        sample::{impostor, usual},
    },
    scene::builtin,
    view::{Projection, View},
};
use glam::{DQuat, DVec3};
use std::sync::Arc;
use wgpu::naga::{front::wgsl, valid};

#[test]
fn the_shader_is_valid_and_shares_the_structs() {
    let module = wgsl::parse_str(SHADER).unwrap_or_else(|e| panic!("{}", e.emit_to_string(SHADER)));
    valid::Validator::new(valid::ValidationFlags::all(), valid::Capabilities::default()).validate(&module).unwrap();
    same_layout!(
        &module,
        "Frame",
        ori::Frame,
        clip,
        depth,
        eye,
        to_sun,
        sun,
        sky,
        ground,
        near,
        far,
        sample_size,
        shading
    );
    same_layout!(
        &module,
        "Impostor",
        ori::Impostor,
        centre,
        extent,
        side,
        squares,
        depths,
        codes,
        levels,
        emits,
        strategy,
        steps,
        halvings,
        wall
    );
    same_layout!(&module, "Map", ori::Map, rows, window, deep, step, texel, first);
    same_layout!(&module, "Instance", ori::Place, place, rotation, maps);
}

/// How two pictures differ.
#[derive(Debug, Default)]
struct Difference {
    covered: usize,
    /// Pixels that one of them covers.
    coverage: usize,
    /// Pixels that both cover, with depths farther apart than 10⁻⁴ of the object's radius; the farthest apart of the others, in radii.
    depths: usize,
    farthest: f64,
    /// Pixels with a channel farther apart than 3; the farthest apart of the others, and of all.
    colors: usize,
    most: u8,
    extreme: u8,
}

/// Of depth, in radii.
const CLOSE: f64 = 1e-4;

fn difference(texels: &[[u8; 4]], depth: &[f32], other: &DrawnByGpu, radius: f64) -> Difference {
    let mut d = Difference::default();
    for i in 0..depth.len() {
        let (a, b) = (f64::from(depth[i]), f64::from(other.depth[i]));
        d.covered += usize::from(a.is_finite());
        let apart = (a - b).abs() / radius;
        match (a.is_finite(), b.is_finite()) {
            (false, false) => {}
            (true, true) if apart <= CLOSE => d.farthest = d.farthest.max(apart),
            (true, true) => d.depths += 1,
            _ => d.coverage += 1,
        }
        let far = (0..3).map(|k| texels[i][k].abs_diff(other.picture.texels[i][k])).max().unwrap_or(0);
        d.extreme = d.extreme.max(far);
        if far > 3 {
            d.colors += 1;
        } else {
            d.most = d.most.max(far);
        }
    }
    d
}

impl Difference {
    /// At most two pixels in a thousand are covered by one alone, and as many at other depths; colours of at most two in a hundred are farther apart
    /// than 3 of 255.
    fn check(&self, what: &str) {
        eprintln!("{what}: {self:?}");
        assert!(self.covered > 500, "{what}: {self:?}");
        let per_thousand = |n: usize| n * 1000 <= self.covered * 2;
        assert!(per_thousand(self.coverage), "{what}: {self:?}");
        assert!(per_thousand(self.depths), "{what}: {self:?}");
        assert!(self.colors * 50 <= self.covered, "{what}: {self:?}");
    }
}

fn seen_from(model: &Model, d: DVec3, orthographic: bool) -> View {
    let bounds = model.ori().bounds;
    let (centre, radius) = (bounds.centre(), bounds.diagonal() * 0.5);
    let eye = centre + d.normalize() * radius * 2.6;
    let view = View::look_at(eye, centre, DVec3::Y, 0.8, 150, 130, radius * 0.1, radius * 5.0);
    if !orthographic {
        return view;
    }
    let half = radius * 1.1;
    View { projection: Projection::Orthographic { left: -half, right: half, bottom: -half, top: half }, ..view }
}

/// The impostor drawn in another way.
fn drawn_as(model: &Model, drawing: Drawing) -> Model {
    Model::new(Ori { drawing, ..model.ori().clone() }).unwrap()
}

fn load(gpu: &Gpu, model: Model) -> (Arc<Model>, LoadedOri) {
    let model = Arc::new(model);
    (model.clone(), gpu.load_ori(model).unwrap())
}

fn compare(gpu: &Gpu, (model, loaded): &(Arc<Model>, LoadedOri), view: &View, how: &Rendering) -> Difference {
    let stop = Stop::default();
    let cpu = draw(model, view, how, &stop).unwrap();
    let other = gpu.draw_ori(&[loaded], &[Instance::default()], view, how, &stop).unwrap();
    difference(&cpu.picture.texels, &cpu.depth, &other, model.ori().bounds.diagonal() * 0.5)
}

fn flat(shading: Shading) -> Rendering {
    Rendering { shading, ..Rendering::default() }.with_samples(1)
}

#[test]
fn parity_of_strategies_and_searches() {
    let Some(gpu) = gpu() else { return };
    let searches = [Search::Pyramid, Search::Linear { steps: 16, halvings: 7 }];
    let strategies = [Strategy::Plane, Strategy::Depth, Strategy::Direction, Strategy::Normal, Strategy::BiasedDepth];
    for name in ["solids", "car"] {
        let scene = builtin::make(name, 1).unwrap();
        let model = impostor(&scene, 96, DepthBits::Eight, usual(), false);
        for (search, strategy) in searches.iter().flat_map(|s| strategies.map(|t| (*s, t))) {
            let drawing = Drawing { trace: Trace { search, ..Trace::default() }, strategy };
            let both = load(gpu, drawn_as(&model, drawing));
            for (d, orthographic) in [
                (DVec3::new(1.0, 0.4, 0.3), false),
                (DVec3::new(-0.4, -0.7, 0.8), false),
                (DVec3::new(-0.2, 0.9, -0.5), true),
            ] {
                let view = seen_from(&both.0, d, orthographic);
                let what = format!("{name} {search:?} {strategy:?} {d}");
                compare(gpu, &both, &view, &flat(Shading::Lit(Light::default()))).check(&what);
            }
        }
    }
}

#[test]
fn parity_along_the_maps_and_inside_the_box() {
    let Some(gpu) = gpu() else { return };
    let scene = builtin::make("solids", 1).unwrap();
    let gloss = Some(Gloss { strength: 0.5, exponent: 30.0 });
    let lit = Shading::Lit(Light { gloss, ..Light::default() });
    let both = load(gpu, impostor(&scene, 97, DepthBits::Sixteen, usual(), true));
    // Rays along a map's own direction cross no cell.
    let along = both.0.maps[3].field.towards;
    let bounds = both.0.ori().bounds;
    let inside = View {
        eye: bounds.centre() + DVec3::new(0.3, 0.2, 0.25) * (bounds.max - bounds.min),
        near: 1e-3,
        ..seen_from(&both.0, DVec3::new(1.0, 0.2, 0.6), false)
    };
    for (what, view) in [
        ("along", seen_from(&both.0, along, true)),
        ("inside", inside),
        ("near the far plane", View { far: (bounds.centre() - inside.eye).length() * 2.0, ..inside }),
    ] {
        for shading in [lit, Shading::Unlit] {
            compare(gpu, &both, &view, &flat(shading)).check(what);
        }
    }
}

/// The CPU samples pixels without edges once, filtered over the pixel, and the device all of them as finely as those at edges.
#[test]
fn supersampled_pictures_are_alike() {
    let Some(gpu) = gpu() else { return };
    let scene = builtin::make("car", 1).unwrap();
    let both = load(gpu, impostor(&scene, 96, DepthBits::Eight, usual(), false));
    let view = seen_from(&both.0, DVec3::new(1.0, 0.4, 0.3), false);
    for samples in [2, 3] {
        let how = Rendering { shading: Shading::Lit(Light::default()), ..Rendering::default() }.with_samples(samples);
        let d = compare(gpu, &both, &view, &how);
        eprintln!("{samples} samples: {d:?}");
        // Depths are those of pixel centres for odd and for even numbers.
        assert!((d.coverage + d.depths) * 500 <= d.covered, "{d:?}");
        assert!(d.colors * 4 <= d.covered, "{d:?}");
    }
}

/// A few instances of two models, before and behind each other.
fn field() -> Vec<Instance> {
    let instance = |i: u32| {
        let (x, z) = (f64::from(i % 6), f64::from(i / 6));
        let turn = f64::from(i) * 2.4;
        Instance {
            model: i % 2,
            rotation: DQuat::from_rotation_y(turn) * DQuat::from_rotation_x(0.3 * libm::sin(turn)),
            scale: 0.6 + 0.1 * f64::from(i % 5),
            translation: DVec3::new(x * 3.1 - 8.0, 0.4 * f64::from(i % 3), z * -3.7),
        }
    };
    (0..24).map(instance).collect()
}

#[test]
fn parity_of_a_field() {
    let Some(gpu) = gpu() else { return };
    let models = ["solids", "car"].map(|name| {
        let scene = builtin::make(name, 1).unwrap();
        load(gpu, impostor(&scene, 64, DepthBits::Eight, usual(), false))
    });
    let (instances, stop) = (field(), Stop::default());
    let view = View::look_at(DVec3::new(3.0, 5.0, 9.0), DVec3::new(0.0, 0.0, -6.0), DVec3::Y, 0.9, 200, 140, 0.1, 60.0);
    let half = 9.0;
    let orthographic = Projection::Orthographic { left: -half, right: half, bottom: -half * 0.7, top: half * 0.7 };
    for view in [view, View { projection: orthographic, ..view }] {
        let how = flat(Shading::Lit(Light::default()));
        let [a, b] = &models;
        let cpu = draw_instances(&[&a.0, &b.0], &instances, &view, &how, &stop).unwrap();
        let other = gpu.draw_ori(&[&a.1, &b.1], &instances, &view, &how, &stop).unwrap();
        difference(&cpu.picture.texels, &cpu.depth, &other, 2.0).check("field");
    }
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let Some(gpu) = gpu() else { return };
    let scene = builtin::make("solids", 1).unwrap();
    let (model, loaded) = load(gpu, impostor(&scene, 16, DepthBits::Eight, usual(), false));
    let (view, stop) = (seen_from(&model, DVec3::X, false), Stop::default());
    let place = [Instance::default()];
    let large = View { width: 8000, height: 8000, ..view };
    let error = gpu.draw_ori(&[&loaded], &place, &large, &Rendering::default(), &stop);
    assert!(error.is_err_and(|e| e.to_string().contains("limit")));
    let error = gpu.draw_ori(&[&loaded], &place, &view, &flat(Shading::Noise(Noise { period: 0.2 })), &stop);
    assert!(error.is_err_and(|e| e.to_string().contains("noise")));
    let none = View { width: 0, ..view };
    assert_eq!(gpu.draw_ori(&[&loaded], &place, &none, &flat(Shading::Unlit), &stop).unwrap().depth.len(), 0);
    // Without instances, the background.
    let how = Rendering { background: [0.0, 0.0, 1.0], ..flat(Shading::Unlit) };
    let drawn = gpu.draw_ori(&[&loaded], &[], &view, &how, &stop).unwrap();
    assert!(drawn.picture.texels.iter().all(|t| *t == [0, 0, 255, 255]));
    assert!(drawn.depth.iter().all(|z| *z == f32::INFINITY));
}
