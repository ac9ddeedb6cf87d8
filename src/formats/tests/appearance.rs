//! glTF materials as viewers show them, and what is said of those that do not come out as expected.

use super::{document::Document, *};
use serde_json::{Value, json};

fn loaded(material: Value, image: &[[u8; 4]]) -> (Material, Vec<String>) {
    let mut d = Document::triangle();
    let picture = image::RgbaImage::from_raw(image.len() as u32, 1, image.concat()).unwrap();
    let mut png = std::io::Cursor::new(Vec::new());
    image::DynamicImage::from(picture).write_to(&mut png, image::ImageFormat::Png).unwrap();
    let view = d.view(&png.into_inner());
    d.push("images", json!({ "bufferView": view }));
    d.push("textures", json!({ "source": 0 }));
    d.push("materials", material);
    d.primitive()["material"] = json!(0);
    let (scene, warnings) = d.load();
    ((*scene.unwrap().objects[0].parts[0].material).clone(), warnings)
}

const RED: [[u8; 4]; 1] = [[200, 0, 0, 255]];

#[test]
fn emissive_on_black_is_shown() {
    for pbr in
        [json!({ "baseColorFactor": [0, 0, 0, 1] }), json!({ "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0 })]
    {
        let row =
            json!({ "pbrMetallicRoughness": pbr, "emissiveTexture": { "index": 0 }, "emissiveFactor": [1, 1, 0.5] });
        let (m, warnings) = loaded(row, &RED);
        assert!(m.unlit && m.emissive == [0.0; 3] && m.emissive_texture.is_none() && warnings.is_empty());
        assert_eq!(m.base_color, [1.0, 1.0, 0.5, 1.0]);
        assert_eq!(m.base_color_texture.unwrap().image.texels[0], RED[0]);
    }
    // A lamp that has a colour of its own stays what it is.
    let (m, _) = loaded(json!({ "emissiveTexture": { "index": 0 }, "emissiveFactor": [1, 1, 1] }), &RED);
    assert!(!m.unlit && m.emissive == [1.0; 3] && m.base_color == [1.0; 4]);
}

#[test]
fn diffuse_colours_of_specular_glossiness_are_base_colours() {
    let sg = json!({ "diffuseFactor": [0.5, 1, 1, 1], "diffuseTexture": { "index": 0 }, "glossinessFactor": 0.25 });
    let row = json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": sg } });
    let (m, warnings) = loaded(row, &RED);
    assert_eq!((m.base_color, m.metallic, m.roughness), ([0.5, 1.0, 1.0, 1.0], 0.0, 0.75));
    assert_eq!(m.base_color_texture.unwrap().image.texels[0], RED[0]);
    assert_eq!(warnings, [""; 0]);
}

#[test]
fn sides_are_the_files() {
    assert!(!loaded(json!({}), &RED).0.double_sided);
    assert!(loaded(json!({ "doubleSided": true }), &RED).0.double_sided);
    let plain = Document::triangle().scene();
    assert!(!plain.objects[0].parts[0].material.double_sided, "glTF's default material has one side");
    assert!(plain.with_both_sides().objects[0].parts[0].material.double_sided);
    let obj = Memory::of([("a.obj", &b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"[..])]).scene("a.obj");
    assert!(obj.objects[0].parts[0].material.double_sided);
}

#[test]
fn what_does_not_come_out_as_expected_is_said_once() {
    let half = [[9u8, 9, 9, 255], [9, 9, 9, 100]];
    let textured = json!({ "baseColorTexture": { "index": 0 } });
    let alpha = |a: f32| json!({ "baseColorFactor": [1, 1, 1, a] });
    for (row, image, expect) in [
        (
            json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": alpha(0.3) }),
            &RED[..],
            "is invisible: BLEND is drawn as",
        ),
        (
            json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": alpha(0.6) }),
            &RED,
            "is BLEND and drawn as a mask at 0.5",
        ),
        (
            json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": textured }),
            &half,
            "is BLEND and drawn as a mask at 0.5",
        ),
        (json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": textured }), &RED, ""),
        (
            json!({ "alphaMode": "MASK", "pbrMetallicRoughness": alpha(0.4) }),
            &RED,
            "is invisible: its alpha lies below",
        ),
        (
            json!({ "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1] } }),
            &RED,
            "is black: its base colour factor is 0",
        ),
        (json!({ "pbrMetallicRoughness": textured }), &[[0, 0, 0, 255]], "is black: its base colour texture is"),
        (
            json!({ "extensions": { "KHR_materials_transmission": { "transmissionFactor": 0.9 } } }),
            &RED,
            "lets light through",
        ),
    ] {
        let mut row = row;
        row["name"] = json!("glass");
        let (_, warnings) = loaded(row.clone(), image);
        let expect = if expect.is_empty() { vec![] } else { vec![format!("a.glb: materials[0] `glass`: {expect}")] };
        let fits = warnings.len() == expect.len() && warnings.iter().zip(&expect).all(|(w, e)| w.starts_with(e));
        assert!(fits, "{row}: {warnings:?}");
    }
}

#[test]
fn equal_warnings_are_counted() {
    let mut d = Document::triangle();
    let primitive = d.primitive().clone();
    for i in 0..12 {
        let black = json!({ "name": format!("m{i}"), "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1] } });
        d.push("materials", black);
        let mut p = primitive.clone();
        p["material"] = json!(i);
        d.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(p);
    }
    let (_, warnings) = d.load();
    assert_eq!(warnings, ["a.glb: materials[0] `m0`: is black: its base colour factor is 0; 11 more like it"]);
}

#[test]
fn images_obey_the_limit_of_bytes() {
    let mut d = Document::triangle();
    for side in [64u32, 32, 16] {
        let picture = image::RgbImage::from_fn(side, side, |x, y| image::Rgb([x as u8, y as u8, side as u8]));
        let mut png = std::io::Cursor::new(Vec::new());
        image::DynamicImage::from(picture).write_to(&mut png, image::ImageFormat::Png).unwrap();
        let view = d.view(&png.into_inner());
        let i = d.push("images", json!({ "bufferView": view }));
        d.push("textures", json!({ "source": i }));
        d.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": i } } }));
        let mut p = d.primitive().clone();
        p["material"] = json!(i);
        d.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(p);
    }
    let load = |bytes: u64| {
        let files = Memory::of([("a.glb", &d.glb()[..])]);
        let limits = Limits { bytes, ..small() };
        load_with(Path::new("a.glb"), &files, &limits, &Stop::default(), &mut |_| {})
    };
    // 4,096 texels of RGB take 7 bytes each while they are decoded.
    let error = load(20_000).unwrap_err().to_string();
    assert_eq!(error, "a.glb: images[0], 64 × 64: 28672 bytes to decode all images; the limit is 20000");
    // All that is kept fits, and so does each while it is decoded: one after the other.
    let enough = 4 * (64 * 64 + 32 * 32 + 16 * 16) + 3 * 64 * 64;
    assert_eq!(load(enough).unwrap(), load(1 << 30).unwrap());
}

#[test]
fn colours_of_vertices_can_mix_too() {
    let mut d = Document::triangle();
    let colors = d.accessor("VEC4", 5121, &[[255u8, 255, 255, 90]; 3]);
    d.json["accessors"][colors]["normalized"] = json!(true);
    d.primitive()["attributes"]["COLOR_0"] = json!(colors);
    d.primitive()["material"] = json!(0);
    d.push("materials", json!({ "name": "veil", "alphaMode": "BLEND" }));
    let (_, warnings) = d.load();
    assert!(warnings.len() == 1 && warnings[0].starts_with("a.glb: materials[0] `veil`: is BLEND"), "{warnings:?}");
}
