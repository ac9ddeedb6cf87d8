//! Tables 1 and 2 of Andújar et al. (2007) for models of your own, with their columns and those that this project adds:
//! `cargo bench --bench ori_tables -- armadillo.ply happy-buddha.ply`. Maps of 256² texels with two samples a side, 320 directions at 256², and as many as
//! `OTHERS` directions between them (1000).

use farfield::{
    capture::{Capturing, capture},
    formats::{DiskFiles, Limits, load},
    math::{Sequence, Stop},
    raster::{Cpu, Geometry, Shader},
    relief::{
        DepthBits, ReliefMap, Resampling, Search, Trace,
        choose::{Perturbation, greedy, perturb},
        coverage::Mask,
        entropy::Probe,
        measure::{Coverage, Original, measure},
        resample,
        select::{Choice, Covered, closest},
        textures::{Compression, compress},
    },
    scene::Scene,
    view::{
        Region,
        directions::{geodesic, icosahedron, look_along},
    },
};
use glam::DVec3;
use rayon::prelude::*;
use std::{path::Path, time::Instant};

const SIDE: u32 = 256;
const SAMPLES: u32 = 2;

fn maps(scene: &Scene, points: &[DVec3], directions: &[DVec3], stop: &Stop) -> Vec<ReliefMap> {
    let geometry = Geometry::new(scene);
    let shader = Shader::new(&geometry);
    let map = |d: &DVec3| {
        let view = look_along(points.iter().copied(), *d, SIDE * SAMPLES, f64::from(SAMPLES)).expect("points");
        let how = Capturing { layers: 1, backs: false };
        let seen = capture(&Cpu, &shader, scene.bounds(), &view, how, stop).expect("no stop");
        resample(&seen, Resampling { samples: SAMPLES, bits: DepthBits::Eight }).expect("a square capture")
    };
    directions.par_iter().map(map).collect()
}

/// Missing pixels of directions between those of the choice, which take that of the nearest.
fn between(coverage: &Coverage, others: &Coverage, choice: Choice) -> (f64, f64) {
    let selection = coverage.select(choice);
    let all = f64::from(coverage.size) * f64::from(coverage.size);
    let missing = |(direction, covered): (&DVec3, &Covered)| {
        let own = closest(&coverage.directions, *direction, 1)[0] as usize;
        let mut union = Mask::empty(covered.original.0.len() * 64);
        for (m, mask) in &covered.maps {
            if selection.subsets[own].maps.contains(m) {
                union.join(mask);
            }
        }
        covered.original.beyond(&union) as f64 / all * 100.0
    };
    let all: Vec<f64> = others.directions.iter().zip(&others.covered).map(missing).collect();
    (all.iter().sum::<f64>() / all.len().max(1) as f64, all.iter().copied().fold(0.0, f64::max))
}

fn rows(coverage: &Coverage, others: &Coverage) {
    println!(
        "| choice | missing min / avg / max % | PLT px | extra avg / max % | maps avg | between avg / max % | s |"
    );
    println!("|---|---|---|---|---|---|---|");
    let best = |goal, neighbours| Choice::Best { goal, neighbours };
    for (name, choice) in [
        ("1 closest", Choice::Closest(1)),
        ("2 closest", Choice::Closest(2)),
        ("3 closest", Choice::Closest(3)),
        ("4 closest", Choice::Closest(4)),
        ("6 closest", Choice::Closest(6)),
        ("best of 6, 0.2 %, the paper's", best(0.002, 0)),
        ("best of 6, 0.2 %", best(0.002, 3)),
        ("best of 6, 0.1 %", best(0.001, 3)),
    ] {
        let start = Instant::now();
        let s = coverage.select(choice);
        let seconds = start.elapsed().as_secs_f64();
        let (m, x, between) = (s.missing(), s.extra(), between(coverage, others, choice));
        println!(
            "| {name} | {:.3} / {:.3} / {:.3} | {:.0} | {:.3} / {:.3} | {:.2} | {:.3} / {:.3} | {seconds:.2} |",
            m.min * 100.0,
            m.avg * 100.0,
            m.max * 100.0,
            s.plt(),
            x.avg * 100.0,
            x.max * 100.0,
            s.maps_per_frame().0,
            between.0,
            between.1
        );
    }
}

fn main() {
    let number = |name: &str, default: usize| std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default);
    let files: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let stop = Stop::default();
    let sphere = Region::Sphere { centre: DVec3::ZERO, radius: 1.0 };
    let sequence = Sequence::<3>::new(1);
    let others: Vec<DVec3> = (0..number("OTHERS", 1000) as u32).map(|i| sphere.eye(sequence.point(i))).collect();
    for file in &files {
        let scene = match load(Path::new(file), &DiskFiles, &Limits::default()) {
            Ok(scene) => scene,
            Err(e) => {
                eprintln!("{e}");
                continue;
            }
        };
        let (points, geometry) = (scene.points(), Geometry::new(&scene));
        println!("\n## {file}: {} triangles", scene.triangle_count());
        let regular = icosahedron();
        let mut sets = vec![("icosahedron", regular.clone(), 0.0)];
        if number("VIEWS", 1) > 0 {
            let start = Instant::now();
            let probe = Probe::new(&Cpu, &geometry, &points, 256).expect("points");
            let how = Perturbation { reach: 4.0, stability: 10.0 };
            let moved = perturb(&probe, &regular, how, &stop).expect("no stop");
            sets.push((
                "entropy-perturbed",
                moved.iter().map(|m| m.direction).collect(),
                start.elapsed().as_secs_f64(),
            ));
            let start = Instant::now();
            let candidates = geodesic(2);
            let chosen = greedy(&probe, &candidates, 20, &stop).expect("no stop").chosen;
            sets.push(("entropy", chosen.iter().map(|i| candidates[*i]).collect(), start.elapsed().as_secs_f64()));
        }
        for (name, directions, seconds) in sets {
            let start = Instant::now();
            let maps = maps(&scene, &points, &directions, &stop);
            let built = start.elapsed().as_secs_f64();
            let start = Instant::now();
            let all: Vec<&ReliefMap> = maps.iter().collect();
            let textures = compress(&all, Compression::default(), &stop).expect("maps of one size");
            let packed = start.elapsed().as_secs_f64();
            let named: Vec<(&str, &ReliefMap)> = maps.iter().map(|m| ("map", m)).collect();
            let original = Original { geometry: &geometry, corners: &points, whole: None };
            let run = |directions: Vec<DVec3>, search| {
                let trace = Trace { search, ..Trace::default() };
                measure(&Cpu, original, &named, directions, SIDE, trace, &stop).expect("no stop")
            };
            let start = Instant::now();
            let coverage = run(geodesic(2), Search::Pyramid);
            let measured = start.elapsed().as_secs_f64();
            println!(
                "\n### {name}: directions {seconds:.1} s, captures and maps {built:.1} s, textures {packed:.1} s ({} KiB), coverage {measured:.1} s",
                textures.bytes() / 1024
            );
            rows(&coverage, &run(others.clone(), Search::Pyramid));
            if name == "icosahedron" {
                for steps in [16, 64] {
                    let linear = run(geodesic(2), Search::Linear { steps, halvings: 7 });
                    let six = linear.select(Choice::Closest(6));
                    println!(
                        "\nThe paper's search, {steps} steps and 7 halvings, 6 closest: missing avg {:.3} max {:.3} %, extra avg {:.3} %",
                        six.missing().avg * 100.0,
                        six.missing().max * 100.0,
                        six.extra().avg * 100.0
                    );
                }
            }
        }
    }
}
