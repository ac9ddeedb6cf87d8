//! Bundles: written and read again, and broken in every way.

use super::*;
use crate::{
    formats::{Limits, from_glb},
    runtime::{BundleFile, testing::Memory},
    scene::Image,
};
use glam::DVec3;
use proptest::prelude::*;
use std::{
    path::Path,
    sync::{Arc, OnceLock},
};

fn open(files: &Memory) -> Result<Bundle, DmeshError> {
    read(Path::new("b"), files, &Limits::default())
}

fn small() -> &'static (Dmesh, Vec<BundleFile>) {
    static SMALL: OnceLock<(Dmesh, Vec<BundleFile>)> = OnceLock::new();
    SMALL.get_or_init(|| {
        let mut dmesh = captured(&solids(), 33);
        dmesh.references.truncate(3);
        dmesh.references[1].normal_map = None;
        dmesh.references[2].mesh = Default::default();
        let blending = Blending { weights: Weights::Angular, quality: false, offset: Some(0.125) };
        let files = write(&dmesh, &blending, &[4, 5, 0], None).unwrap();
        (dmesh, files)
    })
}

#[test]
fn a_bundle_comes_back_as_it_was() {
    let (dmesh, files) = small();
    let bundle = open(&Memory::of(files)).unwrap();
    assert_eq!(bundle.blending, Blending { weights: Weights::Angular, quality: false, offset: Some(0.125) });
    let view = towards(&solids(), DVec3::new(1.0, 0.4, 0.6), 60);
    let how = Rendering { shading: crate::raster::Shading::Lit(Default::default()), ..Rendering::default() };
    let (a, b) = (draw(dmesh, &view, &how), draw(&bundle.dmesh, &view, &how));
    assert!(a.depth.iter().any(|z| z.is_finite()));
    assert_eq!(a, b);
    // What was read is written as the same bytes.
    let again = write(&bundle.dmesh, &bundle.blending, &[4, 5, 0], None).unwrap();
    assert_eq!(again.len(), files.len());
    for (a, b) in again.iter().zip(files) {
        assert!(a == b, "{} and {} differ", a.path, b.path);
    }
    for (a, b) in dmesh.references.iter().zip(&bundle.dmesh.references) {
        assert_eq!((&a.name, &a.view, a.mesh.triangles.len()), (&b.name, &b.view, b.mesh.triangles.len()));
    }
}

#[test]
fn the_manifest_says_what_there_is() {
    let (dmesh, files) = small();
    let text = manifest(dmesh, &Blending::default(), &[], None).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!((&json["format"], &json["version"]), (&"farfield dmesh".into(), &1.into()));
    assert_eq!(json["references"][0]["strips"], serde_json::Value::Null);
    assert_eq!(json["blending"]["weights"], "positional");
    let there = |path: &str| files.iter().any(|f| f.path == path);
    let named = |v: &serde_json::Value| v.as_str().is_none_or(there);
    assert!(there(json["all"].as_str().unwrap()));
    let rows = json["references"].as_array().unwrap();
    assert!(rows.iter().all(|r| named(&r["glb"]) && named(&r["normals"])));
    let shaders = json["shaders"].as_object().unwrap();
    assert_eq!(shaders.len(), 5);
    assert!(shaders.values().flat_map(|s| s.as_array().unwrap()).all(named));
    assert!(manifest(dmesh, &Blending::default(), &[1], None).is_err());
}

/// Viewers know positions, normals, coordinates and textures; the quality must not tint the colour.
#[test]
fn glbs_open_as_ordinary_unlit_models() {
    let (dmesh, files) = small();
    let file = |name: &str| files.iter().find(|f| f.path == name).unwrap();
    for (name, objects) in [("references/+x.glb", 1), ("dmesh.glb", 2)] {
        let scene = from_glb(Path::new(name), Arc::new(file(name).bytes.clone()), &Limits::default()).unwrap();
        assert_eq!(scene.objects.len(), objects);
        for part in scene.objects.iter().flat_map(|o| &o.parts) {
            assert!(part.material.unlit && part.mesh.colors.is_empty() && !part.mesh.normals.is_empty());
            let picture = &part.material.base_color_texture.as_ref().unwrap().image;
            assert!(dmesh.references.iter().any(|r| r.color.texels == picture.texels));
        }
    }
    let text = String::from_utf8_lossy(&file("references/+x.glb").bytes).into_owned();
    assert!(text.contains("\"_QUALITY\"") && !text.contains("COLOR_0"));
}

#[test]
fn broken_bundles_are_refused() {
    let (_, files) = small();
    let good = Memory::of(files);
    let json = String::from_utf8(files[0].bytes.clone()).unwrap();
    let with = |text: String| {
        let mut broken = good.clone();
        broken.0.insert("b/dmesh.json".into(), text.into_bytes());
        open(&broken).err().map(|e| e.to_string()).unwrap_or_default()
    };
    let first = json.find("\"triangles\": ").unwrap();
    for (from, to, expect) in [
        ("farfield dmesh", "something", "expected `farfield dmesh`"),
        ("\"version\": 1", "\"version\": 2", "expected 1"),
        ("\"epsilon\"", "\"epsilom\"", "epsilom"),
        ("references/+x.glb", "../+x.glb", "inside the bundle"),
        ("references/+x.glb", "/etc/passwd", "inside the bundle"),
        ("references/+x.glb", "references/no.glb", "no such file"),
        ("references/+x-normals.png", "dmesh.json", "neither PNG"),
        ("\"perspective\"", "\"fisheye\"", "fisheye"),
        ("\"angular\"", "\"some\"", "`some`"),
        ("\"offset\": 0.125", "\"offset\": -1.0", "offset -1"),
        ("\"width\": 33", "\"width\": 0", "pixels"),
        ("\"name\": \"+x\"", "\"name\": \"a/b\"", "letters"),
        (&json[first..first + 16], "\"triangles\": 1, \"x\": ", "x"),
    ] {
        assert!(json.contains(from), "{from}");
        let error = with(json.replacen(from, to, 1));
        assert!(error.contains(expect), "{from}: {error}");
    }
    let mut none = good.clone();
    none.0.remove(Path::new("b/dmesh.json"));
    assert!(open(&none).is_err());
    let mut plain = good.clone();
    let scene = solids();
    let bytes = crate::formats::write_glb(&scene, &Default::default()).unwrap();
    plain.0.insert("b/references/+x.glb".into(), bytes);
    assert!(open(&plain).unwrap_err().to_string().contains("3 meshes"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Bytes changed anywhere give an error or something that can be drawn.
    #[test]
    fn any_bytes_give_an_error_or_a_dmesh(which in 0..3usize, changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..9), cut in any::<Option<prop::sample::Index>>()) {
        let (_, files) = small();
        let mut broken = Memory::of(files);
        let name = ["b/dmesh.json", "b/references/+x.glb", "b/references/+x-normals.png"][which];
        let bytes = broken.0.get_mut(Path::new(name)).unwrap();
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        if let Ok(bundle) = open(&broken) {
            draw(&bundle.dmesh, &towards(&solids(), DVec3::ONE, 8), &one_sample());
        }
    }
}

/// Vertices that nothing uses are not written.
#[test]
fn only_used_vertices_are_written() {
    let mut reference = square("a", DVec3::Z * 3.0, DVec3::ZERO, [9; 3], 0.5);
    let mut mesh = (*reference.mesh).clone();
    mesh.triangles = vec![[1, 2, 3]].into();
    reference.mesh = Arc::new(mesh);
    let dmesh = Dmesh { references: vec![reference], epsilon: 0.0, diagonal: 1.0, double_sided: true };
    let files = write(&dmesh, &Blending::default(), &[], None).unwrap();
    let read = open(&Memory::of(&files)).unwrap().dmesh;
    assert!(read.double_sided);
    let (a, b) = (&dmesh.references[0].mesh, &read.references[0].mesh);
    assert_eq!(b.triangles[..], [[0, 1, 2]]);
    assert_eq!(b.positions[..], a.positions[1..]);
    assert_eq!(b.uv[..], a.uv[1..]);
    assert_eq!(b.quality[..], [0.5; 3]);
    let Image { texels, .. } = &*read.references[0].color;
    assert_eq!(texels[..], dmesh.references[0].color.texels[..]);
}
