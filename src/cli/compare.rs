//! `farfield compare`.

use super::{
    Done, Exit,
    backend::BackendArgs,
    interrupt, print,
    scene::{exists, load},
    terminal, verdict,
};
use crate::{
    certify::{self, Bound, Choice, CompareError, Comparison, Context, Mode, Sampling, Subject, Viewing},
    formats::Limits,
    image::encode_png,
    raster::Geometry,
    regular,
    runtime::SceneStandIn,
    view::{Cell, Region},
};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// Certifies how much one scene differs from another, seen from a cell
#[derive(clap::Args)]
pub struct Args {
    /// The original: glTF, GLB, OBJ, PLY or scene TOML, or builtin:NAME
    original: PathBuf,
    /// What stands in for it, the same kinds of file
    stand_in: PathBuf,
    /// The view cell: its centre and its side lengths, metres
    #[arg(long, value_name = "X,Y,Z,SX,SY,SZ", value_parser = cell, allow_hyphen_values = true)]
    cell: Cell,
    /// What the stand-in was simplified from; its figures are the ceiling
    #[arg(long, value_name = "FILE")]
    ceiling: Option<PathBuf>,
    /// Views, the eight corners of the cell first
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(8..=100_000))]
    views: u32,
    /// Seed of the sequence of views
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Width and height of a picture, pixels
    #[arg(long, value_name = "PX", default_value_t = 1024)]
    resolution: u32,
    /// Field of view of a picture, degrees
    #[arg(long, value_name = "DEG", default_value_t = 45.0)]
    fov: f64,
    /// Samples of a pixel in x and in y
    #[arg(long, value_name = "N", default_value_t = 4)]
    samples: u32,
    /// Which colours are compared
    #[arg(long, value_enum, default_value_t = Shading::Auto)]
    shading: Shading,
    /// The displacement on the screen that is allowed, pixels
    #[arg(long, value_name = "PX", default_value_t = 1.0)]
    bound: f64,
    /// Lets scenes name files outside their own folder
    #[arg(long)]
    allow_outside: bool,
    #[command(flatten)]
    backend: BackendArgs,
    /// Write certificate.json and pictures/ there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the whole certificate as JSON instead of its verdict and summary
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Shading {
    /// unlit, or noise where the original has no colour
    Auto,
    /// The base colour as it is
    Unlit,
    /// A sun and a sky; unlit materials as they are
    Lit,
    /// Base colour times a 3D noise
    Noise,
}

/// Centre and side lengths.
fn cell(text: &str) -> Result<Cell, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|n| n.trim().parse().map_err(|_| format!("`{n}` is no number")))
        .collect::<Result<_, _>>()?;
    let [x, y, z, sx, sy, sz] = numbers[..] else {
        return Err(format!("expected six numbers X,Y,Z,SX,SY,SZ, found {}", numbers.len()));
    };
    let cell = Cell { centre: DVec3::new(x, y, z), half: DVec3::new(sx, sy, sz) * 0.5 };
    if !(cell.centre.is_finite() && cell.half.is_finite() && cell.half.min_element() > 0.0) {
        return Err("expected a finite centre and side lengths > 0".into());
    }
    Ok(cell)
}

pub fn run(args: &Args) -> Done {
    let limits = Limits { allow_outside: args.allow_outside, ..Limits::default() };
    let stop = interrupt::stop()?;
    for path in [Some(&args.original), Some(&args.stand_in), args.ceiling.as_ref()].into_iter().flatten() {
        exists(path)?;
    }
    let original = load(&args.original, &limits, &stop)?;
    let stand_in = load(&args.stand_in, &limits, &stop)?;
    let ceiling_mesh = args.ceiling.as_deref().map(|path| load(path, &limits, &stop)).transpose()?;
    // Built-in scenes have no file.
    let bytes = regular::read(&args.stand_in).unwrap_or_default();
    let viewing = Viewing {
        sampling: Sampling {
            views: args.views,
            seed: args.seed,
            resolution: args.resolution,
            fov: args.fov.to_radians(),
        },
        samples_per_axis: args.samples,
        shading: match args.shading {
            Shading::Auto => Choice::Auto,
            Shading::Unlit => Choice::Unlit,
            Shading::Lit => Choice::Lit,
            Shading::Noise => Choice::Noise,
        },
    };
    let backend = args.backend.open()?;
    let bar = terminal::bar("views");
    let progress = |done: u64, total: u64| {
        bar.set_length(total);
        bar.set_position(done);
    };
    let context = Context { backend: backend.raster(), stop: &stop, progress: &progress };
    let geometry = Geometry::new(&stand_in);
    let drawn = SceneStandIn::new(&stand_in, &geometry);
    let modes = [Mode { name: String::new(), stand_in: &drawn }];
    let region = Region::Box(args.cell);
    let ceiling = |mesh| certify::ceiling(&original, mesh, &region, &viewing, args.bound, context);
    let comparison = ceiling_mesh.as_ref().map(ceiling).transpose().and_then(|ceiling| {
        let options = certify::Options {
            viewing,
            bound: Bound {
                kind: "given on the command line".into(),
                value: args.bound,
                unit: "px".into(),
                held: false,
            },
            stand_in: Subject {
                name: args.stand_in.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned()),
                blake3: if bytes.is_empty() { String::new() } else { blake3::hash(&bytes).to_hex().to_string() },
            },
            bytes: bytes.len() as u64,
            ceiling,
            may_be_unseen: false,
        };
        certify::compare(&original, &modes, &region, &options, context)
    });
    bar.finish_and_clear();
    backend.warn();
    let comparison = comparison.map_err(|e| Exit::say(exit_code(&e), e))?;
    if let Some(folder) = &args.out {
        write(folder, &comparison).map_err(|e| Exit::say(1, e))?;
    }
    let json = comparison.certificate.to_json();
    if args.json {
        return print(&json);
    }
    let certificate = serde_json::from_str(&json).map_err(|e| Exit::say(1, e))?;
    print(&verdict::text(&certificate))?;
    print(&figures(&comparison))?;
    match &args.out {
        Some(folder) => print(&format!("wrote {} and its pictures\n", folder.join("certificate.json").display())),
        None => Ok(()),
    }
}

/// What was counted, a line for each measure that found something.
fn figures(comparison: &Comparison) -> String {
    let f = &comparison.certificate.figures;
    let counts = [
        ("missing", f.missing_px, f.band.missing_px),
        ("extra", f.extra_px, f.band.extra_px),
        ("wrong surface", f.wrong_surface_px, f.band.wrong_surface_px),
        ("in front", f.in_front_px, f.band.in_front_px),
    ];
    let mut out = String::new();
    for (name, away, band) in counts {
        if away.max + band.max > 0.0 {
            let (mean, worst, edge, edge_worst) = (away.mean, away.max, band.mean, band.max);
            out += &format!("  {name}: {mean} px a view (worst {worst}); at edges {edge} px (worst {edge_worst})\n");
        }
    }
    let lost = f.lost_detail_px;
    if lost.max > 0.0 {
        out += &format!("  lost detail: {} px a view (worst {})\n", lost.mean, lost.max);
    }
    if f.crack_px.total > 0 {
        out += &format!("  cracks: {} px in all views together\n", f.crack_px.total);
    }
    out + &format!(
        "  outlines moved by {} px at most; of {} px that are covered\n",
        f.max_deviation_px, f.covered_px.mean
    )
}

fn exit_code(error: &CompareError) -> u8 {
    match error {
        CompareError::Stopped(_) => 130,
        CompareError::Bound { .. } | CompareError::Resolution { .. } | CompareError::FieldOfView(_) => 2,
        _ => 1,
    }
}

fn write(folder: &Path, comparison: &Comparison) -> Result<(), String> {
    let pictures = folder.join("pictures");
    let wrong = |path: &Path, e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
    std::fs::create_dir_all(&pictures).map_err(|e| wrong(&pictures, &e))?;
    for (name, picture) in &comparison.pictures {
        let path = pictures.join(format!("{name}.png"));
        let bytes = encode_png(picture).map_err(|e| wrong(&path, &e))?;
        std::fs::write(&path, bytes).map_err(|e| wrong(&path, &e))?;
    }
    let path = folder.join("certificate.json");
    std::fs::write(&path, comparison.certificate.to_json()).map_err(|e| wrong(&path, &e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_is_six_numbers() {
        let c = cell("1,-2, 3,4,6,8").unwrap();
        assert_eq!((c.centre, c.half), (DVec3::new(1.0, -2.0, 3.0), DVec3::new(2.0, 3.0, 4.0)));
        for (text, message) in [("1,2,3", "six numbers"), ("1,2,x,1,1,1", "`x`"), ("1,2,3,0,1,1", "> 0")] {
            assert!(cell(text).unwrap_err().contains(message), "{text}");
        }
    }
}
