//! Primitives: vertices, and the triangles of lists, strips and fans.

use super::{
    FormatError,
    accessor::{Integers, Numbers, Want},
    pose::{self, Pose},
    schema, tidy,
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

const NAMES: [&str; 6] = ["POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "TEXCOORD_1", "COLOR_0"];

/// Reads primitives; what two of them share is read once.
#[derive(Default)]
pub(super) struct Primitives {
    vertices: BTreeMap<Attributes, Mesh>,
    meshes: BTreeMap<Shape, Option<Arc<Mesh>>>,
}

impl Primitives {
    /// The mesh of a primitive in a pose; `None` where it has no triangles to show. `place` names it.
    pub fn mesh(
        &mut self,
        loader: &mut Loader,
        numbers: &Numbers,
        primitive: &schema::Primitive,
        pose: &Pose,
        place: &str,
    ) -> Result<Option<Arc<Mesh>>, FormatError> {
        let mode = primitive.mode.unwrap_or(4);
        match mode {
            4..=6 => {}
            0..=3 => {
                loader.note(numbers.file, place, "points and lines are left out");
                return Ok(None);
            }
            _ => return Err(FormatError::invalid(numbers.file, place, format!("unknown mode {mode}"))),
        }
        let mut attributes = NAMES.map(|name| primitive.attributes.get(name).copied());
        let Some(positions) = attributes[0] else {
            loader.note(numbers.file, place, "has no positions; left out");
            return Ok(None);
        };
        stored_plainly(numbers, primitive, place)?;
        let count = numbers.count(positions, place)?;
        for (name, slot) in NAMES.iter().zip(&mut attributes).skip(1) {
            if let Some(accessor) = *slot
                && numbers.count(accessor, place)? != count
            {
                loader.note(
                    numbers.file,
                    place,
                    &format!("{name} has another number of elements than POSITION; left out"),
                );
                *slot = None;
            }
        }
        let shape = (attributes, primitive.indices, mode);
        let moves = pose.moves(primitive);
        if let (false, Some(mesh)) = (moves, self.meshes.get(&shape)) {
            return Ok(mesh.clone());
        }
        let mut vertices = match self.vertices.get(&attributes) {
            Some(v) => v.clone(),
            None => {
                loader.count_vertices(numbers.file, place, count)?;
                let v = vertices(numbers, attributes, positions, count, place)?;
                self.vertices.insert(attributes, v.clone());
                v
            }
        };
        if moves {
            pose::morph(loader, numbers, &mut vertices, primitive, pose.weights, place)?;
            if let Some(skin) = &pose.skin {
                vertices = pose::bend(loader, numbers, &vertices, primitive, skin, place)?;
            }
        }
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
        let mut triangles = triangles(&order, mode);
        if pose.skin.as_ref().is_some_and(|s| s.mirrored()) {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let whole = Mesh { triangles: triangles.into(), ..vertices };
        let mesh = self.finished(loader, numbers, whole, place)?;
        if !moves {
            self.meshes.insert(shape, mesh.clone());
        }
        Ok(mesh)
    }

    /// The mesh without what is broken in it.
    fn finished(
        &self,
        loader: &mut Loader,
        numbers: &Numbers,
        mesh: Mesh,
        place: &str,
    ) -> Result<Option<Arc<Mesh>>, FormatError> {
        let count = mesh.positions.len();
        let (mesh, notes) = tidy::tidy(mesh);
        for what in notes {
            loader.note(numbers.file, place, &what);
        }
        if mesh.triangles.is_empty() {
            return Ok(None);
        }
        let mut mesh = mesh::finish(mesh)
            .map_err(|(at, what)| FormatError::invalid(numbers.file, format!("{place}, {at}"), what))?;
        // Exporters give many primitives one large vertex buffer: each then keeps its own vertices.
        if mesh.triangles.len() * 3 < count {
            mesh = mesh::compact(&mesh);
        }
        Ok(Some(Arc::new(mesh)))
    }
}

/// An error where only an extension that is not read holds a primitive's vertices: its accessors have no buffer view then.
fn stored_plainly(numbers: &Numbers, primitive: &schema::Primitive, place: &str) -> Result<(), FormatError> {
    let Some(extension) = primitive.extensions.keys().find(|e| !e.starts_with("KHR_materials_")) else { return Ok(()) };
    for accessor in primitive.attributes.values().chain(&primitive.indices) {
        if !numbers.stored(*accessor, place)? {
            let what = format!("its geometry is in {extension}, which cannot be read; export the file without");
            return Err(FormatError::invalid(numbers.file, place, what));
        }
    }
    Ok(())
}

/// `count`: of every attribute, checked by the caller.
fn vertices(
    numbers: &Numbers,
    [_, normals, tangents, uv0, uv1, colors]: Attributes,
    positions: u64,
    count: u64,
    place: &str,
) -> Result<Mesh, FormatError> {
    let wide = numbers.vectors::<3>(positions, &Want::new(place, &[3]))?;
    // The positions are stored, or few: as many elements of the others may be implied.
    let want = |widths| Want { known: count, ..Want::new(place, widths) };
    let uv = |index: Option<u64>| match index {
        Some(i) => Ok(numbers.vectors::<2>(i, &want(&[2]))?.into()),
        None => Ok::<_, FormatError>(Default::default()),
    };
    let directions = |widths| Want { integers: Integers::Fractions, ..want(widths) };
    Ok(Mesh {
        positions: wide.into(),
        normals: normals.map(|i| numbers.vectors::<3>(i, &directions(&[3]))).transpose()?.unwrap_or_default().into(),
        tangents: tangents.map(|i| numbers.vectors::<4>(i, &directions(&[4]))).transpose()?.unwrap_or_default().into(),
        uv: [uv(uv0)?, uv(uv1)?],
        colors: match colors {
            Some(i) => {
                let want = Want { integers: Integers::Fractions, fill: 1.0, ..want(&[3, 4]) };
                numbers.vectors::<4>(i, &want)?.into()
            }
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
