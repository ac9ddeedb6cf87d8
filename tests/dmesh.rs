//! Depth-meshes from end to end: what is baked, what runs again when something changes, and what is said of input that cannot be.

mod support;

use serde_json::Value;
use std::path::Path;
use tempfile::{TempDir, tempdir};

/// A small bake of the stock pipeline with these changes: exit code, the names of the nodes that ran, what was said.
fn bake(folder: &Path, pipeline: &str, set: &[&str]) -> (i32, Vec<String>, String) {
    let mut command = support::command(folder, pipeline);
    let small = ["views=16", "evaluate.resolution=128", "evaluate.samples=2", "resolution=129"];
    for set in small.iter().filter(|s| !set.iter().any(|o| o.split('=').next() == s.split('=').next())).chain(set) {
        command.args(["--set", set]);
    }
    support::outcome(command, folder, pipeline)
}

fn certificate(folder: &Path, pipeline: &str) -> Value {
    let text = std::fs::read_to_string(folder.join("out").join(pipeline).join("certificate.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn number(value: &Value, path: &str) -> f64 {
    let found = path.split('.').fold(value, |v, key| &v[key]);
    found.as_f64().unwrap_or_else(|| panic!("{path} is {found}"))
}

fn place() -> TempDir {
    tempdir().unwrap()
}

#[test]
fn a_bundle_is_baked_and_certified_in_both_ways() {
    let folder = place();
    let (code, _, text) = bake(folder.path(), "dmesh", &["resolution=257"]);
    assert_eq!(code, 0, "{text}");
    let out = folder.path().join("out/dmesh");
    for file in ["dmesh.json", "dmesh.glb", "dmesh.wgsl", "references/pos-x.glb", "references/neg-y-normals.png"] {
        assert!(out.join(file).is_file(), "{file}");
    }
    let c = certificate(folder.path(), "dmesh");
    for mode in ["static", "view_dependent"] {
        let of = |path: &str| number(&c, &format!("{mode}.{path}"));
        assert!(of("triangles_per_view.mean") > 100.0 && of("references_per_view.max") <= 6.0);
        assert!(of("missing_px.without_floor.mean") <= of("missing_px.mean"));
        assert!(of("wrong_surface_px.without_floor.mean") <= of("wrong_surface_px.mean"));
        assert!(of("psnr_y_object_db.mean") > 24.0, "{mode}: {}", of("psnr_y_object_db.mean"));
        assert!(c["about"][format!("{mode}.floor_px.ratio")]["about"].is_string());
    }
    assert!(number(&c, "view_dependent.triangles_per_view.mean") < number(&c, "static.triangles_per_view.mean"));
    assert!(number(&c, "missing_px.ratio") < 0.01, "{}", number(&c, "missing_px.ratio"));
}

#[test]
fn layers_show_what_the_first_hides() {
    let folder = place();
    let wrong = |layers: &str| {
        let (code, _, text) = bake(folder.path(), "dmesh", &["resolution=257", layers]);
        assert_eq!(code, 0, "{text}");
        let c = certificate(folder.path(), "dmesh");
        (number(&c, "static.floor_px.ratio"), number(&c, "wrong_surface_px.ratio") + number(&c, "missing_px.ratio"))
    };
    let ((floor, one), (deeper_floor, three)) = (wrong("layers=1"), wrong("layers=3"));
    assert!(deeper_floor < 0.5 * floor && three < one, "{floor} {one}; with three layers {deeper_floor} {three}");
}

#[test]
fn a_lit_stand_in_is_lit_as_its_original_is() {
    let folder = place();
    let (code, _, text) = bake(folder.path(), "dmesh-relit", &["resolution=257"]);
    assert_eq!(code, 0, "{text}");
    let c = certificate(folder.path(), "dmesh-relit");
    assert!(c["shading"].as_str().unwrap().starts_with("lit:"));
    let lit = number(&c, "psnr_y_object_db.mean");
    bake(folder.path(), "dmesh", &["resolution=257"]);
    let unlit = number(&certificate(folder.path(), "dmesh"), "psnr_y_object_db.mean");
    assert!(lit > 24.0 && lit > unlit - 3.0, "lit {lit} dB, unlit {unlit} dB");
}

#[test]
fn a_change_runs_again_only_what_depends_on_it() {
    let folder = place();
    let view = |x: f64| format!("views.more=[{{ name = \"low\", eye = [{x}, 0.4, 6.0], target = [0.0, 0.5, 0.0] }}]");
    let (code, ran, text) = bake(folder.path(), "dmesh", &[&view(3.0)]);
    assert_eq!((code, ran.iter().any(|r| r == "capture 7")), (0, true), "{ran:?} {text}");
    let (_, ran, _) = bake(folder.path(), "dmesh", &[&view(3.0)]);
    assert!(ran.is_empty(), "{ran:?}");
    // The tolerance: nothing is rendered again but the certificate.
    let (_, ran, _) = bake(folder.path(), "dmesh", &[&view(3.0), "epsilon=0.004"]);
    assert_eq!(ran, ["evaluate 1", "mesh 7", "write 1"]);
    // One camera: its capture and its mesh.
    let (_, ran, _) = bake(folder.path(), "dmesh", &[&view(3.5), "epsilon=0.004"]);
    assert_eq!(ran, ["capture 1", "evaluate 1", "mesh 1", "views 1", "write 1"]);
}

#[test]
fn sizes_that_are_no_power_of_two_and_one_are_refused_or_resampled() {
    let folder = place();
    let (code, _, text) = bake(folder.path(), "dmesh", &["resolution=128"]);
    assert!(code == 1 && text.contains("2^k+1") && text.contains("128 × 128") && text.contains("resample"), "{text}");
    let (code, _, text) = bake(folder.path(), "dmesh", &["resolution=128", "mesh.size=resample"]);
    assert!(code == 0 && text.contains("resampled to 129 × 129"), "{text}");
}

#[test]
fn views_of_nothing_warn_and_spare_the_others() {
    let folder = place();
    let away = "views.more=[{ name = \"away\", eye = [9.0, 0.5, 0.0], target = [19.0, 0.5, 0.0] }]";
    let (code, _, text) = bake(folder.path(), "dmesh", &[away]);
    assert!(code == 0 && text.contains("looks past the scene"), "{text}");
    let alone = ["views.faces=[]", away];
    let (code, _, text) = bake(folder.path(), "dmesh", &alone);
    assert!(code == 1 && text.contains("no camera has a mesh"), "{text}");
}

#[test]
fn mistakes_are_named_before_anything_runs() {
    let folder = place();
    for (set, what) in [
        ("mesh.epsilon=-1", "epsilon"),
        ("mesh.omega=91", "omega"),
        ("mesh.segmentation=orthogonal", "orthogonality"),
        ("views.faces=[\"left\"]", "pos-x"),
        ("capture.layers=0", "layers"),
        ("views.method=cell-windows", "box-faces"),
    ] {
        let (code, ran, text) = bake(folder.path(), "dmesh", &[set]);
        assert!(code == 2 && ran.is_empty() && text.contains(what), "{set}: {code} {text}");
    }
}
