//! Vertices: positions in 64 bits, and what else a vertex has.

use super::{Body, ColorColumns, Colors, Element, Fault, columns};

#[derive(Default)]
pub(super) struct Vertices {
    pub positions: Vec<[f64; 3]>,
    /// Each as long as the positions, or empty.
    pub normals: Vec<[f32; 3]>,
    pub uv: Vec<[f32; 2]>,
    pub colors: Option<Colors>,
}

impl Vertices {
    pub fn read(body: &mut Body, element: &Element) -> Result<Self, Fault> {
        let Some(xyz) = columns(element, &[["x", "y", "z"]]) else {
            return Err(Fault::At("header".into(), "vertices without x, y, z".into()));
        };
        let normal = columns(element, &[["nx", "ny", "nz"], ["normal_x", "normal_y", "normal_z"]]);
        let color = ColorColumns::of(element);
        let uv = columns(element, &[["s", "t"], ["u", "v"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]]);
        let count = element.count as usize;
        let room = |wanted: bool| if wanted { count } else { 0 };
        let mut positions = Vec::with_capacity(count);
        let mut normals = Vec::with_capacity(room(normal.is_some()));
        let mut colors = Vec::with_capacity(room(color.is_some()));
        let mut uvs = Vec::with_capacity(room(uv.is_some()));
        let mut row = vec![0.0f64; element.properties.len()];
        let mut items = Vec::new();
        for i in 0..count {
            body.read(element, i as u64, &mut row, None, &mut items)?;
            positions.push(xyz.map(|at| row[at]));
            if let Some(at) = normal {
                normals.push(at.map(|at| row[at] as f32));
            }
            if let Some(at) = &color {
                colors.push(at.pick(element, &row));
            }
            if let Some([u, v]) = uv {
                uvs.push([row[u] as f32, (1.0 - row[v]) as f32]);
            }
        }
        let colors = color.map(|at| Colors { rows: colors, kinds: at.kinds(element) });
        Ok(Self { positions, normals, uv: uvs, colors })
    }
}
