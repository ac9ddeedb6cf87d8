//! Textures for a mesh from its voxels (Jeschke and Wimmer 2002, sections 7 and 8).
//!
//! [`charts`] cuts the mesh into pieces, [`grid`] says which face owns a texel, [`place`] where a texel lies in voxel
//! space, [`colour`] how it looks, [`holes`] which texels alpha must not cut. The colours come from the mesh's own voxels only (the paper searches the whole
//! field at borders): so an element's texture depends on nothing but that element, and what lies behind its outline
//! does not bleed in.
//!
//! Always: every texel has a colour; charts do not share texels; equal vertices have equal positions, bit for bit,
//! in whatever chart they are.

pub mod charts;
pub mod colour;
pub mod grid;
pub mod holes;
pub mod place;
pub mod rays;

use super::{
    Slices, VoxelMesh,
    columns::Columns,
    outline::{Image, Outline},
    reproject::{MisfitError, Reprojection},
};
use crate::{
    math::{Stop, Stopped},
    mesh::ChartedMesh,
};
use charts::Chart;
use colour::Source;
use glam::DVec2;
use grid::Texel;
use place::Space;
use rayon::prelude::*;
use rays::Sight;

/// How texels are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Nearest voxels averaged per texel, 1 to [`super::lattice::MOST`].
    pub n: usize,
    /// Side of a texel in voxel sides, 0.125 to 8.
    pub texel: f64,
    /// Texels of a chart around its faces, at least 2.
    pub margin: u32,
    /// Largest side of a chart in texels, margins included, at least 16.
    pub max_size: u32,
    /// Whether to make a normal map too.
    pub normals: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { n: 4, texel: 1.0, margin: 2, max_size: 4088, normals: false }
    }
}

#[derive(Debug, thiserror::Error)]
pub enum ResampleError {
    #[error(transparent)]
    Misfit(#[from] MisfitError),
    #[error("the cell reaches {az} m towards the near border at {near} m: nothing between them can be bounded")]
    Near { near: f64, az: f64 },
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// The method's own bound on displacements seen from the cell, in pixels: 1 + g·factor with g = near/(near − az).
pub fn bound_px(slices: &Slices, mesh: &VoxelMesh) -> Result<f64, ResampleError> {
    let map = Reprojection::of(slices, mesh)?;
    let near = slices.borders.first().copied().unwrap_or(0.0);
    let az = slices.cell.half.dot(map.frustum().forward.abs());
    if near <= az {
        return Err(ResampleError::Near { near, az });
    }
    Ok(1.0 + near / (near - az) * mesh.factor)
}

/// The mesh in world space, textured.
pub fn resample(
    mesh: &VoxelMesh,
    slices: &Slices,
    settings: &Settings,
    stop: &Stop,
) -> Result<ChartedMesh, ResampleError> {
    let map = Reprojection::of(slices, mesh)?;
    let bound_px = bound_px(slices, mesh)?;
    let space = Space::new(mesh, map);
    let margin = settings.margin.max(2);
    let charts = charts::cut(&space, 1.0 / settings.texel, margin, settings.max_size.max(16), stop)?;
    let frustum = space.map.frustum();
    let image = Image { size: frustum.size, goes_on: frustum.across.map(|a| a.is_some()) };
    let columns = Columns::new(&mesh.voxels, 0..mesh.voxels.len() as u32);
    let outline = mesh.alpha.then(|| Outline::new(&columns, Some(image)));
    let from = Sources { nearest: Source::new(&mesh.voxels), columns, outline };
    let mut textures: Vec<Texture> = charts
        .par_iter()
        .map(|chart| texture(&space, chart, &from, settings, margin, stop))
        .collect::<Result<_, Stopped>>()?;
    if let Some(outline) = &from.outline {
        holes::close(&space, &charts, outline, &mut textures, margin, stop)?;
    }
    Ok(assemble(&space, &charts, textures, margin, settings.normals, bound_px))
}

/// The mesh's voxels: by pixel, and by distance for what no ray meets.
struct Sources<'a> {
    columns: Columns<'a>,
    nearest: Source<'a>,
    /// Where alpha cuts outlines.
    outline: Option<Outline>,
}

/// A chart's texels, row by row.
struct Texture {
    width: usize,
    color: Vec<[u8; 4]>,
    normal: Vec<[u8; 4]>,
}

/// First texel and size of a chart's rectangle with its margin.
fn frame(chart: &Chart, margin: u32) -> (Texel, Texel) {
    let (a, size) = chart.grid.rectangle();
    let m = margin as i32;
    (a.map(|a| a - m), size.map(|s| s + 2 * m))
}

fn texture(
    space: &Space,
    chart: &Chart,
    from: &Sources,
    settings: &Settings,
    margin: u32,
    stop: &Stop,
) -> Result<Texture, Stopped> {
    let (origin, size) = frame(chart, margin);
    // Owned texels are looked up; the others take the colour of the nearest of those.
    let sight = Sight::new(space, chart, &from.columns);
    let width = size[0] as usize;
    let weight = chart.axis.weight();
    let mut texels = vec![Looked::default(); width * size[1] as usize];
    texels.par_chunks_mut(width).enumerate().try_for_each(|(y, row)| {
        stop.check()?;
        let mut seen = Vec::new();
        for (x, texel) in row.iter_mut().enumerate() {
            let at = [origin[0] + x as i32, origin[1] + y as i32];
            let Some((face, _)) = chart.grid.owner(at) else { continue };
            let p = space.place(face, &chart.triangle(space, face), grid::centre(at));
            sight.seen(p, settings.n > 1, &mut seen);
            let (mut color, normal) = if seen.is_empty() {
                from.nearest.sample(p, weight, settings.n)
            } else {
                colour::mix(seen.iter().map(|(weight, seen)| (*weight, seen.voxel(space.mesh))))
            };
            if let Some(outline) = &from.outline {
                color[3] = outline.filtered(&from.columns, p, space.mesh.factor + 0.5);
            }
            let c = ((normal + 1.0) * 127.5).round();
            *texel = Looked { known: true, color, normal: [c.x as u8, c.y as u8, c.z as u8, 255] };
        }
        Ok(())
    })?;
    let nearest = nearest_known(&texels.iter().map(|t| t.known).collect::<Vec<_>>(), width);
    let color = nearest.iter().map(|i| texels[*i as usize].color).collect();
    let normal =
        if settings.normals { nearest.iter().map(|i| texels[*i as usize].normal).collect() } else { Vec::new() };
    Ok(Texture { width, color, normal })
}

/// A texel whose colour was looked up, or will be continued from others.
#[derive(Clone, Copy, Default)]
struct Looked {
    known: bool,
    color: [u8; 4],
    normal: [u8; 4],
}

/// For each texel the number of a known one near it: itself where known, else the nearest by propagation of
/// neighbours in two sweeps (exact up to a fraction of a texel). Any number where nothing is known.
pub fn nearest_known(known: &[bool], width: usize) -> Vec<u32> {
    const FAR: u32 = u32::MAX;
    let height = known.len() / width.max(1);
    let mut source: Vec<u32> = (0..known.len()).map(|i| if known[i] { i as u32 } else { FAR }).collect();
    let away = |at: usize, from: u32| {
        let (dx, dy) = ((at % width).abs_diff(from as usize % width), (at / width).abs_diff(from as usize / width));
        dx * dx + dy * dy
    };
    let mut take = |at: usize, x: usize, y: usize, from: [(isize, isize); 4]| {
        if known[at] {
            return;
        }
        for (dx, dy) in from {
            let (Some(nx), Some(ny)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else { continue };
            if nx >= width || ny >= height {
                continue;
            }
            let candidate = source[ny * width + nx];
            if candidate != FAR && (source[at] == FAR || away(at, candidate) < away(at, source[at])) {
                source[at] = candidate;
            }
        }
    };
    for y in 0..height {
        for x in 0..width {
            take(y * width + x, x, y, [(-1, 0), (-1, -1), (0, -1), (1, -1)]);
        }
        for x in (0..width).rev() {
            take(y * width + x, x, y, [(1, 0), (1, -1), (0, -1), (-1, -1)]);
        }
    }
    for y in (0..height).rev() {
        for x in (0..width).rev() {
            take(y * width + x, x, y, [(1, 0), (1, 1), (0, 1), (-1, 1)]);
        }
        for x in 0..width {
            take(y * width + x, x, y, [(-1, 0), (-1, 1), (0, 1), (1, 1)]);
        }
    }
    source.iter().map(|s| if *s == FAR { 0 } else { *s }).collect()
}

fn assemble(
    space: &Space,
    charts: &[Chart],
    textures: Vec<Texture>,
    margin: u32,
    normals: bool,
    bound_px: f64,
) -> ChartedMesh {
    let mesh = space.mesh;
    let world_origin = space.map.origin();
    let (mut positions, mut uv, mut triangles, mut chart_of) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut chart_size = Vec::new();
    // (chart, number) of each vertex's latest copy.
    let mut copy = vec![(u32::MAX, 0u32); mesh.vertices.len()];
    for (number, chart) in charts.iter().enumerate() {
        let (origin, size) = frame(chart, margin);
        let origin = DVec2::new(f64::from(origin[0]), f64::from(origin[1]));
        chart_size.push(size.map(|s| s as u32));
        let mut faces = chart.faces.clone();
        faces.sort_unstable();
        for f in faces {
            triangles.push(mesh.faces[f as usize].map(|v| {
                let known = &mut copy[v as usize];
                if known.0 != number as u32 {
                    *known = (number as u32, positions.len() as u32);
                    positions.push((space.map.world(mesh.vertices[v as usize]) - world_origin).as_vec3().to_array());
                    uv.push((chart.uv(space, v) - origin).as_vec2().to_array());
                }
                known.1
            }));
            chart_of.push(number as u32);
        }
    }
    let (mut color, mut normal) = (Vec::new(), Vec::new());
    for t in textures {
        color.extend(t.color);
        if normals {
            normal.extend(t.normal);
        }
    }
    ChartedMesh {
        origin: world_origin.to_array(),
        positions: positions.into(),
        uv: uv.into(),
        triangles: triangles.into(),
        chart_of: chart_of.into(),
        chart_size: chart_size.into(),
        color: color.into(),
        normal: normal.into(),
        bound_px,
    }
}

#[cfg(test)]
mod tests;
