//! Reading a bundle. Any bytes give a DMesh that can be drawn or an error.

use super::{
    Blending, Dmesh, DmeshError, Frames, Mesh, Reference,
    manifest::{Manifest, NAME, Row},
    write::QUALITY,
};
use crate::{
    array::Array,
    formats::{Files, Limits, from_glb, image_from_bytes, scalars_from_glb},
    runtime::bundle::{self, load},
    scene::Image,
};
use rayon::prelude::*;
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// What a bundle holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Bundle {
    pub dmesh: Dmesh,
    /// How it is meant to be drawn.
    pub blending: Blending,
    /// What meshes for a view are made from.
    pub frames: Option<Frames>,
}

/// Reads the bundle whose `dmesh.json` lies in `folder`. Only what drawing needs is read: the references, not `dmesh.glb` and the shaders.
///
/// # Errors
/// Where a file is missing or not as it should be; paths that leave the folder are refused.
pub fn read(folder: &Path, files: &(dyn Files + Sync), limits: &Limits) -> Result<Bundle, DmeshError> {
    let path = folder.join(NAME);
    let text = load(&path, files)?;
    let manifest = Manifest::parse((*text).as_ref())?;
    let blending = manifest.blending.blending().map_err(|what| DmeshError::invalid(NAME, what))?;
    let references = manifest.references.par_iter().map(|row| reference(folder, row, files, limits));
    let dmesh = Dmesh {
        references: references.collect::<Result<_, DmeshError>>()?,
        epsilon: manifest.epsilon,
        diagonal: manifest.diagonal,
        double_sided: manifest.double_sided,
    };
    dmesh.check()?;
    let frames = manifest.view_dependent.as_ref().map(|how| -> Result<Frames, DmeshError> {
        let depths = manifest.references.iter().map(|row| depth(folder, row, files));
        Ok(Frames { tau: how.tau, options: how.hierarchy.clone(), depths: depths.collect::<Result<_, _>>()? })
    });
    let frames = frames.transpose()?;
    if let Some(frames) = &frames {
        frames.check(&dmesh)?;
    }
    Ok(Bundle { dmesh, blending, frames })
}

/// The depth image of a reference, of as many pixels as its camera has.
fn depth(folder: &Path, row: &Row, files: &dyn Files) -> Result<Array<f32>, DmeshError> {
    let bad = |what: String| DmeshError::invalid(format!("{NAME}: reference `{}`", row.name), what);
    let name = row.depth.as_ref().ok_or_else(|| bad("no depth image, which view_dependent needs".into()))?;
    let bytes = load(&inside(folder, name)?, files)?;
    let bytes: &[u8] = (*bytes).as_ref();
    let expected = u64::from(row.camera.width) * u64::from(row.camera.height) * 4;
    if bytes.len() as u64 != expected {
        return Err(bad(format!("`{name}` has {} bytes; expected {expected}", bytes.len())));
    }
    Ok(bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
}

/// The path of a file of the bundle.
fn inside(folder: &Path, name: &str) -> Result<PathBuf, DmeshError> {
    bundle::inside(folder, name).map_err(|what| DmeshError::invalid(NAME, what))
}

fn reference(folder: &Path, row: &Row, files: &(dyn Files + Sync), limits: &Limits) -> Result<Reference, DmeshError> {
    let bad = |what: String| DmeshError::invalid(format!("{NAME}: reference `{}`", row.name), what);
    let view = row.camera.view().map_err(bad)?;
    let path = inside(folder, &row.glb)?;
    let bytes = load(&path, files)?;
    let scene = from_glb(&path, bytes.clone(), limits)?;
    let normal_map = match &row.normals {
        Some(name) => {
            let path = inside(folder, name)?;
            let bytes = load(&path, files)?;
            Some(Arc::new(image_from_bytes(&path, (*bytes).as_ref(), limits)?))
        }
        None => None,
    };
    let parts: Vec<_> = scene.objects.iter().flat_map(|o| &o.parts).collect();
    let (mesh, color) = match parts[..] {
        [] => {
            let texels = vec![[255; 4]].into();
            (Mesh::default(), Arc::new(Image { name: String::new(), width: 1, height: 1, texels }))
        }
        [part] => {
            let glb = |what: &str| DmeshError::invalid(path.display().to_string(), what);
            if scene.objects[0].transform != glam::Mat4::IDENTITY {
                return Err(glb("its mesh is moved; expected world coordinates"));
            }
            let texture = part.material.base_color_texture.as_ref();
            let color = texture.ok_or_else(|| glb("no base colour texture; expected the reference's picture"))?;
            let mesh = Mesh {
                positions: part.mesh.positions.clone(),
                normals: part.mesh.normals.clone(),
                quality: scalars_from_glb(&path, bytes, QUALITY, limits)?.into(),
                uv: part.mesh.uv[0].clone(),
                triangles: part.mesh.triangles.clone(),
            };
            (mesh, color.image.clone())
        }
        _ => {
            let what = format!("{} meshes; expected one", parts.len());
            return Err(DmeshError::invalid(path.display().to_string(), what));
        }
    };
    if mesh.triangles.len() as u64 != row.triangles {
        return Err(bad(format!("{} triangles; the manifest says {}", mesh.triangles.len(), row.triangles)));
    }
    Ok(Reference { name: row.name.clone(), view, mesh: Arc::new(mesh), color, normal_map })
}
