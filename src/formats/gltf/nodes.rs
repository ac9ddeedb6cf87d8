//! The node hierarchy: which meshes stand where, under which names.

use super::{
    FormatError,
    accessor::Numbers,
    material,
    pose::{self, Hierarchy, Pose},
    primitive::Primitives,
};
use crate::{
    formats::{appearance, loader::Loader},
    scene::{Alpha, Material, Mesh, Object, Part},
};
use glam::{DMat4, Mat4};
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

/// A node with a mesh, found in the hierarchy.
struct Placed {
    name: String,
    /// One for every instance.
    transforms: Vec<Mat4>,
    node: usize,
    mesh: usize,
    /// The skin and the node's own place.
    skin: Option<(u64, DMat4)>,
}

/// What tells a mesh in one pose from the same mesh in another: the bits of its weights, and the node where that has a skin.
type Posed = (usize, Vec<u32>, Option<usize>);

/// Every node of the scene that has a mesh with triangles.
pub(super) fn objects(loader: &mut Loader, numbers: &Numbers) -> Result<Vec<Object>, FormatError> {
    let (file, root) = (numbers.file, numbers.root);
    let placed = walk(loader, numbers)?;
    let hierarchy = Hierarchy::new(root);
    let mut used = BTreeSet::new();
    let mut shapes = BTreeMap::<Posed, Vec<(Arc<Mesh>, Option<u64>)>>::new();
    let mut primitives = Primitives::default();
    let weights_of = |p: &Placed| match &root.nodes[p.node].weights[..] {
        [] => &root.meshes[p.mesh].weights[..],
        own => own,
    };
    let posed = |p: &Placed| -> Posed {
        let bits = weights_of(p).iter().map(|w| w.to_bits()).collect();
        (p.mesh, bits, p.skin.map(|_| p.node))
    };
    for p in &placed {
        let key = posed(p);
        if shapes.contains_key(&key) {
            continue;
        }
        loader.stop.check()?;
        let mesh = &root.meshes[p.mesh];
        let label = mesh.name.as_deref().map(|n| format!(" `{n}`")).unwrap_or_default();
        let weights = weights_of(p);
        if let Some(w) = weights.iter().find(|w| !w.is_finite()) {
            let place = format!("mesh {}{label}", p.mesh);
            return Err(FormatError::invalid(file, place, format!("a morph weight is {w}; it must be finite")));
        }
        let skin = p.skin.map(|(skin, world)| pose::skin(loader, numbers, &hierarchy, skin, world)).transpose()?;
        let pose = Pose { weights, skin };
        let mut parts = Vec::with_capacity(mesh.primitives.len());
        for (i, primitive) in mesh.primitives.iter().enumerate() {
            let place = format!("mesh {}{label}, primitive {i}", p.mesh);
            if let Some(shape) = primitives.mesh(loader, numbers, primitive, &pose, &place)? {
                parts.push((shape, primitive.material));
                used.insert(primitive.material);
            }
        }
        shapes.insert(key, parts);
    }
    let materials = material::materials(loader, numbers, &used)?;
    let clear = |mesh: &Mesh| mesh.colors.iter().any(|c| c[3] < 1.0);
    let mixed: BTreeSet<u64> = shapes
        .values()
        .flatten()
        .filter(|(mesh, material)| materials[material].alpha == Alpha::Blend && clear(mesh))
        .filter(|(_, material)| appearance::trouble(&materials[material]).is_none())
        .filter_map(|(_, material)| *material)
        .collect();
    for index in mixed {
        loader.note(file, &material::place(root, index), appearance::BLEND);
    }
    let part = |(mesh, material): &(Arc<Mesh>, Option<u64>)| {
        let material: &Arc<Material> = &materials[material];
        Part { mesh: mesh.clone(), material: material.clone() }
    };
    let parts: BTreeMap<Posed, Vec<Part>> =
        shapes.iter().map(|(m, p)| (m.clone(), p.iter().map(part).collect())).collect();
    let mut out = Vec::with_capacity(placed.len());
    for p in placed {
        let parts = &parts[&posed(&p)];
        let many = p.transforms.len() > 1;
        for (i, transform) in p.transforms.into_iter().enumerate() {
            let name = if many { format!("{}/{i}", p.name) } else { p.name.clone() };
            let object = Object { name, transform, parts: parts.clone() };
            if object.parts.is_empty() {
                continue;
            }
            loader.count_object(file, &object.name, object.triangle_count() as u64)?;
            out.push(object);
        }
    }
    Ok(out)
}

/// Walks the scene's nodes from its roots; every node must be reached at most once.
fn walk(loader: &mut Loader, numbers: &Numbers) -> Result<Vec<Placed>, FormatError> {
    let (file, root) = (numbers.file, numbers.root);
    let bad = |node: u64, what: String| FormatError::invalid(file, format!("nodes[{node}]"), what);
    let mut visited = vec![false; root.nodes.len()];
    let mut out = Vec::new();
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
        if node.extensions.visibility.as_ref().is_some_and(|v| v.visible == Some(false)) {
            loader.note(file, &format!("nodes[{index}]"), "is marked as not visible; left out with all below it");
            continue;
        }
        let world = parent * pose::local(node);
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
            let place = format!("nodes[{index}]");
            let skin = node.skin.map(|skin| (skin, world));
            let transforms = match (pose::instances(loader, numbers, node, &place)?, skin) {
                // glTF 2.0, section 3.7.3.3: the node's own transform does not place a skinned mesh.
                (instances, Some(_)) => {
                    if instances.is_some() {
                        loader.note(file, &place, "has a skin and instances; the instances are left out");
                    }
                    vec![Mat4::IDENTITY]
                }
                (None, None) => vec![world.as_mat4()],
                (Some(instances), None) => instances.iter().map(|m| (world * *m).as_mat4()).collect(),
            };
            if !transforms.iter().all(Mat4::is_finite) {
                return Err(bad(index, "its transform is not finite".into()));
            }
            out.push(Placed { name: name.to_string(), transforms, node: i, mesh, skin });
        }
        stack.extend(node.children.iter().rev().map(|c| (*c, world, name.clone(), depth + 1)));
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
