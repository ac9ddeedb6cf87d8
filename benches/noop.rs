//! What a bake costs in which nothing, or one thing, changed: pipelines of trivial nodes, baked by the engine alone and
//! by the whole command, beside ninja with a build file of the same shape. Run with `cargo bench --bench noop`.
//!
//! This program is also the command that it measures: `noop bake FILE` is farfield with the trivial kinds.

#[path = "../tests/engine/support.rs"]
#[expect(dead_code, reason = "the tests use more kinds")]
mod support;

use farfield::{
    engine::{
        bake::{Options, bake},
        events::Silent,
        pipeline::{Request, load_text},
        plan::Plan,
        registry::Registry,
    },
    math::Stop,
};
use std::{
    fmt::Write as _,
    fs,
    path::Path,
    process::{Command, ExitCode, Stdio},
    time::Instant,
};

/// Measurements of which the median is told.
const TIMES: i64 = 9;

/// A pipeline and the build file of the same shape, in both of which `changed` is a parameter of one node.
struct Shape {
    name: &'static str,
    pipeline: fn(usize, i64) -> String,
    ninja: fn(usize, i64) -> String,
    sizes: &'static [usize],
}

const SHAPES: [Shape; 2] = [
    Shape { name: "nodes", pipeline: graph, ninja: ninja_graph, sizes: &[1_000, 10_000] },
    Shape { name: "elements", pipeline: map, ninja: ninja_map, sizes: &[1_000, 10_000, 100_000] },
];

/// Ninja starts a process per node: beyond this many it is not waited for.
const NINJA_NODES: usize = 10_000;

/// Layers of 100 nodes, each of which adds to one of the layer above; the last layer but four holds the change.
fn graph(nodes: usize, changed: i64) -> String {
    let mut text = String::from("[pipeline]\nname = \"test\"\n");
    let layers = nodes / 100;
    for at in 0..nodes {
        let (layer, i) = (at / 100, at % 100);
        let plus = layer as i64 + if (layer + 5, i) == (layers, 0) { changed * 100_000 } else { 0 };
        let _ = match layer {
            0 => write!(text, "[nodes.n0-{i}]\nkind = \"constant\"\nvalue = {i}\n"),
            _ => {
                write!(text, "[nodes.n{layer}-{i}]\nkind = \"add\"\na = \"n{}-{i}\"\nplus = {plus}000\n", layer - 1)
            }
        };
    }
    let _ = write!(text, "[nodes.print]\nkind = \"print\"\nvalue = \"n{}-0\"\n", layers - 1);
    text + "[files]\n\"out.txt\" = \"print\"\n"
}

fn ninja_graph(nodes: usize, changed: i64) -> String {
    let mut text = String::from("rule make\n  command = echo $v > $out\n");
    let layers = nodes / 100;
    for at in 0..nodes {
        let (layer, i) = (at / 100, at % 100);
        let v = at as i64 + if (layer + 5, i) == (layers, 0) { changed * 100_000 } else { 0 };
        let above = if layer > 0 { format!("n{}-{i}", layer - 1) } else { String::new() };
        let _ = write!(text, "build n{layer}-{i}: make {above}\n  v = {v}\n");
    }
    let _ = write!(text, "build out.txt: make n{}-0\n  v = 0\n", layers - 1);
    text
}

/// A list, a node mapped over it, and their sum.
fn map(elements: usize, changed: i64) -> String {
    format!(
        "[pipeline]\nname = \"test\"\n[nodes.list]\nkind = \"many\"\ncount = {elements}\nchanged = {changed}\n\
         [nodes.square]\nkind = \"square\"\nvalue = \"list\"\n[nodes.sum]\nkind = \"sum\"\nitems = \"square\"\n\
         [nodes.print]\nkind = \"print\"\nvalue = \"sum\"\n[files]\n\"out.txt\" = \"print\"\n"
    )
}

fn ninja_map(elements: usize, changed: i64) -> String {
    let mut text = String::from("rule make\n  command = echo $v > $out\n");
    let mut all = String::new();
    for i in 0..elements {
        let v = if i == 0 { -changed } else { i as i64 };
        let _ = write!(text, "build e{i}: make\n  v = {v}\n");
        let _ = write!(all, " e{i}");
    }
    let _ = write!(text, "build sum: make{all}\n  v = 0\nbuild out.txt: make sum\n  v = 0\n");
    text
}

fn registry() -> Registry {
    use support::*;
    let mut registry = Registry::default();
    registry.add::<Constant>();
    registry.add::<Add>();
    registry.add::<MakeMany>();
    registry.add::<Square>();
    registry.add::<Sum>();
    registry.add::<Print>();
    registry
}

fn check(text: &str) -> Plan {
    let request = Request::new("test.toml", Path::new("."), &[]);
    load_text("test.toml", text, &request, &registry()).unwrap_or_else(|problems| panic!("{problems}"))
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn ms(began: Instant) -> f64 {
    began.elapsed().as_secs_f64() * 1e3
}

/// The engine's share, without the process and the pipeline file.
fn engine(shape: &Shape, n: usize) {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let options = Options::new(dir.path().join("cache"), dir.path().join("out"));
    let once = |changed: i64| {
        let text = (shape.pipeline)(n, changed);
        let began = Instant::now();
        let plan = check(&text);
        let check_ms = ms(began);
        let (began, cpu) = (Instant::now(), cpu());
        let report = bake(&plan, &options, &Stop::default(), &Silent).expect("a bake");
        assert!(report.errors.is_empty(), "{:?}", report.errors);
        (check_ms, ms(began), self::cpu() - cpu, report.runs())
    };
    let (_, first, _, runs) = once(0);
    println!("{n} {}: first bake {first:.1} ms ({runs} runs)", shape.name);
    for what in ["no-op", "one change"] {
        let times: Vec<_> = (1..=TIMES).map(|i| once(if what == "no-op" { 0 } else { i })).collect();
        let of = |f: fn(&(f64, f64, f64, u64)) -> f64| median(times.iter().map(f).collect());
        println!(
            "  {what:<10} engine {:6.1} ms, of which its thread computed {:6.1} ms ({} runs); check {:.1} ms",
            of(|t| t.1),
            of(|t| t.2),
            times[0].3,
            of(|t| t.0)
        );
    }
}

/// Whole commands: this program as farfield, and ninja, in turns.
fn commands(shape: &Shape, n: usize) {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let with_ninja = n <= NINJA_NODES && has_ninja();
    let write = |changed: i64| {
        fs::write(dir.path().join("test.toml"), (shape.pipeline)(n, changed)).expect("a file");
        fs::write(dir.path().join("build.ninja"), (shape.ninja)(n, changed)).expect("a file");
    };
    let run = |program: &Path, arguments: &[&str]| {
        let mut command = Command::new(program);
        command.current_dir(dir.path()).args(arguments).env_remove("FARFIELD_CACHE");
        let began = Instant::now();
        let ran = command.output().expect("a program that starts");
        let took = ms(began);
        assert!(ran.status.success(), "{}: {}", program.display(), String::from_utf8_lossy(&ran.stderr));
        took
    };
    let this = std::env::current_exe().expect("a path of this program");
    let farfield = || run(&this, &["bake", "test.toml"]);
    let ninja = || if with_ninja { run(Path::new("ninja"), &["--quiet"]) } else { f64::NAN };
    write(0);
    farfield();
    ninja();
    for what in ["no-op", "one change"] {
        let (mut ours, mut theirs) = (Vec::new(), Vec::new());
        for i in 1..=TIMES {
            if what == "one change" {
                write(i);
            }
            ours.push(farfield());
            theirs.push(ninja());
        }
        let (ours, theirs) = (median(ours), median(theirs));
        let ninja = if with_ninja {
            format!("ninja {theirs:6.1} ms, ratio {:.2}", ours / theirs)
        } else {
            "not compared with ninja".to_owned()
        };
        println!("  {what:<10} whole command {ours:6.1} ms; {ninja}");
    }
}

fn has_ninja() -> bool {
    Command::new("ninja").arg("--version").stdout(Stdio::null()).status().is_ok_and(|s| s.success())
}

/// Milliseconds that this thread has computed; 0 where the system does not tell. On a busy machine it is the figure
/// that can be compared.
fn cpu() -> f64 {
    let text = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).unwrap_or(0.0) / 1e6
}

fn main() -> ExitCode {
    if std::env::args().nth(1).is_some_and(|a| a == "bake") {
        return farfield::cli::run(std::env::args_os(), &registry());
    }
    if !has_ninja() {
        println!("ninja is not on PATH: there is no comparison with it");
    }
    // `noop SHAPE SIZE` measures that alone.
    let words: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    for shape in &SHAPES {
        for n in shape.sizes {
            let asked = [shape.name.to_owned(), n.to_string()];
            if words.iter().all(|w| asked.contains(w)) {
                engine(shape, *n);
                commands(shape, *n);
            }
        }
    }
    ExitCode::SUCCESS
}
