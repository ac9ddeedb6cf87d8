//! Writes statuary parks like the three scenes of Chen et al. 2003, section 4.1.1: `cargo run --release --example park -- MODELS OUT`.
//!
//! MODELS is a folder with `armadillo.ply`, `bunny.ply`, `cow.ply`, `dragon-res2.ply`, `happy-buddha.ply`, `horse.ply`, `teapot.ply`
//! and `torus-knot.ply`. OUT gets each of them once as a GLB, `park-models.toml`, which places each once, and `park-2m.toml`,
//! `park-4m.toml` and `park-8m.toml`: 64, 132 and 253 statues on 1650 × 2035 m, each scene a subset of the next.
//!
//! Dragon and bunny are the paper's own meshes in the paper's size and as frequent as in its 8M-scene. The other six stand in for the paper's
//! (table 2), whose meshes are not to be had: their numbers are such that the scenes have as many objects as the paper's and about as many
//! polygons. The models have no colour; each gets a kind of stone of its own as colours of its vertices.

use farfield::{
    formats::{self, DiskFiles, GlbOptions, Limits},
    scene::{
        Mesh, Object, Part, Scene,
        builtin::park::{self, Park, Place, Statue},
        names,
    },
};
use glam::{Mat4, Quat, Vec3};
use std::{
    collections::BTreeSet, error::Error, f32::consts::FRAC_PI_2, fmt::Write, path::Path, sync::Arc, time::Instant,
};

/// A model: the file's stem, its name, its height in metres, what it stands in for, how often it is in the 8M-scene, and whether z is up in its file.
struct Model(&'static str, &'static str, f32, &'static str, u32, bool);

/// In the order of their names.
const MODELS: [Model; 8] = [
    Model("armadillo", "armadillo", 23.4, "statue", 4, false),
    Model("happy-buddha", "buddha", 30.8, "easter", 4, false),
    Model("bunny", "bunny", 43.2, "bunny", 26, false),
    Model("cow", "cow", 30.7, "cattle", 97, false),
    Model("dragon-res2", "dragon", 40.4, "dragon", 18, false),
    Model("horse", "horse", 57.2, "horse", 4, true),
    Model("torus-knot", "knot", 46.6, "camel", 4, false),
    Model("teapot", "teapot", 15.0, "venus", 96, false),
];

const SCENES: [(&str, u32); 3] = [("2m", 64), ("4m", 132), ("8m", 253)];

/// The model as a statue: upright, in its size, coloured.
fn statue(folder: &Path, model: &Model, all: &mut Vec<Object>) -> Result<(), Box<dyn Error>> {
    let Model(file, name, height, .., z_up) = model;
    let path = folder.join(file).with_extension("ply");
    let mut object =
        formats::load(&path, &DiskFiles, &Limits::default())?.objects.into_iter().next().ok_or("the file is empty")?;
    let upright = if *z_up { Quat::from_axis_angle(Vec3::X, -FRAC_PI_2) } else { Quat::IDENTITY };
    object.transform = Mat4::from_quat(upright) * object.transform;
    let scale = height / object.bounds().size().y as f32;
    object.transform = Mat4::from_scale(Vec3::splat(scale)) * object.transform;
    object.name = (*name).into();
    all.push(object);
    Ok(())
}

/// The statue's mesh as it stands around the y axis, without a transform.
fn standing(statue: &Statue) -> Object {
    let part = |part: &Part| {
        let place = |p: &[f32; 3]| statue.stand.transform_point3(Vec3::from(*p).as_dvec3()).as_vec3().to_array();
        let positions = part.mesh.positions.iter().map(place).collect();
        let mesh = Mesh { positions, ..(*part.mesh).clone() };
        Part { mesh: Arc::new(mesh), material: part.material.clone() }
    };
    Object { name: statue.name.clone(), transform: Mat4::IDENTITY, parts: statue.parts.iter().map(part).collect() }
}

fn scene_toml(statues: &[Statue], places: &[Place]) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    for place in places {
        let kind = &statues[place.kind].name;
        let (s, c) = (libm::sin(place.turn * 0.5), libm::cos(place.turn * 0.5));
        writeln!(text, "[[place]]\nfile       = \"{kind}.glb\"\nname       = \"{}\"", park::place_name(kind, place))?;
        writeln!(text, "translate  = [{:?}, 0.0, {:?}]\nquaternion = [0.0, {s:?}, 0.0, {c:?}]\n", place.x, place.z)?;
    }
    Ok(text)
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [models, out] = &args[..] else { return Err("expected MODELS OUT".into()) };
    let (models, out) = (Path::new(models), Path::new(out));
    let mut objects = Vec::new();
    for model in &MODELS {
        statue(models, model, &mut objects)?;
    }
    let statues = park::of_models(&names::assemble(objects), &MODELS.map(|m| m.4))?;
    std::fs::create_dir_all(out)?;
    let mut each_once = String::new();
    println!("model       stands for   polygons   width × depth × height, m");
    for (statue, model) in statues.iter().zip(&MODELS) {
        let object = standing(statue);
        let (n, [w, h, d]) = (object.triangle_count(), object.bounds().size().to_array());
        println!("{:<11} {:<10} {n:>10}   {w:.1} × {d:.1} × {h:.1}", statue.name, model.3);
        let glb =
            formats::write_glb(&Scene { objects: vec![object] }, &GlbOptions { unlit: false, normal_maps: false })?;
        std::fs::write(out.join(&statue.name).with_extension("glb"), glb)?;
        writeln!(each_once, "[[place]]\nfile = \"{}.glb\"\n", statue.name)?;
    }
    std::fs::write(out.join("park-models.toml"), each_once)?;
    let footprints: Vec<_> = statues.iter().map(|s| s.footprint).collect();
    for (name, count) in SCENES {
        let places = park::places(&footprints, &Park { count, ..Park::default() })?;
        let path = out.join(format!("park-{name}.toml"));
        std::fs::write(&path, scene_toml(&statues, &places)?)?;
        let clock = Instant::now();
        let scene = formats::load(&path, &DiskFiles, &Limits::default())?;
        let took = clock.elapsed();
        let meshes: BTreeSet<_> = scene.objects.iter().flat_map(|o| &o.parts).map(|p| Arc::as_ptr(&p.mesh)).collect();
        let of = |k: usize| places.iter().filter(|p| p.kind == k).count();
        let counts: Vec<String> = (statues.iter().enumerate()).map(|(k, s)| format!("{} {}", of(k), s.name)).collect();
        println!(
            "{}: {} statues ({}), {} polygons, {} meshes in memory, loaded in {took:.2?}",
            path.display(),
            scene.objects.len(),
            counts.join(", "),
            scene.triangle_count(),
            meshes.len(),
        );
    }
    Ok(())
}
