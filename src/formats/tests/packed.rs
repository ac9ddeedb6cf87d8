//! glTF: geometry and textures that extensions hold, and containers that are not quite as they should be.

use super::{
    document::{Document, corners, glb_of},
    *,
};
use serde_json::json;

/// A square of four vertices whose positions, normals and vertex numbers are compressed.
pub(super) fn compressed() -> Document {
    let mut d = Document::triangle();
    let positions = [[0i16, 0, 0, 0], [100, 0, 0, 0], [0, 200, 0, 0], [100, 200, 0, 0]];
    let up = meshopt::encode_filter_oct::<i8>(&[[0.0, 0.0, 1.0, 0.0]; 4], 8);
    let indices = meshopt::encode_index_buffer(&[0u32, 1, 2, 2, 1, 3], 4).unwrap();
    // The buffer that readers without the extension would use holds nothing.
    d.push(
        "buffers",
        json!({ "byteLength": 1 << 20, "extensions": { "EXT_meshopt_compression": { "fallback": true } } }),
    );
    let mut view = |bytes: &[u8], count: usize, stride: usize, mode: &str, filter: &str| {
        let at = d.view(bytes);
        let packed = json!({ "buffer": 0, "byteOffset": d.json["bufferViews"][at]["byteOffset"], "byteLength": bytes.len(),
                             "byteStride": stride, "count": count, "mode": mode, "filter": filter });
        d.json["bufferViews"][at] = json!({ "buffer": 1, "byteLength": count * stride, "byteStride": stride,
                                            "extensions": { "EXT_meshopt_compression": packed } });
        at
    };
    let p = view(&meshopt::encode_vertex_buffer(&positions).unwrap(), 4, 8, "ATTRIBUTES", "NONE");
    let n = view(&meshopt::encode_vertex_buffer(&up).unwrap(), 4, 4, "ATTRIBUTES", "OCTAHEDRAL");
    let i = view(&indices, 6, 2, "TRIANGLES", "NONE");
    d.json["bufferViews"][i].as_object_mut().unwrap().remove("byteStride");
    let p = d.push("accessors", json!({ "bufferView": p, "componentType": 5122, "count": 4, "type": "VEC3" }));
    let n = json!({ "bufferView": n, "componentType": 5120, "normalized": true, "count": 4, "type": "VEC3" });
    let n = d.push("accessors", n);
    let i = d.push("accessors", json!({ "bufferView": i, "componentType": 5123, "count": 6, "type": "SCALAR" }));
    *d.primitive() = json!({ "attributes": { "POSITION": p, "NORMAL": n }, "indices": i });
    d.json["nodes"][0]["scale"] = json!([0.01, 0.01, 0.01]);
    d.json["extensionsRequired"] = json!(["EXT_meshopt_compression", "KHR_mesh_quantization"]);
    d
}

#[test]
fn compressed_and_quantised_geometry_is_read() {
    let scene = compressed().scene();
    let found = corners(&scene, 0);
    let expect = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [1.0, 2.0, 0.0]];
    assert!(found.iter().zip(expect).all(|(a, b)| a.abs_diff_eq(b.into(), 1e-6)), "{found:?}");
    let mesh = &scene.objects[0].parts[0].mesh;
    assert_eq!(mesh.normals[..], [[0.0, 0.0, 1.0]; 4]);
    assert_eq!(scene.triangle_count(), 2);
    // By its other name too.
    let mut d = compressed();
    let text = d.json.to_string().replace("EXT_meshopt_compression", "KHR_meshopt_compression");
    d.json = serde_json::from_str(&text).unwrap();
    assert_eq!(d.scene(), scene);
}

#[test]
fn damaged_compression_names_the_view() {
    let mut d = compressed();
    let view = d.json["bufferViews"].as_array().unwrap().len() - 1;
    let packed = format!("/bufferViews/{view}/extensions/EXT_meshopt_compression");
    let mut error = |key: &str, value: serde_json::Value| {
        let good = std::mem::replace(&mut d.json.pointer_mut(&packed).unwrap()[key], value);
        let e = d.load().0.unwrap_err().to_string();
        d.json.pointer_mut(&packed).unwrap()[key] = good;
        e
    };
    let start = format!("a.glb: bufferViews[{view}]: ");
    for (key, value, expect) in [
        ("mode", json!("X"), "compression mode `X`"),
        ("count", json!(7), "7 elements of 2 bytes cannot be compressed as TRIANGLES"),
        ("count", json!(1u64 << 60), "1152921504606846976 elements of 2 bytes"),
        ("count", json!(30_000), "truncated: "),
        ("byteLength", json!(1), "truncated: "),
        ("byteOffset", json!(0), "its "),
        ("buffer", json!(1), "buffer 1 has neither a URI nor a binary chunk"),
    ] {
        let found = error(key, value);
        assert!(found.starts_with(&format!("{start}{expect}")), "{key}: {found}");
    }
}

#[test]
fn geometry_that_only_an_unknown_extension_holds_is_refused() {
    let mut d = Document::triangle();
    let draco = json!({ "KHR_draco_mesh_compression": { "bufferView": 0, "attributes": { "POSITION": 0 } } });
    d.primitive()["extensions"] = draco;
    d.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    // With plain data beside it, that is read.
    assert_eq!(d.load().0.unwrap().triangle_count(), 1);
    for a in d.json["accessors"].as_array_mut().unwrap() {
        a.as_object_mut().unwrap().remove("bufferView");
    }
    let error = d.load().0.unwrap_err().to_string();
    let expect = "a.glb: mesh 0 `m`, primitive 0: its geometry is in KHR_draco_mesh_compression, which cannot be read";
    assert!(error.starts_with(expect), "{error}");
}

#[test]
fn textures_of_extensions() {
    let mut webp = std::io::Cursor::new(Vec::new());
    let picture = image::RgbaImage::from_pixel(2, 2, image::Rgba([10, 20, 30, 255]));
    image::DynamicImage::from(picture).write_to(&mut webp, image::ImageFormat::WebP).unwrap();
    let mut d = Document::triangle();
    let view = d.view(&webp.into_inner());
    d.push("images", json!({ "bufferView": view, "mimeType": "image/webp" }));
    let base =
        json!({ "baseColorTexture": { "index": 0, "extensions": { "KHR_texture_transform": { "scale": [2, 3] } } } });
    d.push("materials", json!({ "pbrMetallicRoughness": base }));
    d.primitive()["material"] = json!(0);
    d.push("textures", json!({ "extensions": { "EXT_texture_webp": { "source": 0 } } }));
    let scene = d.scene();
    let texture = scene.objects[0].parts[0].material.base_color_texture.clone().unwrap();
    assert_eq!((texture.image.texels[0], texture.scale), ([10, 20, 30, 255], [2.0, 3.0]));
    d.json["textures"][0] = json!({ "extensions": { "KHR_texture_basisu": { "source": 0 } } });
    let error = d.load().0.unwrap_err().to_string();
    assert!(error.starts_with("a.glb: textures[0]: has only a KTX2 image (KHR_texture_basisu)"), "{error}");
    d.json["textures"][0]["source"] = json!(0);
    d.json["extensionsUsed"] = json!(["KHR_texture_basisu"]);
    assert!(d.load().0.is_ok());
}

#[test]
fn one_broken_triangle_costs_itself_alone() {
    let (mut d, text) = (Document::triangle(), "a.glb: mesh 0 `m`, primitive 0: ");
    let positions = d.floats("VEC3", &[[0.0f32; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [f32::NAN, 0.0, 0.0]]);
    let indices = d.accessor("SCALAR", 5123, &[0u16, 1, 2, 1, 2, 3, 0, 1, 9]);
    *d.primitive() = json!({ "attributes": { "POSITION": positions, "TEXCOORD_0": 1 }, "indices": indices });
    let (scene, warnings) = d.load();
    assert_eq!(scene.unwrap().triangle_count(), 1);
    let expect = [
        "TEXCOORD_0 has another number of elements than POSITION; left out",
        "1 triangles name vertices beyond its 4; they are left out",
        "1 triangles have corners that are not finite; they are left out",
    ];
    assert_eq!(warnings, expect.map(|e| format!("{text}{e}")));
}

#[test]
fn containers_that_viewers_read_are_read() {
    let d = Document::triangle();
    let good = d.glb();
    let json = {
        let mut json = d.json.clone();
        json["buffers"][0]["byteLength"] = json!(d.binary.len());
        json.to_string()
    };
    let load = |bytes: &[u8]| {
        let (scene, warnings) = Memory::of([("a.glb", bytes)]).load("a.glb");
        (scene.map(|s| s.triangle_count()).map_err(|e| e.to_string()), warnings)
    };
    let fine = |bytes: &[u8]| assert_eq!(load(bytes), (Ok(1), vec![]));
    // Zeros as padding of the JSON, a byte order mark, zeros and other bytes after the file.
    fine(&glb_of(format!("{json}\0\0\0\0\0").as_bytes(), &d.binary, 0));
    fine(&glb_of(format!("\u{feff}{json}").as_bytes(), &d.binary, b' '));
    fine(&[&good[..], &[0; 7]].concat());
    fine(&[&good[..], b"trailing"].concat());
    // The header's length covers what follows the last chunk.
    let longer = |more: &[u8]| {
        let mut bytes = [&good[..], more].concat();
        let n = bytes.len() as u32;
        bytes[8..12].copy_from_slice(&n.to_le_bytes());
        bytes
    };
    fine(&longer(&[0; 6]));
    fine(&longer(&[0; 60]));
    for more in [&b"xyz"[..], b"more bytes than a chunk's header"] {
        let (count, warnings) = load(&longer(more));
        assert!(count == Ok(1) && warnings[0].contains("bytes after the last chunk; left out"), "{warnings:?}");
    }
    // A length in the header that is too small, and a JSON chunk that is not padded.
    let mut short = good.clone();
    let n = good.len() as u32 - 8;
    short[8..12].copy_from_slice(&n.to_le_bytes());
    assert!(matches!(load(&short), (Ok(1), w) if w[0].contains("read by the chunks")));
    let odd = format!("{json}{}", " ".repeat(5 - json.len() % 4));
    let mut loose = glb_of(odd.as_bytes(), &d.binary, b' ');
    let at = 20 + odd.len();
    loose.drain(at..at + 3);
    loose[12..16].copy_from_slice(&(odd.len() as u32).to_le_bytes());
    let n = loose.len() as u32;
    loose[8..12].copy_from_slice(&n.to_le_bytes());
    assert!(matches!(load(&loose), (Ok(1), w) if w[0].contains("not padded")));
    // What cannot be read says what it is.
    let wide: Vec<u8> = [0xfeff].into_iter().chain(json.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let (scene, _) = Memory::of([("a.gltf", &wide[..])]).load("a.gltf");
    assert_eq!(scene.unwrap_err().to_string(), "a.gltf: JSON: UTF-16; JSON is UTF-8: save the file as UTF-8");
    let latin = json.replace("\"n\"", "\"n?\"").into_bytes();
    let latin: Vec<u8> = latin.into_iter().map(|b| if b == b'?' { 0xe9 } else { b }).collect();
    assert!(load(&glb_of(&latin, &d.binary, b' ')).0.unwrap_err().contains("JSON: not UTF-8 after byte "));
}
