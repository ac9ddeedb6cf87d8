//! The stock pipeline on a small scene: after a change only what depends on it runs, and nothing else changes a byte.

use farfield::{
    cli::stock::STOCK,
    engine::{
        bake::{Options, Report, bake},
        events::Silent,
        pipeline::{Request, load},
    },
    math::Stop,
    nodes,
};
use std::{collections::BTreeMap, fs, path::Path};
use tempfile::TempDir;

/// Corners 0 to 7 of a cube of two metres, and its sides.
const CUBE: &str = "
v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 5 8 4\nf 2 3 7 6
";

const PIPELINE: &str = "
[pipeline]
base = \"tdm\"
name = \"yard\"
[params]
scene = \"yard.toml\"
resolution = 64
views = 8
[nodes.cell]
centre = [0, 0, 0]
size = [1, 1, 1]
[nodes.select]
exclude = [\"outside*\"]
[require]
evaluate = false
";

/// Where the cubes of the yard stand along X: one is left out by name, one stands behind a wall, two are in sight.
#[derive(Clone, Copy)]
struct Yard {
    outside: f64,
    hidden: f64,
    seen: f64,
}

const YARD: Yard = Yard { outside: 0.0, hidden: 0.0, seen: -6.0 };

impl Yard {
    /// Nothing ever reaches beyond the ends: the box around the scene stays.
    fn text(self) -> String {
        let place = |name: &str, at: [f64; 3], scale: [f64; 3]| {
            format!("[[place]]\nfile = \"cube.obj\"\nname = \"{name}\"\ntranslate = {at:?}\nscale = {scale:?}\n")
        };
        place("wall", [0.0, 0.0, -12.0], [9.0, 9.0, 0.5])
            + &place("far", [0.0, 0.0, -40.0], [30.0, 1.0, 1.0])
            + &place("behind", [0.0, 0.0, 40.0], [30.0, 1.0, 1.0])
            + &place("hidden", [self.hidden, 0.0, -16.0], [1.0; 3])
            + &place("still", [6.0, 0.0, 12.0], [1.0; 3])
            + &place("seen", [self.seen, 0.0, 12.0], [1.0; 3])
            + &place("outside", [self.outside, 0.0, 20.0], [1.0; 3])
    }
}

/// A folder with a scene, a pipeline and, after a bake, a cache and an output.
struct Site(TempDir);

impl Site {
    fn new() -> Self {
        let site = Self(tempfile::tempdir().unwrap());
        fs::write(site.0.path().join("cube.obj"), CUBE).unwrap();
        fs::write(site.0.path().join("yard.pipeline.toml"), PIPELINE).unwrap();
        site.place(YARD);
        site
    }

    fn place(&self, yard: Yard) {
        fs::write(self.0.path().join("yard.toml"), yard.text()).unwrap();
    }

    fn bake(&self, set: &[&str], jobs: usize, cache: &str, out: &str) -> Report {
        let set: Vec<String> = set.iter().map(|s| (*s).to_owned()).collect();
        let folder = self.0.path();
        let request = Request { set: &set, ..Request::new("yard.pipeline.toml", folder, STOCK) };
        let plan = load(&request, &nodes::registry()).unwrap_or_else(|problems| panic!("{problems}"));
        let options = Options { jobs, ..Options::new(folder.join(cache), folder.join(out)) };
        let report = bake(&plan, &options, &Stop::default(), &Silent).unwrap();
        assert!(report.errors.is_empty(), "{:?}", report.errors);
        report
    }

    /// Names of the nodes of which something ran.
    fn ran(&self, set: &[&str]) -> Vec<String> {
        names(&self.bake(set, 2, "cache", "out"))
    }
}

fn names(report: &Report) -> Vec<String> {
    report.nodes.iter().filter(|n| n.runs > 0).map(|n| n.name.clone()).collect()
}

/// All files below `folder` but `run.json`.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(at) = folders.pop() {
        for entry in fs::read_dir(at).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.file_name().unwrap() != "run.json" {
                let name = path.strip_prefix(folder).unwrap().to_string_lossy().into_owned();
                found.insert(name, fs::read(&path).unwrap());
            }
        }
    }
    found
}

#[test]
fn only_what_depends_on_a_change_runs() {
    let site = Site::new();
    let first = site.bake(&[], 2, "cache", "out");
    assert!(first.nodes.iter().all(|n| n.runs > 0), "{first:?}");
    assert!(first.nodes.iter().find(|n| n.name == "collapse").unwrap().runs >= 3, "several meshes");
    assert_eq!(site.ran(&[]), [""; 0]);

    // Outside of the selection: the scene is read again, and selected from.
    site.place(Yard { outside: 1.0, ..YARD });
    assert_eq!(site.ran(&[]), ["load", "cell", "select"]);

    // Selected, but behind the wall: what looks at the scene itself sees that nothing changed.
    site.place(Yard { hidden: 0.5, ..YARD });
    assert_eq!(site.ran(&[]), ["load", "cell", "select", "slices", "ceiling", "evaluate"]);

    // In sight: meshes of other objects are taken from the cache.
    site.place(Yard { seen: -5.5, ..YARD });
    let report = site.bake(&[], 2, "cache", "out");
    for name in ["collapse", "resample"] {
        let node = report.nodes.iter().find(|n| n.name == name).unwrap();
        assert!(node.runs > 0 && node.hits >= 2, "{name}: {} ran, {} hits", node.runs, node.hits);
    }

    // A parameter: its node and what is below it.
    let below = ["collapse", "resample", "atlas", "write", "evaluate"];
    assert_eq!(site.ran(&["collapse.factor=1.5"]), below);
    assert_eq!(site.ran(&[]), [""; 0], "and back");
}

/// Three solids, of which one grows.
fn solids(size: f64) -> String {
    let place = |name: &str, x: f64, scale: f64| {
        format!(
            "[[place]]\nfile = \"cube.obj\"\nname = \"{name}\"\ntranslate = [{x:?}, 0, 0]\nscale = {:?}\n",
            [scale; 3]
        )
    };
    place("a", -2.0, 1.0) + &place("b", 0.0, size) + &place("c", 2.0, 0.7)
}

const LENSES: &str = "
[pipeline]
base = \"vds-clip\"
name = \"lenses\"
[params]
scene = \"yard.toml\"
volumes = \"solids.toml\"
resolution = 64
views = 3
size = [40, 30]
places = [{ sprite = \"a\" }, { sprite = \"b\" }, { sprite = \"c\", at = [5.5, 0, 12] }]
[nodes.draw]
eye = [2, 3, 16]
target = [6, 0, 12]
effects = [{ volume = \"a\", style = \"hide\" }, { volume = \"c\", style = \"tint\" }]
";

#[test]
fn a_lens_is_drawn_again_and_a_solid_re_runs_its_own_column() {
    let site = Site::new();
    let write = |name: &str, text: String| fs::write(site.0.path().join(name), text).unwrap();
    write("solids.toml", solids(1.0));
    write("yard.pipeline.toml", LENSES.into());
    let picture = || fs::read(site.0.path().join("out/lenses/clip.png")).unwrap();
    let first = site.bake(&[], 2, "cache", "out");
    assert!(first.nodes.iter().all(|n| n.runs > 0), "{first:?}");
    let before = picture();

    // Its style, and its place: a sprite is moved at run time.
    write("yard.pipeline.toml", LENSES.replace("tint", "normals"));
    assert_eq!(site.ran(&[]), ["draw"]);
    let styled = picture();
    assert!(styled != before);
    write("yard.pipeline.toml", LENSES.replace("at = [5.5, 0, 12]", "at = [6.5, 0, 12]"));
    assert_eq!(site.ran(&[]), ["draw"]);
    assert!(picture() != before);

    write("yard.pipeline.toml", LENSES.into());
    write("solids.toml", solids(1.3));
    let report = site.bake(&[], 2, "cache", "out");
    for name in ["direction", "peel", "compress"] {
        let node = report.nodes.iter().find(|n| n.name == name).unwrap();
        assert_eq!((node.runs, node.hits), (1, 2), "{name}");
    }
    assert_eq!(names(&report), ["solids", "split", "direction", "peel", "compress", "draw"]);
}

#[test]
fn threads_and_caches_change_no_byte() {
    let site = Site::new();
    site.bake(&[], 1, "one", "one-out");
    site.bake(&[], 2, "two", "two-out");
    let (one, two) = (files(&site.0.path().join("one-out")), files(&site.0.path().join("two-out")));
    assert!(one.len() >= 4 && one.contains_key("yard/tdm.glb"), "{:?}", one.keys());
    assert_eq!(one.keys().collect::<Vec<_>>(), two.keys().collect::<Vec<_>>());
    for (name, bytes) in &one {
        assert!(*bytes == two[name], "{name} differs");
    }
}
