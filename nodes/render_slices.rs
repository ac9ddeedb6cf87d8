//! `render-slices`: the layered voxel field that a view cell sees.

use super::samples_per_side;
use crate::{
    engine::node::{Ctx, List, Node, NodeError},
    ports,
    raster::Geometry,
    scene::Scene,
    view::Cell,
    voxel::{
        Field, Slices,
        frusta::{Lens, axis_name, frame},
        near::near_part,
        overlap::triangle_meets_box,
        slicing::{Fineness, Soup, slice},
    },
};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Captures the visible surfaces as layers of voxels. Layers are placed so that from anywhere in the view cell a
/// point appears at most one pixel from its voxel. Each layer is rendered between its borders from the cell's centre, and voxels
/// that are occluded from the whole cell are left out. Triangles of single-sided materials that show their back to the whole cell are
/// left out too. Geometry nearer than 1.5 times the cell's half extent, or nearer than
/// `max_layers` allows, is kept as geometry. Source: Jeschke and Wimmer, Textured Depth Meshes, 2002, section 4.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Params {
    /// Width and height of the image that the stand-in is made for, pixels, 1 to 16384.
    #[schemars(range(min = 1, max = 16384), extend("x-unit" = "pixels"))]
    pub resolution: u32,
    /// Field of view of these images, degrees, more than 0 and less than 180.
    #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 180.0, "x-unit" = "degrees"))]
    pub fov: f64,
    /// Samples per voxel, 1, 4 or 16: a voxel is filled if any sample is covered; its colour is the mean of the covered samples,
    /// and their share is what `resample` cuts outlines by.
    /// With 4 a silhouette lies a quarter of a pixel outside the true one on average, which balances the covering mesh, which lies
    /// inside its voxels. 1 loses thin parts (ropes, lamp posts), 16 thickens them.
    pub samples: u32,
    /// Whether each quarter of a voxel keeps its own colour, that of its own samples: `resample` with a `texel` of 0.5 then shows detail that is
    /// finer than the voxels. Takes 4 or 16 `samples`, and 16 bytes more a voxel.
    pub quarters: bool,
    /// How far occluded voxels are kept where a visible surface continues behind its occluder, in voxels, 0 to 8. Simplification
    /// moves edges by up to `collapse.factor` voxels: without this skirt, gaps open between a silhouette and the surface behind it.
    #[schemars(range(max = 8), extend("x-unit" = "voxels"))]
    pub skirt: u32,
    /// Most layers, 1 to 65535; what would need more is kept as geometry.
    #[schemars(range(min = 1, max = 65535))]
    pub max_layers: u32,
}

impl Default for Params {
    fn default() -> Self {
        Self { resolution: 1024, fov: 45.0, samples: 4, quarters: false, skirt: 2, max_layers: 1024 }
    }
}

ports! {
    pub struct In {
        /// The scene to capture.
        scene: Arc<Scene>,
        /// The view cell.
        cell: Arc<Cell>,
    }
}

ports! {
    pub struct Out {
        /// Frusta and layers.
        slices: Arc<Slices>,
        /// The visible voxels, one field per frustum, named by the axis along which it looks.
        fields: List<Field>,
        /// Geometry that is too near for layers, unchanged; empty where there is none.
        near: Arc<Scene>,
    }
}

pub struct RenderSlices;

impl Node for RenderSlices {
    const KIND: &'static str = "render-slices";
    const VERSION: u32 = 7;
    type Params = Params;
    type In = In;
    type Out = Out;

    fn memory(params: &Params, sizes: &[u64]) -> u64 {
        // Triangles in world space and snapped are about eight times their stored size; about three visible voxels in each
        // of the pixels, and bits of the filled ones.
        let pixels = u64::from(params.resolution) * u64::from(params.resolution) * 3 / 2;
        (256 << 20) + sizes.first().map_or(0, |s| s * 8) + pixels * 100
    }

    fn doubts(params: &Params) -> Vec<(&'static str, String)> {
        super::doubt_fov(params.fov)
    }

    fn check(params: &Params) -> Result<(), (&'static str, String)> {
        if samples_per_side(params.samples).is_none() {
            return Err(("samples", format!("expected 1, 4 or 16, found {}", params.samples)));
        }
        if params.quarters && params.samples < 4 {
            return Err(("quarters", format!("takes 4 or 16 samples, found {}", params.samples)));
        }
        Ok(())
    }

    fn run(params: &Params, inputs: In, ctx: &Ctx) -> Result<Out, NodeError> {
        let (scene, cell) = (&*inputs.scene, &*inputs.cell);
        let samples = samples_per_side(params.samples).unwrap_or(2);
        let geometry = Geometry::new(scene);
        let soup = Soup::new(&geometry, cell);
        if soup.corners.is_empty() {
            return Err(NodeError::Failed(
                "no triangles are selected: the stand-in would be empty (materials whose alpha never reaches the cutoff \
                 count as nothing)"
                    .into(),
            ));
        }
        refuse_what_meets_the_cell(scene, &geometry, &soup, cell)?;
        let lens = Lens {
            resolution: params.resolution,
            fov: params.fov.to_radians(),
            max_layers: params.max_layers as usize,
            max_side: crate::raster::MAX_SIDE / samples,
        };
        let slices = frame(cell, &soup.corners, &lens, ctx.stop).map_err(|e| NodeError::from_error(&e))?;
        let backend = super::backend(ctx);
        let fineness = Fineness { samples, skirt: params.skirt, quarters: params.quarters };
        let fields = slice(backend, scene, &geometry, &soup, &slices, fineness, ctx.stop)?;
        if fields.iter().all(|f| f.voxels.is_empty()) {
            return Err(NodeError::Failed(
                "nothing can be seen from the cell: no sample of any layer is covered, the stand-in would be empty"
                    .into(),
            ));
        }
        let near = near_part(scene, &slices, &soup.corners, &soup.numbers);
        if !near.objects.is_empty() {
            (ctx.warn)(format!(
                "{} triangles of {} objects stay geometry: they lie nearer than {:.3} m to the cell's centre, too near \
                 for layers",
                near.triangle_count(),
                near.objects.len(),
                slices.borders[0],
            ));
        }
        let names = slices.frusta.iter().map(|f| axis_name(f).to_owned());
        let fields = List(names.zip(fields.into_iter().map(Arc::new)).collect());
        Ok(Out { slices: Arc::new(slices), fields, near: Arc::new(near) })
    }
}

/// How many names an error lists.
const NAMED: usize = 8;

fn refuse_what_meets_the_cell(scene: &Scene, geometry: &Geometry, soup: &Soup, cell: &Cell) -> Result<(), NodeError> {
    let meets = |(t, number): (&[glam::DVec3; 3], &u32)| {
        triangle_meets_box(t, cell.half).then(|| geometry.object_of(*number) as usize)
    };
    let mut objects: Vec<usize> = soup.corners.par_iter().zip(&soup.numbers).filter_map(meets).collect();
    objects.sort_unstable();
    objects.dedup();
    if objects.is_empty() {
        return Ok(());
    }
    let names: Vec<_> = objects.iter().take(NAMED).map(|o| format!("`{}`", scene.objects[*o].name)).collect();
    let more = if objects.len() > NAMED { format!(" and {} more", objects.len() - NAMED) } else { String::new() };
    Err(NodeError::Failed(format!(
        "the selection intersects the view cell (centre {}, size {} m): {}{more}; move or shrink the cell, or select \
         without these objects",
        cell.centre,
        cell.half * 2.0,
        names.join(", "),
    )))
}

#[cfg(test)]
mod tests;
