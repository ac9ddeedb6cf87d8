//! Octahedral impostors from end to end: what is baked, what runs again when something changes, and what is said of input that cannot be.

mod support;

use serde_json::Value;
use std::path::Path;
use tempfile::tempdir;

/// A small bake of a stock pipeline with these changes: exit code, the names of the nodes that ran, what was said.
fn bake(folder: &Path, pipeline: &str, set: &[&str]) -> (i32, Vec<String>, String) {
    let mut command = support::command(folder, pipeline);
    let small = ["views=8", "evaluate.resolution=96", "evaluate.samples=2", "resolution=64", "frames=6", "margin=2"];
    for set in small.iter().filter(|s| !set.iter().any(|o| o.split('=').next() == s.split('=').next())).chain(set) {
        command.args(["--set", set]);
    }
    support::outcome(command, folder, pipeline)
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))).unwrap()
}

fn number(value: &Value, path: &str) -> f64 {
    let found = path.split('.').fold(value, |v, key| &v[key]);
    found.as_f64().unwrap_or_else(|| panic!("{path} is {found}"))
}

#[test]
fn a_bundle_is_baked_and_certified() {
    let folder = tempdir().unwrap();
    let (code, _, text) = bake(folder.path(), "octahedral", &[]);
    assert_eq!(code, 0, "{text}");
    let out = folder.path().join("out/octahedral");
    for file in ["octahedral.json", "octahedral.glb", "octahedral.wgsl", "color-alpha.png", "normal-depth.ktx2"] {
        assert!(out.join(file).is_file(), "{file}");
    }
    let c = json(&out.join("certificate.json"));
    assert!(number(&c, "psnr_y_object_db.mean") > 20.0, "{}", number(&c, "psnr_y_object_db.mean"));
    assert!(number(&c, "missing_px.ratio") < 0.05, "{}", number(&c, "missing_px.ratio"));
    // Nothing is rendered again for another number of steps but the certificate.
    let (code, ran, text) = bake(folder.path(), "octahedral", &["write.steps=1"]);
    assert_eq!((code, ran), (0, vec!["evaluate 1".to_owned(), "write 1".to_owned()]), "{text}");
}

/// One impostor for each object, each with all frames of its own.
#[test]
fn objects_are_baked_each_by_itself() {
    let folder = tempdir().unwrap();
    let set = ["scene=builtin:solids", "frames=4", "hemi=true", "resolution=32"];
    let (code, ran, text) = bake(folder.path(), "octahedral-objects", &set);
    assert_eq!(code, 0, "{text}");
    let out = folder.path().join("out/octahedral-objects");
    let names: Vec<String> = out
        .read_dir()
        .unwrap()
        .map(|e| e.unwrap())
        .filter(|e| e.path().is_dir())
        .map(|e| e.file_name().into_string().unwrap())
        .collect();
    let n = names.len();
    assert!(n >= 2 && ran.contains(&format!("write {n}")) && ran.contains(&format!("resample {n}")), "{ran:?}");
    assert!(ran.contains(&format!("capture {}", 16 * n)), "{ran:?}");
    let centres: Vec<String> = names
        .iter()
        .map(|name| {
            assert!(out.join(name).join("color-alpha.png").is_file());
            let c = json(&out.join(name).join("certificate.json"));
            assert!(number(&c, "psnr_y_object_db.mean") > 15.0);
            let m = json(&out.join(name).join("octahedral.json"));
            assert_eq!((m["frames"].as_u64(), m["mapping"].as_str()), (Some(4), Some("hemi-octahedral")));
            m["centre"].to_string()
        })
        .collect();
    assert!(centres.iter().enumerate().all(|(i, c)| !centres[..i].contains(c)), "{centres:?}");
    let (_, ran, _) = bake(folder.path(), "octahedral-objects", &set);
    assert!(ran.is_empty(), "{ran:?}");
}

#[test]
fn mistakes_are_named() {
    let folder = tempdir().unwrap();
    for (set, code, what) in [
        ("write.steps=65", 2, "steps"),
        ("resample.tile=48", 2, "power of two"),
        ("resolution=48", 2, "power of two"),
        ("frames=1", 2, "frames"),
        ("frames=2", 1, "4 captures"),
        ("resample.tile=256", 1, "frames of 256 texels from captures of 128 pixels"),
    ] {
        let (found, _, text) = bake(folder.path(), "octahedral", &[set]);
        let plain = text.split_whitespace().filter(|w| *w != "│").collect::<Vec<_>>().join(" ");
        assert!(found == code && plain.contains(what), "{set}: {found} {text}");
    }
}
