//! Draws a scene and its stand-in from views of a cell, side by side with their difference:
//! `cargo run --release --example look -- ORIGINAL STAND_IN X,Y,Z,SX,SY,SZ COUNT RESOLUTION FOLDER`.
//!
//! ORIGINAL is a model or `builtin:NAME`; STAND_IN is what a bake leaves: a GLB file or a manifest such as `mix.json`. The cell is its centre and its side
//! lengths, metres; the first views are from its corners, as in a certificate. Writes `FOLDER/00.png` and so on.

use farfield::{
    certify::{Sampling, views},
    formats::{self, DiskFiles, Limits},
    image::{Picture, save_png},
    math::Stop,
    raster::{Cpu, Geometry, Rendering},
    runtime::{self, Context, SceneStandIn, StandIn},
    view::{Cell, Region},
};
use glam::DVec3;
use std::{error::Error, path::Path};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [original, stand_in, cell, count, resolution, folder] = &args[..] else {
        return Err("expected ORIGINAL STAND_IN X,Y,Z,SX,SY,SZ COUNT RESOLUTION FOLDER".into());
    };
    let scene = match original.strip_prefix("builtin:") {
        Some(name) => farfield::scene::builtin::make(name, 1).ok_or("no such scene")?,
        None => formats::load(Path::new(original), &DiskFiles, &Limits::default())?,
    };
    let numbers: Vec<f64> = cell.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let [x, y, z, sx, sy, sz] = numbers[..] else { return Err("expected six numbers X,Y,Z,SX,SY,SZ".into()) };
    let cell = Cell { centre: DVec3::new(x, y, z), half: DVec3::new(sx, sy, sz) * 0.5 };
    let opened = runtime::open(Path::new(stand_in), &DiskFiles, &Limits::default())?;
    let (_, drawn) = opened.modes().into_iter().next().ok_or("the stand-in has nothing to draw")?;
    let geometry = Geometry::new(&scene);
    let reference = SceneStandIn::new(&scene, &geometry);
    let sampling =
        Sampling { views: count.parse()?, seed: 1, resolution: resolution.parse()?, fov: 45_f64.to_radians() };
    let all = scene.bounds().union(drawn.bounds());
    let context = Context { backend: &Cpu, stop: &Stop::default() };
    let how = Rendering::default().with_samples(2);
    std::fs::create_dir_all(folder)?;
    for (i, view) in views::draw(&Region::Box(cell), &scene.bounds(), &all, &[], &sampling).iter().enumerate() {
        let (a, b) = (reference.draw(view, &how, context)?.picture, drawn.draw(view, &how, context)?.picture);
        let path = Path::new(folder).join(format!("{i:02}.png"));
        save_png(&path, &beside(&a, &b))?;
        println!("{} from {:.1}", path.display(), view.eye);
    }
    Ok(())
}

/// Original, stand-in, and four times their difference.
fn beside(a: &Picture, b: &Picture) -> Picture {
    let difference = |a: &[u8; 4], b: &[u8; 4]| {
        let [r, g, b] = [0, 1, 2].map(|k| a[k].abs_diff(b[k]).saturating_mul(4));
        [r, g, b, 255]
    };
    let row = |y: usize| {
        let line = y * a.width as usize..(y + 1) * a.width as usize;
        let (a, b) = (&a.texels[line.clone()], &b.texels[line]);
        let difference: Vec<[u8; 4]> = a.iter().zip(b).map(|(a, b)| difference(a, b)).collect();
        [a, b, &difference].concat()
    };
    Picture { width: a.width * 3, height: a.height, texels: (0..a.height as usize).flat_map(row).collect() }
}
