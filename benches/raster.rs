//! The rasteriser on a synthetic mesh, and on a model of your own: `FARFIELD_BENCH_MODEL=model.ply cargo bench --bench raster`.

use criterion::{Criterion, criterion_group, criterion_main};
use farfield::{
    formats::{self, DiskFiles, Limits},
    math::Stop,
    raster::{
        Backend, Cpu, Geometry, Options, Prepared, Rendering, Shader, coverage, fragments_in_tiles, nearest, picture,
    },
    scene::{Image, Material, Mesh, Object, Part, Scene, Texture, Wrap},
    view::View,
};
use glam::{DVec3, Mat4};
use std::{hint::black_box, path::Path, sync::Arc};

/// A bumpy torus of 2·rings·sides triangles with a chequered texture.
fn torus(rings: u32, sides: u32) -> Scene {
    let (mut positions, mut uv, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..=rings {
        for j in 0..=sides {
            let (u, v) = (i as f64 / rings as f64, j as f64 / sides as f64);
            let turn = std::f64::consts::TAU;
            let r = 0.4 + 0.03 * libm::sin(turn * 31.0 * u) * libm::sin(turn * 13.0 * v);
            let c = 1.0 + r * libm::cos(turn * v);
            let p = [c * libm::cos(turn * u), r * libm::sin(turn * v), c * libm::sin(turn * u)];
            positions.push(p.map(|c| c as f32));
            uv.push([8.0 * u as f32, 3.0 * v as f32]);
            if i < rings && j < sides {
                let (a, b) = (i * (sides + 1) + j, (i + 1) * (sides + 1) + j);
                triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
            }
        }
    }
    let texel =
        |i: u32| if (i / 16 + i / 512 / 16).is_multiple_of(2) { [200, 180, 90, 255] } else { [40, 60, 120, 255] };
    let texels = (0..512 * 512).map(texel).collect();
    let texture = Texture {
        image: Arc::new(Image { name: "chequers".to_owned(), width: 512, height: 512, texels }),
        uv_set: 0,
        offset: [0.0; 2],
        rotation: 0.0,
        scale: [1.0; 2],
        wrap: [Wrap::Repeat; 2],
        smooth: true,
    };
    let mesh = Mesh {
        positions: positions.into(),
        uv: [uv.into(), Vec::new().into()],
        triangles: triangles.into(),
        ..Mesh::default()
    };
    let material = Material { base_color_texture: Some(texture), ..Material::default() };
    let part = Part { mesh: Arc::new(mesh), material: Arc::new(material) };
    Scene { objects: vec![Object { name: "torus".to_owned(), transform: Mat4::IDENTITY, parts: vec![part] }] }
}

/// The first adapter, software or not, where there is one.
#[cfg(feature = "gpu")]
fn adapters() -> Vec<(String, Box<dyn Backend>)> {
    use farfield::gpu::{Gpu, Wanted};
    let gpu = Gpu::open(Wanted::Any, 1 << 30).map_err(|e| eprintln!("only the CPU: {e}")).ok();
    gpu.into_iter().map(|g| (g.info.name.clone(), Box::new(g) as Box<dyn Backend>)).collect()
}

#[cfg(not(feature = "gpu"))]
fn adapters() -> Vec<(String, Box<dyn Backend>)> {
    Vec::new()
}

fn measure(c: &mut Criterion, name: &str, scene: &Scene) {
    let bounds = scene.bounds();
    let eye = bounds.centre() + DVec3::new(0.4, 0.35, 0.85).normalize() * bounds.diagonal() * 0.9;
    let far = bounds.diagonal() * 2.0;
    let view = |side| View::look_at(eye, bounds.centre(), DVec3::Y, 0.785, side, side, far * 1e-3, far);
    let geometry = Geometry::new(scene);
    let (options, stop) = (Options::default(), Stop::default());
    let mut group = c.benchmark_group(format!("{name} ({} triangles)", geometry.triangle_count()));
    group.sample_size(20);
    let adapters = adapters();
    let backends: Vec<(&str, &dyn Backend)> = std::iter::once(("cpu", &Cpu as &dyn Backend))
        .chain(adapters.iter().map(|(name, backend)| (&name[..], &**backend)))
        .collect();
    group.bench_function("prepare 1024²", |b| {
        b.iter(|| black_box(Prepared::new(&geometry, &view(1024), &options, &stop).unwrap().tile_count()))
    });
    for (name, backend) in backends {
        group.bench_function(format!("nearest 1024², {name}"), |b| {
            b.iter(|| black_box(nearest(backend, &geometry, &view(1024), &options, &stop)))
        });
        group.bench_function(format!("fragments 1024², {name}"), |b| {
            b.iter(|| {
                let prepared = Prepared::new(&geometry, &view(1024), &options, &stop).unwrap();
                fragments_in_tiles(backend, &prepared, &stop, |_, f| black_box(f.fragments.len()))
            })
        });
        group.bench_function(format!("coverage 1024², {name}"), |b| {
            b.iter(|| coverage(backend, &geometry, &[view(1024)], &options, &stop, |_, c| black_box(c.area[0])))
        });
    }
    group.bench_function("prepare textures", |b| b.iter(|| black_box(Shader::new(&geometry))));
    let shader = Shader::new(&geometry);
    for (name, how) in [
        ("picture 512², 1 sample", Rendering::default().with_samples(1)),
        ("picture 512², 4×4 samples, 2×2 shaded", Rendering::default()),
        ("picture 512², 4×4 samples, all shaded", Rendering::default().with_samples(4)),
    ] {
        group.bench_function(name, |b| b.iter(|| black_box(picture(&Cpu, &shader, &view(512), &how, &stop))));
    }
    group.finish();
}

fn benches(c: &mut Criterion) {
    measure(c, "torus", &torus(180, 100));
    measure(c, "fine torus", &torus(900, 480));
    if let Some(path) = std::env::var_os("FARFIELD_BENCH_MODEL") {
        let path = Path::new(&path);
        match formats::load(path, &DiskFiles, &Limits::default()) {
            Ok(scene) => measure(c, &path.file_name().unwrap_or_default().to_string_lossy(), &scene),
            Err(e) => eprintln!("FARFIELD_BENCH_MODEL: {e}"),
        }
    }
}

criterion_group!(raster, benches);
criterion_main!(raster);
