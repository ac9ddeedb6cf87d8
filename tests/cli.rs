//! The program as a user runs it: exit codes, what is printed where, what is written.

use std::{
    path::Path,
    process::{Command, Output},
};
use tempfile::TempDir;

const SMALL: &str = "
[pipeline]
about = \"Writes a small scene\"
[params]
what = \"solids\"
[nodes.make]
kind = \"make-scene\"
what = \"{what}\"
[nodes.write]
kind   = \"write\"
method = \"glb\"
name   = \"scene\"
scene  = \"make\"
[files]
\"./\" = \"write\"
";

/// A working folder that holds `small.toml`.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("small.toml"), SMALL).unwrap();
    folder
}

struct Ran {
    code: i32,
    out: String,
    err: String,
}

fn farfield(folder: &Path, args: &[&str]) -> Ran {
    let mut command = Command::new(env!("CARGO_BIN_EXE_farfield"));
    command.current_dir(folder).args(args).env_remove("FARFIELD_CACHE").env_remove("NO_COLOR");
    let Output { status, stdout, stderr } = command.output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    Ran { code: status.code().unwrap(), out: text(stdout), err: text(stderr) }
}

#[test]
fn a_second_bake_does_nothing() {
    let folder = folder();
    let first = farfield(folder.path(), &["bake", "small.toml"]);
    assert_eq!(first.code, 0, "{}", first.err);
    assert!(first.out.starts_with("baked: small, 0 hits, 2 ran, "), "{}", first.out);
    let glb = std::fs::read(folder.path().join("out/small/scene.glb")).unwrap();
    assert_eq!(&glb[..4], b"glTF");
    assert!(folder.path().join(".farfield/cache").is_dir(), "the default cache");

    let dry = farfield(folder.path(), &["bake", "small.toml", "--dry-run", "--set", "write.unlit=false"]);
    assert_eq!((dry.code, dry.out.as_str(), dry.err.as_str()), (0, "make   hit\nwrite  runs\n", ""));
    let second = farfield(folder.path(), &["bake", "small.toml"]);
    assert!(
        second.code == 0 && second.out.starts_with("baked: small, 2 hits, 0 ran, "),
        "{} {}",
        second.out,
        second.err
    );

    let forced =
        farfield(folder.path(), &["bake", "small.toml", "--force", "write", "--jobs", "1", "--memory", "2GiB"]);
    assert!(forced.out.contains(", 1 ran, "), "{} {}", forced.out, forced.err);
    let only = farfield(folder.path(), &["bake", "small.toml", "--only", "make", "--audit", "100%"]);
    assert_eq!(only.code, 0, "{}", only.err);
    let why = farfield(folder.path(), &["why", "small.toml", "write"]);
    assert!(why.code == 0 && why.out.contains("write"), "{} {}", why.out, why.err);
}

#[test]
fn events_as_json_are_a_line_each() {
    let folder = folder();
    let ran = farfield(folder.path(), &["bake", "small.toml", "--events", "json", "--out", "there", "--cache", "kept"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let events: Vec<serde_json::Value> = ran.out.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let names: Vec<&str> = events.iter().map(|e| e["event"].as_str().unwrap()).collect();
    assert_eq!((names.first(), names.last()), (Some(&"started"), Some(&"finished")));
    assert!(names.contains(&"published"));
    assert!(folder.path().join("there/small/scene.glb").is_file() && folder.path().join("kept").is_dir());
}

/// Whoever reads standard error may leave: `farfield … 2>&1 | head`.
#[test]
fn a_reader_that_leaves_changes_no_exit_code() {
    let folder = folder();
    for (args, code) in [(&["bake", "tmd"][..], 2), (&["bake", "small.toml"], 0), (&["compare", "a", "b"], 2)] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_farfield"));
        command.args(args).current_dir(folder.path()).env_remove("FARFIELD_CACHE").stderr(std::process::Stdio::piped());
        let mut child = command.stdout(std::process::Stdio::null()).spawn().unwrap();
        drop(child.stderr.take());
        assert_eq!(child.wait().unwrap().code(), Some(code), "{args:?}");
    }
}

#[test]
fn mistakes_exit_with_2_and_run_nothing() {
    let folder = folder();
    std::fs::write(folder.path().join("bad.toml"), "[nodes.a]\nkind = \"make-scnee\"\n").unwrap();
    for (args, expect) in [
        (&["bake", "bad.toml"][..], "did you mean `make-scene`?"),
        (&["check", "bad.toml"], "bad.toml:2:8"),
        (&["bake", "smal.toml"], "did you mean `small.toml`?"),
        (&["bake", "tmd"], "did you mean `tdm`?"),
        (&["bake", "small.toml", "--set", "waht=car"], "did you mean `what`?"),
        (&["bake", "small.toml", "--set", "what=cra"], "did you mean `car`?"),
        (&["bake", "small.toml", "--only", "wriet"], "did you mean `write`?"),
        (&["bake", "small.toml", "--memory", "lots"], "4GiB"),
        (&["bake", "small.toml", "--nonsense"], "--nonsense"),
        (&["bake", "small.toml", "--what", "car"], "--set what=car"),
        (&["check", "small.toml", "--resolution=512"], "--set resolution=512"),
        (&["bake", "small.toml", "--name", "a/b"], "no name for a pipeline"),
        (&["nodes", "make-scnee"], "did you mean `make-scene`?"),
        (&["cache", "gc"], "--max-size"),
        (&["cache", "gc", "--max-size", "lots"], "4GiB"),
    ] {
        let ran = farfield(folder.path(), args);
        assert_eq!(ran.code, 2, "{args:?}: {}", ran.err);
        assert!(ran.err.contains(expect), "{args:?}: {}", ran.err);
        assert!(!ran.err.contains('\x1b'), "no colours where there is no terminal");
        assert_eq!(ran.out, "");
    }
    assert!(!folder.path().join("out").exists() && !folder.path().join(".farfield").exists());
}

#[test]
fn a_failed_node_exits_with_1() {
    let folder = folder();
    std::fs::write(folder.path().join("broken.glb"), b"glTF, but no more").unwrap();
    let text = "[nodes.load]\nkind = \"load-scene\"\npath = \"broken.glb\"\n[nodes.write]\nkind = \"write\"\nmethod = \"glb\"\nscene = \"load\"\n[files]\n\"./\" = \"write\"\n";
    std::fs::write(folder.path().join("broken.toml"), text).unwrap();
    let ran = farfield(folder.path(), &["bake", "broken.toml"]);
    assert_eq!(ran.code, 1, "{}", ran.err);
    assert!(ran.err.contains("error: load: ") && ran.out.starts_with("failed: broken"), "{}{}", ran.err, ran.out);
    assert!(!folder.path().join("out/broken/stand-in.glb").exists());
}

#[test]
fn bakes_under_other_names_lie_side_by_side_and_spare_what_is_not_theirs() {
    let folder = folder();
    for name in ["one", "two"] {
        let ran = farfield(folder.path(), &["bake", "small.toml", "--name", name]);
        assert_eq!(ran.code, 0, "{}", ran.err);
        assert!(folder.path().join("out").join(name).join("scene.glb").is_file());
    }
    let mine = folder.path().join("out/small/scene.glb");
    std::fs::create_dir_all(mine.parent().unwrap()).unwrap();
    std::fs::write(&mine, "mine").unwrap();
    let ran = farfield(folder.path(), &["bake", "small.toml"]);
    assert!(ran.code == 1 && ran.err.contains("--overwrite"), "{}", ran.err);
    assert_eq!(std::fs::read(&mine).unwrap(), b"mine");
    assert_eq!(farfield(folder.path(), &["bake", "small.toml", "--overwrite"]).code, 0);
    let manifest = std::fs::read_to_string(folder.path().join("out/small/manifest.json")).unwrap();
    assert!(manifest.contains("\"params\""), "{manifest}");
}

#[test]
fn a_file_that_is_no_scene_is_found_by_check() {
    let folder = folder();
    std::fs::write(folder.path().join("README.md"), "# Title\n").unwrap();
    let ran = farfield(folder.path(), &["check", "tdm", "--set", "scene=README.md"]);
    assert!(ran.code == 2 && ran.err.contains("`README.md` is no scene"), "{}", ran.err);
    let ran = farfield(folder.path(), &["check", "tdm", "--set", "scene=builtin:car", "--set", "evaluate.fov=0.785"]);
    assert!(ran.code == 0 && ran.err.contains("0.785 radians are 45.0"), "{}{}", ran.out, ran.err);
}

#[test]
fn check_and_graph_show_the_plan() {
    let folder = folder();
    let check = farfield(folder.path(), &["check", "small.toml"]);
    assert_eq!(check.out, "ok: pipeline small, 2 nodes, 1 file, 0 requirements\n  ./ ← write.bundle\n");
    let dot = farfield(folder.path(), &["graph", "small.toml"]);
    assert_eq!(
        dot.out,
        "digraph \"small\" {\n  rankdir = LR;\n  node [shape = box, style = rounded];\n  n0 [label = \"make\\nmake-scene\"];\n  \
         n1 [label = \"write\\nwrite glb\"];\n  n0 -> n1 [label = \"scene\"];\n  f0 [label = \"./\", shape = note];\n  \
         n1 -> f0;\n}\n"
    );
    let mermaid = farfield(folder.path(), &["graph", "small.toml", "--format", "mermaid"]);
    assert!(
        mermaid.out.starts_with("flowchart LR\n") && mermaid.out.contains("n0 -->|\"scene\"| n1"),
        "{}",
        mermaid.out
    );
}

#[test]
fn nodes_are_documented() {
    let folder = folder();
    let list = farfield(folder.path(), &["nodes"]);
    assert!(list.out.contains("make-scene") && list.out.contains("write"));
    let page = farfield(folder.path(), &["nodes", "make-scene"]);
    assert!(page.out.contains("what: \"") && page.out.contains("default \"city\""), "{}", page.out);
    let schema = farfield(folder.path(), &["nodes", "--schema"]);
    let schema: serde_json::Value = serde_json::from_str(&schema.out).unwrap();
    assert!(schema["$defs"]["make-scene"]["properties"]["seed"].is_object());
}

#[test]
fn the_cache_is_looked_after() {
    let folder = folder();
    farfield(folder.path(), &["bake", "small.toml"]);
    let stats = farfield(folder.path(), &["cache", "stats"]);
    assert!(stats.code == 0 && stats.out.contains("results  2 runs"), "{}{}", stats.out, stats.err);
    let verify = farfield(folder.path(), &["cache", "verify"]);
    assert!(verify.code == 0 && verify.out.starts_with("clean: "), "{}{}", verify.out, verify.err);
    let gc = farfield(folder.path(), &["cache", "gc", "--max-size", "1GiB", "--max-age", "30d"]);
    assert!(gc.code == 0 && gc.out.starts_with("removed 0 results"), "{}{}", gc.out, gc.err);
    // Each limit works alone.
    for limits in [["--max-age", "30d"], ["--max-size", "1GiB"], ["--keep-bakes", "5"]] {
        let gc = farfield(folder.path(), &[&["cache", "gc"], &limits[..]].concat());
        assert!(gc.code == 0 && gc.out.starts_with("removed 0 results and 0 values"), "{}{}", gc.out, gc.err);
    }
    let gc = farfield(folder.path(), &["cache", "gc", "--max-size", "1kB"]);
    assert!(
        gc.code == 0 && gc.out.contains("last bake on record needs") && gc.out.contains("--keep-bakes 0"),
        "{}",
        gc.out
    );
    let gc = farfield(folder.path(), &["cache", "gc", "--max-size", "1kB", "--keep-bakes", "0"]);
    assert!(gc.code == 0 && gc.out.starts_with("removed 2 results and 2 values"), "{}{}", gc.out, gc.err);
    let audit = farfield(folder.path(), &["bake", "small.toml"]);
    assert!(audit.out.contains("2 ran"), "{}", audit.out);
    let audit = farfield(folder.path(), &["bake", "small.toml", "--audit", "100%"]);
    assert!(audit.code == 0 && audit.err.contains("audit: 2 hits computed again, all "), "{}{}", audit.out, audit.err);
    for action in [&["stats"][..], &["verify"], &["gc", "--max-size", "1GB"]] {
        let ran = farfield(folder.path(), &[&["cache"], action, &["--cache", "nowhere"]].concat());
        assert!(ran.code == 0 && ran.out == "nowhere: no cache yet; a bake makes it\n", "{}{}", ran.out, ran.err);
    }
}

#[test]
fn a_missed_bound_exits_with_3() {
    let folder = folder();
    let bake = |least: f64| {
        let text = format!(
            "[pipeline]\nbase = \"tdm\"\nname = \"judged\"\n[params]\nscene = \"builtin:solids\"\nresolution = 48\n\
             views = 8\n[require.evaluate]\n\"psnr_y_object_db.mean\" = {{ min = {least} }}\n\
             \"crack_px.ratio\" = {{ max = 1 }}\n\"missing_px.ratio\" = {{ max = 1 }}\n\
             \"wrong_surface_px.ratio\" = {{ max = 1 }}\n\"lost_detail_px.ratio\" = {{ max = 1 }}\n\
             \"crack_px.total\" = {{ min = 0 }}\n"
        );
        std::fs::write(folder.path().join("judged.toml"), text).unwrap();
        farfield(folder.path(), &["bake", "judged.toml"])
    };
    let (out, rejected) = (folder.path().join("out/judged"), folder.path().join("out/judged/rejected"));
    let missed = bake(1000.0);
    assert_eq!(missed.code, 3, "{}{}", missed.out, missed.err);
    assert!(missed.out.contains("not met: evaluate: psnr_y_object_db.mean is "), "{}", missed.out);
    assert!(missed.out.contains("required at least 1000\n  means: likeness of brightness"), "{}", missed.out);
    let seen = Path::new("out").join("judged").join("rejected").join("pictures/worst-psnr.png");
    assert!(missed.out.contains(&format!("  seen in: {}\n", seen.display())), "{}", missed.out);
    assert!(folder.path().join(seen).is_file());
    assert!(missed.out.contains("  may help: --set resolution=96 or --set collapse.factor=1.5\n"), "{}", missed.out);
    assert!(missed.out.contains("  to accept it: --require evaluate.psnr_y_object_db.mean=off\n"), "{}", missed.out);
    let none = "no bake of judged into out/judged was accepted yet; the rejected results are in out/judged/rejected\n";
    assert!(missed.out.contains(none), "{}", missed.out);
    assert!(missed.out.contains("\nrequirements: 5 of 6 met\ncertificate not met: judged, "), "{}", missed.out);
    assert!(rejected.join("tdm.glb").is_file() && rejected.join("certificate.json").is_file());
    assert!(!out.join("tdm.glb").exists());
    let met = bake(1.0);
    assert_eq!(met.code, 0, "{}{}", met.out, met.err);
    assert!(met.out.contains(", 0 ran, "), "a bound is no input: {}", met.out);
    assert!(met.out.starts_with("verdict: "), "a bake that did nothing says what is there: {}", met.out);
    assert!(
        met.out.contains("\n  triangles ") && met.out.contains("\nrequirements: 6 of 6 met\nbaked: judged, "),
        "{}",
        met.out
    );
    assert!(out.join("tdm.glb").is_file() && !rejected.exists());
    let again = bake(1000.0);
    assert!(again.code == 3 && again.out.contains("out/judged still holds the results of the last accepted bake"));
    let accept = farfield(folder.path(), &["bake", "judged.toml", "--require", "evaluate.psnr_y_object_db.mean=off"]);
    assert_eq!(accept.code, 0, "{}{}", accept.out, accept.err);
    // A measure that does not exist is found at once, with the nearest.
    let ran = farfield(folder.path(), &["bake", "judged.toml", "--require", "evaluate.psnr_y_objct_db.mean=30.."]);
    assert!(ran.code == 2 && ran.err.contains("did you mean `psnr_y_object_db.mean`?"), "{}", ran.err);
}

#[cfg(unix)]
#[test]
fn an_interrupted_bake_exits_with_130_and_keeps_what_is_finished() {
    use std::{
        io::{BufRead, BufReader},
        process::Stdio,
    };
    let folder = folder();
    let mut child = Command::new(env!("CARGO_BIN_EXE_farfield"))
        .current_dir(folder.path())
        .args(["bake", "tdm-city", "--events", "json"])
        .env_remove("FARFIELD_CACHE")
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // The slices of the city take seconds: nobody can be late.
    for line in BufReader::new(child.stdout.take().unwrap()).lines() {
        let event: serde_json::Value = serde_json::from_str(&line.unwrap()).unwrap();
        if event["event"] == "node-started" && event["node"] == "slices" {
            assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        }
    }
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(!folder.path().join("out").exists());
    let select = farfield(folder.path(), &["bake", "tdm-city", "--only", "select"]);
    assert!(select.code == 0 && select.out.contains(", 0 ran, "), "{}{}", select.out, select.err);
}

#[test]
fn a_profile_has_a_span_per_run() {
    let folder = folder();
    let ran = farfield(folder.path(), &["bake", "small.toml", "--profile", "trace.json"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let trace = std::fs::read(folder.path().join("trace.json")).unwrap();
    let trace: serde_json::Value = serde_json::from_slice(&trace).unwrap();
    let events = trace["traceEvents"].as_array().unwrap();
    for name in ["make", "write"] {
        let of_name: Vec<_> = events.iter().filter(|e| e["name"] == name).collect();
        assert!(matches!(of_name[..], [e] if e["ph"] == "X" && e["dur"].as_f64().unwrap() > 0.0), "{trace}");
    }
}

#[test]
fn a_scene_that_cannot_be_baked_exits_with_1_and_publishes_nothing() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
               element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let far = "centre = [0, 0, 5]";
    for (name, scene, cell, select, expect) in [
        ("truncated", ply[..ply.len() - 16].to_owned(), far, "*", "scene.ply: vertex: truncated: 3 elements"),
        ("nan", ply.replace("1 0 0\n", "1 nan 0\n"), far, "*", "1 with a corner that is no finite number"),
        ("range", ply.replace("3 0 1 2", "3 0 1 9"), far, "*", "1 with a vertex number that does not exist"),
        ("claims", ply.replace("vertex 3", "vertex 4000000000"), far, "*", "truncated: 4000000000 elements"),
        ("empty", ply.to_owned(), far, "none*", "no triangle of the scene's 1 objects is selected"),
        ("inside", ply.to_owned(), "centre = [0, 0, 0.2]", "*", "the selection intersects the view cell"),
    ] {
        let folder = folder();
        std::fs::write(folder.path().join("scene.ply"), scene).unwrap();
        let text = format!(
            "[pipeline]\nbase = \"tdm\"\n[params]\nscene = \"scene.ply\"\nresolution = 48\nviews = 8\n[nodes.cell]\n{cell}\n\
             size = [1, 1, 1]\n[nodes.select]\ninclude = [\"{select}\"]\n"
        );
        std::fs::write(folder.path().join("bad.toml"), text).unwrap();
        let ran = farfield(folder.path(), &["bake", "bad.toml"]);
        assert_eq!(ran.code, 1, "{name}: {}{}", ran.out, ran.err);
        assert!(ran.err.contains(expect), "{name}: {}", ran.err);
        assert!(!folder.path().join("out").exists(), "{name}");
    }
}

#[test]
fn a_cache_that_cannot_be_written_is_named() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("cache")).unwrap();
    std::fs::write(folder.path().join("cache/values"), "").unwrap();
    let ran = farfield(folder.path(), &["bake", "small.toml", "--cache", "cache"]);
    assert!(
        ran.code == 2 && ran.err.contains("error: cache cache: it holds `values` and is not"),
        "{}{}",
        ran.out,
        ran.err
    );
    // A file in a folder's place stops everyone, root too, for whom permissions do not count.
    let ran = farfield(folder.path(), &["bake", "small.toml", "--cache", "small.toml/cache"]);
    assert!(ran.code == 1 && ran.err.contains("error: cache small.toml/cache: cannot be "), "{}{}", ran.out, ran.err);
    assert!(!folder.path().join("out").exists());
}

#[test]
fn the_back_end_changes_no_byte() {
    let folder = tempfile::tempdir().unwrap();
    let pipeline = concat!(env!("CARGO_MANIFEST_DIR"), "/pipelines/tdm.toml");
    let bake = |backend: &[&str], out: &str, cache: &str| {
        let knobs = ["bake", pipeline, "--set", "resolution=96", "--set", "views=8", "--out", out, "--cache", cache];
        farfield(folder.path(), &[&knobs[..], backend].concat())
    };
    let first = bake(&["--backend", "cpu"], "a", "kept a");
    assert_eq!(first.code, 0, "{}", first.err);
    let devices = farfield(folder.path(), &["devices"]);
    assert_eq!(devices.code, 0, "{}", devices.err);
    let wrong = bake(&["--adapter", "no such adapter"], "b", "kept b");
    assert_eq!(wrong.code, 2, "{}", wrong.err);
    let both = bake(&["--adapter", "x", "--backend", "cpu"], "b", "kept b");
    assert!(both.code == 2 && both.err.contains("--backend is cpu"), "{}", both.err);
    assert!(!folder.path().join("b").exists());

    let gpu = bake(&["--backend", "gpu"], "b", "kept b");
    if devices.out.starts_with("no adapters") {
        assert_eq!(gpu.code, 2, "{}", gpu.err);
        return eprintln!("skipped: {}", devices.out);
    }
    assert_eq!(gpu.code, 0, "{}", gpu.err);
    for name in ["tdm.glb", "certificate.json", "manifest.json"] {
        let read = |out: &str| std::fs::read(folder.path().join(out).join("tdm").join(name)).unwrap();
        assert!(read("a") == read("b"), "{name} differs");
    }
    // What one back end baked is a hit for the other.
    let again = bake(&["--backend", "gpu"], "a", "kept a");
    assert!(again.out.contains(" 0 ran, "), "{} {}", again.out, again.err);
}

/// Classifies a point as section 4.4 and figure 13 of the paper do, from the files alone.
fn inside(manifest: &serde_json::Value, data: &[u8], world: [f64; 3]) -> bool {
    let number = |v: &serde_json::Value| v.as_f64().unwrap();
    let t: Vec<f32> = (0..3)
        .map(|i| {
            let row = &manifest["world_to_texture"][i];
            ((0..3).map(|k| number(&row[k]) * world[k]).sum::<f64>() + number(&row[3])) as f32
        })
        .collect();
    let size = |k: usize| number(&manifest["size"][k]) as f32;
    let region: Vec<i64> = (0..4).map(|k| manifest["region"][k].as_i64().unwrap()).collect();
    let (x, y) = ((t[0] * size(0)).floor() as i64 - region[0], (t[1] * size(1)).floor() as i64 - region[1]);
    if x < 0 || y < 0 || x >= region[2] || y >= region[3] {
        return false;
    }
    let texel = |i: usize, k: usize| {
        let at = manifest["sections"][0]["offset"].as_u64().unwrap() as usize + 8 * i + 4 * k;
        u32::from_le_bytes(data[at..at + 4].try_into().unwrap())
    };
    let index = (y * region[2] + x) as usize;
    let (offset, count) = (texel(index, 0), texel(index, 1));
    (offset..offset + count)
        .any(|i| f32::from_bits(texel(i as usize, 0)) <= t[2] && t[2] <= f32::from_bits(texel(i as usize, 1)))
}

#[test]
fn a_solid_becomes_a_sprite_that_tells_inside_from_outside() {
    // A cube of 2 m around (5, 0, 0).
    const CUBE: &str = "v 4 -1 -1\nv 6 -1 -1\nv 6 1 -1\nv 4 1 -1\nv 4 -1 1\nv 6 -1 1\nv 6 1 1\nv 4 1 1\n\
                        f 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 5 8 4\nf 2 3 7 6\n";
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cube.obj"), format!("{CUBE}f 1 4 3 2\n")).unwrap();
    std::fs::write(folder.path().join("open.obj"), CUBE).unwrap();
    let bake = |scene: &str, more: &[&str]| {
        let scene = format!("scene={scene}");
        let knobs = ["bake", "vds", "--set", &scene, "--set", "resolution=128", "--set", "views=9"];
        farfield(folder.path(), &[&knobs[..], more].concat())
    };
    let done = bake("cube.obj", &["--set", "compress.layout=ranges"]);
    assert_eq!(done.code, 0, "{} {}", done.out, done.err);
    let read = |name: &str| std::fs::read(folder.path().join("out/vds").join(name)).unwrap();
    let json = |name: &str| serde_json::from_slice::<serde_json::Value>(&read(name)).unwrap();
    let (manifest, certificate, data) = (json("vds.json"), json("certificate.json"), read("vds.bin"));
    assert_eq!(manifest["layout"], "ranges");
    assert_eq!((&certificate["wrong_points"], &certificate["odd_rays"]), (&0.into(), &0.into()));
    assert!(certificate["inside_points"].as_u64().unwrap() > 1000);
    let mut counts = [0; 2];
    for i in 0..1000 {
        let at = |k: i32| f64::from(i / k % 10) * 0.31 - 1.4;
        let p = [5.0 + at(1), at(10), at(100)];
        let far = |c: f64| (c.abs() - 1.0).abs() > 0.05;
        if far(p[0] - 5.0) && far(p[1]) && far(p[2]) {
            let truth = (p[0] - 5.0).abs() < 1.0 && p[1].abs() < 1.0 && p[2].abs() < 1.0;
            assert_eq!(inside(&manifest, &data, p), truth, "{p:?}");
            counts[usize::from(truth)] += 1;
        }
    }
    assert!(counts[0] > 300 && counts[1] > 200, "{counts:?}");

    assert_eq!((&read("vds.exr")[..4], &read("vds.dds")[..4]), (&[0x76, 0x2f, 0x31, 0x01][..], &b"DDS "[..]));
    for name in ["vds.wgsl", "vds.comp", "vds.hlsl", "vds.metal", "vds.spv"] {
        assert!(read(name).len() > 1000, "{name}");
    }
    let preview = farfield::image::load_png(&folder.path().join("out/vds/vds.png")).unwrap();
    let shown = preview.texels.iter().filter(|t| **t != [222, 226, 230, 255]).count();
    assert!(shown > preview.texels.len() / 20, "the preview shows the solid: {shown} texels");

    // Depths of 16 bits change by no more than they promise.
    let short = bake("cube.obj", &["--set", "compress.layout=rows", "--set", "compress.depths=u16"]);
    assert_eq!(short.code, 0, "{} {}", short.out, short.err);
    let (manifest, certificate) = (json("vds.json"), json("certificate.json"));
    assert_eq!((&manifest["depths"]["form"], &manifest["sections"][2]["element"]), (&"u16".into(), &"u16x2".into()));
    let error = |name: &str| certificate["depth_error"][name].as_f64().unwrap();
    assert!(error("max") <= error("bound") && error("bound") <= 1.0 / 65536.0, "{certificate}");
    let neither = bake("cube.obj", &["--set", "compress.layout=raw", "--set", "compress.depths=u16"]);
    assert!(neither.code == 2 && neither.err.contains("`rows` and `runs`"), "{}", neither.err);

    // Another layout packs again; what was peeled is a hit.
    let again = bake("cube.obj", &[]);
    assert!(again.code == 0 && again.out.contains("4 hits, 3 ran"), "{} {}", again.out, again.err);
    assert_eq!(json("vds.json")["layout"], "raw");

    // Along −Z, through the side that is missing.
    let open = bake("open.obj", &["--set", "direction.count=1"]);
    assert!(open.code == 1 && open.err.contains("--set peel.repair=winding"), "{}", open.err);
    assert_eq!(json("vds.json")["layout"], "raw", "nothing is lost");
    let repaired = bake("open.obj", &["--set", "direction.count=1", "--set", "peel.repair=pair"]);
    // Every ray enters and never leaves: nothing remains to pack.
    assert!(repaired.code == 1 && repaired.err.contains("no ray meets"), "{}", repaired.err);

    // The winding number closes the side, as the message proposed.
    let closed = bake("open.obj", &["--set", "direction.count=1", "--set", "peel.repair=winding"]);
    assert_eq!(closed.code, 0, "{} {}", closed.out, closed.err);
    let certificate = json("certificate.json");
    assert_eq!(certificate["wrong_points"], 0, "{certificate}");
    assert!(certificate["inside"].as_str().unwrap().contains("winding number"), "{certificate}");
    assert!(certificate["inside_points"].as_u64().unwrap() > 1000, "{certificate}");
}

/// A target of triangles is met, and the bound in the certificate is that of the factor found.
#[test]
fn a_number_of_triangles_is_met() {
    let folder = tempfile::tempdir().unwrap();
    let bake = |more: &[&str]| {
        let knobs = ["bake", "tdm", "--set", "resolution=160", "--set", "views=8"];
        farfield(folder.path(), &[&knobs[..], more].concat())
    };
    let figures = || {
        let out = folder.path().join("out/tdm");
        let at = [out.join("certificate.json"), out.join("rejected/certificate.json")];
        let bytes = at.iter().find_map(|p| std::fs::read(p).ok()).unwrap();
        let certificate: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
        let triangles = certificate["triangles"].as_u64().unwrap();
        (triangles, certificate.pointer("/bound/value").and_then(serde_json::Value::as_f64).unwrap())
    };
    let free = bake(&["--set", "collapse.factor=1"]);
    assert_eq!(free.code, 0, "{} {}", free.out, free.err);
    let (most, least_bound) = figures();
    let target = most * 2 / 3;
    for knob in [format!("triangles={target}"), format!("collapse.triangles={target}")] {
        std::fs::remove_dir_all(folder.path().join("out")).unwrap();
        let met = bake(&["--set", &knob]);
        assert!(met.code == 0 || met.code == 3, "{} {}", met.out, met.err);
        let (found, bound) = figures();
        // `collapse.triangles` counts in each connected mesh.
        assert!(found <= target || knob.starts_with("collapse"), "{found} triangles of {target}");
        assert!(bound > least_bound, "{bound} and {least_bound} px");
    }
    let never = bake(&["--set", "triangles=1"]);
    assert!(never.code == 1 && never.err.contains("1 triangles cannot be reached"), "{}", never.err);
}

/// `vds-clip` takes any closed objects, at the places that are there; an empty picture is a warning.
#[test]
fn places_take_whatever_solids_there_are() {
    const KNIFE: &str = "v -40 -10 -10\nv 60 -10 -10\nv 0 90 -10\nv 0 0 70\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("knife.obj"), KNIFE).unwrap();
    for name in ["clip", "borders", "lenses", "points"] {
        let small = ["--set", "resolution=64", "--set", "views=3", "--set", "size=[96, 64]"];
        let pipeline = format!("vds-{name}");
        let knobs = ["bake", pipeline.as_str(), "--set", "volumes=knife.obj"];
        let done = farfield(folder.path(), &[&knobs[..], &small[..]].concat());
        assert!(done.code == 0 && !done.err.contains("empty"), "{name}: {} {}", done.out, done.err);
    }
    let away = ["bake", "vds-clip", "--set", "resolution=64", "--set", "views=3", "--set", "size=[96, 64]"];
    let away = farfield(folder.path(), &[&away[..], &["--set", "draw.target=[0, 900, 0]"]].concat());
    assert!(away.code == 0 && away.err.contains("the picture is empty"), "{} {}", away.out, away.err);
}

#[test]
fn the_applications_of_sprites_draw_and_report() {
    let folder = tempfile::tempdir().unwrap();
    let pipelines = ["clip", "borders", "styles", "lenses", "collide", "points", "draw"];
    let mut pictures = Vec::new();
    for name in pipelines {
        let pipeline = format!("vds-{name}");
        let small = ["--set", "resolution=96", "--set", "views=5", "--set", "size=[96, 64]"];
        let done = farfield(folder.path(), &[&["bake", pipeline.as_str()], &small[..]].concat());
        assert_eq!(done.code, 0, "{name}: {} {}", done.out, done.err);
        let out = folder.path().join("out").join(&pipeline);
        let picture = farfield::image::load_png(&out.join(format!("{name}.png"))).unwrap();
        assert_eq!((picture.width, picture.height), (96, 64), "{name}");
        let background = picture.texels.iter().filter(|t| **t == [222, 226, 230, 255]).count();
        assert!(background < picture.texels.len() * 19 / 20, "{name}: nothing is drawn");
        assert!(!out.join("clip.png").exists() || name == "clip", "{name} draws another picture too");
        pictures.push(picture.texels);
    }
    // Four of them show one scene, and no two the same.
    for i in 0..pictures.len() {
        assert!(!pictures[..i].contains(&pictures[i]), "{}", pipelines[i]);
    }
    let json = |name: &str| {
        let bytes = std::fs::read(folder.path().join("out").join(name)).unwrap();
        serde_json::from_slice::<serde_json::Value>(&bytes).unwrap()
    };
    let report = json("vds-collide/collide.json");
    let pairs: Vec<_> = report["pairs"].as_array().unwrap().iter().map(|p| (&p["a"], &p["b"], &p["collide"])).collect();
    let expect = [("box", "sphere", true), ("box", "torus", false), ("sphere", "torus", true)];
    assert_eq!(pairs.len(), expect.len());
    for ((a, b, collide), expect) in pairs.into_iter().zip(expect) {
        assert_eq!((a.as_str().unwrap(), b.as_str().unwrap(), collide.as_bool().unwrap()), expect);
    }
    let points = json("vds-points/points.json");
    let number = |pointer: &str| points.pointer(pointer).unwrap().as_u64().unwrap();
    let inside: u64 = ["box", "sphere", "torus"].iter().map(|s| number(&format!("/inside/{s}"))).sum();
    // No point lies in all three.
    assert_eq!(number("/points"), number("/outside") + inside - number("/inside_several"));
    assert!(inside > 60 && number("/outside") > 300, "{points}");
}

#[test]
fn a_pipeline_to_start_from_checks_and_spares_what_is_there() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("models")).unwrap();
    let obj = "v 0 0 0\nv 4 0 0\nv 0 3 1\nf 1 2 3\n";
    std::fs::write(folder.path().join("models/town.obj"), obj).unwrap();
    let first = farfield(folder.path(), &["init", "models/town.obj"]);
    assert_eq!(first.code, 0, "{}", first.err);
    assert!(first.out.starts_with("wrote town-tdm.toml\nwrote farfield.schema.json"), "{}", first.out);
    let text = std::fs::read_to_string(folder.path().join("town-tdm.toml")).unwrap();
    assert!(text.starts_with("#:schema ./farfield.schema.json\n"), "{text}");
    assert!(text.contains("\nscene = \"models/town.obj\"") && text.contains("\n[nodes.cell]"), "{text}");
    let schema = std::fs::read(folder.path().join("farfield.schema.json")).unwrap();
    assert_eq!(schema, farfield(folder.path(), &["nodes", "--schema"]).out.into_bytes());
    let check = farfield(folder.path(), &["check", "town-tdm.toml"]);
    assert!(check.code == 0 && check.out.starts_with("ok: pipeline town-tdm, "), "{}{}", check.out, check.err);

    let again = farfield(folder.path(), &["init", "models/town.obj"]);
    assert!(again.code == 2 && again.err.contains("--overwrite"), "{}", again.err);
    assert_eq!(std::fs::read_to_string(folder.path().join("town-tdm.toml")).unwrap(), text);
    std::fs::write(folder.path().join("town-tdm.toml"), "mine").unwrap();
    let over = farfield(folder.path(), &["init", "models/town.obj", "--overwrite"]);
    assert!(over.code == 0 && !over.out.contains("schema"), "{}{}", over.out, over.err);
    assert_eq!(std::fs::read_to_string(folder.path().join("town-tdm.toml")).unwrap(), text);

    // A schema of somebody else's stays.
    std::fs::write(folder.path().join("models/farfield.schema.json"), "{}").unwrap();
    let other = farfield(folder.path(), &["init", "models/town.obj", "--method", "dmesh", "-o", "models/d.toml"]);
    assert!(other.code == 0 && other.err.contains("stays as it is"), "{}", other.err);
    assert_eq!(std::fs::read(folder.path().join("models/farfield.schema.json")).unwrap(), b"{}");
    let text = std::fs::read_to_string(folder.path().join("models/d.toml")).unwrap();
    assert!(text.contains("\nscene = \"town.obj\"") && text.contains("\nname = \"d\""), "{text}");
    assert_eq!(farfield(folder.path(), &["check", "models/d.toml"]).code, 0);

    for (args, expect) in [
        (&["init", "twon.obj"][..], "there is no such file"),
        (&["init", "builtin:crane"], "no built-in scene `crane`"),
        (&["init", "models/town.obj", "--method", "tmd"], "tdm"),
        (&["init", "models/town.obj", "-o", "models/town.obj", "--overwrite"], "this is the scene"),
        (&["init", "builtin:car", "-o", "no/such/folder.toml"], "cannot be written"),
    ] {
        let ran = farfield(folder.path(), args);
        assert!(ran.code == 2 && ran.err.contains(expect), "{args:?}: {} {}", ran.code, ran.err);
    }
    assert_eq!(std::fs::read_to_string(folder.path().join("models/town.obj")).unwrap(), obj);
}

#[test]
fn completions_and_manual_pages_are_printed() {
    let folder = folder();
    let bash = farfield(folder.path(), &["completions", "bash"]);
    assert!(bash.code == 0 && bash.out.contains("complete -F _farfield"), "{}", bash.err);
    let wrong = farfield(folder.path(), &["completions", "bahs"]);
    assert!(wrong.code == 2 && wrong.err.contains("bash"), "{}", wrong.err);
    let page = farfield(folder.path(), &["man"]);
    assert!(page.code == 0 && page.out.contains(".SH SUBCOMMANDS"), "{}", page.err);
    let pages = farfield(folder.path(), &["man", "pages/man1"]);
    assert!(pages.code == 0 && folder.path().join("pages/man1/farfield-bake.1").is_file(), "{}", pages.err);
    let wrong = farfield(folder.path(), &["man", "small.toml"]);
    assert!(wrong.code == 1 && wrong.err.contains("small.toml: "), "{}", wrong.err);
}

/// Rows are checked before the first is baked; each is cached by itself, and the table changes only where the results do.
#[test]
fn a_batch_bakes_every_row_and_leaves_one_table() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let text = "[params]\nseed = 1\n[nodes.make]\nkind = \"make-scene\"\nwhat = \"car\"\nseed = \"{seed}\"\n\
                [nodes.choose]\nkind = \"choose\"\nscene = \"make\"\nbudget = { triangles = 0 }\n\
                [files]\n\"choice.json\" = \"choose.certificate\"\n[require.choose]\nbudget_taken = { max = 1 }\n";
    let batch = |rows: &str| std::fs::write(path("cars.toml"), format!("{text}{rows}")).unwrap();
    batch("[batch]\nseed = [1, 2]\n");
    let first = farfield(folder.path(), &["bake", "cars.toml"]);
    assert!(
        first.code == 0 && first.out.contains("batch: 2 of 2 bakes met all, ") && !first.out.contains(" 0 ran, "),
        "{}{}",
        first.out,
        first.err
    );
    let table = || {
        (std::fs::read_to_string(path("out/summary.csv")).unwrap(), std::fs::read(path("out/summary.html")).unwrap())
    };
    let (csv, html) = table();
    assert!(csv.starts_with("bake,outcome,verdict,") && csv.lines().count() == 3, "{csv}");
    assert!(csv.lines().nth(2).unwrap().starts_with("2,baked,within budget,1,1,2,"), "{csv}");
    assert!(String::from_utf8(html.clone()).unwrap().contains("href=\"cars-2/report.html\""));
    let again = farfield(folder.path(), &["bake", "cars.toml"]);
    assert!(again.out.contains("4 hits, 0 ran, ") && table() == (csv, html), "{}", again.out);

    // A row that misses a bound and one whose scene is wrong keep no other from its results.
    batch(
        "[[batch]]\nname = \"small\"\n\"choose.budget\" = { triangles = 3 }\n[[batch]]\nname = \"whole\"\nseed = 1\n",
    );
    let missed = farfield(folder.path(), &["bake", "cars.toml"]);
    assert!(missed.code == 3 && missed.out.contains("batch: 1 of 2 bakes met all"), "{} {}", missed.code, missed.out);
    let (csv, _) = table();
    assert!(csv.lines().nth(1).unwrap().starts_with("small,certificate not met,over budget,0,1,"), "{csv}");
    let one = farfield(folder.path(), &["bake", "cars.toml", "--row", "whole"]);
    assert!(one.code == 0 && table().0.lines().count() == 2, "{}", one.out);

    for (args, expect) in [
        (&["bake", "cars.toml", "--row", "wole"][..], "did you mean `whole`?"),
        (&["bake", "small.toml", "--row", "whole"], "the pipeline has no [batch]"),
        (&["bake", "cars.toml", "--profile", "p.json"], "--profile"),
    ] {
        let ran = farfield(folder.path(), args);
        assert!(ran.code == 2 && ran.err.contains(expect), "{args:?}: {} {}", ran.code, ran.err);
    }
    batch("[batch]\nsed = [1]\n");
    for command in ["check", "bake"] {
        let wrong = farfield(folder.path(), &[command, "cars.toml"]);
        assert!(
            wrong.code == 2 && wrong.err.contains("no knob `sed`") && wrong.err.contains("in the row `1`"),
            "{}",
            wrong.err
        );
    }
}
