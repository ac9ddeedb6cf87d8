//! What the program reads: warnings, kinds of files, places far from the origin.

use std::{path::Path, process::Command};
use tempfile::tempdir;

/// Exit code and standard error of a run in `folder`.
fn farfield(folder: &Path, args: &[&str]) -> (i32, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_farfield"));
    let ran = command.current_dir(folder).args(args).env_remove("FARFIELD_CACHE").output().unwrap();
    (ran.status.code().unwrap(), String::from_utf8(ran.stderr).unwrap())
}

#[test]
fn warnings_of_loading_are_shown_by_every_command() {
    let folder = tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let obj = "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    write("a.obj", obj);
    write("lines.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n");
    write(
        "lines.toml",
        "[nodes.load]\nkind = \"load-scene\"\npath = \"lines.obj\"\n[nodes.write]\nkind = \"write\"\nmethod = \"glb\"\nscene = \"load\"\n[files]\n\"./\" = \"write\"\n",
    );
    let cell = "--cell=0,0,4,0.4,0.4,0.4";
    let compare = |a: &str, b: &str| {
        farfield(folder.path(), &["compare", a, b, cell, "--views", "8", "--resolution", "16", "--backend", "cpu"])
    };
    let (code, err) = compare("a.obj", "a.obj");
    assert_eq!((code, err.matches("warning: a.obj: line 1: the material library `none.mtl`").count()), (0, 2), "{err}");
    let (code, err) = farfield(folder.path(), &["bake", "lines.toml"]);
    assert_eq!(code, 1, "{err}");
    assert!(err.contains("the scene has no triangles"), "{err}");
    assert!(err.contains("1 points, lines and curves are left out"), "{err}");
}

#[cfg(unix)]
#[test]
fn only_regular_files_are_read() {
    let folder = tempdir().unwrap();
    let made = Command::new("mkfifo").arg(folder.path().join("pipe.obj")).status();
    assert!(made.unwrap().success());
    std::fs::create_dir(folder.path().join("folder.obj")).unwrap();
    for (name, what) in [("pipe.obj", "FIFO"), ("folder.obj", "folder")] {
        let text = format!("[nodes.load]\nkind = \"load-scene\"\npath = \"{name}\"\n");
        std::fs::write(folder.path().join("p.toml"), text).unwrap();
        let expect = format!("is a {what}, expected a");
        for args in [&["bake", "p.toml"][..], &["compare", name, "builtin:solids", "--cell=0,0,4,1,1,1"]] {
            let (code, err) = farfield(folder.path(), args);
            assert!(code != 0 && err.contains(&expect), "{err}");
        }
    }
}

#[test]
fn a_scan_far_from_the_origin_bakes_to_the_same_shape() {
    use farfield::formats::{DiskFiles, Limits, load};
    let folder = tempdir().unwrap();
    let stand_in = |name: &str, at: [f64; 3]| {
        // A sheet of a metre with hills of millimetres.
        let mut obj = String::new();
        for k in 0..81 {
            let (i, j) = (k % 9, k / 9);
            let height = f64::from(i * j % 5) / 512.0;
            let [x, y, z] = [at[0] + f64::from(i) / 8.0, at[1] + f64::from(j) / 8.0, at[2] + height];
            obj += &format!("v {x} {y} {z}\n");
        }
        for k in (0..80).filter(|k| k % 9 < 8 && k / 9 < 8) {
            obj += &format!("f {} {} {} {}\n", k + 1, k + 2, k + 11, k + 10);
        }
        std::fs::write(folder.path().join(format!("{name}.obj")), obj).unwrap();
        let node = |name: &str, kind: &str, rest: &str| format!("[nodes.{name}]\nkind = \"{kind}\"\n{rest}\n");
        let pipeline = [
            node("load", "load-scene", &format!("path = \"{name}.obj\"")),
            node("cell", "view-cell", "scene = \"load\""),
            node("slices", "render-slices", "scene = \"load\"\ncell = \"cell\"\nresolution = 64"),
            node("mesh", "voxel-mesh", "slices = \"slices.slices\"\nfields = \"slices.fields\""),
            node("resample", "resample", "method = \"voxels\"\nmesh = \"mesh\"\nslices = \"slices.slices\""),
            node("atlas", "pack-atlas", "meshes = \"resample\""),
            node("write", "write", "method = \"glb\"\nname = \"a\"\nscene = \"atlas.scene\""),
            "[files]\n\"./\" = \"write.bundle\"\n".to_owned(),
        ];
        std::fs::write(folder.path().join(format!("{name}.toml")), pipeline.concat()).unwrap();
        let (code, err) = farfield(folder.path(), &["bake", &format!("{name}.toml"), "--backend", "cpu"]);
        assert_eq!(code, 0, "{err}");
        let path = folder.path().join(format!("out/{name}/a.glb"));
        load(&path, &DiskFiles, &Limits::default()).unwrap()
    };
    let far = glam::DVec3::new(524_288.0, 5_242_880.0, 512.0);
    let (a, b) = (stand_in("near", [0.0; 3]), stand_in("far", far.to_array()));
    assert_eq!(a.triangle_count(), b.triangle_count());
    let world = |scene: &farfield::scene::Scene| -> Vec<glam::DVec3> {
        let points = scene.objects.iter().flat_map(|o| {
            let to_world = o.transform.as_dmat4();
            let positions = o.parts.iter().flat_map(|p| p.mesh.positions.iter());
            positions.map(move |p| to_world.transform_point3(glam::Vec3::from(*p).as_dvec3())).collect::<Vec<_>>()
        });
        points.collect()
    };
    for (p, q) in world(&a).into_iter().zip(world(&b)) {
        assert!((q - far - p).abs().max_element() < 1e-5, "{p} {q}");
    }
}
