//! glTF documents made piece by piece.

use super::*;
use serde_json::{Value, json};

/// JSON and the bytes of its one buffer.
pub(super) struct Document {
    pub json: Value,
    pub binary: Vec<u8>,
}

impl Document {
    /// One node with a mesh of one triangle: (0, 0, 0), (1, 0, 0), (0, 2, 0), facing +Z, with texture coordinates.
    pub fn triangle() -> Self {
        let json = json!({
            "asset": { "version": "2.0" },
            "nodes": [{ "mesh": 0, "name": "n" }],
            "meshes": [{ "name": "m", "primitives": [{ "attributes": {} }] }],
            "accessors": [], "bufferViews": [], "buffers": [{}],
        });
        let mut document = Self { json, binary: Vec::new() };
        let positions = document.floats("VEC3", &[[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
        let uv = document.floats("VEC2", &[[0.0f32, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        *document.primitive() = json!({ "attributes": { "POSITION": positions, "TEXCOORD_0": uv } });
        document
    }

    pub fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// Appends to a list of the document; the element's number.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let at = self.binary.len();
        self.binary.extend(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": at, "byteLength": bytes.len() }))
    }

    pub fn accessor<T: bytemuck::Pod>(&mut self, shape: &str, component: u64, values: &[T]) -> usize {
        let view = self.view(bytemuck::cast_slice(values));
        let row = json!({ "bufferView": view, "componentType": component, "count": values.len(), "type": shape });
        self.push("accessors", row)
    }

    pub fn floats<T: bytemuck::Pod>(&mut self, shape: &str, values: &[T]) -> usize {
        self.accessor(shape, 5126, values)
    }

    /// As a GLB.
    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"][0]["byteLength"] = json!(self.binary.len());
        glb_of(json.to_string().as_bytes(), &self.binary, b' ')
    }

    pub fn load(&self) -> (Result<Scene, FormatError>, Vec<String>) {
        Memory::of([("a.glb", &self.glb()[..])]).load("a.glb")
    }

    /// Loads without a warning.
    pub fn scene(&self) -> Scene {
        Memory::of([("a.glb", &self.glb()[..])]).scene("a.glb")
    }

    /// The corners of the first object's first part in the world.
    pub fn corners(&self) -> Vec<glam::Vec3> {
        corners(&self.scene(), 0)
    }
}

pub(super) fn corners(scene: &Scene, object: usize) -> Vec<glam::Vec3> {
    let o = &scene.objects[object];
    o.parts[0].mesh.positions.iter().map(|p| o.transform.transform_point3((*p).into())).collect()
}

/// A GLB of these chunks, the JSON padded with `pad`.
pub(super) fn glb_of(json: &[u8], binary: &[u8], pad: u8) -> Vec<u8> {
    let mut json = json.to_vec();
    json.resize(json.len().next_multiple_of(4), pad);
    let chunk = |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat();
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", binary)].concat();
    let length = (12 + chunks.len()) as u32;
    [&b"glTF"[..], &2u32.to_le_bytes(), &length.to_le_bytes(), &chunks].concat()
}
