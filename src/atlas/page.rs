//! Charted meshes onto textured pages.
//!
//! Every chart lies in a rectangle aligned to the gutter g (rounded down to a power of two), with g/2 texels of its own
//! border continued on each side. So down to the mip level whose texel is g wide no mip texel mixes two charts, and
//! what bilinear filtering of a face reads there belongs to its own chart.
//!
//! All that lies on one page is one object with one mesh and one material: one draw call, no changes of state, which
//! is what the paper wants an atlas for.

use super::pack::{AtlasSlot, Packing, pack};
use crate::{
    math::{Stop, Stopped},
    mesh::ChartedMesh,
    scene::{Alpha, Image, Material, Mesh, Object, Part, Scene, Texture},
};
use glam::{DVec3, Mat4, Vec3};
use std::sync::Arc;

/// How pages are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Texels between charts.
    pub gutter: u32,
    /// Largest side of a page, a power of two.
    pub max_page: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { gutter: 4, max_page: 4096 }
    }
}

#[derive(Debug, thiserror::Error)]
pub enum AtlasError {
    #[error("there is nothing to pack: the meshes have no triangles")]
    Empty,
    #[error("mesh `{mesh}`: a chart of {width} × {height} texels does not fit on a page of {max} texels a side")]
    TooLarge { mesh: String, width: u32, height: u32, max: u32 },
    #[error("mesh `{mesh}` and mesh `{other}`: one has a normal map, the other none")]
    Normals { mesh: String, other: String },
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl Settings {
    /// What charts are aligned to; mip levels up to log2 of it keep charts apart.
    pub fn alignment(&self) -> u32 {
        1 << self.gutter.max(1).ilog2()
    }
}

/// A chart, as the pages see it.
struct Chart {
    mesh: usize,
    /// Its first texel in the mesh's.
    start: usize,
    size: [u32; 2],
}

/// A scene with one object per page, and the numbers that say how well the pages are used.
#[derive(Clone, Debug)]
pub struct Atlas {
    pub scene: Scene,
    /// Texels of all pages.
    pub texels: u64,
    /// Texels of all charts, margins included.
    pub used: u64,
}

/// Packs named meshes, sorted by name.
pub fn atlas(meshes: &[(&str, &ChartedMesh)], settings: &Settings, stop: &Stop) -> Result<Atlas, AtlasError> {
    let mut charts = Vec::new();
    let mut first = Vec::new();
    for (m, (_, mesh)) in meshes.iter().enumerate() {
        first.push(charts.len());
        let mut start = 0;
        for &size in mesh.chart_size.iter() {
            charts.push(Chart { mesh: m, start, size });
            start += size[0] as usize * size[1] as usize;
        }
    }
    if meshes.iter().all(|(_, m)| m.triangles.is_empty()) {
        return Err(AtlasError::Empty);
    }
    let bare = |m: &ChartedMesh| m.normal.is_empty() && !m.color.is_empty();
    let mapped = meshes.iter().find(|(_, m)| !m.normal.is_empty());
    if let (Some((mesh, _)), Some((other, _))) = (mapped, meshes.iter().find(|(_, m)| bare(m))) {
        return Err(AtlasError::Normals { mesh: (*mesh).into(), other: (*other).into() });
    }
    let step = settings.alignment();
    let padded = |s: u32| s.saturating_add(settings.gutter).div_ceil(step);
    let cells: Vec<[u32; 2]> = charts.iter().map(|c| c.size.map(padded)).collect();
    let packing = pack(&cells, (settings.max_page / step).max(1)).ok_or_else(|| {
        let large = charts.iter().zip(&cells).find(|(_, c)| c.iter().any(|s| s * step > settings.max_page));
        let (mesh, [width, height]) = large.map_or((0, [0; 2]), |(c, _)| (c.mesh, c.size));
        AtlasError::TooLarge { mesh: meshes[mesh].0.into(), width, height, max: settings.max_page }
    })?;
    let pages = Pages { meshes, charts: &charts, first: &first, cells: &cells, packing: &packing, settings };
    let mut objects = Vec::new();
    for page in 0..packing.pages.len() as u32 {
        stop.check()?;
        objects.push(pages.object(page, mapped.is_some(), stop)?);
    }
    let area = |s: &[u32; 2]| u64::from(s[0]) * u64::from(s[1]);
    let texels = packing.pages.iter().map(area).sum::<u64>() * u64::from(step) * u64::from(step);
    let used = charts.iter().map(|c| area(&c.size)).sum();
    Ok(Atlas { scene: Scene { objects }, texels, used })
}

struct Pages<'a> {
    meshes: &'a [(&'a str, &'a ChartedMesh)],
    charts: &'a [Chart],
    /// First chart of each mesh.
    first: &'a [usize],
    cells: &'a [[u32; 2]],
    packing: &'a Packing,
    settings: &'a Settings,
}

impl Pages<'_> {
    fn size(&self, page: u32) -> [u32; 2] {
        self.packing.pages[page as usize].map(|s| s * self.settings.alignment())
    }

    /// Top left texel of a chart's aligned rectangle.
    fn corner(&self, p: AtlasSlot) -> [u32; 2] {
        [p.x, p.y].map(|c| c * self.settings.alignment())
    }

    fn object(&self, page: u32, normals: bool, stop: &Stop) -> Result<Object, Stopped> {
        let name = format!("page {page:02}");
        let frames = if normals { self.frames(page) } else { Vec::new() };
        let image = |name: String, texels: Vec<[u8; 4]>| {
            let [width, height] = self.size(page);
            Texture::clamped(Arc::new(Image { name, width, height, texels: texels.into() }))
        };
        let color = self.texels(page, stop, |_, mesh, i| mesh.color[i])?;
        let cut = color.iter().any(|t| t[3] < 255);
        let normal = if normals {
            let flat = self.texels(page, stop, |chart, mesh, i| tangent_space(&frames[chart], mesh.normal[i]))?;
            Some(image(format!("{name} normals"), flat))
        } else {
            None
        };
        let material = Material {
            name: name.clone(),
            base_color_texture: Some(image(name.clone(), color)),
            metallic: 0.0,
            roughness: 1.0,
            unlit: normal.is_none(),
            normal_texture: normal,
            alpha: if cut { Alpha::Mask { cutoff: 0.5 } } else { Alpha::Opaque },
            // From the cell's corners the back of a steep face can be seen, and its colours are right there too.
            double_sided: true,
            ..Material::default()
        };
        let mesh = Arc::new(self.mesh(page, &frames));
        let parts = vec![Part { mesh, material: Arc::new(material) }];
        Ok(Object { name, transform: Mat4::from_translation(self.origin().as_vec3()), parts })
    }

    /// What all pages' positions are relative to.
    fn origin(&self) -> DVec3 {
        self.meshes.first().map_or(DVec3::ZERO, |(_, mesh)| DVec3::from(mesh.origin))
    }

    /// All triangles whose chart lies on the page, by mesh, texture coordinates in the page.
    fn mesh(&self, page: u32, frames: &[TangentFrame]) -> Mesh {
        let [width, height] = self.size(page).map(|s| s as f32);
        let (mut positions, mut uv, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
        let (mut vertex_normals, mut tangents) = (Vec::new(), Vec::new());
        for ((_, mesh), first) in self.meshes.iter().zip(self.first) {
            let mut copy = vec![u32::MAX; mesh.positions.len()];
            // Zero for meshes of one cell.
            let offset = (DVec3::from(mesh.origin) - self.origin()).as_vec3();
            for (t, chart) in mesh.triangles.iter().zip(mesh.chart_of.iter()) {
                let chart = first + *chart as usize;
                let place = self.packing.places[chart];
                if place.page != page {
                    continue;
                }
                let pad = self.settings.gutter / 2;
                let [x, y] = self.corner(place).map(|c| (c + pad) as f32);
                triangles.push(t.map(|v| {
                    let known = &mut copy[v as usize];
                    if *known == u32::MAX {
                        *known = positions.len() as u32;
                        let at = mesh.uv[v as usize];
                        positions.push((Vec3::from(mesh.positions[v as usize]) + offset).to_array());
                        uv.push([(at[0] + x) / width, (at[1] + y) / height]);
                        if let Some(frame) = frames.get(chart) {
                            vertex_normals.push(frame.normal.to_array());
                            tangents.push(frame.tangent.extend(1.0).to_array());
                        }
                    }
                    *known
                }));
            }
        }
        Mesh {
            positions: positions.into(),
            normals: vertex_normals.into(),
            tangents: tangents.into(),
            uv: [uv.into(), Vec::new().into()],
            triangles: triangles.into(),
            ..Mesh::default()
        }
    }

    /// The page's texels: every chart with its border continued to the edges of its aligned rectangle; elsewhere the
    /// charts' mean, so that the highest mip levels do not darken.
    fn texels(
        &self,
        page: u32,
        stop: &Stop,
        texel: impl Fn(usize, &ChartedMesh, usize) -> [u8; 4],
    ) -> Result<Vec<[u8; 4]>, Stopped> {
        let [width, height] = self.size(page);
        let mut sum = [0u64; 4];
        let on_page = |c: &usize| self.packing.places[*c].page == page;
        let mut out = vec![None; width as usize * height as usize];
        for c in (0..self.charts.len()).filter(on_page) {
            stop.check()?;
            let chart = &self.charts[c];
            let mesh = self.meshes[chart.mesh].1;
            let [left, top] = self.corner(self.packing.places[c]);
            let [w, h] = self.cells[c].map(|s| s * self.settings.alignment());
            let inner = |at: u32, size: u32| at.saturating_sub(self.settings.gutter / 2).min(size - 1);
            for y in 0..h {
                let row = chart.start + inner(y, chart.size[1]) as usize * chart.size[0] as usize;
                let to = (top + y) as usize * width as usize + left as usize;
                for x in 0..w {
                    let t = texel(c, mesh, row + inner(x, chart.size[0]) as usize);
                    out[to + x as usize] = Some(t);
                    for k in 0..4 {
                        sum[k] += u64::from(t[k]);
                    }
                }
            }
        }
        let filled = out.iter().flatten().count().max(1) as u64;
        let mean = sum.map(|s| (s / filled) as u8);
        Ok(out.into_iter().map(|t| t.unwrap_or(mean)).collect())
    }

    /// The tangent frames of all charts; only those on the page are looked at.
    fn frames(&self, page: u32) -> Vec<TangentFrame> {
        let all = self.charts.iter().zip(&self.packing.places);
        all.map(|(chart, place)| {
            let texels = chart.size[0] as usize * chart.size[1] as usize;
            let normals = &self.meshes[chart.mesh].1.normal[chart.start..chart.start + texels];
            if place.page == page { TangentFrame::new(normals) } else { TangentFrame::new(&[]) }
        })
        .collect()
    }
}

/// A chart's tangent frame: glTF's bitangent is normal × tangent.
struct TangentFrame {
    normal: Vec3,
    tangent: Vec3,
}

fn unpacked(n: [u8; 4]) -> Vec3 {
    Vec3::new(f32::from(n[0]), f32::from(n[1]), f32::from(n[2])) / 127.5 - 1.0
}

impl TangentFrame {
    /// The frame whose normal is the mean of world-space normals.
    fn new(normals: &[[u8; 4]]) -> Self {
        let mut sum = [0u64; 3];
        for n in normals {
            for k in 0..3 {
                sum[k] += u64::from(n[k]);
            }
        }
        let mean = glam::DVec3::from(sum.map(|s| s as f64 / normals.len().max(1) as f64 / 127.5 - 1.0));
        let normal = mean.try_normalize().unwrap_or(glam::DVec3::Z).as_vec3();
        let a = normal.abs();
        let least = if a.x <= a.y && a.x <= a.z {
            Vec3::X
        } else if a.y <= a.z {
            Vec3::Y
        } else {
            Vec3::Z
        };
        Self { normal, tangent: (least - normal * normal.dot(least)).normalize() }
    }
}

/// A world-space normal as a texel of glTF's normal texture, whose blue is never below the middle.
fn tangent_space(frame: &TangentFrame, world: [u8; 4]) -> [u8; 4] {
    let n = unpacked(world);
    let bitangent = frame.normal.cross(frame.tangent);
    let local = Vec3::new(n.dot(frame.tangent), n.dot(bitangent), n.dot(frame.normal).max(0.05));
    let c = ((local.normalize() + 1.0) * 127.5).round();
    [c.x as u8, c.y as u8, c.z as u8, 255]
}

#[cfg(test)]
mod tests;
