//! Pictures of a voxel field as it is seen from its cell's centre: colours and layers, one pair per frustum.
//!
//! `cargo run --release --example field -- SCENE OUT_FOLDER [RESOLUTION [SAMPLES [CENTRE_X Y Z SIZE]]]`

use farfield::{
    engine::node::{Ctx, Door, List, Node, NodeError},
    formats::{DiskFiles, Limits, load},
    image::{Picture, save_png},
    math::Stop,
    nodes::{render_slices, view_cell},
    scene::builtin,
    voxel::{Field, Frustum},
};
use std::{error::Error, path::Path, sync::Arc, time::Instant};

struct NoDoor;

impl Door for NoDoor {
    fn read(&self, _: &Path) -> Result<Option<farfield::array::Bytes>, NodeError> {
        Ok(None)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [source, out, rest @ ..] = &args[..] else {
        return Err("usage: field SCENE OUT_FOLDER [RESOLUTION ...]".into());
    };
    let number = |i: usize, default: f64| rest.get(i).map_or(Ok(default), |a| a.parse::<f64>());
    let scene = match source.strip_prefix("builtin:") {
        Some(name) => builtin::make(name, 1).ok_or("no such built-in scene")?,
        None => load(Path::new(source), &DiskFiles, &Limits::default())?,
    };
    let scene = Arc::new(scene);
    let ctx = Ctx {
        stop: &Stop::default(),
        door: &NoDoor,
        element: None,
        device: None,
        memory: 1 << 32,
        warn: &|w| println!("warning: {w}"),
        progress: &|_, _| {},
    };

    let mut cell = view_cell::Params::default();
    if rest.len() > 2 {
        cell.centre = Some([number(2, 0.0)?, number(3, 0.0)?, number(4, 0.0)?]);
        cell.size = Some([number(5, 1.0)?; 3]);
    }
    let cell = view_cell::ViewCell::run(&cell, view_cell::In { scene: Some(scene.clone()) }, &ctx)?.cell;
    let params = render_slices::Params {
        resolution: number(0, 1024.0)? as u32,
        samples: number(1, 4.0)? as u32,
        ..Default::default()
    };
    let start = Instant::now();
    let inputs = render_slices::In { scene: scene.clone(), cell: cell.clone() };
    let render_slices::Out { slices, fields: List(fields), near } =
        render_slices::RenderSlices::run(&params, inputs, &ctx)?;
    println!(
        "{:.3} s for {} triangles of {} objects",
        start.elapsed().as_secs_f64(),
        scene.triangle_count(),
        scene.objects.len()
    );
    println!(
        "cell {} half {} m, {} layers from {:.2} to {:.2} m",
        cell.centre,
        cell.half,
        slices.layers.len(),
        slices.borders[0],
        slices.borders[slices.layers.len()]
    );
    println!("{} triangles stay geometry", near.triangle_count());
    std::fs::create_dir_all(out)?;
    for ((name, field), frustum) in fields.iter().zip(&slices.frusta) {
        println!("{name}: {:?} pixels, {} voxels, {} objects", frustum.size, field.voxels.len(), field.objects.len());
        let layers = slices.layers.len() as u32;
        save_png(&Path::new(out).join(format!("{name}-colour.png")), &picture(frustum, field, |v| v.color))?;
        let layer = picture(frustum, field, |v| rainbow(u32::from(v.layer) * 1024 / layers));
        save_png(&Path::new(out).join(format!("{name}-layer.png")), &layer)?;
    }
    Ok(())
}

/// The nearest voxel of every pixel.
fn picture(frustum: &Frustum, field: &Field, color: impl Fn(&farfield::voxel::Voxel) -> [u8; 4]) -> Picture {
    let [width, height] = frustum.size;
    let mut texels = vec![[128, 128, 128, 255]; width as usize * height as usize];
    for v in field.voxels.iter().rev() {
        texels[usize::from(v.y) * width as usize + usize::from(v.x)] = color(v);
    }
    Picture { width, height, texels }
}

/// 0 to 1023 as red, yellow, green, blue, with stripes so that neighbouring layers differ.
fn rainbow(t: u32) -> [u8; 4] {
    let ramp = |centre: i64| (255 - (i64::from(t) - centre).abs() * 255 / 400).clamp(0, 255) as u8;
    let stripe = if t % 64 < 32 { 1 } else { 2 };
    [ramp(0).max(ramp(1400)) / stripe, ramp(400) / stripe, ramp(850) / stripe, 255]
}
