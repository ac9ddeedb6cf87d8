//! The node hierarchy: which meshes stand where, under which names.

use super::{FormatError, accessor::Numbers, material, primitive::Primitives, schema};
use crate::{
    formats::loader::Loader,
    scene::{Material, Mesh, Object, Part},
};
use glam::{DMat4, DQuat, DVec3, Mat4};
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

/// A node with a mesh, found in the hierarchy.
struct Placed {
    name: String,
    transform: Mat4,
    mesh: usize,
}

/// Every node of the scene that has a mesh with triangles.
pub(super) fn objects(loader: &mut Loader, numbers: &Numbers) -> Result<Vec<Object>, FormatError> {
    let (file, root) = (numbers.file, numbers.root);
    let placed = walk(loader, numbers)?;
    let meshes: BTreeSet<usize> = placed.iter().map(|p| p.mesh).collect();
    let mut used = BTreeSet::new();
    let mut shapes = BTreeMap::<usize, Vec<(Arc<Mesh>, Option<u64>)>>::new();
    let mut primitives = Primitives::default();
    for m in meshes {
        loader.stop.check()?;
        let mesh = &root.meshes[m];
        let label = mesh.name.as_deref().map(|n| format!(" `{n}`")).unwrap_or_default();
        if mesh.primitives.iter().any(|p| !p.targets.is_empty()) {
            loader.warn(file, format!("mesh {m}{label} has morph targets; it is read in rest pose"));
        }
        let mut parts = Vec::with_capacity(mesh.primitives.len());
        for (i, p) in mesh.primitives.iter().enumerate() {
            let place = format!("mesh {m}{label}, primitive {i}");
            if let Some(shape) = primitives.mesh(loader, numbers, p, &place)? {
                parts.push((shape, p.material));
                used.insert(p.material);
            }
        }
        shapes.insert(m, parts);
    }
    let materials = material::materials(loader, numbers, &used)?;
    let part = |(mesh, material): &(Arc<Mesh>, Option<u64>)| {
        let material: &Arc<Material> = &materials[material];
        Part { mesh: mesh.clone(), material: material.clone() }
    };
    let parts: BTreeMap<usize, Vec<Part>> = shapes.iter().map(|(m, p)| (*m, p.iter().map(part).collect())).collect();
    let mut out = Vec::with_capacity(placed.len());
    for p in placed {
        let object = Object { name: p.name, transform: p.transform, parts: parts[&p.mesh].clone() };
        if object.parts.is_empty() {
            continue;
        }
        loader.count_object(file, &object.name, object.triangle_count() as u64)?;
        out.push(object);
    }
    Ok(out)
}

/// Walks the scene's nodes from its roots; every node must be reached at most once.
fn walk(loader: &mut Loader, numbers: &Numbers) -> Result<Vec<Placed>, FormatError> {
    let (file, root) = (numbers.file, numbers.root);
    let bad = |node: u64, what: String| FormatError::invalid(file, format!("nodes[{node}]"), what);
    let mut visited = vec![false; root.nodes.len()];
    let mut out = Vec::new();
    let mut skinned = false;
    // Children are pushed in reverse, so that nodes come out in the file's order.
    let mut stack: Vec<(u64, DMat4, Arc<str>, u32)> =
        roots(numbers)?.into_iter().rev().map(|n| (n, DMat4::IDENTITY, "".into(), 0)).collect();
    while let Some((index, parent, path, depth)) = stack.pop() {
        let i = usize::try_from(index).unwrap_or(usize::MAX);
        let node = root.nodes.get(i);
        let node = node.ok_or_else(|| bad(index, format!("does not exist; there are {}", root.nodes.len())))?;
        if std::mem::replace(&mut visited[i], true) {
            return Err(bad(index, "reached twice: a cycle, or a node with two parents".into()));
        }
        if depth > loader.limits.depth {
            return Err(bad(index, format!("more than {} levels deep", loader.limits.depth)));
        }
        let world = parent * local(node);
        let mesh_name = node.mesh.and_then(|m| root.meshes.get(usize::try_from(m).ok()?)?.name.as_deref());
        let own = node.name.as_deref().filter(|n| !n.is_empty()).or(mesh_name.filter(|n| !n.is_empty()));
        let own = own.unwrap_or("node");
        let length = path.len() + own.len();
        if length as u64 > loader.limits.name {
            let (limit, found) = (loader.limits.name, length as u64);
            let place = format!("nodes[{index}]");
            return Err(FormatError::Limit { file: file.to_owned(), place, what: "bytes of name", found, limit });
        }
        let name: Arc<str> = if path.is_empty() { own.into() } else { format!("{path}/{own}").into() };
        if let Some(m) = node.mesh {
            let mesh = usize::try_from(m).unwrap_or(usize::MAX);
            if mesh >= root.meshes.len() {
                return Err(bad(index, format!("mesh {m} does not exist; there are {}", root.meshes.len())));
            }
            let mut transform = world;
            if node.skin.is_some() {
                skinned = true;
                // glTF 2.0, section 3.7.3.3: the node's own transform does not place a skinned mesh.
                transform = DMat4::IDENTITY;
            }
            let transform = transform.as_mat4();
            if !transform.is_finite() {
                return Err(bad(index, "its transform is not finite".into()));
            }
            out.push(Placed { name: name.to_string(), transform, mesh });
        }
        stack.extend(node.children.iter().rev().map(|c| (*c, world, name.clone(), depth + 1)));
    }
    if skinned {
        loader.warn(file, "has skins; they are read in rest pose");
    }
    Ok(out)
}

/// The roots of the default scene; of the first one where there is no default; of all nodes where there is no scene.
fn roots(numbers: &Numbers) -> Result<Vec<u64>, FormatError> {
    let root = numbers.root;
    if let Some(s) = root.scene.or((!root.scenes.is_empty()).then_some(0)) {
        let scene = usize::try_from(s).ok().and_then(|s| root.scenes.get(s));
        let scene = scene.ok_or_else(|| FormatError::invalid(numbers.file, "scene", format!("{s} does not exist")))?;
        return Ok(scene.nodes.clone());
    }
    let children: BTreeSet<u64> = root.nodes.iter().flat_map(|n| n.children.iter().copied()).collect();
    Ok((0..root.nodes.len() as u64).filter(|n| !children.contains(n)).collect())
}

/// A node's transform relative to its parent.
fn local(node: &schema::Node) -> DMat4 {
    if let Some(m) = &node.matrix {
        return Mat4::from_cols_array(m).as_dmat4();
    }
    let vec = |v: Option<[f32; 3]>, default: f32| DVec3::from(v.unwrap_or([default; 3]).map(f64::from));
    let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]).map(f64::from);
    let q = DQuat::from_xyzw(x, y, z, w);
    let q = if q.length_squared() > 0.0 { q.normalize() } else { DQuat::IDENTITY };
    DMat4::from_scale_rotation_translation(vec(node.scale, 1.0), q, vec(node.translation, 0.0))
}
