//! Scene TOML.

use super::*;
use glam::{DVec3, Vec3};

const PLY: &[u8] = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z
element face 1\nproperty list int int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

fn files(scene: &str) -> Memory {
    Memory::of([("s/a.toml", scene.as_bytes()), ("s/sub/t.ply", PLY), ("t.ply", PLY)])
}

#[test]
fn places_share_their_meshes_and_stand_where_they_should() {
    let scene = files(
        "[[place]]\nfile = 'sub/t.ply'\nname = 'x'\ntranslate = [5.0, 0, 0]\nrotate_deg = [90.0, 0.0, 90.0]\nscale = [2, 4.0, 1]
[[place]]\nfile = 'sub/../sub/t.ply'\nquaternion = [0.0, 0.0, 2.0, 0.0]\nscale = 3\n",
    )
    .scene("s/a.toml");
    let [t, x] = &scene.objects[..] else { panic!() };
    assert_eq!((t.name.as_str(), x.name.as_str()), ("t", "x"));
    assert!(Arc::ptr_eq(&t.parts[0].mesh, &x.parts[0].mesh));
    let at = |o: &Object, p: Vec3| o.transform.transform_point3(p);
    // (1, 0, 0) → scaled (2, 0, 0) → about X unchanged → about Z (0, 2, 0).
    assert!(at(x, Vec3::X).abs_diff_eq(glam::vec3(5.0, 2.0, 0.0), 1e-6));
    // (0, 1, 0) → (0, 4, 0) → about X (0, 0, 4) → about Z unchanged.
    assert!(at(x, Vec3::Y).abs_diff_eq(glam::vec3(5.0, 0.0, 4.0), 1e-6));
    assert!(at(t, Vec3::X).abs_diff_eq(glam::vec3(-3.0, 0.0, 0.0), 1e-6));
}

#[test]
fn scene_files_nest_and_equal_names_differ_by_content() {
    let inner = "[[place]]\nfile='../s/sub/t.ply'\n[[place]]\nfile='../s/sub/t.ply'\ntranslate=[1.0,0.0,0.0]\n";
    let mut files = files("[[place]]\nfile='b.toml'\nname='one'\n[[place]]\nfile='b.toml'\nname='two'\nscale=2");
    files.0.insert("s/b.toml".into(), inner.into());
    let scene = files.scene("s/a.toml");
    assert_eq!(scene.objects.len(), 4);
    for (o, prefix) in scene.objects.iter().zip(["one/t#", "one/t#", "two/t#", "two/t#"]) {
        assert!(o.name.starts_with(prefix), "{}", o.name);
    }
    // Moving one of two namesakes leaves the other's name alone.
    files.0.insert("s/b.toml".into(), inner.replace("[1.0", "[9.0").into());
    let moved = files.scene("s/a.toml");
    let names = |s: &Scene| s.objects.iter().map(|o| o.name.clone()).collect::<Vec<_>>();
    let (old, new) = (names(&scene), names(&moved));
    assert_eq!(old.iter().filter(|n| new.contains(n)).count(), 2);
    assert_eq!(scene.bounds().max, DVec3::new(4.0, 2.0, 0.0));
}

#[test]
fn errors_name_line_and_column() {
    let error = |text: &str| files(text).error("s/a.toml");
    assert_eq!(error("[[place]]\nfile = 'no.ply'"), "s/a.toml: line 2, column 8: s/no.ply: no such file");
    assert_eq!(
        error("[[place]]\nfile = '../t.ply'"),
        "s/a.toml: `../t.ply` lies outside the scene's folder s; `--allow-outside` permits it"
    );
    assert_eq!(error("[[place]]\nfile = 't.xyz'"), "s/a.toml: line 2, column 8: s/t.xyz: no such file");
    assert!(
        error("[[place]]\nfile = 't.ply'\nrotate = 1")
            .starts_with("s/a.toml: line 3, column 1: unknown field `rotate`")
    );
    assert!(error("[[place]]\nname = 't.ply'").contains("missing field `file`"));
    assert!(error("[[place]]\nfile='sub/t.ply'\nscale = 0").starts_with("s/a.toml: line 3, column 9: a scale is"));
    assert!(error("[[place]]\nfile='sub/t.ply'\ntranslate = [nan, 0, 0]").contains("NaN is not finite"));
    assert_eq!(error("[[place]]\nfile='a.toml'"), "s/a.toml: scene file: includes itself");
}

#[test]
fn outside_is_allowed_where_it_is_said() {
    let files = files("[[place]]\nfile = '../t.ply'");
    let limits = Limits { allow_outside: true, ..small() };
    let scene = crate::formats::load(Path::new("s/a.toml"), &files, &limits).unwrap();
    assert_eq!(scene.triangle_count(), 1);
}

#[test]
fn a_scene_that_multiplies_without_end_hits_a_limit() {
    let mut files = files("");
    for i in 0..12 {
        let next = if i == 11 { "sub/t.ply".to_owned() } else { format!("{}.toml", i + 1) };
        let text = (0..10).map(|k| format!("[[place]]\nfile='{next}'\nname='{k}'\n")).collect::<String>();
        files.0.insert(format!("s/{i}.toml"), text.into());
    }
    assert!(files.error("s/0.toml").ends_with("1025 objects; the limit is 1024"));
}

/// The fenced blocks of docs/scene.md that begin with `fence`.
fn examples(fence: &str) -> Vec<&'static str> {
    let text = include_str!("../../../docs/scene.md");
    text.split("```").skip(1).step_by(2).filter_map(|block| block.strip_prefix(fence)).collect()
}

#[test]
fn the_examples_of_the_documentation_load() {
    use crate::formats::{GlbOptions, write_glb};
    let glb = write_glb(&everything(), &GlbOptions::default()).unwrap();
    let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let examples = examples("toml\n");
    assert!(examples.len() >= 2);
    for text in examples {
        let block = b"[[place]]\nfile = 'house.glb'\n";
        let files = [("a.toml", text.as_bytes()), ("house.glb", &glb), ("trees/oak.obj", obj), ("block.toml", block)];
        let scene = Memory::of(files).scene("a.toml");
        assert!(scene.objects.len() >= 2, "{text}");
    }
}

#[test]
fn every_key_is_documented() {
    let text = include_str!("../../../docs/scene.md");
    let error = files("[[place]]\nnonsense = 1").error("s/a.toml");
    let keys: Vec<_> = error.split('`').skip(3).step_by(2).collect();
    assert!(keys.len() >= 6, "{error}");
    for key in keys {
        assert!(text.contains(&format!("| `{key}` |")), "{key} is not in docs/scene.md");
    }
}

#[cfg(unix)]
#[test]
fn links_that_lead_out_of_the_folder_are_refused_like_dots() {
    use crate::formats::{DiskFiles, load};
    use std::os::unix::fs::symlink;
    let all = tempfile::tempdir().unwrap();
    let (scene, other) = (all.path().join("scene"), all.path().join("other"));
    std::fs::create_dir(&scene).unwrap();
    std::fs::create_dir(&other).unwrap();
    std::fs::write(other.join("t.ply"), PLY).unwrap();
    std::fs::write(scene.join("own.ply"), PLY).unwrap();
    symlink(other.join("t.ply"), scene.join("file.ply")).unwrap();
    symlink(&other, scene.join("folder")).unwrap();
    symlink(scene.join("own.ply"), scene.join("inside.ply")).unwrap();
    let root = scene.join("a.toml");
    let strict = small();
    let free = Limits { allow_outside: true, ..small() };
    for name in ["file.ply", "folder/t.ply", "../other/t.ply"] {
        std::fs::write(&root, format!("[[place]]\nfile = '{name}'\n")).unwrap();
        let error = load(&root, &DiskFiles, &strict).unwrap_err().to_string();
        assert!(error.contains("outside the scene's folder") && error.contains("`--allow-outside`"), "{error}");
        let to = other.join("t.ply").canonicalize().unwrap().display().to_string();
        assert!(name.starts_with("..") || error.contains(name) && error.contains(&to), "{error}");
        assert_eq!(load(&root, &DiskFiles, &free).unwrap().triangle_count(), 1);
    }
    std::fs::write(&root, "[[place]]\nfile = 'inside.ply'\n").unwrap();
    assert_eq!(load(&root, &DiskFiles, &strict).unwrap().triangle_count(), 1);
    // The scene itself may be a link, and so may the folder that it lies in.
    symlink(&scene, all.path().join("link")).unwrap();
    let linked = all.path().join("link/a.toml");
    assert_eq!(load(&linked, &DiskFiles, &strict).unwrap().triangle_count(), 1);
    symlink(other.join("t.ply"), scene.join("root.ply")).unwrap();
    assert_eq!(load(&scene.join("root.ply"), &DiskFiles, &strict).unwrap().triangle_count(), 1);
    // A folder is no file.
    std::fs::write(&root, "[[place]]\nfile = 'x.ply'\n").unwrap();
    std::fs::create_dir(scene.join("x.ply")).unwrap();
    let error = load(&root, &DiskFiles, &strict).unwrap_err().to_string();
    assert!(error.ends_with("is a folder, expected a regular file"), "{error}");
}
