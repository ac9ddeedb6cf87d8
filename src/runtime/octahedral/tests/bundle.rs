//! Bundles: written and read again, and broken in every way.

use super::*;
use crate::{
    array::Array,
    formats::{Limits, from_glb},
    runtime::{BundleFile, Opened, open, testing::Memory},
    scene::Alpha,
    texture::{Format, dds, ktx2},
};
use proptest::prelude::*;
use std::{
    path::Path,
    sync::{Arc, OnceLock},
};

fn read_all(files: &Memory) -> Result<Bundle, OctahedralError> {
    read(Path::new("b"), files, &Limits::default())
}

const BOTH: Textures = Textures { ktx2: true, dds: true };

/// With all channels.
fn small() -> &'static (Impostor, Vec<BundleFile>) {
    static SMALL: OnceLock<(Impostor, Vec<BundleFile>)> = OnceLock::new();
    SMALL.get_or_init(|| {
        let mut impostor = impostor(&cube(), Grid { side: 3, hemi: false }, 32, 16);
        let image =
            |k: u8| -> Array<[u8; 4]> { impostor.atlas.color.iter().map(|c| [c[0] ^ k, c[3], k, 255]).collect() };
        (impostor.atlas.orm, impostor.atlas.emissive) = (Some(image(7)), Some(image(90)));
        let files = write(&impostor, &Drawing { steps: 3 }, BOTH).unwrap();
        (impostor, files)
    })
}

#[test]
fn a_bundle_comes_back_as_it_was() {
    let (impostor, files) = small();
    let bundle = read_all(&Memory::of(files)).unwrap();
    assert_eq!(bundle, Bundle { impostor: impostor.clone(), drawing: Drawing { steps: 3 } });
    assert!(write(&bundle.impostor, &bundle.drawing, BOTH).unwrap() == *files);
    let mut plain = impostor.clone();
    (plain.atlas.orm, plain.atlas.emissive, plain.bounds) = (None, None, crate::math::Aabb::EMPTY);
    let files = write(&plain, &Drawing { steps: 0 }, Textures::default()).unwrap();
    assert_eq!(read_all(&Memory::of(&files)).unwrap().impostor, plain);
    assert!(files.iter().all(|f| f.path != "orm.png" && !f.path.ends_with("2") && !f.path.ends_with("dds")));
    assert!(write(&plain, &Drawing { steps: MAX_STEPS + 1 }, BOTH).is_err());
}

#[test]
fn the_manifest_says_what_there_is() {
    let (impostor, files) = small();
    let json: serde_json::Value = serde_json::from_slice(&files[0].bytes).unwrap();
    assert_eq!((&json["format"], &json["version"]), (&"farfield octahedral".into(), &1.into()));
    assert_eq!((&json["mapping"], &json["frames"], &json["tile"]), (&"octahedral".into(), &3.into(), &16.into()));
    assert_eq!((json["levels"].as_u64(), json["card"].as_array().unwrap().len()), (Some(3), impostor.card.len()));
    let there = |v: &serde_json::Value| files.iter().any(|f| f.path == v.as_str().unwrap());
    assert!(
        json["atlases"].as_object().unwrap().values().all(|a| ["png", "ktx2", "dds"].iter().all(|k| there(&a[*k])))
            && there(&json["preview"])
    );
    let shaders = json["shaders"].as_object().unwrap();
    assert_eq!(shaders.len(), 5);
    assert!(shaders.values().flat_map(|s| s.as_array().unwrap()).all(there));
    for word in ["world", "coordinates", "order", "blending", "frame", "color", "normal", "depth", "card"] {
        assert!(json["convention"][word].as_str().unwrap().len() > 10, "{word}");
    }
    // Nothing lies in the bundle that the manifest does not name.
    let text = String::from_utf8_lossy(&files[0].bytes);
    assert!(files[1..].iter().all(|f| text.contains(&format!("\"{}\"", f.path))));
}

#[test]
fn texture_files_hold_all_levels() {
    let (impostor, files) = small();
    let levels = crate::octahedral::levels(impostor);
    for (name, format, srgb) in [
        ("color-alpha", Format::Bc3, true),
        ("normal-depth", Format::Rgba8, false),
        ("orm", Format::Bc1, false),
        ("emissive", Format::Bc1, true),
    ] {
        let file = |end: &str| &files.iter().find(|f| f.path == format!("{name}.{end}")).unwrap().bytes;
        let array = ktx2::read(file("ktx2")).unwrap();
        assert_eq!((array.format, array.srgb, array.layers, array.levels.len()), (format, srgb, 1, 3));
        assert_eq!(dds::read(file("dds")).unwrap(), array);
        if name == "normal-depth" {
            for (l, level) in (0..).zip(&levels) {
                assert_eq!(array.decode(l, 0).unwrap().texels, level.normal.to_vec());
            }
        }
    }
}

#[test]
fn the_preview_opens_as_an_ordinary_model() {
    let (impostor, files) = small();
    let glb = files.iter().find(|f| f.path == "octahedral.glb").unwrap();
    let scene = from_glb(Path::new("octahedral.glb"), Arc::new(glb.bytes.clone()), &Limits::default()).unwrap();
    let part = &scene.objects[0].parts[0];
    assert_eq!(part.mesh.triangles.len(), 12);
    assert!(part.material.unlit && part.material.alpha == Alpha::Mask { cutoff: 0.5 });
    let image = &part.material.base_color_texture.as_ref().unwrap().image;
    assert_eq!((image.width, image.height), (16, 96));
    // From the front the cube is seen where it is.
    let view = towards(&cube(), DVec3::Z, 64, 6.0);
    let depth = |scene: &Scene| {
        let geometry = crate::raster::Geometry::new(scene);
        crate::raster::nearest(&Cpu, &geometry, &view, &Default::default(), &Default::default()).unwrap().depth
    };
    // Cards lie in the middle, so the front is drawn a little smaller than it is.
    let covered = depth(&cube()).iter().filter(|z| z.is_finite()).count();
    let differs = depth(&cube()).iter().zip(depth(&scene)).filter(|(a, b)| a.is_finite() != b.is_finite()).count();
    assert!(covered > 1000 && differs * 3 < covered, "{differs} of {covered}");
    assert!((scene.bounds().centre() - impostor.centre).length() < 1e-5);
}

#[test]
fn bundles_are_opened_by_their_format() {
    let (_, files) = small();
    let opened = open(Path::new("b/octahedral.json"), &Memory::of(files), &Limits::default()).unwrap();
    let Opened::Octahedral(stand_in) = &opened else { panic!("another format") };
    assert_eq!(stand_in.model().drawing().steps, 3);
    let modes = opened.modes();
    assert!(modes.len() == 1 && !modes[0].1.bounds().is_empty());
}

#[test]
fn broken_bundles_are_refused() {
    let (_, files) = small();
    let good = Memory::of(files);
    let json = String::from_utf8(files[0].bytes.clone()).unwrap();
    for (from, to, expect) in [
        ("farfield octahedral", "farfield other", "expected `farfield octahedral`"),
        ("\"version\": 1", "\"version\": 2", "version 2; expected 1"),
        ("\"octahedral\",", "\"cubic\",", "mapping `cubic`"),
        ("\"tile\": 16", "\"tile\": 17", "expected 51²"),
        ("\"frames\": 3", "\"frames\": 4000000000", "an atlas of "),
        ("\"steps\": 3", "\"steps\": 65", "65 steps"),
        ("\"steps\": 3", "\"stops\": 3", "unknown field `stops`"),
        ("\"color-alpha.png\"", "\"../color-alpha.png\"", "expected a path inside the bundle"),
        ("\"color-alpha.png\"", "\"none.png\"", "none.png"),
        ("\"radius\": ", "\"radius\": -", "a radius of -"),
    ] {
        assert!(json.contains(from), "{from}");
        let mut broken = good.clone();
        broken.0.insert("b/octahedral.json".into(), json.replacen(from, to, 1).into_bytes());
        let message = read_all(&broken).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.contains(expect), "{message}; expected {expect}");
    }
    for name in ["octahedral.json", "color-alpha.png", "normal-depth.png", "orm.png", "emissive.png"] {
        let mut broken = good.clone();
        broken.0.remove(&Path::new("b").join(name));
        assert!(read_all(&broken).is_err_and(|e| e.to_string().contains(name)), "{name}");
    }
}

proptest! {
    #[test]
    fn damage_gives_an_error_or_a_picture(
        file in prop::sample::select(vec![0_usize, 1, 4, 7, 10]),
        cut in prop::option::of(0.0..1.0_f64),
        changes in prop::collection::vec((0.0..1.0_f64, any::<u8>()), 0..4),
    ) {
        let (_, files) = small();
        let mut files = files.clone();
        let bytes = &mut files[file].bytes;
        if let Some(cut) = cut {
            bytes.truncate((cut * bytes.len() as f64) as usize);
        }
        for (at, value) in &changes {
            let i = (at * bytes.len() as f64) as usize;
            if let Some(byte) = bytes.get_mut(i) {
                *byte = *value;
            }
        }
        if let Ok(bundle) = read_all(&Memory::of(&files)) {
            let model = Model::new(bundle.impostor, bundle.drawing).unwrap();
            let view = towards(&cube(), DVec3::ONE, 8, 4.0);
            let shot = OctahedralStandIn::new(model);
            prop_assert_eq!(draw(&shot, &view, &Rendering::default().with_samples(1)).depth.len(), 64);
        }
    }
}
