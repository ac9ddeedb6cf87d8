//! Renders a model to a PNG file: `cargo run --release --example render -- MODEL EYE TARGET SIZE OUT.png [unlit|lit]`.
//!
//! EYE and TARGET are `x,y,z` in metres, or `auto` for a look at the whole model from the front, right and above;
//! SIZE is `width,height` in pixels.

use farfield::{
    formats::{self, DiskFiles, Limits},
    image::save_png,
    math::Stop,
    raster::{Cpu, Geometry, Light, Rendering, Shader, Shading, render},
    view::View,
};
use glam::DVec3;
use std::{error::Error, path::Path, time::Instant};

fn numbers(text: &str) -> Result<Vec<f64>, Box<dyn Error>> {
    Ok(text.split(',').map(str::parse).collect::<Result<_, _>>()?)
}

fn point(text: &str, auto: DVec3) -> Result<DVec3, Box<dyn Error>> {
    if text == "auto" {
        return Ok(auto);
    }
    match numbers(text)?[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        _ => Err(format!("`{text}`: expected x,y,z").into()),
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [model, eye, target, size, out, rest @ ..] = &args[..] else {
        return Err("expected MODEL EYE TARGET SIZE OUT.png [unlit|lit]".into());
    };
    let path = Path::new(model);
    let scene = match model.strip_prefix("builtin:") {
        Some(name) => farfield::scene::builtin::make(name, 1).ok_or("no such scene")?,
        None => formats::load(path, &DiskFiles, &Limits::default())?,
    };
    let bounds = scene.bounds();
    let target = point(target, bounds.centre())?;
    let eye = point(eye, target + DVec3::new(0.5, 0.35, 0.9).normalize() * bounds.diagonal() * 1.1)?;
    let [width, height] = numbers(size)?[..] else { return Err("expected a size of width,height".into()) };
    let far = (bounds.centre() - eye).length() + bounds.diagonal();
    let view = View::look_at(eye, target, DVec3::Y, 0.785, width as u32, height as u32, far * 1e-4, far);
    let shading = match rest.first().map(String::as_str) {
        Some("lit") => Shading::Lit(Light::default()),
        _ => Shading::Unlit,
    };
    let clock = Instant::now();
    let geometry = Geometry::new(&scene);
    let shader = Shader::new(&geometry);
    let ready = clock.elapsed();
    let done = render(&Cpu, &shader, &view, &Rendering { shading, ..Rendering::default() }, &Stop::default())?;
    let seen = done.nearest.triangle.iter().filter(|t| **t != farfield::raster::NOTHING).count();
    println!(
        "{} triangles; prepared in {ready:.1?}, rendered in {:.1?}; {seen} of {} pixels covered",
        geometry.triangle_count(),
        clock.elapsed() - ready,
        done.nearest.triangle.len(),
    );
    save_png(Path::new(out), &done.picture)?;
    Ok(())
}
