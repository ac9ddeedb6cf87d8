//! Primitives: vertices, and the triangles of lists, strips and fans.

use super::{
    FormatError,
    accessor::{Integers, Numbers},
    schema,
};
use crate::{
    formats::{loader::Loader, mesh},
    scene::Mesh,
};
use std::{collections::BTreeMap, sync::Arc};

/// Accessors of position, normal, tangent, both texture coordinates and colour.
type Attributes = [Option<u64>; 6];
/// What makes two primitives the same mesh: vertices, vertex numbers, mode.
type Shape = (Attributes, Option<u64>, u64);

/// Reads primitives; what two of them share is read once.
#[derive(Default)]
pub(super) struct Primitives {
    vertices: BTreeMap<Attributes, Mesh>,
    meshes: BTreeMap<Shape, Arc<Mesh>>,
}

impl Primitives {
    /// The mesh of a primitive; `None` where it has no triangles to show. `place` names it.
    pub fn mesh(
        &mut self,
        loader: &mut Loader,
        numbers: &Numbers,
        primitive: &schema::Primitive,
        place: &str,
    ) -> Result<Option<Arc<Mesh>>, FormatError> {
        let mode = primitive.mode.unwrap_or(4);
        match mode {
            4..=6 => {}
            0..=3 => {
                loader.warn(numbers.file, format!("{place}: points and lines are left out"));
                return Ok(None);
            }
            _ => return Err(FormatError::invalid(numbers.file, place, format!("unknown mode {mode}"))),
        }
        let of = |name: &str| primitive.attributes.get(name).copied();
        let attributes =
            [of("POSITION"), of("NORMAL"), of("TANGENT"), of("TEXCOORD_0"), of("TEXCOORD_1"), of("COLOR_0")];
        let Some(positions) = attributes[0] else {
            loader.warn(numbers.file, format!("{place} has no positions; left out"));
            return Ok(None);
        };
        let shape = (attributes, primitive.indices, mode);
        if let Some(mesh) = self.meshes.get(&shape) {
            return Ok(Some(mesh.clone()));
        }
        let vertices = match self.vertices.get(&attributes) {
            Some(v) => v.clone(),
            None => {
                let v = vertices(loader, numbers, attributes, positions, place)?;
                self.vertices.insert(attributes, v.clone());
                v
            }
        };
        let order = match primitive.indices {
            None => (0..vertices.positions.len() as u32).collect(),
            Some(i) => {
                let limit = loader.limits.triangles.saturating_mul(3);
                let found = numbers.count(i, place)?;
                if found > limit {
                    let (file, place) = (numbers.file.to_owned(), place.to_owned());
                    return Err(FormatError::Limit { file, place, what: "vertex numbers", found, limit });
                }
                numbers.indices(i, place)?
            }
        };
        let count = vertices.positions.len();
        if let Some((at, v)) = order.iter().enumerate().find(|(_, v)| **v as usize >= count) {
            let what = format!("vertex number {v} at place {at}; there are {count} vertices");
            return Err(FormatError::invalid(numbers.file, place, what));
        }
        let whole = Mesh { triangles: triangles(&order, mode).into(), ..vertices };
        let mut mesh = mesh::finish(whole)
            .map_err(|(at, what)| FormatError::invalid(numbers.file, format!("{place}, {at}"), what))?;
        // Exporters give many primitives one large vertex buffer: each then keeps its own vertices.
        if mesh.triangles.len() * 3 < count {
            mesh = mesh::compact(&mesh);
        }
        let mesh = Arc::new(mesh);
        self.meshes.insert(shape, mesh.clone());
        Ok(Some(mesh))
    }
}

fn vertices(
    loader: &mut Loader,
    numbers: &Numbers,
    [_, normals, tangents, uv0, uv1, colors]: Attributes,
    positions: u64,
    place: &str,
) -> Result<Mesh, FormatError> {
    let count = numbers.count(positions, place)?;
    loader.count_vertices(numbers.file, place, count)?;
    for other in [normals, tangents, uv0, uv1, colors].into_iter().flatten() {
        let found = numbers.count(other, place)?;
        if found != count {
            let what = format!("accessor {other} has {found} elements for {count} positions");
            return Err(FormatError::invalid(numbers.file, place, what));
        }
    }
    let told = Integers::AsTold;
    let wide = |index: u64, from: &str| numbers.vectors::<3>(index, from, &[3], told, 0.0);
    let uv = |index: Option<u64>| match index {
        Some(i) => Ok(numbers.vectors::<2>(i, place, &[2], told, 0.0)?.into()),
        None => Ok::<_, FormatError>(Default::default()),
    };
    Ok(Mesh {
        positions: wide(positions, place)?.into(),
        normals: normals.map(|i| wide(i, place)).transpose()?.unwrap_or_default().into(),
        tangents: match tangents {
            Some(i) => numbers.vectors::<4>(i, place, &[4], told, 0.0)?.into(),
            None => Default::default(),
        },
        uv: [uv(uv0)?, uv(uv1)?],
        colors: match colors {
            Some(i) => numbers.vectors::<4>(i, place, &[3, 4], Integers::Fractions, 1.0)?.into(),
            None => Default::default(),
        },
        triangles: Default::default(),
    })
}

/// The triangles of a list (4), strip (5) or fan (6), as glTF 2.0, section 3.7.2.1 orders them.
fn triangles(order: &[u32], mode: u64) -> Vec<[u32; 3]> {
    match mode {
        5 => order
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] })
            .collect(),
        6 => order.get(1..).unwrap_or_default().windows(2).map(|w| [w[0], w[1], order[0]]).collect(),
        _ => order.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    }
}
