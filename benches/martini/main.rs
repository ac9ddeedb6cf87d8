//! Depth meshes beside the npm package `@mapbox/martini` on identical orthographic height maps, at equal measured vertical error:
//! `cargo bench --bench martini -- [MODEL.ply …]`.
//!
//! Needs Node and npm, which install the package into a temporary folder. Martini knows no background, so background
//! is filled with the farthest depth. Both meshes are measured by the same code, `depth_mesh::measure`.

#[path = "../support/maps.rs"]
#[expect(dead_code, reason = "other benchmarks use the rest")]
mod maps;

use farfield::{
    depth_mesh::{DepthMap, Distance, ErrorMeasure, Hierarchy, Options, Segmentation, Workspace, measure},
    math::Aabb,
};
use glam::DVec3;
use std::{
    error::Error,
    fs,
    io::{BufRead, BufReader, Write},
    path::{Path, PathBuf},
    process::{Child, ChildStdin, ChildStdout, Command, Stdio},
    time::Instant,
};

/// Measurements of which the median is told.
const TIMES: usize = 15;

fn median(mut work: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..TIMES)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[TIMES / 2]
}

/// The Node process that runs martini: one answer per line of orders.
struct Martini {
    process: Child,
    orders: ChildStdin,
    answers: BufReader<ChildStdout>,
    folder: PathBuf,
}

impl Martini {
    fn start(folder: &Path) -> Result<Self, Box<dyn Error>> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/martini/martini.mjs");
        let installed = Command::new("npm")
            .args(["install", "--silent", "--no-save", "--prefix"])
            .arg(folder)
            .arg("@mapbox/martini@0.2.0")
            .status()?;
        if !installed.success() {
            return Err("npm could not install @mapbox/martini".into());
        }
        let mut process =
            Command::new("node").arg(script).arg(folder).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let orders = process.stdin.take().ok_or("no standard input")?;
        let answers = BufReader::new(process.stdout.take().ok_or("no standard output")?);
        Ok(Self { process, orders, answers, folder: folder.to_owned() })
    }

    fn ask(&mut self, order: &str) -> Result<Vec<f64>, Box<dyn Error>> {
        writeln!(self.orders, "{order}")?;
        let mut line = String::new();
        self.answers.read_line(&mut line)?;
        line.split_whitespace()
            .map(|n| n.parse::<f64>().map_err(|e| format!("martini said {line:?}: {e}").into()))
            .collect()
    }

    /// Milliseconds of preparation for the size, and of the error map.
    fn load(&mut self, map: &DepthMap) -> Result<[f64; 2], Box<dyn Error>> {
        let bytes: Vec<u8> = map.depth().iter().flat_map(|z| z.to_le_bytes()).collect();
        fs::write(self.folder.join("heights.f32"), bytes)?;
        let answer = self.ask(&format!("load {} {TIMES}", map.side()))?;
        Ok([answer[0], answer[1]])
    }

    /// Triangles for a largest error, as grid points, and milliseconds.
    fn mesh(&mut self, error: f64, times: usize) -> Result<(Vec<[u32; 3]>, f64), Box<dyn Error>> {
        let answer = self.ask(&format!("mesh {error:e} {times}"))?;
        let bytes = fs::read(self.folder.join("mesh.u32"))?;
        let corners: Vec<u32> = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        Ok((corners.as_chunks().0.to_vec(), answer[0]))
    }
}

impl Drop for Martini {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The largest tolerance of which `deviation` is at most `error`, to a thousandth.
fn largest(error: f64, mut deviation: impl FnMut(f64) -> Result<f64, Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    let (mut low, mut high) = (0.0, 2.0 * error);
    while high - low > error * 1e-3 {
        let middle = 0.5 * (low + high);
        if deviation(middle)? <= error { low = middle } else { high = middle }
    }
    Ok(low)
}

fn compare(martini: &mut Martini, name: &str, map: &DepthMap) -> Result<(), Box<dyn Error>> {
    let (least, most) = map.depth().iter().fold((f32::MAX, f32::MIN), |(l, m), z| (l.min(*z), m.max(*z)));
    let range = f64::from(most - least);
    let [prepare, errors] = martini.load(map)?;
    let options =
        |error| Options { error, distance: Distance::Depth, segmentation: Segmentation::None, ..Options::default() };
    let kinds = [("edge", ErrorMeasure::Edge), ("exact", ErrorMeasure::Exact)];
    println!("| {name} {}² | martini | | prepare {prepare:.2} + {errors:.2} | |", map.side());
    for (kind, error) in kinds {
        let init = median(|| drop(Hierarchy::new(map.clone(), &options(error))));
        println!("| | {kind} | | initialise {init:.2} | |");
    }
    for share in [1000.0, 300.0, 100.0] {
        let wanted = range / share;
        let tolerance = largest(wanted, |e| Ok(measure(map, martini.mesh(e, 1)?.0).depth))?;
        let (triangles, time) = martini.mesh(tolerance, TIMES)?;
        let found = measure(map, triangles.iter().copied());
        println!("| 1/{share} | martini | {} | {time:.2} | {:.4} |", triangles.len(), found.depth / wanted);
        for (kind, error) in kinds {
            let hierarchy = Hierarchy::new(map.clone(), &options(error))?;
            let mut workspace = Workspace::default();
            let mut deviation = |tolerance: f64| {
                let t = hierarchy.triangulate(tolerance as f32, &mut workspace);
                Ok(measure(map, t.triangles.iter().map(|c| c.map(|i| t.vertices[i as usize]))).depth)
            };
            // The exact bound holds by itself, up to rounding in 32 bits.
            let tolerance =
                if error == ErrorMeasure::Exact { wanted * (1.0 - 1e-4) } else { largest(wanted, &mut deviation)? };
            let found = deviation(tolerance)?;
            let time = median(|| _ = hierarchy.triangulate(tolerance as f32, &mut workspace));
            let count = workspace.triangulation().triangles.len();
            println!("| | {kind} | {count} | {time:.2} | {:.4} |", found / wanted);
        }
    }
    Ok(())
}

/// Octaves of waves, as rough on every scale.
fn terrain(side: u32) -> Result<DepthMap, Box<dyn Error>> {
    let bounds = Aabb { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
    let depth = (0..side * side).map(|at| {
        let [x, y] = [at % side, at / side].map(|c| 2.0 * f64::from(c) / f64::from(side - 1) - 1.0);
        let octave = |o: i32| {
            let (f, turn) = (f64::from(1 << o) * 1.7, f64::from(o) * 2.4);
            let (u, v) = (x * libm::cos(turn) - y * libm::sin(turn), x * libm::sin(turn) + y * libm::cos(turn));
            0.4 / f64::from(1 << o) * libm::sin(f * u + turn) * libm::cos(f * v + 1.3 * turn)
        };
        (5.0 + (0..8).map(octave).sum::<f64>()) as f32
    });
    Ok(DepthMap::new(maps::view(&bounds, DVec3::Y, side, false), depth.collect())?)
}

/// Background at the farthest depth.
fn filled(map: &DepthMap) -> Result<DepthMap, Box<dyn Error>> {
    let farthest = map.depth().iter().filter(|z| z.is_finite()).fold(0.0f32, |a, z| a.max(*z));
    let depth = map.depth().iter().map(|z| z.min(farthest)).collect();
    Ok(DepthMap::new(*map.view(), depth)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::temp_dir().join(format!("farfield-martini-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    let run = || -> Result<(), Box<dyn Error>> {
        let mut martini = Martini::start(&folder)?;
        println!(
            "| map, error as a share of the range | | triangles | ms | measured error over wanted |\n|---|---|---|---|---|"
        );
        for side in [513, 1025] {
            compare(&mut martini, "terrain", &terrain(side)?)?;
            for path in std::env::args_os().skip(1).filter(|a| !a.to_string_lossy().starts_with("--")) {
                let object = maps::model(Path::new(&path), side, false)?;
                let front = object.maps.get(4).ok_or("six maps are made")?;
                compare(&mut martini, &object.name, &filled(front)?)?;
            }
        }
        Ok(())
    };
    let result = run();
    fs::remove_dir_all(&folder)?;
    result
}
