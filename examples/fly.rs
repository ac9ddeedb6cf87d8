//! Flies around a baked DMesh and writes a PNG file for each frame:
//! `cargo run --release --example fly -- BUNDLE SIZE FRAMES OUT [PATH] [unlit|lit|glossy]`.
//!
//! BUNDLE is the folder with `dmesh.json`, SIZE `width,height` in pixels, OUT a folder. PATH is `orbit`, once around the object, or a TOML or
//! JSON file of keyframes in metres, through which the camera moves smoothly (Catmull-Rom):
//!
//! ```toml
//! fov = 45.0       # vertical, degrees
//! closed = false   # whether the path ends where it began
//! [[keyframes]]
//! eye = [3.0, 1.0, 4.0]
//! target = [0.0, 0.5, 0.0]
//! ```

use farfield::{
    formats::{DiskFiles, Limits},
    image::save_png,
    math::{Aabb, Stop},
    raster::{Gloss, Light, Rendering, Shading},
    runtime::dmesh::{Model, read},
    view::View,
};
use glam::{DVec3, Vec3};
use serde::Deserialize;
use std::{error::Error, f64::consts::TAU, path::Path, time::Instant};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Flight {
    #[serde(default = "default_fov")]
    fov: f64,
    #[serde(default)]
    closed: bool,
    keyframes: Vec<Keyframe>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct Keyframe {
    eye: [f64; 3],
    target: [f64; 3],
}

fn default_fov() -> f64 {
    45.0
}

impl Flight {
    fn load(path: &str) -> Result<Self, Box<dyn Error>> {
        let text = std::fs::read_to_string(path).map_err(|e| format!("{path}: {e}"))?;
        let json = Path::new(path).extension().is_some_and(|e| e == "json");
        let flight: Self = if json { serde_json::from_str(&text)? } else { toml::from_str(&text)? };
        if flight.keyframes.is_empty() {
            return Err(format!("{path}: no keyframes").into());
        }
        if !(flight.fov > 0.0 && flight.fov < 180.0) {
            return Err(format!("{path}: fov {}; expected an angle between 0 and 180 degrees", flight.fov).into());
        }
        Ok(flight)
    }

    /// Once around `bounds`, rising and sinking.
    fn orbit(bounds: &Aabb) -> Self {
        let (centre, reach) = (bounds.centre(), bounds.diagonal() * 1.3);
        let keyframe = |i: u32| {
            let angle = TAU * f64::from(i) / 16.0;
            let up = 0.3 + 0.25 * libm::sin(2.0 * angle);
            let d = DVec3::new(libm::sin(angle), up, libm::cos(angle));
            Keyframe { eye: (centre + d.normalize() * reach).to_array(), target: centre.to_array() }
        };
        Self { fov: default_fov(), closed: true, keyframes: (0..16).map(keyframe).collect() }
    }

    /// Eye and target at `t` from 0 to 1.
    fn at(&self, t: f64) -> (DVec3, DVec3) {
        let n = self.keyframes.len();
        let along = t * if self.closed { n } else { n - 1 } as f64;
        let (first, part) = (along.floor(), along - along.floor());
        let key = |offset: i64| {
            let i = first as i64 + offset;
            let i = if self.closed { i.rem_euclid(n as i64) } else { i.clamp(0, n as i64 - 1) };
            self.keyframes[i as usize]
        };
        let keys = [-1, 0, 1, 2].map(key);
        let curve = |get: fn(&Keyframe) -> [f64; 3]| {
            let [a, b, c, d] = keys.map(|k| DVec3::from(get(&k)));
            let (p, p2, p3) = (part, part * part, part * part * part);
            (b * 2.0 + (c - a) * p + (a * 2.0 - b * 5.0 + c * 4.0 - d) * p2 + (b * 3.0 - a - c * 3.0 + d) * p3) * 0.5
        };
        (curve(|k| k.eye), curve(|k| k.target))
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [bundle, size, frames, out, rest @ ..] = &args[..] else {
        return Err("expected BUNDLE SIZE FRAMES OUT [PATH] [unlit|lit|glossy]".into());
    };
    let (width, height) = size.split_once(',').ok_or("expected a size of width,height")?;
    let (width, height, frames): (u32, u32, u32) = (width.parse()?, height.parse()?, frames.parse()?);
    let bundle = read(Path::new(bundle), &DiskFiles, &Limits::default())?;
    let vertices = bundle.dmesh.references.iter().flat_map(|r| r.mesh.positions.iter());
    let bounds = Aabb::of(vertices.map(|p| Vec3::from(*p)));
    let flight = match rest.first().map(String::as_str) {
        None | Some("orbit") => Flight::orbit(&bounds),
        Some(path) => Flight::load(path)?,
    };
    let gloss = Some(Gloss { strength: 0.4, exponent: 40.0 });
    let shading = match rest.get(1).map(String::as_str) {
        None | Some("unlit") => Shading::Unlit,
        Some("lit") => Shading::Lit(Light::default()),
        Some("glossy") => Shading::Lit(Light { gloss, ..Light::default() }),
        Some(other) => return Err(format!("`{other}`: expected unlit, lit or glossy").into()),
    };
    let how = Rendering { shading, ..Rendering::default() };
    let blending = bundle.blending;
    let model = Model::new(bundle.dmesh)?;
    std::fs::create_dir_all(out)?;
    let clock = Instant::now();
    let mut triangles = 0;
    for frame in 0..frames {
        let steps = if flight.closed { frames } else { frames.saturating_sub(1) };
        let (eye, target) = flight.at(f64::from(frame) / f64::from(steps.max(1)));
        let far = (bounds.centre() - eye).length() + bounds.diagonal();
        let view = View::look_at(eye, target, DVec3::Y, flight.fov.to_radians(), width, height, far * 1e-4, far);
        let drawn = model.draw(&view, &how, &blending, &Stop::default())?;
        let of = |s: &farfield::runtime::dmesh::Selected| model.dmesh().references[s.reference].mesh.triangles.len();
        triangles += drawn.selected.iter().map(of).sum::<usize>();
        save_png(&Path::new(out).join(format!("{frame:04}.png")), &drawn.picture)?;
    }
    println!(
        "{frames} frames of {width} × {height} pixels in {:.1?}; {} triangles a frame",
        clock.elapsed(),
        triangles / frames.max(1) as usize
    );
    Ok(())
}
