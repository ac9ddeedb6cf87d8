//! Relief impostors from end to end: what is baked, what runs again when something changes, and what is said of input that cannot be.

mod support;

use serde_json::Value;
use std::path::Path;
use tempfile::tempdir;

const SMALL: [&str; 4] = ["views.method=icosahedron", "resolution=24", "coverage.size=32", "coverage.subdivisions=1"];

/// A small bake with these changes: exit code, the names of the nodes that ran and how often, what was said.
fn bake(folder: &Path, pipeline: &str, arguments: &[&str]) -> (i32, Vec<String>, String) {
    let mut command = support::command(folder, pipeline);
    let evaluate: &[&str] = match pipeline {
        "ori" => &["evaluate.size=32", "evaluate.most=32", "evaluate.subdivisions=0", "views=8"],
        _ => &["views=8", "evaluate.resolution=64", "evaluate.samples=1"],
    };
    for set in SMALL.iter().chain(evaluate).filter(|s| pipeline == "ori" || !s.starts_with("views.method")) {
        if !arguments.iter().any(|a| a.split('=').next() == set.split('=').next()) {
            command.args(["--set", set]);
        }
    }
    for argument in arguments {
        command.args(if argument.starts_with("--") { vec![*argument] } else { vec!["--set", argument] });
    }
    support::outcome(command, folder, pipeline)
}

fn json(folder: &Path, file: &str) -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder.join("out").join(file)).unwrap()).unwrap()
}

#[test]
fn an_impostor_is_baked_and_certified_over_directions() {
    let folder = tempdir().unwrap();
    let (code, ran, text) = bake(folder.path(), "ori", &["scene=builtin:solids"]);
    assert_eq!(code, 0, "{text}");
    assert!(ran.contains(&"capture 20".into()) && ran.contains(&"relief 20".into()), "{ran:?}");
    for file in
        ["ori.json", "color.ktx2", "color.dds", "normal.ktx2", "depth.ktx2", "cards.glb", "preview.png", "ori.wgsl"]
    {
        assert!(folder.path().join("out/ori").join(file).is_file(), "{file}");
    }
    let manifest = json(folder.path(), "ori/ori.json");
    assert_eq!((manifest["maps"].as_array().unwrap().len(), &manifest["depth"]["bits"]), (20, &Value::from(8)));
    let c = json(folder.path(), "ori/certificate.json");
    for set in ["directions", "others"] {
        let of = |path: &str| path.split('.').fold(&c[set], |v, key| &v[key]).as_f64().unwrap();
        assert!(
            of("coverage_error.min") <= of("coverage_error.avg")
                && of("coverage_error.avg") <= of("coverage_error.max")
        );
        assert!(of("coverage_error.max") < 0.05 && of("extra.max") < 0.06, "{c}");
        assert!(of("psnr_y_object_db.mean") > 18.0 && of("impostors_per_frame.max") <= 6.0, "{c}");
    }
    assert!(c["plt_px"].as_f64().unwrap() > 16.0);
}

#[test]
fn another_goal_draws_nothing_again() {
    let folder = tempdir().unwrap();
    assert_eq!(bake(folder.path(), "ori", &["scene=builtin:solids"]).0, 0);
    let (_, ran, _) = bake(folder.path(), "ori", &["scene=builtin:solids"]);
    assert!(ran.is_empty(), "{ran:?}");
    let (code, ran, text) = bake(folder.path(), "ori", &["scene=builtin:solids", "goal=0.05"]);
    assert_eq!(code, 0, "{text}");
    assert_eq!(ran, ["evaluate 1", "select 1", "write 1"]);
    // 80 directions, of which 20 are those from before.
    let (code, ran, text) = bake(folder.path(), "ori", &["scene=builtin:solids", "views.levels=1"]);
    assert_eq!(code, 0, "{text}");
    assert!(ran.contains(&"capture 60".into()) && ran.contains(&"relief 60".into()), "{ran:?}");
}

#[test]
fn a_tree_of_impostors_is_baked_and_drawn() {
    let folder = tempdir().unwrap();
    let (code, _, text) = bake(folder.path(), "ori-tree", &["scene=builtin:solids", "split.division=bintree"]);
    assert_eq!(code, 0, "{text}");
    let tree = json(folder.path(), "ori-tree/ori-tree.json");
    let regions = tree["regions"].as_array().unwrap();
    assert_eq!(regions.len(), 3);
    assert_eq!(regions[0]["children"], serde_json::json!(["root.0", "root.1"]));
    for region in regions {
        let of = folder.path().join("out/ori-tree").join(region["folder"].as_str().unwrap());
        assert!(
            of.join("ori.json").is_file()
                && of.join("mesh.glb").is_file() == region["children"].as_array().unwrap().is_empty()
        );
    }
    let c = json(folder.path(), "ori-tree/certificate.json");
    assert!(c["missing_px"]["ratio"].as_f64().unwrap() < 0.05, "{}", c["missing_px"]);
    // A threshold that the root meets leaves its children out.
    let (code, ran, text) =
        bake(folder.path(), "ori-tree", &["scene=builtin:solids", "split.division=bintree", "write.stop_plt=1"]);
    assert_eq!((code, &ran[..]), (0, &["evaluate 1".to_owned(), "write 1".to_owned()][..]), "{text}");
    assert_eq!(json(folder.path(), "ori-tree/ori-tree.json")["regions"].as_array().unwrap().len(), 1);
}

const TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/// A single triangle is flat, has no thickness in some views, and is seen from one side only.
#[test]
fn a_single_triangle_has_an_impostor() {
    let folder = tempdir().unwrap();
    std::fs::write(folder.path().join("triangle.ply"), TRIANGLE).unwrap();
    let (code, _, text) = bake(folder.path(), "ori", &["scene=triangle.ply"]);
    assert_eq!(code, 0, "{text}");
    assert!(text.contains("warning"), "views that show nothing are named: {text}");
    let c = json(folder.path(), "ori/certificate.json");
    assert!(c["directions"]["coverage_error"]["avg"].as_f64().unwrap() < 0.05, "{c}");
}

#[test]
fn what_cannot_be_is_said_and_leaves_nothing() {
    let folder = tempdir().unwrap();
    let nan = TRIANGLE.replace("1 0 0\n0 1", "nan 0 0\n0 1");
    std::fs::write(folder.path().join("nan.ply"), nan).unwrap();
    std::fs::write(folder.path().join("empty.ply"), TRIANGLE.replace("face 1", "face 0").replace("\n3 0 1 2", ""))
        .unwrap();
    for (set, code, says) in [
        ("scene=nan.ply", 1, "finite"),
        ("scene=empty.ply", 1, ""),
        ("resolution=16384", 2, "out of range"),
        ("goal=2", 2, "goal"),
        ("relief.depth_bits=12", 2, "expected 8 or 16"),
        ("relief.samples=5", 1, "5 pixels each"),
        ("select.method=nearest", 2, "nearest"),
        ("coverage.search=sphere", 2, "sphere"),
    ] {
        let (found, _, text) = bake(folder.path(), "ori", &[set]);
        assert_eq!(found, code, "{set}: {text}");
        assert!(text.contains(says), "{set}: {text}");
        assert!(!folder.path().join("out/ori/ori.json").exists(), "{set}");
    }
    let (code, _, text) = bake(folder.path(), "ori", &["resolution=4096", "--memory=256MiB"]);
    assert!(code == 1 && text.contains("a capture of 8192 × 8192 pixels in 1 layers takes"), "{code}: {text}");
    let (code, _, text) = bake(folder.path(), "ori-tree", &["levels=9"]);
    assert!(code == 2 && text.contains("levels"), "{code}: {text}");
}

/// No subset meets a goal of 0 where something is missing: all six maps are used, and a warning says how far that carries.
#[test]
fn a_goal_that_nothing_meets_is_a_warning() {
    let folder = tempdir().unwrap();
    let (code, _, text) = bake(folder.path(), "ori", &["scene=builtin:solids", "goal=0"]);
    assert_eq!(code, 0, "{text}");
    assert!(text.contains("with all six maps; the impostor may be used up to"), "{text}");
    let manifest = json(folder.path(), "ori/ori.json");
    assert!(manifest["selection"]["maps"].as_array().unwrap().iter().any(|m| m.as_array().unwrap().len() == 6));
}
