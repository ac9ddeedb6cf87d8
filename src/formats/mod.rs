//! Readers and writers of the outside world's files: glTF, OBJ, PLY, scene TOML; EXR is written only.
//!
//! What always holds: a reader given any bytes returns a scene that keeps the promises of [`crate::scene`], or an error
//! that names file and place; it never panics, and never allocates what a number in the file only claims. Every file
//! is read through [`Files`]. Objects are named by their path in the file.

mod appearance;
mod colors;
mod error;
pub mod exr;
mod files;
pub mod glb;
mod gltf;
mod limits;
mod loader;
mod mesh;
mod obj;
mod picture;
mod ply;
mod polygon;
mod probe;
mod scene_toml;
#[cfg(test)]
mod tests;
mod text;
mod weld;

pub use error::FormatError;
pub use files::{DiskFiles, Files, real};
pub use glb::{GlbOptions, Scalars, write_glb, write_glb_with};
pub use limits::Limits;
pub use loader::DECODING;
pub use probe::probe;

use crate::{
    math::Stop,
    scene::{Image, Scene, names},
};
use loader::Loader;
use std::path::Path;

/// The scene that the file at `path` describes, by its extension: `.glb`, `.gltf`, `.obj`, `.ply` or `.toml`.
pub fn load(path: &Path, files: &dyn Files, limits: &Limits) -> Result<Scene, FormatError> {
    load_with(path, files, limits, &Stop::default(), &mut |_| {})
}

/// [`load`] that can be stopped, and that hands what the file holds but a scene cannot to `warn`.
pub fn load_with(
    path: &Path,
    files: &dyn Files,
    limits: &Limits,
    stop: &Stop,
    warn: &mut dyn FnMut(String),
) -> Result<Scene, FormatError> {
    let mut loader = Loader::new(path, files, limits, stop, warn);
    let objects = loader.objects(path);
    loader.tell();
    let objects = objects?;
    Ok(names::assemble(objects))
}

/// The scene that a GLB in memory describes; it can name no other files. `name` stands for it in errors.
pub fn from_glb(name: &Path, bytes: crate::array::Bytes, limits: &Limits) -> Result<Scene, FormatError> {
    let stop = Stop::default();
    let mut ignore = |_| {};
    let mut loader = Loader::new(name, &files::NoFiles, limits, &stop, &mut ignore);
    Ok(names::assemble(gltf::read(&mut loader, name, bytes)?))
}

/// An attribute of one number a vertex (see [`Scalars`]) of the first mesh of a GLB in memory; empty where it has no mesh.
pub fn scalars_from_glb(
    name: &Path,
    bytes: crate::array::Bytes,
    attribute: &str,
    limits: &Limits,
) -> Result<Vec<f32>, FormatError> {
    let stop = Stop::default();
    let mut ignore = |_| {};
    let mut loader = Loader::new(name, &files::NoFiles, limits, &stop, &mut ignore);
    gltf::scalars(&mut loader, name, bytes, attribute)
}

/// A PNG, JPEG or WebP file in memory; `name` stands for it in errors.
pub fn image_from_bytes(name: &Path, bytes: &[u8], limits: &Limits) -> Result<Image, FormatError> {
    let bad = |what: String| FormatError::invalid(name, "image", what);
    let claim = picture::claim(bytes).map_err(bad)?;
    if claim.texels() > limits.texels {
        let place = format!("{} × {}", claim.width, claim.height);
        let (found, limit) = (claim.texels(), limits.texels);
        return Err(FormatError::Limit { file: name.to_owned(), place, what: "texels", found, limit });
    }
    picture::decode(bytes, "", limits.bytes).map_err(bad)
}
