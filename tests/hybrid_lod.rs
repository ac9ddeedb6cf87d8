//! Hybrid textured LOD meshes from end to end: what is baked, what runs again when something changes, and what is said of input that cannot be.

mod support;

use serde_json::Value;
use std::{fmt::Write as _, path::Path};
use tempfile::{TempDir, tempdir};

/// A closed ball of 512 triangles with bumps, and a scene that places it at these points of the ground.
fn park(places: &[(&str, f64, f64)]) -> TempDir {
    let folder = tempdir().unwrap();
    let (rings, sides) = (16, 17);
    let mut text = String::from("o ball\n");
    for i in 0..=rings {
        for j in 0..sides {
            let (a, b) = (
                std::f64::consts::PI * f64::from(i) / f64::from(rings),
                std::f64::consts::TAU * f64::from(j) / f64::from(sides),
            );
            let (sin, cos) = (libm::sin(a), libm::cos(a));
            let r = 2.0 + 0.2 * libm::sin(5.0 * b) * sin;
            let _ = writeln!(text, "v {} {} {}", r * sin * libm::cos(b), 2.2 + r * cos, -r * sin * libm::sin(b));
        }
    }
    for i in 0..rings {
        for j in 0..sides {
            let at = |i: i32, j: i32| i * sides + j % sides + 1;
            let _ = writeln!(text, "f {} {} {} {}", at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        }
    }
    std::fs::write(folder.path().join("ball.obj"), text).unwrap();
    write(folder.path(), places);
    folder
}

fn write(folder: &Path, places: &[(&str, f64, f64)]) {
    let place = |(name, x, z): &(&str, f64, f64)| {
        format!("[[place]]\nfile = \"ball.obj\"\nname = \"{name}\"\ntranslate = [{x}, 0, {z}]\n")
    };
    std::fs::write(folder.join("park.toml"), places.iter().map(place).collect::<String>()).unwrap();
}

const PLACES: [(&str, f64, f64); 4] = [("a", 0.0, 0.0), ("b", 28.0, 60.0), ("c", 60.0, 8.0), ("d", 55.0, 55.0)];

/// A small bake with these changes: exit code, the names of the nodes that ran and how often, what was said.
fn bake(folder: &Path, arguments: &[&str]) -> (i32, Vec<String>, String) {
    bake_of(folder, "hybrid-lod", arguments)
}

/// The same of another pipeline.
fn bake_of(folder: &Path, pipeline: &str, arguments: &[&str]) -> (i32, Vec<String>, String) {
    let mut command = support::command(folder, pipeline);
    let small = ["scene=park.toml", "size=8", "resolution=128", "views=6", "path=[]", "cells.cells=[\"2,2\",\"2,3\"]"];
    for set in small {
        if !arguments.iter().any(|a| a.split('=').next() == set.split('=').next()) {
            command.args(["--set", set]);
        }
    }
    for argument in arguments {
        command.args(if argument.starts_with("--") { vec![*argument] } else { vec!["--set", argument] });
    }
    support::outcome(command, folder, pipeline)
}

/// How often a node ran.
fn count(ran: &[String], node: &str) -> usize {
    let of = |r: &String| r.strip_prefix(node)?.strip_prefix(' ')?.parse().ok();
    ran.iter().find_map(of).unwrap_or(0)
}

fn json(folder: &Path, file: &str) -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder.join("out/hybrid-lod").join(file)).unwrap()).unwrap()
}

#[test]
fn a_park_is_baked_and_certified_along_a_walk() {
    let folder = park(&PLACES);
    let fine = ["resolution=256", "tolerance=0.2"];
    let (code, ran, text) = bake(folder.path(), &fine);
    assert_eq!(code, 0, "{text}");
    // Four objects of one shape, which is simplified once.
    assert!(
        ran.contains(&"place 4".into()) && ran.contains(&"levels 1".into()) && ran.contains(&"cell 2".into()),
        "{ran:?}"
    );
    let shaders = [
        "hybrid-lod.wgsl",
        "hybrid-lod.vert",
        "hybrid-lod.frag",
        "hybrid-lod.hlsl",
        "hybrid-lod.metal",
        "hybrid-lod.spv",
    ];
    let others = ["hybrid-lod.json", "cells/2,2.glb", "cells/2,2.ktx2", "cells/2,3.glb", "pictures/worst-psnr.png"];
    for file in shaders.iter().chain(&others) {
        assert!(folder.path().join("out/hybrid-lod").join(file).is_file(), "{file}");
    }
    let manifest = json(folder.path(), "hybrid-lod.json");
    let cells = manifest["cells"].as_array().unwrap();
    assert_eq!(cells.len(), 2);
    for cell in cells {
        let (few, many) = (cell["triangles"].as_u64().unwrap(), cell["original_triangles"].as_u64().unwrap());
        assert!(few > 20 && few * 2 < many, "{few} of {many}");
        assert_eq!(cell["stand_ins"].as_array().unwrap().len() + cell["inside"].as_array().unwrap().len(), 4);
    }
    let c = json(folder.path(), "certificate.json");
    let of = |path: &str| path.split('.').fold(&c, |v, key| &v[key]).as_f64().unwrap();
    assert!(of("psnr_y_object_db.min") > 22.0 && of("missing.max") < 0.05 && of("extra.max") < 0.03, "{c}");
    assert_eq!(of("popping.count"), 1.0);
    let (code, ran, _) = bake(folder.path(), &fine);
    assert!(code == 0 && ran.is_empty(), "{ran:?}");
}

#[test]
fn a_moved_object_bakes_its_own_stand_ins_again() {
    let folder = park(&PLACES);
    let same = "classify.clusters=false";
    assert_eq!(bake(folder.path(), &[same]).0, 0);
    let mut moved = PLACES;
    moved[3].1 = 50.0;
    write(folder.path(), &moved);
    let (code, ran, text) = bake(folder.path(), &[same]);
    assert_eq!(code, 0, "{text}");
    for step in ["cameras 2", "collapse 2", "resample 2", "place 1", "cell 2"] {
        assert!(ran.contains(&step.into()), "{step}: {ran:?}");
    }
    assert!((2..=14).contains(&count(&ran, "capture")), "two cells, seven cameras at most: {ran:?}");
    assert!(!ran.iter().any(|r| r.starts_with("levels")), "{ran:?}");
    let added: Vec<_> = moved.iter().copied().chain([("e", 30.0, 8.0)]).collect();
    write(folder.path(), &added);
    let (_, ran, text) = bake(folder.path(), &[same]);
    assert!((2..=14).contains(&count(&ran, "capture")) && count(&ran, "collapse") == 2, "{ran:?} {text}");
    write(folder.path(), &moved);
    let (_, ran, text) = bake(folder.path(), &[same]);
    assert!(!ran.iter().any(|r| r.starts_with("capture") || r.starts_with("cell ")), "{ran:?} {text}");
}

#[test]
fn cells_share_what_is_seen_from_one_point() {
    let captured = |cells: &[&str]| {
        let folder = park(&PLACES);
        let bake = |cell: &&str| {
            let (code, ran, text) = bake(folder.path(), &["evaluate.path=[[24,45],[24,46]]", "classify.t_s=0", cell]);
            assert_eq!(code, 0, "{text}");
            count(&ran, "capture")
        };
        cells.iter().map(bake).collect::<Vec<_>>()
    };
    let (one, both) = ("cells.cells=[\"2,3\"]", "cells.cells=[\"2,2\",\"2,3\"]");
    let (alone, after) = (captured(&[both])[0], captured(&[one, both]));
    assert!(after[1] > 0 && after[0] + after[1] == alone, "{alone} {after:?}");
    assert!(alone < 2 * after[0], "neighbours look from the same points but for six: {alone} {after:?}");
}

#[test]
fn another_tolerance_captures_nothing_again() {
    let folder = park(&PLACES);
    assert_eq!(bake(folder.path(), &[]).0, 0);
    for set in ["tolerance=1", "collapse.t_l=2", "collapse.cost=paper"] {
        let (code, ran, text) = bake(folder.path(), &[set]);
        assert_eq!(code, 0, "{text}");
        assert!(!ran.iter().any(|r| r.starts_with("capture") || r.starts_with("levels")), "{set}: {ran:?}");
        assert!(ran.iter().any(|r| r.starts_with("collapse")), "{set}: {ran:?}");
    }
    // Another T_s changes how many views an object has: only those that it changes are captured.
    let (code, ran, text) = bake(folder.path(), &["classify.t_s=0"]);
    assert!(code == 0 && !ran.iter().any(|r| r.starts_with("levels")), "{ran:?} {text}");
}

#[test]
fn objects_in_a_cell_are_drawn_as_they_are() {
    // One in the first cell, and nothing else: a cell without stand-ins is legal.
    let folder = park(&[("only", 24.0, 27.7)]);
    let arguments = ["path=[]", "cells.area=[0,0,60,60]", "evaluate.path=[[24,26],[24,28]]", "cells.cells=[\"2,2\"]"];
    let (code, _, text) = bake(folder.path(), &arguments);
    assert_eq!(code, 0, "{text}");
    let cell = &json(folder.path(), "hybrid-lod.json")["cells"][0];
    assert_eq!((cell["inside"].as_array().unwrap().len(), cell["stand_ins"].as_array().unwrap().len()), (1, 0));
    let c = json(folder.path(), "certificate.json");
    assert_eq!(c["psnr_y_db"]["min"].as_f64(), Some(100.0), "{c}");
}

#[test]
fn objects_behind_a_wall_have_no_stand_in() {
    let folder = park(&PLACES);
    let wall = "v 44 0 -40\nv 44 30 -40\nv 44 30 100\nv 44 0 100\nf 1 2 3 4\n";
    std::fs::write(folder.path().join("wall.obj"), wall).unwrap();
    let mut text = std::fs::read_to_string(folder.path().join("park.toml")).unwrap();
    text += "[[place]]\nfile = \"wall.obj\"\nname = \"wall\"\n";
    std::fs::write(folder.path().join("park.toml"), text).unwrap();
    let arguments = ["cells.heights=[1.5,1.8]", "cells.cells=[\"2,3\",\"2,4\"]", "evaluate.path=[[22,2],[22,14]]"];
    let objects = |pipeline: &str| {
        let (code, _, text) = bake_of(folder.path(), pipeline, &arguments);
        assert_eq!(code, 0, "{text}");
        let file = |name: &str| -> Value {
            let path = folder.path().join("out").join(pipeline).join(name);
            serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
        };
        let cell = &file("hybrid-lod.json")["cells"][0];
        let stand_ins = cell["stand_ins"].as_array().unwrap().iter();
        let names: Vec<String> =
            stand_ins.flat_map(|s| s["objects"].as_array().unwrap()).map(|n| n.as_str().unwrap().into()).collect();
        (names, file("certificate.json")["missing"].clone())
    };
    let (all, missing) = objects("hybrid-lod");
    let (seen, same) = objects("hybrid-lod-culled");
    assert!(all.contains(&"c".into()) && all.contains(&"d".into()), "{all:?}");
    assert!(!seen.contains(&"c".into()) && !seen.contains(&"d".into()), "{seen:?}");
    assert!(seen.contains(&"a".into()), "{seen:?}");
    assert_eq!(missing, same);
}

#[test]
fn mistakes_are_named() {
    let folder = park(&PLACES);
    for (set, code, what) in [
        ("size=-1", 2, "size"),
        ("classify.t_s=-1", 2, "t_s"),
        ("collapse.t_l=-1", 2, "t_l"),
        ("tolerance=-1", 2, "tolerance"),
        ("cells.cells=[\"99,99\"]", 1, "`99,99` is none"),
        ("evaluate.path=[[0,0],[500,0]]", 1, "leaves the baked cells"),
        ("cell.page=100", 2, "page"),
    ] {
        let (found, _, text) = bake(folder.path(), &[set]);
        assert!(found == code && text.contains(what), "{set}: {found} {text}");
    }
    let (code, _, text) = bake(folder.path(), &["size=0.01", "cells.cells=[]"]);
    assert!(code == 1 && text.contains("`most` allows"), "{text}");
}
