//! Turns an object by steps of a degree in front of the eye and measures what pops: `cargo run --release --example turn -- ORIGINAL BUNDLE [SIZE [STEPS]]`.
//!
//! ORIGINAL is a scene file, BUNDLE the main file of a stand-in (`out/ori/ori.json`), SIZE the pixels along the longer side of the object's projection
//! (256), STEPS the number of degrees (360). A pixel pops where the stand-in's luminance changes from one frame to the next by 32 of 255 more than the
//! original's does within a pixel around it. Prints the mean and the greatest share of the object's pixels that pop, and those of frames in which
//! another number of maps is drawn than in the one before.

use farfield::{
    certify::directions::view,
    formats::{DiskFiles, Limits, load},
    image::measure::luminances,
    math::Stop,
    raster::{Cpu, Geometry, Light, Rendering, Shading},
    runtime::{Context, SceneStandIn, StandIn, open},
};
use glam::DVec3;
use std::{error::Error, path::Path};

/// Of 255, beyond what the original changes.
const POP: f32 = 32.0;

struct Frame {
    original: Vec<f32>,
    stand_in: Vec<f32>,
    covered: Vec<bool>,
    maps: u32,
}

/// The most that the original changes within a pixel of (x, y).
fn moved(before: &[f32], after: &[f32], n: usize, [x, y]: [usize; 2]) -> f32 {
    let (x0, x1, y0, y1) = (x.saturating_sub(1), (x + 1).min(n - 1), y.saturating_sub(1), (y + 1).min(n - 1));
    (y0..=y1).flat_map(|y| (x0..=x1).map(move |x| y * n + x)).map(|i| (after[i] - before[i]).abs()).fold(0.0, f32::max)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [original, bundle, rest @ ..] = &arguments[..] else {
        return Err("expected ORIGINAL BUNDLE [SIZE [STEPS]]".into());
    };
    let number = |i: usize, default: u32| rest.get(i).map_or(Ok(default), |t| t.parse());
    let (size, steps) = (number(0, 256)?, number(1, 360)?);
    let scene = load(Path::new(original), &DiskFiles, &Limits::default())?;
    let geometry = Geometry::new(&scene);
    let drawn = SceneStandIn::new(&scene, &geometry);
    let opened = open(Path::new(bundle), &DiskFiles, &Limits::default())?;
    let modes = opened.modes();
    let (_, stand_in) = modes.first().ok_or("the bundle cannot be drawn")?;
    let points = scene.points();
    let stop = Stop::default();
    let context = Context { backend: &Cpu, stop: &stop };
    let how = Rendering { shading: Shading::Lit(Light::default()), ..Rendering::default() }.with_samples(2);
    // One window for all frames, so that nothing moves but what turns.
    let still = view(&points, DVec3::Z, size).ok_or("the scene is empty")?;
    let (mut last, mut shares, mut switched): (Option<Frame>, Vec<f64>, Vec<f64>) = (None, Vec::new(), Vec::new());
    for step in 0..steps {
        let angle = f64::from(step).to_radians();
        let direction = DVec3::new(libm::sin(angle), 0.25, libm::cos(angle)).normalize();
        let own = view(&points, direction, size).ok_or("the scene is empty")?;
        let own = farfield::view::View { projection: still.projection, ..own };
        let (a, b) = (drawn.draw(&own, &how, context)?, stand_in.draw(&own, &how, context)?);
        let frame = Frame {
            covered: a.depth.iter().zip(&b.depth).map(|(a, b)| a.is_finite() || b.is_finite()).collect(),
            original: luminances(&a.picture),
            stand_in: luminances(&b.picture),
            maps: b.drawn.map_or(0, |d| d.references),
        };
        if let Some(before) = &last {
            let n = size as usize;
            let pops = |i: &usize| {
                let change = (frame.stand_in[*i] - before.stand_in[*i]).abs();
                frame.covered[*i] && change > POP + moved(&before.original, &frame.original, n, [i % n, i / n])
            };
            let covered = frame.covered.iter().filter(|c| **c).count().max(1);
            let share = (0..n * n).filter(pops).count() as f64 / covered as f64 * 100.0;
            shares.push(share);
            if before.maps != frame.maps {
                switched.push(share);
            }
        }
        last = Some(frame);
    }
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len().max(1) as f64;
    let most = |v: &[f64]| v.iter().copied().fold(0.0, f64::max);
    println!("{steps} frames of {size} px: mean {:.3} %, most {:.3} % of the object pop", mean(&shares), most(&shares));
    println!(
        "{} frames with another number of maps: mean {:.3} %, most {:.3} %",
        switched.len(),
        mean(&switched),
        most(&switched)
    );
    Ok(())
}
