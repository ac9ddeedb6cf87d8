//! `farfield init`: a pipeline file to start from.

use super::{
    Done, Exit, interrupt, pipeline, print,
    scene::{exists, load},
    schema,
    stock::STOCK,
};
use crate::{
    engine::{
        pipeline::{Request, load_text, valid_name},
        registry::Registry,
        source::lexical,
    },
    formats::Limits,
    math::Aabb,
    nodes::view_cell::default_cell,
};
use std::{
    io::{ErrorKind, Write as _},
    path::{Component, Path, PathBuf},
};

/// Writes a commented pipeline file for a scene
///
/// It changes a stock pipeline: the knobs stand in it with what they do, and where the method looks from, proposed from the scene's bounds.
/// Beside it goes farfield.schema.json, with which editors complete and check what is typed.
#[derive(clap::Args)]
pub struct Args {
    /// The scene: glTF, GLB, OBJ, PLY or scene TOML, or builtin:NAME
    scene: String,
    /// The stock pipeline that it starts from
    #[arg(long, value_name = "METHOD", value_parser = METHODS, default_value = "tdm")]
    method: String,
    /// The pipeline file [default: <scene>-<method>.toml in the working folder]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace the pipeline file where there is one
    #[arg(long)]
    overwrite: bool,
    /// Lets scenes name files outside their own folder
    #[arg(long)]
    allow_outside: bool,
}

/// The stock pipelines that take any scene.
const METHODS: [&str; 8] = ["tdm", "dmesh", "hybrid-lod", "octahedral", "octahedral-objects", "ori", "ori-tree", "vds"];

/// The schema's file, beside the pipeline file.
const SCHEMA: &str = "farfield.schema.json";

pub fn run(args: &Args, registry: &Registry) -> Done {
    let builtin = args.scene.starts_with("builtin:");
    exists(Path::new(&args.scene))?;
    let folder = std::env::current_dir().map_err(|e| Exit::say(2, format!("no working folder: {e}")))?;
    let stem = Path::new(args.scene.trim_start_matches("builtin:")).file_stem();
    let name = plain(&format!("{}-{}", stem.unwrap_or_default().to_string_lossy(), args.method));
    let file = folder.join(args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{name}.toml"))));
    let name =
        if args.output.is_some() { plain(&file.file_stem().unwrap_or_default().to_string_lossy()) } else { name };
    let shown = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{name}.toml")));
    let refuse = |what: &str| Exit::say(2, format!("{}: {what}", shown.display()));
    let same = |a: &Path, b: &Path| a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b));
    if !builtin && same(&file, Path::new(&args.scene)) {
        return Err(refuse("this is the scene; give the pipeline another file with -o"));
    }
    if file.symlink_metadata().is_ok() && !args.overwrite {
        return Err(refuse("there is such a file already; --overwrite replaces it, -o writes another"));
    }
    let home = file.parent().unwrap_or(&folder).to_owned();
    let limits = Limits { allow_outside: args.allow_outside, ..Limits::default() };
    let scene = if builtin { args.scene.clone() } else { relative(&folder.join(&args.scene), &home) };
    let bounds = match args.method.as_str() {
        "tdm" | "hybrid-lod" => load(Path::new(&args.scene), &limits, &interrupt::stop()?)?.bounds(),
        _ => Aabb::EMPTY,
    };
    let text = text(&args.method, &name, &scene, &bounds, args.allow_outside);
    let request = Request::new("", &home, STOCK);
    let file_name = file.file_name().unwrap_or_default().to_string_lossy();
    load_text(&file_name, &text, &request, registry).map_err(|problems| pipeline::report(&problems))?;
    write(&file, &text, args.overwrite).map_err(|e| match e.kind() {
        ErrorKind::AlreadyExists => refuse("there is such a file already; --overwrite replaces it"),
        _ => refuse(&format!("cannot be written: {e}")),
    })?;
    print(&format!("wrote {}\n", shown.display()))?;
    write_schema(&home.join(SCHEMA), registry)?;
    let bake = format!("farfield bake {}", shown.display());
    let watch = format!(", or farfield watch {} while you edit it", shown.display());
    print(&format!("next: {bake}{}\n", if cfg!(feature = "watch") { &watch } else { "" }))
}

/// The schema, unless there is a file of that name that is none of ours.
fn write_schema(path: &Path, registry: &Registry) -> Done {
    let schema = schema::of(registry);
    let title = &schema["title"];
    let ours =
        |bytes: &[u8]| serde_json::from_slice::<serde_json::Value>(bytes).is_ok_and(|there| there["title"] == *title);
    let text = format!("{schema:#}\n");
    match std::fs::read(path) {
        Ok(bytes) if bytes == text.as_bytes() => return Ok(()),
        Ok(bytes) if !ours(&bytes) => {
            super::terminal::say(format_args!("warning: {} is not farfield's, and stays as it is", path.display()));
            return Ok(());
        }
        _ => {}
    }
    std::fs::write(path, text).map_err(|e| Exit::say(1, format!("{}: cannot be written: {e}", path.display())))?;
    print(&format!("wrote {SCHEMA} beside it, for editors\n"))
}

fn write(file: &Path, text: &str, overwrite: bool) -> std::io::Result<()> {
    let mut options = std::fs::File::options();
    options.write(true);
    if overwrite {
        options.create(true).truncate(true)
    } else {
        options.create_new(true)
    };
    options.open(file)?.write_all(text.as_bytes())
}

/// `name` as one of a pipeline: letters, digits, `-` and `_`.
fn plain(name: &str) -> String {
    let plain: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_".contains(c) { c } else { '-' }).collect();
    let plain = plain.trim_matches('-').to_owned();
    if valid_name(&plain) { plain } else { "pipeline".to_owned() }
}

/// The way from the folder `home` to `file`, with `/`; both are absolute. The file's own path where they share no folder.
fn relative(file: &Path, home: &Path) -> String {
    let (file, home) = (lexical(file), lexical(home));
    let (to, from): (Vec<_>, Vec<_>) = (file.components().collect(), home.components().collect());
    let shared = to.iter().zip(&from).take_while(|(a, b)| a == b).count();
    // Two places that share only the root do not move together.
    if !to[..shared].iter().any(|part| matches!(part, Component::Normal(_))) {
        return file.to_string_lossy().into_owned();
    }
    let up = from[shared..].iter().map(|_| "..".to_owned());
    let down = to[shared..].iter().map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// The file's text.
fn text(method: &str, name: &str, scene: &str, bounds: &Aabb, allow_outside: bool) -> String {
    let stock = STOCK.iter().find(|(name, _)| *name == method).map_or("", |(_, text)| text);
    let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
    let mut out = format!(
        "#:schema ./{SCHEMA}\n# {about}: the stock pipeline `{method}` with changes.\n\
         # `farfield check` tells mistakes, `farfield graph` shows all nodes, and `farfield nodes KIND METHOD` what else each can be told.\n\n\
         [pipeline]\nbase = \"{method}\"\nname = {name}   # results go to out/<name>/\n\n[params]\n",
        about = about(stock),
        name = quoted(name),
    );
    let place = place(method, bounds);
    for knob in knobs(stock) {
        let own = place.params.iter().find(|(name, _)| *name == knob.0).map(|(_, value)| value.clone());
        let value = if knob.0 == "scene" { quoted(scene) } else { own.unwrap_or_else(|| knob.1.to_owned()) };
        out += &format!("{} = {value}   # {}\n", knob.0, knob.2);
    }
    if allow_outside {
        out += "\n[nodes.load]\nallow_outside = true   # the scene names files outside its own folder\n";
    }
    out + &place.nodes + more(method)
}

/// What a stock pipeline says it makes.
fn about(stock: &str) -> &str {
    let line = stock.lines().find_map(|line| line.strip_prefix("about = \""));
    line.map_or("", |about| about.trim_end_matches('"'))
}

/// The knobs of a stock pipeline: name, value, what it does.
fn knobs(stock: &str) -> Vec<(&str, &str, &str)> {
    let lines = stock.lines().skip_while(|line| *line != "[params]").skip(1).take_while(|line| !line.starts_with('['));
    lines
        .filter_map(|line| {
            let (name, rest) = line.split_once('=')?;
            let (value, what) = rest.split_once(" # ")?;
            Some((name.trim(), value.trim(), what.trim()))
        })
        .collect()
}

/// Where a stand-in is seen from.
#[derive(Default)]
struct Placed {
    /// Values of knobs.
    params: Vec<(&'static str, String)>,
    /// Tables of nodes.
    nodes: String,
}

fn place(method: &str, bounds: &Aabb) -> Placed {
    match method {
        "tdm" => view_cell(bounds),
        "hybrid-lod" => walk(bounds),
        _ => Placed::default(),
    }
}

/// The box that a node `view-cell` proposes.
fn view_cell(bounds: &Aabb) -> Placed {
    let Some(cell) = default_cell(bounds) else { return Placed::default() };
    let side = cell.half * 2.0;
    let list = |v: glam::DVec3| v.to_array().map(|x| number(x, side.max_element())).join(", ");
    let nodes = format!(
        "\n[nodes.cell]   # from where the stand-in must look right: a box, metres, Y up. Proposed from the scene's bounds:\n\
         # x {}, y {}, z {}\n\
         centre = [{}]\nsize   = [{}]\n",
        range(bounds, 0),
        range(bounds, 1),
        range(bounds, 2),
        list(cell.centre),
        list(side),
    );
    Placed { params: Vec::new(), nodes }
}

/// A walk through the middle of the ground along its longer side, in cells of a tenth of it.
fn walk(bounds: &Aabb) -> Placed {
    let extent = bounds.max - bounds.min;
    let longer = extent.x.max(extent.z);
    if bounds.is_empty() || !(longer > 0.0 && longer.is_finite()) {
        return Placed::default();
    }
    let middle = bounds.centre();
    let step = extent * 0.4;
    let ends = if extent.x >= extent.z {
        [[middle.x - step.x, middle.z], [middle.x + step.x, middle.z]]
    } else {
        [[middle.x, middle.z - step.z], [middle.x, middle.z + step.z]]
    };
    let point = |p: &[f64; 2]| format!("[{}, {}]", number(p[0], longer), number(p[1], longer));
    let path = ends.iter().map(point).collect::<Vec<_>>().join(", ");
    // Eyes of people, or of whoever walks through a model.
    let heights = if longer >= 50.0 { "[1.6, 2.0]" } else { "[]" };
    let nodes = format!(
        "\n[nodes.cells]   # the ground: x {}, z {}\n\
         heights = {heights}   # eyes above the scene's lowest point, metres; [] for 2 % to 3 % of a cell's size\n",
        range(bounds, 0),
        range(bounds, 2),
    );
    Placed { params: vec![("size", number(longer * 0.1, longer * 0.1)), ("path", format!("[{path}]"))], nodes }
}

/// `from … to … m` along an axis.
fn range(bounds: &Aabb, axis: usize) -> String {
    let (min, max) = (bounds.min[axis], bounds.max[axis]);
    let scale = (max - min).max(bounds.diagonal() * 0.01);
    format!("{} to {}", number(min, scale), number(max, scale))
}

/// `value` with as many decimals as leave three digits of `scale`.
fn number(value: f64, scale: f64) -> String {
    let mut decimals = 1;
    let mut scaled = scale.abs() * 10.0;
    while scaled < 100.0 && decimals < 12 {
        scaled *= 10.0;
        decimals += 1;
    }
    let text = format!("{value:.decimals$}");
    if text.trim_start_matches('-').trim_matches(['0', '.']).is_empty() { "0.0".to_owned() } else { text }
}

/// What else is often changed.
fn more(method: &str) -> &'static str {
    match method {
        "tdm" => {
            "\n\
             [require.evaluate]   # a bake that misses a bound exits with 3 and goes to out/<name>/rejected/\n\
             \"psnr_y_object_db.mean\" = { min = 18 }   # dB; `farfield nodes evaluate views` lists the measures\n"
        }
        "vds" => "\n[nodes.peel]\nrepair = \"none\"   # \"winding\" for a model whose surface is not closed\n",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    const BOUNDS: Aabb = Aabb { min: DVec3::new(-120.0, 0.0, -80.0), max: DVec3::new(120.0, 9.5, 80.0) };

    #[test]
    fn every_method_has_knobs_and_a_file_that_checks() {
        let registry = crate::nodes::registry();
        for method in METHODS {
            for bounds in [BOUNDS, Aabb { min: DVec3::ZERO, max: DVec3::new(0.1, 0.02, 3.3) }, Aabb::EMPTY] {
                let text = text(method, "park", "builtin:park", &bounds, true);
                let folder = std::env::temp_dir();
                let request = Request::new("", &folder, STOCK);
                let plan = load_text("park.toml", &text, &request, &registry);
                let plan = plan.unwrap_or_else(|problems| panic!("{method}\n{text}\n{problems}"));
                assert_eq!((plan.name.as_str(), &*plan.sources), ("park", &["builtin:park".to_owned()][..]));
                assert!(text.starts_with(&format!("#:schema ./{SCHEMA}\n")), "{text}");
                // Every knob of the stock pipeline stands there with what it does.
                let all: Vec<&str> = text.lines().filter(|line| line.contains("   # ")).collect();
                for knob in plan.knobs.keys() {
                    let is_it = |line: &&&str| line.split(" = ").next() == Some(knob.as_str());
                    assert_eq!(all.iter().filter(is_it).count(), 1, "{method}: {knob}\n{text}");
                }
            }
        }
    }

    #[test]
    fn what_a_method_is_seen_from_is_proposed() {
        let tdm = text("tdm", "park", "park.glb", &BOUNDS, false);
        let cell = default_cell(&BOUNDS).unwrap();
        assert!(tdm.contains(&format!("centre = [0.0, {:.1}, {:.1}]", cell.centre.y, cell.centre.z)), "{tdm}");
        let walk = text("hybrid-lod", "park", "park.glb", &BOUNDS, false);
        assert!(walk.contains("\npath = [[-96.0, 0.0], [96.0, 0.0]]   # "), "{walk}");
        assert!(walk.contains("\nsize = 24.0   # ") && walk.contains("\nheights = [1.6, 2.0]"), "{walk}");
    }

    #[test]
    fn scenes_are_named_from_the_files_folder() {
        for (file, home, expect) in [
            ("/a/b/town.glb", "/a/b", "town.glb"),
            ("/a/b/town.glb", "/a/b/c/../c", "../town.glb"),
            ("/a/x/town.glb", "/a/b", "../x/town.glb"),
            ("/data/town.glb", "/home/u", "/data/town.glb"),
        ] {
            assert_eq!(relative(Path::new(file), Path::new(home)), expect);
        }
        assert_eq!(plain("Stadt (alt)-tdm"), "Stadt--alt--tdm");
        assert_eq!(plain("…"), "pipeline");
    }

    #[test]
    fn numbers_have_three_digits_of_what_they_measure() {
        for (value, scale, expect) in
            [(12.3456, 240.0, "12.3"), (0.012_345, 0.5, "0.012"), (-0.001, 240.0, "0.0"), (1e6, 2e6, "1000000.0")]
        {
            assert_eq!(number(value, scale), expect);
        }
    }
}
