//! Shows which references blend where, and how fine the meshes are:
//! `cargo run --release --example occupancy -- ORIGINAL BUNDLE OUT.png [DISTANCE]`.
//!
//! ORIGINAL is a scene file, BUNDLE the folder with `dmesh.json`, DISTANCE that of the eye in diagonals of the object (1.5). Five pictures side by
//! side: the original, the stand-in (both lit), its occupancy (a colour for each reference where it is alone, orange-brown where several blend), and
//! the triangles of the static meshes and of those made for this view, each in a colour of its own. After figures 19 to 21 of
//! Pajarola, Sainz and Meng (2003).

use farfield::{
    formats::{DiskFiles, Limits, load},
    image::{Picture, save_png},
    math::Stop,
    raster::{Cpu, Geometry, NOTHING, Rendering, Shader, Shading, picture},
    runtime::dmesh::{Drawn, Meshes, Model, read, select},
    view::View,
};
use glam::DVec3;
use std::{error::Error, f64::consts::FRAC_PI_4, path::Path};

const SIDE: u32 = 512;
const BLENDED: [u8; 4] = [200, 110, 40, 255];
const GREY: [u8; 4] = [128, 128, 128, 255];

/// Colours far apart for numbers side by side.
fn color(n: u32) -> [u8; 4] {
    let h = n.wrapping_mul(0x9E37_79B9) ^ (n.wrapping_mul(0x85EB_CA6B) >> 13);
    [64 + (h >> 24) as u8 / 2, 64 + (h >> 16 & 255) as u8 / 2, 64 + (h >> 8 & 255) as u8 / 2, 255]
}

fn triangles(drawn: &Drawn) -> Picture {
    let texel = |s: &u32| if *s == NOTHING { GREY } else { color(*s + 1) };
    Picture { width: SIDE, height: SIDE, texels: drawn.surface.iter().map(texel).collect() }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [original, bundle, out, rest @ ..] = &arguments[..] else {
        return Err("expected ORIGINAL BUNDLE OUT.png [DISTANCE]".into());
    };
    let times: f64 = rest.first().map_or(Ok(1.5), |t| t.parse())?;
    let scene = load(Path::new(original), &DiskFiles, &Limits::default())?;
    let bundle = read(Path::new(bundle), &DiskFiles, &Limits::default())?;
    let (bounds, stop) = (scene.bounds(), Stop::default());
    let diagonal = bounds.diagonal();
    let eye = bounds.centre() + DVec3::new(0.45, 0.35, 0.82).normalize() * diagonal * times;
    let near = ((times - 0.6) * diagonal).max(0.01 * diagonal);
    let view = View::look_at(eye, bounds.centre(), DVec3::Y, FRAC_PI_4, SIDE, SIDE, near, (times + 0.6) * diagonal);
    let how = Rendering { shading: Shading::Lit(Default::default()), ..Rendering::default() };

    let geometry = Geometry::new(&scene);
    let original = picture(&Cpu, &Shader::new(&geometry), &view, &how, &stop)?;
    let model = Model::new(bundle.dmesh.clone())?;
    let fixed = model.draw(&view, &how, &bundle.blending, &stop)?;
    let occupancy = |(mask, surface): (&u64, &u32)| match mask.count_ones() {
        _ if *surface == NOTHING => GREY,
        1 => color(mask.trailing_zeros() * 7 + 3),
        _ => BLENDED,
    };
    let texels = fixed.mask.iter().zip(&fixed.surface).map(occupancy).collect();
    let occupancy = Picture { width: SIDE, height: SIDE, texels };
    let mut pictures = vec![original, fixed.picture.clone(), occupancy, triangles(&fixed)];
    if let Some(frames) = &bundle.frames {
        let meshes = Meshes::new(&bundle.dmesh, frames)?;
        let selected = select(&bundle.dmesh, &view, bundle.blending.weights);
        let model = model.with_meshes(&meshes.for_view(&view, &selected))?;
        pictures.push(triangles(&model.draw(&view, &how, &bundle.blending, &stop)?));
    }

    let width = SIDE * pictures.len() as u32;
    let mut sheet = Picture { width, height: SIDE, texels: Vec::with_capacity((width * SIDE) as usize) };
    for y in 0..SIDE as usize {
        let row = y * SIDE as usize..(y + 1) * SIDE as usize;
        pictures.iter().for_each(|p| sheet.texels.extend_from_slice(&p.texels[row.clone()]));
    }
    save_png(Path::new(out), &sheet)?;
    Ok(())
}
