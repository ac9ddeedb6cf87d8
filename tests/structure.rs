//! Who may import whom.
//!
//! The engine knows no algorithm and no node; algorithms know no engine; only the library's root and the command line
//! name the nodes; only `gpu/` names wgpu. Files stay short enough to hold one concept.

use std::path::{Path, PathBuf};

const ALGORITHMS: [&str; 18] = [
    "capture",
    "choice",
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
    "octahedral",
    "report",
    "texture",
];

/// Folders whose files never need each other in a circle.
const ROOMS_WITHOUT_CIRCLES: [&str; 16] = [
    "src/atlas",
    "src/capture",
    "src/choice",
    "src/cli",
    "src/depth_mesh",
    "src/engine",
    "src/image",
    "src/mesh",
    "src/octahedral",
    "src/raster",
    "src/report",
    "src/scene",
    "src/sprite",
    "src/texture",
    "src/view",
    "src/voxel",
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

/// The paths that the `use` trees of `code` name, and those that it writes out from `super::` or `crate::`.
fn paths(code: &str) -> Vec<String> {
    fn expand(prefix: &str, tree: &str, found: &mut Vec<String>) {
        let (mut depth, mut start) = (0, 0);
        for (at, c) in tree.char_indices().chain([(tree.len(), ',')]) {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    let part = tree[start..at].trim();
                    start = at + 1;
                    match part.split_once('{') {
                        Some((head, rest)) => {
                            expand(&format!("{prefix}{}", head.trim()), rest.trim_end_matches('}'), found);
                        }
                        None if !part.is_empty() => found.push(format!("{prefix}{part}")),
                        None => {}
                    }
                }
                _ => {}
            }
        }
    }
    let mut found = Vec::new();
    for rest in code.split("use ").skip(1) {
        expand("", rest.split(';').next().unwrap_or_default(), &mut found);
    }
    for start in ["super::", "crate::"] {
        for (at, _) in code.match_indices(start).filter(|(at, _)| !code[..*at].ends_with("::")) {
            found.push(code[at..].chars().take_while(|c| c.is_alphanumeric() || "_:".contains(*c)).collect());
        }
    }
    found
}

/// The files among `files` (modules by path) that `module` names. What a file takes of the module around it does not count:
/// a folder's `mod.rs` holds what its files share.
fn named<'f>(module: &str, code: &str, files: &'f [(String, String)]) -> Vec<&'f str> {
    let around = |file: &str| module == file || module.starts_with(&format!("{file}::"));
    let mut found = Vec::new();
    for path in paths(code) {
        let mut base: Vec<&str> = module.split("::").collect();
        let mut steps: Vec<&str> = path.split("::").collect();
        if steps[0] == "crate" {
            base.clear();
            steps.remove(0);
        }
        while steps.first() == Some(&"super") {
            base.pop();
            steps.remove(0);
        }
        base.extend(steps);
        let names = (1..=base.len()).rev().map(|n| base[..n].join("::"));
        let file = names.filter_map(|name| files.iter().find(|(f, _)| *f == name)).map(|(f, _)| f.as_str()).next();
        found.extend(file.filter(|f| !around(f)));
    }
    found
}

/// Files of `folder` that need each other in a circle.
fn circles(folder: &str) -> Vec<Vec<String>> {
    let name = |path: &str| {
        let path = path.trim_start_matches("src/").trim_end_matches(".rs").trim_end_matches("/mod");
        path.replace('/', "::")
    };
    let is_test = |path: &str| path.contains("/tests") || path.ends_with("_tests.rs");
    let files = sources(folder).into_iter().filter(|(path, _)| !is_test(path));
    let own = |code: String| code.split("#[cfg(test)] mod tests {").next().unwrap_or_default().to_owned();
    circles_of(&files.map(|(path, code)| (name(&path), own(code))).collect::<Vec<_>>())
}

/// Groups of modules that need each other, directly or through others.
fn circles_of(files: &[(String, String)]) -> Vec<Vec<String>> {
    let number = |file: &str| files.iter().position(|(f, _)| f == file).unwrap();
    let needs: Vec<Vec<usize>> =
        files.iter().map(|(file, code)| named(file, code, files).into_iter().map(number).collect()).collect();
    let reaches = |from: usize| {
        let mut seen = vec![false; files.len()];
        let mut next = needs[from].clone();
        while let Some(at) = next.pop() {
            if !std::mem::replace(&mut seen[at], true) {
                next.extend(&needs[at]);
            }
        }
        seen
    };
    let reach: Vec<Vec<bool>> = (0..files.len()).map(reaches).collect();
    let with = |a: usize| (0..files.len()).filter(|b| reach[a][*b] && reach[*b][a]).collect::<Vec<usize>>();
    let mut found: Vec<Vec<usize>> = (0..files.len()).map(with).filter(|c| c.len() > 1).collect();
    found.sort();
    found.dedup();
    found.into_iter().map(|c| c.into_iter().map(|f| files[f].0.clone()).collect()).collect()
}

#[test]
fn no_files_need_each_other_in_a_circle() {
    let code = "use super::{a::{self, B}, c}; use crate::engine::d::E; fn f() { super::g::h(); }";
    let mut found = paths(code);
    found.sort();
    found.dedup();
    assert_eq!(found, ["crate::engine::d::E", "super::", "super::a::B", "super::a::self", "super::c", "super::g::h"]);
    let file = |name: &str, code: &str| (name.to_owned(), code.to_owned());
    let files = [
        file("x", "mod a; mod b; mod c; use a::A;"),
        file("x::a", "use super::{Shared, b::B};"),
        file("x::b", "use crate::x::c;"),
        file("x::c", "fn f() { super::a::g(); }"),
        file("x::d", "use super::{a::A, Shared};"),
    ];
    assert_eq!(circles_of(&files), [["x::a", "x::b", "x::c"]]);
    for folder in ROOMS_WITHOUT_CIRCLES {
        assert_eq!(circles(folder), Vec::<Vec<String>>::new(), "{folder}");
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
