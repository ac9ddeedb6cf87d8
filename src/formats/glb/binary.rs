//! The binary chunk: arrays and images end to end, each at a multiple of four bytes.

use super::{FormatError, schema};
use bytemuck::Pod;

const VERTICES: Option<u64> = Some(34962);
const INDICES: Option<u64> = Some(34963);
const U8: u64 = 5121;
const U16: u64 = 5123;
const U32: u64 = 5125;
const F32: u64 = 5126;

#[derive(Default)]
pub(super) struct Binary(Vec<u8>);

impl Binary {
    /// Appends bytes as a buffer view.
    pub fn view(&mut self, root: &mut schema::Root, bytes: &[u8], target: Option<u64>) -> u64 {
        let byte_offset = self.0.len() as u64;
        self.0.extend_from_slice(bytes);
        self.0.resize(self.0.len().next_multiple_of(4), 0);
        let byte_length = bytes.len() as u64;
        let extensions = schema::ViewExtensions::default();
        root.buffer_views.push(schema::View {
            buffer: 0,
            byte_offset,
            byte_length,
            byte_stride: None,
            target,
            extensions,
        });
        root.buffer_views.len() as u64 - 1
    }

    fn accessor<T: Pod>(
        &mut self,
        root: &mut schema::Root,
        shape: &str,
        component_type: u64,
        values: &[T],
        target: Option<u64>,
    ) -> u64 {
        let view = self.view(root, bytemuck::cast_slice(values), target);
        root.accessors.push(schema::Accessor {
            buffer_view: Some(view),
            byte_offset: 0,
            component_type,
            normalized: false,
            count: values.len() as u64,
            shape: shape.into(),
            min: None,
            max: None,
            sparse: None,
        });
        root.accessors.len() as u64 - 1
    }

    pub fn floats<T: Pod>(&mut self, root: &mut schema::Root, shape: &str, values: &[T]) -> u64 {
        self.accessor(root, shape, F32, values, VERTICES)
    }

    /// Positions, with the bounds that glTF demands.
    pub fn positions(&mut self, root: &mut schema::Root, values: &[[f32; 3]]) -> u64 {
        let n = self.floats(root, "VEC3", values);
        let fold = |pick: fn(f32, f32) -> f32, start: f32| {
            let all = values.iter().fold([start; 3], |m, v| std::array::from_fn(|k| pick(m[k], v[k])));
            Some(all.map(f64::from).to_vec())
        };
        let accessor = &mut root.accessors[n as usize];
        accessor.min = fold(f32::min, f32::INFINITY);
        accessor.max = fold(f32::max, f32::NEG_INFINITY);
        n
    }

    /// Colours, in bytes where bytes hold them exactly.
    pub fn colors(&mut self, root: &mut schema::Root, values: &[[f32; 4]]) -> u64 {
        let byte = |c: f32| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        if values.iter().flatten().all(|c| byte(*c) as f32 / 255.0 == *c) {
            let bytes: Vec<[u8; 4]> = values.iter().map(|v| v.map(byte)).collect();
            let n = self.accessor(root, "VEC4", U8, &bytes, VERTICES);
            root.accessors[n as usize].normalized = true;
            return n;
        }
        let clamped: Vec<[f32; 4]> = values.iter().map(|v| v.map(|c| c.clamp(0.0, 1.0))).collect();
        self.floats(root, "VEC4", &clamped)
    }

    /// Vertex numbers, in 16 bits where they fit (65,535 means "restart").
    pub fn indices(&mut self, root: &mut schema::Root, triangles: &[[u32; 3]], vertices: usize) -> u64 {
        let flat: &[u32] = bytemuck::cast_slice(triangles);
        if vertices <= u16::MAX as usize {
            let short: Vec<u16> = flat.iter().map(|v| *v as u16).collect();
            return self.accessor(root, "SCALAR", U16, &short, INDICES);
        }
        self.accessor(root, "SCALAR", U32, flat, INDICES)
    }

    /// The file.
    pub fn finish(self, mut root: schema::Root) -> Result<Vec<u8>, FormatError> {
        if !self.0.is_empty() {
            root.buffers = vec![schema::Buffer { uri: None, byte_length: self.0.len() as u64 }];
        }
        let mut json = serde_json::to_vec(&root).expect("plain data serialises");
        json.resize(json.len().next_multiple_of(4), b' ');
        let chunk = if self.0.is_empty() { 0 } else { 8 + self.0.len() };
        let total = 12 + 8 + json.len() + chunk;
        let Ok(length) = u32::try_from(total) else {
            let what = format!("{total} bytes; a GLB holds at most 4 GiB");
            return Err(FormatError::Unwritable { object: "the scene".into(), what });
        };
        let mut out = Vec::with_capacity(total);
        out.extend(b"glTF");
        out.extend(2u32.to_le_bytes());
        out.extend(length.to_le_bytes());
        out.extend((json.len() as u32).to_le_bytes());
        out.extend(b"JSON");
        out.extend(json);
        if chunk > 0 {
            out.extend((self.0.len() as u32).to_le_bytes());
            out.extend(b"BIN\0");
            out.extend(self.0);
        }
        Ok(out)
    }
}
