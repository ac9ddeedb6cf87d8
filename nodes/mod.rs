//! The node kinds: thin adapters between the engine and the algorithms, one file or folder each.

pub mod collapse;
mod evaluate;
mod field_scene;
mod load_scene;
mod make_scene;
mod pack_atlas;
pub mod render_slices;
mod resample;
mod select_objects;
mod split_objects;
pub mod values;
pub mod view_cell;
pub mod voxel_mesh;
mod write_glb;

use crate::{
    engine::node::{Ctx, Registry},
    raster::{Backend, Cpu},
};
use std::sync::Arc;

/// Who renders: the device that the program was given, or the CPU.
fn backend<'a>(ctx: &Ctx<'a>) -> &'a dyn Backend {
    ctx.device.and_then(|d| d.downcast_ref::<Arc<dyn Backend>>()).map_or(&Cpu, |b| &**b)
}

/// Every kind that the program knows.
pub fn registry() -> Registry {
    let mut r = Registry::default();
    r.add::<load_scene::LoadScene>();
    r.add::<make_scene::MakeScene>();
    r.add::<select_objects::SelectObjects>();
    r.add::<split_objects::SplitObjects>();
    r.add::<write_glb::WriteGlb>();
    r.add::<collapse::Collapse>();
    r.add::<voxel_mesh::VoxelMeshNode>();
    r.add::<field_scene::FieldScene>();
    r.add::<pack_atlas::PackAtlas>();
    r.add::<resample::Resample>();
    r.add::<view_cell::ViewCell>();
    r.add::<render_slices::RenderSlices>();
    r.add::<evaluate::Evaluate>();
    r
}
