//! What bundles of several methods have in common: their files, the shaders that they ship, the row of a camera, and reading by relative path.

use crate::{
    array::Bytes,
    formats::{Files, FormatError},
    view::{Projection, View},
};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::{
    collections::BTreeMap,
    path::{Component, Path, PathBuf},
};

/// A file of a bundle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BundleFile {
    /// Relative, with `/` between folders.
    pub path: String,
    /// Media type.
    pub media: &'static str,
    pub bytes: Vec<u8>,
}

/// A shader file of a bundle.
#[derive(Clone, Copy, Debug)]
pub struct ShaderFile {
    pub name: &'static str,
    /// Its language, as the manifest names it.
    pub language: &'static str,
    pub media: &'static str,
    pub bytes: &'static [u8],
}

impl ShaderFile {
    pub(super) const fn wgsl(name: &'static str, text: &'static str) -> Self {
        Self { name, language: "wgsl", media: "text/wgsl", bytes: text.as_bytes() }
    }

    pub(super) const fn glsl(name: &'static str, bytes: &'static [u8]) -> Self {
        Self { name, language: "glsl", media: "text/x-glsl", bytes }
    }

    pub(super) const fn hlsl(name: &'static str, bytes: &'static [u8]) -> Self {
        Self { name, language: "hlsl", media: "text/x-hlsl", bytes }
    }

    pub(super) const fn metal(name: &'static str, bytes: &'static [u8]) -> Self {
        Self { name, language: "metal", media: "text/x-metal", bytes }
    }

    pub(super) const fn spirv(name: &'static str, bytes: &'static [u8]) -> Self {
        Self { name, language: "spirv", media: "application/octet-stream", bytes }
    }
}

/// The names of shaders by language, as manifests list them.
pub fn shader_names(shaders: &[ShaderFile]) -> BTreeMap<String, Vec<String>> {
    let mut names = BTreeMap::<String, Vec<String>>::new();
    for s in shaders {
        names.entry(s.language.into()).or_default().push(s.name.into());
    }
    names
}

/// Shaders as files of a bundle.
pub fn shader_files(shaders: &[ShaderFile]) -> impl Iterator<Item = BundleFile> {
    shaders.iter().map(|s| BundleFile { path: s.name.into(), media: s.media, bytes: s.bytes.to_vec() })
}

/// The content of a file that a bundle needs.
///
/// # Errors
/// Where it is missing or cannot be read.
pub(super) fn load(path: &Path, files: &dyn Files) -> Result<Bytes, FormatError> {
    files.read(path)?.ok_or_else(|| FormatError::Missing { file: path.to_owned() })
}

/// The path of a file of the bundle in `folder`.
///
/// # Errors
/// What is wrong with `name`, where it leaves the folder or names none.
pub(super) fn inside(folder: &Path, name: &str) -> Result<PathBuf, String> {
    let path = Path::new(name);
    let plain =
        !name.is_empty() && !name.contains('\\') && path.components().all(|c| matches!(c, Component::Normal(_)));
    if plain { Ok(folder.join(path)) } else { Err(format!("`{name}`: expected a path inside the bundle")) }
}

/// A view that captured something; its pixels are the texels of what was captured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    pub eye: [f64; 3],
    /// Orthonormal, right × up = −forward.
    pub right: [f64; 3],
    pub up: [f64; 3],
    pub forward: [f64; 3],
    /// `perspective` or `orthographic`.
    pub projection: String,
    /// Left, right, bottom, top: tangents at depth 1 in perspective, extents otherwise.
    pub window: [f64; 4],
    /// Pixels.
    pub width: u32,
    pub height: u32,
    /// Planar depths between which surfaces were kept.
    pub near: f64,
    pub far: f64,
}

impl Camera {
    pub fn of(v: &View) -> Self {
        let (projection, window) = match v.projection {
            Projection::Perspective { left, right, bottom, top } => ("perspective", [left, right, bottom, top]),
            Projection::Orthographic { left, right, bottom, top } => ("orthographic", [left, right, bottom, top]),
        };
        let [eye, right, up, forward] = [v.eye, v.right, v.up, v.forward].map(|a| a.to_array());
        let (width, height, near, far) = (v.width, v.height, v.near, v.far);
        Self { eye, right, up, forward, projection: projection.into(), window, width, height, near, far }
    }

    pub fn view(&self) -> Result<View, String> {
        let [left, right, bottom, top] = self.window;
        let projection = match self.projection.as_str() {
            "perspective" => Projection::Perspective { left, right, bottom, top },
            "orthographic" => Projection::Orthographic { left, right, bottom, top },
            other => return Err(format!("projection `{other}`; expected `perspective` or `orthographic`")),
        };
        let [eye, right, up, forward] = [self.eye, self.right, self.up, self.forward].map(DVec3::from);
        let (width, height, near, far) = (self.width, self.height, self.near, self.far);
        Ok(View { eye, right, up, forward, projection, width, height, near, far })
    }
}
