//! Hybrid textured LOD meshes beside the paper's literal method and beside meshoptimizer at equal triangles, along one walk:
//! `cargo bench --bench hybrid_tables -- park-8m.toml SIZE X0 Z0 X1 Z1`. Cells of SIZE metres that the walk from (X0, Z0) to (X1, Z1) meets, pictures of
//! `RES`² pixels (1024), `FRAMES` of them (12), eyes `EYE` metres above the ground (10).

use farfield::{
    certify::walk::{Frame, Pace, poses, walk},
    formats::{DiskFiles, Limits, load},
    lod::{
        build::{CostKind, Simplifying, simplify, textured},
        entry::Entry,
        faces::Facing,
        levels::{Levels, levels},
        occlusion::Estimate,
        outline::Outline,
        pixels::{Steps, Unit},
        render::window,
        subject::{Classified, Classifying, Placement, Subject, Views, classify},
        texture::Textured,
        weights::Window,
    },
    math::Stop,
    mesh::simplify::{Goal, Surface, simplify as quadric},
    raster::{Cpu, Rendering},
    runtime::{
        Context,
        hybrid_lod::{cell_files, cell_scene},
    },
    scene::{Mesh, Object, Part, Scene},
    view::{HexGrid, View},
};
use glam::{DAffine3, DVec2, DVec3, Mat4};
use rayon::prelude::*;
use std::{collections::BTreeMap, convert::Infallible, path::Path, sync::Arc, time::Instant};

/// A way to make stand-ins.
#[derive(Clone, Copy)]
struct Way {
    name: &'static str,
    estimate: Estimate,
    t_s: f64,
    how: Simplifying,
}

const OURS: Simplifying = Simplifying {
    cost: CostKind::Parallax,
    facing: Facing::Cell,
    steps: Steps { t_c0: 8.0, t_c1: 3.0, unit: Unit::Footprint },
    exponent: 2.0,
    t_l: 4.5,
    tolerance: 0.35,
    start: 0.1,
    triangles: 0,
};
const PAPER: Simplifying = Simplifying { cost: CostKind::Paper, facing: Facing::Centre, ..OURS };

const WAYS: [Way; 8] = [
    Way { name: "parallax, 0.35 px", estimate: Estimate::Bound, t_s: 5.0, how: OURS },
    Way { name: "parallax, 0.5 px", estimate: Estimate::Bound, t_s: 5.0, how: Simplifying { tolerance: 0.5, ..OURS } },
    Way { name: "parallax, 1 px", estimate: Estimate::Bound, t_s: 5.0, how: Simplifying { tolerance: 1.0, ..OURS } },
    Way { name: "paper, T_s 5, T_l 3", estimate: Estimate::Paper, t_s: 5.0, how: Simplifying { t_l: 3.0, ..PAPER } },
    Way { name: "paper, T_s 5, T_l 4.5", estimate: Estimate::Paper, t_s: 5.0, how: PAPER },
    Way { name: "paper, T_s 5, T_l 6", estimate: Estimate::Paper, t_s: 5.0, how: Simplifying { t_l: 6.0, ..PAPER } },
    Way { name: "paper, T_s 3, T_l 4.5", estimate: Estimate::Paper, t_s: 3.0, how: PAPER },
    Way { name: "paper, T_s 7, T_l 4.5", estimate: Estimate::Paper, t_s: 7.0, how: PAPER },
];

/// The scene with what is made once.
struct World {
    scene: Scene,
    placements: Vec<(String, Placement)>,
    /// By name.
    numbers: BTreeMap<String, usize>,
    /// Of each object; instances share them.
    shapes: Vec<Arc<Levels>>,
}

fn world(path: &str) -> World {
    let scene = load(Path::new(path), &DiskFiles, &Limits::default()).expect("a scene");
    let mut known: BTreeMap<usize, Arc<Levels>> = BTreeMap::new();
    let mut shapes = Vec::new();
    for o in &scene.objects {
        let make = || {
            let shape = Object { name: "shape".into(), transform: Mat4::IDENTITY, parts: o.parts.clone() };
            Arc::new(levels(&Scene { objects: vec![shape] }, 11).expect("triangles"))
        };
        shapes.push(known.entry(Arc::as_ptr(&o.parts[0].mesh).addr()).or_insert_with(make).clone());
    }
    let place = |o: &Object| {
        let transform = DAffine3::from_mat4(o.transform.as_dmat4());
        let placement = Placement { transform, outline: Outline::of(o), triangles: o.triangle_count() as u64 };
        (o.name.clone(), placement)
    };
    World {
        placements: scene.objects.iter().map(place).collect(),
        numbers: scene.objects.iter().enumerate().map(|(i, o)| (o.name.clone(), i)).collect(),
        shapes,
        scene,
    }
}

impl World {
    fn classify(&self, grid: &HexGrid, cell: (u32, u32), way: &Way, resolution: f64) -> Classified {
        let how = Classifying { image_res: resolution, t_s: way.t_s, estimate: way.estimate, clusters: true };
        let around: Vec<DVec3> =
            grid.neighbours(cell.0, cell.1).iter().map(|(c, r)| grid.cell(*c, *r).centre).collect();
        let objects: Vec<(String, &Placement)> = self.placements.iter().map(|(n, p)| (n.clone(), p)).collect();
        classify(&grid.cell(cell.0, cell.1), &around, &objects, &how)
    }

    fn stand_in(&self, subject: &Subject, how: &Simplifying) -> Textured {
        let stop = Stop::default();
        let number = |name: &String| self.numbers[name];
        let shapes: Vec<&[Part]> =
            subject.members.iter().map(|(n, _)| &self.scene.objects[number(n)].parts[..]).collect();
        let captured: Vec<Window> =
            subject.cameras.iter().map(|(_, c)| window(&Cpu, c, &shapes, 2, &stop).expect("no stop")).collect();
        let windows = subject.windows(captured.iter()).expect("its own windows");
        let levels: Vec<&Levels> = subject.members.iter().map(|(n, _)| &*self.shapes[number(n)]).collect();
        let simplified = simplify(subject, &levels, &windows, how, &stop).expect("no stop");
        textured(subject, &simplified, &windows, how.tolerance)
    }

    /// Each object of a stand-in by meshoptimizer, its share of the stand-in's triangles, with its own colours.
    fn meshopt(&self, subject: &Subject, triangles: usize) -> Vec<Object> {
        let object = |name: &String| &self.scene.objects[self.numbers[name]];
        let all: usize = subject.members.iter().map(|(n, _)| object(n).triangle_count()).sum();
        let reduced = |(name, _): &(String, DAffine3)| {
            let o = object(name);
            let part = |p: &Part| {
                let colors: Vec<f32> = p.mesh.colors.iter().flat_map(|c| [c[0], c[1], c[2]]).collect();
                let weights: &[f32] = if colors.is_empty() { &[] } else { &[0.1; 3] };
                let surface = Surface {
                    positions: &p.mesh.positions,
                    attributes: &colors,
                    weights,
                    triangles: &p.mesh.triangles,
                };
                let triangles = triangles * p.mesh.triangles.len() / all.max(1);
                let left = quadric(&surface, &Goal { triangles, error: f32::INFINITY, lock_border: false });
                Part {
                    mesh: Arc::new(Mesh { triangles: left.into(), ..(*p.mesh).clone() }),
                    material: p.material.clone(),
                }
            };
            Object { parts: o.parts.iter().map(part).collect(), ..o.clone() }
        };
        subject.members.iter().map(reduced).collect()
    }
}

fn number(name: &str, default: f64) -> f64 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let [path, numbers @ ..] = &arguments[..] else {
        println!("expected a scene, the size of cells, and two points of the ground");
        return;
    };
    let numbers: Vec<f64> = numbers.iter().map(|n| n.parse().expect("a number")).collect();
    let [size, x0, z0, x1, z1] = numbers[..] else { panic!("expected SIZE X0 Z0 X1 Z1") };
    let (resolution, frames) = (number("RES", 1024.0), number("FRAMES", 12.0));
    let start = Instant::now();
    let world = world(path);
    let bounds = world.scene.bounds();
    let eye = bounds.min.y + number("EYE", 10.0);
    let (min, max) = (DVec2::new(bounds.min.x, bounds.min.z), DVec2::new(bounds.max.x, bounds.max.z));
    let grid = HexGrid::over(min, max, size, eye - 1.0, eye + 1.0);
    let line = [DVec3::new(x0, eye, z0), DVec3::new(x1, eye, z1)];
    let pace = Pace { speed: 1.0, turn: 1.0, step: line[0].distance(line[1]) / (frames - 1.0) };
    let pixels = resolution as u32;
    let shots: Vec<(View, (u32, u32))> = poses(&line, &pace)
        .iter()
        .map(|p| {
            let fov = std::f64::consts::FRAC_PI_3;
            let view = View::look_at(p.eye, p.eye + p.aim, DVec3::Y, fov, pixels, pixels, size * 1e-3, size * 1e4);
            (view, grid.locate(p.eye).expect("a walk over the ground"))
        })
        .collect();
    let mut cells: Vec<(u32, u32)> = shots.iter().map(|s| s.1).collect();
    cells.dedup();
    let originals = world.scene.triangle_count();
    println!(
        "{path}: {originals} triangles, {} objects, {} of {} cells, loaded with levels in {:.1?}",
        world.scene.objects.len(),
        cells.len(),
        grid.count(),
        start.elapsed()
    );
    println!(
        "| way | SV | clusters | MV | inside | stand-ins' triangles | in the frustum | PSNR(Y) avg / min dB | meshopt at equal triangles | missing % | extra % | popping max % | s a cell |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for way in &WAYS {
        let start = Instant::now();
        let mut made: Vec<(Entry, Scene, Scene)> = Vec::new();
        let (mut counts, mut triangles, mut inside) = ([0_usize; 3], 0, 0);
        for cell in &cells {
            let found = world.classify(&grid, *cell, way, resolution);
            let stand_ins: Vec<(&String, &Subject, Textured)> =
                found.subjects.par_iter().map(|(n, s)| (n, s, world.stand_in(s, &way.how))).collect();
            for (_, s, t) in &stand_ins {
                counts[if s.views == Views::Multi { 2 } else { usize::from(s.members.len() > 1) }] += 1;
                triangles += t.triangles.len();
            }
            inside +=
                found.inside.iter().map(|n| world.scene.objects[world.numbers[n]].triangle_count()).sum::<usize>();
            let rows: Vec<(&str, &Subject, &Textured)> =
                stand_ins.iter().map(|(n, s, t)| (n.as_str(), *s, t)).collect();
            let entry = Entry {
                centre: grid.cell(cell.0, cell.1).centre.to_array(),
                inside: found.inside.clone(),
                ..Entry::default()
            };
            let scene = cell_files(&entry, &rows, 8192).expect("textures fit").scene;
            let objects = stand_ins.iter().flat_map(|(_, s, t)| world.meshopt(s, t.triangles.len())).collect();
            made.push((entry, scene, Scene { objects }));
        }
        let seconds = start.elapsed().as_secs_f64() / cells.len() as f64;
        let frames: Vec<Frame> = shots
            .iter()
            .map(|(view, cell)| Frame { view: *view, cell: cells.iter().position(|c| c == cell).unwrap_or(0) })
            .collect();
        let stop = Stop::default();
        let context = Context { backend: &Cpu, stop: &stop };
        let play = |ours: bool| {
            let scene_of = |i: usize| {
                let (entry, scene, baseline) = &made[i];
                let stand_ins = if ours { scene.clone() } else { baseline.clone() };
                Ok::<_, Infallible>(cell_scene(stand_ins, entry, &world.scene))
            };
            walk(&world.scene, &frames, &scene_of, &Rendering::default(), context, &|_, _| {}).expect("no stop").frames
        };
        let (ours, baseline) = (play(true), play(false));
        let mean = |f: &dyn Fn(usize) -> f64| (0..ours.len()).map(f).sum::<f64>() / ours.len() as f64;
        let share = |n: u64, i: usize| 100.0 * n as f64 / ours[i].covered.max(1) as f64;
        let n = cells.len();
        println!(
            "| {} | {:.1} % | {:.1} % | {:.1} % | {} | {} (1:{:.1}) | {:.0} | {:.2} / {:.2} | {:.2} | {:.3} | {:.3} | {:.3} | {seconds:.1} |",
            way.name,
            100.0 * counts[0] as f64 / counts.iter().sum::<usize>() as f64,
            100.0 * counts[1] as f64 / counts.iter().sum::<usize>() as f64,
            100.0 * counts[2] as f64 / counts.iter().sum::<usize>() as f64,
            inside / n,
            triangles / n,
            originals as f64 * n as f64 / (triangles + inside) as f64,
            mean(&|i| ours[i].triangles as f64),
            mean(&|i| ours[i].psnr_y_db),
            ours.iter().map(|f| f.psnr_y_db).fold(f64::INFINITY, f64::min),
            mean(&|i| baseline[i].psnr_y_db),
            mean(&|i| share(ours[i].missing, i)),
            mean(&|i| share(ours[i].extra, i)),
            ours.iter().filter_map(|f| f.popping).map(|p| 100.0 * p.share).fold(0.0, f64::max),
        );
    }
}
