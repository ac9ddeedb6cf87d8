//! `farfield compare` as a user runs it: what it prints, its exit codes, what it writes.

use std::{
    path::Path,
    process::{Command, Output},
};

struct Ran {
    code: i32,
    out: String,
    err: String,
}

fn compare(folder: &Path, args: &[&str]) -> Ran {
    let mut command = Command::new(env!("CARGO_BIN_EXE_farfield"));
    command.current_dir(folder).arg("compare").args(args).env_remove("NO_COLOR");
    let Output { status, stdout, stderr } = command.output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    Ran { code: status.code().unwrap(), out: text(stdout), err: text(stderr) }
}

const SMALL: [&str; 4] = ["--cell=0,0,12,1,1,1", "--views=8", "--resolution=48", "--samples=1"];

fn with<'a>(more: &[&'a str]) -> Vec<&'a str> {
    more.iter().copied().chain(SMALL).collect()
}

#[test]
fn the_result_is_printed_for_people_and_as_json_on_demand() {
    let folder = tempfile::tempdir().unwrap();
    let same = compare(folder.path(), &with(&["builtin:solids", "builtin:solids"]));
    assert_eq!(same.code, 0, "{}", same.err);
    assert!(same.out.starts_with("verdict: indistinguishable. "), "{}", same.out);
    for words in
        ["\n  triangles ", "\n  likeness 100.0 dB", "\n  heavier than the original", "\n  outlines moved by 0 px"]
    {
        assert!(same.out.contains(words), "{words}: {}", same.out);
    }

    let other = compare(folder.path(), &with(&["builtin:solids", "builtin:car", "--out", "there"]));
    assert!(other.code == 0 && other.out.starts_with("verdict: failed. "), "{}{}", other.out, other.err);
    assert!(other.out.contains("\n  missing: ") && other.out.contains("wrote there"), "{}", other.out);
    assert!(folder.path().join("there/pictures/worst-missing.png").is_file());
    let json = compare(folder.path(), &with(&["builtin:solids", "builtin:car", "--json"]));
    assert_eq!(json.out.as_bytes(), std::fs::read(folder.path().join("there/certificate.json")).unwrap());
}

#[test]
fn wrong_arguments_exit_with_2_and_say_what_was_expected() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    for (args, expect) in [
        (with(&["absent.glb", "builtin:car"]), "absent.glb: there is no such file"),
        (with(&["builtin:car", "sub"]), "sub: is a folder, expected a regular file"),
        (with(&["builtin:car", "builtin:car", "--ceiling", "absent.ply"]), "absent.ply"),
        (with(&["builtin:cra", "builtin:car"]), "there is no built-in scene `cra`"),
        (vec!["builtin:car", "builtin:car", "--cell=1,2,3"], "expected six numbers"),
        (vec!["builtin:car", "builtin:car", "--cell=0,0,9,1,1,0"], "side lengths > 0"),
        (with(&["builtin:car", "builtin:car", "--bound=0"]), "the bound is 0 px"),
        (with(&["builtin:car", "builtin:car", "--fov=200"]), "between 0.1"),
    ] {
        let ran = compare(folder.path(), &args);
        assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{args:?}: {}", ran.err);
        assert!(ran.err.contains(expect), "{args:?}: {}", ran.err);
    }
    std::fs::write(folder.path().join("broken.glb"), b"glTF, but no more").unwrap();
    assert_eq!(compare(folder.path(), &with(&["broken.glb", "builtin:car"])).code, 1);
}
