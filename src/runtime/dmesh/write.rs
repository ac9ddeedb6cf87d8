//! A DMesh as a bundle of files.

use super::{
    Blending, Dmesh, DmeshError, Frames, Mesh, Reference,
    manifest::{ALL, BlendingRow, FORMAT, Manifest, NAME, Row, VERSION, ViewDependent},
    shaders::SHADERS,
};
use crate::{
    formats::{GlbOptions, Scalars, write_glb, write_glb_with},
    image::{Picture, encode_png},
    runtime::bundle::{BundleFile, Camera, shader_files, shader_names},
    scene::{self, Material, Object, Part, Scene, Texture},
};
use glam::Mat4;
use rayon::prelude::*;
use std::sync::Arc;

/// Name of the attribute that holds the quality; one of its own, so that viewers leave the colour alone.
pub(super) const QUALITY: &str = "_QUALITY";

/// The files of a bundle: the manifest first, a GLB and, where there is a normal map, a PNG for each reference, a GLB of all
/// references, the shaders. Vertices that no triangle uses are left out, and the picture of a mesh
/// without triangles. `strips`: for each reference the number of triangle strips, or
/// nothing at all where they are not known. `frames`: depth images, from which meshes for a view are made.
///
/// # Errors
/// As [`Dmesh::check`].
pub fn write(
    dmesh: &Dmesh,
    blending: &Blending,
    strips: &[u64],
    frames: Option<&Frames>,
) -> Result<Vec<BundleFile>, DmeshError> {
    let manifest = manifest(dmesh, blending, strips, frames)?;
    let mut files = vec![BundleFile { path: NAME.into(), media: "application/json", bytes: manifest.into_bytes() }];
    let own = dmesh.references.par_iter().map(|r| of_reference(r, dmesh.double_sided));
    for own in own.collect::<Result<Vec<_>, _>>()? {
        files.extend(own);
    }
    for (reference, depths) in dmesh.references.iter().zip(frames.iter().flat_map(|f| &f.depths)) {
        let bytes = depths.iter().flat_map(|z| z.to_le_bytes()).collect();
        files.push(BundleFile { path: depth(&reference.name), media: "application/octet-stream", bytes });
    }
    let objects = dmesh.references.iter().filter_map(|r| object(r, &used(&r.mesh), dmesh.double_sided));
    let mut all = Scene { objects: objects.collect() };
    all.objects.sort_by(|a, b| a.name.cmp(&b.name));
    let bytes = write_glb(&all, &GlbOptions::default())?;
    files.push(BundleFile { path: ALL.into(), media: "model/gltf-binary", bytes });
    files.extend(shader_files(&SHADERS));
    Ok(files)
}

/// `dmesh.json` of the bundle that [`write()`] makes.
///
/// # Errors
/// As [`Dmesh::check`].
pub fn manifest(
    dmesh: &Dmesh,
    blending: &Blending,
    strips: &[u64],
    frames: Option<&Frames>,
) -> Result<String, DmeshError> {
    dmesh.check()?;
    if let Some(frames) = frames {
        frames.check(dmesh)?;
    }
    if !strips.is_empty() && strips.len() != dmesh.references.len() {
        let what = format!("{} numbers of strips for {} references", strips.len(), dmesh.references.len());
        return Err(DmeshError::invalid("dmesh", what));
    }
    let row = |(i, r): (usize, &Reference)| Row {
        name: r.name.clone(),
        camera: Camera::of(&r.view),
        glb: glb(&r.name),
        normals: r.normal_map.as_ref().map(|_| normals(&r.name)),
        depth: frames.map(|_| depth(&r.name)),
        triangles: r.mesh.triangles.len() as u64,
        strips: strips.get(i).copied(),
    };
    let manifest = Manifest {
        format: FORMAT.into(),
        version: VERSION,
        epsilon: dmesh.epsilon,
        diagonal: dmesh.diagonal,
        double_sided: dmesh.double_sided,
        blending: BlendingRow::of(blending),
        view_dependent: frames.map(|f| ViewDependent { tau: f.tau, hierarchy: f.options.clone() }),
        references: dmesh.references.iter().enumerate().map(row).collect(),
        all: ALL.into(),
        shaders: shader_names(&SHADERS),
    };
    let mut text = serde_json::to_string_pretty(&manifest).map_err(|e| DmeshError::invalid(NAME, e.to_string()))?;
    text.push('\n');
    Ok(text)
}

fn glb(name: &str) -> String {
    format!("references/{name}.glb")
}

fn normals(name: &str) -> String {
    format!("references/{name}-normals.png")
}

fn depth(name: &str) -> String {
    format!("references/{name}-depth.f32")
}

fn of_reference(reference: &Reference, double_sided: bool) -> Result<Vec<BundleFile>, DmeshError> {
    let mesh = used(&reference.mesh);
    let scene = Scene { objects: object(reference, &mesh, double_sided).into_iter().collect() };
    let scalars = [Scalars { name: QUALITY, values: &mesh.quality }];
    let bytes = write_glb_with(&scene, &GlbOptions::default(), &scalars)?;
    let mut files = vec![BundleFile { path: glb(&reference.name), media: "model/gltf-binary", bytes }];
    if let Some(map) = &reference.normal_map {
        let picture = Picture { width: map.width, height: map.height, texels: map.texels.to_vec() };
        let bytes = encode_png(&picture).map_err(|e| DmeshError::invalid(&reference.name, e.to_string()))?;
        files.push(BundleFile { path: normals(&reference.name), media: "image/png", bytes });
    }
    Ok(files)
}

/// An unlit object with the picture as its texture; `None` for a mesh without triangles.
fn object(reference: &Reference, mesh: &Mesh, double_sided: bool) -> Option<Object> {
    if mesh.triangles.is_empty() {
        return None;
    }
    let texture = Texture::clamped(reference.color.clone());
    let material = Material {
        name: reference.name.clone(),
        base_color_texture: Some(texture),
        double_sided,
        unlit: true,
        ..Material::default()
    };
    let mesh = scene::Mesh {
        positions: mesh.positions.clone(),
        normals: mesh.normals.clone(),
        uv: [mesh.uv.clone(), Default::default()],
        triangles: mesh.triangles.clone(),
        ..scene::Mesh::default()
    };
    let part = Part { mesh: Arc::new(mesh), material: Arc::new(material) };
    Some(Object { name: reference.name.clone(), transform: Mat4::IDENTITY, parts: vec![part] })
}

/// The mesh without the vertices that no triangle uses, the others in their order.
fn used(mesh: &Mesh) -> Mesh {
    let mut number = vec![u32::MAX; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|v| number[*v as usize] = 0);
    if !number.contains(&u32::MAX) {
        return mesh.clone();
    }
    let kept: Vec<usize> = (0..number.len()).filter(|v| number[*v] == 0).collect();
    for (new, old) in (0..).zip(&kept) {
        number[*old] = new;
    }
    let pick = |values: &[[f32; 3]]| kept.iter().filter_map(|v| values.get(*v).copied()).collect();
    Mesh {
        positions: pick(&mesh.positions),
        normals: pick(&mesh.normals),
        quality: kept.iter().map(|v| mesh.quality[*v]).collect(),
        uv: kept.iter().map(|v| mesh.uv[*v]).collect(),
        triangles: mesh.triangles.iter().map(|t| t.map(|v| number[v as usize])).collect(),
    }
}
