//! Who may import whom.
//!
//! The engine knows no algorithm and no node; algorithms know no engine; only the library's root and the command line
//! name the nodes; only `gpu/` names wgpu. Files stay short enough to hold one concept.

use std::path::{Path, PathBuf};

const ALGORITHMS: [&str; 13] = [
    "scene",
    "raster",
    "mesh",
    "view",
    "voxel",
    "image",
    "atlas",
    "formats",
    "certify",
    "runtime",
    "gpu",
    "sprite",
    "depth_mesh",
];

fn sources(folder: &str) -> Vec<(String, String)> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in folder.read_dir().into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                found.push(path);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    walk(&root.join(folder), &mut found);
    found.sort();
    let name = |p: &Path| p.strip_prefix(root).unwrap().to_str().unwrap().replace('\\', "/");
    found.iter().map(|p| (name(p), code(&std::fs::read_to_string(p).unwrap()))).collect()
}

/// A file without its comments, white space made single.
fn code(text: &str) -> String {
    let lines = text.lines().map(|l| l.split_once("//").map_or(l, |(code, _)| code));
    lines.flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ")
}

/// The first-level modules of the crate that `code` names by `crate::x` or `crate::{x, …}`.
fn modules(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    for rest in code.split("crate::").skip(1) {
        let Some(group) = rest.strip_prefix('{') else {
            found.push(rest);
            continue;
        };
        let mut depth = 0;
        let mut start = Some(0);
        for (at, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => start = None,
                c if start.is_none() && c.is_alphanumeric() => start = Some(at),
                _ => continue,
            }
            if depth == 0 && start == Some(at) {
                found.push(&group[at..]);
            }
        }
        found.push(group);
    }
    let word = |s: &str| s.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    found.into_iter().map(word).collect()
}

#[test]
fn the_modules_of_a_text_are_found() {
    let text = "use crate::{array::Bytes, math::{Stop, view::{A, B}}, scene}; fn f() { crate::nodes::registry(); }";
    let mut found = modules(text);
    found.sort();
    found.dedup();
    assert_eq!(found, ["array", "math", "nodes", "scene"]);
}

/// Every file of `folder` that names one of `forbidden`.
fn check(folder: &str, forbidden: &[&str], except: &[&str]) {
    for (name, code) in sources(folder) {
        if except.iter().any(|e| name.starts_with(e)) {
            continue;
        }
        // A module's tests may use what the module may not.
        let code = code.split("#[cfg(test)] mod tests {").next().unwrap_or_default();
        for module in modules(code) {
            assert!(!forbidden.contains(&module.as_str()), "{name} uses crate::{module}");
        }
    }
}

#[test]
fn the_engine_knows_no_algorithm_and_no_node() {
    let forbidden: Vec<&str> = ALGORITHMS.into_iter().chain(["nodes", "cli"]).collect();
    check("src/engine", &forbidden, &[]);
}

#[test]
fn algorithms_know_no_engine() {
    for folder in ALGORITHMS.into_iter().chain(["math"]) {
        check(&format!("src/{folder}"), &["engine", "nodes", "cli"], &[]);
    }
}

#[test]
fn only_the_root_and_the_command_line_name_the_nodes() {
    check("src", &["nodes"], &["src/lib.rs", "src/cli/"]);
    check("nodes", &["cli"], &[]);
}

#[test]
fn only_the_gpu_folder_names_wgpu() {
    for (name, code) in sources("src").into_iter().chain(sources("nodes")) {
        assert!(name.starts_with("src/gpu/") || !code.contains("wgpu::"), "{name} names wgpu");
    }
}

#[test]
fn files_hold_one_concept() {
    for (name, _) in sources("src").into_iter().chain(sources("nodes")) {
        let lines = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(&name)).unwrap().lines().count();
        assert!(lines <= 500, "{name} has {lines} lines, at most 500");
    }
}

#[test]
fn the_program_is_short() {
    let main = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/main.rs")).unwrap();
    assert!(main.lines().count() <= 15);
}
