//! The pose that a file shows: morph targets by the weights of node or mesh, then skins by the joints' own place in the node
//! hierarchy (glTF 2.0, sections 3.7.2.2 and 3.7.3). Animations move nothing.

use super::{
    FormatError,
    accessor::{Integers, Numbers, Want},
    schema,
};
use crate::{formats::loader::Loader, scene::Mesh};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, Mat4};
use rayon::prelude::*;
use std::sync::Arc;

/// How a node bends its mesh.
#[derive(Default)]
pub(super) struct Pose<'a> {
    /// Of the morph targets; missing ones are 0.
    pub weights: &'a [f32],
    pub skin: Option<Skin>,
}

/// Joints in the place where the file's nodes hold them.
pub(super) struct Skin {
    /// Of each joint: from the mesh's space in bind pose to the world.
    joints: Vec<DAffine3>,
    /// The node's own transform: where primitives without joints stand, and which way triangles face.
    node: DAffine3,
}

impl Pose<'_> {
    /// Whether it moves anything of a primitive.
    pub fn moves(&self, primitive: &schema::Primitive) -> bool {
        self.skin.is_some() || primitive.targets.iter().zip(self.weights).any(|(_, w)| *w != 0.0)
    }
}

/// A node's transform relative to its parent.
pub(super) fn local(node: &schema::Node) -> DMat4 {
    if let Some(m) = &node.matrix {
        return Mat4::from_cols_array(m).as_dmat4();
    }
    let t = node.translation.unwrap_or_default();
    trs(t, node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]), node.scale.unwrap_or([1.0; 3]))
}

/// A rotation without length turns nothing.
pub(super) fn trs(translation: [f32; 3], rotation: [f32; 4], scale: [f32; 3]) -> DMat4 {
    let vec = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let q = DQuat::from_array(rotation.map(f64::from));
    let q = if q.length_squared() > 0.0 { q.normalize() } else { DQuat::IDENTITY };
    DMat4::from_scale_rotation_translation(vec(scale), q, vec(translation))
}

/// The transforms of nodes in the whole hierarchy; joints may stand outside the scene.
pub(super) struct Hierarchy<'a> {
    nodes: &'a [schema::Node],
    parents: Vec<Option<usize>>,
}

impl<'a> Hierarchy<'a> {
    pub fn new(root: &'a schema::Root) -> Self {
        let nodes = &root.nodes;
        let mut parents = vec![None; nodes.len()];
        for (i, node) in nodes.iter().enumerate() {
            for child in &node.children {
                if let Some(parent) = usize::try_from(*child).ok().and_then(|c| parents.get_mut(c)) {
                    parent.get_or_insert(i);
                }
            }
        }
        Self { nodes, parents }
    }

    /// Node to world; `None` where there is no such node, or more than `depth` above it.
    fn world(&self, node: u64, depth: u32) -> Option<DMat4> {
        let mut at = usize::try_from(node).ok().filter(|n| *n < self.nodes.len())?;
        let mut chain = vec![at];
        while let Some(parent) = self.parents[at] {
            if chain.len() > depth as usize {
                return None;
            }
            chain.push(parent);
            at = parent;
        }
        Some(chain.iter().rev().fold(DMat4::IDENTITY, |m, n| m * local(&self.nodes[*n])))
    }
}

/// Skin `index` for a node that stands at `world`.
pub(super) fn skin(
    loader: &mut Loader,
    numbers: &Numbers,
    hierarchy: &Hierarchy,
    index: u64,
    world: DMat4,
) -> Result<Skin, FormatError> {
    let place = format!("skins[{index}]");
    let bad = |what: String| FormatError::invalid(numbers.file, &place, what);
    let skins = &numbers.root.skins;
    let found = usize::try_from(index).ok().and_then(|i| skins.get(i));
    let found = found.ok_or_else(|| bad(format!("does not exist; there are {}", skins.len())))?;
    let inverse: Vec<[f32; 16]> = match found.inverse_bind_matrices {
        Some(accessor) => {
            let known = found.joints.len() as u64;
            if numbers.count(accessor, &place)? > loader.limits.vertices {
                return Err(bad("more matrices than a scene may have vertices".into()));
            }
            numbers.vectors(accessor, &Want { known, ..Want::new(&place, &[16]) })?
        }
        None => Vec::new(),
    };
    if found.inverse_bind_matrices.is_some() && inverse.len() < found.joints.len() {
        let (have, need) = (inverse.len(), found.joints.len());
        let what = format!("{have} inverse bind matrices for {need} joints; the others count as identity");
        loader.warn(numbers.file, format!("{place}: {what}"));
    }
    let mut joints = Vec::with_capacity(found.joints.len());
    for (i, joint) in found.joints.iter().enumerate() {
        let joint_world = hierarchy.world(*joint, loader.limits.depth);
        let joint_world = joint_world.ok_or_else(|| bad(format!("joint {joint} does not exist, or lies too deep")))?;
        let inverse = inverse.get(i).map_or(DMat4::IDENTITY, |m| Mat4::from_cols_array(m).as_dmat4());
        let joint = DAffine3::from_mat4(joint_world * inverse);
        if !joint.is_finite() {
            return Err(bad(format!("the matrix of joint {i} is not finite")));
        }
        joints.push(joint);
    }
    Ok(Skin { joints, node: DAffine3::from_mat4(world) })
}

/// Adds the morph targets of `primitive` by their weights. A target's arrays that do not fit the mesh are left out with a warning.
pub(super) fn morph(
    loader: &mut Loader,
    numbers: &Numbers,
    mesh: &mut Mesh,
    primitive: &schema::Primitive,
    weights: &[f32],
    place: &str,
) -> Result<(), FormatError> {
    let count = mesh.positions.len();
    for (target, weight) in primitive.targets.iter().zip(weights) {
        loader.stop.check()?;
        if *weight == 0.0 {
            continue;
        }
        for (name, accessor) in target {
            let from = format!("{place}, morph target {name}");
            let present = match name.as_str() {
                "POSITION" => count,
                "NORMAL" => mesh.normals.len(),
                "TANGENT" => mesh.tangents.len(),
                "TEXCOORD_0" => mesh.uv[0].len(),
                "TEXCOORD_1" => mesh.uv[1].len(),
                "COLOR_0" => mesh.colors.len(),
                _ => 0,
            };
            if present == 0 {
                continue;
            }
            if numbers.count(*accessor, &from)? != count as u64 {
                loader.note(numbers.file, &from, "has another number of elements than the mesh; left out");
                continue;
            }
            let known = count as u64;
            let want = |widths| Want { known, ..Want::new(&from, widths) };
            match name.as_str() {
                "POSITION" => add(&mut mesh.positions, &numbers.vectors::<3>(*accessor, &want(&[3]))?, *weight),
                "NORMAL" => add(&mut mesh.normals, &numbers.vectors::<3>(*accessor, &want(&[3]))?, *weight),
                "TANGENT" => add(&mut mesh.tangents, &numbers.vectors::<3>(*accessor, &want(&[3]))?, *weight),
                "TEXCOORD_0" => add(&mut mesh.uv[0], &numbers.vectors::<2>(*accessor, &want(&[2]))?, *weight),
                "TEXCOORD_1" => add(&mut mesh.uv[1], &numbers.vectors::<2>(*accessor, &want(&[2]))?, *weight),
                _ => {
                    let want = Want { integers: Integers::Fractions, ..want(&[3, 4]) };
                    add(&mut mesh.colors, &numbers.vectors::<4>(*accessor, &want)?, *weight);
                }
            }
        }
    }
    Ok(())
}

/// Adds `weight` times `offsets`; components that the offsets lack stay.
fn add<const N: usize, const M: usize>(values: &mut crate::array::Array<[f32; N]>, offsets: &[[f32; M]], weight: f32)
where
    [f32; N]: bytemuck::Pod,
{
    let mut moved = std::mem::take(values).into_vec();
    for (v, d) in moved.iter_mut().zip(offsets) {
        for (v, d) in v.iter_mut().zip(d) {
            *v += weight * d;
        }
    }
    *values = moved.into();
}

/// Bends `mesh` by its joints; what comes out stands in the world.
pub(super) fn bend(
    loader: &mut Loader,
    numbers: &Numbers,
    mesh: &Mesh,
    primitive: &schema::Primitive,
    skin: &Skin,
    place: &str,
) -> Result<Mesh, FormatError> {
    loader.count_vertices(numbers.file, place, mesh.positions.len() as u64)?;
    let sets = influences(numbers, primitive, mesh.positions.len(), place)?;
    let n = skin.joints.len();
    let bound = |set: &Influences, v: usize| -> [Option<(usize, f64)>; 4] {
        std::array::from_fn(|k| {
            let (joint, weight) = (set.joints[v][k], f64::from(set.weights[v][k]));
            let known = joint >= 0.0 && (joint as usize) < n;
            (weight > 0.0 && weight.is_finite() && known).then_some((joint as usize, weight))
        })
    };
    let place_of = |v: usize| {
        let (mut matrix3, mut translation, mut sum) = (DMat3::ZERO, DVec3::ZERO, 0.0);
        for (joint, weight) in sets.iter().flat_map(|set| bound(set, v)).flatten() {
            matrix3 += skin.joints[joint].matrix3 * weight;
            translation += skin.joints[joint].translation * weight;
            sum += weight;
        }
        match sets.first() {
            _ if sum > 0.0 => DAffine3 { matrix3: matrix3 * (1.0 / sum), translation: translation / sum },
            // A vertex without weights follows its first joint, as in viewers.
            Some(set) => skin.joints.get(set.joints[v][0].max(0.0) as usize).copied().unwrap_or(skin.node),
            None => skin.node,
        }
    };
    if sets.is_empty() {
        loader.note(numbers.file, place, "has a skin but no joints; it stands where its node does");
    }
    let stray = |set: &Influences| {
        let vertices = set.joints.iter().zip(&set.weights);
        vertices.filter(|(j, w)| (0..4).any(|k| w[k] > 0.0 && !(j[k] >= 0.0 && (j[k] as usize) < n))).count()
    };
    let strays: usize = sets.iter().map(stray).sum();
    if strays > 0 {
        loader.note(numbers.file, place, &format!("{strays} vertices are bound to joints that the skin lacks"));
    }
    loader.stop.check()?;
    let places: Vec<DAffine3> = (0..mesh.positions.len()).into_par_iter().map(place_of).collect();
    let vec = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let side = |m: &DMat3| if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    let normal = |(v, n): (usize, &[f32; 3])| {
        let m = &places[v].matrix3;
        let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
        // The cofactor matrix carries normals even where joints flatten the mesh.
        let cofactor = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        (cofactor * vec(*n) * side(m)).normalize_or_zero().as_vec3().to_array()
    };
    let tangent = |(v, t): (usize, &[f32; 4])| {
        let m = &places[v].matrix3;
        let along = (*m * vec([t[0], t[1], t[2]])).normalize_or_zero();
        along.as_vec3().extend(t[3] * side(m) as f32).to_array()
    };
    let position = |(v, p): (usize, &[f32; 3])| places[v].transform_point3(vec(*p)).as_vec3().to_array();
    Ok(Mesh {
        positions: mesh.positions.par_iter().enumerate().map(position).collect::<Vec<_>>().into(),
        normals: mesh.normals.par_iter().enumerate().map(normal).collect::<Vec<_>>().into(),
        tangents: mesh.tangents.par_iter().enumerate().map(tangent).collect::<Vec<_>>().into(),
        ..mesh.clone()
    })
}

impl Skin {
    /// Whether triangles face the other way: glTF lets the node's own transform decide (section 3.7.4).
    pub fn mirrored(&self) -> bool {
        self.node.matrix3.determinant() < 0.0
    }
}

/// Four joints of every vertex with their weights.
struct Influences {
    joints: Vec<[f32; 4]>,
    weights: Vec<[f32; 4]>,
}

fn influences(
    numbers: &Numbers,
    primitive: &schema::Primitive,
    count: usize,
    place: &str,
) -> Result<Vec<Influences>, FormatError> {
    let mut sets = Vec::new();
    for set in 0.. {
        let of = |name: &str| primitive.attributes.get(&format!("{name}_{set}")).copied();
        let (Some(joints), Some(weights)) = (of("JOINTS"), of("WEIGHTS")) else { break };
        for accessor in [joints, weights] {
            let found = numbers.count(accessor, place)?;
            if found != count as u64 {
                let what = format!("accessor {accessor} has {found} elements for {count} positions");
                return Err(FormatError::invalid(numbers.file, place, what));
            }
        }
        let want = Want { known: count as u64, ..Want::new(place, &[4]) };
        sets.push(Influences {
            joints: numbers.vectors(joints, &want)?,
            weights: numbers.vectors(weights, &Want { integers: Integers::Fractions, ..want })?,
        });
    }
    Ok(sets)
}

/// Instances of a node's mesh (EXT_mesh_gpu_instancing), relative to the node; `None` where it has none.
pub(super) fn instances(
    loader: &Loader,
    numbers: &Numbers,
    node: &schema::Node,
    place: &str,
) -> Result<Option<Arc<[DMat4]>>, FormatError> {
    let Some(instancing) = &node.extensions.instancing else { return Ok(None) };
    let from = format!("{place}, EXT_mesh_gpu_instancing");
    let mut count = None;
    for accessor in instancing.attributes.values() {
        let found = numbers.count(*accessor, &from)?;
        if count.is_some_and(|c| c != found) {
            return Err(FormatError::invalid(numbers.file, from, "its accessors have different numbers of elements"));
        }
        count = Some(found);
    }
    let Some(found) = count else { return Ok(None) };
    let limit = loader.limits.objects;
    if found > limit {
        return Err(FormatError::Limit { file: numbers.file.to_owned(), place: from, what: "instances", found, limit });
    }
    let of = |name: &str| instancing.attributes.get(name).copied();
    let want = |widths| Want { integers: Integers::AsTold, ..Want::new(&from, widths) };
    let translations = of("TRANSLATION").map(|a| numbers.vectors::<3>(a, &want(&[3]))).transpose()?;
    let turned = Want { integers: Integers::Fractions, ..want(&[4]) };
    let rotations = of("ROTATION").map(|a| numbers.vectors::<4>(a, &turned)).transpose()?;
    let scales = of("SCALE").map(|a| numbers.vectors::<3>(a, &want(&[3]))).transpose()?;
    let one = |i: usize| {
        let t = translations.as_ref().map_or([0.0; 3], |t| t[i]);
        let r = rotations.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |r| r[i]);
        trs(t, r, scales.as_ref().map_or([1.0; 3], |s| s[i]))
    };
    Ok(Some((0..found as usize).map(one).collect()))
}
