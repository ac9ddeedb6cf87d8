//! Writing GLB: one file that Blender, three.js, Godot, Unreal and Unity open as it is.
//!
//! Equal scenes give equal bytes. Every distinct mesh, material and image is stored once. What comes back from the
//! reader differs from what was written only in this: triangles of objects whose transform is no
//! translation-rotation-scale are stored in world space; parts without triangles are dropped; factors outside
//! their range are clamped; textures whose coordinates a mesh lacks are dropped there; with `unlit` all materials are
//! unlit and only their base colour is kept.

mod binary;
mod material;
mod node;

use super::{FormatError, gltf::schema};
use crate::scene::{Mesh, Object, Scene, tables::Tables};
use binary::Binary;
use material::Materials;
use node::NodePlacement;
use std::collections::BTreeMap;

/// What a written file should be like.
#[derive(Clone, Debug, PartialEq)]
pub struct GlbOptions {
    /// Marks every material as unlit (KHR_materials_unlit), as stand-ins with captured colour are.
    pub unlit: bool,
    /// Keeps normal maps on materials that `unlit` marks, for engines that replace the shader.
    pub normal_maps: bool,
}

impl Default for GlbOptions {
    fn default() -> Self {
        Self { unlit: true, normal_maps: false }
    }
}

/// An attribute of one number a vertex that scenes do not hold, for programs that know its name.
#[derive(Clone, Copy, Debug)]
pub struct Scalars<'a> {
    /// Begins with an underscore, as glTF demands of an application's own attributes.
    pub name: &'a str,
    /// One for each vertex.
    pub values: &'a [f32],
}

/// A primitive: attributes and vertex numbers as accessors.
#[derive(Clone)]
struct Stored {
    attributes: BTreeMap<String, u64>,
    indices: u64,
    /// Which coordinate sets it has.
    uv: [bool; 2],
}

/// The scene as a GLB with all textures inside, as PNG.
pub fn write_glb(scene: &Scene, options: &GlbOptions) -> Result<Vec<u8>, FormatError> {
    write_glb_with(scene, options, &[])
}

/// [`write_glb`] with more attributes for every mesh of the scene: for scenes of one mesh.
///
/// # Errors
/// Also where an attribute does not have one number for each vertex.
pub fn write_glb_with(scene: &Scene, options: &GlbOptions, scalars: &[Scalars]) -> Result<Vec<u8>, FormatError> {
    let tables = Tables::of(scene);
    let asset = schema::Asset { version: "2.0".into(), generator: Some("farfield".into()), ..Default::default() };
    let mut root = schema::Root { asset, ..Default::default() };
    let mut binary = Binary::default();
    let mut materials = Materials::new(&tables, options, &mut root, &mut binary)?;
    let mut stored: Vec<Option<Stored>> = vec![None; tables.meshes.len()];
    let mut shared = BTreeMap::<Vec<[u32; 2]>, u64>::new();
    let mut nodes = Vec::new();
    for (object, parts) in scene.objects.iter().zip(&tables.parts) {
        let shown: Vec<_> =
            parts.iter().filter(|p| !tables.meshes[p[0] as usize].triangles.is_empty()).copied().collect();
        if shown.is_empty() {
            continue;
        }
        let mut node = schema::Node { name: Some(object.name.clone()), ..Default::default() };
        let mesh = match NodePlacement::of(&object.transform) {
            NodePlacement::Baked(transform) => {
                let baked = shown.iter().map(|[mesh, material]| {
                    let mesh = transform.apply(tables.meshes[*mesh as usize]);
                    Ok((store(&mesh, object, scalars, &mut root, &mut binary)?, *material))
                });
                let baked = baked.collect::<Result<Vec<_>, FormatError>>()?;
                push_mesh(&mut root, &mut materials, object, &baked)
            }
            NodePlacement::Node(place) => {
                (node.translation, node.rotation, node.scale) = (place.translation, place.rotation, place.scale);
                match shared.get(&shown) {
                    Some(n) => *n,
                    None => {
                        let mut primitives = Vec::with_capacity(shown.len());
                        for [mesh, material] in &shown {
                            let slot = &mut stored[*mesh as usize];
                            let s = match slot {
                                Some(s) => s.clone(),
                                None => {
                                    let mesh = tables.meshes[*mesh as usize];
                                    slot.insert(store(mesh, object, scalars, &mut root, &mut binary)?).clone()
                                }
                            };
                            primitives.push((s, *material));
                        }
                        let n = push_mesh(&mut root, &mut materials, object, &primitives);
                        shared.insert(shown, n);
                        n
                    }
                }
            }
        };
        node.mesh = Some(mesh);
        nodes.push(root.nodes.len() as u64);
        root.nodes.push(node);
    }
    root.scene = Some(0);
    root.scenes = vec![schema::Scene { name: None, nodes }];
    materials.finish(&mut root);
    binary.finish(root)
}

fn push_mesh(root: &mut schema::Root, materials: &mut Materials, object: &Object, primitives: &[(Stored, u32)]) -> u64 {
    let primitives = primitives.iter().map(|(s, material)| schema::Primitive {
        attributes: s.attributes.clone(),
        indices: Some(s.indices),
        material: Some(materials.number(*material, s.uv)),
        ..Default::default()
    });
    let mesh = schema::Mesh { name: Some(object.name.clone()), primitives: primitives.collect(), ..Default::default() };
    root.meshes.push(mesh);
    root.meshes.len() as u64 - 1
}

/// Stores a mesh's arrays.
fn store(
    mesh: &Mesh,
    object: &Object,
    scalars: &[Scalars],
    root: &mut schema::Root,
    binary: &mut Binary,
) -> Result<Stored, FormatError> {
    let count = mesh.positions.len();
    let lengths = [mesh.normals.len(), mesh.tangents.len(), mesh.uv[0].len(), mesh.uv[1].len(), mesh.colors.len()];
    let unwritable = |what: &str| FormatError::Unwritable { object: object.name.clone(), what: what.into() };
    if lengths.iter().any(|n| *n != 0 && *n != count) || scalars.iter().any(|s| s.values.len() != count) {
        return Err(unwritable("attributes of unequal length"));
    }
    if mesh.triangles.iter().flatten().any(|v| *v as usize >= count) {
        return Err(unwritable("a vertex number beyond its vertices"));
    }
    if !mesh.positions.iter().flatten().all(|x| x.is_finite()) {
        return Err(unwritable("a vertex that is not finite"));
    }
    let mut attributes = BTreeMap::new();
    attributes.insert("POSITION".into(), binary.positions(root, &mesh.positions));
    if !mesh.normals.is_empty() {
        attributes.insert("NORMAL".into(), binary.floats(root, "VEC3", &mesh.normals));
        if !mesh.tangents.is_empty() {
            attributes.insert("TANGENT".into(), binary.floats(root, "VEC4", &mesh.tangents));
        }
    }
    let mut uv = [false; 2];
    for (set, has) in uv.iter_mut().enumerate() {
        if !mesh.uv[set].is_empty() {
            attributes.insert(format!("TEXCOORD_{set}"), binary.floats(root, "VEC2", &mesh.uv[set]));
            *has = true;
        }
    }
    // Coordinate sets must be numbered without a gap.
    if let (false, Some(second)) = (uv[0], attributes.get("TEXCOORD_1").copied()) {
        attributes.insert("TEXCOORD_0".into(), second);
    }
    if !mesh.colors.is_empty() {
        attributes.insert("COLOR_0".into(), binary.colors(root, &mesh.colors));
    }
    for s in scalars {
        attributes.insert(s.name.into(), binary.floats(root, "SCALAR", s.values));
    }
    let indices = binary.indices(root, &mesh.triangles, count);
    Ok(Stored { attributes, indices, uv })
}
