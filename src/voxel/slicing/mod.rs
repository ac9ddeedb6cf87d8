//! The voxel field that a cell sees (Jeschke and Wimmer 2002, sections 4.1 and 4.2).
//!
//! Meaning: each layer holds what is seen from the cell's centre between its two borders; backs of single-sided materials
//! only where some point of the cell sees their front. A pixel is
//! filled where one of its samples is covered, or where a surface passes from this layer to a neighbouring one: the
//! cuts along both borders are drawn conservatively, so that a continuous surface is never cut between layers. Hidden
//! voxels are then removed (see [`hidden`]).
//!
//! How: the samples of all layers are the fragments of one view whose pixels are the samples (`samples.rs`), the cuts are
//! drawn on their own (`cuts.rs`); both give bits of rows of pixels. From near to far these become a layer's mask, what is hidden
//! is removed, and what is left is listed as voxels. A second time over the fragments colours them (`paint.rs`). Of the fragments
//! themselves nothing is stored but for a tile at a time.

mod cuts;
mod groups;
pub mod hidden;
pub mod mask;
mod paint;
mod samples;
mod skirt;

#[cfg(test)]
mod literal;

use super::{Cell, Field, Frustum, Slices, Voxel};
use crate::{
    array::Array,
    math::{Stop, Stopped},
    raster::{Backend, Cutout, Geometry, Options, Prepared, Shader, Sides, faces_any},
    scene::Scene,
    view::{Projection, View},
};
use cuts::{Crossings, Screen};
use glam::DVec3;
use hidden::Hidden;

/// The triangles of a scene in world space, relative to the cell's centre. Materials that are all hole are left out, and so are
/// triangles of single-sided materials that show their back to the whole cell.
pub struct Soup {
    /// Corners in the order of the mesh's indices.
    pub corners: Vec<[DVec3; 3]>,
    /// Number of each in the [`Geometry`].
    pub numbers: Vec<u32>,
}

impl Soup {
    pub fn new(geometry: &Geometry, cell: &Cell) -> Self {
        let (centre, from) = (cell.centre, cell.corners());
        let (mut corners, mut numbers) = (Vec::new(), Vec::new());
        for d in geometry.draws().iter().filter(|d| d.cutout != Cutout::Hidden) {
            for t in 0..d.mesh.triangles.len() as u32 {
                let [a, b, c] = d.corners(t);
                let front = if d.mirrored { [a, c, b] } else { [a, b, c] };
                if d.material.double_sided || faces_any(&front, &from) {
                    corners.push([a - centre, b - centre, c - centre]);
                    numbers.push(d.first + t);
                }
            }
        }
        Self { corners, numbers }
    }
}

/// What a frustum sees.
struct Face<'a> {
    soup: &'a Soup,
    borders: &'a [f64],
    screen: Screen,
    /// Samples along a pixel's side: 1, 2 or 4.
    samples: u32,
    /// The view whose pixels are the samples.
    prepared: Prepared<'a>,
    crossings: Crossings,
}

impl<'a> Face<'a> {
    fn new(
        geometry: &'a Geometry,
        soup: &'a Soup,
        slices: &'a Slices,
        frustum: &Frustum,
        samples: u32,
        stop: &Stop,
    ) -> Result<Self, Stopped> {
        let screen = Screen::new(frustum);
        let view = sample_view(slices, frustum, samples);
        Ok(Self {
            soup,
            borders: &slices.borders,
            samples,
            prepared: Prepared::new(geometry, &view, &facing(slices), stop)?,
            crossings: Crossings::new(soup, slices, &screen, stop)?,
            screen,
        })
    }

    /// The samples of a pixel, row by row.
    fn samples_of(&self, x: u32, y: u32) -> impl Iterator<Item = [u32; 2]> {
        let n = self.samples;
        (0..n * n).map(move |i| [x * n + i % n, y * n + i / n])
    }
}

/// What the cell sees: no backs of single-sided materials, unless some point of the cell sees their front.
fn facing(slices: &Slices) -> Options {
    Options { sides: Sides::FacingAny(slices.cell.corners()) }
}

/// The view whose pixels are the samples of a frustum, from the nearest border on.
fn sample_view(slices: &Slices, frustum: &Frustum, samples: u32) -> View {
    View {
        eye: slices.cell.centre,
        right: frustum.right,
        up: frustum.up,
        forward: frustum.forward,
        projection: Projection::Perspective {
            left: frustum.left,
            right: frustum.right_tan,
            bottom: frustum.bottom,
            top: frustum.top,
        },
        width: frustum.size[0] * samples,
        height: frustum.size[1] * samples,
        near: slices.borders[0],
        far: f64::INFINITY,
    }
}

/// How finely a field is sampled, and how far it goes on.
#[derive(Clone, Copy, Debug)]
pub struct Fineness {
    /// Colour and fill samples along a pixel's side: 1, 2 or 4; an image's width and height times this may not exceed
    /// [`crate::raster::MAX_SIDE`].
    pub samples: u32,
    /// Pixels beside a visible voxel in which hidden ones are kept.
    pub skirt: u32,
    /// Whether the quarters of voxels have their own colours; that takes two samples along a pixel's side.
    pub quarters: bool,
}

/// The visible voxels of every frustum, in their order. `soup` holds the scene's triangles relative to the cell's centre.
pub fn slice(
    backend: &dyn Backend,
    scene: &Scene,
    geometry: &Geometry,
    soup: &Soup,
    slices: &Slices,
    fineness: Fineness,
    stop: &Stop,
) -> Result<Vec<Field>, Stopped> {
    let Fineness { samples, skirt, quarters } = fineness;
    let faces = slices.frusta.iter().map(|f| Face::new(geometry, soup, slices, f, samples, stop));
    let faces: Vec<Face> = faces.collect::<Result<_, _>>()?;
    let voxels = visible(backend, slices, &faces, skirt, stop)?;
    let shader = Shader::new(geometry);
    let mut fields = Vec::new();
    for (((i, face), frustum), mut voxels) in (0..).zip(&faces).zip(&slices.frusta).zip(voxels) {
        skirt::keep_reached(&mut voxels, frustum.size, skirt);
        let quarters = paint::paint(backend, face, &shader, &mut voxels, quarters, stop)?;
        fields.push(Field { quarters: quarters.into(), ..field(scene, i, voxels) });
    }
    Ok(fields)
}

/// The voxels of every face to keep, sorted, without colour, and without the rings of those that are hidden.
fn visible(
    backend: &dyn Backend,
    slices: &Slices,
    faces: &[Face],
    skirt: u32,
    stop: &Stop,
) -> Result<Vec<Vec<Voxel>>, Stopped> {
    let mut parts = Vec::with_capacity(faces.len());
    for face in faces {
        parts.push((samples::parts(backend, face, stop)?, face.cut_parts(stop)?));
    }
    let mut taken = vec![0; faces.len()];
    let mut hidden = Hidden::new(&slices.frusta, skirt);
    let mut voxels = vec![Vec::new(); faces.len()];
    for layer in 0..slices.layers.len() {
        stop.check()?;
        for (frustum, ((samples, cuts), taken)) in parts.iter().zip(&mut taken).enumerate() {
            let here = samples[*taken..].partition_point(|p| usize::from(p.layer) == layer);
            hidden.fill(frustum, &samples[*taken..*taken + here]);
            *taken += here;
            // The borders in front of the layer and behind it.
            hidden.fill(frustum, cuts[layer..].iter().take(2).flatten());
        }
        for (voxels, mut kept) in voxels.iter_mut().zip(hidden.step(layer as u16)) {
            voxels.append(&mut kept);
        }
    }
    Ok(voxels)
}

/// Names only the objects that are seen.
fn field(scene: &Scene, frustum: u32, mut voxels: Vec<Voxel>) -> Field {
    let mut number = vec![u32::MAX; scene.objects.len()];
    for v in &voxels {
        number[v.object as usize] = 0;
    }
    let mut objects = Vec::new();
    for (object, number) in scene.objects.iter().zip(&mut number) {
        if *number == 0 {
            *number = objects.len() as u32;
            objects.push(object.name.clone());
        }
    }
    for v in &mut voxels {
        v.object = number[v.object as usize];
    }
    Field { frustum, voxels: voxels.into(), quarters: Array::default(), objects }
}
