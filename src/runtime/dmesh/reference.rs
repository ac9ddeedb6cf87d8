//! The data: reference views with their meshes and pictures.

use super::DmeshError;
use crate::{
    array::Array,
    raster::MAX_SIDE,
    scene::Image,
    view::{Projection, View},
};
use glam::{DVec3, DVec4, Vec3};
use std::sync::Arc;

/// Most references of a DMesh: one bit each in [`super::Drawn::mask`].
pub const MAX_REFERENCES: usize = 64;

/// An object seen from several reference views.
#[derive(Clone, Debug, PartialEq)]
pub struct Dmesh {
    pub references: Vec<Reference>,
    /// How far the meshes may lie from the captured surface, metres, ≥ 0.
    pub epsilon: f64,
    /// Diagonal of the object's bounding box, metres, > 0.
    pub diagonal: f64,
    /// Backs of faces are drawn too.
    pub double_sided: bool,
}

/// One view of the object. Clones share the arrays and pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Unique; letters, digits and `+-_.`.
    pub name: String,
    /// The camera that captured it: its pixels are the picture's texels.
    pub view: View,
    pub mesh: Arc<Mesh>,
    /// Unlit colour, sRGB-encoded; alpha is ignored. Texels without surface should hold the colours of their
    /// neighbours: filtering blends them in at the mesh's border.
    pub color: Arc<Image>,
    /// Normals of the captured surface in world space, n·0.5 + 0.5; without it those of the vertices count.
    pub normal_map: Option<Arc<Image>>,
}

/// A textured triangle mesh in world space. `normals` may be empty; `quality` and `uv` have one element a vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Metres, finite.
    pub positions: Array<[f32; 3]>,
    /// Unit.
    pub normals: Array<[f32; 3]>,
    /// ρ = |n·v| of section 4.2, 0 to 1: how squarely the reference camera saw the vertex.
    pub quality: Array<f32>,
    /// Where the reference camera sees the vertex, in its picture; v down. Within a triangle coordinates follow that camera's
    /// projection: they are affine only where it is orthographic.
    pub uv: Array<[f32; 2]>,
    /// Counter-clockwise seen from the reference camera.
    pub triangles: Array<[u32; 3]>,
}

impl Reference {
    /// t such that t·(x, y, z, 1) is what a texel measures (metres, along its longer side) on a surface through the world point
    /// (x, y, z) that faces the reference camera.
    pub fn texel(&self) -> DVec4 {
        let v = &self.view;
        let longer = |l: f64, r: f64, b: f64, t: f64| ((r - l) / v.width as f64).max((t - b) / v.height as f64);
        match v.projection {
            Projection::Perspective { left, right, bottom, top } => {
                let size = longer(left, right, bottom, top);
                (v.forward * size).extend(-v.forward.dot(v.eye) * size)
            }
            Projection::Orthographic { left, right, bottom, top } => {
                DVec3::ZERO.extend(longer(left, right, bottom, top))
            }
        }
    }
}

impl Dmesh {
    /// Checks what drawing relies on.
    ///
    /// # Errors
    /// Too many references or triangles, repeated or unusable names, arrays of unequal length, vertex numbers beyond the
    /// vertices, numbers that are not finite, cameras or pictures without pixels.
    pub fn check(&self) -> Result<(), DmeshError> {
        let bad = |what: String| Err(DmeshError::invalid("dmesh", what));
        if self.references.len() > MAX_REFERENCES {
            return bad(format!("{} references; expected at most {MAX_REFERENCES}", self.references.len()));
        }
        if !(self.epsilon >= 0.0 && self.epsilon.is_finite()) {
            return bad(format!("epsilon {}; expected a length of at least 0", self.epsilon));
        }
        if !(self.diagonal > 0.0 && self.diagonal.is_finite()) {
            return bad(format!("diagonal {}; expected a length above 0", self.diagonal));
        }
        let mut triangles = 0u64;
        for (i, reference) in self.references.iter().enumerate() {
            let named = |what: String| DmeshError::invalid(format!("reference `{}`", reference.name), what);
            let usable = |c: char| c.is_ascii_alphanumeric() || "+-_.".contains(c);
            let name = &reference.name;
            if name.is_empty() || name.len() > 64 || name.starts_with('.') || !name.chars().all(usable) {
                return Err(named("expected a name of 1 to 64 letters, digits and `+-_.`".into()));
            }
            if self.references[..i].iter().any(|r| r.name.eq_ignore_ascii_case(name)) {
                return Err(named("another reference has this name".into()));
            }
            reference.check().map_err(named)?;
            triangles += reference.mesh.triangles.len() as u64;
        }
        if triangles >= u64::from(u32::MAX) {
            return bad(format!("{triangles} triangles; expected fewer than 2^32 - 1"));
        }
        Ok(())
    }
}

impl Reference {
    fn check(&self) -> Result<(), String> {
        camera(&self.view)?;
        self.mesh.check()?;
        for (what, image) in [("color", Some(&self.color)), ("normal map", self.normal_map.as_ref())] {
            let Some(image) = image else { continue };
            let texels = u64::from(image.width) * u64::from(image.height);
            if texels == 0 || texels != image.texels.len() as u64 {
                let (w, h, n) = (image.width, image.height, image.texels.len());
                return Err(format!("{what}: {n} texels for {w} × {h}"));
            }
        }
        Ok(())
    }
}

impl Mesh {
    fn check(&self) -> Result<(), String> {
        let n = self.positions.len();
        for (what, len) in [("quality", self.quality.len()), ("uv", self.uv.len()), ("normals", self.normals.len())] {
            if len != n && !(what == "normals" && len == 0) {
                return Err(format!("{what}: {len} elements; expected {n}, one a vertex"));
            }
        }
        if let Some(v) = self.triangles.iter().flatten().find(|v| **v as usize >= n) {
            return Err(format!("vertex number {v}; there are {n} vertices"));
        }
        let finite = self.positions.iter().chain(self.normals.iter()).all(|p| Vec3::from(*p).is_finite())
            && self.uv.iter().flatten().all(|x| x.is_finite());
        if !finite {
            return Err("a vertex is not finite".into());
        }
        if let Some(q) = self.quality.iter().find(|q| !(0.0..=1.0).contains(*q)) {
            return Err(format!("quality {q}; expected 0 to 1"));
        }
        Ok(())
    }
}

/// Whether the rasteriser could use the view.
fn camera(v: &View) -> Result<(), String> {
    let axes = [v.right, v.up, v.forward];
    if !v.eye.is_finite() || !axes.iter().all(|a| (a.length() - 1.0).abs() < 1e-6) {
        return Err("camera: expected a finite eye and unit axes".into());
    }
    if axes[0].dot(axes[1]).abs() > 1e-6 || (axes[0].cross(axes[1]) + axes[2]).length() > 1e-5 {
        return Err("camera: expected right × up = −forward".into());
    }
    let (perspective, l, r, b, t) = match v.projection {
        Projection::Perspective { left, right, bottom, top } => (true, left, right, bottom, top),
        Projection::Orthographic { left, right, bottom, top } => (false, left, right, bottom, top),
    };
    let finite = [l, r, b, t, v.near, v.far].iter().all(|x| x.is_finite());
    if !(finite && l < r && b < t && v.near < v.far) || (perspective && v.near <= 0.0) {
        return Err("camera: expected a window and a depth range that are not empty".into());
    }
    if !(1..=MAX_SIDE).contains(&v.width) || !(1..=MAX_SIDE).contains(&v.height) {
        return Err(format!("camera: {} × {} pixels; expected 1 to {MAX_SIDE} a side", v.width, v.height));
    }
    Ok(())
}
