//! glTF: accessors, hierarchies, and what can be wrong with them.

use super::*;
use serde_json::{Value, json};

/// Bytes of a buffer, with the offset of each array in it.
#[derive(Default)]
struct Buffer(Vec<u8>);

impl Buffer {
    fn put<T: bytemuck::Pod>(&mut self, values: &[T]) -> usize {
        let at = self.0.len();
        self.0.extend(bytemuck::cast_slice::<T, u8>(values));
        self.0.resize(self.0.len().next_multiple_of(4), 0);
        at
    }
}

/// A document with one mesh of one primitive: a strip over four vertices, two of them replaced by a sparse accessor,
/// with u16 texture coordinates, u8 colours in an interleaved view, and a node below a node.
fn document() -> (Value, Vec<u8>) {
    let mut b = Buffer::default();
    let positions = b.put(&[[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [9.0, 9.0, 9.0], [9.0, 9.0, 9.0]]);
    let replaced = b.put(&[2u8, 3]);
    let by = b.put(&[[0f32, 1.0, 0.0], [1.0, 1.0, 0.0]]);
    let indices = b.put(&[0u8, 1, 2, 3]);
    // Colours as RGB in bytes, texture coordinates in 16 bits: eight bytes a vertex.
    let mixed: Vec<u8> = (0..4u8).flat_map(|i| [255, i * 51, 0, 7, 0, 0, 255, 255]).collect();
    let mixed = b.put(&mixed);
    let n = b.0.len();
    let json = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [
            { "name": "Root", "children": [1], "translation": [0, 0, 5], "scale": [2, 2, 2] },
            { "name": "House.003", "mesh": 0, "rotation": [0, 0, 1, 0] },
        ],
        "meshes": [{ "name": "m", "primitives": [{
            "mode": 5, "indices": 1,
            "attributes": { "POSITION": 0, "COLOR_0": 2, "TEXCOORD_0": 3, "_CUSTOM": 3 },
        }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0],
              "sparse": { "count": 2, "indices": { "bufferView": 1, "componentType": 5121 }, "values": { "bufferView": 2 } } },
            { "bufferView": 3, "componentType": 5121, "count": 4, "type": "SCALAR" },
            { "bufferView": 4, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC3" },
            { "bufferView": 4, "byteOffset": 4, "componentType": 5123, "normalized": true, "count": 4, "type": "VEC2" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": positions, "byteLength": 48 },
            { "buffer": 0, "byteOffset": replaced, "byteLength": 2 },
            { "buffer": 0, "byteOffset": by, "byteLength": 24 },
            { "buffer": 0, "byteOffset": indices, "byteLength": 4 },
            { "buffer": 0, "byteOffset": mixed, "byteLength": 32, "byteStride": 8 },
        ],
        "buffers": [{ "byteLength": n, "uri": "data%20file.bin" }],
    });
    (json, b.0)
}

fn files(json: &Value, binary: &[u8]) -> Memory {
    Memory::of([("d/a.gltf", json.to_string().as_bytes()), ("d/data file.bin", binary)])
}

/// `document` with the value at `path` set to `value`.
fn changed(path: &str, value: Value) -> Memory {
    let (mut json, binary) = document();
    let (parent, key) = path.rsplit_once('/').unwrap();
    let parent = json.pointer_mut(parent).unwrap_or_else(|| panic!("{path}"));
    match parent {
        Value::Array(a) => a[key.parse::<usize>().unwrap()] = value,
        other => other[key] = value,
    }
    files(&json, &binary)
}

#[test]
fn strips_sparse_strides_and_hierarchies() {
    let (json, binary) = document();
    let scene = files(&json, &binary).scene("d/a.gltf");
    let [object] = &scene.objects[..] else { panic!() };
    assert_eq!(object.name, "Root/House.003");
    let mesh = &object.parts[0].mesh;
    assert_eq!(mesh.positions[..], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
    assert_eq!(mesh.triangles[..], [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(mesh.uv[0][..], [[0.0, 1.0]; 4]);
    assert_eq!(mesh.colors[2], [1.0, 0.4, 0.0, 1.0]);
    // Half a turn about Z, twice as large, five metres off.
    assert!(object.transform.transform_point3(glam::Vec3::X).abs_diff_eq(glam::vec3(-2.0, 0.0, 5.0), 1e-6));
}

#[test]
fn fans_and_plain_lists() {
    let fan = changed("/meshes/0/primitives/0/mode", json!(6)).scene("d/a.gltf");
    assert_eq!(fan.objects[0].parts[0].mesh.triangles[..], [[1, 2, 0], [2, 3, 0]]);
    let (mut json, binary) = document();
    let primitive = &mut json["meshes"][0]["primitives"][0];
    primitive["mode"] = json!(4);
    primitive.as_object_mut().unwrap().remove("indices");
    let list = files(&json, &binary).scene("d/a.gltf");
    assert_eq!(list.objects[0].parts[0].mesh.triangles[..], [[0, 1, 2]]);
}

#[test]
fn lines_and_unknown_extensions_are_warnings() {
    let (scene, warnings) = changed("/meshes/0/primitives/0/mode", json!(1)).load("d/a.gltf");
    assert_eq!(scene.unwrap().objects.len(), 0);
    assert_eq!(warnings, ["d/a.gltf: mesh 0 `m`, primitive 0: points and lines are left out"]);
    let (_, warnings) =
        changed("/extensionsUsed", json!(["KHR_lights_punctual", "KHR_materials_unlit"])).load("d/a.gltf");
    assert_eq!(warnings, ["d/a.gltf: ignores KHR_lights_punctual"]);
    // What shows the same shape and base colour without it may even be required.
    let (scene, _) =
        changed("/extensionsRequired", json!(["KHR_lights_punctual", "KHR_materials_ior"])).load("d/a.gltf");
    assert_eq!(scene.unwrap().objects.len(), 1);
}

#[test]
fn errors_name_the_place() {
    for (path, value, expect) in [
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "extensionsRequired: KHR_draco_mesh_compression cannot be read; export the file without",
        ),
        ("/asset/version", json!("1.0"), "asset: version `1.0`; this reader knows glTF 2.0"),
        (
            "/accessors/0/count",
            json!(5),
            "accessors[0]: 5 elements of 12 bytes at 0 leave the 48 bytes of buffer view 0",
        ),
        ("/accessors/1/count", json!(5), "accessors[1]: 5 elements of 1 bytes at 0 leave the 4 bytes of buffer view 3"),
        (
            "/accessors/1/count",
            json!(u64::MAX),
            "mesh 0 `m`, primitive 0: 18446744073709551615 vertex numbers; the limit is 196608",
        ),
        ("/accessors/1/componentType", json!(5126), "accessors[1]: SCALAR of type 5126 as vertex numbers"),
        (
            "/accessors/2/type",
            json!("VEC2"),
            "accessors[2]: VEC2 where mesh 0 `m`, primitive 0 needs [3, 4] components",
        ),
        (
            "/accessors/0/sparse/count",
            json!(u64::MAX),
            "accessors[0]: 18446744073709551615 elements of 1 bytes at 0 leave the 2 bytes of buffer view 1",
        ),
        (
            "/accessors/0/sparse/indices/byteOffset",
            json!(u64::MAX),
            "accessors[0]: 2 elements of 1 bytes at 18446744073709551615 leave the 2 bytes of buffer view 1",
        ),
        (
            "/bufferViews/0/byteLength",
            json!(47),
            "accessors[0]: 4 elements of 12 bytes at 0 leave the 47 bytes of buffer view 0",
        ),
        (
            "/bufferViews/0/byteOffset",
            json!(u64::MAX),
            "bufferViews[0]: 48 bytes at 18446744073709551615 leave the buffer's 112",
        ),
        ("/bufferViews/4/byteStride", json!(1), "accessors[3]: byte stride 1 for elements of 4 bytes"),
        ("/bufferViews/0/buffer", json!(1), "bufferViews[0]: buffer 1 does not exist"),
        ("/buffers/0/byteLength", json!(113), "buffers[0]: truncated: it says 113 bytes, there are 112"),
        ("/nodes/1/children", json!([0]), "nodes[0]: reached twice: a cycle, or a node with two parents"),
        ("/nodes/1/mesh", json!(9), "nodes[1]: mesh 9 does not exist; there are 1"),
        ("/nodes/0/children", json!([7]), "nodes[7]: does not exist; there are 2"),
        ("/nodes/0/translation", json!([1e39, 0, 0]), "JSON: "),
        ("/scene", json!(3), "scene: 3 does not exist"),
        ("/meshes/0/primitives/0/material", json!(3), "materials[3]: does not exist; there are 0"),
        ("/meshes/0/primitives/0/mode", json!(9), "mesh 0 `m`, primitive 0: unknown mode 9"),
    ] {
        let found = changed(path, value).error("d/a.gltf");
        assert!(found.starts_with(&format!("d/a.gltf: {expect}")), "{path}\n  found {found}\nexpected {expect}");
    }
    let missing = changed("/buffers/0/uri", json!("no.bin"));
    assert_eq!(missing.error("d/a.gltf"), "d/no.bin: no such file");
    let outside = changed("/buffers/0/uri", json!("../a.bin"));
    assert_eq!(
        outside.error("d/a.gltf"),
        "d/a.gltf: `../a.bin` lies outside the scene's folder d; `--allow-outside` permits it"
    );
}

#[test]
fn accessors_that_imply_much_and_store_nothing_are_refused() {
    let (mut json, binary) = document();
    json["accessors"][0] = json!({ "componentType": 5126, "count": 4_000_000_000u64, "type": "VEC3" });
    let mut attributes = json["meshes"][0]["primitives"][0].clone();
    attributes["attributes"] = json!({ "POSITION": 0 });
    json["meshes"][0]["primitives"][0] = attributes;
    let limit = files(&json, &binary).error("d/a.gltf");
    assert_eq!(limit, "d/a.gltf: mesh 0 `m`, primitive 0: 4000000000 vertices; the limit is 65536");
    json["accessors"][0]["count"] = json!(1000);
    let implied = files(&json, &binary).error("d/a.gltf");
    assert_eq!(implied, "d/a.gltf: accessors[0]: 1000 elements that are not stored; at most 256 may be implied");
}

#[test]
fn an_image_that_claims_gigabytes_is_refused_before_it_is_decoded() {
    // A PNG that is only a header: 60,000 × 60,000.
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
    png.extend(60_000u32.to_be_bytes());
    png.extend(60_000u32.to_be_bytes());
    png.extend([8, 6, 0, 0, 0]);
    png.extend(crc(&png[12..]).to_be_bytes());
    png.extend(b"\0\0\0\0IDAT\x35\xaf\x06\x1e\0\0\0\0IEND\xae\x42\x60\x82");
    let (mut json, binary) = document();
    json["meshes"][0]["primitives"][0]["material"] = json!(0);
    json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    json["textures"] = json!([{ "source": 0 }]);
    json["images"] = json!([{ "uri": "big.png" }]);
    let mut files = files(&json, &binary);
    files.0.insert("d/big.png".into(), png);
    assert_eq!(
        files.error("d/a.gltf"),
        "d/a.gltf: images[0], 60000 × 60000: 3600000000 texels in all images; the limit is 65536"
    );
    files.0.insert("d/big.png".into(), b"GIF89a".to_vec());
    assert!(files.error("d/a.gltf").starts_with("d/a.gltf: images[0]: an image of kind Gif"));
}

#[test]
fn zero_normals_are_taken_from_the_faces() {
    let (mut json, mut binary) = document();
    let at = binary.len();
    binary.extend([0u8; 48]);
    json["buffers"][0]["byteLength"] = json!(binary.len());
    json["bufferViews"].as_array_mut().unwrap().push(json!({ "buffer": 0, "byteOffset": at, "byteLength": 48 }));
    json["accessors"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "bufferView": 5, "componentType": 5126, "count": 4, "type": "VEC3" }));
    json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(4);
    let scene = files(&json, &binary).scene("d/a.gltf");
    assert_eq!(scene.objects[0].parts[0].mesh.normals[..], [[0.0, 0.0, 1.0]; 4]);
}

#[test]
fn truncated_glbs_are_errors_wherever_they_end() {
    use crate::formats::{GlbOptions, from_glb, write_glb};
    let good = write_glb(&everything(), &GlbOptions::default()).unwrap();
    for end in 0..good.len() {
        let cut = Arc::new(good[..end].to_vec());
        from_glb(Path::new("m.glb"), cut, &small()).unwrap_err();
    }
}
