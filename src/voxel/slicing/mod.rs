//! The voxel field that a cell sees (Jeschke and Wimmer 2002, sections 4.1 and 4.2).
//!
//! Meaning: each layer holds what is seen from the cell's centre between its two borders, back faces too. A pixel is
//! filled where one of its samples is covered, or where a surface passes from this layer to a neighbouring one: the
//! cuts along both borders are drawn conservatively, so that a continuous surface is never cut between layers. Hidden
//! voxels are then removed (see [`hidden`]).
//!
//! How: the geometry is transformed, clipped and snapped once; then batches of layers go from near to far, filling bit
//! masks, removing what is hidden, and colouring only what is left. Nothing but bits is stored per pixel and layer, and
//! only for one batch.

mod band;
pub mod hidden;
pub mod mask;
mod paint;
mod prepare;
mod skirt;
pub mod spans;

#[cfg(test)]
mod literal;

use super::{Field, Slices, Voxel};
use crate::{
    math::{Stop, Stopped},
    raster::{Camera, Geometry, Shader},
    scene::Scene,
};
use band::{Band, Job};
use hidden::{Hidden, Rows};
pub use prepare::Soup;
use prepare::{Prepared, Screen};
use rayon::prelude::*;
use spans::Samples;

/// Bytes that the masks of a batch of layers may take.
const BATCH_BYTES: usize = 192 << 20;

/// The visible voxels of every frustum, in their order. `soup` holds the scene's triangles relative to the cell's centre.
/// `samples`: colour and fill samples along a pixel's side, a power
/// of two; width and height times `samples` may not exceed [`crate::raster::MAX_SIDE`].
pub fn slice(
    scene: &Scene,
    geometry: &Geometry,
    soup: &Soup,
    slices: &Slices,
    samples: u32,
    skirt: u32,
    stop: &Stop,
) -> Result<Vec<Field>, Stopped> {
    let shader = Shader::new(geometry);
    let inverse: Vec<f64> = slices.borders.iter().map(|b| 1.0 / b).collect();
    let mut jobs = Vec::with_capacity(slices.frusta.len());
    let mut bands = Vec::new();
    for (i, f) in slices.frusta.iter().enumerate() {
        let screen = Screen::new(f, slices.borders[0]);
        let prepared = Prepared::new(soup, slices, &screen, stop)?;
        bands.extend(Band::split(i, f.size[1], &prepared.items));
        jobs.push(Job {
            geometry,
            soup,
            prepared,
            screen,
            camera: Camera::new(&prepare::sample_view(slices, f, samples)),
            borders: &slices.borders,
            inverse: &inverse,
            samples: Samples(samples),
            words: mask::Shape::new(f.size[0], f.size[1]).words,
        });
    }

    let layer_bytes: usize = bands.iter().map(|b| b.height() * jobs[b.frustum].words * 8).sum();
    let batch = (BATCH_BYTES / layer_bytes.max(1)).clamp(1, 64);
    let mut hidden = Hidden::new(&slices.frusta, skirt);
    let mut voxels: Vec<Vec<Voxel>> = vec![Vec::new(); slices.frusta.len()];
    for start in (0..slices.layers.len()).step_by(batch) {
        let end = (start + batch).min(slices.layers.len());
        let batch = start as u16..end as u16;
        bands.par_iter_mut().try_for_each(|band| {
            let job = &jobs[band.frustum];
            band.cover(job, batch.clone(), stop)
        })?;
        remove_hidden(&mut hidden, &mut bands, &jobs, end - start, stop)?;
        let painted: Vec<_> = bands
            .par_iter()
            .map(|band| paint::paint(band, &jobs[band.frustum], &shader, &batch, stop))
            .collect::<Result<_, Stopped>>()?;
        for layer in 0..end - start {
            for (band, (found, ends)) in bands.iter().zip(&painted) {
                let from = if layer == 0 { 0 } else { ends[layer - 1] };
                voxels[band.frustum].extend_from_slice(&found[from..ends[layer]]);
            }
        }
    }
    let mut fields = Vec::with_capacity(voxels.len());
    for (i, mut voxels) in voxels.into_iter().enumerate() {
        stop.check()?;
        skirt::keep_reached(&mut voxels, slices.frusta[i].size, skirt);
        fields.push(field(scene, i as u32, voxels));
    }
    Ok(fields)
}

/// Leaves the pixels to keep in the bands' masks, layer after layer.
fn remove_hidden(
    hidden: &mut Hidden,
    bands: &mut [Band],
    jobs: &[Job],
    layers: usize,
    stop: &Stop,
) -> Result<(), Stopped> {
    let mut rest: Vec<(usize, usize, Rows)> = Vec::with_capacity(bands.len());
    for band in bands {
        let size = band.height() * jobs[band.frustum].words;
        rest.push((
            band.frustum,
            size,
            Rows { filled: &mut band.masks, hidden: &mut band.hidden, inside: &mut band.inside },
        ));
    }
    for _ in 0..layers {
        stop.check()?;
        let mut current: Vec<Vec<Rows>> = jobs.iter().map(|_| Vec::new()).collect();
        for (frustum, size, rows) in &mut rest {
            let (filled, more) = std::mem::take(&mut rows.filled).split_at_mut(*size);
            let (hidden, room) = std::mem::take(&mut rows.hidden).split_at_mut(*size);
            let (inside, space) = std::mem::take(&mut rows.inside).split_at_mut(4 * *size);
            current[*frustum].push(Rows { filled, hidden, inside });
            *rows = Rows { filled: more, hidden: room, inside: space };
        }
        hidden.step(&mut current);
    }
    Ok(())
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
    Field { frustum, voxels: voxels.into(), objects }
}
